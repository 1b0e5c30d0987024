"""The package's own solver on the rods of the paper's studies, beside the printed method.

Each set of rods (a size l, a step δ and a spacing α) is solved once, whatever the printed method's
error or symmetry: `solve_batch` has neither. A rod counts as solved when its residual on the check
mesh is below 1e-9; the printed method's mark is 1e-5.
"""

import time
from collections.abc import Iterable
from typing import Any

from loopelastica._arrays import Array
from loopelastica.rod.batch import solve_batch
from loopelastica.rod.paper import grid_kernels as kernels

Row = dict[str, Any]

# rods solved between two moves of the bar
_PART = 50_000

COLUMNS = {
    "l": ("l", "g"),
    "delta": ("δ", "g"),
    "rods": ("of", ",d"),
    "tested": ("tested", ",d"),
    "success_percent": ("success at 1e-9 / %", ".4f"),
    "residual_max": ("residual, max", ".1e"),
    "time_ms": ("time per rod / ms", ".4f"),
    "threads": ("threads", "d"),
}


def _clampings(rods: Array) -> tuple[Array, Array]:
    """Positions (n, 3) and rotations (n, 3, 3) of the ends of rods (n, 5), K30 = 1."""
    from scipy.spatial.transform import Rotation

    ends = kernels.poses(rods, 1.0)
    rotations = Rotation.from_quat(ends[:, 3:], scalar_first=True).as_matrix()
    return ends[:, :3], rotations


def row(size: float, delta: float, rods: Array, tested: int, threads: int) -> Row:
    """Solve the first rods of a set.

    Parameters
    ----------
    size, delta : float
        l and δ of the set.
    rods : (n, 5) ndarray
        λ, t_P, a, s_ini/μ, L/μ.
    tested : int
        How many of them.
    threads : int

    Returns
    -------
    dict
        The line of the table.
    """
    positions, rotations = _clampings(rods[:tested])
    solve_batch(positions[:2], rotations[:2], lowest=False)  # compiled before the clock starts
    converged, residual, seconds = 0, 0.0, 0.0
    for part in _parts(tested):
        started = time.perf_counter()
        batch = solve_batch(positions[part], rotations[part], lowest=False, threads=threads)
        seconds += time.perf_counter() - started
        converged += int(batch.converged.sum())
        residual = max(residual, float(batch.residual[batch.converged].max(initial=0.0)))
    return {
        "l": size,
        "delta": delta,
        "rods": len(rods),
        "tested": tested,
        "success_percent": 100.0 * converged / tested,
        "residual_max": residual,
        "time_ms": 1e3 * seconds / tested,
        "threads": threads,
    }


def _parts(n: int) -> Iterable[slice]:
    return (slice(first, min(first + _PART, n)) for first in range(0, n, _PART))
