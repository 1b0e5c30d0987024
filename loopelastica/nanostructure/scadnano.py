"""Designs of scadnano as systems: nucleotides in order, partners, and what is on its helix."""

from __future__ import annotations

from collections.abc import Iterator
from os import PathLike
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from loopelastica._checks import file_name, whole
from loopelastica.errors import StructureError
from loopelastica.nanostructure.bonds import bond_lengths
from loopelastica.nanostructure.design import Design, HelixAxis
from loopelastica.nanostructure.helices import Helices, helices_of
from loopelastica.nanostructure.scadnano_file import File, load
from loopelastica.nanostructure.system import System

Ints = NDArray[np.int64]

CLOSEST: Final = 0.4
"""Centres of nucleotides that are not neighbours are further apart; oxDNA's units."""

_BASES = np.array(["A", "C", "G", "T"])
_NOT_GIVEN = ("?", "N")


class _Drawn(NamedTuple):
    """Nucleotides as the design draws them; arrays over n of them, strand by strand."""

    strand: Ints
    drawn: NDArray[np.str_]
    row: Ints
    """Of which helix, by its place in `Helices`; −1 for none."""
    forward: NDArray[np.bool_]
    offset: Ints
    rank: Ints
    """0 for the base of an offset itself, 1, 2, … for insertions, which go before it."""
    base: NDArray[np.str_]
    label: tuple[str, ...]
    changes: dict[tuple[int, int], dict[bool, int]]
    """By helix and offset where bases are inserted or deleted: their number by direction."""


def read_design(path: str | PathLike[str], seed: int = 0) -> Design:
    """Read a design of scadnano and place what is paired.

    Two bases at one offset of a helix, of a forward and a reverse strand, are partners and are
    placed on that helix in the geometry of oxDNA2. Loopouts, extensions and what has no partner
    are not placed. Where only one of two strands has an insertion or a deletion, the bases without
    a partner are a bulge, and the helix is no longer or shorter for it.

    Parameters
    ----------
    path : path-like
        A file of scadnano (``.sc``), of the installed version or before; compressed by gzip or
        not.
    seed : int
        Partners without a sequence get random complementary bases, drawn from this seed. Other
        nucleotides without a sequence are T.

    Returns
    -------
    Design
        The system, axes of helices, what is drawn where, and notes.

    Raises
    ------
    MissingDependencyError
        If the package scadnano is not installed (extra ``origami``).
    StructureError
        If the file cannot be read or is no design that can be placed; one sentence that names
        strand, helix and offset.
    """
    seed = whole(0)("seed", seed)
    file = load(Path(file_name("path", path)))
    helices = helices_of(file.name, file.design)
    drawn = _drawn(file, helices)
    pair = _partners(drawn)
    base, filled = _bases(drawn.base, pair, seed)
    steps = _steps(drawn)
    on_helix = drawn.row >= 0
    centre, a1, a3 = (np.zeros((len(base), 3)) for _ in range(3))
    placed = helices.place(drawn.row[on_helix], steps[on_helix], drawn.forward[on_helix])
    centre[on_helix], a1[on_helix], a3[on_helix] = placed
    n3, n5 = _neighbours(drawn.strand, [strand.circular for strand in file.strands])
    system = System(
        name=file.name,
        base=base,
        strand=drawn.strand,
        n3=n3,
        n5=n5,
        pair=pair,
        placed=pair >= 0,
        centre=centre,
        a1=a1,
        a3=a3,
        label=drawn.label,
        strand_name=tuple(strand.name for strand in file.strands),
        colour=file.colours,
        rna=np.zeros(len(file.strands), dtype=bool),
        box=np.zeros(3),
    )
    return Design(
        system=system,
        axes=tuple(_axes(helices, drawn, steps)),
        helix=np.where(on_helix, helices.index[drawn.row], -1),
        offset=drawn.offset,
        drawn=drawn.drawn,
        notes=(*file.notes, *filled, *_care(system)),
    )


def _drawn(file: File, helices: Helices) -> _Drawn:
    rows = {int(index): row for row, index in enumerate(helices.index)}
    changes: dict[tuple[int, int], dict[bool, int]] = {}
    parts: list[tuple[Any, ...]] = []
    labels: list[str] = []
    bases: list[str] = []
    for number, strand in enumerate(file.strands):
        for part in strand.domains:
            count = part.dna_length()
            bases.append(_letters(file, number, part, count))
            if hasattr(part, "helix"):
                row = rows[part.helix]
                offset, rank = _offsets(part, changes, row)
                kind, forward = "domain", part.forward
                labels += [
                    f"helix {part.helix}, offset {at}" + (f", insertion {k}" if k else "")
                    for at, k in zip(offset.tolist(), rank.tolist(), strict=True)
                ]
            else:
                kind = "loopout" if hasattr(part, "length") else "extension"
                row, forward = -1, True
                offset = rank = np.zeros(count, dtype=np.int64)
                labels += [f"{kind} nucleotide {k} of {count}" for k in range(1, count + 1)]
            parts.append((number, kind, row, forward, offset, rank))
    counts = [len(part[4]) for part in parts]
    strand_, kind_, row_, forward_ = (
        np.repeat(np.array([part[i] for part in parts]), counts) for i in range(4)
    )
    offset_, rank_ = (np.concatenate([part[i] for part in parts]) for i in (4, 5))
    return _Drawn(
        strand_, kind_, row_, forward_, offset_, rank_,
        np.array(list("".join(bases))), tuple(labels), changes,
    )  # fmt: skip


def _offsets(
    domain: Any, changes: dict[tuple[int, int], dict[bool, int]], row: int
) -> tuple[Ints, Ints]:
    """Offset and rank of each nucleotide of a domain, from 5' to 3'."""
    count = np.ones(domain.end - domain.start, dtype=np.int64)
    for at, more in domain.insertions:
        count[at - domain.start] += more
    for at in domain.deletions:
        count[at - domain.start] = 0
    for at in (*domain.deletions, *(at for at, _ in domain.insertions)):
        changes.setdefault((row, at), {})[domain.forward] = int(count[at - domain.start])
    offset = np.repeat(np.arange(domain.start, domain.end), count)
    rank = np.repeat(np.cumsum(count), count) - 1 - np.arange(len(offset))
    return (offset, rank) if domain.forward else (offset[::-1], rank[::-1])


def _letters(file: File, number: int, part: Any, count: int) -> str:
    letters: str = part.dna_sequence or "?" * count
    if odd := letters.strip("ACGT?N"):
        what = "RNA, whose helices have another geometry" if odd[0] == "U" else "no base of DNA"
        raise StructureError(
            f"{file.name}: {file.strands[number].name} has {odd[0]!r} in its sequence; that is"
            f" {what}"
        )
    return letters


def _partners(drawn: _Drawn) -> Ints:
    """Partner of each nucleotide: the same rank at the same offset, of the other direction."""
    pair = np.full(len(drawn.row), -1)
    on = np.flatnonzero(drawn.row >= 0)
    places = np.column_stack([drawn.row, drawn.offset, drawn.rank])[on]
    _, key = np.unique(places, axis=0, return_inverse=True)
    key = key.reshape(-1)
    forward = drawn.forward[on]
    _, one, other = np.intersect1d(
        key[forward], key[~forward], assume_unique=True, return_indices=True
    )
    first, second = on[forward][one], on[~forward][other]
    pair[first], pair[second] = second, first
    return pair


def _steps(drawn: _Drawn) -> NDArray[np.float64]:
    """How many bases each nucleotide is from offset 0 of its helix, along the axis."""
    steps = drawn.offset - drawn.rank
    if drawn.changes:
        # per helix and offset how much longer the helix is; a strand that passes an offset without
        # a change has one base there, and a helix is as long as the shorter of its two strands
        occupied = {
            way: set(zip(drawn.row[where].tolist(), drawn.offset[where].tolist(), strict=True))
            for way in (True, False)
            for where in [(drawn.forward == way) & (drawn.row >= 0)]
        }
        longer: dict[int, list[tuple[int, int]]] = {}
        for (row, offset), counts in sorted(drawn.changes.items()):
            least = [
                1 for way in (True, False) if way not in counts and (row, offset) in occupied[way]
            ]
            longer.setdefault(row, []).append((offset, min([*counts.values(), *least]) - 1))
        for row, pieces in longer.items():
            here = np.flatnonzero(drawn.row == row)
            offsets, more = np.array(pieces).T
            before = np.searchsorted(offsets, drawn.offset[here], side="right")
            steps[here] += np.concatenate([[0], np.cumsum(more)])[before]
    return steps.astype(np.float64)


def _bases(
    base: NDArray[np.str_], pair: Ints, seed: int
) -> tuple[NDArray[np.str_], tuple[str, ...]]:
    """Bases of all nucleotides, and a note where some were not given."""
    missing = np.isin(base, _NOT_GIVEN)
    base = np.where(missing, "T", base)
    paired = pair >= 0
    # of two that are missing, the first is drawn
    drawn = missing & paired & missing[pair] & (pair > np.arange(len(pair)))
    base[drawn] = np.random.default_rng(seed).choice(_BASES, int(drawn.sum()))
    copied = missing & paired & ~drawn
    base[copied] = _complement(base[pair[copied]])
    notes = []
    if missing.any():
        notes.append(
            f"{int(missing.sum())} of {len(base)} nucleotides have no base in the design: partners"
            f" got complementary ones (random where neither has one, seed {seed}), others T"
        )
    first = np.flatnonzero(paired & (pair > np.arange(len(pair))))
    odd = first[base[first] != _complement(base[pair[first]])]
    if len(odd):
        notes.append(f"{len(odd)} pairs are not complementary, so oxDNA will not hold them")
    return base, tuple(notes)


def _complement(bases: NDArray[np.str_]) -> NDArray[np.str_]:
    found: NDArray[np.str_] = _BASES[3 - np.searchsorted(_BASES, bases)]
    return found


def _neighbours(strand: Ints, circular: list[bool]) -> tuple[Ints, Ints]:
    n = len(strand)
    first = np.searchsorted(strand, np.arange(len(circular)))
    last = np.append(first[1:], n) - 1
    n3, n5 = np.arange(1, n + 1), np.arange(-1, n - 1)
    n3[last] = np.where(circular, first, -1)
    n5[first] = np.where(circular, last, -1)
    return n3, n5


def _axes(helices: Helices, drawn: _Drawn, steps: NDArray[np.float64]) -> Iterator[HelixAxis]:
    on = np.flatnonzero(drawn.row >= 0)
    order = on[np.lexsort([steps[on], drawn.row[on]])]
    rows, first = np.unique(drawn.row[order], return_index=True)
    last = np.append(first[1:], len(order)) - 1
    begin, end = (helices.axis_points(rows, steps[order[at]]) for at in (first, last))
    for place, row in enumerate(rows):
        direction = helices.direction[row]
        yield HelixAxis(
            int(helices.index[row]), *map(np.copy, (direction, begin[place], end[place]))
        )


def _care(system: System) -> Iterator[str]:
    """What is drawn so that a simulation cannot begin with it as it is."""
    from scipy.spatial import KDTree

    if sentence := bond_lengths(system).sentence(system):
        yield sentence
    placed = np.flatnonzero(system.placed)
    near = KDTree(system.centre[placed]).query_pairs(CLOSEST, output_type="ndarray")
    if len(near):
        one, other = (system.label[i] for i in placed[near[0]])
        yield (f"{len(near)} pairs of nucleotides are drawn in one place, first {one} and {other}")
