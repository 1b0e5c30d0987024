"""What every way to an equilibrium shares: tables of starts, the straight rod, records of a solve.

Starts are structured (``multistart``): an axis of tension with a whole number of turns, each
boundary layer on one side or the other. They go through closed-form boundary layers, multiple
shooting and the discrete rod.
"""

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibrium import METHODS, Equilibrium, Status

# largest end error (position, rotation vector) of a converged solution on the check mesh
TOLERANCE = 1e-9

# turns, sides (start, end) and kick of the standard starts. Without the sides and the kicks the
# lowest rod of about one random pose in a thousand is missed
_PLAIN = tuple((n, *sides, 0.0) for n in (0, 1, -1) for sides in ((0, 0), (1, 0), (0, 1)))
_LOWEST = (*_PLAIN, (0, 0, 0, 0.5), (1, 1, 0, 0.5), (-1, 1, 0, 0.5))
# twist costs next to nothing: more turns are worth a look
_SOFT = (*_LOWEST, (2, 0, 0, 0.0), (-2, 0, 0, 0.0), (3, 0, 0, 0.0), (-3, 0, 0, 0.0))
_FREE = (
    *((0, *sides, 0.0) for sides in ((0, 0), (1, 0), (0, 1), (1, 1))),
    *((0, 0, 0, 0.5), (0, 0, 0, 1.5), (0, 1, 1, 0.8)),
)
_SOFT_RATIO = 0.1

# |η| above this is the straight rod or out of reach: the load of a bent one exceeds 1e17
STRAIGHT = 1e-9


def check_torsion_ratio(torsion_ratio: float) -> float:
    """K30 as a float; ValueError unless it is positive and finite."""
    value = float(torsion_ratio)
    if not (np.isfinite(value) and value > 0):
        raise ValueError(f"`torsion_ratio` is {torsion_ratio}; it must be positive and finite")
    return value


def straight(clamping: Clamping, torsion_ratio: float) -> Equilibrium | None:
    """The rod stretched straight, or None if the clamping leaves it slack.

    Its ends fix no tension: any F along the rod is in equilibrium, and F = 0 is returned, with the
    twist of least energy. Raises ValueError if no rod fits.
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
        "straight",
    )


def from_standard_starts(
    clamping: Clamping, torsion_ratio: float, lowest: bool = False
) -> Equilibrium:
    """The first or the lowest equilibrium that the compiled cascade finds, for a slack clamping."""
    from loopelastica.rod.kernels.multistart import run_starts

    record = new_record()
    outcome = run_starts(
        clamping.position.copy(), quaternion(clamping), torsion_ratio, clamping.free_spin,
        starts(torsion_ratio, clamping.free_spin), lowest, TOLERANCE, *record,
    )  # fmt: skip
    return from_record(clamping, torsion_ratio, outcome, record)


def quaternion(clamping: Clamping) -> Array:
    """End frame as a quaternion (w, x, y, z)."""
    from loopelastica.rod.kernels.rotations import quaternion_from_matrix

    q: Array = quaternion_from_matrix(clamping.rotation.copy())
    return q


def new_record() -> tuple[Array, Array, Array, Array]:
    """Room for what ``multistart`` writes: loads, node_s, node_pose, tail."""
    from loopelastica.rod.kernels.boundary_layers import SIZE
    from loopelastica.rod.kernels.multistart import NODES

    return np.zeros(6), np.empty(NODES), np.empty((NODES, 7)), np.zeros(SIZE)


def starts(torsion_ratio: float, free_spin: bool) -> Array:
    """Standard starts (n, 4): turns, sides of start and end, kick."""
    chosen = _FREE if free_spin else _SOFT if torsion_ratio < _SOFT_RATIO else _LOWEST
    return np.array(chosen, dtype=np.float64)


def from_record(
    clamping: Clamping,
    torsion_ratio: float,
    outcome: tuple[int, float, float, int],
    record: tuple[Array, Array, Array, Array],
) -> Equilibrium:
    """The equilibrium of an outcome (method, residual, energy, segments) and its record."""
    from loopelastica.rod.kernels.multistart import RELAXED_SHOT

    method, residual, energy, segments = outcome
    loads, node_s, node_pose, tail = record
    status = Status.CONVERGED if method else Status.STALLED
    known = (clamping, torsion_ratio, loads, energy, residual, status, METHODS[method])
    if not method:
        return Equilibrium(*known)
    if segments:
        return Equilibrium(*known, node_s[: segments + 1], node_pose[: segments + 1])
    # one shot from the start: the loads tell it all
    return Equilibrium(*known) if method == RELAXED_SHOT else Equilibrium(*known, tail=tail)
