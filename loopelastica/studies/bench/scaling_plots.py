"""Time and memory over the number of rods, their length and the number of equilibria."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from loopelastica.studies.figures import new_figure, save_figure

Row = dict[str, Any]

_COLORS = ("#1b6ca8", "#c8553d", "#588157", "#7b5ea7")


def _stated(slopes: Sequence[Row], what: str) -> str:
    value = next((row["slope"] for row in slopes if row["what"].startswith(what)), None)
    return "" if value is None else f", slope {value:.2f}"


def _over_rods(axes: Sequence[Any], rods: Sequence[Row]) -> None:
    for color, threads in zip(_COLORS, sorted({row["threads"] for row in rods}), strict=False):
        chosen = [row for row in rods if row["threads"] == threads]
        x = [row["rods"] for row in chosen]
        label = f"{threads} thread{'s' * (threads > 1)}"
        axes[0].loglog(x, [row["seconds"] for row in chosen], "o-", color=color, ms=4, label=label)
        axes[1].semilogx(
            x, [row["memory_MB"] for row in chosen], "s-", color=color, ms=4, label=label
        )
    last = max(rods, key=lambda row: row["rods"])
    steady = [last["seconds"] * n / last["rods"] for n in x]
    axes[0].loglog(x, steady, ":", color="0.5", lw=1, label="proportional")
    axes[0].set_ylabel("wall time in solve_batch / s")
    axes[1].set_ylabel("peak memory of the process / MB")
    axes[1].set_ylim(0.0, 1.3 * max(row["memory_MB"] for row in rods))
    for axis in axes[:2]:
        axis.set_xlabel("load-drawn rods, streamed in chunks")


def _over_lengths(axis: Any, lengths: Sequence[Row], slopes: Sequence[Row]) -> None:
    x = [row["length"] for row in lengths]
    for color, key, scale, label, what in (
        (_COLORS[0], "time_median_ms", 1.0, "inversion, median", "median time of an inversion"),
        (_COLORS[2], "integrator_us", 1e-3, "end by the integrator", "time of the integrator"),
        (_COLORS[1], "closed_form_us", 1e-3, "end by the closed form", "time of the closed form"),
    ):
        y = [scale * row[key] for row in lengths]
        axis.loglog(x, y, "o-", color=color, ms=4, label=label + _stated(slopes, what))
    axis.loglog(
        x, [row["time_p99_ms"] for row in lengths], ":", color=_COLORS[0], lw=1,
        label="inversion, 99th percentile",
    )  # fmt: skip
    axis.set_ylim(top=30.0 * max(row["time_p99_ms"] for row in lengths))  # room for the legend
    axis.set_xlabel("arc length L/μ")
    axis.set_ylabel("time per rod / ms")


def draw(
    rods: Sequence[Row], lengths: Sequence[Row], found: Sequence[Row], slopes: Sequence[Row],
    path: Path, setting: str,
) -> None:  # fmt: skip
    """Four panels, each with its legend.

    Parameters
    ----------
    rods, lengths, found, slopes : sequence of dict
        Lines of ``rods.csv``, ``lengths.csv``, ``equilibria.csv`` and ``slopes.csv``.
    path : Path
        Of the PNG.
    setting : str
        Machine and date, for the title.
    """
    figure = new_figure(10.0, 7.2)
    axes = figure.subplots(2, 2).ravel()
    _over_rods(axes, rods)
    _over_lengths(axes[2], lengths, slopes)
    axes[3].plot(
        [row["equilibria"] for row in found], [row["time_ms"] for row in found], "o",
        color=_COLORS[3], ms=4, alpha=0.6,
        label="one clamping; log–log" + _stated(slopes, "time of `equilibria`"),
    )  # fmt: skip
    axes[3].set_xlabel("equilibria found, pose-drawn clampings")
    axes[3].set_ylabel("time of equilibria() / ms")
    axes[3].set_ylim(bottom=0.0)
    for axis in axes:
        axis.grid(color="0.92", lw=0.6)
        axis.set_axisbelow(True)
        axis.legend(fontsize=7)
    figure.suptitle(setting, fontsize=8)
    save_figure(figure, path)
