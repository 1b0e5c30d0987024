"""Straight lines: tails at the ends of strands, and strands and circles that are paired nowhere."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.nanostructures.laying.bases import REACH
from loopelastica.nanostructures.laying.chains import Chains
from loopelastica.nanostructures.laying.ends import across
from loopelastica.nanostructures.oxdna.model import BOND_LENGTH
from loopelastica.nanostructures.oxdna.periodic import tree_of, wrapped

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

# backbones of a straight tail are as far from other backbones, and from bases, as this
_LEAST: Final = (0.73, 0.55)
_SHARES: Final = (0.0, REACH)
# tilts from the helix' tangent and turns about it that are tried, the least tilt first, outwards
# first
_TILTS: Final = np.radians([20.0, 40.0, 60.0, 80.0, 100.0, 120.0])
_TURNS: Final = 2 * np.pi / 12 * np.array([0, 1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6])
# of rounding
_EPS: Final = 1e-9


class Tail(NamedTuple):
    """A tail as its nucleotides from the helix on."""

    nucleotides: NDArray[np.int64]
    anchor: int
    """The paired nucleotide that it is bonded to."""
    tangent: Array
    """Unit vector (3,) away from it along its helix' backbone line."""
    outward: Array
    """Unit vector (3,) across the tangent, away from the helix' axis."""


def lay_tails(chains: Chains, tails: list[Tail], turn: bool) -> None:
    """Lay tails on straight lines, in their order.

    Parameters
    ----------
    chains : Chains
        All nucleotides; those of the tails are placed.
    tails : list of Tail
        What is laid.
    turn : bool
        Whether tails turn out of the way of what is laid; else each follows its tangent.
    """
    crowd = _Crowd(chains)
    for tail in tails:
        start, count = chains.sites[tail.anchor], len(tail.nucleotides)
        best, room = tail.tangent, -np.inf
        for directions in _directions(tail) if turn else ():
            lines = np.stack([straight(start, direction, count) for direction in directions])
            free = crowd.room(lines, tail.anchor)
            first = int(np.argmax(free > -_EPS)) if (free > -_EPS).any() else int(np.argmax(free))
            if free[first] > room + _EPS:
                best, room = directions[first], free[first]
            if room > -_EPS:
                break
        chains.sites[tail.nucleotides] = straight(start, best, count)
        towards = across(chains.direction[tail.anchor][None], best[None])
        chains.direction[tail.nucleotides] = towards
        chains.placed[tail.nucleotides] = True
        crowd.add(tail.nucleotides)


def straight(start: Array, direction: Array, count: int) -> Array:
    """Backbone sites (count, 3) on a line that begins a bond after a point."""
    steps = BOND_LENGTH * np.arange(1, count + 1)
    return np.asarray(start + steps[:, None] * direction)


def ring(count: int) -> tuple[Array, Array]:
    """Backbone sites (count, 3) on a circle about the origin, and directions outwards."""
    angle = 2 * np.pi * np.arange(count) / count
    outward = np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], axis=1)
    return BOND_LENGTH / (2 * np.sin(np.pi / count)) * outward, outward


def _directions(tail: Tail) -> Iterator[Array]:
    """Unit vectors (k, 3) to try, the helix' tangent first, then all of one tilt together."""
    side = np.cross(tail.tangent, tail.outward)
    sideways = np.outer(np.cos(_TURNS), tail.outward) + np.outer(np.sin(_TURNS), side)
    yield tail.tangent[None]
    for tilt in _TILTS:
        yield np.cos(tilt) * tail.tangent + np.sin(tilt) * sideways


class _Crowd:
    """What is laid already, in trees: one of what was there, and of tails few that grow."""

    def __init__(self, chains: Chains) -> None:
        self.chains = chains
        self.parts: list[tuple[NDArray[np.int64], list[cKDTree]]] = []
        self.known = np.flatnonzero(chains.placed)
        self.trees = self._trees(self.known)

    def _trees(self, rows: NDArray[np.int64]) -> list[cKDTree]:
        """Of backbones and of bases."""
        sites, direction = self.chains.sites[rows], self.chains.direction[rows]
        return [tree_of(sites + share * direction, self.chains.box) for share in _SHARES]

    def add(self, nucleotides: NDArray[np.int64]) -> None:
        """Note a tail. Parts of like size become one, so that there are never many."""
        while self.parts and len(self.parts[-1][0]) < 2 * len(nucleotides):
            nucleotides = np.concatenate([self.parts.pop()[0], nucleotides])
        self.parts.append((nucleotides, self._trees(nucleotides)))

    def room(self, lines: Array, anchor: int) -> Array:
        """By how much sites of lines (k, n, 3) are too near to others (k,): 0 or less."""
        points = wrapped(lines.reshape(-1, 3), self.chains.box)
        room = np.zeros(len(points))
        for tree, least in zip(self.trees, _LEAST, strict=True):
            # the nucleotide that the tail is bonded to is left out where it is the nearest
            distance, which = tree.query(points, k=2, distance_upper_bound=least)
            own = np.append(self.known, -1)[which[:, 0]] == anchor
            room = np.minimum(room, np.where(own, distance[:, 1], distance[:, 0]) - least)
        for _, trees in self.parts:
            for tree, least in zip(trees, _LEAST, strict=True):
                distance, _ = tree.query(points, distance_upper_bound=least)
                room = np.minimum(room, distance - least)
        return np.asarray(room.reshape(len(lines), -1).min(axis=1))
