"""Straight lines: tails at the ends of strands, and strands and circles that are paired nowhere."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.nanostructures.laying.bases import REACH
from loopelastica.nanostructures.laying.chains import Chains
from loopelastica.nanostructures.laying.ends import across
from loopelastica.nanostructures.oxdna.energies import nearest_image
from loopelastica.nanostructures.oxdna.model import BOND_LENGTH

# backbones of a straight tail are as far from other backbones, and from bases, as this
_BACKBONES: Final = 0.73
_BASES: Final = 0.55
# tilts from the helix' tangent and turns about it that are tried, the least tilt first, outwards
# first
_TILTS: Final = np.radians([20.0, 40.0, 60.0, 80.0, 100.0, 120.0])
_TURNS: Final = 2 * np.pi / 12 * np.array([0, 1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6])
# tails that are looked through one by one before they go into the tree of sites
_MANY: Final = 64


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
        for direction in _directions(tail) if turn else ():
            free = crowd.room(straight(start, direction, count), tail.anchor)
            if free > room + 1e-9:
                best, room = direction, free
            if room >= 0:
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


def _directions(tail: Tail) -> list[Array]:
    """Unit vectors (3,) to try, the helix' tangent first."""
    side = np.cross(tail.tangent, tail.outward)
    sideways = [np.cos(turn) * tail.outward + np.sin(turn) * side for turn in _TURNS]
    return [tail.tangent] + [
        np.cos(tilt) * tail.tangent + np.sin(tilt) * towards
        for tilt in _TILTS
        for towards in sideways
    ]


class _Crowd:
    """What is laid already, in two trees and a list of what is not in them yet."""

    def __init__(self, chains: Chains) -> None:
        self.chains = chains
        self.box = chains.box if (chains.box > 0).all() else None
        self._plant()

    def _plant(self) -> None:
        from scipy.spatial import cKDTree

        chains = self.chains
        self.recent: list[int] = []
        self.known = np.flatnonzero(chains.placed)
        self.trees = [
            cKDTree(self._inside(chains.sites[self.known] + share * chains.direction[self.known]),
                    boxsize=self.box)
            for share in (0.0, REACH)
        ]  # fmt: skip

    def _inside(self, points: Array) -> Array:
        if self.box is None:
            return points
        points = points % self.box
        return np.where(points >= self.box, 0.0, points)

    def add(self, nucleotides: NDArray[np.int64]) -> None:
        self.recent += nucleotides.tolist()
        if len(self.recent) > _MANY:
            self._plant()

    def room(self, line: Array, anchor: int) -> float:
        """By how much sites of a line are further from all others than they must be."""
        chains, free = self.chains, []
        for tree, share, least in zip(self.trees, (0.0, REACH), (_BACKBONES, _BASES), strict=True):
            # the nucleotide that the tail is bonded to is left out where it is the nearest
            distance, which = tree.query(self._inside(line), k=2, distance_upper_bound=least)
            own = np.append(self.known, -1)[which] == anchor
            distance[:, 0] = np.where(own[:, 0], distance[:, 1], distance[:, 0])
            free.append(min(float(distance[:, 0].min()), least) - least)
            if self.recent:
                others = chains.sites[self.recent] + share * chains.direction[self.recent]
                apart = (others[None] - line[:, None]).reshape(-1, 3)
                nearest = np.linalg.norm(nearest_image(apart, chains.box), axis=1).min()
                free.append(min(float(nearest), least) - least)
        return min(free)
