"""How time and memory grow with the number of rods, threads, arc length and number of equilibria.

Rods are drawn, solved and forgotten chunk by chunk, each row in a process of its own, so that the
peak of its memory is its own. A slope is that of a straight line through the logarithms: 1 where
time is proportional.
"""

import inspect
import math
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from loopelastica.rod.batch import solve_batch
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibria import equilibria
from loopelastica.rod.parameters import PhysicalParameters
from loopelastica.studies.bench import _poses as poses
from loopelastica.studies.bench import _scaling_plots
from loopelastica.studies.bench._machine import peak_memory_MB, setting
from loopelastica.studies.bench._report import markdown_table, write_csv, write_text

__all__ = ["run", "slope", "stream"]

Row = dict[str, Any]

_SEED = 2026
# rods drawn and solved at once when streaming
_CHUNK = 8192
# of rods at most: default and full; rods of each length; clampings whose equilibria are listed
_MOST, _PER_LENGTH, _LISTED = (10**4, 10**6), (20, 300), (12, 100)
_THREADS = (1, 2)
# bounds of L/μ: each row is a factor of two
_LENGTHS = tuple(2.0**k for k in range(8))
# from here on the time of one call no longer counts
_MANY = 1000
_NEAR = 0.95
_REPEATS = 20


def slope(x: Sequence[float], y: Sequence[float]) -> float | None:
    """Slope of log y over log x by least squares; None for fewer than two different x."""
    if len(set(x)) < 2:
        return None
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def _thread_counts() -> tuple[int, ...]:
    """1 and 2, or 1 alone where ``solve_batch`` takes no threads."""
    return _THREADS if "threads" in inspect.signature(solve_batch).parameters else _THREADS[:1]


def stream(rods: int, threads: int, seed: int) -> Row:
    """Draw and solve ``rods`` load-drawn clampings chunk by chunk, in this process.

    Returns
    -------
    dict
        ``rods``, ``threads``, ``seconds`` of wall time in ``solve_batch``, ``processor_s`` of
        all its threads, ``per_rod_us``, ``solved``, ``residual_max`` and ``memory_MB``, the peak of
        the process.
    """
    options: dict[str, Any] = {"threads": threads} if threads > 1 else {}
    seconds, processor, solved, worst = 0.0, 0.0, 0, 0.0
    solve_batch(*poses.load_drawn(np.random.default_rng(seed), 2), **options)
    for first in range(0, rods, _CHUNK):
        # every chunk has its own stream of numbers: the same rods for any number of them
        rng = np.random.default_rng([seed, first])
        positions, rotations = poses.load_drawn(rng, min(_CHUNK, rods - first))
        started, spent = time.perf_counter(), time.process_time()
        batch = solve_batch(positions, rotations, **options)
        seconds += time.perf_counter() - started
        processor += time.process_time() - spent
        solved += int(batch.converged.sum())
        worst = max(worst, float(batch.residual[batch.converged].max(initial=0.0)))
    return {
        "rods": rods,
        "threads": threads,
        "seconds": round(seconds, 6),
        "processor_s": round(processor, 6),
        "per_rod_us": round(1e6 * seconds / rods, 3),
        "solved": solved,
        "residual_max": worst,
        "memory_MB": round(peak_memory_MB(), 1),
    }


def _alone(rods: int, threads: int, seed: int) -> Row:
    """`stream` in a fresh process."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(stream, rods, threads, seed).result()


def _timed_us(call: Any, repeats: int) -> float:
    call()
    started = time.perf_counter()
    for _ in range(repeats):
        call()
    return 1e6 * (time.perf_counter() - started) / repeats


def _forward_us(rods: Sequence[PhysicalParameters]) -> tuple[float, float]:
    """Median time of the closed form and of the integrator for one end."""
    from loopelastica.rod.kernels import shooting as kernel
    from loopelastica.rod.kernels.closed_form import rod_along

    y, z = np.empty(kernel.WITH_JACOBIAN), np.empty(kernel.WITH_JACOBIAN)
    k, at = np.empty(12 * kernel.WITH_JACOBIAN), np.ones(1)
    closed, integrated = [], []
    for p in rods:
        numbers = (p.lam, p.t_p, p.a, p.phi0, p.s_ini, p.length, 1.0)
        closed.append(_timed_us(lambda numbers=numbers: rod_along(*numbers, at), _REPEATS))
        loads = p.loads()
        steps = kernel.step_count(loads, 4.0)
        call = (loads, 1.0, steps, kernel.POSE, y, k, z)
        integrated.append(_timed_us(lambda call=call: kernel.shoot(*call), _REPEATS))
    return float(np.median(closed)), float(np.median(integrated))


def _length_row(shortest: float, sample: int, seed: int) -> Row:
    """Clampings of random rods with L/μ from ``shortest`` to twice that, one by one."""
    rods = poses.of_length(
        np.random.default_rng([seed, int(shortest)]), sample, shortest, 2.0 * shortest
    )
    positions, rotations = poses.ends_of(rods)
    solve_batch(positions[:1], rotations[:1])
    times, solved = [], 0
    for i in range(sample):
        started = time.perf_counter()
        batch = solve_batch(positions[i : i + 1], rotations[i : i + 1])
        times.append(1e3 * (time.perf_counter() - started))
        solved += int(batch.converged[0])
    closed, integrated = _forward_us(rods)
    return {
        "length": math.sqrt(2.0) * shortest,
        "sample": sample,
        "solved": solved,
        "time_median_ms": round(float(np.median(times)), 5),
        "time_mean_ms": round(float(np.mean(times)), 5),
        "time_p99_ms": round(float(np.quantile(times, 0.99)), 5),
        "closed_form_us": round(closed, 3),
        "integrator_us": round(integrated, 3),
    }


def _equilibria_row(clamping: Clamping) -> Row:
    started = time.perf_counter()
    found = equilibria(clamping)
    return {
        "equilibria": len(found),
        "starts": found.starts,
        "unseen": round(found.unseen, 4),
        "time_ms": round(1e3 * (time.perf_counter() - started), 4),
    }


def _named(threads: int) -> str:
    return f"{threads} thread{'s' * (threads > 1)}"


def _slopes(rods: Sequence[Row], lengths: Sequence[Row], found: Sequence[Row]) -> list[Row]:
    """What is stated about each curve."""
    rows: list[Row] = []

    def add(what: str, x: Sequence[float], y: Sequence[float]) -> None:
        rows.append({"what": what, "points": len(x), "slope": slope(x, y)})

    for threads in sorted({row["threads"] for row in rods}):
        chosen = [row for row in rods if row["threads"] == threads]
        many = [row for row in chosen if row["rods"] >= _MANY]
        for what, part in (("all", chosen), (f"{_MANY:,d} and more", many)):
            x = [row["rods"] for row in part]
            for key, name in (("seconds", "time"), ("processor_s", "processor time")):
                label = f"{name} over number of rods, {what}, {_named(threads)}"
                add(label, x, [row[key] for row in part])
        add(
            f"memory over number of rods, {_named(threads)}",
            [row["rods"] for row in chosen], [row["memory_MB"] for row in chosen],
        )  # fmt: skip
    x = [row["length"] for row in lengths]
    add("median time of an inversion over L/μ", x, [row["time_median_ms"] for row in lengths])
    add("time of the closed form over L/μ", x, [row["closed_form_us"] for row in lengths])
    add("time of the integrator over L/μ", x, [row["integrator_us"] for row in lengths])
    some = [row for row in found if row["equilibria"]]
    add(
        "time of `equilibria` over their number",
        [row["equilibria"] for row in some], [row["time_ms"] for row in some],
    )  # fmt: skip
    return rows


def _speedups(rods: Sequence[Row]) -> list[str]:
    single = {row["rods"]: row["seconds"] for row in rods if row["threads"] == 1}
    several = [row for row in rods if row["threads"] > 1 and row["rods"] >= _MANY]
    return [
        f"- {_named(row['threads'])}, {row['rods']:,d} rods:"
        f" {single[row['rods']] / row['seconds']:.2f} × one"
        for row in several
    ]


_ROD_COLUMNS = {
    "rods": ("rods", ",d"),
    "threads": ("threads", "d"),
    "seconds": ("s", ".4g"),
    "processor_s": ("processor / s", ".4g"),
    "per_rod_us": ("µs per rod", ".4g"),
    "solved": ("solved", ",d"),
    "residual_max": ("residual, max", ".1e"),
    "memory_MB": ("peak memory / MB", ".0f"),
}
_LENGTH_COLUMNS = {
    "length": ("L/μ", ".3g"),
    "sample": ("sample", ",d"),
    "solved": ("solved", ",d"),
    "time_median_ms": ("ms, median", ".3f"),
    "time_mean_ms": ("mean", ".3f"),
    "time_p99_ms": ("p99", ".3f"),
    "closed_form_us": ("closed form / µs", ".2f"),
    "integrator_us": ("integrator / µs", ".2f"),
}
_FOUND_COLUMNS = {
    "equilibria": ("equilibria", "d"),
    "clampings": ("clampings", "d"),
    "time_median_ms": ("ms, median", ".1f"),
    "time_max_ms": ("max", ".1f"),
}
_SLOPE_COLUMNS = {"what": ("what", ""), "points": ("points", "d"), "slope": ("slope", ".3f")}


def _by_count(found: Sequence[Row]) -> list[Row]:
    rows = []
    for count in sorted({row["equilibria"] for row in found}):
        times = [row["time_ms"] for row in found if row["equilibria"] == count]
        rows.append({
            "equilibria": count, "clampings": len(times),
            "time_median_ms": float(np.median(times)), "time_max_ms": max(times),
        })  # fmt: skip
    return rows


def _markdown(
    rods: Sequence[Row], lengths: Sequence[Row], found: Sequence[Row], slopes: Sequence[Row]
) -> str:
    times = [row["time_ms"] for row in found]
    parts = [
        "# Scaling", "", f"{setting()}; wall time where nothing else is said.",
        "", "## Slopes", "", markdown_table(slopes, _SLOPE_COLUMNS),
        "", "## Number of rods", "",
        f"Load-drawn, the first equilibrium, drawn and solved in chunks of {_CHUNK:,d}.", "",
        markdown_table(rods, _ROD_COLUMNS), "", *_speedups(rods),
        "", "## Arc length", "",
        "Ends of random rods with L/μ within a factor √2, one by one; the end alone by the closed"
        " form and by the integrator at 4 steps per radian.", "",
        markdown_table(lengths, _LENGTH_COLUMNS),
        "", "## Number of equilibria", "",
        f"Pose-drawn, |η| < {_NEAR}; median of all {np.median(times):.0f} ms.", "",
        markdown_table(_by_count(found), _FOUND_COLUMNS),
    ]  # fmt: skip
    return "\n".join(parts) + "\n"


def run(out: Path, full: bool = False, seed: int = _SEED, progress: bool = True) -> list[Row]:
    """Measure how time and memory grow.

    Parameters
    ----------
    out : Path
        Folder for ``rods.csv``, ``lengths.csv``, ``equilibria.csv``, ``slopes.csv``,
        ``scaling.md`` and ``scaling.png``.
    full : bool
        Up to 10⁶ rods, some minutes; otherwise up to 10⁴.
    seed : int
        Of the random rods.
    progress : bool
        Show a bar on standard error.

    Returns
    -------
    list of dict
        The lines of ``slopes.csv``.
    """
    from tqdm import tqdm

    out = Path(out)
    counts = [10**k for k in range(round(math.log10(_MOST[full])) + 1)]
    streams = [(n, threads) for threads in _thread_counts() for n in counts]
    drawn = poses.shell(np.random.default_rng(seed), _LISTED[full], 0.0, _NEAR)
    clampings = [Clamping(p, r) for p, r in zip(*drawn, strict=True)]
    rods, lengths, found = [], [], []
    total = len(streams) + len(_LENGTHS) + len(clampings)
    with tqdm(total=total, disable=not progress, unit="row") as bar:
        for n, threads in streams:
            bar.set_description(f"{n:,d} rods, {_named(threads)}")
            rods.append(_alone(n, threads, seed))
            bar.update()
        for shortest in _LENGTHS:
            bar.set_description(f"L/μ from {shortest:g}")
            lengths.append(_length_row(shortest, _PER_LENGTH[full], seed))
            bar.update()
        bar.set_description("equilibria")
        equilibria(clampings[0])  # compiled, and its stored rods loaded, before the clock starts
        for clamping in clampings:
            found.append(_equilibria_row(clamping))
            bar.update()
    slopes = _slopes(rods, lengths, found)
    for name, rows in (
        ("rods", rods), ("lengths", lengths), ("equilibria", found), ("slopes", slopes),
    ):  # fmt: skip
        write_csv(out / f"{name}.csv", rows)
    write_text(out / "scaling.md", _markdown(rods, lengths, found, slopes))
    _scaling_plots.draw(rods, lengths, found, slopes, out / "scaling.png", setting())
    return slopes
