"""Error against run time, forward and inverse, in one picture."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from loopelastica.studies.figures import new_figure, save_figure

Row = dict[str, Any]

# beginning of a method's name: colour, marker, and whether its settings are joined by a line
_STYLES = {
    "closed form q1": ("#e09f3e", "*", False),
    "own integrator": ("#1b6ca8", "o", True),
    "Bulirsch–Stoer": ("#c8553d", "^", True),
    "SciPy DOP853": ("#588157", "D", True),
    "ours, batch": ("#1b6ca8", "*", False),
    "ours, solve, first": ("#1b6ca8", "o", False),
    "ours, batch, lowest": ("#5fa8d3", "*", False),
    "ours, solve, lowest": ("#5fa8d3", "o", False),
    "ours, first, tolerance": ("#1b6ca8", ".", True),
    "paper, ε1": ("#c8553d", "^", False),
    "paper, ε2": ("#c8553d", "v", False),
    "paper, ε3": ("#c8553d", ">", False),
    "solve_bvp, tol": ("#588157", "D", True),
    "solve_bvp, 20 guesses": ("#a3b18a", "s", False),
    "least_squares": ("#7b5ea7", "X", False),
    "least_squares, 20 guesses": ("#b8a1d9", "P", False),
}
# where the success of a method is written, in points off its marker, if not above to the right
_OFFSETS = {
    "paper, ε1": (3, -8),
    "paper, ε3": (-20, 3),
    "solve_bvp, 20 guesses": (3, -8),
    "least_squares": (-20, -8),
}
# where methods stand that reached nothing
_NOTHING = 1.0


def _kind(name: str) -> str:
    """The longest beginning that has a style."""
    return max((kind for kind in _STYLES if name.startswith(kind)), key=len)


def _groups(rows: Sequence[Row]) -> dict[str, list[Row]]:
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(_kind(row["method"]), []).append(row)
    return groups


def _draw_forward(axis: Any, rows: Sequence[Row]) -> None:
    for kind, group in _groups(rows).items():
        color, marker, joined = _STYLES[kind]
        x = [1e-3 * row["time_median_us"] for row in group]
        y = [row["error_median"] for row in group]
        size = 12 if marker == "*" else 5
        axis.plot(x, y, marker, ls="-" if joined else "", color=color, ms=size, lw=1, label=kind)
        axis.vlines(x, y, [row["error_max"] for row in group], color=color, lw=0.8, alpha=0.6)
    axis.set_title("forward: load-drawn rods, error against 50 digits", fontsize=9)
    axis.legend(fontsize=7, loc="upper right")


def _draw_inverse(axis: Any, rows: Sequence[Row], title: str) -> None:
    axis.axhspan(0.2, 5.0, color="0.93", lw=0)
    axis.text(0.01, 0.98, "no answer", transform=axis.transAxes, fontsize=7, va="top")
    for kind, group in _groups(rows).items():
        color, marker, joined = _STYLES[kind]
        x, y = [], []
        for row in group:
            x.append(row["time_median_ms"] or row["time_mean_ms"])
            y.append(row["error_median"] or _NOTHING)
            if row["error_max"] is not None:
                axis.vlines(x[-1], y[-1], row["error_max"], color=color, lw=0.8, alpha=0.6)
            if row["time_p99_ms"] is not None:
                axis.hlines(y[-1], x[-1], row["time_p99_ms"], color=color, lw=0.8, alpha=0.6)
            success = row["success_1e-5_percent"]
            if row["error_median"] is not None and success < 99.95:
                axis.annotate(
                    f"{success:.0f} %", (x[-1], y[-1]), _OFFSETS.get(kind, (3, 3)),
                    textcoords="offset points", fontsize=6, color=color,
                )  # fmt: skip
        size = {"*": 12, ".": 4}.get(marker, 5)
        axis.plot(x, y, marker, color=color, ms=size, label=kind)
        if joined:
            axis.plot(
                [at for at, error in zip(x, y, strict=True) if error < _NOTHING],
                [error for error in y if error < _NOTHING],
                ":", color=color, lw=1,
            )  # fmt: skip
    for level in (1e-5, 1e-9):
        axis.axhline(level, color="0.6", lw=0.7, ls="--", zorder=0)
    axis.set_ylim(1e-13, 5.0)
    axis.set_title(f"inverse: {title}, {rows[0]['sample']} targets", fontsize=9)


def draw(forward: Sequence[Row], inverse: dict[str, list[Row]], path: Path, setting: str) -> None:
    """Four panels: the way from loads to the end, and the three sets of targets.

    Parameters
    ----------
    forward : sequence of dict
        Lines of ``forward.csv``.
    inverse : dict
        Lines of ``inverse.csv`` for each set of targets.
    path : Path
        Of the PNG.
    setting : str
        Machine and date, for the title.
    """
    figure = new_figure(11.0, 8.6)
    axes = figure.subplots(2, 2).ravel()
    _draw_forward(axes[0], [row for row in forward if row["time_median_us"] is not None])
    for axis, (title, rows) in zip(axes[1:], inverse.items(), strict=True):
        _draw_inverse(axis, [row for row in rows if row["ratio"] is not None], title)
    for axis in axes:
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.set_xlabel("processor time per rod / ms")
        axis.set_ylabel("error")
        axis.grid(color="0.92", lw=0.6)
        axis.set_axisbelow(True)
    figure.legend(
        *axes[1].get_legend_handles_labels(), fontsize=7, ncols=6, loc="outside lower center"
    )
    figure.suptitle(
        "median over targets; bars to the largest error and to the 99th percentile of time;"
        " success at 1e-5 where it is not 100 %\n" + setting,
        fontsize=8,
    )
    save_figure(figure, path)
