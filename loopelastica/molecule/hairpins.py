"""Canonical pairs, and the hairpin loops they close.

A hairpin loop is the single strand between the two nucleotides of a canonical pair: one unbroken
chain with no canonical pair of its own. Pairs of loop nucleotides with others far away (kissing
loops, tertiary contacts) are allowed and listed, for they bend the loop and no stem tells of them.

Left out are loops of unknown length (nucleotides missing in the file), isolated pairs from which no
stem goes on, and pseudoknots: there a strand of the loop is itself half of a helix.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica.molecule.nucleotides import (
    Nucleotides,
    Structure,
    atom_positions,
    linked,
    read_structure,
)
from loopelastica.molecule.pairs import MIN_LOOP, canonical_pairs, dot_bracket

__all__ = [
    "MAX_LOOP",
    "MIN_LOOP",
    "Hairpin",
    "canonical_pairs",
    "dot_bracket",
    "find_hairpins",
    "hairpins_of",
]

BESIDE_MAX_A: Final = 12.5
"""Longest C1'–C1' distance of two nucleotides that face each other in a helix of any pairs. Next to
an isolated closing pair 8.7–11.2 Å are found where a stem of mispairs goes on, 13–22 Å where a
tertiary pair merely meets a turn of the chain."""
MIN_HELIX: Final = 3
"""Pairs in a row that make a pseudoknot of a contact."""

MAX_LOOP: Final = 30


@dataclass(frozen=True, slots=True, eq=False)
class Hairpin:
    """One hairpin loop and the stem that holds it; arrays are rows of :class:`Nucleotides`.

    Attributes
    ----------
    chain : str
        Chain of all its nucleotides, "" where the file names none.
    name : str
        Chain, first and last number of the loop, such as "A6-9" or "_6-9" without a chain.
    closing_pair : tuple of str
        Labels of the 5' and the 3' closing nucleotide.
    residues : tuple of str
        Labels of the loop nucleotides, closing pair left out.
    sequence : str
        Parent bases from the 5' to the 3' closing nucleotide.
    is_dna : bool
        Whether most of the stem is DNA, for the stem decides the ideal strand.
    contacts : tuple of (str, str)
        Canonical pairs of loop nucleotides with nucleotides outside: loop label, other label.
    loop : (n,) array of int
        Loop nucleotides 5' to 3'.
    stem_5, stem_3 : (n_pairs,) array of int
        The two strands of the stem outwards from the closing pair; `stem_5[k]` pairs `stem_3[k]`.
    """

    chain: str
    name: str
    closing_pair: tuple[str, str]
    residues: tuple[str, ...]
    sequence: str
    is_dna: bool
    contacts: tuple[tuple[str, str], ...]
    loop: NDArray[np.int64]
    stem_5: NDArray[np.int64]
    stem_3: NDArray[np.int64]

    def __post_init__(self) -> None:
        for rows in (self.loop, self.stem_5, self.stem_3):
            rows.setflags(write=False)

    def __len__(self) -> int:
        """Return the number of loop nucleotides."""
        return len(self.loop)

    @property
    def n_pairs(self) -> int:
        """Number of pairs of the stem without a bulge; 1 for an isolated closing pair."""
        return len(self.stem_5)


def find_hairpins(
    source: Any, *, min_loop: int = MIN_LOOP, max_loop: int = MAX_LOOP
) -> list[Hairpin]:
    """Hairpin loops of the first model of a file, a Universe or a Structure.

    Parameters
    ----------
    source : path, MDAnalysis.Universe or Structure
        Where to look.
    min_loop, max_loop : int
        Fewest and most loop nucleotides.

    Raises
    ------
    StructureError
        If the structure cannot be read or has no nucleotide.

    Examples
    --------
    >>> from loopelastica._data import data_path
    >>> for hairpin in find_hairpins(data_path("hairpins/2koc.pdb")):
    ...     print(hairpin.name, hairpin.sequence, hairpin.closing_pair, hairpin.n_pairs)
    A6-9 CUUCGG ('A.C5', 'A.G10') 5
    """
    structure: Structure = read_structure(source)
    return hairpins_of(
        structure.nucleotides, structure.positions(0), min_loop=min_loop, max_loop=max_loop
    )


def hairpins_of(
    nucleotides: Nucleotides,
    positions: NDArray[np.float64],
    *,
    min_loop: int = MIN_LOOP,
    max_loop: int = MAX_LOOP,
) -> list[Hairpin]:
    """Hairpin loops of one model, in the order of the file; see :func:`find_hairpins`."""
    if not 1 <= min_loop <= max_loop:
        raise ValueError(f"`min_loop` is {min_loop}, not between 1 and `max_loop` = {max_loop}")
    pairs = canonical_pairs(nucleotides, positions)
    joined = linked(nucleotides, positions)
    partner = np.full(len(nucleotides), -1, dtype=np.int64)
    partner[pairs[:, 0]], partner[pairs[:, 1]] = pairs[:, 1], pairs[:, 0]
    c1 = atom_positions(nucleotides, positions, ("C1'",))[:, 0]
    closing = [
        (i, j)
        for i, j in pairs.tolist()
        # A gap in the chain means missing nucleotides: the length of the loop is then unknown.
        if min_loop <= j - i - 1 <= max_loop
        and joined[i:j].all()
        and not _holds_a_pair(partner, i, j)
        and (_stem_length(partner, joined, i, j) > 1 or _stem_goes_on(c1, joined, i, j))
    ]
    return [
        _hairpin(nucleotides, partner, joined, i, j)
        for i, j in closing
        if not _pseudoknotted(partner, closing, i, j)
    ]


def _holds_a_pair(partner: NDArray[np.int64], i: int, j: int) -> bool:
    """Whether two loop nucleotides pair each other."""
    inside = partner[i + 1 : j]
    return bool(((inside > i) & (inside < j)).any())


def _stem_length(partner: NDArray[np.int64], joined: NDArray[np.bool_], i: int, j: int) -> int:
    """Pairs (i − k, j + k) in a row, both strands unbroken."""
    n = 1
    while i - n >= 0 and partner[i - n] == j + n and joined[i - n] and joined[j + n - 1]:
        n += 1
    return n


def _stem_goes_on(c1: NDArray[np.float64], joined: NDArray[np.bool_], i: int, j: int) -> bool:
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


def _hairpin(
    nucleotides: Nucleotides,
    partner: NDArray[np.int64],
    joined: NDArray[np.bool_],
    i: int,
    j: int,
) -> Hairpin:
    n_pairs = _stem_length(partner, joined, i, j)
    loop = np.arange(i + 1, j)
    stem_5, stem_3 = i - np.arange(n_pairs), j + np.arange(n_pairs)
    label, chain = nucleotides.label, str(nucleotides.chain[i])
    return Hairpin(
        chain=chain,
        name=f"{chain or '_'}{nucleotides.number(i + 1)}-{nucleotides.number(j - 1)}",
        closing_pair=(label(i), label(j)),
        residues=tuple(label(k) for k in range(i + 1, j)),
        sequence="".join(nucleotides.letter[i : j + 1]),
        is_dna=bool(nucleotides.is_dna[np.concatenate([stem_5, stem_3])].mean() > 0.5),
        contacts=tuple(
            (label(k), label(int(partner[k]))) for k in range(i + 1, j) if partner[k] >= 0
        ),
        loop=loop,
        stem_5=stem_5,
        stem_3=stem_3,
    )
