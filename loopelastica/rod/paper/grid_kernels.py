"""Columns of the paper's grid of guesses and of its tested rods, compiled.

Ameline et al., J. Comput. Phys. 373 (2018) 736, DOI 10.1016/j.jcp.2018.07.021, eq. 33–35 and
40–42; :mod:`loopelastica.rod.paper.grid` explains the reading. A column is one (λ, t_P); its rows
(n, 10) hold λ, t_P, a, s_ini/μ, L/μ and the image η1, η3, ψ_R, θ_R, φ_R.
"""

import math

import numpy as np

from loopelastica.rod.kernels.closed_form import constants, landau_pose, period
from loopelastica.rod.kernels.cubic import a_min
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.shooting import POSE
from loopelastica.rod.paper.errors import TURN, physical_pose, reduced_parameters, seen_from

_LONGEST = 0.95  # of the period, for s_ini (eq. 40); of the length, for the chord (eq. 42)
_SHORTEST = 0.1  # L/μ (eq. 40)
_ROUNDING = 1e-9  # of a step: an upper bound met but for rounding belongs to the ladder


@kernel
def rungs(low, high, step):
    """Number of points low, low + step, … up to high."""
    return max(math.floor((high - low) / step + _ROUNDING) + 1, 0)


@kernel
def _ranges(lam, t_p, a, margin, step):
    """Numbers of points in s_ini and L at one (λ, t_P, a); none where the period is infinite."""
    whole = period(lam, t_p, a)
    if not whole < math.inf:
        return 0, 0
    return (
        rungs(margin, _LONGEST * whole - margin, step),
        rungs(_SHORTEST + margin, whole - margin, step),
    )


@kernel
def _column(lam, t_p, replaced, low, high, margin, step, torsion_ratio):
    """Rows (n, 10) of a column; ``replaced`` is the t_P of the rods, ``t_p`` that of the bounds."""
    floor_a = a_min(lam, replaced)
    heights = rungs(low, high, step)
    size = 0
    for i in range(heights):
        starts, lengths = _ranges(lam, t_p, low + i * step, margin, step)
        size += starts * lengths
    rows = np.empty((size, 10))
    y = np.empty(POSE)
    spin = replaced * (1.0 / torsion_ratio - 1.0)
    at = 0
    for i in range(heights):
        a = low + i * step
        starts, lengths = _ranges(lam, t_p, a, margin, step)
        a = max(a, floor_a)
        c, scale = constants(lam, replaced, a)
        for j in range(starts):
            s_ini = margin + j * step
            first = landau_pose(s_ini, 0.0, spin, c, scale)
            for k in range(lengths):
                length = _SHORTEST + margin + k * step
                second = landau_pose(s_ini + length, 0.0, spin, c, scale)
                seen_from(first, second, length, y)
                row = rows[at]
                row[0], row[1], row[2], row[3], row[4] = lam, replaced, a, s_ini, length
                reduced_parameters(y, row[5:])
                at += 1
    return rows


@kernel
def guesses(lam, t_p, size, step, no_twist, symmetric, torsion_ratio):
    """Guesses (n, 10) of one column of the grid (eq. 40)."""
    replaced = t_p if abs(t_p) > _ROUNDING else no_twist
    rows = _column(lam, t_p, replaced, a_min(lam, t_p), size * size, 0.0, step, torsion_ratio)
    if symmetric:
        for i in range(rows.shape[0]):
            if rows[i, 9] > math.pi:  # eq. 34–35
                rows[i, 0], rows[i, 1] = -rows[i, 0], -rows[i, 1]
                rows[i, 7] = (TURN - rows[i, 7]) % TURN
                rows[i, 9] = TURN - rows[i, 9]
    return rows


@kernel
def trials(lam, t_p, size, margin, step):
    """Tested rods (n, 10) of one column, ``margin`` inside the bounds (section 4.3)."""
    low = a_min(lam, t_p) + margin
    rows = _column(lam, t_p, t_p, low, size * size - margin, margin, step, 1.0)
    keep = np.sqrt(rows[:, 5] ** 2 + rows[:, 6] ** 2) < _LONGEST  # eq. 42
    return rows[keep]


@kernel
def poses(points, torsion_ratio):
    """End poses (n, 7), position and quaternion, of physical parameters (n, 5), φ0 = 0 (q1)."""
    out = np.empty((points.shape[0], POSE))
    for i in range(points.shape[0]):
        p = points[i]
        physical_pose(p[0], p[1], p[2], p[3], p[4], torsion_ratio, out[i])
    return out


@kernel
def images(points, torsion_ratio):
    """Images (n, 5) of physical parameters (n, 5) under the closed form q1 (eq. 20)."""
    out, y = np.empty((points.shape[0], 5)), np.empty(POSE)
    for i in range(points.shape[0]):
        p = points[i]
        physical_pose(p[0], p[1], p[2], p[3], p[4], torsion_ratio, y)
        reduced_parameters(y, out[i])
    return out
