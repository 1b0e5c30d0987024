"""Many clampings at once: plain arrays in and out, a failed row is a status.

Where any equilibrium will do, Newton's method from the nearest rods of the guess library
(``_library``) comes before the standard starts; a single pose does not load it.
"""

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from loopelastica._arrays import Array
from loopelastica.rod._starts import STRAIGHT, TOLERANCE, check_torsion_ratio, starts, straight
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibrium import METHODS, Equilibrium, Status
from loopelastica.rod.solve import by_detour

_CHUNK = 256
# stored rods tried for each row of a batch, and how near they must be: further ones lead nowhere
# more often than they spare the cascade
_NEIGHBOURS, _NEAR = 6, 0.24


@dataclass(frozen=True, slots=True, eq=False)
class Batch:
    """Solutions of n clampings: ``loads`` (n, 6), ``energy``, ``residual``, ``status`` (n,)."""

    loads: Array
    energy: Array
    residual: Array
    status: NDArray[np.int64]

    @classmethod
    def unsolved(cls, n: int) -> "Batch":
        """Rows that nothing has been tried on."""
        return cls(
            np.zeros((n, 6)),
            np.full(n, np.inf),
            np.full(n, np.inf),
            np.full(n, int(Status.STALLED), dtype=np.int64),
        )

    @property
    def converged(self) -> NDArray[np.bool_]:
        """(n,) which rows are solutions."""
        return np.asarray(self.status == Status.CONVERGED)

    def __len__(self) -> int:
        return len(self.status)

    def _arrays(self) -> tuple[Array, Array, Array, NDArray[np.int64]]:
        return self.loads, self.energy, self.residual, self.status


def solve_batch(
    positions: ArrayLike,
    rotations: ArrayLike,
    torsion_ratio: float = 1.0,
    free_spin: bool = False,
    lowest: bool = False,
    threads: int = 1,
) -> Batch:
    """Solve many clampings; one that fails is a row with a status.

    Where any equilibrium will do, the nearest stored rods are tried before the cascade. A row does
    not depend on the others, on how rows are cut into batches or on `threads`.

    Parameters
    ----------
    positions : (n, 3) array_like
        End positions in the start frames, in units of the length.
    rotations : (n, 3, 3) array_like
        End frames in the start frames, columns d1 d2 d3.
    torsion_ratio, free_spin, lowest
        As for :func:`solve` and :class:`Clamping`; here the first solution is the default.
    threads : int
        Threads to compute with; the compiled solver runs without the interpreter's lock.

    Returns
    -------
    Batch
        ``loads`` (n, 6), ``energy`` (n,), ``residual`` (n,), ``converged`` (n,), ``status`` (n,).
        Rows that failed have infinite energy and residual and the last iterate's loads.

    Raises
    ------
    ValueError
        If the shapes do not match or `torsion_ratio` is not positive.

    Examples
    --------
    >>> import numpy as np
    >>> batch = solve_batch([[0, 0, 0.9], [0, 0, 1.1]], [np.eye(3), np.eye(3)])
    >>> print(batch.converged, batch.status)
    [ True False] [0 5]
    """
    torsion_ratio = check_torsion_ratio(torsion_ratio)
    positions = np.ascontiguousarray(positions, dtype=np.float64)
    rotations = np.ascontiguousarray(rotations, dtype=np.float64)
    n = len(positions)
    if positions.shape != (n, 3) or rotations.shape != (n, 3, 3):
        raise ValueError(
            f"`positions` {positions.shape} and `rotations` {rotations.shape} must be (n, 3) and"
            " (n, 3, 3)"
        )
    batch = Batch.unsolved(n)
    rows = np.flatnonzero(_solvable(positions, rotations, batch))
    for i in np.flatnonzero(batch.status == Status.UNREACHABLE):
        _try_straight(int(i), positions, rotations, torsion_ratio, free_spin, batch)

    def solve_part(part: NDArray[np.intp]) -> None:
        _solve_rows(part, positions, rotations, torsion_ratio, free_spin, lowest, batch)

    # one row first: what is compiled or loaded late is so once
    cuts = [0, *range(1, len(rows), _CHUNK), len(rows)] if len(rows) else [0]
    parts = [rows[first:last] for first, last in itertools.pairwise(cuts)]
    if threads == 1 or len(parts) < 3:
        for part in parts:
            solve_part(part)
    else:
        from concurrent.futures import ThreadPoolExecutor

        solve_part(parts[0])
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(solve_part, parts[1:]))
    for array in batch._arrays():
        array.setflags(write=False)
    return batch


def _solvable(positions: Array, rotations: Array, batch: Batch) -> NDArray[np.bool_]:
    """Which rows can be solved; the others are marked in ``batch``."""
    with np.errstate(invalid="ignore", over="ignore"):
        products = rotations.transpose(0, 2, 1) @ rotations
        # a comparison with NaN is false, so that NaN is caught as well
        proper = (np.abs(products - np.eye(3)) < 1e-4).all(axis=(1, 2))
        proper &= (np.cross(rotations[:, :, 0], rotations[:, :, 1]) * rotations[:, :, 2]).sum(1) > 0
        distance = np.linalg.norm(positions, axis=1)
        proper &= np.isfinite(distance)
        slack = distance < 1.0 - STRAIGHT
    batch.status[~slack] = Status.UNREACHABLE
    batch.status[~proper] = Status.BAD_INPUT
    return np.asarray(proper & slack)


def _try_straight(
    i: int, positions: Array, rotations: Array, torsion_ratio: float, free_spin: bool, batch: Batch
) -> None:
    try:
        rod = straight(Clamping(positions[i], rotations[i], free_spin), torsion_ratio)
    except ValueError:
        return
    if rod is not None:
        batch.loads[i], batch.energy[i] = rod.loads, rod.energy
        batch.residual[i], batch.status[i] = rod.residual, rod.status


def _quaternions(rotations: Array) -> Array:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(rotations).as_quat(scalar_first=True))


def _solve_rows(
    rows: NDArray[np.intp], positions: Array, rotations: Array, torsion_ratio: float,
    free_spin: bool, lowest: bool, batch: Batch,
) -> None:  # fmt: skip
    """Solve the given rows; results into ``batch``."""
    from loopelastica.rod.kernels.multistart import run_batch

    n = len(rows)
    guesses, known = np.zeros((n, 0, 6)), np.zeros(n, dtype=np.int64)
    if not lowest:
        from loopelastica.rod._library import stored_rods

        stored = stored_rods(torsion_ratio, free_spin)
        guesses, known = stored.nearest(positions[rows], rotations[rows], _NEIGHBOURS, _NEAR)
    loads, energy, residual = np.zeros((n, 6)), np.full(n, np.inf), np.full(n, np.inf)
    method = np.zeros(n, dtype=np.int64)
    run_batch(
        positions[rows], _quaternions(rotations[rows]), torsion_ratio, free_spin, guesses, known,
        starts(torsion_ratio, free_spin), lowest, TOLERANCE, loads, energy, residual, method,
    )  # fmt: skip
    for i in np.flatnonzero(method == 0):
        clamping = Clamping(positions[rows[i]], rotations[rows[i]], free_spin)
        failed = Equilibrium(
            clamping, torsion_ratio, loads[i], np.inf, np.inf, Status.STALLED, METHODS[0]
        )
        rod = by_detour(failed, lowest)
        loads[i], energy[i], residual[i] = rod.loads, rod.energy, rod.residual
        method[i] = METHODS.index(rod.method)
    batch.loads[rows], batch.energy[rows], batch.residual[rows] = loads, energy, residual
    batch.status[rows] = np.where(method > 0, Status.CONVERGED, Status.STALLED)
