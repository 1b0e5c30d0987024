"""Restored chemistry (step iv): least squares of ideal geometry with the stem held fixed.

Every term is a residual over its standard deviation: bond lengths, angles (as distances of the two
outer atoms), signed volumes (chirality, and planarity where the volume is zero), torsions α γ ζ
that are not staggered, overlap of atoms nearer than they may be, distance of each nucleotide's
backbone centroid from the line, and a weak tether of every atom to where the line had carried it.
The tethers make the minimum a smooth function of the input.

rdkit's force fields were tried in its place, with the stem fixed and the backbone held near the
line, on the first candidates of 2KOC, 1BJH, 1AC7, 1JUR, 1KR8 and 1HLX. Share of bonds within 0.05 Å
and of angles within 6° of the values of :mod:`.ideal`:

    MMFF94 98.5 % and 98.7 % (rms 0.019 Å, 2.0°)    UFF 79.6 % and 85.3 % (0.061 Å, 4.3°)
    these residuals 100 % and 99.6 % (0.001 Å, 0.9°)

MMFF94 restores sugar and phosphate much better than UFF, which makes O3'–P 0.11 Å too long and
turns hands over; neither reaches 99 % of the bonds, for their equilibrium values are not those of
nucleotides in crystals.

The sum of squares is minimized by Levenberg & Marquardt's method with the exact Jacobian. The pairs
that may overlap are listed anew from time to time.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import splu

from loopelastica._arrays import Array, Record

Index = NDArray[np.int64]

OVERLAP_SD_A: Final = 0.05
"""Deviation of overlaps: 0.2 Å too near weighs like a bond that is 0.05 Å too long."""
_LISTED_A: Final = 1.5
_RELIST: Final = 8


class Status(IntEnum):
    """How a minimization ended."""

    CONVERGED = 0
    STEPS = 1
    TIME = 2


MESSAGES: Final = {
    Status.CONVERGED: "converged",
    Status.STEPS: "the limit of steps was reached",
    Status.TIME: "the limit of time was reached",
}


@dataclass(frozen=True, slots=True, eq=False)
class Restraints:
    """Terms over N atoms, of which the first `n_moving` move.

    Attributes
    ----------
    n_moving : int
    pairs, length_A, length_sd : (p, 2), (p,), (p,) array
        Distances: bonds and angles.
    quads, volume, volume_sd : (q, 4), (q,), (q,) array
        (b − a) · (c − a) × (d − a) in Å³ for atoms a b c d.
    torsions, torsion_sd : (t, 4), float
        Torsions a–b–c–d that like to be staggered (60°, 180°, 300°): residual cos(3φ/2).
    groups, center_A, center_sd : (g, m), (g, 3), float
        Centroids held to points.
    tether_A, tether_sd : (n_moving, 3), float
        Places the atoms are held to.
    near, near_A : (r, 2), (r,) array
        Pairs that must not be nearer than this.
    """

    n_moving: int
    pairs: Index
    length_A: Array
    length_sd: Array
    quads: Index
    volume: Array
    volume_sd: Array
    torsions: Index
    torsion_sd: float
    groups: Index
    center_A: Array
    center_sd: float
    tether_A: Array
    tether_sd: float
    near: Index
    near_A: Array


@dataclass(frozen=True, slots=True, eq=False)
class Relaxed(Record):
    """Result: positions (N, 3), status, steps and the final sum of squares by kind of term."""

    positions_A: Array
    status: Status
    steps: int
    cost: dict[str, float]

    @property
    def message(self) -> str:
        """The status in words."""
        return MESSAGES[self.status]


def relax(
    restraints: Restraints,
    start_A: Array,
    *,
    max_steps: int = 200,
    max_seconds: float = 30.0,
    tolerance_A: float = 1e-6,
) -> Relaxed:
    """Minimize from `start_A` (N, 3); atoms from `n_moving` on stay where they are.

    Parameters
    ----------
    restraints : Restraints
    start_A : (N, 3) array
    max_steps : int
        Most accepted or refused trial steps.
    max_seconds : float
        Wall time after which it stops; the result then depends on the machine.
    tolerance_A : float
        Converged when no atom moves further in a step.

    Returns
    -------
    Relaxed
    """
    x = np.array(start_A, dtype=np.float64)
    limit = time.monotonic() + max_seconds
    listed = _listed(restraints, x)
    damping = 1e-2
    residual, jacobian = _evaluate(restraints, x, listed)
    cost = float(residual @ residual)
    status, steps = Status.STEPS, 0
    for steps in range(1, max_steps + 1):
        if time.monotonic() > limit:
            status = Status.TIME
            break
        normal = jacobian.T @ jacobian
        damped = csc_array(normal + diags_array(damping * normal.diagonal()))
        # atoms far apart share no term: the sparse solution is quick, and the same on every machine
        # whatever the number of its cores
        factors = splu(damped, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
        step = -factors.solve(jacobian.T @ residual).reshape(-1, 3)
        longest = float(np.linalg.norm(step, axis=1).max())
        # one step may not carry an atom through another
        if longest > 0.25:
            step *= 0.25 / longest
        trial = x.copy()
        trial[: restraints.n_moving] += step
        other, other_jacobian = _evaluate(restraints, trial, listed)
        other_cost = float(other @ other)
        if other_cost < cost:
            x, residual, jacobian, cost = trial, other, other_jacobian, other_cost
            damping = max(damping / 4.0, 1e-9)
            if steps % _RELIST == 0 or longest < tolerance_A:
                listed = _listed(restraints, x)
                residual, jacobian = _evaluate(restraints, x, listed)
                cost = float(residual @ residual)
            if longest < tolerance_A:
                status = Status.CONVERGED
                break
        else:
            if longest < tolerance_A:
                status = Status.CONVERGED
                break
            damping = min(damping * 6.0, 1e9)
    return Relaxed(x, status, steps, _by_kind(restraints, x))


def _listed(restraints: Restraints, x: Array) -> tuple[Index, Array]:
    """The pairs near enough to overlap within some steps."""
    near = restraints.near
    apart = np.linalg.norm(x[near[:, 0]] - x[near[:, 1]], axis=1)
    chosen = apart < restraints.near_A + _LISTED_A
    return near[chosen], restraints.near_A[chosen]


def _evaluate(restraints: Restraints, x: Array, listed: tuple[Index, Array]) -> tuple[Array, Any]:
    """Residuals (m,) and their sparse Jacobian (m, 3 n_moving)."""
    r = restraints
    free = 3 * r.n_moving
    values, rows, columns, entries = [], [], [], []
    count = 0
    for value, index, gradient in (
        _distances(x, r.pairs, r.length_A, r.length_sd),
        _overlaps(x, *listed),
        _volumes(x, r.quads, r.volume, r.volume_sd),
        _staggered(x, r.torsions, r.torsion_sd),
    ):
        values.append(value)
        row = np.broadcast_to(count + np.arange(len(value))[:, None, None], gradient.shape)
        column = 3 * index[:, :, None] + np.arange(3)
        moves = np.broadcast_to(column < free, gradient.shape)
        rows.append(row[moves])
        columns.append(column[moves])
        entries.append(gradient[moves])
        count += len(value)
    size = r.groups.shape[1]
    away = (x[r.groups].mean(axis=1) - r.center_A) / r.center_sd
    values.append(away.ravel())
    column = 3 * r.groups[:, :, None] + np.arange(3)
    row = count + 3 * np.arange(len(r.groups))[:, None, None] + np.arange(3)
    rows.append(np.broadcast_to(row, column.shape).ravel())
    columns.append(column.ravel())
    entries.append(np.full(column.size, 1.0 / (size * r.center_sd)))
    count += away.size
    values.append(((x[: r.n_moving] - r.tether_A) / r.tether_sd).ravel())
    rows.append(count + np.arange(free))
    columns.append(np.arange(free))
    entries.append(np.full(free, 1.0 / r.tether_sd))
    place = (np.concatenate(rows), np.concatenate(columns))
    jacobian = csc_array((np.concatenate(entries), place), shape=(count + free, free))
    return np.concatenate(values), jacobian


def _distances(x: Array, pairs: Index, length: Array, sd: Array) -> tuple[Array, Index, Array]:
    between = x[pairs[:, 0]] - x[pairs[:, 1]]
    apart = np.maximum(np.linalg.norm(between, axis=1), 1e-6)
    direction = between / (apart * sd)[:, None]
    return (apart - length) / sd, pairs, np.stack([direction, -direction], axis=1)


def _overlaps(x: Array, pairs: Index, least: Array) -> tuple[Array, Index, Array]:
    between = x[pairs[:, 0]] - x[pairs[:, 1]]
    apart = np.maximum(np.linalg.norm(between, axis=1), 1e-6)
    touching = apart < least
    pairs, between, apart, least = (
        pairs[touching],
        between[touching],
        apart[touching],
        least[touching],
    )
    direction = between / (apart * OVERLAP_SD_A)[:, None]
    return (apart - least) / OVERLAP_SD_A, pairs, np.stack([direction, -direction], axis=1)


def _volumes(x: Array, quads: Index, volume: Array, sd: Array) -> tuple[Array, Index, Array]:
    a = x[quads[:, 0]]
    b, c, d = (x[quads[:, column]] - a for column in (1, 2, 3))
    along_b, along_c, along_d = np.cross(c, d), np.cross(d, b), np.cross(b, c)
    gradient = np.stack([-along_b - along_c - along_d, along_b, along_c, along_d], axis=1)
    value = (b * along_b).sum(axis=1)
    return (value - volume) / sd, quads, gradient / sd[:, None, None]


def _staggered(x: Array, quads: Index, sd: float) -> tuple[Array, Index, Array]:
    a, b, c, d = (x[quads[:, column]] for column in range(4))
    u, axis, v = b - a, c - b, d - c
    m, n = np.cross(u, axis), np.cross(axis, v)
    length = np.linalg.norm(axis, axis=1)
    angle = np.arctan2(length * (u * n).sum(axis=1), (m * n).sum(axis=1))
    # the gradient of a torsion: Blondel & Karplus, J. Comput. Chem. 17 (1996) 1132
    at_a = -m * (length / np.maximum((m * m).sum(axis=1), 1e-9))[:, None]
    at_d = n * (length / np.maximum((n * n).sum(axis=1), 1e-9))[:, None]
    along_u = ((u * axis).sum(axis=1) / length**2)[:, None]
    along_v = ((v * axis).sum(axis=1) / length**2)[:, None]
    at_b = -at_a - along_u * at_a + along_v * at_d
    at_c = -at_d + along_u * at_a - along_v * at_d
    gradient = np.stack([at_a, at_b, at_c, at_d], axis=1)
    slope = -1.5 * np.sin(1.5 * angle) / sd
    return np.cos(1.5 * angle) / sd, quads, slope[:, None, None] * gradient


def _by_kind(restraints: Restraints, x: Array) -> dict[str, float]:
    r = restraints
    listed = _listed(r, x)
    lengths, _, _ = _distances(x, r.pairs, r.length_A, r.length_sd)
    overlaps, _, _ = _overlaps(x, *listed)
    volumes, _, _ = _volumes(x, r.quads, r.volume, r.volume_sd)
    torsions, _, _ = _staggered(x, r.torsions, r.torsion_sd)
    away = (x[r.groups].mean(axis=1) - r.center_A) / r.center_sd
    tethers = (x[: r.n_moving] - r.tether_A) / r.tether_sd
    return {
        "lengths_and_angles": float(lengths @ lengths),
        "overlaps": float(overlaps @ overlaps),
        "chirality_and_planarity": float(volumes @ volumes),
        "torsions": float(torsions @ torsions),
        "line": float((away**2).sum()),
        "tethers": float((tethers**2).sum()),
    }
