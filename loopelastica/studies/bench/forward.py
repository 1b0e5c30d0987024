"""From loads to the end of the rod: error against run time of each way to get there.

All ways take the same rods, each evaluated by one after the other. The closed form starts from
physical parameters, the integrators from loads, both rounded to double; times are those of one
call from Python, conversions left out. The error is the largest component of position (L) and
quaternion off the reference of fifty digits.
"""

import dataclasses
import time
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.parameters import PhysicalParameters
from loopelastica.studies.bench import peers, reference
from loopelastica.studies.bench.poses import random_loads

Row = dict[str, Any]
# what is timed, and the pose (7,) in what it returns
Way = tuple[Callable[[], Any], Callable[[Any], Array]]

_STEPS = (4, 6, 8, 12, 16, 24, 32, 48, 96)
_TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13)
# calls between two looks at the clock: of compiled ways, and of SciPy's
_REPEATS, _SLOW_REPEATS = 40, 1
# digits of a second reference that judges the first one
_MORE_DIGITS = 60


def _closed_form(loads: Array) -> Way:
    from scipy.spatial.transform import Rotation

    from loopelastica.rod.kernels.finite_rod import rod_along

    p = PhysicalParameters.from_loads(loads)
    if p is None:
        raise ValueError("`loads` have no force; the closed form needs one")
    call = partial(rod_along, *dataclasses.astuple(p), 1.0, np.ones(1))
    return call, lambda end: np.append(
        end[0][0], Rotation.from_matrix(end[1][0]).as_quat(scalar_first=True)
    )


def _integrator(loads: Array, steps: int) -> Way:
    from loopelastica.rod.kernels import shooting as kernel

    y, z = np.empty(kernel.WITH_JACOBIAN), np.empty(kernel.WITH_JACOBIAN)
    k = np.empty(12 * kernel.WITH_JACOBIAN)
    call = partial(kernel.shoot, loads, 1.0, steps, kernel.POSE, y, k, z)
    return call, lambda _: y[:7].copy()


def _bulirsch_stoer(loads: Array, rtol: float) -> Way:
    from loopelastica.rod.paper.bulirsch_stoer import end_pose

    y = np.empty(7)
    return partial(end_pose, loads, 1.0, rtol, y), lambda _: y.copy()


def _dop853(loads: Array, rtol: float) -> Way:
    return partial(peers.end_by_dop853, loads, rtol), lambda pose: np.asarray(pose)


def _ways(loads: Array) -> Iterable[tuple[str, str, int, Way]]:
    """Method, setting, repeats between two looks at the clock, and the way itself."""
    yield "closed form q1", "", _REPEATS, _closed_form(loads)
    for steps in _STEPS:
        yield "own integrator", f"{steps} steps", _REPEATS, _integrator(loads, steps)
    for rtol in _TOLERANCES:
        yield "Bulirsch–Stoer", f"rtol {rtol:.0e}", _REPEATS, _bulirsch_stoer(loads, rtol)
    for rtol in _TOLERANCES:
        yield "SciPy DOP853", f"rtol {rtol:.0e}", _SLOW_REPEATS, _dop853(loads, rtol)


def measure(sample: int, rng: np.random.Generator, tick: Callable[[], object]) -> list[Row]:
    """Measure all ways on the same load-drawn rods.

    Parameters
    ----------
    sample : int
        How many rods.
    rng : numpy.random.Generator
    tick : callable
        Called after each rod.

    Returns
    -------
    list of dict
        A row per way and setting; the first one is the reference itself against one of ten digits
        more.
    """
    rods = random_loads(rng, sample)
    measured: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for loads in rods:
        exact = reference.end_pose(loads)
        for method, setting, repeats, (call, pose) in _ways(loads):
            # once for the compiler and for the answer
            error = reference.difference(pose(call()), exact)
            started = time.thread_time()
            for _ in range(repeats):
                call()
            each = (time.thread_time() - started) / repeats
            measured.setdefault((method, setting), []).append((1e6 * each, error))
        tick()
    again = reference.end_pose(rods[0], _MORE_DIGITS)
    doubt = max(abs(float(a - b)) for a, b in zip(reference.end_pose(rods[0]), again, strict=True))
    rows = [_row("reference", f"{reference.DIGITS} digits", 1, None, np.array([doubt]))]
    for (method, setting), values in measured.items():
        times, errors = np.array(values).T
        rows.append(_row(method, setting, sample, float(np.median(times)), errors))
    return rows


def _row(method: str, setting: str, sample: int, time_us: float | None, errors: Array) -> Row:
    return {
        "method": method,
        "setting": setting,
        "sample": sample,
        "time_median_us": None if time_us is None else round(time_us, 3),
        "error_median": float(np.median(errors)),
        "error_max": float(errors.max()),
    }


COLUMNS = {
    "method": ("method", ""),
    "setting": ("setting", ""),
    "sample": ("sample", "d"),
    "time_median_us": ("µs, median", ".2f"),
    "error_median": ("error, median", ".1e"),
    "error_max": ("max", ".1e"),
}
