"""The two clamps of a loop, from stem atoms alone.

The ideal strand is laid on the last nucleotides of *each strand of the stem by itself*: a whole
ideal duplex does not fit real stems and moves the ends by ångströms. Its helix line, taken half a
nucleotide beyond each closing nucleotide, gives point and frame of the rod's ends. The rod then
runs from the P of the first loop nucleotide to the P of the 3' closing one: n steps for n
nucleotides. That P and the O3' of the 5' closing nucleotide belong to the stem.

What the clamp assumes is the elastic line of biopolymer chain elasticity (Pakleza & Cognet, Nucleic
Acids Res. 31 (2003) 1075), clamped to the ideal stem.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from loopelastica.errors import StructureError
from loopelastica.molecule.hairpins import Hairpin
from loopelastica.molecule.nucleotides import BACKBONE, Nucleotides, atom_positions
from loopelastica.molecule.strands import Strand, ideal_strand, line_frame, strand_atoms

MIN_ATOMS = 4
"""Fewest of the six backbone atoms of a closing nucleotide that still place a strand."""


@dataclass(frozen=True, slots=True, eq=False)
class StemEnds:
    """Where a loop leaves its stem and comes back to it, in the coordinates of the file.

    Attributes
    ----------
    start_origin_A, end_origin_A : (3,) array
        Ends of the line, Å.
    start_frame, end_frame : (3, 3) array
        Columns d1 (towards the helix axis), d2, d3 (tangent 5' to 3').
    length_A : float
        Length of the line between them.
    fit_rms_A : (2,) array
        Root mean square misfit of the ideal strand, 5' and 3' strand.
    stem_rms_A : (2,) array or None
        The same for the last two nucleotides; None where the stem has one pair only. Above 1.3 Å
        the stem is no A or B helix and the clamp means nothing.
    """

    start_origin_A: NDArray[np.float64]
    start_frame: NDArray[np.float64]
    end_origin_A: NDArray[np.float64]
    end_frame: NDArray[np.float64]
    length_A: float
    fit_rms_A: NDArray[np.float64]
    stem_rms_A: NDArray[np.float64] | None

    def __post_init__(self) -> None:
        for name in self.__slots__:
            value = getattr(self, name)
            if isinstance(value, np.ndarray):
                value.setflags(write=False)


@dataclass(frozen=True, slots=True, eq=False)
class _Placed:
    """An ideal strand moved rigidly onto atoms: x ↦ rotation x + shift."""

    rotation: NDArray[np.float64]
    shift: NDArray[np.float64]
    rms_A: float


def stem_ends(
    nucleotides: Nucleotides, hairpin: Hairpin, positions: NDArray[np.float64]
) -> StemEnds:
    """Clamp a loop to its stem; no atom of the loop is looked at.

    Parameters
    ----------
    nucleotides : Nucleotides
        The table the hairpin was found in.
    hairpin : Hairpin
        Which loop.
    positions : (n_atoms, 3) array
        All atoms of one model, Å.

    Raises
    ------
    StructureError
        If a closing nucleotide has fewer than ``MIN_ATOMS`` backbone atoms, or atoms without a
        place; the message names the residue.

    Examples
    --------
    >>> from loopelastica._data import data_path
    >>> from loopelastica.molecule.hairpins import find_hairpins
    >>> from loopelastica.molecule.nucleotides import read_structure
    >>> structure = read_structure(data_path("hairpins/2koc.pdb"))
    >>> ends = stem_ends(
    ...     structure.nucleotides, find_hairpins(structure)[0], structure.positions(0)
    ... )
    >>> chord_A = np.linalg.norm(ends.end_origin_A - ends.start_origin_A)
    >>> print(f"{chord_A:.1f} of {ends.length_A:.1f} Å")
    14.5 of 24.0 Å
    """
    strand = ideal_strand(hairpin.is_dna)
    sides = ((hairpin.stem_5, -1), (hairpin.stem_3, 1))
    placed = [
        _place(strand, nucleotides, rows[: strand.fitted_nucleotides], step, positions)
        for rows, step in sides
    ]
    two = [
        _place(strand, nucleotides, rows[:2], step, positions).rms_A
        for rows, step in sides
        if len(rows) > 1
    ]
    start_origin, start_frame = _line_end(strand, placed[0], 0.5)
    end_origin, end_frame = _line_end(strand, placed[1], -0.5)
    return StemEnds(
        start_origin_A=start_origin,
        start_frame=start_frame,
        end_origin_A=end_origin,
        end_frame=end_frame,
        length_A=len(hairpin) * strand.length_per_nucleotide_A,
        fit_rms_A=np.array([fit.rms_A for fit in placed]),
        stem_rms_A=np.array(two) if two else None,
    )


def _line_end(
    strand: Strand, placed: _Placed, phase: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    point, frame = line_frame(strand, phase)
    return placed.rotation @ point + placed.shift, placed.rotation @ frame


def _place(
    strand: Strand,
    nucleotides: Nucleotides,
    rows: NDArray[np.int64],
    step: int,
    positions: NDArray[np.float64],
) -> _Placed:
    """Lay the ideal strand on the nucleotides `rows`, the closing one at phase 0.

    `step` is −1 where the rows go against the chain (5' strand), 1 where they go along it.
    """
    _check_stem(nucleotides, rows, positions)
    real = atom_positions(nucleotides, positions, BACKBONE)[rows].reshape(-1, 3)
    ideal = np.concatenate([strand_atoms(strand, step * k) for k in range(len(rows))])
    present = np.isfinite(real).all(axis=1)
    return _superpose(ideal[present], real[present])


def _superpose(ideal: NDArray[np.float64], real: NDArray[np.float64]) -> _Placed:
    """Rigid motion of least squares (Kabsch), without reflection."""
    ideal_center, real_center = ideal.mean(axis=0), real.mean(axis=0)
    u, _, vt = np.linalg.svd((real - real_center).T @ (ideal - ideal_center))
    handed = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    rotation = u @ handed @ vt
    shift = real_center - rotation @ ideal_center
    misfit = real - ideal @ rotation.T - shift
    return _Placed(rotation, shift, float(np.sqrt((misfit**2).sum(axis=1).mean())))


def _check_stem(
    nucleotides: Nucleotides, rows: NDArray[np.int64], positions: NDArray[np.float64]
) -> None:
    """Refuse a stem strand whose atoms cannot place it, naming residue, fact and consequence."""
    index = nucleotides.columns(BACKBONE)[rows]
    for row, atoms in zip(rows, index, strict=True):
        label = nucleotides.label(int(row))
        missing = [name for name, atom in zip(BACKBONE, atoms, strict=True) if atom < 0]
        values = positions[atoms[atoms >= 0]]
        # Outwards of the closing pair a missing P (5' end of the chain) only leaves fewer atoms.
        if row == rows[0] and len(BACKBONE) - len(missing) < MIN_ATOMS:
            names = " and ".join([", ".join(missing[:-1]), missing[-1]])
            raise StructureError(f"{label}: no {names} atoms; its stem frame cannot be placed")
        if not np.isfinite(values).all():
            raise StructureError(
                f"{label}: its backbone coordinates are no numbers; its stem frame cannot be placed"
            )
        if (values == 0.0).all(axis=1).sum() > 1:
            raise StructureError(
                f"{label}: its backbone atoms lie at the origin; its stem frame cannot be placed"
            )
