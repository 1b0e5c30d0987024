"""Loop shapes of one length as a table of arrays, and which of them are related to a loop."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record, read_only
from loopelastica.molecule.shapes import LoopShape

COPY_A: Final = 0.5
"""Loops of one entry and sequence whose nodes are nearer than this (RMS) are one loop."""

Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ShapeTable(Record):
    """k shapes of loops of n nucleotides, as arrays.

    Attributes
    ----------
    is_dna : (k,) array of bool
        Kind of the stem.
    letters : (k, n + 2) array of uint8
        Bases from closing to closing nucleotide in ASCII, T as U.
    steps_A : (k, n + 1, 3) array
        From each node to the next, in the frame of the first, Å.
    end_frames : (k, 3, 3) array
        Frame of the last node in that of the first.
    stem_rms_A : (k,) array
        Misfit of the ideal strands to the stem, Å.
    entries, sources : (k,) array of str
        Entry such as "1zih", and place such as "1zih A.4-A.9".
    copies : (k,) array of int
        Shapes of the library that have the same loop sequence and kind, this one included.
    """

    is_dna: Mask
    letters: NDArray[np.uint8]
    steps_A: Array
    end_frames: Array
    stem_rms_A: Array
    entries: NDArray[np.str_]
    sources: NDArray[np.str_]
    copies: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.letters)

    def __repr__(self) -> str:
        return f"<ShapeTable of {len(self)} loops of {self.nucleotides} nt>"

    @property
    def nucleotides(self) -> int:
        """Number of loop nucleotides, n."""
        return int(self.letters.shape[1]) - 2

    @property
    def nodes_A(self) -> Array:
        """The nodes (k, n + 2, 3) in the frame of the first, Å."""
        nodes = np.zeros((len(self), self.nucleotides + 2, 3))
        np.cumsum(self.steps_A, axis=1, out=nodes[:, 1:])
        return nodes

    def sequence(self, index: int) -> str:
        """Bases of one shape, from closing to closing nucleotide."""
        return bytes(self.letters[index]).decode()

    def shape(self, index: int) -> LoopShape:
        """One shape."""
        return LoopShape(
            self.sequence(index),
            bool(self.is_dna[index]),
            read_only(self.steps_A[index]),
            read_only(self.end_frames[index]),
            str(self.sources[index]),
        )

    def take(self, which: NDArray[Any]) -> ShapeTable:
        """Those at some indices, or where a mask is true; `copies` stays as it is."""
        return ShapeTable(*(getattr(self, name)[which] for name in ShapeTable.__slots__))

    def same_loop(self, sequence: str) -> Mask:
        """Which have the loop sequence of another, its closing pair left out.

        Parameters
        ----------
        sequence : str
            Bases from closing to closing nucleotide, n + 2; T is U.
        """
        loop = self._letters_of(sequence)[1:-1]
        return np.equal(_differences(self.letters[:, 1:-1], loop), 0)

    def relatives(self, sequence: str) -> Mask:
        """Which are related to a loop by sequence, whatever the kind of either.

        Relatives have the same loop sequence; or differ in no more than one base from five
        nucleotides on, two from seven on, closing pair included.

        Parameters
        ----------
        sequence : str
            Bases from closing to closing nucleotide, n + 2; T is U.

        Returns
        -------
        (k,) array of bool

        Raises
        ------
        ValueError
            If `sequence` is of another length.
        """
        n = self.nucleotides
        most = 2 if n >= 7 else 1 if n >= 5 else 0
        near = _differences(self.letters, self._letters_of(sequence)) <= most
        related: Mask = self.same_loop(sequence) | near
        return related

    def of_entries(self, entries: Collection[str]) -> Mask:
        """Which are from one of these entries, such as those that a query may be of."""
        return np.isin(self.entries, [entry.lower() for entry in entries])

    def like(self, shape: LoopShape, within_A: float = COPY_A) -> Mask:
        """Which have the sequence of a shape, and nodes not further from its own than this (RMS).

        Within 0.05 Å it is the same loop in another file.
        """
        same = _differences(self.letters, self._letters_of(shape.sequence)) == 0
        found = np.zeros(len(self), dtype=np.bool_)
        found[same] = rms_A(self.nodes_A[same], shape.nodes_A) <= within_A
        return found

    def _letters_of(self, sequence: str) -> NDArray[np.uint8]:
        if len(sequence) != self.nucleotides + 2:
            raise ValueError(
                f"`sequence` has {len(sequence)} letters; loops of {self.nucleotides} nucleotides"
                f" have {self.nucleotides + 2} with their closing pair"
            )
        return letters_of(sequence)


def rms_A(nodes_A: Array, other_A: Array) -> Array:
    """Root mean square distance (...,) of nodes (..., n + 2, 3) to others where they are, Å."""
    return np.asarray(np.sqrt(((nodes_A - other_A) ** 2).sum(axis=-1).mean(axis=-1)))


def letters_of(sequence: str) -> NDArray[np.uint8]:
    """A sequence as ASCII codes (k,), upper case, T as U."""
    text = sequence.upper().replace("T", "U").encode("ascii", "replace")
    return np.frombuffer(text, dtype=np.uint8)


def _differences(letters: NDArray[np.uint8], others: NDArray[np.uint8]) -> NDArray[np.int64]:
    return np.asarray((letters != others).sum(axis=1))


def empty_table(nucleotides: int) -> ShapeTable:
    """A table without shapes."""
    return table_of(nucleotides, [])


def table_of(nucleotides: int, loops: Iterable[FoundLoop]) -> ShapeTable:
    """Shapes of one length and kind as they come, counted."""
    loops = list(loops)
    k, m = len(loops), nucleotides + 1
    shapes = [loop.shape for loop in loops]
    letters = np.array([letters_of(s.sequence) for s in shapes], dtype=np.uint8).reshape(k, m + 1)
    return ShapeTable(
        is_dna=np.array([s.is_dna for s in shapes], dtype=np.bool_),
        letters=letters,
        steps_A=np.array([s.steps_A for s in shapes], dtype=np.float64).reshape(k, m, 3),
        end_frames=np.array([s.end_frame for s in shapes], dtype=np.float64).reshape(k, 3, 3),
        stem_rms_A=np.array([loop.stem_rms_A for loop in loops], dtype=np.float64),
        entries=np.array([loop.entry for loop in loops], dtype=np.str_),
        sources=np.array([s.source for s in shapes], dtype=np.str_),
        copies=copies_of(letters),
    )


def copies_of(letters: NDArray[np.uint8]) -> NDArray[np.int64]:
    """How many of k sequences (k, n + 2) have the loop of each, closing pairs left out."""
    if not len(letters):
        return np.zeros(0, dtype=np.int64)
    # a loop as one value: rows take ten times as long
    loops = np.ascontiguousarray(letters[:, 1:-1])
    loops = loops.view(f"S{loops.shape[1]}").ravel()
    _, which, counts = np.unique(loops, return_inverse=True, return_counts=True)
    return np.asarray(counts, dtype=np.int64)[which]


def joined(tables: Iterable[ShapeTable]) -> ShapeTable:
    """Tables of one length as one."""
    columns = zip(
        *([getattr(t, name) for name in ShapeTable.__slots__] for t in tables), strict=True
    )
    return ShapeTable(*(np.concatenate(column) for column in columns))


class FoundLoop(NamedTuple):
    """A loop on its way into a library."""

    shape: LoopShape
    entry: str
    stem_rms_A: float

    @property
    def order(self) -> tuple[Any, ...]:
        """What loops are sorted by: nothing of the order in which they were found."""
        shape = self.shape
        values = np.concatenate([shape.steps_A, shape.end_frame]).tobytes()
        return shape.is_dna, len(shape), shape.sequence, self.entry, shape.source, values
