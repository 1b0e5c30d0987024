"""What a user writes for a hairpin, read: nucleotides, pairs, RNA or DNA.

    "GGCAC(UUCG)GUGCC"    "ggcac uucg gugcc (((((....)))))"    "5'-GG[5MC]A(UUCG)UGCC-3'"

A hairpin is one stem of paired nucleotides and the loop that it closes. What is none (bulges,
internal loops, junctions, overhangs) is refused with the place.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

from loopelastica._checks import flag, optional, shown
from loopelastica._checks import text as checked_text
from loopelastica.atoms.chemistry import Residue
from loopelastica.molecule.components import METHYLATED, component, is_standard
from loopelastica.molecule.hairpins import MAX_LOOP
from loopelastica.molecule.pairs import CANONICAL, MIN_LOOP

MAX_STEM: Final = 100
"""Most pairs of a built stem; one of 100 takes some 5 s."""
_MAX_TEXT: Final = 10_000
_EXAMPLE: Final = (
    'two strands with the loop in brackets, such as "GGCAC(UUCG)GUGCC", or a sequence with its'
    ' dot-bracket, such as "GGCACUUCGGUGCC (((((....)))))"'
)
_END_5: Final = re.compile(r"^\s*5\s*['’′]\s*[-–]?")
_END_3: Final = re.compile(r"[-–]?\s*3\s*['’′]\s*$", re.MULTILINE)
# as programs for secondary structure write it behind theirs
_ENERGY: Final = re.compile(r"\(\s*[-+]?\d+\.\d+\s*\)\s*$")
_NAME: Final = r"\[\s*(?P<name>[A-Za-z0-9]{1,5})\s*\]"
_NUCLEOTIDE: Final = re.compile(rf"{_NAME}|[^\s.()\[\]{{}}<>]")
_OF_KIND: Final = re.compile(r"\s*(?P<kind>[dDrR])\s*\((?P<sequence>.*)\)\s*", re.DOTALL)
_TOKEN: Final = re.compile(rf"{_NAME}|(?P<one>.)", re.DOTALL)
# of ribonucleotides and of deoxyribonucleotides; the others are of both
_ONLY: Final = {"U": False, "T": True}
# the second methyl group takes the place of the hydrogen that a pair needs
_UNPAIRED: Final = frozenset({"M2G"})


@dataclass(frozen=True, slots=True)
class HairpinSequence:
    """The nucleotides of a hairpin without overhangs.

    Attributes
    ----------
    residues : tuple of Residue
        5' to 3'.
    pairs : int
        Of the stem.
    mismatches : tuple of str
        Those that are none of the pairs that build a helix, such as "A3·A12".
    """

    residues: tuple[Residue, ...]
    pairs: int
    mismatches: tuple[str, ...] = ()

    @property
    def is_dna(self) -> bool:
        """DNA, else RNA."""
        return self.residues[0].is_dna

    @property
    def strand_5(self) -> tuple[Residue, ...]:
        """The 5' strand of the stem."""
        return self.residues[: self.pairs]

    @property
    def loop(self) -> tuple[Residue, ...]:
        """The nucleotides between the two of the closing pair."""
        return self.residues[self.pairs : -self.pairs]

    @property
    def strand_3(self) -> tuple[Residue, ...]:
        """The 3' strand of the stem."""
        return self.residues[-self.pairs :]

    @property
    def letters(self) -> str:
        """Parent bases."""
        return "".join(residue.letter for residue in self.residues)

    def __str__(self) -> str:
        parts = (self.strand_5, self.loop, self.strand_3)
        return "{}({}){}".format(*("".join(_written(r) for r in part) for part in parts))


def read_sequence(
    text: str,
    structure: str | None = None,
    *,
    rna: bool | None = None,
    mismatches: bool = False,
) -> HairpinSequence:
    """A hairpin as people write it.

    Spaces and lower case mean nothing. Modified nucleotides stand in square brackets by the names
    of the wwPDB.

    Parameters
    ----------
    text : str
        Such as "GGCAC(UUCG)GUGCC", "5'-ggcac (uucg) gugcc-3'", "d(GCGC GAA GCGC)" (strands of
        one length), or a sequence with its dot-bracket behind it. Lines that begin with ">" are
        left out.
    structure : str, optional
        The dot-bracket, where it is not in `text`.
    rna : bool, optional
        True: RNA, False: DNA; by default T and U decide.
    mismatches : bool
        Take nucleotides that do not pair into the stem too.

    Returns
    -------
    HairpinSequence

    Raises
    ------
    ValueError
        If it is no hairpin, a nucleotide is unknown or of the other kind, the kind is open, or
        nucleotides of the stem do not pair; the sentence says where.

    Examples
    --------
    >>> print(read_sequence("ggc acu ucg gug cc  (((((....)))))"))
    GGCAC(UUCG)GUGCC
    >>> read_sequence("GC[5MU](UUCG)AGC").letters, read_sequence("GGC(TTT)GCC").is_dna
    ('GCUUUCGAGC', True)
    """
    rna, mismatches = optional(flag)("rna", rna), flag("mismatches", mismatches)
    sequence, brackets = _split(text, structure)
    if (marked := _OF_KIND.fullmatch(sequence)) and rna in (None, marked["kind"] in "rR"):
        sequence, rna = marked["sequence"], marked["kind"] in "rR"
    if brackets is None:
        sequence = _with_brackets(sequence)
    tokens = _tokens(sequence)
    names = [token for token in tokens if token not in "()"]
    around = "".join(token for token in tokens if token in "()")
    if brackets is not None and around:
        raise ValueError(
            "`sequence` has its loop in brackets and a dot-bracket too; one of them is enough"
        )
    if brackets is None and around != "()":
        raise ValueError(f"`sequence` is {shown(text)}; it must be {_EXAMPLE}")
    residues = _residues(names, rna)
    labels = [f"{name}{k}" for k, name in enumerate(names, start=1)]
    if brackets is None:
        pairs = _pairs_of_strands(sequence, tokens, residues, labels)
    else:
        pairs = _pairs_of_brackets(brackets, labels)
    n_loop = len(residues) - 2 * pairs
    if not MIN_LOOP <= n_loop <= MAX_LOOP:
        raise ValueError(
            f"`sequence`: the loop has {n_loop} nucleotides, not {MIN_LOOP} to {MAX_LOOP}"
        )
    if pairs > MAX_STEM:
        raise ValueError(f"`sequence`: the stem has {pairs} pairs; at most {MAX_STEM} are built")
    wrong = tuple(_mismatches(residues, labels, pairs))
    if wrong and not mismatches:
        raise ValueError(
            f"`sequence`: {wrong[0]} do not pair, the stem is none; pairs are A·U, A·T, G·C, G·U"
            " and G·T, and `mismatches` lets others be"
        )
    return HairpinSequence(residues, pairs, wrong)


def pair_of(one: Residue, other: Residue) -> str | None:
    """Which pair of a helix two nucleotides make: "GC", "AU" or "GU" (also with T), else None.

    Parameters
    ----------
    one, other : Residue
        In either order.

    Returns
    -------
    str or None
        The purine first.

    Examples
    --------
    >>> pair_of(Residue("T", True, "DT"), Residue("G", True, "DG"))
    'GU'
    """
    if _UNPAIRED & {one.resname, other.resname}:
        return None
    both = (one.letter + other.letter, other.letter + one.letter)
    return next((pair.replace("T", "U") for pair in both if pair in CANONICAL), None)


def _split(text: Any, structure: Any) -> tuple[str, str | None]:
    """The sequence and its dot-bracket, spaces left out of the latter."""
    text, structure = checked_text("sequence", text), optional(checked_text)("structure", structure)
    for name, value in (("sequence", text), ("structure", structure or "")):
        if len(value) > _MAX_TEXT:
            raise ValueError(
                f"`{name}` has {len(value)} characters; a hairpin has at most"
                f" {2 * MAX_STEM + MAX_LOOP} nucleotides"
            )
    lines = text.strip().splitlines()
    if sum(line.startswith(">") for line in lines) > 1:
        raise ValueError("`sequence` holds several hairpins; give them one by one, or as a file")
    bare = "\n".join(line for line in lines if not line.startswith(">"))
    bare = _ENERGY.sub("", _END_3.sub("", _END_5.sub("", bare)))
    # behind the last nucleotide
    end = max((found.end() for found in _NUCLEOTIDE.finditer(bare)), default=0)
    within = bare[end:] if "." in bare[end:] else None
    sequence = bare[:end] if within else bare
    if not sequence.strip():
        raise ValueError(f"`sequence` is {shown(text)}; it must be {_EXAMPLE}")
    if within is not None and structure is not None:
        raise ValueError("`sequence` and `structure` both hold a dot-bracket; one is enough")
    given = within if structure is None else _ENERGY.sub("", structure)
    return sequence, None if given is None else "".join(given.split())


def _with_brackets(sequence: str) -> str:
    """Three words, the outer ones of one length, are a strand, the loop and a strand."""
    words = re.split(r"[\s\-]+", sequence.strip())
    if len(words) != 3 or any(sign in sequence for sign in "()"):
        return sequence
    counts = [len(_NUCLEOTIDE.findall(word)) for word in words]
    return f"{words[0]}({words[1]}){words[2]}" if counts[0] == counts[2] else sequence


def _tokens(sequence: str) -> list[str]:
    """Names of nucleotides, and the brackets around the loop."""
    tokens = []
    for found in _TOKEN.finditer(sequence):
        name, one = found["name"], found["one"]
        if name is not None:
            tokens.append(name.upper())
        elif one in "()" or (one.isascii() and one.isalpha()):
            tokens.append(one.upper())
        elif not one.isspace():
            raise ValueError(
                f"`sequence`: {shown(one)}, character {found.start() + 1} of {shown(sequence)}, is"
                f" no nucleotide; it must be {_EXAMPLE}"
            )
    return tokens


def _residues(names: Sequence[str], rna: bool | None) -> tuple[Residue, ...]:
    kinds = [_kind_of(name, k) for k, name in enumerate(names, start=1)]
    # the first of either kind
    first = {is_dna: kinds.index(is_dna) for is_dna in (False, True) if is_dna in kinds}
    where = {is_dna: f"{names[k]} (nucleotide {k + 1})" for is_dna, k in first.items()}
    if len(first) == 2:
        raise ValueError(
            f"`sequence` has both {where[False]} and {where[True]}, and is of one kind: T in RNA is"
            " written [5MU], U in DNA [DU]"
        )
    if rna is None and not first:
        raise ValueError(
            "`rna` is needed: the sequence has neither U nor T, so it may be RNA, which has U, or"
            " DNA, which has T"
        )
    is_dna = next(iter(first)) if rna is None else not rna
    if (not is_dna) in first:
        kind, letters = ("DNA", "A, C, G, T") if is_dna else ("RNA", "A, C, G, U")
        raise ValueError(f"`sequence`: {where[not is_dna]} is no base of {kind} ({letters})")
    return tuple(_residue(name, is_dna) for name in names)


def _kind_of(name: str, number: int) -> bool | None:
    """Whether a nucleotide is of DNA; None where it may be of either kind."""
    if name in ("A", "C", "G", "U", "T"):
        return _ONLY.get(name)
    known = component(name)
    if name not in METHYLATED and not (len(name) == 2 and name[0] == "D" and is_standard(name)):
        what = f"{name} (nucleotide {number})"
        modified = known is not None and len(name) > 1
        why = "is a nucleotide that cannot be built" if modified else "is no known nucleotide"
        raise ValueError(
            f"`sequence`: {what} {why}; there are A, C, G, U, T and, in square brackets,"
            f" {', '.join(METHYLATED)} of RNA and DU of DNA"
        )
    return bool(known and known.is_dna)


def _residue(name: str, is_dna: bool) -> Residue:
    if name in METHYLATED:
        known = component(name)
        assert known is not None
        return Residue(known.letter, is_dna, name)
    letter = name[-1]
    return Residue(letter, is_dna, f"D{letter}" if is_dna else letter)


def _written(residue: Residue) -> str:
    plain = residue.letter in ("U" if not residue.is_dna else "T", "A", "C", "G")
    return residue.letter if plain and not residue.methyls else f"[{residue.resname}]"


def _pairs_of_strands(
    sequence: str, tokens: Sequence[str], residues: Sequence[Residue], labels: Sequence[str]
) -> int:
    """Pairs of two strands with the loop in brackets between them."""
    opening, closing = tokens.index("("), tokens.index(")")
    n_5, n_loop, n_3 = opening, closing - opening - 1, len(tokens) - 1 - closing
    if not n_5 or not n_3:
        raise ValueError(
            f"`sequence` is {shown(sequence)}: no strand {'before' if not n_5 else 'behind'} the"
            f" loop; it must be {_EXAMPLE}"
        )
    if n_5 != n_3:
        # counted from the loop
        rungs = ((n_5 - 1 - k, n_5 + n_loop + k) for k in range(min(n_5, n_3)))
        broken = [(i, j) for i, j in rungs if pair_of(residues[i], residues[j]) is None]
        if broken:
            i, j = broken[0]
            where = f"{labels[i]} and {labels[j]} are the first that do not pair"
        else:
            rest = range(n_5 - n_3) if n_5 > n_3 else range(2 * n_5 + n_loop, len(labels))
            where = f"at its other end {_run(labels, rest)} without a partner"
        raise ValueError(
            f"`sequence`: the strands before and behind the loop have {n_5} and {n_3} nucleotides;"
            f" a stem needs equal ones (counted from the loop, {where})"
        )
    return n_5


def _pairs_of_brackets(brackets: str, labels: Sequence[str]) -> int:
    """Pairs of a dot-bracket that is one stem with its loop."""
    for k, sign in enumerate(brackets, start=1):
        if sign not in "().":
            raise ValueError(
                f"`structure`: {shown(sign)}, character {k}, is none of ( ) and .; pseudoknots and"
                " strands apart are not built"
            )
    if len(brackets) != len(labels):
        raise ValueError(
            f"`structure` has {len(brackets)} characters for {len(labels)} nucleotides; it needs"
            " one for each"
        )
    pairs = _matched(brackets, labels)
    loops = [(i, j) for i, j in pairs if set(brackets[i + 1 : j]) <= {"."}]
    if len(loops) != 1:
        what = " and ".join(_run(labels, range(i + 1, j)) for i, j in loops)
        several = f"it has {len(loops)} loops, {what}; they are built one by one"
        raise ValueError(
            f"`structure` is no hairpin: {several if loops else 'it has no pair and so no stem'}"
        )
    (i, j), *_ = pairs
    for end, rest in ((5, range(i)), (3, range(j + 1, len(labels)))):
        if rest:
            raise ValueError(
                f"`structure` is no hairpin alone: {_run(labels, rest)} without a partner at the"
                f" {end}' end, where no stem gives it a place; leave it out"
            )
    for (i, j), (inner_i, inner_j) in pairwise(pairs):
        left, right = range(i + 1, inner_i), range(inner_j + 1, j)
        if left or right:
            what = " and ".join(_run(labels, side) for side in (left, right) if side)
            kind = "an internal loop" if left and right else "a bulge"
            raise ValueError(
                f"`structure` is no unbroken stem: behind the pair {labels[i]}·{labels[j]} it has"
                f" {kind}, {what}"
            )
    return len(pairs)


def _matched(brackets: str, labels: Sequence[str]) -> list[tuple[int, int]]:
    """Pairs i < j, the outermost first."""
    opened, pairs = list[int](), []
    for k, sign in enumerate(brackets):
        if sign == "(":
            opened.append(k)
        elif sign == ")":
            if not opened:
                raise ValueError(f"`structure`: the bracket at {labels[k]} closes none")
            pairs.append((opened.pop(), k))
    if opened:
        raise ValueError(f"`structure`: the bracket at {labels[opened[-1]]} is not closed")
    return sorted(pairs)


def _mismatches(residues: Sequence[Residue], labels: Sequence[str], pairs: int) -> Iterator[str]:
    for k in range(pairs):
        if pair_of(residues[k], residues[-1 - k]) is None:
            yield f"{labels[k]}·{labels[-1 - k]}"


def _run(labels: Sequence[str], rows: range) -> str:
    first, last = labels[rows[0]], labels[rows[-1]]
    return first if len(rows) == 1 else f"{first} to {last}"
