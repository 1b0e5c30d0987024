"""Many clampings at once: plain arrays in and out, a failed row is a status.

Where any equilibrium will do, Newton's method from the nearest rods of the guess library
(``_library``) comes before the standard starts; otherwise the library is not loaded.
"""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from loopelastica._arrays import Array, Record
from loopelastica._checks import array, whole
from loopelastica.rod._arguments import check_flag, check_torsion_ratio
from loopelastica.rod._library import stored_rods
from loopelastica.rod._starts import (
    STRAIGHT,
    TOLERANCE,
    Deadline,
    check_tolerance,
    record_of,
    standard_starts,
    straight,
)
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.kernels.multistart import RETRIES, Problems, Search, new_rows, run_batch
from loopelastica.rod.kernels.records import Method, Status
from loopelastica.rod.solve import by_detour

_CHUNK = 256
# rods of the guess library tried for each row, and how near they must be: further ones lead
# nowhere more often than they spare the standard starts
_NEIGHBOURS, _NEAR = 6, 0.16
# Newton steps that a stored rod is given to come near: one that needs more seldom does
_HASTE = 2


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Batch(Record):
    """Solutions of n clampings; ``batch[i]`` is an :class:`Equilibrium`.

    Attributes
    ----------
    positions, rotations : (n, 3), (n, 3, 3) ndarray
        What was to be solved.
    torsion_ratio : (n,) ndarray
        K30 of each row.
    free_spin : bool
        Whether the ends may turn about their tangents.
    loads : (n, 6) ndarray
        F and M at s = 0 in the start frame; the last iterate's where a row failed.
    energy, residual : (n,) ndarray
        As for :class:`Equilibrium`; inf where a row failed. The residual is the error of what
        ``batch[i]`` gives back.
    status : (n,) ndarray
        `Status` of each row.
    method : (n,) ndarray
        `Method` of each row.
    by_loads : (n,) ndarray of bool
        Whether the loads alone determine the rod to the tolerance. A tense rod needs its nodes or
        boundary layers besides, which ``batch[i]`` has.
    records : dict
        The nodes or boundary layers of those rows.

    Examples
    --------
    >>> import numpy as np
    >>> import loopelastica as le
    >>> batch = le.solve_batch([[0, 0, 0.9], [0, 0, 0.8]], [np.eye(3), np.eye(3)])
    >>> len(batch), batch.loads.shape, [round(rod.energy, 3) for rod in batch]
    (2, (2, 6), [4.05, 8.323])
    """

    positions: Array
    rotations: Array
    torsion_ratio: Array
    free_spin: bool
    loads: Array
    energy: Array
    residual: Array
    status: NDArray[np.int64]
    method: NDArray[np.int64]
    records: dict[int, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """`solve_batch` fills it in place and makes it read-only then."""

    @property
    def converged(self) -> NDArray[np.bool_]:
        """(n,) which rows are solutions."""
        return np.asarray(self.status == Status.CONVERGED)

    @property
    def by_loads(self) -> NDArray[np.bool_]:
        """(n,) whether the loads alone determine the rod."""
        alone = self.converged.copy()
        alone[list(self.records)] = False
        return alone

    def __len__(self) -> int:
        return len(self.status)

    def __repr__(self) -> str:
        solved = int(self.converged.sum())
        return f"<Batch: {solved} of {len(self)} clampings solved>"

    @overload
    def __getitem__(self, i: int) -> Equilibrium: ...
    @overload
    def __getitem__(self, i: slice) -> list[Equilibrium]: ...
    def __getitem__(self, i: int | slice) -> Equilibrium | list[Equilibrium]:
        if isinstance(i, slice):
            return [self[k] for k in range(*i.indices(len(self)))]
        return _equilibrium(self, range(len(self))[i])

    def __iter__(self) -> Iterator[Equilibrium]:
        return (self[i] for i in range(len(self)))


def solve_batch(
    positions: ArrayLike,
    rotations: ArrayLike,
    torsion_ratio: ArrayLike = 1.0,
    free_spin: bool = False,
    lowest: bool = True,
    threads: int = 1,
    *,
    tolerance: float = TOLERANCE,
    time_limit_s: float | None = None,
) -> Batch:
    """Solve many clampings; one that fails is a row with a status.

    Where any equilibrium will do (``lowest=False``), the nearest rods of the guess library are
    tried first, which is several times faster. A row does not depend on the others, on how rows are
    cut into batches or on `threads`.

    Parameters
    ----------
    positions : (n, 3) array_like
        End positions in the start frames, in units of the length.
    rotations : (n, 3, 3) array_like
        End frames in the start frames, columns d1 d2 d3.
    torsion_ratio : float or (n,) array_like
        K30 = K3/K0, of all rows or of each. Each ratio has a guess library of its own, which takes
        a moment to build where ``lowest`` is False.
    free_spin : bool
        As for :class:`Clamping`.
    lowest : bool
        As for :func:`solve`.
    threads : int
        Threads to compute with; the compiled solver runs without the interpreter's lock.
    tolerance : float
        Largest residual of a solution.
    time_limit_s : float, optional
        Seconds after which no further rows are begun (in parts of some hundred); those that are
        left have the status ``OUT_OF_TIME``.

    Returns
    -------
    Batch
        Rows that failed have infinite energy and residual and the last iterate's loads.

    Raises
    ------
    ValueError
        If the shapes do not match or an argument is out of range.

    Examples
    --------
    >>> import numpy as np
    >>> batch = solve_batch([[0, 0, 0.9], [0, 0, 1.1]], [np.eye(3), np.eye(3)])
    >>> print(batch.converged, batch.status, round(batch[0].energy, 4))
    [ True False] [0 5] 4.0504
    """
    deadline, tolerance = Deadline(time_limit_s), check_tolerance(tolerance)
    batch = _unsolved(positions, rotations, torsion_ratio, check_flag("free_spin", free_spin))
    threads, lowest = whole(1)("threads", threads), check_flag("lowest", lowest)
    solvable = _solvable(batch)
    for i in np.flatnonzero(batch.status == Status.UNREACHABLE):
        _try_straight(int(i), batch)

    def solve_part(part: NDArray[np.intp]) -> None:
        if deadline.passed:
            batch.status[part] = Status.OUT_OF_TIME
            return
        _solve_rows(part, lowest, tolerance, deadline, batch)

    parts = _parts(solvable, batch.torsion_ratio)
    if threads == 1 or len(parts) < 3:
        for part in parts:
            solve_part(part)
    else:
        from concurrent.futures import ThreadPoolExecutor

        solve_part(parts[0])
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(solve_part, parts[1:]))
    Record.__post_init__(batch)
    return batch


def _equilibrium(batch: Batch, row: int) -> Equilibrium:
    if batch.status[row] == Status.BAD_INPUT:
        raise ValueError(f"row {row} is no clamping: its position or rotation is not valid")
    return Equilibrium(
        Clamping(batch.positions[row], batch.rotations[row], batch.free_spin),
        float(batch.torsion_ratio[row]),
        batch.loads[row],
        float(batch.energy[row]),
        float(batch.residual[row]),
        Status(batch.status[row]),
        Method(batch.method[row]),
        **batch.records.get(row, {}),
    )


def _parts(solvable: NDArray[np.bool_], torsion_ratio: Array) -> list[NDArray[np.intp]]:
    """Rows in parts of one torsion ratio each."""
    parts = []
    for ratio in np.unique(torsion_ratio):
        rows = np.flatnonzero(solvable & (torsion_ratio == ratio))
        # one row first: what is compiled or loaded late is so once
        cuts = [0, *range(1, len(rows), _CHUNK), len(rows)] if len(rows) else [0]
        parts += [rows[first:last] for first, last in itertools.pairwise(cuts)]
    return parts


def _unsolved(
    positions: ArrayLike, rotations: ArrayLike, torsion_ratio: ArrayLike, free_spin: bool
) -> Batch:
    """Rows that nothing has been tried on."""
    places = np.atleast_1d(array("positions", positions))
    frames = np.atleast_1d(array("rotations", rotations))
    n = len(places)
    if places.shape != (n, 3) or frames.shape != (n, 3, 3):
        raise ValueError(
            f"`positions` {places.shape} and `rotations` {frames.shape} must be (n, 3) and"
            " (n, 3, 3)"
        )
    ratios = array("torsion_ratio", torsion_ratio)
    if ratios.shape not in ((), (n,)):
        raise ValueError(f"`torsion_ratio` has shape {ratios.shape}; it must be a number or ({n},)")
    for ratio in np.unique(ratios):
        check_torsion_ratio(ratio)
    return Batch(
        places,
        frames,
        np.broadcast_to(ratios, (n,)),
        free_spin,
        np.zeros((n, 6)),
        np.full(n, np.inf),
        np.full(n, np.inf),
        np.full(n, int(Status.STALLED), dtype=np.int64),
        np.zeros(n, dtype=np.int64),
    )


def _solvable(batch: Batch) -> NDArray[np.bool_]:
    """Which rows can be solved; the others are marked in ``batch``."""
    positions, rotations = batch.positions, batch.rotations
    with np.errstate(all="ignore"):
        products = rotations.transpose(0, 2, 1) @ rotations
        # a comparison with NaN is false, so that NaN is caught as well
        proper = (np.abs(products - np.eye(3)) < 1e-4).all(axis=(1, 2))
        proper &= (np.cross(rotations[:, :, 0], rotations[:, :, 1]) * rotations[:, :, 2]).sum(1) > 0
        distance = np.linalg.norm(positions, axis=1)
        proper &= np.isfinite(positions).all(axis=1)
        slack = distance < 1.0 - STRAIGHT
    batch.status[~slack] = Status.UNREACHABLE
    batch.status[~proper] = Status.BAD_INPUT
    return np.asarray(proper & slack)


def _try_straight(i: int, batch: Batch) -> None:
    clamping = Clamping(batch.positions[i], batch.rotations[i], batch.free_spin)
    try:
        rod = straight(clamping, float(batch.torsion_ratio[i]))
    except ValueError:
        return
    if rod is not None:
        _put(batch, i, rod)


def _put(batch: Batch, i: int, rod: Equilibrium) -> None:
    """Write an equilibrium into row ``i``."""
    batch.loads[i], batch.energy[i], batch.residual[i] = rod.loads, rod.energy, rod.residual
    batch.status[i], batch.method[i] = rod.status, rod.method
    if rod.converged and rod.method != Method.STRAIGHT:
        batch.records[i] = {
            "node_s": rod.node_s,
            "node_pose": rod.node_pose,
            "layers": rod.layers,
        }


def _quaternions(rotations: Array) -> Array:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(rotations).as_quat(scalar_first=True))


def _solve_rows(
    rows: NDArray[np.intp], lowest: bool, tolerance: float, deadline: Deadline, batch: Batch
) -> None:
    """Solve the given rows, all of one torsion ratio; results into ``batch``."""
    positions, rotations = batch.positions[rows], batch.rotations[rows]
    torsion_ratio, free_spin, n = float(batch.torsion_ratio[rows[0]]), batch.free_spin, len(rows)
    guesses, known = np.zeros((n, 0, 6)), np.zeros(n, dtype=np.int64)
    if not lowest:
        stored = stored_rods(torsion_ratio, free_spin)
        guesses, known = stored.nearest(positions, rotations, _NEIGHBOURS, _NEAR)
    solutions = new_rows(n)
    starts = standard_starts(torsion_ratio, free_spin)
    run_batch(
        Problems(positions, _quaternions(rotations), torsion_ratio, free_spin, tolerance),
        Search(guesses, known, _HASTE, starts, RETRIES, lowest, True, False),
        solutions,
    )
    found = solutions.method != Method.NONE
    batch.loads[rows], batch.energy[rows] = solutions.loads, solutions.energy
    batch.residual[rows], batch.method[rows] = solutions.residual, solutions.method
    batch.status[rows] = np.where(found, Status.CONVERGED, Status.STALLED)
    for k in np.flatnonzero(found & np.logical_not(solutions.shot)):
        batch.records[int(rows[k])] = record_of(solutions, int(k))
    for k in np.flatnonzero(~found):
        _put(
            batch,
            int(rows[k]),
            by_detour(_equilibrium(batch, int(rows[k])), lowest, tolerance, deadline),
        )
