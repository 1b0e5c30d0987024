"""Numerical continuation in an end angle: section 4.5 and Fig. 6 of the paper.

Ameline et al., J. Comput. Phys. 373 (2018) 736, DOI 10.1016/j.jcp.2018.07.021: one of ψ_R, θ_R,
φ_R "is increased progressively using algorithms 1 and 2 initialized at the current elastic rod".
The paper gives no step. Here the step of the angle is halved where Algorithm 1 fails, needs more
than a few iterations or moves the loads too far at once (another branch may have been met), and
grows by half where it was easy. Below the least step the branch is said to end: a fold, where the
Jacobian is singular.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from loopelastica._arrays import Array, read_only
from loopelastica._checks import shown
from loopelastica.rod._arguments import check_loads
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.paper.solver import ERRORS, FORWARD

_ANGLES = {"psi": 3, "theta": 4, "phi": 5}
# radians; a turn takes at least 60 steps
_FIRST_STEP, _LARGEST_STEP, _LEAST_STEP = 0.05, math.tau / 60.0, 1e-6
_EASY, _HARD = 4, 8
# a step may move the loads by this share of their natural size, 1 + |f|
_JUMP = 0.25


@dataclass(frozen=True, slots=True, eq=False)
class Continuation:
    """A branch of equilibria.

    Attributes
    ----------
    angles : (n,) ndarray
        Values of the angle, radians, not reduced to one turn.
    loads : (n, 6) ndarray
        F and M at S = 0 in the start frame, in K0/L² and K0/L.
    converged : bool
        Whether the last angle is the one requested.
    """

    angles: Array
    loads: Array
    converged: bool


def continue_angle(
    loads: ArrayLike,
    clamping: Clamping,
    which: str = "phi",
    turns: float = 1.0,
    torsion_ratio: float = 1.0,
    error: str = "eps2",
    tolerance: float = 1e-9,
) -> Continuation:
    """Follow an equilibrium while an end angle turns.

    Parameters
    ----------
    loads : (6,) array_like
        Loads of an equilibrium of `clamping`, or near to one.
    clamping : Clamping
        Clamping to start from, without a free end spin.
    which : str
        "psi", "theta" or "phi": the ZYZ Euler angle of the end frame that changes.
    turns : float
        By how much, in turns of 2π, of either sign.
    torsion_ratio : float
        K30 = K3/K0.
    error : str
        "eps1", "eps2" or "eps3"; ε1 cannot pass the seams of the angles.
    tolerance : float
        ε_c of Algorithm 1.

    Returns
    -------
    Continuation

    Raises
    ------
    ValueError
        If `which` or `error` is unknown, `loads` is not six finite numbers, or the end spin is
        free.
    """
    from loopelastica.rod.paper import errors as kernels
    from loopelastica.rod.paper import newton as algorithms

    if which not in _ANGLES:
        raise ValueError(f"`which` is {shown(which)}; it must be one of {sorted(_ANGLES)}")
    if error not in ERRORS:
        raise ValueError(f"`error` is {shown(error)}; it must be one of {sorted(ERRORS)}")
    if clamping.free_spin:
        raise ValueError("`clamping` has a free end spin; the paper's method clamps it")
    current = check_loads(loads)
    q = clamping.parameters

    def at(travel: float, start: Array) -> tuple[Array, int, bool]:
        """Loads at an angle ``travel`` from the first, by Algorithm 1 from ``start``."""
        turned = q.copy()
        turned[_ANGLES[which]] += travel
        target = np.empty(7)
        end = Clamping.from_parameters(turned)
        kernels.pose_of_frame(np.array(end.position), np.array(end.rotation), target)
        f = start.copy()
        status, iterations = algorithms.newton(
            f, target, ERRORS[error], torsion_ratio, FORWARD["printed"], tolerance, False
        )
        return f, iterations, status == algorithms.CONVERGED

    current, _, fine = at(0.0, current)
    path, angles = [current], [float(q[_ANGLES[which]])]
    goal, travel, step = math.tau * turns, 0.0, _FIRST_STEP
    while fine and travel != goal and step >= _LEAST_STEP:
        rest = goal - travel
        last = abs(rest) <= step
        ahead = goal if last else travel + math.copysign(step, rest)
        f, iterations, solved = at(ahead, current)
        jump = float(np.linalg.norm(f - current))
        if not solved or iterations > _HARD or jump > _JUMP * (1.0 + np.linalg.norm(current)):
            step *= 0.5
            continue
        travel, current = ahead, f
        path.append(current)
        angles.append(float(q[_ANGLES[which]]) + travel)
        if iterations <= _EASY:
            step = min(1.5 * step, _LARGEST_STEP)
    return Continuation(read_only(angles), read_only(path), bool(fine and travel == goal))
