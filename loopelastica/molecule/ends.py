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

from loopelastica._arrays import Array, Record
from loopelastica.errors import StructureError
from loopelastica.molecule.clamp_rule import STEM_RMS_MAX_A, StemClamp, plain_clamp
from loopelastica.molecule.hairpins import Hairpin
from loopelastica.molecule.nucleotides import BACKBONE, Nucleotides, atom_positions
from loopelastica.molecule.strands import Strand, ideal_strand, line_frame, strand_atoms
from loopelastica.molecule.trace import to_file_coordinates

MIN_ATOMS = 4
"""Fewest of the six backbone atoms of a closing nucleotide that still place a strand."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class StemEnds(Record):
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

    start_origin_A: Array
    start_frame: Array
    end_origin_A: Array
    end_frame: Array
    length_A: float
    clamp: StemClamp
    continued_5_A: Array
    continued_3_A: Array
    fit_rms_A: Array
    stem_rms_A: Array | None

    def __repr__(self) -> str:
        return (
            f"<StemEnds {self.distance_A:.1f} Å apart, line of {self.length_A:.1f} Å on"
            f" {self.n_free} nucleotides, stem misfit {self.rms_A:.2f} Å>"
        )

    def to_file(self, centerline: Array) -> Array:
        """Line (n, 3) of unit length in the start frame → Å in the coordinates of the file."""
        return to_file_coordinates(centerline, self.start_origin_A, self.start_frame, self.length_A)

    def trace(self, centerline: Array) -> Array:
        """The same, with the nucleotides that continue the stem before and after."""
        return np.concatenate([self.continued_5_A, self.to_file(centerline), self.continued_3_A])

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


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ClosingPoses(Record):
    """Points and frames of the two closing nucleotides on the ideal strands of their stem.

    Attributes
    ----------
    start_origin_A, end_origin_A : (3,) array
        Points of the line, 5' and 3', Å.
    start_frame, end_frame : (3, 3) array
        Columns d1 (towards the helix axis), d2, d3 (tangent 5' to 3').
    """

    start_origin_A: Array
    start_frame: Array
    end_origin_A: Array
    end_frame: Array

    @property
    def position_A(self) -> Array:
        """The end in the frame of the start (3,), Å."""
        return self.start_frame.T @ (self.end_origin_A - self.start_origin_A)

    @property
    def rotation(self) -> Array:
        """The end frame in the frame of the start (3, 3)."""
        return self.start_frame.T @ self.end_frame

    @property
    def local(self) -> ClosingPoses:
        """The same in the frame of the start."""
        return ClosingPoses(np.zeros(3), np.eye(3), self.position_A, self.rotation)

    def to_file(self, points_A: Array) -> Array:
        """Points (..., 3) in the frame of the start, Å → coordinates of the file."""
        return np.asarray(self.start_origin_A + np.asarray(points_A) @ self.start_frame.T)

    def __repr__(self) -> str:
        return f"<ClosingPoses {math.dist(self.start_origin_A, self.end_origin_A):.1f} Å apart>"


def stem_ends(
    nucleotides: Nucleotides, hairpin: Hairpin, positions: Array, clamp: StemClamp | None = None
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

    Returns
    -------
    StemEnds

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
    return fit_stem(nucleotides, hairpin, positions).ends(clamp or plain_clamp(hairpin.is_dna))


@dataclass(frozen=True, slots=True, eq=False)
class FittedStem(Record):
    """Ideal strands laid on the 5' and the 3' strand of a stem, from which any clamp follows.

    Attributes
    ----------
    hairpin : Hairpin
        Whose stem it is.
    file_from_strand : (2, 3, 3) array
        Rotations of the ideal strand onto the atoms.
    shift_A : (2, 3) array
        Shifts that follow them.
    fit_rms_A, stem_rms_A : (2,) array
        As for :class:`StemEnds`.
    """

    hairpin: Hairpin
    file_from_strand: Array
    shift_A: Array
    fit_rms_A: Array
    stem_rms_A: Array | None

    def ends(self, clamp: StemClamp) -> StemEnds:
        """The ends of the rod for one clamp; raises as :func:`stem_ends` does."""
        extend_5, extend_3 = clamp.stem_extend_5, clamp.stem_extend_3
        n_free = len(self.hairpin) - extend_5 - extend_3
        if n_free < 1:
            raise StructureError(
                f"{self.hairpin.label}: the loop has {len(self.hairpin)} nucleotides and extensions"
                f" of {extend_5} and {extend_3} leave none to the rod; the loop is not folded"
            )
        try:
            start = self._line_frame(0, extend_5 + 0.5)
            end = self._line_frame(1, -extend_3 - 0.5, clamp.taper)
            continued_5 = [self._line_frame(0, k + 1)[0] for k in range(extend_5)]
            continued_3 = [
                self._line_frame(1, k - extend_3, clamp.taper)[0] for k in range(extend_3)
            ]
        except ValueError as error:
            raise StructureError(f"{self.hairpin.label}: {error}; the loop is not folded") from None
        return StemEnds(
            start_origin_A=start[0],
            start_frame=start[1],
            end_origin_A=end[0],
            end_frame=end[1],
            length_A=n_free * clamp.length_per_nucleotide_A,
            clamp=clamp,
            continued_5_A=np.array(continued_5).reshape(-1, 3),
            continued_3_A=np.array(continued_3).reshape(-1, 3),
            fit_rms_A=self.fit_rms_A,
            stem_rms_A=self.stem_rms_A,
        )

    def closing(self) -> ClosingPoses:
        """Where the ideal strands have the closing nucleotides themselves."""
        start, end = self._line_frame(0, 0.0), self._line_frame(1, 0.0)
        return ClosingPoses(start[0], start[1], end[0], end[1])

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
                return ends.check_reach(self.hairpin.label)

    def _line_frame(self, side: int, phase: float, taper: float = 0.0) -> tuple[Array, Array]:
        """Point and frame of the 5' (0) or 3' (1) strand's line; see :func:`line_frame`."""
        point, frame = line_frame(ideal_strand(self.hairpin.is_dna), phase, taper)
        rotation = self.file_from_strand[side]
        return rotation @ point + self.shift_A[side], rotation @ frame


def fit_stem(nucleotides: Nucleotides, hairpin: Hairpin, positions: Array) -> FittedStem:
    """Lay the ideal strand on each strand of the stem.

    Parameters
    ----------
    nucleotides, hairpin, positions
        As for :func:`stem_ends`.

    Returns
    -------
    FittedStem

    Raises
    ------
    StructureError
        If atoms of the stem are missing or have no place.
    """
    strand = ideal_strand(hairpin.is_dna)
    sides = ((hairpin.stem_5, -1), (hairpin.stem_3, 1))
    fits = [
        _fit(strand, nucleotides, rows[: strand.fitted_nucleotides], step, positions)
        for rows, step in sides
    ]
    two = [
        _fit(strand, nucleotides, rows[:2], step, positions)[2]
        for rows, step in sides
        if len(rows) > 1
    ]
    rotations, shifts, rms_A = (np.array(values) for values in zip(*fits, strict=True))
    return FittedStem(hairpin, rotations, shifts, rms_A, np.array(two) if two else None)


def _fit(
    strand: Strand, nucleotides: Nucleotides, rows: NDArray[np.int64], step: int, positions: Array
) -> tuple[Array, Array, float]:
    """Lay the ideal strand on the nucleotides `rows`, the closing one at phase 0.

    `step` is −1 where the rows go against the chain (5' strand), 1 where they go along it.
    """
    _check_stem(nucleotides, rows, positions)
    real = atom_positions(nucleotides, positions, BACKBONE)[rows].reshape(-1, 3)
    ideal = np.concatenate([strand_atoms(strand, step * k) for k in range(len(rows))])
    present = np.isfinite(real).all(axis=1)
    return superpose(ideal[present], real[present])


def superpose(ideal: Array, real: Array) -> tuple[Array, Array, float]:
    """Rotation, shift and misfit of the rigid motion of least squares (Kabsch), no reflection."""
    ideal_center, real_center = ideal.mean(axis=0), real.mean(axis=0)
    u, _, vt = np.linalg.svd((real - real_center).T @ (ideal - ideal_center))
    handed = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    rotation = u @ handed @ vt
    shift = real_center - rotation @ ideal_center
    misfit = real - ideal @ rotation.T - shift
    return rotation, shift, float(np.sqrt((misfit**2).sum(axis=1).mean()))


def _check_stem(nucleotides: Nucleotides, rows: NDArray[np.int64], positions: Array) -> None:
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
