"""The solver under stress: poses of every kind, and what became of them.

Each case is a way to draw clampings. All are solved as one batch (mean time), some one by one
(median and 99th percentile), and some results are judged by another integrator (``judge``). A case
whose poses no rod fits counts as solved where they are refused for the right reason.
"""

import json
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica._files import write_csv, write_json, write_text
from loopelastica.rod.batch import Batch, solve_batch
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.kernels.records import Status
from loopelastica.rod.solve import solve
from loopelastica.studies.bench.cases import Case, all_cases
from loopelastica.studies.bench.judge import independent
from loopelastica.studies.bench.markdown import markdown_table
from loopelastica.studies.figures import new_figure, save_figure

__all__ = ["run"]

Row = dict[str, Any]

_SEED = 2026
# poses solved one by one for the spread of times, and judged independently: default and full
_TIMED, _CHECKED = (40, 300), (3, 12)
# the default sample is the full one over this, and no less than that
_SHARE, _LEAST = 50, 12


def _size(case: Case, full: bool) -> int:
    """How many poses to draw."""
    return case.full if full else max(_LEAST, case.full // _SHARE)


def _measure(case: Case, full: bool, seed: int) -> tuple[Row, list[Row], list[list[float]]]:
    """The row of one case, the clampings that failed, and (√F, residual, ms) of those timed."""
    # the same poses in whatever order cases run
    rng = np.random.default_rng([seed, *case.name.encode(), int(1000 * case.torsion_ratio)])
    positions, rotations = case.draw(rng, _size(case, full))

    def batch_of(rows: slice) -> Batch:
        return solve_batch(positions[rows], rotations[rows], case.torsion_ratio, lowest=case.lowest)

    batch_of(slice(0, 2))  # compiled, and its guess library loaded, before the clock starts
    started = time.perf_counter()
    batch = batch_of(slice(None))
    mean = 1e3 * (time.perf_counter() - started) / len(batch)
    timed = np.empty(min(_TIMED[full], len(batch)))
    for i in range(len(timed)):
        started = time.perf_counter()
        batch_of(slice(i, i + 1))
        timed[i] = 1e3 * (time.perf_counter() - started)
    right = batch.status == case.expected
    right &= (batch.residual < 1e-9) == (case.expected == Status.CONVERGED)
    rods = [
        solve(Clamping(positions[i], rotations[i]), case.torsion_ratio, case.lowest)
        for i in np.flatnonzero(right & batch.converged)[: _CHECKED[full]]
    ]
    checks = np.array([independent(rod) for rod in rods if rod.converged]).reshape(-1, 2)
    root = np.sqrt(np.linalg.norm(batch.loads[:, :3], axis=1))
    failures = [
        {
            "case": case.name, "torsion_ratio": case.torsion_ratio, "lowest": case.lowest,
            "status": int(batch.status[i]), "position": _numbers(positions[i]),
            "rotation": _numbers(rotations[i]),
        }
        for i in np.flatnonzero(~right)
    ]  # fmt: skip
    points = [
        [float(root[i]), float(batch.residual[i]), float(timed[i])]
        for i in range(len(timed))
        if batch.converged[i]
    ]
    return _row(case, batch, right, mean, timed, checks, root), failures, points


def _numbers(values: Array) -> Any:
    """Nested lists with None where a value is not finite, which JSON cannot hold."""
    numbers = values.astype(object)
    numbers[~np.isfinite(values)] = None
    return numbers.tolist()


def _row(
    case: Case, batch: Batch, right: NDArray[np.bool_], mean: float, timed: Array, checks: Array,
    root: Array,
) -> Row:  # fmt: skip
    residual = batch.residual[batch.converged]
    wrong = [Status(code).name.lower() for code in batch.status[~right]]

    def largest(values: Array) -> float | None:
        return float(values.max()) if len(values) else None

    return {
        "case": case.name,
        "torsion_ratio": case.torsion_ratio,
        "expected": case.expected.name.lower(),
        "sample": len(batch),
        "right": int(right.sum()),
        "others": ", ".join(f"{wrong.count(name)} {name}" for name in sorted(set(wrong))),
        "residual_median": float(np.median(residual)) if len(residual) else None,
        "residual_max": largest(residual),
        "root_force_max": largest(root[batch.converged]),
        "time_mean_ms": round(mean, 5),
        "time_median_ms": round(float(np.median(timed)), 5),
        "time_p99_ms": round(float(np.quantile(timed, 0.99)), 5),
        "checked": len(checks),
        "check_max": largest(checks[:, 0]),
        "energy_error_max": largest(checks[:, 1]),
    }


_COLUMNS = {
    "case": ("case", ""),
    "torsion_ratio": ("K30", "g"),
    "sample": ("sample", ",d"),
    "right": ("right", ",d"),
    "others": ("others", ""),
    "residual_median": ("residual, median", ".1e"),
    "residual_max": ("max", ".1e"),
    "root_force_max": ("√F, max", ".3g"),
    "time_mean_ms": ("ms, mean", ".3f"),
    "time_median_ms": ("ms singly, median", ".3f"),
    "time_p99_ms": ("p99", ".3f"),
    "checked": ("checked", "d"),
    "check_max": ("independent, max", ".1e"),
    "energy_error_max": ("energy, max", ".1e"),
}


def _draw(points: Array, path: Path) -> None:
    figure = new_figure(9.0, 3.8)
    labels = ("residual", "run time, one pose / ms")
    for axis, column, label in zip(figure.subplots(1, 2), (1, 2), labels, strict=True):
        # a logarithm needs a floor: rods without force, residuals of exactly 0
        x, y = np.maximum(points[:, 0], 0.1), np.maximum(points[:, column], 1e-17)
        axis.loglog(x, y, ".", ms=2, alpha=0.5, color="#1b6ca8", rasterized=True)
        axis.set_xlabel("stiffness √(F L²/K0)")
        axis.set_ylabel(label)
    save_figure(figure, path)


def run(out: Path, full: bool = False, seed: int = _SEED, progress: bool = True) -> list[Row]:
    """Solve the extreme cases and write what came of them.

    Parameters
    ----------
    out : Path
        Folder for ``stability.csv``, ``stability.md``, ``stability.png`` and ``failures.json``, the
        clampings that were not solved. A run into the same folder continues an earlier one.
    full : bool
        Samples of up to 20,000 poses, some minutes; otherwise a fiftieth of them.
    seed : int
        Of the random poses.
    progress : bool
        Show a bar on standard error.

    Returns
    -------
    list of dict
        The lines of ``stability.csv``.
    """
    from loopelastica._progress import progress_bar

    out = Path(out)
    rows: list[Row] = []
    failures: list[Row] = []
    points: list[list[float]] = []
    bar = progress_bar(all_cases(), shown=progress, unit="case")
    for number, case in enumerate(bar):
        bar.set_description(f"{case.name}, K30 = {case.torsion_ratio:g}")
        label = [case.name, case.torsion_ratio, case.lowest, _size(case, full), full, seed]
        path = out / "partial" / f"stability-{number}.json"
        try:
            kept = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            kept = None
        if not isinstance(kept, dict) or kept.get("label") != label:
            kept = {"label": label, "result": _measure(case, full, seed)}
            write_json(path, kept)
        row, failed, timed = kept["result"]
        rows.append(row)
        failures += failed
        points += timed
    write_csv(out / "stability.csv", rows)
    head = "# Poses of every kind\n\nResiduals and times of one core; see `stability.csv`.\n\n"
    write_text(out / "stability.md", head + markdown_table(rows, _COLUMNS) + "\n")
    write_json(out / "failures.json", failures)
    _draw(np.array(points).reshape(-1, 3), out / "stability.png")
    return rows
