"""Hydrogens that come too near to others bent aside.

Heavy atoms that keep their distances may have hydrogens that do not, since they were built without
them. At ideal angles such a pair is what a simulation sees first: two hydrogens 0.9 Å apart push
each other by thousands of kcal/mol/Å, 20° off their ideal angles by less than a hundred.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from loopelastica._arrays import Array

NEAREST_H_A: Final = 1.75
NEAREST_GEMINAL_A: Final = 1.6
"""Room between hydrogens of two carriers, and of one."""
NEAREST_CH_A: Final = 1.9
NEAREST_NH_A: Final = 1.6
"""Room of a carbon's hydrogen to heavy atoms, and of one that makes hydrogen bonds. Where Amber's
forces reach some 100 kcal/mol/Å."""
NEAREST_1_3_A: Final = 1.85
"""Room to heavy atoms that are bonded to the carrier: no angle is less than 85°."""
_TETHER: Final = 0.1
"""What it costs to leave the ideal place, in parts of a contact."""
_BONDED_A: Final = 1.9
"""Heavy atoms nearer than this to a carrier are bonded to it."""
_SAME_A: Final = 0.05
_MARGIN_A: Final = 0.8
_STEPS: Final = 80
_STEP: Final = 0.2


def eased(hydrogens_A: Array, carriers_A: Array, polar: NDArray[np.bool_], heavy_A: Array) -> Array:
    """Where hydrogens have room, at the lengths of their bonds.

    Parameters
    ----------
    hydrogens_A, carriers_A : (n, 3) array
        Where they ideally are, and the atoms that carry them, Å.
    polar : (n,) array of bool
        Whether they make hydrogen bonds.
    heavy_A : (N, 3) array
        All heavy atoms, carriers among them.

    Returns
    -------
    (n, 3) array
        Those that have room as they were.
    """
    pairs, apart_A = _hydrogens(hydrogens_A, carriers_A)
    rows, points, room_A = _contacts(hydrogens_A, carriers_A, polar, heavy_A)
    lengths = np.linalg.norm(hydrogens_A - carriers_A, axis=1, keepdims=True)
    here = hydrogens_A.copy()
    for _ in range(_STEPS):
        force = _TETHER * (hydrogens_A - here)
        push = _push(here[pairs[:, 0]] - here[pairs[:, 1]], apart_A)
        np.add.at(force, pairs[:, 0], push)
        np.add.at(force, pairs[:, 1], -push)
        np.add.at(force, rows, _push(here[rows] - points, room_A))
        moved = np.flatnonzero(np.abs(force).max(axis=1, initial=0.0) > 0.0)
        if len(moved) == 0:
            break
        to = here[moved] + 2.0 * _STEP * force[moved] - carriers_A[moved]
        to *= lengths[moved] / np.linalg.norm(to, axis=1, keepdims=True)
        here[moved] = carriers_A[moved] + to
    return here


def _push(apart: Array, room_A: Array) -> Array:
    """What drives two points apart that are nearer than they should be."""
    distance = np.linalg.norm(apart, axis=1)
    return np.asarray(
        (np.maximum(0.0, room_A - distance) / np.maximum(distance, 1e-9))[:, None] * apart
    )


def _hydrogens(hydrogens_A: Array, carriers_A: Array) -> tuple[NDArray[np.int64], Array]:
    """Pairs of hydrogens (m, 2) that may come near each other, and the room between them (m,)."""
    found = cKDTree(hydrogens_A).query_pairs(NEAREST_H_A + _MARGIN_A, output_type="ndarray")
    pairs = found.astype(np.int64).reshape(-1, 2)
    between = carriers_A[pairs[:, 0]] - carriers_A[pairs[:, 1]]
    geminal = np.linalg.norm(between, axis=1) < _SAME_A
    return pairs, np.where(geminal, NEAREST_GEMINAL_A, NEAREST_H_A)


def _contacts(
    hydrogens_A: Array, carriers_A: Array, polar: NDArray[np.bool_], heavy_A: Array
) -> tuple[NDArray[np.int64], Array, Array]:
    """Hydrogens (m,), heavy atoms near them (m, 3) but their carriers, and the room (m,)."""
    near = cKDTree(heavy_A).query_ball_point(hydrogens_A, NEAREST_CH_A + _MARGIN_A)
    rows = np.repeat(np.arange(len(hydrogens_A)), [len(found) for found in near])
    points = heavy_A[np.array([row for found in near for row in found], dtype=np.int64)]
    away = np.linalg.norm(points - carriers_A[rows], axis=1)
    room = np.where(polar[rows], NEAREST_NH_A, NEAREST_CH_A)
    room = np.where(away < _BONDED_A, NEAREST_1_3_A, room)
    others = away > _SAME_A
    return rows[others], points[others], room[others]
