"""Designs of scadnano as systems: nucleotides in order, partners, and what is on its helix."""

from __future__ import annotations

from collections.abc import Iterator
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica._checks import file_name, whole
from loopelastica.nanostructures.design import Design, HelixAxis
from loopelastica.nanostructures.oxdna.checks import check_start
from loopelastica.nanostructures.scadnano.file import load
from loopelastica.nanostructures.scadnano.fitting import Crossings, fitted
from loopelastica.nanostructures.scadnano.helices import Helices, helices_of
from loopelastica.nanostructures.scadnano.layout import (
    NOT_GIVEN,
    Ints,
    layout,
    partners,
    steps_along,
)
from loopelastica.nanostructures.system import System

_BASES = np.array(["A", "C", "G", "T"])


def read_design(path: str | PathLike[str], seed: int = 0, *, fit: bool = False) -> Design:
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
    fit : bool
        Whether helices are moved so that strands can cross between them, in place of staying where
        they are drawn.

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
    drawn = layout(file)
    pair = partners(drawn)
    base, filled = _bases(drawn.base, pair, seed)
    on = np.flatnonzero(drawn.helix >= 0)
    row, steps = helices.rows(drawn.helix[on]), steps_along(drawn)[on]
    n3, n5 = _neighbours(drawn.strand, [strand.circular for strand in file.strands])
    moved = ""
    if fit:
        first = np.flatnonzero((n3 >= 0) & (pair >= 0))
        ends = np.stack([first, n3[first]])
        ends = ends[:, (pair[ends[1]] >= 0) & (drawn.helix[ends[0]] != drawn.helix[ends[1]])]
        at = np.searchsorted(on, ends)
        crossings = Crossings(row[at], steps[at], drawn.forward[ends])
        helices, moved = fitted(helices, crossings, _extent(len(helices.index), row, steps))
    centre, a1, a3 = (np.zeros((len(base), 3)) for _ in range(3))
    centre[on], a1[on], a3[on] = helices.place(row, steps, drawn.forward[on])
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
    faults = check_start(system)
    hint = "with fitted helices (option `helices`) strands can cross by bonds inside of the window"
    return Design(
        system=system,
        axes=tuple(_axes(helices, row, steps)),
        helix=drawn.helix,
        offset=drawn.offset,
        drawn=drawn.drawn,
        # what is drawn so that a simulation cannot begin with it as it is
        notes=(
            *(*file.notes, *filled, *faults.notes()),
            *(note for note in (moved,) if note),
            *(note for note in (hint,) if len(faults.broken) and not fit),
        ),
    )


def _bases(
    base: NDArray[np.str_], pair: Ints, seed: int
) -> tuple[NDArray[np.str_], tuple[str, ...]]:
    """Bases of all nucleotides, and a note where some were not given."""
    missing = np.isin(base, list(NOT_GIVEN))
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
        many, them = ("pairs are", "them") if len(odd) > 1 else ("pair is", "it")
        notes.append(f"{len(odd)} {many} not complementary, so oxDNA will not hold {them}")
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


def _extent(count: int, row: Ints, steps: Array) -> Array:
    """First and last base drawn on each of so many helices (count, 2); 0 where there is none."""
    extent = np.stack([np.full(count, np.inf), np.full(count, -np.inf)], axis=1)
    np.minimum.at(extent[:, 0], row, steps)
    np.maximum.at(extent[:, 1], row, steps)
    return np.where(np.isfinite(extent), extent, 0.0)


def _axes(helices: Helices, row: Ints, steps: Array) -> Iterator[HelixAxis]:
    order = np.lexsort([steps, row])
    rows, first = np.unique(row[order], return_index=True)
    last = np.append(first[1:], len(order)) - 1
    begin, end = (helices.axis_points(rows, steps[order[at]]) for at in (first, last))
    for place, own in enumerate(rows):
        points = (helices.direction[own], begin[place], end[place])
        yield HelixAxis(int(helices.index[own]), *map(np.copy, points))
