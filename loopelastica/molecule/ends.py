"""The two clamps of a loop, from stem atoms alone.

The ideal strand is laid on the last nucleotides of *each strand of the stem by itself*: a whole
ideal duplex does not fit real stems and moves the ends by ångströms. Its helix line, taken half a
nucleotide beyond each closing nucleotide, gives point and frame of the rod's ends. The rod then
runs from the P of the first loop nucleotide to the P of the 3' closing one: n steps for n
nucleotides. That P and the O3' of the 5' closing nucleotide belong to the stem.

Where loop nucleotides go on stacking on the stem, the rod begins (ends) that many nucleotides
further along the ideal strand; the 3' strand may taper towards its axis (`clamp_rule`).

What the clamp assumes is the elastic line of biopolymer chain elasticity (Pakleza & Cognet, Nucleic
Acids Res. 31 (2003) 1075), clamped to the ideal stem.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from loopelastica.errors import StructureError
from loopelastica.molecule.clamp_rule import STEM_RMS_MAX_A, StemClamp, plain_clamp
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
    clamp : StemClamp
        Extensions, taper and length per nucleotide in force.
    continued_5_A, continued_3_A : (stem_extend_5, 3), (stem_extend_3, 3) array
        Loop nucleotides that continue the stem's strands, in chain order.
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
    clamp: StemClamp
    continued_5_A: NDArray[np.float64]
    continued_3_A: NDArray[np.float64]
    fit_rms_A: NDArray[np.float64]
    stem_rms_A: NDArray[np.float64] | None

    def __post_init__(self) -> None:
        for name in self.__slots__:
            value = getattr(self, name)
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    @property
    def distance_A(self) -> float:
        """Distance of the two ends."""
        return math.dist(self.start_origin_A, self.end_origin_A)

    @property
    def n_free(self) -> int:
        """Number of loop nucleotides on the rod."""
        return round(self.length_A / self.clamp.length_per_nucleotide_A)

    @property
    def rms_A(self) -> float:
        """Misfit of the worse strand, Å, over its last two nucleotides, or the one there is."""
        return float(np.max(self.fit_rms_A if self.stem_rms_A is None else self.stem_rms_A))

    @property
    def regular(self) -> bool:
        """Whether both strands of the stem follow an A or B helix (`STEM_RMS_MAX_A`)."""
        return self.rms_A <= STEM_RMS_MAX_A

    @property
    def misfit(self) -> str:
        """What is wrong with an irregular stem."""
        return (
            f"the ideal strand misses the last nucleotides of the stem by {self.rms_A:.2f} Å (limit"
            f" {STEM_RMS_MAX_A} Å), so the stem is no A or B helix"
        )

    def check_regular(self, name: str) -> None:
        """Raise a `StructureError` that names the loop if its stem is no A or B helix."""
        if not self.regular:
            raise StructureError(
                f"{name}: {self.misfit}; the loop is not folded (`irregular` folds it)"
            )

    def check_reach(self, name: str) -> StemEnds:
        """These ends; a `StructureError` that names the loop if the rod cannot span them."""
        if self.distance_A >= self.length_A:
            raise StructureError(
                f"{name}: the stem ends are {self.distance_A:.1f} Å apart but the loop's line is"
                f" only {self.length_A:.1f} Å long; no rod fits and the loop is not folded"
            )
        return self


@dataclass(frozen=True, slots=True, eq=False)
class _Placed:
    """An ideal strand moved rigidly onto atoms: x ↦ rotation x + shift."""

    rotation: NDArray[np.float64]
    shift: NDArray[np.float64]
    rms_A: float

    def line_end(
        self, strand: Strand, phase: float, taper: float = 0.0
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Point and frame of its line where it lies now; see :func:`line_frame`."""
        point, frame = line_frame(strand, phase, taper)
        return self.rotation @ point + self.shift, self.rotation @ frame


def stem_ends(
    nucleotides: Nucleotides,
    hairpin: Hairpin,
    positions: NDArray[np.float64],
    clamp: StemClamp | None = None,
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
    clamp : StemClamp, optional
        Extensions, taper and length; default the plain clamp at the closing pair.

    Raises
    ------
    StructureError
        If a closing nucleotide has fewer than ``MIN_ATOMS`` backbone atoms, or atoms without a
        place; the message names the residue. If `clamp` leaves no nucleotide to the rod or its
        taper brings the 3' strand to its axis.

    Examples
    --------
    >>> from loopelastica._files import data_path
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
    return placed_stem(nucleotides, hairpin, positions).ends(clamp or plain_clamp(hairpin.is_dna))


@dataclass(frozen=True, slots=True, eq=False)
class PlacedStem:
    """Ideal strands laid on the two strands of a stem, from which any clamp follows."""

    hairpin: Hairpin
    strands: tuple[_Placed, _Placed]
    stem_rms_A: NDArray[np.float64] | None

    def ends(self, clamp: StemClamp) -> StemEnds:
        """The ends of the rod for one clamp; raises as :func:`stem_ends` does."""
        strand, (five, three) = ideal_strand(self.hairpin.is_dna), self.strands
        n_free = len(self.hairpin) - clamp.stem_extend_5 - clamp.stem_extend_3
        name = "–".join(self.hairpin.closing_pair)
        if n_free < 1:
            raise StructureError(
                f"{name}: the loop has {len(self.hairpin)} nucleotides and extensions of"
                f" {clamp.stem_extend_5} and {clamp.stem_extend_3} leave none to the rod; the loop"
                " is not folded"
            )
        try:
            start = five.line_end(strand, clamp.stem_extend_5 + 0.5)
            end = three.line_end(strand, -clamp.stem_extend_3 - 0.5, clamp.taper)
            continued_5 = [five.line_end(strand, k + 1)[0] for k in range(clamp.stem_extend_5)]
            continued_3 = [
                three.line_end(strand, k - clamp.stem_extend_3, clamp.taper)[0]
                for k in range(clamp.stem_extend_3)
            ]
        except ValueError as error:
            raise StructureError(f"{name}: {error}; the loop is not folded") from None
        return StemEnds(
            start_origin_A=start[0],
            start_frame=start[1],
            end_origin_A=end[0],
            end_frame=end[1],
            length_A=n_free * clamp.length_per_nucleotide_A,
            clamp=clamp,
            continued_5_A=np.array(continued_5).reshape(-1, 3),
            continued_3_A=np.array(continued_3).reshape(-1, 3),
            fit_rms_A=np.array([fit.rms_A for fit in self.strands]),
            stem_rms_A=self.stem_rms_A,
        )

    def feasible(self, clamp: StemClamp) -> StemEnds:
        """The ends for `clamp` with as much extension taken off (3' first) as the rod needs.

        Raises
        ------
        StructureError
            If the ends are further apart than the rod is long even at the closing pair.
        """
        while True:
            ends = self.ends(clamp)
            if ends.distance_A < ends.length_A:
                return ends
            if clamp.stem_extend_3:
                clamp = replace(clamp, stem_extend_3=clamp.stem_extend_3 - 1)
            elif clamp.stem_extend_5:
                clamp = replace(clamp, stem_extend_5=clamp.stem_extend_5 - 1)
            else:
                return ends.check_reach("–".join(self.hairpin.closing_pair))


def placed_stem(
    nucleotides: Nucleotides, hairpin: Hairpin, positions: NDArray[np.float64]
) -> PlacedStem:
    """Lay the ideal strand on each strand of the stem; raises as :func:`stem_ends` does."""
    strand = ideal_strand(hairpin.is_dna)
    sides = ((hairpin.stem_5, -1), (hairpin.stem_3, 1))
    five, three = (
        _place(strand, nucleotides, rows[: strand.fitted_nucleotides], step, positions)
        for rows, step in sides
    )
    two = [
        _place(strand, nucleotides, rows[:2], step, positions).rms_A
        for rows, step in sides
        if len(rows) > 1
    ]
    return PlacedStem(hairpin, (five, three), np.array(two) if two else None)


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
