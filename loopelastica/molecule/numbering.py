"""Author numbers for nucleotides that a file gives none."""

from __future__ import annotations

from string import ascii_uppercase
from typing import Final

from loopelastica.molecule.polymer import Monomer

Place = tuple[int, str]
"""Author number and insertion code."""

NO_CODE: Final = "?"
"""Insertion code of those that no number is left for."""


def free_places(
    chain: str, before: Monomer | None, after: Monomer | None, n: int, used: set[Place]
) -> tuple[list[Place], str]:
    """Numbers for n missing nucleotides between two that are there.

    They count on from the one before. Where that leaves no room, the rest are insertions to the
    last number; where they count further than the numbers leave room for, numbers stay free.

    Parameters
    ----------
    chain : str
        For the sentence.
    before, after : Monomer or None
        What they lie between; None at an end of the chain.
    n : int
        How many.
    used : set of (int, str)
        Numbers and insertion codes of the chain that are in use.

    Returns
    -------
    places : list of (int, str)
        With insertion code ``NO_CODE`` where none are left.
    sentence : str
        What was chosen; "" where numbers and count agree.
    """
    if before is None and after is None:
        return [(k + 1, "") for k in range(n)], ""
    if after is None:
        assert before is not None
        return [(before.number + k + 1, "") for k in range(n)], ""
    if before is None:
        return [(after.number - n + k, "") for k in range(n)], ""
    room = [(k, "") for k in range(before.number + 1, after.number) if (k, "") not in used]
    if len(room) == n == after.number - before.number - 1:
        return room, ""
    places = room[:n]
    last = places[-1][0] if places else before.number
    codes = ascii_uppercase
    if not places and before.icode:
        codes = codes[codes.find(before.icode.upper()) + 1 :]
    free = [(last, code) for code in codes if (last, code) not in used]
    places += free[: n - len(places)]
    places += [(last, NO_CODE)] * (n - len(places))
    named = [f"{number}{icode}" for number, icode in places]
    span = named[0] if n == 1 else f"{named[0]}–{named[-1]}"
    prefix = f"{chain}." if chain else ""
    return places, (
        f"{prefix}{before.number}{before.icode}–{after.number}{after.icode}: the record has {n}"
        f" nucleotide(s) between them and gives them no numbers; they are called {span}"
    )
