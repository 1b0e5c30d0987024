"""Pictures; matplotlib is loaded when the first one is drawn."""

from pathlib import Path
from typing import Any

import numpy as np

from loopelastica.folding import LoopFold
from loopelastica.molecule.trace import smoothed_line, to_file_coordinates
from loopelastica.rod.clamping import Array

_POINTS = 101


def plot_fold(fold: LoopFold, path: Path, title: str = "", sticks: Array | None = None) -> None:
    """Draw the candidates and the native line from two sides, and the curvature along the loop.

    ``sticks`` (m, 2, 3) are the bonds of the first candidate's atoms, Å.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    assert fold.ends is not None
    figure = Figure(figsize=(11.0, 4.2))
    FigureCanvasAgg(figure)
    axes = figure.subplot_mosaic(
        [["front", "side", "curvature"]],
        width_ratios=[1, 1, 0.9],
        per_subplot_kw={("front", "side"): {"projection": "3d"}},
    )
    view = _view(fold)
    for name, azimuth in (("front", -90), ("side", 0)):
        _draw_lines(axes[name], fold, view)
        if sticks is not None:
            _draw_sticks(axes[name], sticks, view)
        axes[name].set_proj_type("ortho")
        axes[name].view_init(elev=6, azim=azimuth)
        # the axis one looks along has no room for its numbers
        (axes[name].yaxis if name == "front" else axes[name].xaxis).set_ticklabels([])
        axes[name].set_title(f"{title} {name}" if name == "front" else name, fontsize=9)
    _draw_curvature(axes["curvature"], fold)
    # fixed margins: a layout engine would draw the picture twice
    figure.subplots_adjust(left=0.01, right=0.985, bottom=0.13, top=0.92, wspace=0.12)
    axes["front"].legend(loc="upper left", fontsize=7, frameon=False)
    figure.savefig(path, dpi=120)


def _colour(rank: int) -> Any:
    return f"C{(rank - 1) % 10}"


def _view(fold: LoopFold) -> tuple[Array, Array]:
    """Origin and axes (columns) of the picture: x along the stem ends' chord, z away from it."""
    assert fold.ends is not None
    start, end = np.asarray(fold.ends.start_origin_A), np.asarray(fold.ends.end_origin_A)
    top = fold.candidates[0].trace.mean(axis=0)
    middle = 0.5 * (start + end)
    x = (end - start) / np.linalg.norm(end - start)
    z = top - middle - x * float((top - middle) @ x)
    # a loop that lies on the chord has no "up": any direction across will do
    if np.linalg.norm(z) < 1e-6:
        z = np.cross(x, np.eye(3)[np.argmin(np.abs(x))])
    z = z / np.linalg.norm(z)
    return middle, np.column_stack([x, np.cross(z, x), z])


def _draw_lines(axes: Any, fold: LoopFold, view: tuple[Array, Array]) -> None:
    assert fold.ends is not None
    middle, directions = view
    for candidate in reversed(fold.candidates):
        points = to_file_coordinates(
            candidate.rod.centerline(_POINTS),
            fold.ends.start_origin_A,
            fold.ends.start_frame,
            candidate.length_A,
        )
        line, trace = (points - middle) @ directions, (candidate.trace - middle) @ directions
        first = candidate.rank == 1
        label = f"{candidate.rank}: E/K0 {candidate.energy_per_A:.3f} /Å"
        if candidate.rmsd_A is not None:
            label += f", {candidate.rmsd_A:.2f} Å"
        axes.plot(*line.T, color=_colour(candidate.rank), lw=2.2 if first else 1.0, label=label)
        if first:
            axes.plot(*trace.T, "o", color=_colour(1), ms=4)
    if fold.backbone_A is not None:
        native = (fold.backbone_A[1:-1] - middle) @ directions
        smooth = (smoothed_line(fold.backbone_A, _POINTS) - middle) @ directions
        axes.plot(*smooth.T, color="0.25", lw=1.4, ls="--", label="file (smoothed)")
        axes.plot(*native.T, "s", color="0.25", ms=3)
    axes.set_aspect("equal")
    axes.tick_params(labelsize=6)
    axes.set_zlabel("Å", fontsize=7)


def _draw_sticks(axes: Any, sticks: Array, view: tuple[Array, Array]) -> None:
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    middle, directions = view
    bonds = Line3DCollection((sticks - middle) @ directions, colors="0.55", linewidths=0.9)
    bonds.set_label("atoms of 1")
    # the limits are those of atoms and lines together
    axes.add_collection3d(bonds, autolim=True)
    axes.auto_scale_xyz(*((sticks - middle) @ directions).reshape(-1, 3).T, had_data=True)
    axes.set_aspect("equal")


def _draw_curvature(axes: Any, fold: LoopFold) -> None:
    for candidate in reversed(fold.candidates):
        s = np.linspace(0.0, candidate.length_A, _POINTS)
        curvature = candidate.rod.curvature(_POINTS) / candidate.length_A
        axes.plot(s, curvature, color=_colour(candidate.rank), lw=2.0 if candidate.rank == 1 else 1)
    axes.set_xlabel("arc length (Å)")
    axes.set_ylabel("curvature (1/Å)")
    axes.set_ylim(bottom=0)
