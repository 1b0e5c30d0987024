"""From a clamping to an equilibrium: a cascade of starts, each judged independently.

Starts are structured (``multistart``): an axis of tension with a whole number of turns, each end
tail on one side or the other. They go through closed-form tails, multiple shooting and the discrete
rod. The lowest of their results was the lowest of all known ones wherever this was compared with
random starts; it is not proven to be. For many poses of which any equilibrium will do, Newton's
method from the nearest stored rods (``_library``) comes first; a single pose does not load them.
"""

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

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
_STRAIGHT = 1e-9
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
    if distance < 1.0 - _STRAIGHT:
        return None
    if distance > 1.0 + _STRAIGHT:
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


def solve(clamping: Clamping, torsion_ratio: float = 1.0, lowest: bool = True) -> Equilibrium:
    """Find an equilibrium of an ideal rod with both ends clamped.

    Parameters
    ----------
    clamping : Clamping
        The end's pose in the start frame, lengths in units of the rod's.
    torsion_ratio : float
        K30 = K3/K0 (eq. 5 of doi:10.1016/j.jcp.2018.07.021).
    lowest : bool
        Return the equilibrium of least energy that the standard starts lead to (not proven to be
        the lowest of all); otherwise the first one found.

    Returns
    -------
    Equilibrium
        Its ``converged`` says whether it is a solution: a numerical failure is a status, not an
        exception.

    Raises
    ------
    ValueError
        If no rod can fit (`clamping` out of reach) or `torsion_ratio` is not positive.

    Examples
    --------
    >>> q = Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
    >>> rod = solve(q)
    >>> print(rod.converged, round(rod.energy, 6), rod.residual < 1e-9)
    True 7.057888 True
    """
    torsion_ratio = check_torsion_ratio(torsion_ratio)
    stretched = straight(clamping, torsion_ratio)
    if stretched is not None:
        return stretched
    rod = from_standard_starts(clamping, torsion_ratio, lowest)
    return rod if rod.converged else _by_detour(rod, lowest)


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


def _by_detour(rod: Equilibrium, lowest: bool) -> Equilibrium:
    """By continuation from clampings nearby, where no start arrives; else ``rod`` as it is.

    About one in 200 of those poses needs it whose tangents are both within 1e-6 of the line of a
    nearly straight chord, where solutions are a circle in all but name.
    """
    from loopelastica.rod.continuation import detours

    found = []
    for end in detours(rod.clamping, rod.torsion_ratio):
        found.append(end)
        if not lowest:
            break
    return min(found, key=lambda end: end.energy, default=rod)


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
        slack = distance < 1.0 - _STRAIGHT
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
        rod = _by_detour(failed, lowest)
        loads[i], energy[i], residual[i] = rod.loads, rod.energy, rod.residual
        method[i] = METHODS.index(rod.method)
    batch.loads[rows], batch.energy[rows], batch.residual[rows] = loads, energy, residual
    batch.status[rows] = np.where(method > 0, Status.CONVERGED, Status.STALLED)
