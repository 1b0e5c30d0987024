"""Algorithms 1 and 2 of the paper: Newton–Raphson with Armijo's line search, as printed.

Ameline et al., J. Comput. Phys. 373 (2018) 736, DOI 10.1016/j.jcp.2018.07.021, section 3.3.

Algorithm 1 drives the error ε(q2(f)) to zero over the six loads f. The Jacobian is taken by
central differences; where the algorithm does not converge it is run again from the same guess with
Ridders' extrapolated differences (both in ``derivatives``).
Algorithm 2 walks back along the Newton step, τ = 0.45, until the cost ½ ε² has fallen by Armijo's
share ω = 1e-4 of the linear prediction. Where no step of 51 is short enough the point is called
singular, and the algorithm starts anew from a guess whose s_ini is moved by a tenth of the period
(eq. 36), up to nine times.

What the paper leaves open, and what is taken here:

- ε_c, the bound on max|ε| at which the algorithm stops: the caller's; the public default is 1e-7,
  since success (eq. 39) is judged at 1e-5 on the Euler angles, which magnify ε where θ_R or η1 is
  small;
- each new guess of eq. 36 is tried with central differences first, then with Ridders' method;
- a linear system that cannot be solved counts as a singular point.

Legend: f loads (6,), y pose (7,), e error ε (6,), j Jacobian (6, 6), d Newton step (6,), cost C,
p physical parameters (5,).
"""

import math

import numpy as np

from loopelastica.rod.kernels.closed_form import period
from loopelastica.rod.kernels.finite_rod import loads_from_physical
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.linalg import eliminate
from loopelastica.rod.kernels.shooting import POSE
from loopelastica.rod.paper.derivatives import (
    central_jacobian,
    error_at,
    largest,
    norm,
    ridders_jacobian,
)
from loopelastica.rod.paper.errors import physical_pose, reduced_parameters, turn

CONVERGED, SINGULAR, TOO_MANY_ITERATIONS, NOT_FINITE = 0, 1, 2, 3

_ITERATIONS = 41  # Algorithm 1, line 3
_BACKTRACKS = 51  # Algorithm 2, line 4
_TAU, _OMEGA = 0.45, 1e-4  # Algorithm 2, lines 2 and 3


@kernel
def newton_step(j, e, a, d):
    """Newton step d = −J⁻¹ε (6,); False if J (6, 6) is singular. ``a`` (6, 7) is scratch."""
    for i in range(6):
        a[i, 6] = -e[i]
        for c in range(6):
            a[i, c] = j[i, c]
    if eliminate(a, 6, 6, 7, 0.0) == 0.0:
        return False
    for i in range(5, -1, -1):
        d[i] = a[i, 6]
        for c in range(i + 1, 6):
            d[i] -= a[i, c] * d[c]
        d[i] /= a[i, i]
    return largest(d) < math.inf


@kernel
def line_search(f, d, decrease, cost, target, kind, torsion_ratio, forward, y, trial, e):
    """Algorithm 2: ``f`` (6,) moves by the first step τ^j d that fulfils Armijo's rule.

    ``decrease`` is g·d, ``cost`` C at ``f``. False if no step does; ``e`` belongs to the last one.
    """
    t = 1.0
    for _ in range(_BACKTRACKS):
        for c in range(6):
            trial[c] = f[c] + t * d[c]
        if error_at(trial, target, kind, torsion_ratio, forward, y, e):
            size = norm(e)
            if 0.5 * size * size - cost < _OMEGA * t * decrease:  # line 7
                # a step below rounding leaves f where it is: null (Algorithm 1, line 12)
                moved = False
                for c in range(6):
                    moved = moved or trial[c] != f[c]
                    f[c] = trial[c]
                return moved
        t *= _TAU
    return False


@kernel
def newton(f, target, kind, torsion_ratio, forward, eps_c, ridders):
    """Algorithm 1 from the loads ``f`` (6,), in place.

    Parameters
    ----------
    f : (6,) array
        Guess, then result.
    target : (7,) array
        Pose given.
    kind, forward
        Error and mapping q2, see ``errors``.
    torsion_ratio
        K30.
    eps_c
        Bound on max|ε|.
    ridders
        Derivatives by Ridders' method.

    Returns
    -------
    status, iterations
        Iterations are Newton steps taken.
    """
    y, e, trial = np.empty(POSE), np.empty(6), np.empty(6)
    j, a, d = np.empty((6, 6)), np.empty((6, 7)), np.empty(6)
    if not error_at(f, target, kind, torsion_ratio, forward, y, e):
        return NOT_FINITE, 0
    for i in range(_ITERATIONS):
        if largest(e) < eps_c:  # line 4
            return CONVERGED, i
        cost = 0.5 * norm(e) ** 2  # line 7
        if ridders:  # line 8
            fine = ridders_jacobian(f, target, kind, torsion_ratio, forward, y, j)
        else:
            fine = central_jacobian(f, target, kind, torsion_ratio, forward, y, j)
        if not fine:
            return NOT_FINITE, i
        if not newton_step(j, e, a, d):  # line 10
            return SINGULAR, i
        decrease = 0.0  # g·d with g = Jᵀε (line 9)
        for c in range(6):
            for r in range(6):
                decrease += j[r, c] * e[r] * d[c]
        if not line_search(f, d, decrease, cost, target, kind, torsion_ratio, forward, y, trial, e):
            return SINGULAR, i + 1  # line 12
    if largest(e) < eps_c:
        return CONVERGED, _ITERATIONS
    return TOO_MANY_ITERATIONS, _ITERATIONS


@kernel
def reduced_loads(p, s_ini, torsion_ratio, f):
    """Loads ``f`` (6,) of a rod turned to η1 ≥ 0, η2 = 0 (eq. 15–19).

    ``p`` (5,) are its physical parameters, but for ``s_ini`` in place of theirs (eq. 36).
    """
    y, q = np.empty(POSE), np.empty(5)
    physical_pose(p[0], p[1], p[2], s_ini, p[4], torsion_ratio, y)
    angle = reduced_parameters(y, q)
    f[0], f[1], f[2], f[3], f[4], f[5] = loads_from_physical(
        p[0], p[1], p[2], 0.0, s_ini, p[4], torsion_ratio
    )
    turn(f, -angle)


@kernel
def invert(p, target, kind, torsion_ratio, forward, eps_c, restarts, f):
    """Section 3.3 from one guess: Algorithm 1, Ridders' derivatives, restarts by eq. 36.

    Parameters
    ----------
    p : (5,) array
        Guess λ, t_P, a, s_ini/μ, L/μ.
    target : (7,) array
        Pose given, with η2 = 0 and η1 ≥ 0.
    restarts
        At most; the paper's nine.
    f : (6,) array
        Loads found, on return.

    Returns
    -------
    status, iterations, restarts, ridders
        Iterations of all runs; index n_ini of the guess that was the last; runs with Ridders'
        derivatives.
    """
    iterations = 0
    runs = 0
    tenth = 0.1 * period(p[0], p[1], p[2])
    status = SINGULAR
    for n_ini in range(restarts + 1):
        if n_ini > 0 and not tenth < math.inf:
            return status, iterations, n_ini - 1, runs
        s_ini = p[3] + n_ini * tenth if n_ini > 0 else p[3]
        for ridders in range(2):
            reduced_loads(p, s_ini, torsion_ratio, f)
            status, count = newton(f, target, kind, torsion_ratio, forward, eps_c, ridders == 1)
            iterations += count
            runs += ridders
            if status == CONVERGED:
                return status, iterations, n_ini, runs
    return status, iterations, restarts, runs
