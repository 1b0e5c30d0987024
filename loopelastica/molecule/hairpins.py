"""Canonical pairs, and the hairpin loops they close.

A hairpin loop is the single strand between the two nucleotides of a canonical pair: one unbroken
chain with no canonical pair of its own. Pairs of loop nucleotides with others far away (kissing
loops, tertiary contacts) are allowed and listed, for they bend the loop and no stem shows them.

Left out are loops with nucleotides missing in the file, isolated pairs from which no stem goes on,
and pseudoknots: there a strand of the loop is itself half of a helix. What is left out for what the
file shows is stated in :attr:`Hairpins.remarks`; a user who names the loop gets it all the same.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record
from loopelastica._checks import keywords_known, optional, whole
from loopelastica._html import html_table
from loopelastica.errors import StructureError
from loopelastica.molecule._loops import closing_pairs, named_loop, pairs_of, stem_length
from loopelastica.molecule.nucleotides import (
    MAX_ATOMS,
    MAX_SIZE_MB,
    Limits,
    Nucleotides,
    enumerated,
    linked,
    read_structure,
)
from loopelastica.molecule.pairs import MIN_LOOP, canonical_pairs, dot_bracket
from loopelastica.molecule.selection import (
    Place,
    bracket_pairs,
    brackets,
    ends_of,
    named_pairs,
    places,
)

MAX_LOOP: Final = 30


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Hairpin(Record):
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

    Examples
    --------
    >>> from loopelastica._files import data_path
    >>> (hairpin,) = find_hairpins(data_path("hairpins/2koc.pdb"))
    >>> hairpin.name, hairpin.label, hairpin.sequence, len(hairpin), hairpin.kind
    ('A6-9', 'A.C5–A.G10', 'CUUCGG', 4, 'RNA')
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

    def __repr__(self) -> str:
        stem = "a stem of one pair" if self.n_pairs == 1 else f"a stem of {self.n_pairs} pairs"
        return f"<Hairpin {self.name} {self.sequence}: {self.kind}, {len(self)} nt on {stem}>"

    def __len__(self) -> int:
        """Return the number of loop nucleotides."""
        return len(self.loop)

    @property
    def label(self) -> str:
        """The closing pair, such as "A.C5–A.G10"."""
        return "–".join(self.closing_pair)

    @property
    def kind(self) -> str:
        """The stem's kind: "DNA" or "RNA"."""
        return "DNA" if self.is_dna else "RNA"

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
        One sentence for each loop that was left out, was named, or pairs with another one.

    Examples
    --------
    >>> from loopelastica._files import data_path
    >>> hairpins = find_hairpins(data_path("hairpins/2koc.pdb"))
    >>> len(hairpins), hairpins.dot_bracket, hairpins.remarks
    (1, '(((((....)))))', ())
    """

    __slots__ = ("dot_bracket", "remarks")

    def __init__(
        self, hairpins: Iterable[Hairpin], dot_bracket: str, remarks: Iterable[str]
    ) -> None:
        super().__init__(hairpins)
        self.dot_bracket = dot_bracket
        self.remarks = tuple(remarks)

    def _repr_html_(self) -> str:
        """A table of them, for notebooks."""
        names = ("loop", "closing pair", "sequence", "kind", "nt", "stem pairs", "pairs with")
        rows = [
            (
                *(one.name, one.label, one.sequence, one.kind, len(one), one.n_pairs),
                ", ".join("–".join(pair) for pair in one.contacts),
            )
            for one in self
        ]
        return html_table(f"hairpin loops: {len(self)}", names, rows)

    def __reduce__(self) -> tuple[Any, ...]:
        return Hairpins, ([*self], self.dot_bracket, self.remarks)


@keywords_known
def find_hairpins(
    structure: Any,
    *,
    min_loop: int = MIN_LOOP,
    max_loop: int = MAX_LOOP,
    pair: str | Sequence[str] = (),
    dot_bracket: str | None = None,
    loop: str | Sequence[str] = (),
    max_size_MB: float = MAX_SIZE_MB,
    max_atoms: int = MAX_ATOMS,
) -> Hairpins:
    """Hairpin loops of the first model of a file, or of the current frame of a Universe.

    Parameters
    ----------
    structure : path, MDAnalysis.Universe, MDAnalysis.AtomGroup or Structure
        Where to look; of a group of atoms, only its own nucleotides pair and count.
    min_loop, max_loop : int
        Fewest and most loop nucleotides.
    pair : str or sequence of str
        Pairs known from other data, such as "A.12-A.25", beside those of the coordinates. They hold
        at any loop length and without a stem that goes on.
    dot_bracket : str, optional
        Secondary structure in place of the pairs of the coordinates: a character per nucleotide in
        the order of the file.
    loop : str or sequence of str
        First and last nucleotide of loops such as "A.13-24"; then only these are given. Their
        neighbours 12 and 25 close them, whatever they pair with, and must be in the file. Where
        loop nucleotides are absent from the file, their numbers say how many there are.
    max_size_MB, max_atoms : float, int
        How large a file may be: megabytes after decompression, atoms of a model.

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
    size = Limits(max_size_MB, max_atoms)
    least = whole(1)("min_loop", min_loop)
    limits = least, whole(least)("max_loop", max_loop)
    named, pairs = places("loop", loop), places("pair", pair)
    dot_bracket = optional(brackets)("dot_bracket", dot_bracket)
    structure = read_structure(structure, size)
    try:
        return _hairpins(
            structure.nucleotides, structure.positions(0), limits, pairs, dot_bracket, named
        )
    except StructureError as error:
        where = structure.where
        sentence = str(error)
        raise StructureError(
            sentence if sentence.startswith(where) else f"{where}: {sentence}"
        ) from None


def _hairpins(
    nucleotides: Nucleotides,
    positions: Array,
    limits: tuple[int, int],
    pair: Sequence[str],
    dot_bracket: str | None,
    loop: Sequence[str],
) -> Hairpins:
    named = [ends_of(nucleotides, "loop", text) for text in loop]
    if dot_bracket is None:
        pairs, given = canonical_pairs(nucleotides, positions), set[tuple[int, int]]()
    else:
        pairs = bracket_pairs(nucleotides, dot_bracket)
        given = {(i, j) for i, j in pairs.tolist()}
    partner = np.full(len(nucleotides), -1, dtype=np.int64)
    partner[pairs[:, 0]], partner[pairs[:, 1]] = pairs[:, 1], pairs[:, 0]
    for i, j in named_pairs(nucleotides, pair):
        former = partner[[i, j]]
        partner[former[former >= 0]] = -1
        partner[i], partner[j] = j, i
        given.add((i, j))
    joined = linked(nucleotides, positions)
    if named:
        return _named(nucleotides, partner, joined, named)
    return _found(nucleotides, positions, partner, joined, given, limits)


def _found(
    nucleotides: Nucleotides,
    positions: Array,
    partner: NDArray[np.int64],
    joined: NDArray[np.bool_],
    given: set[tuple[int, int]],
    limits: tuple[int, int],
) -> Hairpins:
    """Loops that the pairs close; pairs `given` by the user close one at any length."""
    kept, remarks = closing_pairs(nucleotides, positions, partner, joined, given, limits)
    loop_of = {row: (i, j) for i, j in kept for row in range(i + 1, j)}
    hairpins = [
        _hairpin(nucleotides, partner, joined, i, j, np.arange(i + 1, j), loop_of) for i, j in kept
    ]
    before: set[str] = set()
    for hairpin in hairpins:
        # Two loops that kiss get one remark, the first one's.
        if not before.issuperset(hairpin.kissing) or not hairpin.kissing:
            remarks += _contacts(hairpin)
        before.add(hairpin.name)
    return Hairpins(hairpins, dot_bracket(len(nucleotides), np.array(pairs_of(partner))), remarks)


def _named(
    nucleotides: Nucleotides,
    partner: NDArray[np.int64],
    joined: NDArray[np.bool_],
    named: list[tuple[Place, Place]],
) -> Hairpins:
    """Loops that the user names by their first and last nucleotide."""
    hairpins, remarks = [], []
    for first, last in named:
        i, j, loop = named_loop(nucleotides, joined, first, last)
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
                f"{hairpin.name}: {hairpin.label} is no pair by the coordinates, the loop is"
                " clamped there as requested"
            )
        remarks += _contacts(hairpin)
    return Hairpins(hairpins, dot_bracket(len(nucleotides), np.array(pairs_of(partner))), remarks)


def _contacts(hairpin: Hairpin) -> Iterator[str]:
    """Say that a loop pairs with something else, which its stem does not show."""
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
    """The hairpin closed by rows i and j; `loop_of` holds the closing rows of each loop row."""
    n_pairs = stem_length(partner, joined, i, j)
    stem_5, stem_3 = i - np.arange(n_pairs), j + np.arange(n_pairs)
    label, chain = nucleotides.label, str(nucleotides.chain[i])
    prefix = f"{chain}." if chain else ""
    resid, icode = nucleotides.resid[loop], nucleotides.icode[loop]
    if (loop < 0).any():
        # Without insertion codes: the numbers go on from the 5' closing nucleotide.
        resid, icode = nucleotides.resid[i] + 1 + np.arange(len(loop)), np.full(len(loop), "")
    outside = {int(k): int(partner[k]) for k in loop if k >= 0 and partner[k] >= 0}
    own = set(loop.tolist())
    outside = {k: other for k, other in outside.items() if other not in own}
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
