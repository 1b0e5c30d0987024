"""A library of loop shapes: a table of arrays for each kind and number of nucleotides.

A table is made or read when it is first needed. Which of its shapes a query may be answered with is
said by masks: :meth:`ShapeTable.relatives`, :meth:`ShapeTable.of_entries`,
:meth:`ShapeTable.like`. Which of many are worth deforming is estimated by
:mod:`loopelastica.folding.nearest`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Final, NamedTuple

import numpy as np

from loopelastica._checks import whole
from loopelastica.folding.shape_table import (
    COPY_A,
    FoundLoop,
    ShapeTable,
    empty_table,
    joined,
    rms_A,
    table_of,
)

MIN_NUCLEOTIDES: Final = 3
MAX_NUCLEOTIDES: Final = 12


class Kind(NamedTuple):
    """What the shapes of a table have in common."""

    is_dna: bool
    nucleotides: int

    def __str__(self) -> str:
        return f"{'DNA' if self.is_dna else 'RNA'}{self.nucleotides}"


class Library:
    """Many loop shapes, by kind and length.

    Attributes
    ----------
    counts : dict
        Number of shapes by `Kind`, RNA before DNA and short before long.

    Examples
    --------
    >>> import loopelastica as le
    >>> from loopelastica._files import data_path
    >>> library = le.load_library(data_path("loops.lib"))
    >>> len(library), len(library.of_length(4, is_dna=False))
    (570, 255)
    """

    def __init__(self, counts: Mapping[Kind, int], table: Callable[[Kind], ShapeTable]) -> None:
        self.counts = {kind: counts[kind] for kind in sorted(counts) if counts[kind]}
        self._table = table
        self._read: dict[Kind, ShapeTable] = {}

    @classmethod
    def of(cls, loops: Iterable[FoundLoop]) -> Library:
        """A library of loops, in whatever order they come.

        Of one entry and sequence, loops whose shapes are copies of each other (`COPY_A`) are kept
        once, the first by place.

        Parameters
        ----------
        loops : iterable of FoundLoop
            Of any lengths and kinds.

        Returns
        -------
        Library
        """
        tables: dict[Kind, list[FoundLoop]] = {}
        for loop in _without_copies(sorted(loops, key=lambda loop: loop.order)):
            tables.setdefault(Kind(loop.shape.is_dna, len(loop.shape)), []).append(loop)
        made = {kind: table_of(kind.nucleotides, found) for kind, found in tables.items()}
        return cls({kind: len(table) for kind, table in made.items()}, made.__getitem__)

    def __len__(self) -> int:
        return sum(self.counts.values())

    def __repr__(self) -> str:
        loops = "1 loop" if len(self) == 1 else f"{len(self)} loops"
        return f"<Library of {loops}: {', '.join(map(str, self.counts)) or 'none'}>"

    def of_length(self, nucleotides: int, is_dna: bool | None = None) -> ShapeTable:
        """All shapes of loops of n nucleotides.

        Parameters
        ----------
        nucleotides : int
            Loop nucleotides, without the closing pair.
        is_dna : bool, optional
            Whether those on DNA stems or those on RNA stems; default both, RNA first.

        Returns
        -------
        ShapeTable
            Without a shape where there is none.

        Raises
        ------
        LoopelasticaError
            If the file is damaged there.
        """
        n = whole(1)("nucleotides", nucleotides)
        asked = [Kind(dna, n) for dna in (False, True) if is_dna is None or dna == is_dna]
        tables = [self.table(kind) for kind in asked if kind in self.counts]
        if not tables:
            return empty_table(n)
        return tables[0] if len(tables) == 1 else joined(tables)

    def table(self, kind: Kind) -> ShapeTable:
        """The table of one kind, read when it is first needed.

        Parameters
        ----------
        kind : Kind
            One of `counts`.

        Returns
        -------
        ShapeTable
        """
        if kind not in self._read:
            self._read[kind] = self._table(kind)
        return self._read[kind]

    def tables(self) -> Iterator[tuple[Kind, ShapeTable]]:
        """Each kind and its table.

        Returns
        -------
        iterator of (Kind, ShapeTable)
        """
        return ((kind, self.table(kind)) for kind in self.counts)


def _without_copies(loops: Iterable[FoundLoop]) -> Iterator[FoundLoop]:
    """Sorted loops without those that another one of the same entry and sequence stands for."""
    last, kept = None, np.empty((0, 0, 3))
    for loop in loops:
        nodes = loop.shape.nodes_A[None]
        if last != (group := loop.order[:4]):
            last, kept = group, nodes
        elif (rms_A(kept, nodes) <= COPY_A).any():
            continue
        else:
            kept = np.concatenate([kept, nodes])
        yield loop
