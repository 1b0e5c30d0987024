"""Which rows close a hairpin loop, by their pairs or by name, and what is left out."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.errors import StructureError
from loopelastica.molecule.nucleotides import Nucleotides, atom_positions, enumerated
from loopelastica.molecule.selection import Place, row_at, rows_at

BESIDE_MAX_A: Final = 12.5
"""Longest C1'–C1' distance of two nucleotides that face each other in a helix of any pairs. Next to
an isolated closing pair 8.7–11.2 Å are found where a stem of mispairs goes on, 13–22 Å where a
tertiary pair merely meets a turn of the chain."""
MOST_NAMED: Final = 1000
"""Most nucleotides of a loop whose length only the numbers tell."""
MIN_HELIX: Final = 3
"""Pairs in a row that make a pseudoknot of a contact."""


def pairs_of(partner: NDArray[np.int64]) -> list[tuple[int, int]]:
    """Pairs i < j of the partner array (n,), −1 where single."""
    return [(i, int(j)) for i, j in enumerate(partner) if i < j]


def closing_pairs(
    nucleotides: Nucleotides,
    positions: Array,
    partner: NDArray[np.int64],
    joined: NDArray[np.bool_],
    given: set[tuple[int, int]],
    limits: tuple[int, int],
) -> tuple[list[tuple[int, int]], list[str]]:
    """Pairs that close a hairpin loop, and a sentence for each that the file spoils.

    Parameters
    ----------
    nucleotides : Nucleotides
        Table of n nucleotides.
    positions : (n_atoms, 3) array
        All atoms of one model, Å.
    partner : (n,) array of int
        Row that each nucleotide pairs with, −1 where it is single.
    joined : (n − 1,) array of bool
        Whether the chain goes on to the next row.
    given : set of (int, int)
        Pairs of the user: they close a loop of any length, without a stem that goes on.
    limits : (int, int)
        Fewest and most nucleotides of any other loop.

    Returns
    -------
    closing : list of (int, int)
        Rows i < j of the closing pairs, in their order.
    remarks : list of str
    """
    min_loop, max_loop = limits
    c1 = atom_positions(nucleotides, positions, ("C1'",))[:, 0]
    closing: list[tuple[int, int]] = []
    remarks: list[str] = []
    for i, j in pairs_of(partner):
        if _holds_a_pair(partner, i, j):
            continue
        if not joined[i:j].all():
            # The length of a loop with missing nucleotides follows from its numbers only.
            remarks += _incomplete(nucleotides, joined, i, j, max_loop)
        elif ((i, j) in given and j - i > 1) or (
            min_loop <= j - i - 1 <= max_loop
            and (stem_length(partner, joined, i, j) > 1 or _stem_goes_on(c1, joined, i, j))
        ):
            closing.append((i, j))
    knots = [(i, j) for i, j in closing if _pseudoknotted(partner, closing, i, j)]
    remarks += [_knot(nucleotides, partner, i, j) for i, j in knots]
    kept = [ends for ends in closing if ends not in knots]
    return kept, remarks


def _holds_a_pair(partner: NDArray[np.int64], i: int, j: int) -> bool:
    """Whether two loop nucleotides pair each other."""
    inside = partner[i + 1 : j]
    return bool(((inside > i) & (inside < j)).any())


def stem_length(partner: NDArray[np.int64], joined: NDArray[np.bool_], i: int, j: int) -> int:
    """Pairs (i − k, j + k) in a row, both strands unbroken."""
    n = 1
    while i - n >= 0 and partner[i - n] == j + n and joined[i - n] and joined[j + n - 1]:
        n += 1
    return n


def _stem_goes_on(c1: Array, joined: NDArray[np.bool_], i: int, j: int) -> bool:
    """Whether the strands run on side by side outside an isolated pair, one bulge allowed."""
    for a, b in ((1, 1), (1, 2), (2, 1)):
        if i - a < 0 or j + b >= len(c1):
            continue
        unbroken = joined[i - a : i].all() and joined[j : j + b].all()
        if unbroken and np.linalg.norm(c1[i - a] - c1[j + b]) <= BESIDE_MAX_A:
            return True
    return False


def _pseudoknotted(
    partner: NDArray[np.int64], closing: list[tuple[int, int]], i: int, j: int
) -> bool:
    """Whether a strand of the loop forms a helix with anything but another hairpin loop."""
    run = 0
    for k in range(i + 1, j):
        other = int(partner[k])
        kissing = any(a < other < b and (b < i or j < a) for a, b in closing)
        if other < 0 or kissing:
            run = 0
            continue
        run = run + 1 if run and partner[k - 1] == other + 1 else 1
        if run >= MIN_HELIX:
            return True
    return False


def _incomplete(
    nucleotides: Nucleotides, joined: NDArray[np.bool_], i: int, j: int, max_loop: int
) -> Iterator[str]:
    """Say that a loop has nucleotides missing, where the numbers are those of a hairpin loop."""
    label, number = nucleotides.label, nucleotides.resid
    n = int(number[j] - number[i]) - 1
    if nucleotides.chain[i] == nucleotides.chain[j] and j - i - 1 < n <= max_loop:
        chain = f"{nucleotides.chain[i]}." if nucleotides.chain[i] else ""
        name = f"{chain}{number[i] + 1}-{number[j] - 1}"
        yield (
            f"{label(i)}–{label(j)}: {n - (j - i - 1)} of its {n} loop nucleotides are missing or"
            f" incomplete in the file, so it is left out; `loop` {name} folds it"
        )


def _knot(nucleotides: Nucleotides, partner: NDArray[np.int64], i: int, j: int) -> str:
    label = nucleotides.label
    pairs = [f"{label(k)}–{label(int(partner[k]))}" for k in range(i + 1, j) if partner[k] >= 0]
    return (
        f"{label(i)}–{label(j)}: a pseudoknot, its loop is half of a helix"
        f" ({enumerated(pairs)}), so it is left out"
    )


def named_loop(
    nucleotides: Nucleotides, joined: NDArray[np.bool_], first: Place, last: Place
) -> tuple[int, int, NDArray[np.int64]]:
    """The loop that a user names by its first and last nucleotide.

    Parameters
    ----------
    nucleotides : Nucleotides
        Table of n nucleotides.
    joined : (n − 1,) array of bool
        Whether the chain goes on to the next row.
    first, last : Place
        Its ends, which may be absent from the file.

    Returns
    -------
    i, j : int
        Rows of the closing nucleotides.
    loop : (m,) array of int
        Rows of the loop, −1 where a nucleotide is not in the file.

    Raises
    ------
    StructureError
        If there is no such loop, or its closing nucleotides are not in the file.
    """
    name = f"{first}-{last.number}{last.icode}"
    refusal = f"`loop` {name} has no stem to be clamped to"
    i = _beside(nucleotides, joined, first, -1, refusal)
    j = _beside(nucleotides, joined, last, 1, refusal)
    chain = nucleotides.chain[i]
    if not i < j or nucleotides.chain[j] != chain:
        raise StructureError(f"`loop` {name} does not run 5' to 3' along one chain")
    if j - i > 1 and joined[i:j].all():
        return i, j, np.arange(i + 1, j)
    if first.icode or last.icode or (nucleotides.icode[i + 1 : j] != "").any():
        raise StructureError(
            f"`loop` {name}: nucleotides are missing in the file, and with insertion codes the"
            " numbers do not say how many"
        )
    if last.number - first.number >= MOST_NAMED:
        raise StructureError(f"`loop` {name} has more than {MOST_NAMED:,} nucleotides")
    present = {int(nucleotides.resid[row]): row for row in range(i + 1, j)}
    rows = [present.get(number, -1) for number in range(first.number, last.number + 1)]
    if not rows:
        raise StructureError(f"`loop` {name} does not run 5' to 3' along one chain")
    return i, j, np.array(rows, dtype=np.int64)


def _beside(
    nucleotides: Nucleotides, joined: NDArray[np.bool_], end: Place, step: int, refusal: str
) -> int:
    """Row of the nucleotide before (step −1) or after (1) one end of a loop."""
    rows = rows_at(nucleotides, end)
    if rows:
        row = row_at(nucleotides, end, refusal) + step
        if 0 <= row < len(nucleotides) and joined[min(row, row - step)]:
            return row
        raise StructureError(f"the chain does not go on at {end}; {refusal}")
    if rows_at(nucleotides, end._replace(name="")):
        raise StructureError(f"there is no nucleotide {end}; {refusal}")
    neighbour = end._replace(number=end.number + step, icode="", name="")
    return row_at(nucleotides, neighbour, refusal)
