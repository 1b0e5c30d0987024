"""What every way to an equilibrium shares: tables of starts, the straight rod, records of a solve.

Starts are structured (``multistart``): an axis of tension with a whole number of turns, each
boundary layer on one side or the other. They go through closed-form boundary layers, multiple
shooting and the discrete rod.
"""

import math
import time
from typing import Any

import numpy as np

from loopelastica._arrays import Array
from loopelastica._checks import between, positive
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.kernels.multistart import (
    RETRIES,
    Problems,
    Rows,
    Search,
    new_rows,
    run_batch,
    shortening_of,
)
from loopelastica.rod.kernels.records import Method, Problem, Start, Status, starts_array
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
# near K30 = 1 two of them led to no lowest rod that the others missed, in 27,000 random poses and
# 500 symmetric ones
_EVEN = (*_PLAIN[:4], *_PLAIN[6:], *_LOWEST[len(_PLAIN) :])
_EVEN_RATIOS = 0.7, 1.5
# twist costs next to nothing: more turns are worth a look
_SOFT = (*_LOWEST, *(Start(n) for n in (2.0, -2.0, 3.0, -3.0)))
_SOFT_RATIO = 0.1
_FREE = (
    *(Start(over_0=a, over_1=b) for a, b in _SIDES),
    Start(bow=1.5),
    Start(bow=0.8, over_0=True, over_1=True),
)
_TABLES = {
    name: starts_array(table)
    for name, table in (("free", _FREE), ("soft", _SOFT), ("even", _EVEN), ("lowest", _LOWEST))
}

_NO_STARTS = starts_array(())
_NOTHING, _NONE_KNOWN = np.zeros((1, 0, 6)), np.zeros(1, np.int64)

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
        seconds = math.inf if limit_s is None else positive("time_limit_s", limit_s)
        self._end = time.monotonic() + seconds

    @property
    def passed(self) -> bool:
        """Whether the time is over."""
        return time.monotonic() >= self._end

    @property
    def left_s(self) -> float | None:
        """Seconds left, more than 0 even if it has passed; None without a limit."""
        return None if math.isinf(self._end) else max(self._end - time.monotonic(), 1e-9)


def check_tolerance(tolerance: float) -> float:
    """The largest residual of a solution; ValueError unless it is a sensible one."""
    value: float = between(*_TOLERANCES)("tolerance", tolerance)
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
    distance = math.hypot(*clamping.position)
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
    name = "lowest"
    if free_spin:
        name = "free"
    elif torsion_ratio < _SOFT_RATIO:
        name = "soft"
    elif _EVEN_RATIOS[0] <= torsion_ratio <= _EVEN_RATIOS[1]:
        name = "even"
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
        With its ends less than the rod's length apart.
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
    starts = standard_starts(torsion_ratio, clamping.free_spin)
    search = Search(_NOTHING, _NONE_KNOWN, 0, starts, RETRIES, lowest, True, True)
    return _searched(clamping, torsion_ratio, search, tolerance)


def from_start(
    clamping: Clamping, torsion_ratio: float, start: Start, tolerance: float = TOLERANCE
) -> Equilibrium:
    """What one start leads to."""
    starts = starts_array((start,))
    search = Search(_NOTHING, _NONE_KNOWN, 0, starts, _NO_STARTS, False, False, True)
    return _searched(clamping, torsion_ratio, search, tolerance)


def from_loads(
    clamping: Clamping,
    torsion_ratio: float,
    loads: Array,
    patience: int,
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
    tolerance : float
        Largest residual of a solution.

    Returns
    -------
    Equilibrium
        Determined by its loads alone; energy and residual are inf where nothing was found.
    """
    guess = np.array(loads, dtype=np.float64).reshape(1, 1, 6)
    known = np.ones(1, np.int64)
    search = Search(guess, known, patience, _NO_STARTS, _NO_STARTS, False, False, True)
    return _searched(clamping, torsion_ratio, search, tolerance)


def _searched(
    clamping: Clamping, torsion_ratio: float, search: Search, tolerance: float
) -> Equilibrium:
    rows = new_rows(1)
    poses = clamping.position[None].copy(), quaternion(clamping)[None]
    run_batch(Problems(*poses, torsion_ratio, clamping.free_spin, tolerance), search, rows)
    return equilibrium_of(clamping, torsion_ratio, rows, 0)


def equilibrium_of(clamping: Clamping, torsion_ratio: float, rows: Rows, i: int) -> Equilibrium:
    """What row ``i`` came to, ``STALLED`` where there is no solution."""
    method = Method(rows.method[i])
    return Equilibrium(
        clamping,
        torsion_ratio,
        rows.loads[i],
        float(rows.energy[i]),
        float(rows.residual[i]),
        Status.STALLED if method == Method.NONE else Status.CONVERGED,
        method,
        **record_of(rows, i),
    )


def record_of(rows: Rows, i: int) -> dict[str, Any]:
    """What row ``i`` needs beside its loads, as fields of an equilibrium; copies."""
    m = int(rows.segments[i])
    if m:
        nodes = rows.node_s[i, : m + 1], rows.node_pose[i, : m + 1]
        return {"node_s": nodes[0].copy(), "node_pose": nodes[1].copy()}
    if rows.method[i] in _LAYERED and not rows.shot[i]:
        return {"layers": rows.layers[i : i + 1].copy()}
    return {}


# methods whose result, without nodes, is two boundary layers
_LAYERED = (Method.BOUNDARY_LAYERS, Method.DISCRETE_ROD_LAYERS)
