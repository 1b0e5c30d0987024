"""Where the nucleotides that are there stand in the sequence of record.

Nucleotides that a bond joins are neighbours in the record too, so a chain is a row of segments, and
only where each segment begins is open. Least disagreement is sought by dynamic programming: letters
count first, then whether as many residues lie between two segments as their numbers say. So chain
breaks decide where a repeated letter belongs, and numbers where the letters leave a choice.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.molecule.polymer import Monomer
from loopelastica.molecule.record import Listed

_WRONG_LETTER: Final = 100.0
_WRONG_NAME: Final = 0.01
"""Same parent base under another name: a modified nucleotide and its parent."""
_WRONG_NUMBER: Final = 1.0


def align(
    monomers: Sequence[Monomer],
    listed: Sequence[Listed],
    joined: Sequence[bool],
    between: Sequence[int],
    before: int | None,
) -> list[int] | None:
    """Places in the record of nucleotides that are there.

    Parameters
    ----------
    monomers : sequence of n Monomer
        What is there, 5' to 3'.
    listed : sequence of m Listed
        The record.
    joined : sequence of n − 1 bool
        Whether a bond joins each to the next.
    between : sequence of n − 1 int
        How many are missing between each and the next, by their numbers.
    before : int or None
        How many are missing before the first; None where nothing tells.

    Returns
    -------
    list of n int, or None
        From 0, increasing. Letters may disagree there. None where the record is shorter than what
        is there.
    """
    n, m = len(monomers), len(listed)
    if n > m:
        return None
    breaks = [k + 1 for k in range(n - 1) if not joined[k]]
    segments = list(zip([0, *breaks], [*breaks, n], strict=True))
    costs = _costs(monomers, listed)
    best = np.zeros(0)
    origins: list[NDArray[np.int64]] = []
    for begin, end in segments:
        length = end - begin
        here = _windows(costs[begin:end])
        if begin == 0:
            # the first segment begins anywhere, by choice where the numbers say
            start = _WRONG_NUMBER * np.ones(len(here))
            if before is not None and before < len(start):
                start[before] = 0.0
            best = np.full(m + 1, np.inf)
            best[length:] = here + start
            origins.append(np.zeros(m + 1, dtype=np.int64))
            continue
        # lowest[j]: where the segment before ends, at j or earlier, at least cost
        lowest = _running_argmin(best)
        follow, origin = best[lowest] + _WRONG_NUMBER, lowest
        gap = between[begin - 1]
        exact = np.full(m + 1, np.inf)
        if 0 <= gap <= m:
            exact[gap:] = best[: m + 1 - gap]
        nearer = exact <= follow
        follow = np.where(nearer, exact, follow)
        origin = np.where(nearer, np.arange(m + 1) - gap, origin)
        total = np.full(m + 1, np.inf)
        total[length:] = here + follow[: m + 1 - length]
        ends = np.zeros(m + 1, dtype=np.int64)
        ends[length:] = origin[: m + 1 - length]
        best = total
        origins.append(ends)
    return _traced(segments, origins, int(np.argmin(best)))


def _traced(
    segments: list[tuple[int, int]], origins: list[NDArray[np.int64]], end: int
) -> list[int]:
    places: list[int] = []
    for (first, last), origin in zip(reversed(segments), reversed(origins), strict=True):
        begin = end - (last - first)
        places[:0] = range(begin, end)
        end = int(origin[end])
    return places


def _running_argmin(values: Array) -> NDArray[np.int64]:
    """For each j the index up to j of the least value, the last of equals."""
    least = np.minimum.accumulate(values)
    here = np.where(values == least, np.arange(len(values)), 0)
    return np.asarray(np.maximum.accumulate(here), dtype=np.int64)


def _costs(monomers: Sequence[Monomer], listed: Sequence[Listed]) -> NDArray[np.float32]:
    """Disagreement (n, m) of each nucleotide with each place of the record."""
    codes: dict[str, int] = {}
    there = np.array([codes.setdefault(_same(one.letter), len(codes)) for one in monomers])
    named = np.array([codes.setdefault(_same(one.letter), len(codes)) for one in listed])
    unknown = codes.get("N", -1)
    wrong = there[:, None] != named
    wrong &= (there[:, None] != unknown) & (named != unknown)
    cost = np.where(wrong, np.float32(_WRONG_LETTER), np.float32(0.0))
    kinds: dict[str, int] = {}
    names = np.array([kinds.setdefault(one.resname, len(kinds)) for one in monomers])
    firsts = np.array([kinds.setdefault(one.names[0], len(kinds)) for one in listed])
    cost[names[:, None] != firsts] += _WRONG_NAME
    for j, one in enumerate(listed):
        for other in one.names[1:]:
            cost[names == kinds.get(other, -1), j] = 0.0
    return cost


def _windows(costs: NDArray[np.float32]) -> Array:
    """Sum of a segment's costs (length, m) for each place where it may begin."""
    length, m = costs.shape
    total = np.zeros(m - length + 1)
    for k in range(length):
        total += costs[k, k : k + len(total)]
    return total


def _same(letter: str) -> str:
    return "U" if letter == "T" else letter


def disagreements(
    monomers: Sequence[Monomer], listed: Sequence[Listed], places: Sequence[int]
) -> list[int]:
    """Which nucleotides have another base than the record at their place.

    Parameters
    ----------
    monomers : sequence of Monomer
    listed : sequence of Listed
    places : sequence of int
        Place in `listed` of each.

    Returns
    -------
    list of int
    """
    found = []
    for k, place in enumerate(places):
        one, letters = listed[place], {_same(listed[place].letter), _same(monomers[k].letter)}
        if monomers[k].resname not in one.names and len(letters - {"N"}) > 1:
            found.append(k)
    return found
