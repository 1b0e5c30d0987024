"""Canonical pairs, and the hairpin loops they close.

A hairpin loop is the single strand between the two nucleotides of a canonical pair: one unbroken
chain with no canonical pair of its own. Pairs of loop nucleotides with others far away (kissing
loops, tertiary contacts) are allowed and listed, for they bend the loop and no stem tells of them.

Left out are loops with nucleotides missing in the file, isolated pairs from which no stem goes on,
and pseudoknots: there a strand of the loop is itself half of a helix. What is left out for what the
file shows is told in :attr:`Hairpins.remarks`; a user who names the loop gets it all the same.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica.errors import StructureError
from loopelastica.molecule._loops import asked_loop, closing_pairs, pairs_of, stem_length
from loopelastica.molecule.nucleotides import (
    Nucleotides,
    Structure,
    enumerated,
    linked,
    read_structure,
)
from loopelastica.molecule.pairs import MIN_LOOP, canonical_pairs, dot_bracket
from loopelastica.molecule.selection import (
    Place,
    as_texts,
    asked_pairs,
    bracket_pairs,
    ends_of,
)

__all__ = [
    "MAX_LOOP",
    "MIN_LOOP",
    "Hairpin",
    "Hairpins",
    "canonical_pairs",
    "dot_bracket",
    "find_hairpins",
    "hairpins_of",
]

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
    kissing : tuple of str
        Names of the hairpin loops that this one pairs with.
    loop : (n,) array of int
        Loop nucleotides 5' to 3'; −1 where one is absent from the file.
    resid : (n,) array of int
        Their residue numbers.
    icode : (n,) array of str
        Their insertion codes or "".
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
    kissing: tuple[str, ...]
    loop: NDArray[np.int64]
    resid: NDArray[np.int64]
    icode: NDArray[np.str_]
    stem_5: NDArray[np.int64]
    stem_3: NDArray[np.int64]

    def __post_init__(self) -> None:
        for values in (self.loop, self.resid, self.icode, self.stem_5, self.stem_3):
            values.setflags(write=False)

    def __len__(self) -> int:
        """Return the number of loop nucleotides."""
        return len(self.loop)

    @property
    def n_pairs(self) -> int:
        """Number of pairs of the stem without a bulge; 1 for an isolated closing pair."""
        return len(self.stem_5)


class Hairpins(list[Hairpin]):
    """The hairpins of one model, in the order of the file.

    Attributes
    ----------
    dot_bracket : str
        Secondary structure, a character per nucleotide of the structure.
    remarks : tuple of str
        One sentence for each loop that was left out, asked for, or pairs with another one.
    """

    __slots__ = ("dot_bracket", "remarks")

    def __init__(
        self, hairpins: Iterable[Hairpin], dot_bracket: str, remarks: Iterable[str]
    ) -> None:
        super().__init__(hairpins)
        self.dot_bracket = dot_bracket
        self.remarks = tuple(remarks)


def find_hairpins(
    source: Any,
    *,
    min_loop: int = MIN_LOOP,
    max_loop: int = MAX_LOOP,
    pair: str | Sequence[str] = (),
    dot_bracket: str | None = None,
    loop: str | Sequence[str] = (),
) -> Hairpins:
    """Hairpin loops of the first model of a file, a Universe or a Structure.

    Parameters
    ----------
    source : path, MDAnalysis.Universe or Structure
        Where to look.
    min_loop, max_loop : int
        Fewest and most loop nucleotides.
    pair : str or sequence of str
        Pairs known from other data, such as "A.12-A.25", beside those of the coordinates. They hold
        at any loop length and without a stem that goes on.
    dot_bracket : str, optional
        Secondary structure in place of the pairs of the coordinates: a character per nucleotide in
        the order of the file.
    loop : str or sequence of str
        First and last nucleotide of the loops that are wanted, such as "A.13-24"; then only these
        are given. Their neighbours 12 and 25 close them, whatever they pair with, and must be in
        the file. Where loop nucleotides are absent from the file, the numbers tell how many there
        are.

    Returns
    -------
    Hairpins
        A list of :class:`Hairpin`, with `dot_bracket` and `remarks`.

    Raises
    ------
    StructureError
        If the structure cannot be read, has no nucleotide, or not the ones named.
    ValueError
        If an argument cannot be understood.

    Examples
    --------
    >>> from loopelastica._files import data_path
    >>> for hairpin in find_hairpins(data_path("hairpins/2koc.pdb")):
    ...     print(hairpin.name, hairpin.sequence, hairpin.closing_pair, hairpin.n_pairs)
    A6-9 CUUCGG ('A.C5', 'A.G10') 5
    """
    structure: Structure = read_structure(source)
    try:
        return hairpins_of(
            structure.nucleotides,
            structure.positions(0),
            min_loop=min_loop,
            max_loop=max_loop,
            pair=pair,
            dot_bracket=dot_bracket,
            loop=loop,
        )
    except StructureError as error:
        where = structure.source or structure.name
        sentence = str(error)
        raise StructureError(
            sentence if sentence.startswith(where) else f"{where}: {sentence}"
        ) from None


def hairpins_of(
    nucleotides: Nucleotides,
    positions: NDArray[np.float64],
    *,
    min_loop: int = MIN_LOOP,
    max_loop: int = MAX_LOOP,
    pair: str | Sequence[str] = (),
    dot_bracket: str | None = None,
    loop: str | Sequence[str] = (),
) -> Hairpins:
    """Hairpin loops of one model, in the order of the file; see :func:`find_hairpins`."""
    if not 1 <= min_loop <= max_loop:
        raise ValueError(f"`min_loop` is {min_loop}, not between 1 and `max_loop` = {max_loop}")
    wanted = [ends_of(nucleotides, "loop", text) for text in as_texts(loop)]
    if dot_bracket is None:
        pairs, told = canonical_pairs(nucleotides, positions), set[tuple[int, int]]()
    else:
        pairs = bracket_pairs(nucleotides, dot_bracket)
        told = {(i, j) for i, j in pairs.tolist()}
    partner = np.full(len(nucleotides), -1, dtype=np.int64)
    partner[pairs[:, 0]], partner[pairs[:, 1]] = pairs[:, 1], pairs[:, 0]
    for i, j in asked_pairs(nucleotides, as_texts(pair)):
        former = partner[[i, j]]
        partner[former[former >= 0]] = -1
        partner[i], partner[j] = j, i
        told.add((i, j))
    joined = linked(nucleotides, positions)
    if wanted:
        return _asked(nucleotides, partner, joined, wanted)
    return _found(nucleotides, positions, partner, joined, told, min_loop, max_loop)


def _found(
    nucleotides: Nucleotides,
    positions: NDArray[np.float64],
    partner: NDArray[np.int64],
    joined: NDArray[np.bool_],
    told: set[tuple[int, int]],
    min_loop: int,
    max_loop: int,
) -> Hairpins:
    """Loops that the pairs close; pairs `told` by the user close one at any length."""
    kept, remarks = closing_pairs(nucleotides, positions, partner, joined, told, min_loop, max_loop)
    loop_of = {row: (i, j) for i, j in kept for row in range(i + 1, j)}
    hairpins = [
        _hairpin(nucleotides, partner, joined, i, j, np.arange(i + 1, j), loop_of) for i, j in kept
    ]
    told_of: set[str] = set()
    for hairpin in hairpins:
        # Of two loops that kiss, the first one tells.
        if not told_of.issuperset(hairpin.kissing) or not hairpin.kissing:
            remarks += _contacts(hairpin)
        told_of.add(hairpin.name)
    return Hairpins(hairpins, dot_bracket(len(nucleotides), np.array(pairs_of(partner))), remarks)


def _asked(
    nucleotides: Nucleotides,
    partner: NDArray[np.int64],
    joined: NDArray[np.bool_],
    wanted: list[tuple[Place, Place]],
) -> Hairpins:
    """Loops that the user names by their first and last nucleotide."""
    hairpins, remarks = [], []
    for first, last in wanted:
        i, j, loop = asked_loop(nucleotides, joined, first, last)
        hairpin = _hairpin(nucleotides, partner, joined, i, j, loop, {})
        hairpins.append(hairpin)
        absent = int((loop < 0).sum())
        if absent:
            remarks.append(
                f"{hairpin.name}: {absent} of its {len(loop)} nucleotides are not in the file,"
                " their number is taken from the residue numbers"
            )
        if partner[i] != j:
            remarks.append(
                f"{hairpin.name}: {'–'.join(hairpin.closing_pair)} is no pair by the coordinates,"
                " the loop is clamped there as asked"
            )
        remarks += _contacts(hairpin)
    return Hairpins(hairpins, dot_bracket(len(nucleotides), np.array(pairs_of(partner))), remarks)


def _contacts(hairpin: Hairpin) -> Iterator[str]:
    """Say that a loop pairs with something else, which its stem does not tell."""
    if hairpin.contacts:
        pairs = enumerated(["–".join(pair) for pair in hairpin.contacts])
        what = f"kisses {' and '.join(hairpin.kissing)}" if hairpin.kissing else "pairs outside"
        yield f"{hairpin.name} {what} ({pairs})"


def _loop_name(nucleotides: Nucleotides, i: int, j: int) -> str:
    chain = str(nucleotides.chain[i]) or "_"
    return f"{chain}{nucleotides.number(i + 1)}-{nucleotides.number(j - 1)}"


def _hairpin(
    nucleotides: Nucleotides,
    partner: NDArray[np.int64],
    joined: NDArray[np.bool_],
    i: int,
    j: int,
    loop: NDArray[np.int64],
    loop_of: dict[int, tuple[int, int]],
) -> Hairpin:
    """The hairpin closed by rows i and j; `loop_of` tells the closing rows of each loop row."""
    n_pairs = stem_length(partner, joined, i, j)
    stem_5, stem_3 = i - np.arange(n_pairs), j + np.arange(n_pairs)
    label, chain = nucleotides.label, str(nucleotides.chain[i])
    prefix = f"{chain}." if chain else ""
    resid, icode = nucleotides.resid[loop], nucleotides.icode[loop]
    if (loop < 0).any():
        # Without insertion codes: the numbers go on from the 5' closing nucleotide.
        resid, icode = nucleotides.resid[i] + 1 + np.arange(len(loop)), np.full(len(loop), "")
    outside = {int(k): int(partner[k]) for k in loop if k >= 0 and partner[k] >= 0}
    outside = {k: other for k, other in outside.items() if other not in set(loop.tolist())}
    kissed = {loop_of[other] for other in outside.values() if other in loop_of}
    return Hairpin(
        chain=chain,
        name=f"{chain or '_'}{resid[0]}{icode[0]}-{resid[-1]}{icode[-1]}",
        closing_pair=(label(i), label(j)),
        residues=tuple(
            label(k) if k >= 0 else f"{prefix}N{number}"
            for k, number in zip(loop.tolist(), resid, strict=True)
        ),
        sequence="".join(nucleotides.letter[k] if k >= 0 else "N" for k in (i, *loop, j)),
        is_dna=bool(nucleotides.is_dna[np.concatenate([stem_5, stem_3])].mean() > 0.5),
        contacts=tuple((label(k), label(other)) for k, other in outside.items()),
        kissing=tuple(_loop_name(nucleotides, *ends) for ends in sorted(kissed)),
        loop=loop,
        resid=resid,
        icode=icode,
        stem_5=stem_5,
        stem_3=stem_3,
    )
