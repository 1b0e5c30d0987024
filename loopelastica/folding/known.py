"""What is known of a loop before it is looked at: shapes of other loops, deformed onto its stem.

    library → shapes of its length → elastic chains on its stem → weights → answers

The first answer is a mean: over loops of the same sequence where there are any, else over those of
its motif, else over all. How far the weighted shapes lie from an answer, whatever that is, tells
the error to expect of it.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record
from loopelastica._files import data_path
from loopelastica.folding.choice import (
    Weighted,
    atoms_per_point,
    covering,
    distances_A,
    sequence_distance,
    smooth_lines,
    weigh,
)
from loopelastica.folding.library import Library, ShapeTable
from loopelastica.folding.library_file import load_library
from loopelastica.folding.lines import ChainLine, deform
from loopelastica.folding.motifs import Motif, motif_of
from loopelastica.folding.nearest import nearest
from loopelastica.molecule.ends import ClosingPoses
from loopelastica.molecule.hairpins import Hairpin
from loopelastica.molecule.shapes import LoopShape, shape_between

MOST_SHAPES: Final = 600
"""Shapes that are deformed; of more, those of least estimated energy."""
FEWEST_OF_MOTIF: Final = 2
"""Sequences that a motif's own mean needs."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Known(Record):
    """Shapes of a library on the stem of a loop.

    Attributes
    ----------
    hairpin : Hairpin
    poses : ClosingPoses
        Of its closing pair.
    table : ShapeTable
        The k shapes.
    weighted : Weighted
        Their loop nucleotides on the stem, in the frame of the 5' closing nucleotide, and weights.
    same : (k,) array of bool
        Which have the same loop sequence.
    motif : Motif or None
        What the sequence says.
    """

    hairpin: Hairpin
    poses: ClosingPoses
    table: ShapeTable
    weighted: Weighted
    same: NDArray[np.bool_]
    motif: Motif | None

    def __repr__(self) -> str:
        return f"<Known: {len(self.table)} shapes for {self.hairpin.name}>"

    def first(self) -> tuple[ChainLine, str, str]:
        """The first answer, its kind for the table of errors, and what it is called."""
        among, kind, name = self._basis()
        trace_A = self.weighted.among(among).mean_A
        n = int(among.sum())
        called = f"{name} (mean of {n} loops)" if n > 1 else f"{name} ({self._source(among)})"
        shape = shape_between(
            trace_A, _at_origin(self.poses), self.hairpin.sequence, self.hairpin.is_dna, called
        )
        return self._line(shape), kind, called

    def others(self, lines_A: Sequence[Array], count: int) -> list[tuple[ChainLine, str]]:
        """Single shapes that cover what answers (n, 3) in the file leave open; what they are."""
        own = [self._local(line_A) for line_A in lines_A]
        covered = [distances_A(self.weighted.nodes_A, trace_A) for trace_A in own]
        nearest_A = np.min(covered, axis=0) if covered else None
        rows = covering(self.weighted, nearest_A, count)
        shapes = [self.table.shape(row) for row in rows]
        return [(self._line(s), f"library {s.source} ({s.sequence[1:-1]})") for s in shapes]

    def spread_A(self, trace_A: Array) -> float:
        """Expected distance of the loop from an answer (n, 3) in the file's coordinates, Å."""
        return self.weighted.distance_A(self._local(trace_A))

    def _basis(self) -> tuple[NDArray[np.bool_], str, str]:
        usable = self.weighted.weights > 0.0
        if (usable & self.same).any():
            return usable & self.same, "same sequence", "same sequence"
        if self.motif is not None:
            codes = self.table.letters
            of_motif = usable & self.motif.matches(codes)
            if len(np.unique(codes[of_motif, 1:-1], axis=0)) >= FEWEST_OF_MOTIF:
                return of_motif, f"motif {self.motif.name}", f"motif {self.motif.name}"
        return usable, "mean", f"{len(self.hairpin)} nucleotides"

    def _source(self, among: NDArray[np.bool_]) -> str:
        return str(self.table.sources[np.flatnonzero(among)[0]])

    def _local(self, trace_A: Array) -> Array:
        return np.asarray((trace_A - self.poses.start_origin_A) @ self.poses.start_frame)

    def _line(self, shape: LoopShape) -> ChainLine:
        (line,) = deform([shape], self.poses, self.hairpin.is_dna)
        assert line is not None
        return line
