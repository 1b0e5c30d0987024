"""The shape of a loop as a chain of steps: what an elastic chain has at rest.

Nodes 0 … n + 1 are the centroids of the backbone atoms P O5' C5' C4' C3' O3'; those of the closing
nucleotides, 0 and n + 1, and their frames are of the ideal strands laid on the stem, as in all that
is clamped to a stem. Everything is in the frame of node 0, so that a shape has no place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from loopelastica._arrays import Array, Record, read_only
from loopelastica.molecule.ends import ClosingPoses, FittedStem, fit_stem
from loopelastica.molecule.hairpins import Hairpin
from loopelastica.molecule.nucleotides import Nucleotides
from loopelastica.molecule.trace import native_backbone


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class LoopShape(Record):
    """A loop of n nucleotides as a chain of n + 1 steps.

    Attributes
    ----------
    sequence : str
        Bases from the 5' to the 3' closing nucleotide, T as U.
    is_dna : bool
        Whether its stem is DNA.
    steps_A : (n + 1, 3) array
        From each node to the next, in the frame of the first, Å.
    end_frame : (3, 3) array
        Frame of the last node in that of the first.
    source : str
        Where it is from, such as "1zih A.4-A.9".
    """

    sequence: str
    is_dna: bool
    steps_A: Array
    end_frame: Array
    source: str

    def __len__(self) -> int:
        return len(self.steps_A) - 1

    @property
    def nodes_A(self) -> Array:
        """The nodes (n + 2, 3) in the frame of the first, Å."""
        return np.concatenate([np.zeros((1, 3)), np.cumsum(self.steps_A, axis=0)])

    def __repr__(self) -> str:
        return f"<LoopShape {self.sequence} of {self.source}>"


def loop_shape(
    nucleotides: Nucleotides, hairpin: Hairpin, positions: Array, source: str = ""
) -> tuple[LoopShape, FittedStem] | None:
    """The shape of a loop in a structure.

    Parameters
    ----------
    nucleotides : Nucleotides
        The table the hairpin was found in.
    hairpin : Hairpin
        Which loop.
    positions : (n_atoms, 3) array
        All atoms of one model, Å.
    source : str
        Kept with it.

    Returns
    -------
    (LoopShape, FittedStem) or None
        And the stem it is on; None where a backbone atom of the loop is missing.

    Raises
    ------
    StructureError
        If atoms of the stem are missing or have no place.
    """
    backbone_A = native_backbone(nucleotides, hairpin, positions)
    if backbone_A is None:
        return None
    stem = fit_stem(nucleotides, hairpin, positions)
    sequence = hairpin.sequence.replace("T", "U")
    return shape_between(backbone_A[1:-1], stem.closing(), sequence, hairpin.is_dna, source), stem


def shape_between(
    centroids_A: Array, poses: ClosingPoses, sequence: str, is_dna: bool, source: str = ""
) -> LoopShape:
    """The shape of loop nucleotides (n, 3) between two closing ones, all in one frame, Å."""
    nodes = np.concatenate([[poses.start_origin_A], centroids_A, [poses.end_origin_A]])
    steps = np.diff(nodes, axis=0) @ poses.start_frame
    return LoopShape(sequence, is_dna, read_only(steps), read_only(poses.rotation), source)
