"""Hydroxyls and methyl groups turned to where their hydrogens have room.

A score per angle: staggered bonds, contacts, and for hydroxyls hydrogen bonds to the nitrogens and
oxygens of nucleotides. It is no force field's energy; it finds the place that a minimization need
not leave.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from loopelastica._arrays import Array
from loopelastica._vectors import unit

ANGLE_DEG: Final = {1: 108.5, 2: 109.5, 3: 109.5}
"""Angle at the carrier by the number of hydrogens: C–O–H and X–C–H of Amber's parm94."""
_TURNS_DEG: Final = np.arange(0.0, 360.0, 10.0)
_STAGGERED: Final = {1: 0.35, 2: 1.0, 3: 1.5}
"""What an eclipsed bond costs."""
_PER_A2: Final = 10.0
"""What a contact costs that is 1 Å too near."""
_POLAR, _OTHER, _FIXED = range(3)
_NEAREST_A: Final = 2.6
_NEAREST_H_A: Final = 2.1
_ROOM_A: Final = np.array([1.75, 2.4, _NEAREST_H_A])
"""Room of a hydroxyl's hydrogen to nitrogen and oxygen of nucleotides, to other heavy atoms (their
element is not known here), and to hydrogens; of a methyl group's to nitrogen and oxygen."""
_BOND: Final = 1.5
_BOND_A: Final = 1.9
_BOND_SD_A: Final = 0.35
"""What a straight hydrogen bond of this length gives."""
_REACH_A: Final = 4.2
_AT_ONCE: Final = 1000
_SAME_A: Final = 0.3


def turned(
    at: Array,
    hydrogens: Sequence[int],
    lengths_A: Array,
    others_A: Array,
    others_polar: NDArray[np.bool_],
    fixed_A: Array,
) -> list[Array]:
    """Where the hydrogens of groups are that can turn.

    Parameters
    ----------
    at : (n, 3, 3) array
        Carrier, its neighbour, and a neighbour of that, Å.
    hydrogens : sequence of int
        How many each group has, 1 to 3.
    lengths_A : (n,) array
        Of their bonds.
    others_A : (N, 3) array
        Heavy atoms, those of the groups among them.
    others_polar : (N,) array of bool
        Nitrogens and oxygens that take hydrogen bonds.
    fixed_A : (h, 3) array
        Hydrogens that do not turn.

    Returns
    -------
    list of (k, 3) arrays
        One per group.
    """
    count = np.asarray(hydrogens)
    points = np.concatenate([others_A, fixed_A])
    kinds = np.concatenate([np.where(others_polar, _POLAR, _OTHER), np.full(len(fixed_A), _FIXED)])
    tree = cKDTree(points)
    places = _places(at, count, lengths_A)
    score = np.empty(places.shape[:2])
    for begin in range(0, len(at), _AT_ONCE):
        part = slice(begin, begin + _AT_ONCE)
        near = tree.query_ball_point(at[part, 0], _REACH_A)
        group = np.repeat(np.arange(len(near)), [len(rows) for rows in near])
        rows = np.concatenate([np.asarray(rows, dtype=np.int64) for rows in near])
        score[part] = _scores(at[part], places[part], count[part], group, points[rows], kinds[rows])
    return _settled(at[:, 0], places, count, score)


def _places(at: Array, count: NDArray[np.int64], lengths_A: Array) -> Array:
    """Where hydrogens are (n, angles, 3, 3) at every angle, Å; the angle 0 is anti."""
    axis = unit(at[:, 1] - at[:, 0])
    across = at[:, 2] - at[:, 1]
    # three atoms in a line say nothing: any direction across serves
    across += 1e-6 * np.roll(axis, 1, axis=1)
    first = -unit(across - (across * axis).sum(axis=1, keepdims=True) * axis)
    second = np.cross(axis, first)
    turns = np.deg2rad(_TURNS_DEG[:, None] + np.array([0.0, 120.0, 240.0]))
    angle = np.deg2rad([ANGLE_DEG[n] for n in count.tolist()])[:, None]
    out = np.cos(turns)[..., None] * first[:, None, None] + (
        np.sin(turns)[..., None] * second[:, None, None]
    )
    out = np.sin(angle)[..., None, None] * out + (np.cos(angle) * axis)[:, None, None]
    return np.asarray(at[:, None, None, 0] + lengths_A[:, None, None, None] * out)


def _scores(
    at: Array,
    places: Array,
    count: NDArray[np.int64],
    group: NDArray[np.int64],
    points: Array,
    kinds: NDArray[np.int64],
) -> Array:
    """The score (n, angles) of groups by their neighbours: points (m, 3), each of one group."""
    staggered = np.array([_STAGGERED[n] for n in count.tolist()])
    score = staggered[:, None] * (1.0 - np.cos(np.deg2rad(3.0 * _TURNS_DEG))) / 2.0
    # a group's own carrier and its neighbour are no contacts
    own = np.linalg.norm(points[:, None] - at[group, :2], axis=2).min(axis=1) < _SAME_A
    group, points, kinds = group[~own], points[~own], kinds[~own]
    room = _ROOM_A[kinds]
    donor = (count == 1)[group] & (kinds == _POLAR)
    room = np.where((kinds == _POLAR) & ~donor, _NEAREST_A, room)
    for h in range(3):
        here = places[group, :, h]
        to = points[:, None] - here
        distance = np.linalg.norm(to, axis=2)
        terms = _PER_A2 * np.maximum(0.0, room[:, None] - distance) ** 2
        out = unit(here - at[group, None, 0])
        straight = np.maximum(0.0, (out * to).sum(axis=2) / np.maximum(distance, 1e-9)) ** 2
        away = (distance - _BOND_A) / _BOND_SD_A
        terms -= np.where(donor[:, None], _BOND * straight * np.exp(-(away**2)), 0.0)
        terms[h >= count[group]] = 0.0
        np.add.at(score, group, terms)
    return score


def _settled(carriers: Array, places: Array, count: NDArray[np.int64], score: Array) -> list[Array]:
    """One group after the other takes its best angle; those before it count as contacts."""
    beside: dict[int, list[int]] = {}
    for i, j in sorted(cKDTree(carriers).query_pairs(_REACH_A)):
        beside.setdefault(j, []).append(i)
    out: list[Array] = []
    for k, n in enumerate(count.tolist()):
        own = score[k]
        if k in beside:
            others = np.concatenate([out[i] for i in beside[k]])
            to = np.linalg.norm(places[k, :, :n, None] - others, axis=-1)
            own = own + _PER_A2 * (np.maximum(0.0, _NEAREST_H_A - to) ** 2).sum(axis=(1, 2))
        # rounded, for a rigid motion must not change which one is best
        out.append(places[k, int(np.argmin(own.round(6))), :n])
    return out
