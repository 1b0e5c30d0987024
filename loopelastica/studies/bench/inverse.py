"""From a clamping to a rod: success, run time and error of ours, the paper's and SciPy's ways.

All methods take the same targets, each target by one after the other, so that whatever slows the
machine slows all alike. An answer is judged by `judge.misfits`, SciPy's integrator on frames as
matrices, from the loads and, where a method has them, nodes that it gives: the sum of what is
missing at the start, from node to node and at the end. That is what the answer is off as a rod
between the two clamps, for one that holds nodes as for one that is loads alone.
"""

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.batch import Batch, solve_batch
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.paper import ERRORS, PaperSolver
from loopelastica.rod.solve import solve
from loopelastica.studies.bench import peers
from loopelastica.studies.bench.judge import misfits
from loopelastica.studies.bench.poses import Draw, Poses, at_shell, load_drawn

Row = dict[str, Any]

SUCCESS = (1e-5, 1e-9)
OURS, PEER = "ours, batch", "solve_bvp, tol 1e-06"
LARGE = "ours, batch, large sample"

_NEAR = 0.95
_TOLERANCES = (1e-3, 1e-6, 1e-11)
_GUESSES = 20
# rows of a batch that is timed: the targets are repeated until there are as many
_BATCH_ROWS, _ROUNDS = 240, 4


def _load_drawn_near(rng: np.random.Generator, n: int) -> Poses:
    positions, rotations = load_drawn(rng, 2 * n + 20)
    near = np.flatnonzero(np.linalg.norm(positions, axis=1) < _NEAR)[:n]
    return positions[near], rotations[near]


SETS: dict[str, Draw] = {
    "load-drawn": _load_drawn_near,
    "pose-drawn, |η| < 0.95": at_shell(0.0, _NEAR),
    "stiff, 0.95 < |η| < 0.9999": at_shell(_NEAR, 0.9999),
}


def _converged(rod: Equilibrium) -> Equilibrium | None:
    return rod if rod.converged else None


def _first(clamping: Clamping) -> Equilibrium | None:
    return _converged(solve(clamping, lowest=False))


def _lowest(clamping: Clamping) -> Equilibrium | None:
    return _converged(solve(clamping))


def _at_tolerance(clamping: Clamping, tolerance: float) -> Equilibrium | None:
    return _converged(solve(clamping, lowest=False, tolerance=tolerance))


def _printed(clamping: Clamping, solver: PaperSolver) -> Equilibrium | None:
    found = solver.solve(clamping)
    return peers.from_loads(clamping, found.loads) if found.converged else None


def _methods(rng: np.random.Generator) -> dict[str, peers.Method]:
    guesses = peers.random_guesses(rng, _GUESSES - 1)
    none = guesses[:0]
    methods: dict[str, peers.Method] = {
        "ours, solve, first": _first,
        "ours, solve, lowest": _lowest,
    }
    for tolerance in _TOLERANCES:
        methods[f"ours, first, tolerance {tolerance:.0e}"] = partial(
            _at_tolerance, tolerance=tolerance
        )
    for error, name in zip(ERRORS, ("ε1", "ε2", "ε3"), strict=True):
        methods[f"paper, {name}"] = partial(_printed, solver=PaperSolver(2.0, 0.5, error))
    for tolerance in (1e-3, 1e-6, 1e-9):
        name = f"solve_bvp, tol {tolerance:.0e}"
        methods[name] = peers.by_collocation(none, tolerance)
    methods[f"solve_bvp, {_GUESSES} guesses"] = peers.by_collocation(guesses)
    methods["least_squares"] = peers.by_shooting(none)
    methods[f"least_squares, {_GUESSES} guesses"] = peers.by_shooting(guesses)
    return methods


def error_of(rod: Equilibrium | None) -> float:
    """What an answer is off; inf for none."""
    if rod is None or not np.isfinite(rod.loads).all():
        return np.inf
    # a wrong answer may be far out of what can be integrated
    with np.errstate(all="ignore"):
        total = float(misfits(rod)[0].sum())
    return total if np.isfinite(total) else np.inf


def _batch_error(clamping: Clamping, batch: Batch, i: int, rod: Equilibrium | None) -> float:
    """That of the same rod with its nodes, which a batch leaves out, else that of the loads."""
    if not batch.converged[i]:
        return np.inf
    if rod is not None and np.allclose(rod.loads, batch.loads[i], rtol=1e-7, atol=1e-7):
        return error_of(rod)
    return error_of(peers.from_loads(clamping, batch.loads[i]))


class _Record:
    """Times (s), errors and claims of one method, target by target."""

    def __init__(self) -> None:
        self.times: list[float] = []
        self.errors: list[float] = []
        self.claimed = 0

    def row(self, targets: str, method: str) -> Row:
        errors = np.array(self.errors)
        reached = errors[np.isfinite(errors)]
        times = 1e3 * np.array(self.times)
        # a batch has one time, its mean
        single = len(times) == len(errors)

        def quantile(q: float) -> float | None:
            return float(np.quantile(reached, q)) if len(reached) else None

        return {
            "targets": targets,
            "method": method,
            "sample": len(errors),
            "claimed_percent": round(100.0 * self.claimed / len(errors), 3),
            "success_1e-5_percent": round(100.0 * float((errors < SUCCESS[0]).mean()), 3),
            "success_1e-9_percent": round(100.0 * float((errors < SUCCESS[1]).mean()), 3),
            "time_median_ms": round(float(np.median(times)), 5) if single else None,
            "time_mean_ms": round(float(times.mean()), 5),
            "time_p99_ms": round(float(np.quantile(times, 0.99)), 5) if single else None,
            "ratio": None,
            "error_median": quantile(0.5),
            "error_p90": quantile(0.9),
            "error_max": quantile(1.0),
        }


def _timed(call: Callable[[], Any]) -> tuple[Any, float]:
    # not the process's: BLAS has helpers that spin for some time after a peer's call
    started = time.thread_time()
    result = call()
    return result, time.thread_time() - started


def measure(
    targets: str, sample: int, large: int, rng: np.random.Generator, tick: Callable[[], object]
) -> list[Row]:
    """Measure all methods on the same targets, and our batch on a large sample.

    Parameters
    ----------
    targets : str
        Name of one of `SETS`.
    sample : int
        Targets that all methods take.
    large : int
        Targets of our batch alone; a tenth of them for the lowest. They are judged by our own
        residual, which is that of a mesh the solver did not use.
    rng : numpy.random.Generator
    tick : callable
        Called after each target.

    Returns
    -------
    list of dict
        A row per method, our batch first.
    """
    positions, rotations = SETS[targets](rng, max(sample, large))
    clampings = [Clamping(p, r) for p, r in zip(positions[:sample], rotations, strict=False)]
    methods = _methods(rng)
    tiled = np.resize(np.arange(sample), max(_BATCH_ROWS, sample))
    batches = {
        OURS: partial(solve_batch, positions[tiled], rotations[tiled], lowest=False),
        "ours, batch, lowest": partial(
            solve_batch, positions[tiled], rotations[tiled], lowest=True
        ),
    }
    # compiled, and the grid built and the guess library loaded, before the clock starts
    for method in methods.values():
        method(clampings[0])
    for call in batches.values():
        call()
    records = {name: _Record() for name in (*batches, *methods)}
    seconds: dict[str, list[float]] = {name: [] for name in batches}
    outcomes: dict[str, Batch] = {}
    due = {round(k * sample / _ROUNDS) for k in range(_ROUNDS)}
    rods: dict[str, list[Equilibrium | None]] = {name: [] for name in methods}
    for i, clamping in enumerate(clampings):
        if i in due:
            for name, call in batches.items():
                outcomes[name], took = _timed(call)
                seconds[name].append(took)
        for name, method in methods.items():
            rod, took = _timed(partial(method, clamping))
            records[name].times.append(took)
            records[name].errors.append(error_of(rod))
            records[name].claimed += rod is not None
            rods[name].append(rod)
        tick()
    for name, twin in zip(batches, ("ours, solve, first", "ours, solve, lowest"), strict=True):
        record, batch = records[name], outcomes[name]
        record.times = [float(np.mean(seconds[name])) / len(tiled)]
        record.claimed = int(batch.converged[:sample].sum())
        record.errors = [_batch_error(c, batch, i, rods[twin][i]) for i, c in enumerate(clampings)]
    rows = [record.row(targets, name) for name, record in records.items()]
    ours = rows[0]["time_mean_ms"]
    for row in rows:
        # the peer's median: its failures would only make it look worse
        typical = row["time_median_ms"] or row["time_mean_ms"]
        row["ratio"] = round(typical / ours, 3)
    return [*rows, *_large(targets, positions, rotations)]


def _large(targets: str, positions: Array, rotations: Array) -> list[Row]:
    rows = []
    for name, lowest, share in ((LARGE, False, 1), ("ours, batch, lowest, large sample", True, 10)):
        part = slice(None, -(-len(positions) // share))
        batch, took = _timed(partial(solve_batch, positions[part], rotations[part], lowest=lowest))
        record = _Record()
        record.times = [took / len(batch)]
        record.errors = batch.residual.tolist()
        record.claimed = int(batch.converged.sum())
        rows.append(record.row(targets, name))
    return rows


COLUMNS = {
    "method": ("method", ""),
    "sample": ("sample", ",d"),
    "claimed_percent": ("claimed / %", ".1f"),
    "success_1e-5_percent": ("at 1e-5 / %", ".1f"),
    "success_1e-9_percent": ("at 1e-9 / %", ".1f"),
    "time_median_ms": ("ms, median", ".3g"),
    "time_mean_ms": ("mean", ".3g"),
    "time_p99_ms": ("p99", ".3g"),
    "ratio": ("× ours", ".3g"),
    "error_median": ("error, median", ".1e"),
    "error_p90": ("90 %", ".1e"),
    "error_max": ("max", ".1e"),
}
