"""What is known of a loop before it is looked at: shapes of other loops, deformed onto its stem.

    library → shapes of its length → elastic chains on its stem → weights → answers

The first answer is a mean: over loops of the same sequence where there are any, else over those of
its motif, else over all. How far the weighted shapes lie from an answer, whatever that is, tells
the error to expect of it.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record
from loopelastica._files import data_path
from loopelastica.folding.choice import (
    Weighted,
    atoms_per_point,
    covering,
    sequence_distance,
    smooth_lines,
    weigh,
)
from loopelastica.folding.gathering import library_of_folder
from loopelastica.folding.library import Library
from loopelastica.folding.library_file import load_library
from loopelastica.folding.lines import ChainLine, chain_lines
from loopelastica.folding.motifs import Motif, motif_of, typical_spread_A
from loopelastica.folding.nearest import nearest
from loopelastica.folding.shape_table import ShapeTable, copies_of, letters_of, rms_A
from loopelastica.folding.surroundings import SURROUNDED
from loopelastica.molecule.ends import ClosingPoses
from loopelastica.molecule.shapes import LoopShape, shape_between
from loopelastica.rod.chain import deform_batch

MOST_SHAPES: Final = 600
"""Shapes that are deformed; of more, those of least estimated energy."""


DOUBT: Final = 3.0
"""Sequences of unknown shape that are added to those of a library, for the error to expect."""
OWN_A: Final = 0.1
"""A shape of the same sequence that is as near as this to the file's loop is this loop."""
FIRST: Final = 5
"""Answers that differ in what they assume come first, so many."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Answer(Record):
    """One answer among those for a loop.

    Attributes
    ----------
    kind : str
        In the table of errors.
    trace_A : (n, 3) array
        Its loop nucleotides in the coordinates of the file, Å.
    energy : float
        E L/K0 of its deformation.
    line : ChainLine or None
        None for a rod.
    rod : int
        Which of the rods; −1 for a chain.
    """

    kind: str
    trace_A: Array
    energy: float
    line: ChainLine | None = None
    rod: int = -1

    @property
    def shape(self) -> str:
        """What its line is, such as "motif GNRA, 130 loops"; "" for a rod."""
        if self.line is None:
            return ""
        shape = self.line.shape
        single = self.kind == "library"
        return f"library {shape.source} ({shape.sequence[1:-1]})" if single else shape.source

    def __repr__(self) -> str:
        return f"<Answer {self.kind}>"


class Loop(Protocol):
    """What is asked about a loop: a hairpin, or a strand between two nucleotides like its stem."""

    @property
    def sequence(self) -> str:
        """Bases from closing to closing nucleotide."""

    @property
    def is_dna(self) -> bool:
        """Kind of what it is on."""

    def __len__(self) -> int: ...


class Traced(Protocol):
    """A rod in the coordinates of the file."""

    @property
    def trace(self) -> Array:
        """Its loop nucleotides (n, 3), Å."""

    @property
    def energy(self) -> float:
        """E L/K0."""


def rod_answers(
    straight: Sequence[Traced], bent: Sequence[Traced]
) -> tuple[list[Answer], list[Answer]]:
    """Rods as answers, and those in their surroundings, which go on counting."""
    rods = [
        Answer("further rod" if k else "rod", x.trace, x.energy, rod=k)
        for k, x in enumerate(straight)
    ]
    among = [
        Answer(SURROUNDED, x.trace, x.energy, rod=k) for k, x in enumerate(bent, start=len(rods))
    ]
    return rods, among


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Known(Record):
    """Shapes of a library on the stem of a loop.

    Attributes
    ----------
    loop : Hairpin or another `Loop`
    poses : ClosingPoses
        Of its closing nucleotides.
    table : ShapeTable
        The k shapes.
    weighted : Weighted
        Their loop nucleotides on the stem, in the frame of the 5' closing nucleotide, and weights.
    energies : (k,) array
        E L/K0 of their deformation.
    same : (k,) array of bool
        Which have the same loop sequence, and are of the same kind.
    motif : Motif or None
        What the sequence says.
    sequences : int
        How many loop sequences the table has.
    """

    loop: Loop
    poses: ClosingPoses
    table: ShapeTable
    weighted: Weighted
    energies: Array
    same: NDArray[np.bool_]
    motif: Motif | None
    sequences: int

    def __repr__(self) -> str:
        return f"<Known: {len(self.table)} shapes for {self.loop.sequence}>"

    def answers(self, straight: Sequence[Traced], bent: Sequence[Traced] = ()) -> list[Answer]:
        """All answers, in the order that was measured to be best.

        The mean, the rod by the rule, the rod in its surroundings, single shapes that cover what
        these leave open up to `FIRST`; then the other rods. Of DNA loops few are known: there the
        rod comes first, and a mean only if it is over the same sequence.

        Parameters
        ----------
        straight : sequence of Traced
            The rods of one clamp, least energy first.
        bent : sequence of Traced
            Those in their surroundings.

        Returns
        -------
        list of Answer
            For rods in their surroundings ``rod`` goes on counting.
        """
        first, kind = self._mean()
        rods, among = rod_answers(straight, bent)
        answers = [Answer(kind, first.trace, first.energy, first), *rods[:1], *among[:1]]
        if self.loop.is_dna and rods:
            mean = answers.pop(0)
            answers[1:1] = [mean] if self.same.any() else []
        for line in self._covering([one.trace_A for one in answers], FIRST - len(answers)):
            answers.append(Answer("library", line.trace, line.energy, line))
        return [*answers, *rods[1:], *among[1:]]

    def _mean(self) -> tuple[ChainLine, str]:
        """The mean of what is most like the loop, and its kind.

        A mean of deformed shapes fits this stem as it is: its energy is the mean of theirs.
        """
        among, kind, name = self._basis()
        share = self.weighted.among(among)
        n = int(among.sum())
        if n == 1 and not name:
            return self._line(self.table.shape(int(np.flatnonzero(among)[0]))), "library"
        name = f"{name}, {n} loop{'s' * (n > 1)}" if name else f"mean of {n} loops"
        sequence = self.loop.sequence.replace("T", "U")
        shape = shape_between(share.mean_A, self.poses.local, sequence, self.loop.is_dna, name)
        (line,) = chain_lines([shape], self.poses, self.loop.is_dna)
        if line is None:
            # means of shapes that contradict each other can be folded up
            line = self._line(self.table.shape(int(np.argmax(self.weighted.weights * among))))
        return replace(line, energy=float(share.weights @ self.energies[among])), kind

    def _covering(self, lines_A: Sequence[Array], count: int) -> list[ChainLine]:
        covered = [rms_A(self.weighted.nodes_A, self._local(x)) for x in lines_A]
        nearest_A = np.min(covered, axis=0) if covered else None
        rows = covering(self.weighted, nearest_A, count)
        return [self._line(self.table.shape(row)) for row in rows]

    def spread_A(self, trace_A: Array) -> float:
        """Expected distance of the loop from an answer (n, 3) in the file's coordinates, Å.

        Few shapes know little: `DOUBT` sequences as far apart as is usual are added to them.
        """
        n, own = len(self.loop), self.weighted.distance_A(self._local(trace_A))
        k = self.sequences
        return math.sqrt((k * own**2 + DOUBT * typical_spread_A(n) ** 2) / (k + DOUBT))

    def _basis(self) -> tuple[NDArray[np.bool_], str, str]:
        """Which shapes the mean is over, its kind in the table of errors, and what it is called."""
        usable = self.weighted.weights > 0.0
        same = usable & self.same
        if self.motif is not None:
            of_motif = usable & self.motif.matches(self.table.letters)
            name = f"motif {self.motif.name}"
            if same.any():
                return same, name, f"{name}, same sequence"
            if of_motif.any():
                return of_motif, name, name
        return (same, *2 * ("same sequence",)) if same.any() else (usable, "mean", "")

    def _local(self, trace_A: Array) -> Array:
        return np.asarray((trace_A - self.poses.start_origin_A) @ self.poses.start_frame)

    def _line(self, shape: LoopShape) -> ChainLine:
        (line,) = chain_lines([shape], self.poses, self.loop.is_dna)
        assert line is not None, "every shape of the table was deformed before"
        return line


def usable_shapes(
    library: Library,
    loop: Loop,
    entries: Collection[str] = (),
    exclude_relatives: bool = False,
    own: LoopShape | None = None,
) -> ShapeTable:
    """What a library has for a loop.

    Parameters
    ----------
    library : Library
        Loop shapes. Loops of DNA, of which few are known, may take those of RNA.
    loop : Hairpin or another `Loop`
        Of its nucleotides only the sequence counts.
    entries : collection of str
        Entries of the databank that the loop may be from: their shapes are left out.
    exclude_relatives : bool
        Leave out shapes of related sequences.
    own : LoopShape, optional
        The loop as the file has it: a shape that is the same (`OWN_A`) is from another copy of the
        file and is left out. It has no other use.

    Returns
    -------
    ShapeTable
        Those of its length.
    """
    table = library.of_length(len(loop), None if loop.is_dna else False)
    without = table.of_entries(entries)
    if exclude_relatives:
        without |= table.relatives(loop.sequence)
    if own is not None:
        without |= table.like(own, OWN_A)
    return table.take(~without)


def known_shapes(
    loop: Loop, poses: ClosingPoses, table: ShapeTable, atoms_A: Array | None = None
) -> Known | None:
    """Deform loop shapes onto the stem of a loop, and weigh them.

    Parameters
    ----------
    loop : Hairpin or another `Loop`
    poses : ClosingPoses
        Of its closing nucleotides.
    table : ShapeTable
        Shapes of its length.
    atoms_A : (m, 3) array, optional
        What lines may run into, in the coordinates of the file, Å.

    Returns
    -------
    Known or None
        None where nothing could be deformed onto this stem.
    """
    copies = copies_of(table.letters)
    chosen = nearest(table, poses, loop.sequence, MOST_SHAPES)
    table, copies = table.take(chosen), copies[chosen]
    if not len(table):
        return None
    batch = deform_batch(table.steps_A, table.end_frames, poses.position_A, poses.rotation)
    there = batch.converged
    table, copies = table.take(there), copies[there]
    nodes_A, energies = batch.nodes[there], batch.energy[there]
    if not len(table):
        return None
    near = np.zeros(len(table))
    if atoms_A is not None:
        near = atoms_per_point(poses.to_file(smooth_lines(nodes_A)), atoms_A)
    distances = sequence_distance(table.letters, letters_of(loop.sequence))
    weights = weigh(energies, distances, copies, near, len(loop))
    return Known(
        loop,
        poses,
        table,
        Weighted(nodes_A[:, 1:-1], weights),
        energies,
        table.same_loop(loop.sequence) & (table.is_dna == loop.is_dna),
        None if loop.is_dna else motif_of(loop.sequence),
        len(np.unique(table.letters[:, 1:-1], axis=0)),
    )


def library_at(path: str | None) -> Library:
    """The library of a file, or of a folder of structures; the one that is shipped for None."""
    if path is None:
        return load_library(data_path("loops.lib"))
    return library_of_folder(Path(path)) if Path(path).is_dir() else load_library(path)
