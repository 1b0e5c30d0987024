"""Nucleotides of a scadnano design in order: where each is drawn, and across from which other."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.errors import StructureError
from loopelastica.nanostructures.scadnano.file import File

Ints = NDArray[np.int64]

NOT_GIVEN = "?N"
"""What stands in a sequence for a base that the design leaves open."""


class Layout(NamedTuple):
    """Nucleotides strand by strand, each from 5' to 3'; arrays over n of them."""

    strand: Ints
    drawn: NDArray[np.str_]
    """"domain", "loopout" or "extension"."""
    helix: Ints
    """Number of the helix; −1 for none."""
    forward: NDArray[np.bool_]
    offset: Ints
    rank: Ints
    """0 for the base of an offset itself, 1, 2, … for insertions, which go before it."""
    base: NDArray[np.str_]
    label: tuple[str, ...]
    changes: dict[tuple[int, int], dict[bool, int]]
    """By helix and offset where bases are inserted or deleted: their number by direction."""


class _Stretch(NamedTuple):
    """A domain, a loopout or an extension."""

    strand: int
    drawn: str
    helix: int
    forward: bool
    offset: Ints
    rank: Ints
    base: str
    label: list[str]


def layout(file: File) -> Layout:
    """Put the nucleotides of a design in order.

    Raises
    ------
    StructureError
        If a sequence has what is no base of DNA.
    """
    changes: dict[tuple[int, int], dict[bool, int]] = {}
    stretches = [
        _stretch(file, number, part, changes)
        for number, strand in enumerate(file.strands)
        for part in strand.domains
    ]
    counts = [len(stretch.base) for stretch in stretches]
    strand, drawn, helix, forward, offset, rank, base, label = zip(*stretches, strict=True)
    return Layout(
        strand=np.repeat(strand, counts),
        drawn=np.repeat(drawn, counts),
        helix=np.repeat(helix, counts),
        forward=np.repeat(forward, counts),
        offset=np.concatenate(offset),
        rank=np.concatenate(rank),
        base=np.array(list("".join(base))),
        label=tuple(text for texts in label for text in texts),
        changes=changes,
    )


def _stretch(
    file: File, number: int, part: Any, changes: dict[tuple[int, int], dict[bool, int]]
) -> _Stretch:
    count = part.dna_length()
    base = part.dna_sequence or NOT_GIVEN[0] * count
    if odd := base.strip("ACGT" + NOT_GIVEN):
        what = "RNA, whose helices have another geometry" if odd[0] == "U" else "no base of DNA"
        raise StructureError(
            f"{file.name}: {file.strands[number].name} has {odd[0]!r} in its sequence; that is"
            f" {what}"
        )
    if not hasattr(part, "helix"):
        drawn = "loopout" if hasattr(part, "length") else "extension"
        nowhere = np.zeros(count, dtype=np.int64)
        label = [f"{drawn} nucleotide {k} of {count}" for k in range(1, count + 1)]
        return _Stretch(number, drawn, -1, True, nowhere, nowhere, base, label)
    offset, rank = _offsets(part, changes)
    label = [
        f"helix {part.helix}, offset {at}" + (f", insertion {k}" if k else "")
        for at, k in zip(offset.tolist(), rank.tolist(), strict=True)
    ]
    return _Stretch(number, "domain", part.helix, part.forward, offset, rank, base, label)


def _offsets(domain: Any, changes: dict[tuple[int, int], dict[bool, int]]) -> tuple[Ints, Ints]:
    """Offset and rank of each nucleotide of a domain, from 5' to 3'."""
    count = np.ones(domain.end - domain.start, dtype=np.int64)
    for at, more in domain.insertions:
        count[at - domain.start] += more
    for at in domain.deletions:
        count[at - domain.start] = 0
    for at in (*domain.deletions, *(at for at, _ in domain.insertions)):
        changes.setdefault((domain.helix, at), {})[domain.forward] = int(count[at - domain.start])
    offset = np.repeat(np.arange(domain.start, domain.end), count)
    rank = np.repeat(np.cumsum(count), count) - 1 - np.arange(len(offset))
    return (offset, rank) if domain.forward else (offset[::-1], rank[::-1])


def partners(drawn: Layout) -> Ints:
    """Partner of each nucleotide: the same rank at the same offset, of the other direction."""
    pair = np.full(len(drawn.helix), -1)
    on = np.flatnonzero(drawn.helix >= 0)
    places = np.column_stack([drawn.helix, drawn.offset, drawn.rank])[on]
    _, key = np.unique(places, axis=0, return_inverse=True)
    key = key.reshape(-1)
    forward = drawn.forward[on]
    _, one, other = np.intersect1d(
        key[forward], key[~forward], assume_unique=True, return_indices=True
    )
    first, second = on[forward][one], on[~forward][other]
    pair[first], pair[second] = second, first
    return pair


def steps_along(drawn: Layout) -> Array:
    """How many bases each nucleotide is from offset 0 of its helix, along the axis.

    A helix is as long as the shorter of its two strands: what only one has more is a bulge.
    """
    steps = drawn.offset - drawn.rank
    for helix, longer in _longer(drawn).items():
        here = np.flatnonzero(drawn.helix == helix)
        offsets, more = np.array(longer).T
        before = np.searchsorted(offsets, drawn.offset[here], side="right")
        steps[here] += np.concatenate([[0], np.cumsum(more)])[before]
    return steps.astype(np.float64)


def _longer(drawn: Layout) -> dict[int, list[tuple[int, int]]]:
    """By helix, offsets and how many bases more than one the helix has there; −1 for none."""
    if not drawn.changes:
        return {}
    places = (drawn.helix, drawn.offset, drawn.forward)
    occupied = set(zip(*(place.tolist() for place in places), strict=True))
    longer: dict[int, list[tuple[int, int]]] = {}
    for (helix, offset), counts in sorted(drawn.changes.items()):
        # a strand that passes an offset without a change has one base there
        plain = [
            1 for way in (True, False) if way not in counts and (helix, offset, way) in occupied
        ]
        longer.setdefault(helix, []).append((offset, min([*counts.values(), *plain]) - 1))
    return longer
