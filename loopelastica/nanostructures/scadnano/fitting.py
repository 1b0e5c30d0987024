"""Helices moved so that strands that cross between them have bonds of the model.

A design draws its helices on a lattice, as far apart as is good to look at: scadnano's are 3.0 nm
from axis to axis, and no bond reaches from one to the next. Here each helix keeps its direction and
is shifted, rolled about its axis, and turned a little more or less per base: least squares of what
bonds between helices are too long, of what helices side by side are too near, and, weakly, of the
changes. Rolls and turns begin where crossing backbones look at the other helix.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica._vectors import dot, perpendicular
from loopelastica.nanostructures.oxdna.model import (
    BOND_DELTA,
    BOND_LENGTH,
    UNIT_NM,
    backbone_sites,
)
from loopelastica.nanostructures.scadnano.helices import Helices

Ints = NDArray[np.int64]

APART: Final = 2.7
"""Axes of helices side by side are to be so far apart, oxDNA's units (2.3 nm): backbone sites are
1.0 from the axis, and repel each other below 0.7."""
_FREE: Final = 0.19
"""What a bond may miss of its unstretched length before it counts in full: its energy is 0.05
there, and that of volumes that overlap is far greater."""
_TOUCH: Final = 2.4
"""Nearer than this axes count in full too: no groove makes room for that."""
_SOFT, _HARD, _HARDEST = 0.1, 3.0, 20.0
# drawn so far apart side by side: neighbours' neighbours of a lattice, which may come together
_SIDE: Final = 8.0
_PARALLEL: Final = 0.999
# per base to either side, to begin with and then again: at 10.5 bases per turn 10.1 to 10.9
_MOST_TWIST: Final = np.radians(1.3)
_TWISTS: Final = 53
# a shift of 1, a roll of 1 radian, a turn of 1 radian at the ends weigh as an axis too near by this
_KEPT: Final = 0.02
_STEPS: Final = 200


class Crossings(NamedTuple):
    """Bonds between paired nucleotides of two helices: both sides, the 5' one first; k of them."""

    row: Ints
    """(2, k) helices, by their places in :class:`Helices`."""
    steps: Array
    """(2, k) bases from offset 0."""
    forward: NDArray[np.bool_]
    """(2, k) whether the strand follows rising offsets."""

    def sites(self, helices: Helices, side: int) -> Array:
        """Backbone sites (k, 3) of the 5' side (0) or the 3' side (1)."""
        return backbone_sites(*helices.place(self.row[side], self.steps[side], self.forward[side]))

    def outside(self, helices: Helices) -> int:
        """How many bonds are outside of the model's window."""
        length = np.linalg.norm(self.sites(helices, 1) - self.sites(helices, 0), axis=1)
        return int((np.abs(length - BOND_LENGTH) >= BOND_DELTA).sum())


def fitted(helices: Helices, crossings: Crossings, extent: Array) -> tuple[Helices, str]:
    """Helices of a design, moved so that bonds between them are as long as the model's.

    Parameters
    ----------
    helices : Helices
        As they are drawn.
    crossings : Crossings
        Bonds between paired nucleotides of two helices.
    extent : (n, 2) array
        First and last base that is drawn on each helix, from offset 0.

    Returns
    -------
    helices : Helices
        Their directions are the same.
    note : str
        What was moved, and what is left; "" where no strand crosses.
    """
    n = crossings.row.shape[1]
    if not n:
        return helices, ""
    moved = _Fit(_rolled(helices, crossings, extent), crossings, extent).solved()
    far = float(np.linalg.norm(moved.origin - helices.origin, axis=1).max()) * UNIT_NM
    bases = 2 * np.pi / moved.turn
    return moved, (
        f"helices were fitted: shifted by up to {far:.2f} nm, rolled, and turned once in"
        f" {bases.min():.2f} to {bases.max():.2f} bases; of {n} bonds between helices"
        f" {crossings.outside(moved)} are outside of oxDNA's window, as drawn"
        f" {crossings.outside(helices)}"
    )


def _turned(helices: Helices, middle: Array, roll: Array, twist: Array) -> Helices:
    """Rolled about their axes, and turned by so much more per base on both sides of the middle."""
    angle = (roll - twist * middle)[:, None]
    up = np.cos(angle) * helices.up + np.sin(angle) * np.cross(helices.direction, helices.up)
    return replace(helices, up=up, turn=helices.turn + twist)


def _rolled(helices: Helices, crossings: Crossings, extent: Array) -> Helices:
    """Rolled and turned so that crossing backbones look at the other helix, on average."""
    middle = extent.mean(axis=1)
    twists = np.linspace(-_MOST_TWIST, _MOST_TWIST, _TWISTS)
    # directions as numbers on the unit circle: their sum is long where all agree
    sums = np.zeros((len(middle), _TWISTS), dtype=np.complex128)
    for side in (0, 1):
        row, steps = crossings.row[side], crossings.steps[side]
        axis, at = helices.direction[row], helices.axis_points(row, steps)
        out = crossings.sites(helices, side) - at
        towards = helices.axis_points(crossings.row[1 - side], crossings.steps[1 - side]) - at
        cosine = dot(perpendicular(out, axis), perpendicular(towards, axis))
        angle = np.arctan2(dot(np.cross(out, towards), axis), cosine)
        turned = angle[:, None] - (steps - middle[row])[:, None] * twists
        np.add.at(sums, row, np.exp(1j * turned))
    # of equal ones the least twist
    best = np.argmax(np.abs(sums) - 1e-3 * np.abs(twists) / _MOST_TWIST, axis=1)
    total = np.take_along_axis(sums, best[:, None], axis=1)[:, 0]
    crossing = np.abs(total) > 0
    roll, twist = np.where(crossing, [np.angle(total), twists[best]], 0.0)
    return _turned(helices, middle, roll, twist)


class _Fit:
    """Least squares over five numbers of each helix: a shift, a roll, a turn per base."""

    def __init__(self, helices: Helices, crossings: Crossings, extent: Array) -> None:
        self.helices, self.crossings = helices, crossings
        self.middle = extent.mean(axis=1)
        half = (extent[:, 1] - extent[:, 0]) / 2
        self.scale = np.ones((len(half), 5))
        self.scale[:, 4] = 1 / np.maximum(half, 1.0)
        self.beside = self._beside(half * helices.rise)

    def _beside(self, half: Array) -> Ints:
        """Pairs (2, m) of parallel helices that are drawn side by side."""
        from scipy.spatial import cKDTree

        axis = self.helices.direction
        centre = self.helices.axis_points(np.arange(len(axis)), self.middle)
        reach = _SIDE + 2 * float(half.max())
        i, j = cKDTree(centre).query_pairs(reach, output_type="ndarray").T
        step = centre[j] - centre[i]
        near = np.linalg.norm(perpendicular(step, axis[i]), axis=1) < _SIDE
        overlap = np.abs(dot(step, axis[i])) < half[i] + half[j]
        parallel = np.abs(dot(axis[i], axis[j])) > _PARALLEL
        return np.stack([i, j])[:, near & overlap & parallel]

    def solved(self) -> Helices:
        """Helices where the sum of squares is least."""
        from scipy.optimize import least_squares

        room = np.full(self.scale.shape, np.inf)
        room[:, 4] = _MOST_TWIST / self.scale[:, 4]
        start = np.zeros(self.scale.size)
        found = least_squares(
            self._misses,
            start,
            jac=self._slopes,
            bounds=(-room.ravel(), room.ravel()),
            max_nfev=_STEPS,
        )
        return self._moved(found.x)

    def _moved(self, x: Array) -> Helices:
        change = x.reshape(self.scale.shape) * self.scale
        turned = _turned(self.helices, self.middle, change[:, 3], change[:, 4])
        return replace(turned, origin=self.helices.origin + change[:, :3])

    def _bonds(self, helices: Helices) -> tuple[Array, Array]:
        """By how much bonds are too long, and their directions."""
        bond = self.crossings.sites(helices, 1) - self.crossings.sites(helices, 0)
        length = np.linalg.norm(bond, axis=1)
        return length - BOND_LENGTH, bond / np.maximum(length, 1e-9)[:, None]

    def _gaps(self, helices: Helices) -> tuple[Array, Array]:
        """Distances of axes side by side, and directions from the first to the second."""
        i, j = self.beside
        step = perpendicular(helices.origin[j] - helices.origin[i], helices.direction[i])
        distance = np.linalg.norm(step, axis=1)
        return distance, step / np.maximum(distance, 1e-9)[:, None]

    def _misses(self, x: Array) -> Array:
        helices = self._moved(x)
        long, distance = self._bonds(helices)[0], self._gaps(helices)[0]
        beyond = np.sign(long) * np.maximum(np.abs(long) - _FREE, 0.0)
        near = np.maximum(APART - distance, 0.0) + _HARDEST * np.maximum(_TOUCH - distance, 0.0)
        return np.concatenate([_SOFT * long + _HARD * beyond, near, _KEPT * x])

    def _slopes(self, x: Array) -> Any:
        """Derivatives of what is missed, a sparse matrix."""
        from scipy.sparse import coo_matrix

        helices, crossings = self._moved(x), self.crossings
        long, way = self._bonds(helices)
        weight = _SOFT + np.where(np.abs(long) > _FREE, _HARD, 0.0)
        n, m = len(long), self.beside.shape[1]
        # which residual, which helix, and its five slopes
        parts = []
        for side, sign in ((0, -1.0), (1, 1.0)):
            row, steps = crossings.row[side], crossings.steps[side]
            out = crossings.sites(helices, side) - helices.axis_points(row, steps)
            roll = dot(way, np.cross(helices.direction[row], out))
            slopes = np.column_stack([way, roll, roll * (steps - self.middle[row])])
            parts.append((np.arange(n), row, sign * weight[:, None] * slopes))
        distance, aside = self._gaps(helices)
        weight = np.where(distance < APART, 1.0, 0.0) + np.where(distance < _TOUCH, _HARDEST, 0.0)
        push = weight[:, None] * np.column_stack([aside, np.zeros((m, 2))])
        for row, sign in ((self.beside[0], 1.0), (self.beside[1], -1.0)):
            parts.append((n + np.arange(m), row, sign * push))
        rows = [np.repeat(residual, 5) for residual, _, _ in parts]
        columns = [(5 * row[:, None] + np.arange(5)).ravel() for _, row, _ in parts]
        values = [(slopes * self.scale[row]).ravel() for _, row, slopes in parts]
        own = np.arange(x.size)
        at = np.concatenate([*rows, n + m + own]), np.concatenate([*columns, own])
        value = np.concatenate([*values, np.full(x.size, _KEPT)])
        return coo_matrix((value, at), (n + m + x.size, x.size)).tocsr()
