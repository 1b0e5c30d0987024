"""The error to expect of a filled strand, from what is known of it blind."""

from __future__ import annotations

from loopelastica._arrays import Array, read_only
from loopelastica.molecule.strand_ends import StrandEnds
from loopelastica.molecule.polymer import Gap


def expected_rmsd(gap: Gap, ends: StrandEnds, crowding: float) -> Array:
    """10, 50 and 90 % of the error of a strand's backbone centroids, Å."""
    return read_only([0.5 * len(gap) ** 0.7, 0.9 * len(gap) ** 0.7, 2.0 * len(gap) ** 0.7])
