"""The paper's studies, run again: Figs. 3, 4 and 5.

Ameline et al., J. Comput. Phys. 373 (2018) 736, DOI 10.1016/j.jcp.2018.07.021, section 4. Each cell
is one grid of guesses, one error and one set of tested rods; each rod goes through the testing path
(eq. 37): p → q1 → inversion → p̄ → q1, and counts as a success when max|q_5D − q̄_5D| < 1e-5
(eq. 39). Time is the processor's on the whole path, compiled, one core; iterations are all Newton
steps spent on a rod, those of failed runs included.

The rods of a cell are taken in a random order that a seed fixes, so that any number of first ones
is a fair sample and a longer run continues a shorter one. What has been measured is kept in
``partial/`` of the output folder after each chunk; an interrupted run goes on from there, and a
sample already larger than requested is used whole.
"""

import io
import json
import os
import time
import zipfile
import zlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica._files import whole_file, write_csv, write_text
from loopelastica.rod.paper import ERRORS, FORWARD, PaperSolver, grid, grid_kernels
from loopelastica.rod.paper import path as paper_path
from loopelastica.studies.bench import ours, paper_plots
from loopelastica.studies.bench.markdown import markdown_table
from loopelastica.studies.bench.paper_cells import Cell, cells_of

__all__ = ["run"]

Row = dict[str, Any]

_SUCCESS = 1e-5  # eq. 39
_SAMPLE = 400
_SEED = 2018
# rods measured between two saves: about a second
_CHUNK = 200
_FIGURES = (3, 4, 5)
# columns of the measured rows
_DEFECT, _ITERATIONS, _RESTARTS, _RIDDERS, _STATUS = range(5)
# raise when the meaning of partial results changes
_VERSION = 1


def _shuffled(cell: Cell, seed: int) -> Array:
    """The cell's rods (n, 5) in the random order of the seed."""
    rods = grid.trial_points(cell.l, cell.delta, cell.spacing)
    return np.ascontiguousarray(rods[np.random.default_rng(seed).permutation(len(rods))])


def _measure(rods: Array, solver: PaperSolver) -> tuple[Array, float]:
    """Results (n, 5) of the testing path, and the seconds it took."""
    guesses, out = solver.grid, np.empty((len(rods), 5))
    # processor time: other work on the machine does not count
    started = time.thread_time()
    paper_path.paths(
        rods,
        guesses.points,
        guesses.images,
        solver.symmetry,
        ERRORS[solver.scan],
        ERRORS[solver.error],
        solver.torsion_ratio,
        FORWARD[solver.forward],
        solver.tolerance,
        9,
        out,
    )
    return out, time.thread_time() - started


def _read(path: Path, label: str) -> tuple[Array, float]:
    """Partial results (n, 5) and seconds; none where there are none of this label."""
    try:
        # from memory: a damaged archive would leave its file open
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as archive:
            if str(archive["label"]) == label:
                return np.asarray(archive["results"]), float(archive["seconds"])
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error):
        pass
    return np.empty((0, 5)), 0.0


def _write(path: Path, label: str, results: Array, seconds: float) -> None:
    with whole_file(path) as part:
        np.savez_compressed(part, label=label, results=results, seconds=seconds)


def _tested(
    rods: Array,
    requested: int,
    solver: PaperSolver,
    path: Path,
    label: str,
    show: Callable[[int], object],
) -> tuple[Array, float]:
    """Results of the first ``requested`` rods or more, and seconds; kept in ``path`` on the way.

    ``show`` is called with the number of rods done before each chunk.
    """
    results, seconds = _read(path, label)
    if len(results) < requested:
        _measure(rods[:2], solver)  # compiled, and its grid built, before the clock starts
    for first in range(len(results), requested, _CHUNK):
        show(first)
        more, took = _measure(rods[first : min(first + _CHUNK, requested)], solver)
        results, seconds = np.vstack([results, more]), seconds + took
        _write(path, label, results, seconds)
    return results, seconds


def _row(cell: Cell, rods: Array, results: Array, seconds: float, guesses: int) -> Row:
    """One line of the table."""
    tested = rods[: len(results)]
    success = results[:, _DEFECT] < _SUCCESS
    singular = np.abs(np.abs(tested[:, 0]) - np.abs(tested[:, 1])) < 1e-9

    def percent(share: NDArray[np.bool_]) -> float | None:
        return round(100.0 * float(share.mean()), 3) if len(share) else None

    return {
        "figure": cell.figure,
        "l": cell.l,
        "delta": cell.delta,
        "error": cell.error,
        "scan": cell.scan,
        "symmetry": cell.symmetry,
        "guesses": guesses,
        "rods": len(rods),
        "paper_rods": cell.paper_rods,
        "tested": len(results),
        "success_percent": percent(success),
        "paper_success_percent": cell.paper_success_percent,
        "success_regular_percent": percent(success[~singular]),
        "success_singular_percent": percent(success[singular]),
        "first_run_percent": percent(success & (results[:, _RIDDERS] == 0)),
        "iterations": round(float(results[:, _ITERATIONS].mean()), 3),
        "restarts": round(float(results[:, _RESTARTS].mean()), 4),
        "singular_percent": round(100.0 * grid.singular_share(rods), 2),
        "time_ms": round(1e3 * seconds / len(results), 4),
        "paper_time_ms": cell.paper_time_ms,
    }


_COLUMNS = {
    "l": ("l", "g"),
    "delta": ("δ", "g"),
    "error": ("error", ""),
    "scan": ("scan", ""),
    "symmetry": ("symmetry", ""),
    "guesses": ("guesses", ",d"),
    "tested": ("tested", ",d"),
    "rods": ("of", ",d"),
    "paper_rods": ("paper's", ",d"),
    "success_percent": ("success / %", ".2f"),
    "paper_success_percent": ("paper's / %", ".1f"),
    "success_regular_percent": ("off t_P = ±λ / %", ".2f"),
    "success_singular_percent": ("on t_P = ±λ / %", ".2f"),
    "first_run_percent": ("at the first run / %", ".2f"),
    "iterations": ("iterations", ".2f"),
    "singular_percent": ("t_P = ±λ / %", ".1f"),
    "time_ms": ("time / ms", ".2f"),
    "paper_time_ms": ("paper's / ms", ".0f"),
}


def _own_rows(
    cells: Sequence[Cell], whole: bool, sample: int, seed: int, progress: bool
) -> list[Row]:
    """The package's own solver on each set of rods, once."""
    from loopelastica._progress import progress_bar

    sets = {(cell.l, cell.delta, cell.halved): cell for cell in cells}
    rows = []
    for cell in progress_bar(sets.values(), shown=progress, unit="set", desc="own solver"):
        rods = _shuffled(cell, seed)
        tested = len(rods) if whole else min(sample, len(rods))
        rows.append(ours.row(cell.l, cell.delta, rods, tested, min(2, os.cpu_count() or 1)))
    return rows


def _markdown(rows: Sequence[Row], own: Sequence[Row], solver: PaperSolver) -> str:
    parts = [
        "# The paper's studies",
        "",
        "Ameline et al., J. Comput. Phys. 373 (2018) 736, Figs. 3 and 4, run again with its method",
        f"as printed; ε_c = {solver.tolerance:g}, processor time of one core. Success is",
        "max|q − q̄| < 1e-5 (eq. 39), “scan” the error that chooses the guess,",
        "iterations are all Newton steps spent on a rod, “at the first run” counts the rods that",
        "needed neither Ridders' derivatives nor another guess. The paper's times are its own",
        "machine's (Intel i7-5930K, 3.5 GHz).",
    ]
    for figure, title in ((3, "Fig. 3: step δ and error"), (4, "Fig. 4: size l and symmetry")):
        chosen = [row for row in rows if row["figure"] == figure]
        if chosen:
            parts += ["", f"## {title}", "", markdown_table(chosen, _COLUMNS)]
    if own:
        parts += ["", "## The package's own solver on the same rods (wall time)", ""]
        parts += [markdown_table(own, ours.COLUMNS)]
    return "\n".join(parts) + "\n"


def _draw(rows: Sequence[Row], figures: Sequence[int], out: Path, seed: int) -> None:
    for figure, draw in ((3, paper_plots.draw_steps), (4, paper_plots.draw_sizes)):
        chosen = [row for row in rows if row["figure"] == figure]
        if chosen:
            draw(chosen, out / f"fig{figure}.png")
    if 5 in figures:
        cell = Cell(5, 2.0, 0.5, "eps2", True, True, 53170)
        rods = _shuffled(cell, seed)
        images = grid_kernels.images(rods, 1.0)
        results, _ = _read(_partial(out, cell), _label(cell, seed, len(rods), _solver(cell)))
        missed = np.zeros(len(rods), dtype=np.bool_)
        missed[: len(results)] = results[:, _DEFECT] >= _SUCCESS
        paper_plots.draw_targets(images, missed, out / "fig5.png")


def _solver(cell: Cell) -> PaperSolver:
    return PaperSolver(cell.l, cell.delta, cell.error, cell.symmetry, scan=cell.scan)


def _partial(out: Path, cell: Cell) -> Path:
    return out / "partial" / f"{cell.name}.npz"


def _label(cell: Cell, seed: int, rods: int, solver: PaperSolver) -> str:
    return json.dumps([_VERSION, cell.name, cell.spacing, seed, rods, solver.tolerance])


def run(
    out: Path,
    full: bool = False,
    sample: int = _SAMPLE,
    figures: Sequence[int] = _FIGURES,
    seed: int = _SEED,
    progress: bool = True,
    own_full: bool = False,
) -> list[Row]:
    """Run the studies of Figs. 3, 4 and 5 again, and the package's own solver on their rods.

    Parameters
    ----------
    out : Path
        Folder for ``paper.csv``, ``own.csv``, ``paper.md``, ``fig3.png``, ``fig4.png``,
        ``fig5.png`` and the partial results. A run into the same folder continues an earlier one.
    full : bool
        Test all rods: some 1.9 million inversions, about an hour.
    sample : int
        Rods in each cell otherwise.
    figures : sequence of int
        Which of 3, 4, 5.
    seed : int
        Of the random order of the rods.
    progress : bool
        Show a bar on standard error.
    own_full : bool
        Test all rods with the package's own solver only: minutes.

    Returns
    -------
    list of dict
        The lines of ``paper.csv``.

    Raises
    ------
    ValueError
        If `sample` is not positive or `figures` has another number.
    """
    if sample < 1:
        raise ValueError(f"`sample` is {sample}; it must be at least 1")
    if not set(figures) <= set(_FIGURES):
        raise ValueError(f"`figures` is {tuple(figures)}; only {_FIGURES} can be run")
    from loopelastica._progress import progress_bar

    out = Path(out)
    rows = []
    cells = cells_of(figures)
    bar = progress_bar(total=len(cells), shown=progress, unit="cell")
    with bar:
        for cell in cells:
            solver = _solver(cell)
            rods = _shuffled(cell, seed)
            requested = len(rods) if full else min(sample, len(rods))
            label = _label(cell, seed, len(rods), solver)

            def show(done: int, goal: str = f"{requested:,d}, {cell.name}") -> None:
                bar.set_description(f"{done:,d} of {goal}")

            results, seconds = _tested(rods, requested, solver, _partial(out, cell), label, show)
            rows.append(_row(cell, rods, results, seconds, len(solver.grid)))
            bar.update()
    own = _own_rows(cells, full or own_full, sample, seed, progress)
    write_csv(out / "paper.csv", rows)
    write_csv(out / "own.csv", own)
    write_text(
        out / "paper.md", _markdown(rows, own, _solver(Cell(3, 2, 0.5, "eps2", True, True, 0)))
    )
    _draw(rows, figures, out, seed)
    return rows
