"""Which laid nucleotides are too near to others, and to which."""

from __future__ import annotations

from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.nanostructures.laying.cells import beside
from loopelastica.nanostructures.laying.laid import Conflict
from loopelastica.nanostructures.oxdna.checks import NEAREST
from loopelastica.nanostructures.oxdna.energies import (
    bonds,
    close_sites,
    excluded_volume,
    separation,
)
from loopelastica.nanostructures.oxdna.model import BOND_LONGEST, BOND_SHORTEST, backbone_sites
from loopelastica.nanostructures.oxdna.periodic import tree_of, wrapped
from loopelastica.nanostructures.system import System

Index = NDArray[np.int64]

# sites of nucleotides meet where centres are nearer than this
_REACH: Final = 2.0
# backbones nearer than this overlap by more than turned bases can help
_CROSSED: Final = 0.69
OVERLAP: Final = 0.05
"""Excluded volume of two nucleotides from which on a strand gives way; half of kT at 300 K."""
CONFLICT: Final = 0.5
"""The same from which on another way is tried, and what is left is named: five times kT."""


class Overlaps(NamedTuple):
    """Two nucleotides each, one of them laid at least; arrays over m."""

    first: Index
    second: Index
    energy: Array


def overlaps(system: System, laid: NDArray[np.bool_]) -> Overlaps:
    """Excluded volume of laid nucleotides, summed over the sites of each two.

    Parameters
    ----------
    system : System
        The nucleotides.
    laid : (n,) array of bool
        Those that count, with whatever they meet.

    Returns
    -------
    Overlaps
        Also of bonded neighbours, and with infinite energy where centres are too near or a bond
        is out of the window of the model.
    """
    rows = np.flatnonzero(_about(system, laid))
    system, laid = _part(system, rows), laid[rows]
    volume, bonded = excluded_volume(system), bonds(system)
    out = (bonded.length <= BOND_SHORTEST) | (bonded.length >= BOND_LONGEST)
    near = close_sites(system, system.centre, NEAREST)
    first = np.concatenate([volume.first, bonded.first, near[0]])
    second = np.concatenate([volume.second, bonded.second, near[1]])
    energy = np.concatenate(
        [
            volume.energy,
            np.where(out, np.inf, bonded.excluded_volume),
            np.full(len(near[0]), np.inf),
        ]
    )
    some = (laid[first] | laid[second]) & (energy > 0)
    low, high = np.minimum(first, second)[some], np.maximum(first, second)[some]
    pairs, which = np.unique(np.stack([low, high], axis=1), axis=0, return_inverse=True)
    total = np.bincount(which.reshape(-1), energy[some], len(pairs)).astype(np.float64)
    return Overlaps(rows[pairs[:, 0]], rows[pairs[:, 1]], total)


def _part(system: System, rows: Index) -> System:
    """Some nucleotides of a system, for energies only."""
    place = np.full(len(system) + 1, -1, dtype=np.int64)
    place[rows] = np.arange(len(rows))
    per_nucleotide = ("base", "strand", "placed", "centre", "a1", "a3")
    return replace(
        system,
        **{name: getattr(system, name)[rows] for name in per_nucleotide},
        **{name: place[getattr(system, name)[rows]] for name in ("n3", "n5", "pair")},
        label=(),
    )


def _about(system: System, laid: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which nucleotides can meet laid ones; with a periodic box all may."""
    if (system.box > 0).any():
        return system.placed
    own = system.centre[laid & system.placed]
    return system.placed & beside(system.centre, own, _REACH)


def strands_of(found: Overlaps, strand: Index, above: float) -> Index:
    """Single strands, by the number of each nucleotide's, that overlap by more than an energy."""
    worst = found.energy > above
    both = np.concatenate([strand[found.first[worst]], strand[found.second[worst]]])
    return np.unique(both[both >= 0])


def crossed(system: System, strand: Index) -> Index:
    """Single strands, by the number of each nucleotide's, whose backbones overlap others."""
    rows = np.flatnonzero(_about(system, strand >= 0))
    part, own = _part(system, rows), strand[rows]
    i, j = close_sites(part, backbone_sites(part.centre, part.a1, part.a3), _CROSSED)
    both = np.concatenate([own[i], own[j]])
    return np.unique(both[both >= 0])


def worst(found: Overlaps, strand: Index, count: int) -> Array:
    """Sum (count,) of the overlaps of each single strand; what is infinite counts as 10⁶."""
    total = np.zeros(count)
    for index in (found.first, found.second):
        own = strand[index]
        total += np.bincount(own[own >= 0], np.minimum(found.energy[own >= 0], 1e6), count)
    return total


def conflicts_of(
    system: System, found: Overlaps, strand: Index, labels: list[str]
) -> dict[int, list[Conflict]]:
    """Conflicts of each single strand, by its number.

    Parameters
    ----------
    system : System
        The nucleotides.
    found : Overlaps
        Of laid nucleotides.
    strand : (n,) array of int
        Number of the single strand that a nucleotide is laid in; −1 for none.
    labels : list of str
        What sentences call single strands.

    Returns
    -------
    dict of int to list of Conflict
        Two laid strands both name a conflict.
    """
    named: dict[int, list[Conflict]] = {}
    worst = np.flatnonzero(found.energy > CONFLICT)
    first, second = found.first[worst], found.second[worst]
    apart = separation(system, system.centre[first], system.centre[second])
    distance = np.linalg.norm(apart, axis=1)
    for i, j, far, energy in zip(
        first.tolist(), second.tolist(), distance.tolist(), found.energy[worst].tolist(),
        strict=True,
    ):  # fmt: skip
        ways = [(i, j)] if strand[i] == strand[j] else [(i, j), (j, i)]
        for own, other in ways:
            if strand[own] >= 0:
                named.setdefault(int(strand[own]), []).append(
                    Conflict(own, other, far, energy, _sentence(system, own, other, far, energy,
                                                                strand, labels))
                )  # fmt: skip
    return named


def _sentence(
    system: System, i: int, j: int, far: float, energy: float, strand: Index, labels: list[str]
) -> str:
    label = system.label
    fact = f"centres are {far:.3f} apart" + (
        f", excluded volume {energy:.2g}" if np.isfinite(energy) else ""
    )
    if system.n3[i] == j or system.n5[i] == j:
        fact = f"neighbours whose {fact}"
    other = f"of {labels[strand[j]]}" if strand[j] >= 0 else "of a helix"
    own = labels[strand[i]]
    if strand[i] == strand[j]:
        other = "of the same strand"
    return f"{own}: {label[i]} is too near to {label[j]} {other} ({fact})"


def nearest_others(system: System, laid: NDArray[np.bool_]) -> Array:
    """Distance (n,) from each laid centre to the nearest that is no neighbour; inf for others.

    Looked for up to 4, beyond which nothing meets: inf there as well.
    """
    found = np.full(len(system), np.inf)
    rows, placed = np.flatnonzero(laid & system.placed), np.flatnonzero(system.placed)
    if not len(rows):
        return found
    tree = tree_of(system.centre[placed], system.box)
    # itself and two neighbours come before it at most
    distance, which = tree.query(wrapped(system.centre[rows], system.box), k=4)
    other = np.append(placed, -1)[np.minimum(which, len(placed))]
    known = (
        (other < 0)
        | (other == rows[:, None])
        | (other == system.n3[rows][:, None])
        | (other == system.n5[rows][:, None])
    )
    found[rows] = np.where(known, np.inf, distance).min(axis=1)
    return found
