"""Pictures; matplotlib is loaded when the first one is drawn."""

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from loopelastica._arrays import Array
from loopelastica._names import printable
from loopelastica.folding.expected import expected_text
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.setting import Setting
from loopelastica.molecule.trace import smoothed_line
from loopelastica.report.records import LINE_POINTS


def plot_fold(fold: LoopFold, path: Path, title: str = "", sticks: Array | None = None) -> None:
    """Write the picture of a loop.

    Parameters
    ----------
    fold, title, sticks
        As for :func:`draw_fold`.
    path : Path
        The picture; its suffix decides the format.
    """
    figure = draw_fold(fold, title=title, sticks=sticks)
    with warnings.catch_warnings():
        # letters of a name that the font lacks are drawn as boxes
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        figure.savefig(path, dpi=120)


def draw_fold(
    fold: LoopFold,
    setting: Setting | None = None,
    title: str = "",
    sticks: Array | None = None,
) -> Any:
    """Draw the candidates and the native line from two sides, and the curvature along the loop.

    Parameters
    ----------
    fold : LoopFold
        With at least one candidate.
    setting : Setting, optional
        What the loop is seen in.
    title : str
        What stands over it.
    sticks : (m, 2, 3) array, optional
        Bonds of the first candidate's atoms, Å.

    Returns
    -------
    matplotlib.figure.Figure
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    assert fold.ends is not None
    figure = Figure(figsize=(11.0, 4.2))
    FigureCanvasAgg(figure)
    axes = dict(zip(("front", "side", "curvature"), figure.subplots(1, 3), strict=True))
    middle, across, depth, up = _view(fold)
    for name, horizontal in (("front", across), ("side", depth)):

        def flat(points: Array, along: Array = horizontal) -> Array:
            return np.asarray((points - middle) @ np.column_stack([along, up]))

        if sticks is not None:
            _draw_sticks(axes[name], flat(sticks))
        _draw_lines(axes[name], fold, flat)
        # a title is a name, in which a dollar begins no formula
        text = f"{title} {name}" if name == "front" else name
        axes[name].set_title(text, fontsize=9, parse_math=False)
        axes[name].set_xlabel("Å")
    _same_scale(axes["front"], axes["side"])
    _draw_curvature(axes["curvature"], fold)
    text = f"expected error of 1 (80 %): {expected_text(fold.candidates[0].expected_rmsd_A)} Å"
    axes["side"].text(0.03, 0.95, text, transform=axes["side"].transAxes, fontsize=7)
    # fixed margins: a layout engine would draw the picture twice
    figure.subplots_adjust(left=0.05, right=0.985, bottom=0.13, top=0.92, wspace=0.2)
    # the lines are drawn from the last to the first
    handles, labels = axes["front"].get_legend_handles_labels()
    last = len(fold.candidates)
    shown = [*range(last)[::-1], *range(last, len(labels))]
    legend = axes["front"].legend(
        [handles[k] for k in shown], [labels[k] for k in shown],
        loc="upper left", fontsize=7, frameon=False,
    )  # fmt: skip
    for label in legend.get_texts():
        label.set_parse_math(False)
    return figure


def _colour(rank: int) -> Any:
    return f"C{(rank - 1) % 10}"


def _view(fold: LoopFold) -> tuple[Array, Array, Array, Array]:
    """Origin and axes of the picture: along the stem ends' chord, into it, and away from it."""
    assert fold.ends is not None
    start, end = fold.ends.start_origin_A, fold.ends.end_origin_A
    top = fold.candidates[0].trace.mean(axis=0)
    middle = 0.5 * (start + end)
    x = (end - start) / np.linalg.norm(end - start)
    z = top - middle - x * float((top - middle) @ x)
    # a loop that lies on the chord has no "up": any direction across will do
    if np.linalg.norm(z) < 1e-6:
        z = np.cross(x, np.eye(3)[np.argmin(np.abs(x))])
    z = z / np.linalg.norm(z)
    return middle, x, np.cross(z, x), z


def _draw_lines(axes: Any, fold: LoopFold, flat: Callable[[Array], Array]) -> None:
    for candidate in reversed(fold.candidates):
        points = candidate.line.points(LINE_POINTS)
        first = candidate.rank == 1
        # printable: a shape may be called after a file
        label = f"{candidate.rank}: {printable(candidate.shape)}"
        if candidate.rmsd_A is not None:
            label += f", {candidate.rmsd_A:.2f} Å"
        axes.plot(
            *flat(points).T, color=_colour(candidate.rank), lw=2.2 if first else 1.0, label=label
        )
        if first:
            axes.plot(*flat(candidate.trace).T, "o", color=_colour(1), ms=4)
    if fold.backbone_A is not None:
        smooth = flat(smoothed_line(fold.backbone_A, LINE_POINTS))
        axes.plot(*smooth.T, color="0.25", lw=1.4, ls="--", label="file (smoothed)")
        axes.plot(*flat(fold.backbone_A[1:-1]).T, "s", color="0.25", ms=3)


def _draw_sticks(axes: Any, sticks: Array) -> None:
    from matplotlib.collections import LineCollection

    axes.add_collection(
        LineCollection(sticks, colors="0.6", linewidths=0.9, label="atoms of 1"), autolim=True
    )


def _same_scale(*both: Any) -> None:
    """Squares of one scale, with room for the legend above."""
    low = min(axes.dataLim.y0 for axes in both)
    high = max(axes.dataLim.y1 for axes in both)
    size = 1.1 * max(high - low, *(axes.dataLim.width for axes in both))
    for axes in both:
        middle = 0.5 * (axes.dataLim.x0 + axes.dataLim.x1)
        axes.set_xlim(middle - 0.5 * size, middle + 0.5 * size)
        axes.set_ylim(low - 0.05 * size, low + 0.95 * size)
        axes.set_aspect("equal")


def _draw_curvature(axes: Any, fold: LoopFold) -> None:
    for candidate in reversed(fold.candidates):
        s = np.linspace(0.0, candidate.line.curve_A, LINE_POINTS)
        curvature = candidate.line.curvature_per_A(LINE_POINTS)
        axes.plot(s, curvature, color=_colour(candidate.rank), lw=2.0 if candidate.rank == 1 else 1)
    axes.set_xlabel("arc length (Å)")
    axes.set_ylabel("curvature (1/Å)")
    axes.set_ylim(bottom=0)
