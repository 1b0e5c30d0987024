"""The two ends of any strand, each from the one nucleotide that flanks it.

The ideal strand is laid on that nucleotide, paired or not; the line's end and tangent half a
nucleotide beyond are where they are in chains that are there: on the ideal line for RNA, not quite
for DNA (`MEAN_ENDS`). One nucleotide places the end better than two: the
last but one tells how the helix was, not where the chain turns.

The line is shorter than the chain from three nucleotides on (`line_length`): a smooth line of the
zigzag's length would balloon.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from loopelastica._arrays import Array, Record
from loopelastica.errors import StructureError
from loopelastica.molecule.clamp_rule import StemClamp
from loopelastica.molecule.ends import ClosingPoses, superpose
from loopelastica.molecule.polymer import Gap, Monomer
from loopelastica.molecule.refusals import check_span
from loopelastica.molecule.strands import ideal_strand, line_frame, strand_atoms
from loopelastica.molecule.trace import to_file_coordinates

MEAN_ENDS: Final = {
    # is_dna, 3' side: point (Å) and tangent in the frame of the ideal line at its half nucleotide
    (False, False): ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    (False, True): ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    (True, False): ((-0.60, 0.04, -0.17), (-0.27, 0.05, 0.96)),
    (True, True): ((0.25, 0.50, 0.07), (-0.08, -0.20, 0.98)),
}
"""Where the half point of a chain lies, on splines through the centroids of real strands: for RNA
(1,987 bulges, internal loops, junctions and unpaired runs) on the ideal line itself, for a shift to
the mean, 0.4 Å, made the median error of 700 strands larger; for DNA (328, duplexes for the most
part) beside it."""

LENGTHS: Final = {
    # up to how many nucleotides, length per nucleotide (Å), least multiple of the distance
    False: ((2, 6.0, 1.02), (4, 5.5, 1.05), (math.inf, 5.0, 1.05)),
    True: ((math.inf, 6.3, 1.02),),
}
"""Length of the line of RNA and of DNA (True) by the number of nucleotides it stands for."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class StrandEnds(Record):
    """Where a strand leaves the nucleotide before it and comes to the one after it.

    Attributes
    ----------
    start_origin_A, end_origin_A : (3,) array
        Ends of the line in the coordinates of the file, half a nucleotide beyond the flanking ones.
    start_frame, end_frame : (3, 3) array
        Columns d1 (towards the axis of the ideal helix), d2, d3 (tangent, 5' to 3').
    n : int
        Nucleotides on the line.
    length_A : float
        Its length.
    fit_rms_A : (2,) array
        Misfit of the ideal nucleotide on the flanking ones, Å.
    is_dna : bool
        Whether all that it stands for is DNA.
    """

    start_origin_A: Array
    start_frame: Array
    end_origin_A: Array
    end_frame: Array
    n: int
    length_A: float
    fit_rms_A: Array
    is_dna: bool

    def __repr__(self) -> str:
        return (
            f"<StrandEnds {self.distance_A:.1f} Å apart, line of {self.length_A:.1f} Å for"
            f" {self.n} nucleotides>"
        )

    @property
    def distance_A(self) -> float:
        """Distance of the two ends."""
        return math.dist(self.start_origin_A, self.end_origin_A)

    @property
    def n_free(self) -> int:
        """Nucleotides on the line, by the name that hairpins' ends have for it."""
        return self.n

    @property
    def clamp(self) -> StemClamp:
        """A clamp right beside the flanking nucleotides, as hairpins' ends have it."""
        return StemClamp(0, 0, 0.0, self.length_A / self.n)

    def to_file(self, centerline: Array) -> Array:
        """Line (..., 3) of unit length in the start frame → Å in the coordinates of the file."""
        return to_file_coordinates(centerline, self.start_origin_A, self.start_frame, self.length_A)

    def from_file(self, positions_A: Array) -> Array:
        """Coordinates (..., 3) of the file → Å in the start frame."""
        return np.asarray((positions_A - self.start_origin_A) @ self.start_frame)


def flank_end(monomer: Monomer, after: bool) -> tuple[Array, Array, float]:
    """End of a strand's line beside the nucleotide that flanks it.

    Parameters
    ----------
    monomer : Monomer
        The flanking nucleotide.
    after : bool
        Whether it comes after the strand (on its 3' side).

    Returns
    -------
    origin_A : (3,) array
        In the coordinates of the file.
    frame : (3, 3) array
        Columns d1 d2 d3, d3 the tangent 5' to 3'.
    fit_rms_A : float
        Misfit of the ideal nucleotide.

    Raises
    ------
    StructureError
        If the nucleotide lacks C4' or has fewer than four backbone atoms.
    """
    rotation, shift, rms_A = _laid_on(monomer)
    point, frame = line_frame(ideal_strand(monomer.is_dna), -0.5 if after else 0.5)
    offset, tangent = (np.array(values) for values in MEAN_ENDS[monomer.is_dna, after])
    d3 = frame @ tangent
    d3 /= np.linalg.norm(d3)
    d1 = frame[:, 0] - (frame[:, 0] @ d3) * d3
    d1 /= np.linalg.norm(d1)
    own = np.stack([d1, np.cross(d3, d1), d3], axis=1)
    return rotation @ (point + frame @ offset) + shift, rotation @ own, rms_A


def flank_poses(before: Monomer, after: Monomer) -> ClosingPoses:
    """Point and frame of the ideal line at the two nucleotides that flank a strand.

    Parameters
    ----------
    before, after : Monomer
        The flanking nucleotides.

    Returns
    -------
    ClosingPoses
        In the coordinates of the file.

    Raises
    ------
    StructureError
        As :func:`flank_end`.
    """
    poses: list[Array] = []
    for monomer in (before, after):
        rotation, shift, _ = _laid_on(monomer)
        point, frame = line_frame(ideal_strand(monomer.is_dna), 0.0)
        poses += [rotation @ point + shift, rotation @ frame]
    return ClosingPoses(*poses)


def _laid_on(monomer: Monomer) -> tuple[Array, Array, float]:
    """Rotation, shift and misfit of the ideal nucleotide on one that flanks a strand."""
    if not monomer.usable:
        raise StructureError(
            f"{monomer.label}: it lacks C4' or has fewer than four backbone atoms; no strand can"
            " end on it"
        )
    strand = ideal_strand(monomer.is_dna)
    real = monomer.backbone_A
    present = np.isfinite(real).all(axis=1)
    return superpose(strand_atoms(strand, 0)[present], real[present])


def line_length(n: int, distance_A: float, is_dna: bool = False) -> float:
    """Length of the line of a strand, Å.

    Parameters
    ----------
    n : int
        Its nucleotides.
    distance_A : float
        Of its two ends.
    is_dna : bool
        Kind of the strand.

    Returns
    -------
    float

    Examples
    --------
    >>> line_length(4, 12.0), line_length(4, 22.0)
    (22.0, 23.1)
    """
    per_nucleotide, factor = next((k, c) for most, k, c in LENGTHS[is_dna] if n <= most)
    return max(per_nucleotide * n, factor * distance_A)


def strand_ends(gap: Gap) -> StrandEnds:
    """Both ends of the line that fills a gap, and its length.

    Parameters
    ----------
    gap : Gap
        What is missing, and between what.

    Returns
    -------
    StrandEnds

    Raises
    ------
    StructureError
        If a flanking nucleotide cannot place its end, or the gap is too wide for its nucleotides;
        the sentence has both distances.
    """
    start, start_frame, rms_5 = flank_end(gap.before, after=False)
    end, end_frame, rms_3 = flank_end(gap.after, after=True)
    n = len(gap)
    distance_A = math.dist(start, end)
    too_far = check_span(gap, distance_A)
    if too_far is not None:
        raise StructureError(too_far)
    # a strand of both kinds is as short as one of RNA
    is_dna = all(monomer.is_dna for monomer in gap.monomers)
    length_A = line_length(n, distance_A, is_dna)
    fit_rms_A = np.array([rms_5, rms_3])
    return StrandEnds(start, start_frame, end, end_frame, n, length_A, fit_rms_A, is_dna)
