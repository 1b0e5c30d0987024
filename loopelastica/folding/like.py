"""The structure that a user names as a template: read once, its strands by length.

    FILE[:A.4-A.9] → structure → the strand that is named, or any of its loops → templates

Of a file with several models the first one counts.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence, Sized
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Final, NamedTuple

from loopelastica._arrays import Array
from loopelastica._names import safe_stem
from loopelastica.errors import StructureError
from loopelastica.folding.template import deformed
from loopelastica.molecule.hairpins import Hairpin, find_hairpins
from loopelastica.molecule.nucleotides import (
    Limits,
    Nucleotides,
    Structure,
    enumerated,
    read_structure,
)
from loopelastica.molecule.polymer import Gap
from loopelastica.molecule.selection import Like, ends_of, row_at
from loopelastica.molecule.strand_ends import flank_poses
from loopelastica.molecule.templates import (
    Template,
    counted,
    hairpin_template,
    pair_name,
    strand_template,
)

MOST: Final = 3
"""Templates that are taken where no loop is named."""
MOST_BENT: Final = 5.0
"""Energy E·L/K0 above which a hairpin loop that was not named is not like a strand: 19 of 20 loops
of four nucleotides are deformed onto each other with less than 4, onto other strands few are."""


def file_of(text: str | None) -> str | None:
    """The file that the option `like` names, if it names one."""
    return None if text is None else Like.of("like", text).file


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


def strand_templates(text: str, gap: Gap, limits: Limits) -> tuple[Template, ...]:
    """The templates of a file for any strand.

    Parameters
    ----------
    text : str
        As for the option `like`.
    gap : Gap
        Where it is to be.
    limits : Limits
        How large the file may be.

    Returns
    -------
    tuple of Template
        As for :func:`loop_templates`. Without a pair strands of the same letters, wherever they are
        in the file; else those of its hairpin loops that fit the ends.

    Raises
    ------
    StructureError
        If the file cannot be read, or has no such strand.
    """
    like, stamp = _key(text)
    if like.pair is not None:
        return _of_length((_strand(like, stamp, limits),), len(gap))
    same = tuple(_same_letters(_source(like.file, stamp, limits), gap.sequence))
    if same:
        return same
    loops = _of_length(_loops_as_strands(like, stamp, limits), len(gap))
    poses, is_dna = flank_poses(gap.before, gap.after), gap.kind == "DNA"
    fitting = deformed(loops, poses, gap.context, is_dna)
    return tuple(one.template for one in fitting if one.line.energy <= MOST_BENT)


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
    there = _loops(*_key(text), limits)
    if hairpins and not any(_of_length(there, len(hairpin)) for hairpin in hairpins):
        raise _unlike(text, "loop", there, hairpins)


def check_strands(text: str, gaps: Sequence[Gap], limits: Limits) -> None:
    """Refuse a file of which no strand fits any of those to be filled.

    Parameters
    ----------
    text : str
        As for the option `like`.
    gaps : sequence of Gap
        What is to be like it.
    limits : Limits
        How large the file may be.

    Raises
    ------
    StructureError
        As :func:`strand_templates`, or if none has as many nucleotides, or one more or less.
    """
    like, stamp = _key(text)
    if like.pair is None:
        there: Sequence[Template] = _loops_as_strands(like, stamp, limits)
    else:
        there = (_strand(like, stamp, limits),)
    if gaps and not any(strand_templates(text, gap, limits) for gap in gaps):
        raise _unlike(text, "strand", there, gaps)


def remarks(
    text: str, what: str, name: str, n: int, templates: Sequence[Template]
) -> Iterator[str]:
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

    Yields
    ------
    str
        Nothing where its template has as many nucleotides.
    """
    if not templates:
        yield f"{name}: {text} has no {what} for its {counted(n)}; it is made without template"
    elif len(templates[0]) != templates[0].made_from:
        yield (
            f"{name}: {text} has no {what} of {counted(n)}; the line of"
            f" {templates[0].made_from} is respaced, and no atoms come with it"
        )


def _unlike(text: str, what: str, there: Sequence[Sized], here: Sequence[Sized]) -> StructureError:
    own, other = (sorted({*map(len, some)}) for some in (there, here))
    has = f"its {what} has {counted(*own)}" if own else "it has no hairpin loop"
    return StructureError(
        f"{text}: {has}, what is to be like it {', '.join(map(str, other))}; a template has as"
        " many, or one more or less, and fits the ends"
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


class _Source(NamedTuple):
    """A structure, the positions of its first model, and what it is called."""

    structure: Structure
    positions_A: Array
    name: str

    @property
    def where(self) -> str:
        return self.structure.where

    @property
    def table(self) -> Nucleotides:
        return self.structure.nucleotides


@lru_cache(maxsize=4)
def _source(file: str, stamp: tuple[int, int], limits: Limits) -> _Source:
    structure = read_structure(file, limits)
    return _Source(structure, structure.positions(0), safe_stem(Path(file)))


@lru_cache(maxsize=4)
def _loops(like: Like, stamp: tuple[int, int], limits: Limits) -> tuple[Template, ...]:
    """The loop that is named, or all that may be templates."""
    source = _source(like.file, stamp, limits)
    hairpins: Sequence[Hairpin] = find_hairpins(source.structure)
    if not hairpins:
        raise StructureError(f"{source.where}: no hairpin loop; no loop can be like it")
    if like.pair is not None:
        hairpins = [_named(source, like, hairpins)]
    found, faults = [], []
    for hairpin in hairpins:
        try:
            found.append(hairpin_template(source.table, hairpin, source.positions_A, source.name))
        except StructureError as error:
            faults.append(f"{source.where}: {error}")
    if not found:
        raise StructureError(faults[0])
    return tuple(found)


def _named(source: _Source, like: Like, hairpins: Sequence[Hairpin]) -> Hairpin:
    i, j = _rows(source, like)
    for hairpin in hairpins:
        if (hairpin.stem_5[0], hairpin.stem_3[0]) == (i, j):
            return hairpin
    there = enumerated(
        [pair_name(source.table, int(h.stem_5[0]), int(h.stem_3[0])) for h in hairpins]
    )
    raise StructureError(
        f"{source.where}: {like.pair} closes no hairpin loop; the pairs that do are {there}"
    )


@lru_cache(maxsize=4)
def _strand(like: Like, stamp: tuple[int, int], limits: Limits) -> Template:
    """The strand between the two nucleotides that are named."""
    source = _source(like.file, stamp, limits)
    i, j = _rows(source, like)
    try:
        return _between(source, i, j)
    except StructureError as error:
        raise StructureError(f"{source.where}: {error}") from None


@lru_cache(maxsize=4)
def _loops_as_strands(like: Like, stamp: tuple[int, int], limits: Limits) -> tuple[Template, ...]:
    """The hairpin loops of a file, their ends by the closing nucleotides alone."""
    source = _source(like.file, stamp, limits)
    found = []
    for hairpin in find_hairpins(source.structure):
        ends = int(hairpin.stem_5[0]), int(hairpin.stem_3[0])
        with suppress(StructureError):
            found.append(_between(source, *ends))
    return tuple(found)


def _between(source: _Source, i: int, j: int) -> Template:
    return strand_template(source.table, i, j, source.positions_A, source.name)


def _same_letters(source: _Source, sequence: str) -> Iterator[Template]:
    """Strands with the letters of a sequence."""
    letters, wanted = ("".join(x).replace("T", "U") for x in (source.table.letter, sequence))
    begin = letters.find(wanted, 1)
    while 0 < begin < len(letters) - len(wanted):
        # one that goes over an end of a chain or a break, or is not whole, is no strand
        with suppress(StructureError):
            yield _between(source, begin - 1, begin + len(wanted))
        begin = letters.find(wanted, begin + 1)


def _rows(source: _Source, like: Like) -> tuple[int, int]:
    """Rows of the nucleotides of the pair that is named."""
    assert like.pair is not None
    try:
        places = ends_of(source.table, "like", like.pair)
        i, j = sorted(row_at(source.table, one, f"no loop {like.pair} is there") for one in places)
    except StructureError as error:
        raise StructureError(f"{source.where}: {error}") from None
    return i, j
