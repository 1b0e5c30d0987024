"""Which strands of a structure can be taken out: between which nucleotides, and of what kind.

A strand is a whole run of unpaired nucleotides between two paired ones (bulge, internal loop,
junction, hairpin, or a joint between helices), a cut in the middle of such a run, whose neighbours
are unpaired, or a piece of one strand of a helix.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica.errors import LoopelasticaError
from loopelastica.molecule.nucleotides import Nucleotides, centroids, linked, read_structure
from loopelastica.molecule.pairs import canonical_pairs

LONGEST: Final = 12
HELIX_CUTS: Final = (1, 2, 4, 6)
_MOST_BRANCHES: Final = 12


@dataclass(frozen=True, slots=True)
class Cut:
    """A strand to be taken out.

    Attributes
    ----------
    file : Path
    name : str
        Such as "A.6-9".
    kind : str
        "RNA" or "DNA".
    type : str
        "bulge", "internal", "junction", "hairpin", "joint", "unpaired" or "helix".
    n : int
        Nucleotides.
    context : str
        Parent bases, with up to three more on both sides: copies and relatives agree in it.
    """

    file: Path
    name: str
    kind: str
    type: str
    n: int
    context: str


def cuts(file: Path) -> list[Cut]:
    """All strands of a file that can be taken out, in chain order; none where it cannot be read.

    Parameters
    ----------
    file : Path
        A structure; its first model is looked at.

    Returns
    -------
    list of Cut
    """
    try:
        structure = read_structure(file)
        positions = structure.positions(0)
        table = structure.nucleotides
        partner = np.full(len(table), -1)
        pairs = canonical_pairs(table, positions)
    except LoopelasticaError:
        return []
    partner[pairs[:, 0]], partner[pairs[:, 1]] = pairs[:, 1], pairs[:, 0]
    joined = linked(table, positions)
    whole = np.isfinite(centroids(table, positions)).all(axis=1) & (table.letter != "N")
    found = []
    for first, last, what in _strands(partner, joined):
        rows = np.arange(first - 1, last + 2)
        alike = len(set(table.is_dna[rows].tolist())) == 1
        if whole[rows].all() and joined[rows[:-1]].all() and alike:
            found.append(_cut(file, table, first, last, what))
    return found


def _cut(file: Path, table: Nucleotides, first: int, last: int, what: str) -> Cut:
    numbers = (
        table.number(first) if first == last else f"{table.number(first)}-{table.number(last)}"
    )
    chain = f"{table.chain[first]}." if table.chain[first] else ""
    kind = "DNA" if table.is_dna[first] else "RNA"
    context = "".join(table.letter[max(first - 3, 0) : last + 4])
    return Cut(file, f"{chain}{numbers}", kind, what, last - first + 1, context)


def _strands(
    partner: NDArray[np.int64], joined: NDArray[np.bool_]
) -> Iterator[tuple[int, int, str]]:
    """First and last row of each strand, and what it is."""
    n = len(partner)
    row = 0
    while row < n:
        last = row
        while last + 1 < n and joined[last] and (partner[last + 1] < 0) == (partner[row] < 0):
            last += 1
        length = last - row + 1
        if partner[row] >= 0:
            yield from ((a, b, "helix") for a, b in _inside(row, last, HELIX_CUTS)
                        if (np.diff(partner[a - 1 : b + 2]) == -1).all())  # fmt: skip
        else:
            between = row > 0 and last + 1 < n and joined[row - 1] and joined[last]
            if between and length <= LONGEST:
                yield row, last, _type(partner, joined, row, last)
            yield from ((a, b, "unpaired") for a, b in _inside(row, last, range(1, LONGEST + 1)))
        row = last + 1


def _inside(first: int, last: int, lengths: range | tuple[int, ...]) -> Iterator[tuple[int, int]]:
    """Pieces in the middle of a run that leave a nucleotide of it on both sides."""
    for length in lengths:
        if last - first + 1 >= length + 2:
            start = first + 1 + (last - first - 1 - length) // 2
            yield start, start + length - 1


def _type(partner: NDArray[np.int64], joined: NDArray[np.bool_], first: int, last: int) -> str:
    """What closes the loop that a strand between two paired nucleotides belongs to."""
    if partner[first - 1] == last + 1:
        return "hairpin"
    row, lengths = last + 1, []
    for _ in range(_MOST_BRANCHES):
        # across the pair, then on to the next paired nucleotide
        row, length = int(partner[row]), 0
        while True:
            if row + 1 >= len(partner) or not joined[row]:
                return "joint"
            row += 1
            if partner[row] >= 0:
                break
            length += 1
        lengths.append(length)
        if row == last + 1:
            others = lengths[:-1]
            return "junction" if len(others) != 1 else "internal" if others[0] else "bulge"
    return "joint"


def distinct(found: list[Cut]) -> list[Cut]:
    """Each strand once: copies and relatives, alike in kind, type and context, count as one."""
    return list(
        {(cut.kind, cut.type, cut.n, cut.context): cut for cut in reversed(found)}.values()
    )[::-1]
