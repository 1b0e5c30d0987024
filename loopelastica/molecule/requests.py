"""Strands that a user names to be filled: ``A.6-9``, ``A.6-9=UUCG``.

First and last are those of the strand itself. With a sequence the user's word wins over the file;
without one the file must say what the strand consists of. A strand that is there is given up and
made anew.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

from loopelastica._checks import shown, texts
from loopelastica.errors import StructureError
from loopelastica.molecule.chains import Chain, called, joined
from loopelastica.molecule.components import BASES
from loopelastica.molecule.flanks import gap_between
from loopelastica.molecule.nucleotides import enumerated
from loopelastica.molecule.polymer import Gap, Monomer
from loopelastica.molecule.selection import Place, one_place, two_places

_FORM = "it must be like A.6-9 or A.6-9=UUCG"


class Request(NamedTuple):
    """A strand that a user asks for.

    Attributes
    ----------
    text : str
        As it was written.
    first, last : Place
        Its first and last nucleotide; both have the chain of the first, None where none is given.
    sequence : str
        Bases, "" where the file is to say.
    """

    text: str
    first: Place
    last: Place
    sequence: str

    @property
    def where(self) -> str:
        """What sentences begin with."""
        return f"`strands` {self.text}"


def requests(strands: Any) -> tuple[Request, ...]:
    """The strands that are asked for.

    Parameters
    ----------
    strands : str, sequence of str or None
        None or none at all: whatever is missing.

    Raises
    ------
    ValueError
        If one cannot be understood, or two of them have a nucleotide in common.

    Examples
    --------
    >>> [(str(one.first), str(one.last), one.sequence) for one in requests("A.-3-2=uu cga")]
    [('A.-3', 'A.2', 'UUCGA')]
    """
    if strands is None:
        return ()
    found = tuple(_request(text) for text in texts("strands", strands))
    for k, one in enumerate(found):
        for other in found[:k]:
            if _overlap(one, other):
                raise ValueError(f"`strands`: {other.text} and {one.text} overlap")
    return found


def _request(text: str) -> Request:
    places, equals, letters = text.partition("=")
    sequence = re.sub(r"\s", "", letters).upper()
    if equals and not sequence:
        raise ValueError(f"`strands` is {shown(text)}; {_FORM}")
    wrong = [letter for letter in sequence if letter not in BASES]
    if wrong:
        raise ValueError(
            f"`strands` is {shown(text)}; {wrong[0]!r} is no base that can be built, those are"
            " A C G U and T"
        )
    try:
        first, last = two_places("strands", places)
    except ValueError:
        single = one_place(places)
        if single is None:
            raise ValueError(f"`strands` is {shown(text)}; {_FORM}") from None
        first = last = single
    if last.chain is None:
        last = last._replace(chain=first.chain)
    elif first.chain != last.chain:
        raise ValueError(f"`strands` is {shown(text)}; a strand lies in one chain")
    if _key(last) < _key(first):
        raise ValueError(f"`strands` is {shown(text)}; a strand runs from 5' to 3'")
    return Request(" ".join(text.split()), first, last, sequence)


def _key(place: Place) -> tuple[int, str]:
    return place.number, place.icode


def _count(first: Place, last: Place) -> int | None:
    """How many nucleotides the numbers say; None where insertion codes leave it open."""
    if first == last:
        return 1
    if first.number == last.number and (first.icode or "@").isalpha():
        return ord(last.icode) - ord(first.icode) + 1
    return None if first.icode or last.icode else last.number - first.number + 1


def _overlap(one: Request, other: Request) -> bool:
    chains = {one.first.chain, other.first.chain}
    if len(chains) > 1 and None not in chains:
        return False
    return _key(one.first) <= _key(other.last) and _key(other.first) <= _key(one.last)


def with_request(chains: Sequence[Chain], request: Request) -> Gap:
    """The gap that a request makes in the chain it names.

    Parameters
    ----------
    chains : sequence of Chain
        Of one model.
    request : Request

    Returns
    -------
    Gap

    Raises
    ------
    StructureError
        If the chain, a flank or the sequence is not there, or contradicts the request.
    """
    chain, request = _chain(chains, request)
    slots = chain.slots
    begin, end = _stretch(chain, request)
    old = slots[begin:end]
    if not begin or end == len(slots):
        side = "5'" if not begin else "3'"
        raise StructureError(
            f"{request.where}: nothing stands on its {side} side in {called(chain.name)}, so it has"
            " no end there"
        )
    monomers = _monomers(request, chain, old, slots[begin - 1], slots[end])
    changed = replace(chain, slots=(*slots[:begin], *monomers, *slots[end:]))
    i, j = begin - 1, begin + len(monomers)
    for side, k, step in (("5'", i, -1), ("3'", j, 1)):
        if not changed.slots[k].atoms_A:
            raise StructureError(
                f"{request.where}: {changed.slots[k].label} on its {side} side is missing too; name"
                " the strand as a whole"
            )
        while 0 <= k < len(changed.slots) and not changed.slots[k].usable:
            k += step
        if not 0 <= k < len(changed.slots):
            raise StructureError(
                f"{request.where}: no nucleotide on its {side} side has C4' and four backbone"
                " atoms, so it has no end there"
            )
        i, j = (k, j) if step < 0 else (i, k)
    gap = gap_between(changed, i, j, given=bool(request.sequence))
    there = tuple(one for one in old if one.atoms_A)
    remarks = [*gap.remarks]
    if there:
        remarks.append(
            f"{gap.name} is there and is made anew: {enumerated([o.label for o in there])}"
        )
    filed = "".join(one.letter for one in old)
    if request.sequence and filed and filed != request.sequence:
        remarks.append(f"{request.where}: the file has {filed} there; the given sequence is taken")
    return replace(gap, replaces=there, remarks=tuple(remarks))


def _chain(chains: Sequence[Chain], request: Request) -> tuple[Chain, Request]:
    """The chain that is meant; "A6-9" means chain A too, as hairpins are named."""
    names = {chain.name for chain in chains}
    first = request.first
    if first.chain is None and first.name in names:
        first = first._replace(chain=first.name, name="")
        request = request._replace(first=first, last=request.last._replace(chain=first.chain))
    if first.chain is None:
        found = [chain for chain in chains if _has(chain, request)] if len(chains) > 1 else chains
        if len(found) != 1:
            which = enumerated(sorted(names))
            raise StructureError(
                f"{request.where}: name the chain too, as in {chains[0].name}.{request.text}; the"
                f" chains of nucleotides are {which}"
            )
        return found[0], request
    found = [chain for chain in chains if chain.name == first.chain]
    if not found:
        raise StructureError(
            f"{request.where}: there is no chain {first.chain} of nucleotides; there is"
            f" {enumerated(sorted(name or repr(name) for name in names))}"
        )
    if len(found) > 1:
        found = [chain for chain in found if _has(chain, request)] or found[:1]
    # a record that contradicts the file is no reason: the user's word wins
    if found[0].fault and (len(found) > 1 or not _unique(found[0])):
        raise StructureError(f"{request.where}: {found[0].fault}")
    return found[0], request


def _unique(chain: Chain) -> bool:
    return len({(one.number, one.icode) for one in chain.slots}) == len(chain.slots)


def _has(chain: Chain, request: Request) -> bool:
    keys = [(one.number, one.icode) for one in chain.slots]
    return bool(keys) and min(keys) <= _key(request.first) and _key(request.last) <= max(keys)


def _stretch(chain: Chain, request: Request) -> tuple[int, int]:
    """Where the strand lies among the nucleotides of the chain, which may all be missing."""
    keys = [(one.number, one.icode) for one in chain.slots]
    first, last = _key(request.first), _key(request.last)
    if first in keys and last in keys and keys.index(first) <= keys.index(last):
        return keys.index(first), keys.index(last) + 1
    inside = [k for k, key in enumerate(keys) if first <= key <= last]
    if inside:
        begin, end = inside[0], inside[-1] + 1
        if end - begin != len(inside):
            raise StructureError(
                f"{request.where}: the numbers of {called(chain.name)} do not run from 5' to 3'"
                " there"
            )
        return begin, end
    places = [k for k in range(1, len(keys)) if keys[k - 1] < first and last < keys[k]]
    if not places:
        lowest, highest = chain.slots[0], chain.slots[-1]
        raise StructureError(
            f"{request.where}: {called(chain.name)} runs from {lowest.label} to {highest.label},"
            " so the strand has no nucleotide on one of its sides"
        )
    return places[0], places[0]


def _monomers(
    request: Request, chain: Chain, old: Sequence[Monomer], before: Monomer, after: Monomer
) -> list[Monomer]:
    """What is to be built, without atoms."""
    first, last, sequence = request.first, request.last, request.sequence
    count = _count(first, last)
    complete = bool(old) and (old[0].number, old[0].icode) == _key(first)
    complete = complete and (old[-1].number, old[-1].icode) == _key(last)
    if not sequence:
        gap_inside = any(
            not joined(a, b) and b.number - a.number > 1
            for a, b in pairwise(old)
            if not chain.source
        )
        if not complete or gap_inside:
            raise StructureError(
                f"{request.where}: the file does not say what its nucleotides are; give the"
                f" sequence, as in {first}-{last.number}{last.icode}="
                f"{'N' * min(count or 4, 12)}"
            )
        return [replace(one, atoms_A={}) for one in old]
    if complete and len(old) == len(sequence):
        places = [(one.number, one.icode) for one in old]
    else:
        places = _numbered(request, count)
    _check_beside(request, chain, places, before, after)
    kind = _is_dna(request, old, before, after)
    records = [one.record for one in old] if len(old) == len(sequence) else [None] * len(places)
    return [
        Monomer(chain.name, number, icode, f"D{letter}" if kind else letter, letter, kind, record)
        for (number, icode), letter, record in zip(places, sequence, records, strict=True)
    ]


def _numbered(request: Request, count: int | None) -> list[tuple[int, str]]:
    first, last, sequence = request.first, request.last, request.sequence
    numbers = last.number - first.number + 1
    if count is None and numbers != len(sequence):
        raise StructureError(
            f"{request.where}: with insertion codes the numbers do not say how many nucleotides"
            f" these are, and the sequence has {len(sequence)}; only {numbers} have numbers"
        )
    if count is not None and count != len(sequence):
        raise StructureError(
            f"{request.where}: the numbers say {count} nt, and the sequence has {len(sequence)}"
        )
    if first.number == last.number:
        codes = range(ord(first.icode or " "), ord(first.icode or " ") + len(sequence))
        return [(first.number, chr(code).strip()) for code in codes]
    between = [(number, "") for number in range(first.number + 1, last.number)]
    return [_key(first), *between, _key(last)]


def _check_beside(
    request: Request,
    chain: Chain,
    places: list[tuple[int, str]],
    before: Monomer,
    after: Monomer,
) -> None:
    """Refuse a strand whose neighbours by number are missing too, where only numbers tell."""
    if chain.source:
        return
    left = places[0][0] - before.number > 1
    right = after.number - places[-1][0] > 1
    if left or right:
        number = places[0][0] - 1 if left else places[-1][0] + 1
        prefix = f"{chain.name}." if chain.name else ""
        raise StructureError(
            f"{request.where}: {prefix}{number} beside it is not in the file; name the strand as a"
            f" whole, between {before.label} and {after.label}"
        )


def _is_dna(request: Request, old: Sequence[Monomer], before: Monomer, after: Monomer) -> bool:
    """Kind of a given sequence: that of its neighbours; of two kinds the letters choose."""
    kinds = {one.is_dna for one in old} or {before.is_dna, after.is_dna}
    if len(kinds) > 1:
        return "T" in request.sequence or ("U" not in request.sequence and before.is_dna)
    (is_dna,) = kinds
    if "T" in request.sequence and not is_dna:
        raise StructureError(
            f"{request.where}: T is a base of DNA, and {before.label} and {after.label} are RNA;"
            " write U"
        )
    return is_dna
