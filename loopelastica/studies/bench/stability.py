"""The solver under stress: poses of every kind, and what became of them.

Each case is a way to draw clampings. All are solved as one batch (mean time), some one by one
(median and 99th percentile), and some results are judged by an evaluation that shares nothing with
the solver: SciPy's integrator on frames as matrices, between nodes that follow the rod's own rate
of turning. Where the rod is two tails with a straight middle, the moment is taken from the
curvature of the tail itself, not from M0 + F × r, whose rounding grows with F. A case whose poses
no rod fits counts as solved where they are refused for the right reason.
"""

import io
import json
import math
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from loopelastica._arrays import Array
from loopelastica.rod.batch import Batch, solve_batch
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.kernels.records import Status
from loopelastica.rod.solve import solve
from loopelastica.studies.bench import _poses as poses
from loopelastica.studies.bench._poses import Case
from loopelastica.studies.bench._report import markdown_table, write_bytes, write_csv, write_text

__all__ = ["independent", "run"]

Row = dict[str, Any]

_SEED = 2026
# poses solved one by one for the spread of times, and judged independently: default and full
_TIMED, _CHECKED = (40, 300), (3, 12)
# the default sample is the full one over this, and no less than that
_SHARE, _LEAST = 50, 12
# decay lengths after which a tail is straight to rounding
_LAYER = 32.0
# radians that the rod turns between two nodes of the check, and the most intervals
_TURN, _INTERVALS = 0.75, 4000
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(8)


def _layers(rod: Equilibrium) -> tuple[Array, float]:
    """Nodes of the check, and the length of each tail's layer; 0 where the rod is no two tails."""
    force = float(np.linalg.norm(rod.loads[:3]))
    decay = math.sqrt(max(force - 0.25 * rod.loads[5] ** 2, 0.0))
    twist = abs(rod.loads[5]) / rod.torsion_ratio
    if len(rod.layers) and decay > 2.0 * _LAYER:
        layer = _LAYER / decay
        n = min(int(layer * (2.0 * math.sqrt(force) + twist) / _TURN) + 8, _INTERVALS)
        near = np.linspace(0.0, layer, n + 1)
        return np.concatenate([near, 1.0 - near[::-1]]), layer
    hamiltonian = float(rod.loads[3:] @ rod.loads[3:]) + 2.0 * abs(rod.loads[2])
    rate = max(math.sqrt(max(hamiltonian, 2.0 * force)), twist, 1.0)
    return np.linspace(0.0, 1.0, min(int(rate / _TURN) + 16, _INTERVALS) + 1), 0.0


def _march(
    frames: Array, moment: Array, h: Array, force: Array, torsion_ratio: float
) -> tuple[Array, Array]:
    """Displacements over h and frames at the ends of all intervals at once, by SciPy."""
    from scipy.integrate import solve_ivp

    n, step = len(h), h[:, None]

    def slope(_: float, y: Array) -> Array:
        state = y.reshape(n, 12)
        frame = state[:, 3:].reshape(n, 3, 3)
        t = frame[:, :, 2]
        m = moment + np.cross(force, step * state[:, :3])
        omega = step * (m + (1.0 / torsion_ratio - 1.0) * (m * t).sum(1)[:, None] * t)
        turned = np.cross(omega[:, None, :], frame.transpose(0, 2, 1)).transpose(0, 2, 1)
        return np.asarray(np.hstack([t, turned.reshape(n, 9)])).ravel()

    start = np.hstack([np.zeros((n, 3)), frames.reshape(n, 9)]).ravel()
    end = solve_ivp(slope, (0.0, 1.0), start, "DOP853", rtol=3e-12, atol=1e-13).y[:, -1]
    state = end.reshape(n, 12)
    return state[:, :3] * step, state[:, 3:].reshape(n, 3, 3)


def _tail_moments(rod: Equilibrium, at: int, moved: Array) -> Array:
    """Moments at the nodes of both layers from displacements, zero bending where they end."""
    force = rod.loads[:3]
    twist = rod.loads[5] * force / np.linalg.norm(force)
    near, far = moved[:at], moved[at + 1 :]
    back = np.vstack([-np.cumsum(near[::-1], axis=0)[::-1], np.zeros(3)])
    ahead = np.vstack([np.zeros(3), np.cumsum(far, axis=0)])
    return np.asarray(twist + np.cross(force, np.vstack([back, ahead])))


def independent(rod: Equilibrium) -> tuple[float, float]:
    """Misfit of center line, frames and ends by another integrator; relative error of the energy.

    The misfit is the largest component of position (L) or frame between neighbouring nodes.
    """
    misfit, energy_error = misfits(rod)
    return float(misfit.max()), energy_error


def misfits(rod: Equilibrium) -> tuple[Array, float]:
    """Largest component at start and end and from each node to the next; error of the energy.

    Their sum bounds, but for how the rod itself magnifies it, what is missing at the end.
    """
    s, layer = _layers(rod)
    h, force = np.diff(s), np.asarray(rod.loads[:3])
    line, frames = rod.centerline(s), rod.frames(s)
    inner = (s[:-1, None] + 0.5 * h[:, None] * (1.0 + _POINTS)).ravel()
    tangents = rod.frames(inner)[:, :, 2].reshape(len(h), -1, 3)
    keep = np.ones(len(h), dtype=np.bool_)
    first = max(np.abs(line[0]).max(), np.abs(frames[0] - np.eye(3)).max())
    last = np.abs(line[-1] - rod.clamping.position).max()
    last = max(last, np.abs(frames[-1] - rod.clamping.rotation).max())
    jumps = np.zeros(len(h))
    twist = 0.5 * rod.loads[5] ** 2 / rod.torsion_ratio
    if layer:
        at = len(s) // 2 - 1
        keep[at] = False
        size = float(np.linalg.norm(force))
        moved = 0.5 * h[:, None] * (_WEIGHTS[:, None] * tangents).sum(axis=1)
        for _ in range(2):
            moment = _tail_moments(rod, at, moved)[:-1]
            moved[keep], turned = _march(
                frames[:-1][keep], moment[keep], h[keep], force, rod.torsion_ratio
            )
        spun = Rotation.from_rotvec([0, 0, rod.loads[5] / rod.torsion_ratio * h[at]])
        jumps[at] = np.abs(frames[at] @ spun.as_matrix() - frames[at + 1]).max()
        jumps[at] = max(jumps[at], np.abs(line[at] + h[at] * force / size - line[at + 1]).max())
        # the first integral, free of the rounding of F × r
        bending = 0.5 * size * ((tangents - force / size) ** 2).sum(axis=2)
        bending[at] = 0.0
    else:
        moment = rod.moment(s)[:-1]
        moved, turned = _march(frames[:-1], moment, h, force, rod.torsion_ratio)
        bending = 0.5 * rod.curvature(inner).reshape(len(h), -1) ** 2
    jumps[keep] = np.abs((line[:-1] + moved - line[1:])[keep]).max(axis=1)
    jumps[keep] = np.maximum(jumps[keep], np.abs(turned - frames[1:][keep]).max(axis=(1, 2)))
    energy = float((0.5 * h) @ (bending @ _WEIGHTS)) + twist
    energy_error = abs(energy - rod.energy) / max(abs(rod.energy), 1e-12)
    return np.array([first, last, *jumps]), energy_error


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

    batch_of(slice(0, 2))  # compiled, and its stored rods loaded, before the clock starts
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
            "status": int(batch.status[i]), "position": positions[i].tolist(),
            "rotation": rotations[i].tolist(),
        }
        for i in np.flatnonzero(~right)
    ]  # fmt: skip
    points = [
        [float(root[i]), float(batch.residual[i]), float(timed[i])]
        for i in range(len(timed))
        if batch.converged[i]
    ]
    return _row(case, batch, right, mean, timed, checks, root), failures, points


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
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 3.8), layout="constrained")
    FigureCanvasAgg(figure)
    labels = ("residual", "run time, one pose / ms")
    for axis, column, label in zip(figure.subplots(1, 2), (1, 2), labels, strict=True):
        # a logarithm needs a floor: rods without force, residuals of exactly 0
        x, y = np.maximum(points[:, 0], 0.1), np.maximum(points[:, column], 1e-17)
        axis.loglog(x, y, ".", ms=2, alpha=0.5, color="#1b6ca8", rasterized=True)
        axis.set_xlabel("stiffness √(F L²/K0)")
        axis.set_ylabel(label)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=150)
    write_bytes(path, buffer.getvalue())


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
    from tqdm import tqdm

    out = Path(out)
    rows: list[Row] = []
    failures: list[Row] = []
    points: list[list[float]] = []
    bar = tqdm(poses.all_cases(), disable=not progress, unit="case")
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
            write_text(path, json.dumps(kept))
        row, failed, timed = kept["result"]
        rows.append(row)
        failures += failed
        points += timed
    write_csv(out / "stability.csv", rows)
    head = "# Poses of every kind\n\nResiduals and times of one core; see `stability.csv`.\n\n"
    write_text(out / "stability.md", head + markdown_table(rows, _COLUMNS) + "\n")
    write_text(out / "failures.json", json.dumps(failures, indent=1).replace("NaN", "null"))
    _draw(np.array(points).reshape(-1, 3), out / "stability.png")
    return rows
