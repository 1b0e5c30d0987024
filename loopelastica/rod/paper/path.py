"""The paper's testing path (eq. 37), and the scan of the grid for the nearest guess.

Ameline et al., J. Comput. Phys. 373 (2018) 736, DOI 10.1016/j.jcp.2018.07.021, sections 3.2 and
4.1. The scan is exhaustive and by the norm of ε1; section 4.4 once scans by ε3 as well.
"""

import math

import numpy as np

from loopelastica.rod.kernels.finite_rod import physical_from_loads
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.shooting import POSE
from loopelastica.rod.paper.errors import (
    EPS1,
    error,
    physical_pose,
    pose_of_parameters,
    reduced_parameters,
)
from loopelastica.rod.paper.newton import CONVERGED, invert


@kernel
def nearest(images, q):
    """Index of the row of ``images`` (n, 5) with the least norm of ε1 against ``q`` (5,)."""
    best, index = math.inf, 0
    q0, q1, q2, q3, q4 = q[0], q[1], q[2], q[3], q[4]
    for i in range(images.shape[0]):
        d0, d1, d2 = images[i, 0] - q0, images[i, 1] - q1, images[i, 2] - q2
        d3, d4 = images[i, 3] - q3, images[i, 4] - q4
        distance = d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3 + d4 * d4
        if distance < best:
            best, index = distance, i
    return index


@kernel
def distances(images, q, kind, out):
    """Squared norms ``out`` (n,) of ε1, ε2 or ε3 of ``images`` (n, 5) against ``q`` (5,)."""
    y, target, e = np.empty(POSE), np.empty(POSE), np.empty(6)
    pose_of_parameters(q, target)
    for i in range(images.shape[0]):
        pose_of_parameters(images[i], y)
        error(kind, y, target, e)  # η2 = 0 in both: five components count
        out[i] = 0.0
        for c in range(6):
            out[i] += e[c] * e[c]


@kernel
def path(p, points, images, symmetric, scan, kind, torsion_ratio, forward, eps_c, restarts):
    """The testing path (eq. 37) of the physical parameters ``p`` (5,).

    p → q1 → inversion from the nearest guess → p̄ → q1, all compiled. ``scan`` is the error that
    chooses the guess, ``kind`` the one driven to zero.

    Returns
    -------
    defect, iterations, restarts, ridders, status
        ``defect`` is max|q_5D − q̄_5D| (eq. 39), inf where nothing was found; its angles are
        compared as printed, without regard to 2π.
    """
    y, q, back, f = np.empty(POSE), np.empty(5), np.empty(5), np.empty(6)
    physical_pose(p[0], p[1], p[2], p[3], p[4], torsion_ratio, y)
    reduced_parameters(y, q)
    if symmetric and q[4] > math.pi:  # eq. 35
        q[2] = (2.0 * math.pi - q[2]) % (2.0 * math.pi)
        q[4] = (2.0 * math.pi - q[4]) % (2.0 * math.pi)
    pose_of_parameters(q, y)
    if scan == EPS1:
        i = nearest(images, q)
    else:
        away = np.empty(images.shape[0])
        distances(images, q, scan, away)
        i = np.argmin(away)
    status, iterations, restarts, runs = invert(
        points[i], y, kind, torsion_ratio, forward, eps_c, restarts, f
    )
    if status != CONVERGED:
        return math.inf, iterations, restarts, runs, status
    lam, t_p, a, _, s_ini, length = physical_from_loads(
        f[0], f[1], f[2], f[3], f[4], f[5], torsion_ratio
    )
    physical_pose(lam, t_p, a, s_ini, length, torsion_ratio, y)
    reduced_parameters(y, back)
    defect = 0.0
    for c in range(5):
        defect = max(defect, abs(q[c] - back[c]))
    return defect, iterations, restarts, runs, status


@kernel
def paths(
    trials, points, images, symmetric, scan, kind, torsion_ratio, forward, eps_c, restarts, out
):
    """`path` of each row of ``trials`` (n, 5) into the row of ``out`` (n, 5)."""
    for i in range(trials.shape[0]):
        out[i, 0], out[i, 1], out[i, 2], out[i, 3], out[i, 4] = path(
            trials[i],
            points,
            images,
            symmetric,
            scan,
            kind,
            torsion_ratio,
            forward,
            eps_c,
            restarts,
        )
