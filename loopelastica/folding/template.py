"""Templates: strands of another structure, chosen, and deformed onto the ends at hand.

    FILE[:A.4-A.9] → structure → templates of n nucleotides → chains between the ends, best first

Of a hairpin loop the ends are by the whole stem, of any other strand by the nucleotide on each of
its sides. Without a pair every loop of the file is a template, those of the most similar sequence
first, then those that are deformed least.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Final

import numpy as np

from loopelastica._arrays import Record
from loopelastica._names import safe_stem
from loopelastica.errors import StructureError
from loopelastica.folding.lines import ChainLine
from loopelastica.molecule.ends import ClosingPoses
from loopelastica.molecule.hairpins import Hairpin, find_hairpins
from loopelastica.molecule.nucleotides import Limits, Structure, enumerated, read_structure
from loopelastica.molecule.polymer import Monomer
from loopelastica.molecule.selection import Like, ends_of, row_at
from loopelastica.molecule.templates import Template, hairpin_template, strand_template
from loopelastica.rod.chain import deform_batch

MOST: Final = 3
"""Templates that are taken of a file where none is named."""
PURINES: Final = "AG"
# weights of a letter that differs: closing pair, first and last of the loop, others; and of one
# that is of the same kind still
_CLOSING, _OUTER, _INNER, _SAME_KIND = 0.25, 1.5, 1.0, 0.6


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Deformed(Record):
    """A template on the ends of another strand.

    Attributes
    ----------
    template : Template
    line : ChainLine
        In the coordinates of these ends.
    identity : float
        Share of the strand's letters that are the template's; 0 where the numbers differ.
    """

    template: Template
    line: ChainLine
    identity: float

    @property
    def shape(self) -> str:
        """What the line is called, such as "like 1zih A.4-A.9"."""
        return self.template.name

    @property
    def carried(self) -> tuple[Monomer, ...]:
        """The template's nucleotides where the line takes them; empty for a respaced one."""
        return self.template.carried(self.line.nodes_A, self.line.rotations, self.line.poses)

    def __repr__(self) -> str:
        return f"<Deformed {self.shape}: energy {self.line.energy:.3g}>"


def deformed(
    templates: Sequence[Template], poses: ClosingPoses, sequence: str, is_dna: bool
) -> list[Deformed]:
    """Templates of equal length deformed onto ends, the most similar first, then the least bent.

    Parameters
    ----------
    templates : sequence of Template
        Of n nucleotides each.
    poses : ClosingPoses
        Where the ideal strands have the nucleotides before and after.
    sequence : str
        Letters of the strand with the two beside it.
    is_dna : bool
        Kind of its ends.

    Returns
    -------
    list of Deformed
        Without those that cannot be deformed so far.
    """
    if not templates:
        return []
    shapes = [template.shape for template in templates]
    batch = deform_batch(
        np.array([shape.steps_A for shape in shapes]),
        np.array([shape.end_frame for shape in shapes]),
        poses.position_A,
        poses.rotation,
    )
    found = [
        Deformed(
            template,
            ChainLine(
                template.shape, poses, is_dna, batch.nodes[k], batch.rotations[k],
                float(batch.energy[k]), float(batch.residual[k]), bool(batch.stable[k]),
            ),
            _identity(template, sequence),
        )
        for k, template in enumerate(templates)
        if batch.converged[k]
    ]  # fmt: skip
    found.sort(key=lambda one: (difference(one.template.shape.sequence, sequence), one.line.energy))
    return found


def difference(a: str, b: str) -> float:
    """How different two sequences are, closing nucleotides included; those of other lengths alike.

    >>> difference("CGAAAG", "CGAAAG"), difference("CGCAAG", "CGAAAG"), difference("C", "CG")
    (0.0, 1.0, 0.0)
    """
    if len(a) != len(b):
        return 0.0
    n, total = len(a), 0.0
    for k, (x, y) in enumerate(zip(a.replace("T", "U"), b.replace("T", "U"), strict=True)):
        weight = _CLOSING if k in (0, n - 1) else _OUTER if k in (1, n - 2) else _INNER
        kept = (x in PURINES) == (y in PURINES)
        total += 0.0 if x == y else weight * (_SAME_KIND if kept else 1.0)
    return total


def _identity(template: Template, sequence: str) -> float:
    own, other = template.shape.sequence[1:-1], sequence[1:-1].replace("T", "U")
    if len(own) != len(other):
        return 0.0
    return sum(a == b for a, b in zip(own, other, strict=True)) / len(own)


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


def loop_lengths(text: str, limits: Limits) -> tuple[int, ...]:
    """How many nucleotides the loops of a file have that may be templates; raises as above."""
    return tuple(sorted({len(template) for template in _loops(*_key(text), limits)}))


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
        As for :func:`loop_templates`. Without a pair only strands whose letters are the same.

    Raises
    ------
    StructureError
        If the file cannot be read, or has no such strand.
    """
    like, stamp = _key(text)
    if like.pair is not None:
        return _of_length((_strand(like, stamp, limits),), n)
    structure = _structure(like.file, stamp, limits)
    return tuple(_same_letters(structure, n, sequence))


def strand_length(text: str, limits: Limits) -> int | None:
    """How many nucleotides a named strand has; None where none is named; raises as above."""
    like, stamp = _key(text)
    if like.pair is not None:
        return len(_strand(like, stamp, limits))
    _structure(like.file, stamp, limits)
    return None


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
    there = enumerated([_pair(structure, *h.stem_5[:1], *h.stem_3[:1]) for h in hairpins])
    raise StructureError(
        f"{structure.where}: {like.pair} closes no hairpin loop; the pairs that do are {there}"
    )


@lru_cache(maxsize=4)
def _strand(like: Like, stamp: tuple[int, int], limits: Limits) -> Template:
    """The strand between the two nucleotides that are named."""
    structure = _structure(like.file, stamp, limits)
    i, j = _rows(structure, like)
    try:
        return strand_template(structure.nucleotides, i, j, structure.positions(0), _called(like))
    except StructureError as error:
        raise StructureError(f"{structure.where}: {error}") from None


def _same_letters(structure: Structure, n: int, sequence: str) -> Iterator[Template]:
    """Strands with the letters of a sequence, but for those beside it."""
    table = structure.nucleotides
    letters = "".join(table.letter).replace("T", "U")
    wanted = sequence[1:-1].replace("T", "U")
    begin = letters.find(wanted, 1)
    while 0 < begin < len(letters) - n:
        # one that goes over an end of a chain or a break, or is not whole, is no strand
        with suppress(StructureError):
            yield strand_template(
                table, begin - 1, begin + n, structure.positions(0), safe_stem(Path(structure.name))
            )
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


def _pair(structure: Structure, i: int, j: int) -> str:
    """A pair as it is written, such as "A.4-A.9"."""
    table = structure.nucleotides
    chain = f"{table.chain[i]}." if table.chain[i] else ""
    return f"{chain}{table.number(i)}-{chain}{table.number(j)}"


def _called(like: Like) -> str:
    """What the structure is called in the name of a shape."""
    return safe_stem(Path(like.file))
