"""The structure that a user names as a template: read once, its strands by length.

    FILE[:A.4-A.9] → structure → the strand that is named, or any of its loops → templates

Of a file with several models the first one counts.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Final

from loopelastica._names import safe_stem
from loopelastica.errors import StructureError
from loopelastica.molecule.hairpins import Hairpin, find_hairpins
from loopelastica.molecule.nucleotides import Limits, Structure, enumerated, read_structure
from loopelastica.molecule.selection import Like, ends_of, row_at
from loopelastica.molecule.templates import (
    Template,
    hairpin_template,
    pair_name,
    strand_template,
)

MOST: Final = 3
"""Templates that are taken where no loop is named."""


def loop_templates(text: str, n: int, limits: Limits) -> tuple[Template, ...]:
    """The templates of a file for a hairpin loop of n nucleotides.

    Parameters
    ----------
    text : str
        As for the option `like`.
    n : int
        How many nucleotides the loop has.
    limits : Limits
        How large the file may be.

    Returns
    -------
    tuple of Template
        Those of equal length; where there is none, those of one more or less, respaced.

    Raises
    ------
    StructureError
        If the file cannot be read, or has no such loop, or none that is whole on a regular stem.
    """
    return _of_length(_loops(*_key(text), limits), n)


def strand_templates(text: str, n: int, sequence: str, limits: Limits) -> tuple[Template, ...]:
    """The templates of a file for any strand of n nucleotides.

    Parameters
    ----------
    text : str
        As for the option `like`.
    n : int
        How many nucleotides the strand has.
    sequence : str
        Its letters and those of the two beside it.
    limits : Limits
        How large the file may be.

    Returns
    -------
    tuple of Template
        As for :func:`loop_templates`. Without a pair strands of the same letters, wherever they are
        in the file; else its hairpin loops.

    Raises
    ------
    StructureError
        If the file cannot be read, or has no such strand.
    """
    like, stamp = _key(text)
    if like.pair is not None:
        return _of_length((_strand(like, stamp, limits),), n)
    structure = _structure(like.file, stamp, limits)
    return tuple(_same_letters(structure, n, sequence, like)) or _of_length(
        _loops_as_strands(like, stamp, limits), n
    )


def check_loops(text: str, hairpins: Sequence[Hairpin], limits: Limits) -> None:
    """Refuse a file of which no loop fits any hairpin.

    Parameters
    ----------
    text : str
        As for the option `like`.
    hairpins : sequence of Hairpin
        What is to be like it.
    limits : Limits
        How large the file may be.

    Raises
    ------
    StructureError
        As :func:`loop_templates`, or if none has as many nucleotides, or one more or less.
    """
    lengths = [len(template) for template in _loops(*_key(text), limits)]
    _check(text, "loop", lengths, [len(hairpin) for hairpin in hairpins])


def check_strands(text: str, sequences: Sequence[str], limits: Limits) -> None:
    """Refuse a file of which no strand fits any of those to be filled.

    Parameters
    ----------
    text : str
        As for the option `like`.
    sequences : sequence of str
        Letters of each strand with the two beside it.
    limits : Limits
        How large the file may be.

    Raises
    ------
    StructureError
        As :func:`strand_templates`, or if none has as many nucleotides, or one more or less.
    """
    like, stamp = _key(text)
    there = (
        _loops_as_strands(like, stamp, limits)
        if like.pair is None
        else (_strand(like, stamp, limits),)
    )
    if any(strand_templates(text, len(one) - 2, one, limits) for one in sequences):
        return
    _check(text, "strand", [len(one) for one in there], [len(one) - 2 for one in sequences])


def remark(text: str, what: str, name: str, n: int, templates: Sequence[Template]) -> str | None:
    """What is said of a strand that is not quite like its template.

    Parameters
    ----------
    text : str
        As for the option `like`.
    what, name : str
        "loop" or "strand", and what this one is called.
    n : int
        Its nucleotides.
    templates : sequence of Template
        What was found for it.

    Returns
    -------
    str or None
        None where its template has as many nucleotides.
    """
    if not templates:
        return f"{name}: {text} has no {what} for its {n} nucleotides; it is made without template"
    first = templates[0]
    if len(first) == first.made_from:
        return None
    return (
        f"{name}: {text} has no {what} of {n} nucleotides; the line of {first.made_from} is"
        " respaced, and no atoms come with it"
    )


def _check(text: str, what: str, there: Sequence[int], here: Sequence[int]) -> None:
    if not here or any(abs(a - b) <= 1 for a in there for b in here):
        return
    own, other = (", ".join(map(str, sorted({*lengths}))) for lengths in (there, here))
    raise StructureError(
        f"{text}: its {what} has {own or 'no'} nucleotides, what is to be like it {other}; a"
        " template has as many, or one more or less"
    )


def _of_length(templates: Sequence[Template], n: int) -> tuple[Template, ...]:
    equal = tuple(one for one in templates if len(one) == n)
    return equal or tuple(one.respaced(n) for one in templates if abs(len(one) - n) == 1)


def _key(text: str) -> tuple[Like, tuple[int, int]]:
    """What is asked for, and what changes when the file does."""
    like = Like.of("like", text)
    try:
        state = os.stat(like.file)
    except (OSError, ValueError):
        return like, (0, 0)
    return like, (state.st_mtime_ns, state.st_size)


@lru_cache(maxsize=4)
def _structure(file: str, stamp: tuple[int, int], limits: Limits) -> Structure:
    return read_structure(file, limits)


@lru_cache(maxsize=4)
def _loops(like: Like, stamp: tuple[int, int], limits: Limits) -> tuple[Template, ...]:
    """The loop that is named, or all that may be templates."""
    structure = _structure(like.file, stamp, limits)
    hairpins: Sequence[Hairpin] = find_hairpins(structure)
    if not hairpins:
        raise StructureError(f"{structure.where}: no hairpin loop; no loop can be like it")
    if like.pair is not None:
        hairpins = [_named(structure, like, hairpins)]
    found, faults = [], []
    for hairpin in hairpins:
        try:
            found.append(
                hairpin_template(
                    structure.nucleotides, hairpin, structure.positions(0), _called(like)
                )
            )
        except StructureError as error:
            faults.append(f"{structure.where}: {error}")
    if not found:
        raise StructureError(faults[0])
    return tuple(found)


def _named(structure: Structure, like: Like, hairpins: Sequence[Hairpin]) -> Hairpin:
    i, j = _rows(structure, like)
    for hairpin in hairpins:
        if (hairpin.stem_5[0], hairpin.stem_3[0]) == (i, j):
            return hairpin
    there = enumerated(
        [pair_name(structure.nucleotides, int(h.stem_5[0]), int(h.stem_3[0])) for h in hairpins]
    )
    raise StructureError(
        f"{structure.where}: {like.pair} closes no hairpin loop; the pairs that do are {there}"
    )


@lru_cache(maxsize=4)
def _strand(like: Like, stamp: tuple[int, int], limits: Limits) -> Template:
    """The strand between the two nucleotides that are named."""
    structure = _structure(like.file, stamp, limits)
    i, j = _rows(structure, like)
    try:
        return _between(structure, i, j, like)
    except StructureError as error:
        raise StructureError(f"{structure.where}: {error}") from None


@lru_cache(maxsize=4)
def _loops_as_strands(like: Like, stamp: tuple[int, int], limits: Limits) -> tuple[Template, ...]:
    """The hairpin loops of a file, their ends by the closing nucleotides alone."""
    structure = _structure(like.file, stamp, limits)
    found = []
    for hairpin in find_hairpins(structure):
        ends = int(hairpin.stem_5[0]), int(hairpin.stem_3[0])
        with suppress(StructureError):
            found.append(_between(structure, *ends, like))
    return tuple(found)


def _between(structure: Structure, i: int, j: int, like: Like) -> Template:
    return strand_template(structure.nucleotides, i, j, structure.positions(0), _called(like))


def _same_letters(structure: Structure, n: int, sequence: str, like: Like) -> Iterator[Template]:
    """Strands with the letters of a sequence, but for those beside it."""
    letters = "".join(structure.nucleotides.letter).replace("T", "U")
    wanted = sequence[1:-1].replace("T", "U")
    begin = letters.find(wanted, 1)
    while 0 < begin < len(letters) - n:
        # one that goes over an end of a chain or a break, or is not whole, is no strand
        with suppress(StructureError):
            yield _between(structure, begin - 1, begin + n, like)
        begin = letters.find(wanted, begin + 1)


def _rows(structure: Structure, like: Like) -> tuple[int, int]:
    """Rows of the nucleotides of the pair that is named."""
    assert like.pair is not None
    table = structure.nucleotides
    try:
        places = ends_of(table, "like", like.pair)
        i, j = sorted(row_at(table, one, f"no loop {like.pair} is there") for one in places)
    except StructureError as error:
        raise StructureError(f"{structure.where}: {error}") from None
    return i, j


def _called(like: Like) -> str:
    """What the structure is called in the name of a shape."""
    return safe_stem(Path(like.file))
