"""How time and memory grow with the number of rods, threads, arc length and number of equilibria.

Rods are drawn, solved and forgotten chunk by chunk, each row in a process of its own, so that the
peak of its memory is its own. A slope is that of a straight line through the logarithms: 1 where
time is proportional (``scaling_report``).
"""

import dataclasses
import math
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from loopelastica._files import write_csv, write_text
from loopelastica.rod.batch import solve_batch
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibria import equilibria
from loopelastica.rod.parameters import PhysicalParameters
from loopelastica.studies.bench import poses, scaling_plots
from loopelastica.studies.bench.machine import peak_memory_MB, setting
from loopelastica.studies.bench.scaling_report import CHUNK, NEAR, markdown, named, slopes

__all__ = ["run", "stream"]

Row = dict[str, Any]

_SEED = 2026
# of rods at most: default and full; rods of each length; clampings whose equilibria are listed
_MOST, _PER_LENGTH, _LISTED = (10**4, 10**6), (20, 300), (12, 100)
_THREADS = (1, 2)
# bounds of L/μ: each row is a factor of two
_LENGTHS = tuple(2.0**k for k in range(8))
_REPEATS = 20


def stream(rods: int, threads: int, seed: int) -> Row:
    """Draw and solve load-drawn clampings chunk by chunk, in this process.

    Parameters
    ----------
    rods, threads : int
        How many clampings, on how many threads.
    seed : int
        Of the random clampings.

    Returns
    -------
    dict
        ``rods``, ``threads``, ``seconds`` of wall time in ``solve_batch``, ``processor_s`` of
        all its threads, ``per_rod_us``, ``solved``, ``residual_max`` and ``memory_MB``, the peak of
        the process.
    """
    seconds, processor, solved, worst = 0.0, 0.0, 0, 0.0
    solve_batch(*poses.load_drawn(np.random.default_rng(seed), 2), lowest=False)
    for first in range(0, rods, CHUNK):
        # every chunk has its own stream of numbers: the same rods for any number of them
        rng = np.random.default_rng([seed, first])
        positions, rotations = poses.load_drawn(rng, min(CHUNK, rods - first))
        started, spent = time.perf_counter(), time.process_time()
        batch = solve_batch(positions, rotations, lowest=False, threads=threads)
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
    from loopelastica.rod.kernels.finite_rod import rod_along

    y, z = np.empty(kernel.WITH_JACOBIAN), np.empty(kernel.WITH_JACOBIAN)
    k, at = np.empty(12 * kernel.WITH_JACOBIAN), np.ones(1)
    closed, integrated = [], []
    for p in rods:
        numbers = dataclasses.astuple(p)
        closed.append(_timed_us(lambda numbers=numbers: rod_along(*numbers, 1.0, at), _REPEATS))
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
    solve_batch(positions[:1], rotations[:1], lowest=False)
    times, solved = [], 0
    for i in range(sample):
        started = time.perf_counter()
        batch = solve_batch(positions[i : i + 1], rotations[i : i + 1], lowest=False)
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
    from loopelastica._progress import progress_bar

    out = Path(out)
    counts = [10**k for k in range(round(math.log10(_MOST[full])) + 1)]
    streams = [(n, threads) for threads in _THREADS for n in counts]
    drawn = poses.shell(np.random.default_rng(seed), _LISTED[full], 0.0, NEAR)
    clampings = [Clamping(p, r) for p, r in zip(*drawn, strict=True)]
    rods, lengths, found = [], [], []
    total = len(streams) + len(_LENGTHS) + len(clampings)
    with progress_bar(total=total, shown=progress, unit="row") as bar:
        for n, threads in streams:
            bar.set_description(f"{n:,d} rods, {named(threads)}")
            rods.append(_alone(n, threads, seed))
            bar.update()
        for shortest in _LENGTHS:
            bar.set_description(f"L/μ from {shortest:g}")
            lengths.append(_length_row(shortest, _PER_LENGTH[full], seed))
            bar.update()
        bar.set_description("equilibria")
        equilibria(clampings[0])  # compiled, and its guess library loaded, before the clock starts
        for clamping in clampings:
            found.append(_equilibria_row(clamping))
            bar.update()
    stated = slopes(rods, lengths, found)
    for name, rows in (
        ("rods", rods), ("lengths", lengths), ("equilibria", found), ("slopes", stated),
    ):  # fmt: skip
        write_csv(out / f"{name}.csv", rows)
    write_text(out / "scaling.md", markdown(rods, lengths, found, stated))
    scaling_plots.draw(rods, lengths, found, stated, out / "scaling.png", setting())
    return stated
