"""Pairs and loops that a user names, where other data show what the coordinates do not.

A place is a chain and a number, ``A.12``, with its insertion code, ``A.3B``; residue names may be
given as they are printed, ``A.DG3^B``. The chain is left out where the file has none, and after the
hyphen where it is the same one: ``A.12-A.25``, ``A.13-24``, ``12-25``.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from loopelastica._checks import file_name, shown, texts
from loopelastica._checks import text as _text
from loopelastica.errors import StructureError
from loopelastica.molecule.nucleotides import Nucleotides, enumerated
from loopelastica.molecule.pairs import BRACKETS

_PLACE = re.compile(
    r"(?:(?P<chain>.*)\.)?(?P<name>[A-Za-z0-9+]*[A-Za-z+])?(?P<number>-?\d{1,10})\^?(?P<icode>[A-Za-z]?)"
)
# The hyphen between two places is the first one after a number.
_TWO = re.compile(r"(.*?\d[A-Za-z]?)\s*[-–]\s*(.+)")
_LONGEST = 100
_NO_CHAIN = re.compile(r"(^|[-–]\s*)_\.?(?=-?\d)")
_SEPARATORS = re.compile(r"[\s&+|]")


class Place(NamedTuple):
    """A nucleotide as a user names it; `chain` is None where none is given."""

    chain: str | None
    name: str
    number: int
    icode: str

    def __str__(self) -> str:
        """Return it as it is written, such as "A.12"."""
        chain = f"{self.chain}." if self.chain else ""
        return f"{chain}{self.name}{self.number}{self.icode}"


def two_places(argument: str, text: str) -> tuple[Place, Place]:
    """Two places joined by a hyphen.

    Parameters
    ----------
    argument : str
        Name of the option that `text` comes from.
    text : str
        Such as "A.12-A.25".

    Returns
    -------
    first, last : Place

    Raises
    ------
    ValueError
        If `text` is nothing of that form; the message names `argument`.

    Examples
    --------
    >>> [str(place) for place in two_places("pair", "A.12-A.25")]
    ['A.12', 'A.25']
    >>> [str(place) for place in two_places("loop", "A.-3-4B")]
    ['A.-3', '4B']
    """
    halves = _TWO.fullmatch(text.strip()) if len(text) <= _LONGEST else None
    matches = [_PLACE.fullmatch(half.strip()) for half in halves.groups()] if halves else []
    places = [
        Place(m["chain"], m["name"] or "", int(m["number"]), m["icode"]) for m in matches if m
    ]
    if len(places) != 2:
        raise ValueError(f"`{argument}` is {shown(text)}; it must be like A.12-A.25 or A.12-25")
    return places[0], places[1]


class Like(NamedTuple):
    """What a user wants a strand to be like.

    Attributes
    ----------
    text : str
        As it was written.
    file : str
        The structure.
    pair : str or None
        The nucleotides before and after the strand, such as "A.4-A.9"; None: any of the file.
    """

    text: str
    file: str
    pair: str | None

    @classmethod
    def of(cls, argument: str, text: str) -> Like:
        """Read "FILE" or "FILE:A.4-A.9".

        A colon may be part of the file's name: what is after the last one counts as a pair where it
        looks like one and no file has the whole name. ValueError that names `argument` where it is
        none, and the file is there.

        >>> Like.of("like", "1zih.pdb:A.4-A.9")[1:], Like.of("like", "C:/1zih.pdb")[1:]
        (('1zih.pdb', 'A.4-A.9'), ('C:/1zih.pdb', None))
        """
        file, colon, pair = text.rpartition(":")
        if not (colon and file) or Path(text).exists():
            return cls(text, text, None)
        pair = _NO_CHAIN.sub(r"\1", pair.strip())
        try:
            two_places(argument, pair)
        except ValueError:
            if not Path(file).is_file():
                return cls(text, text, None)
            raise ValueError(
                f"`{argument}` is {shown(text)}; after the file comes the closing pair of its"
                " loop, like A.4-A.9"
            ) from None
        return cls(text, file, pair)


def likeness(name: str, value: Any) -> str:
    """The check of what a strand is to be like: "FILE" or "FILE:A.4-A.9"."""
    return Like.of(name, file_name(name, value)).text


def one_place(text: str) -> Place | None:
    """A single place; None where the text is none. What may be two places is to be read so first.

    >>> str(one_place("A.-3")), one_place("A.")
    ('A.-3', None)
    """
    m = _PLACE.fullmatch(text.strip()) if len(text) <= _LONGEST else None
    return Place(m["chain"], m["name"] or "", int(m["number"]), m["icode"]) if m else None


def places(argument: str, value: Any) -> tuple[str, ...]:
    """One text or a sequence of them, each of two places; ValueError that names `argument` else."""
    found = texts(argument, value)
    for text in found:
        two_places(argument, text)
    return found


def ends_of(nucleotides: Nucleotides, argument: str, text: str) -> tuple[Place, Place]:
    """Two places with their chains: the second one is in the chain of the first if none is given.

    The name of a hairpin, such as A6-9, is understood too, unless A is the base of a nucleotide 6.

    Parameters
    ----------
    nucleotides : Nucleotides
        Where to look for the chain.
    argument, text : str
        As for :func:`two_places`.

    Returns
    -------
    first, last : Place

    Raises
    ------
    ValueError
        If `text` cannot be understood, or names chains as if they were bases.
    """
    first, last = two_places(argument, text)
    chains = nucleotides.chain.tolist()
    named_chain = first.chain is None and first.name in chains
    if named_chain and not rows_at(nucleotides, first):
        first = first._replace(chain=first.name, name="")
    if last.chain is None:
        if last.name in chains and not rows_at(nucleotides, last._replace(chain=first.chain)):
            written = f"{first}-{last.name}.{last.number}{last.icode}"
            raise ValueError(f"`{argument}` is {text!r}; with chains it is written {written}")
        last = last._replace(chain=first.chain)
    return first, last


def rows_at(nucleotides: Nucleotides, place: Place) -> list[int]:
    """Rows of the nucleotides at a place: none where it is absent, several where it is ambiguous.

    Parameters
    ----------
    nucleotides : Nucleotides
        Where to look.
    place : Place
        A residue name, where given, must be the one of the file.

    Returns
    -------
    list of int
    """
    here = (nucleotides.resid == place.number) & (nucleotides.icode == place.icode)
    if place.chain is not None:
        here &= nucleotides.chain == place.chain
    if place.name:
        here &= nucleotides.resname == place.name
    return [int(row) for row in np.flatnonzero(here)]


def row_at(nucleotides: Nucleotides, place: Place, consequence: str) -> int:
    """The one row at a place.

    Parameters
    ----------
    nucleotides : Nucleotides
        Where to look.
    place : Place
        Which nucleotide.
    consequence : str
        What follows if it is not there: the end of the message.

    Returns
    -------
    int

    Raises
    ------
    StructureError
        If there is none, or more than one.
    """
    rows = rows_at(nucleotides, place)
    if len(rows) > 1:
        labels = " and ".join(nucleotides.label(row) for row in rows[:2])
        raise StructureError(f"{place} may be {labels}; {consequence}")
    if not rows:
        raise StructureError(f"{_absence(nucleotides, place)}; {consequence}")
    return rows[0]


def _absence(nucleotides: Nucleotides, place: Place) -> str:
    """That nothing is at a place, and which chains there are where it names none of them."""
    sentence = f"there is no nucleotide {place}"
    chains = list(dict.fromkeys(nucleotides.chain.tolist()))
    if place.chain is None or place.chain in chains:
        return sentence
    named = [chain for chain in chains if chain]
    return (
        f"{sentence}, {f'the chains are {enumerated(named)}' if named else 'no chain has a name'}"
    )


def named_pairs(nucleotides: Nucleotides, texts: Sequence[str]) -> list[tuple[int, int]]:
    """Rows i < j of pairs such as "A.12-A.25".

    Parameters
    ----------
    nucleotides : Nucleotides
        Where to look.
    texts : sequence of str
        The pairs.

    Returns
    -------
    list of (int, int)

    Raises
    ------
    ValueError
        If a text is no pair.
    StructureError
        If a nucleotide is not in the structure, or two pairs share one.
    """
    pairs: list[tuple[int, int]] = []
    for text in texts:
        ends = ends_of(nucleotides, "pair", text)
        i, j = sorted(row_at(nucleotides, end, f"`pair` {text} cannot be made") for end in ends)
        if i == j or any({i, j} & set(other) for other in pairs):
            raise StructureError(f"`pair` {text}: a nucleotide pairs with one other only")
        pairs.append((i, j))
    return pairs


def brackets(argument: str, value: Any) -> str:
    """Dot-bracket notation without what separates chains; ValueError that names `argument` else."""
    text = _SEPARATORS.sub("", _text(argument, value))
    _pairs_of(argument, text)
    return text


def bracket_pairs(nucleotides: Nucleotides, text: str) -> NDArray[np.int64]:
    """Pairs (m, 2), i < j, of a secondary structure in dot-bracket notation.

    Parameters
    ----------
    nucleotides : Nucleotides
        Table of n nucleotides.
    text : str
        A character per nucleotide in the order of the file: ``( [ { < A B C`` open, ``) ] } > a b
        c`` close, any other stays single. Spaces and ``& + |`` between chains do not count.

    Returns
    -------
    (m, 2) array of int

    Raises
    ------
    ValueError
        If `text` is no text, or a bracket has no partner.
    StructureError
        If the length is not the number of nucleotides.
    """
    text = brackets("dot_bracket", text)
    if len(text) != len(nucleotides):
        raise StructureError(
            f"`dot_bracket` has {len(text)} characters for {len(nucleotides)} nucleotides; it needs"
            " one for each, such as ((((....))))"
        )
    return np.array(_pairs_of("dot_bracket", text), dtype=np.int64).reshape(-1, 2)


def _pairs_of(argument: str, text: str) -> list[tuple[int, int]]:
    opening = {a: k for k, (a, _) in enumerate(BRACKETS)}
    closing = {b: k for k, (_, b) in enumerate(BRACKETS)}
    open_rows: list[list[int]] = [[] for _ in BRACKETS]
    pairs = []
    form = "it must be like ((((....))))"
    for row, character in enumerate(text):
        if character in opening:
            open_rows[opening[character]].append(row)
        elif character in closing:
            if not open_rows[closing[character]]:
                raise ValueError(
                    f"`{argument}`: {character!r} at place {row + 1} closes nothing; {form}"
                )
            pairs.append((open_rows[closing[character]].pop(), row))
    unclosed = sorted(row for rows in open_rows for row in rows)
    if unclosed:
        row = unclosed[0]
        raise ValueError(f"`{argument}`: {text[row]!r} at place {row + 1} is not closed; {form}")
    return sorted(pairs)
