"""What every way to an equilibrium shares: tables of starts, the straight rod, records of a solve.

Starts are structured (``multistart``): an axis of tension with a whole number of turns, each
boundary layer on one side or the other. They go through closed-form boundary layers, multiple
shooting and the discrete rod.
"""

import math
import time

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.kernels.multistart import RETRIES, run_start, run_starts, shortening_of
from loopelastica.rod.kernels.newton import elastic_energy, newton
from loopelastica.rod.kernels.records import (
    LAYERS,
    Method,
    Outcome,
    Problem,
    Solution,
    Start,
    Status,
    new_solution,
    starts_array,
)
from loopelastica.rod.kernels.rotations import quaternion_from_matrix

# largest end error (position, rotation vector) of a converged solution on the check mesh, and
# the range of it: below, rounding decides; above, a residual means little
TOLERANCE = 1e-9
_TOLERANCES = 1e-11, 1e-3

# without the sides and the bows the lowest rod of about one random pose in a thousand is missed
_SIDES = ((False, False), (True, False), (False, True))
_PLAIN = tuple(Start(n, over_0=a, over_1=b) for n in (0.0, 1.0, -1.0) for a, b in _SIDES)
_LOWEST = (
    *_PLAIN,
    Start(bow=0.5),
    Start(1.0, bow=0.5, over_0=True),
    Start(-1.0, bow=0.5, over_0=True),
)
# twist costs next to nothing: more turns are worth a look
_SOFT = (*_LOWEST, *(Start(n) for n in (2.0, -2.0, 3.0, -3.0)))
_SOFT_RATIO = 0.1
_FREE = (
    *(Start(over_0=a, over_1=b) for a, b in (*_SIDES, (True, True))),
    Start(bow=0.5),
    Start(bow=1.5),
    Start(bow=0.8, over_0=True, over_1=True),
)
_TABLES = {
    name: starts_array(table)
    for name, table in (("free", _FREE), ("soft", _SOFT), ("lowest", _LOWEST))
}

# |η| above this is the straight rod or out of reach: the load of a bent one exceeds 1e17
STRAIGHT = 1e-9


class Deadline:
    """A time limit on a search; None for no limit.

    Parameters
    ----------
    limit_s : float or None
        Seconds from now.

    Raises
    ------
    ValueError
        If it is not a positive number.
    """

    def __init__(self, limit_s: float | None) -> None:
        if limit_s is not None and not (isinstance(limit_s, int | float) and limit_s > 0.0):
            raise ValueError(f"`time_limit_s` is {limit_s!r}; it must be a positive number")
        self._end = math.inf if limit_s is None else time.monotonic() + limit_s

    @property
    def passed(self) -> bool:
        """Whether the time is over."""
        return time.monotonic() >= self._end


def check_torsion_ratio(torsion_ratio: float) -> float:
    """K30 as a float; ValueError unless it is positive and finite."""
    value = float(torsion_ratio)
    if not (np.isfinite(value) and value > 0):
        raise ValueError(f"`torsion_ratio` is {torsion_ratio}; it must be positive and finite")
    return value


def check_tolerance(tolerance: float) -> float:
    """The largest residual of a solution as a float; ValueError unless it is a sensible one."""
    value = float(tolerance)
    least, most = _TOLERANCES
    if not least <= value <= most:
        raise ValueError(f"`tolerance` is {tolerance}; it must be between {least:g} and {most:g}")
    return value


def straight(clamping: Clamping, torsion_ratio: float) -> Equilibrium | None:
    """The rod stretched straight, or None if the clamping leaves it slack.

    Its ends fix no tension: any F along the rod is in equilibrium, and F = 0 is returned, with the
    twist of least energy.

    Parameters
    ----------
    clamping : Clamping
        With a free end spin the rod has no twist.
    torsion_ratio : float
        K30.

    Returns
    -------
    Equilibrium or None
        Its residual is how far the clamping is from a straight rod's, below 1e-8.

    Raises
    ------
    ValueError
        If no rod fits: the ends are further apart than its length, or as far with end tangents
        that do not point along it.
    """
    distance = float(np.linalg.norm(clamping.position))
    if distance < 1.0 - STRAIGHT:
        return None
    if distance > 1.0 + STRAIGHT:
        raise ValueError(
            f"`clamping` has its ends {distance:.9g} rod lengths apart; no rod reaches further"
            " than its length"
        )
    tangent_miss = np.linalg.norm(clamping.rotation[:, 2] - [0, 0, 1])
    if np.linalg.norm(clamping.position - [0, 0, 1]) > 1e-8 or tangent_miss > 1e-8:
        raise ValueError(
            "`clamping` stretches the rod to its full length, but its end tangents do not both"
            " point along it"
        )
    spin = 0.0
    if not clamping.free_spin:
        spin = float(np.arctan2(clamping.rotation[1, 0], clamping.rotation[0, 0]))
    moment = torsion_ratio * spin
    loads = np.array([0.0, 0.0, 0.0, 0.0, 0.0, moment])
    return Equilibrium(
        clamping,
        torsion_ratio,
        loads,
        0.5 * moment * spin,
        max(float(np.abs(clamping.position - [0, 0, 1]).max()), float(tangent_miss)),
        Status.CONVERGED,
        Method.STRAIGHT,
    )


def quaternion(clamping: Clamping) -> Array:
    """End frame as a quaternion (w, x, y, z)."""
    q: Array = quaternion_from_matrix(clamping.rotation.copy())
    return q


def problem_of(clamping: Clamping, torsion_ratio: float, tolerance: float = TOLERANCE) -> Problem:
    """A clamping in compiled code's terms."""
    position = clamping.position.copy()
    return Problem(
        position,
        quaternion(clamping),
        float(shortening_of(position)),
        torsion_ratio,
        clamping.free_spin,
        tolerance,
    )


def standard_starts(torsion_ratio: float, free_spin: bool) -> Array:
    """Standard starts (n,) of `records.START`."""
    name = "free" if free_spin else "soft" if torsion_ratio < _SOFT_RATIO else "lowest"
    table: Array = _TABLES[name]
    return table


def from_standard_starts(
    clamping: Clamping,
    torsion_ratio: float,
    lowest: bool = False,
    tolerance: float = TOLERANCE,
) -> Equilibrium:
    """The first or the lowest equilibrium that the standard starts find.

    Parameters
    ----------
    clamping : Clamping
        Slack: with its ends less than the rod's length apart.
    torsion_ratio : float
        K30.
    lowest : bool
        Finish all starts that may lead to the lowest; otherwise stop at the first solution.
    tolerance : float
        Largest residual of a solution.

    Returns
    -------
    Equilibrium
        With the status ``STALLED`` where no start arrived.
    """
    solution = new_solution()
    problem = problem_of(clamping, torsion_ratio, tolerance)
    starts = standard_starts(torsion_ratio, clamping.free_spin)
    outcome = run_starts(problem, starts, RETRIES, lowest, solution)
    return from_solution(clamping, torsion_ratio, outcome, solution)


def from_start(
    clamping: Clamping, torsion_ratio: float, start: Start, tolerance: float = TOLERANCE
) -> Equilibrium:
    """What one start leads to."""
    solution = new_solution()
    problem = problem_of(clamping, torsion_ratio, tolerance)
    outcome = run_start(problem, starts_array((start,))[0], solution)
    return from_solution(clamping, torsion_ratio, outcome, solution)


def from_loads(
    clamping: Clamping,
    torsion_ratio: float,
    loads: Array,
    patience: int,
    method: Method = Method.SHOOTING,
    tolerance: float = TOLERANCE,
) -> Equilibrium:
    """Newton's method from given loads.

    Parameters
    ----------
    clamping : Clamping
        The goal.
    torsion_ratio : float
        K30.
    loads : (6,) ndarray
        F and M at s = 0 in the start frame to begin with; left as they are.
    patience : int
        Steps made at least, if they are needed; more follow as long as each halves the error.
    method : Method
        What the result is to be labelled with.
    tolerance : float
        Largest residual of a solution.

    Returns
    -------
    Equilibrium
        Determined by its loads alone; energy and residual are inf where nothing was found.
    """
    f = np.array(loads, dtype=np.float64)
    status, residual, _, end = newton(problem_of(clamping, torsion_ratio, tolerance), f, patience)
    if status != Status.CONVERGED:
        return Equilibrium(clamping, torsion_ratio, f, math.inf, math.inf, Status(status), method)
    energy = float(elastic_energy(f, end[:3], torsion_ratio))
    return Equilibrium(
        clamping, torsion_ratio, f, energy, float(residual), Status.CONVERGED, method
    )


def from_solution(
    clamping: Clamping, torsion_ratio: float, outcome: Outcome, solution: Solution
) -> Equilibrium:
    """The equilibrium of an outcome and its record."""
    method = Method(outcome.method)
    status = Status.STALLED if method == Method.NONE else Status.CONVERGED
    m = outcome.segments + 1 if outcome.segments else 0
    nodes, layers = solution.nodes, np.zeros(0, LAYERS)
    common = (
        clamping,
        torsion_ratio,
        solution.loads,
        float(outcome.energy),
        float(outcome.residual),
        status,
        method,
    )
    if m:
        return Equilibrium(*common, nodes.s[:m], nodes.pose[:m])
    if method in LAYERED:
        layers = solution.layers
    return Equilibrium(*common, layers=layers)


# methods whose result, without nodes, is two boundary layers; with others the loads determine it
LAYERED = (Method.BOUNDARY_LAYERS, Method.DISCRETE_ROD_LAYERS)
