"""Figures 3, 4 and 5 of the paper with this package's values.

Layout of Ameline et al., J. Comput. Phys. 373 (2018) 736, DOI 10.1016/j.jcp.2018.07.021; what the
paper prints in words is drawn as a dashed line or an open mark.
"""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from loopelastica.studies.figures import new_figure, save_figure

Row = Mapping[str, Any]

_COLORS = {"eps1": "#1b6ca8", "eps2": "#c8553d", "eps3": "#588157"}
_NAMES = {"eps1": "ε1", "eps2": "ε2", "eps3": "ε3"}
# boundary of the four regions of Fig. 5 in η1; the other one is η3 = 0
_ETA1 = 0.4


def draw_steps(rows: Sequence[Row], path: Path) -> None:
    """Fig. 3: success, time and iterations for each step δ and error.

    Parameters
    ----------
    rows : sequence of mapping
        Lines of ``paper.csv`` of this figure.
    path : Path
        Of the PNG.
    """
    figure = new_figure(10.0, 3.4)
    axes = figure.subplots(1, 3)
    steps = sorted({row["delta"] for row in rows}, reverse=True)
    panels = (
        ("success_percent", "success at 1e-5 / %", False),
        ("time_ms", "time per inversion / ms", True),
        ("iterations", "iterations", True),
    )
    for axis, (key, label, logarithmic) in zip(axes, panels, strict=True):
        for shift, error in enumerate(_NAMES):
            chosen = {
                row["delta"]: row for row in rows if (row["error"], row["scan"]) == (error, "eps1")
            }
            at = [steps.index(delta) + 0.25 * (shift - 1) for delta in chosen]
            heights = [row[key] for row in chosen.values()]
            axis.bar(at, heights, 0.22, color=_COLORS[error], label=_NAMES[error])
            for x, row in zip(at, chosen.values(), strict=True):
                printed = row.get("paper_" + key)
                if printed is not None:
                    axis.plot(x, printed, "D", mfc="none", mec="black", ms=5)
        axis.set_xticks(range(len(steps)), [f"{delta:g}" for delta in steps])
        axis.set_xlabel("step δ of the grid")
        axis.set_ylabel(label)
        if logarithmic:
            axis.set_yscale("log")
    axes[0].set_ylim(80, 100.5)
    axes[0].axhline(99.9, color="black", lw=0.8, ls="--", label="paper, δ = 0.5")
    # beside the short bars there is room
    axes[1].legend(*axes[0].get_legend_handles_labels(), fontsize=7, loc="upper right")
    figure.suptitle("l = 2; diamonds: printed in the paper", fontsize=9)
    save_figure(figure, path)


def draw_sizes(rows: Sequence[Row], path: Path) -> None:
    """Fig. 4: time for each size l, with and without the symmetry; share of t_P = ±λ.

    Parameters
    ----------
    rows, path
        As for `draw_steps`.
    """
    figure = new_figure(5.4, 3.6)
    axis = figure.subplots()
    for symmetry, color, label in (
        (True, "#1b6ca8", "with symmetry (34)"),
        (False, "#c8553d", "without"),
    ):
        chosen = [row for row in rows if row["symmetry"] == symmetry]
        axis.plot(
            [row["l"] for row in chosen],
            [row["time_ms"] for row in chosen],
            "o-",
            color=color,
            label=label,
        )
    axis.set_xlabel("size l of the region of guesses")
    axis.set_ylabel("time per inversion / ms")
    axis.set_ylim(bottom=0)
    axis.legend(fontsize=7, loc="upper left")
    other = axis.twinx()
    shares = {row["l"]: row["singular_percent"] for row in rows}
    other.plot(list(shares), list(shares.values()), "s:", color="gray", ms=4)
    other.set_ylabel("rods with t_P = ±λ / %", color="gray")
    other.set_ylim(bottom=0)
    save_figure(figure, path)


def draw_targets(images: NDArray[np.float64], missed: NDArray[np.bool_], path: Path) -> None:
    """Fig. 5: the targets, those missed as crosses.

    Parameters
    ----------
    images : (n, 5) ndarray
        Clamping parameters η1, η3, ψ_R, θ_R, φ_R; angles in radians.
    missed : (n,) ndarray
        Which were tested and not reached.
    path : Path
        Of the PNG.
    """
    figure = new_figure(10.0, 4.4)
    grid = figure.add_gridspec(2, 4)
    eta1, eta3, psi, theta = images[:, 0], images[:, 1], images[:, 2], images[:, 3]
    region = 2 * (eta3 < 0) + (eta1 >= _ETA1)
    colors = np.array(["#1b6ca8", "#c8553d", "#588157", "#7b5ea7"])
    axis = figure.add_subplot(grid[:, :2])
    axis.scatter(eta1, eta3, s=0.5, c=colors[region], linewidths=0, rasterized=True)
    axis.plot(eta1[missed], eta3[missed], "kx", ms=4)
    axis.set_xlabel("η1")
    axis.set_ylabel("η3")
    axis.set_aspect("equal")
    for number in range(4):
        inside = region == number
        axis = figure.add_subplot(grid[number // 2, 2 + number % 2])
        axis.scatter(
            psi[inside], theta[inside], s=0.5, c=colors[number], linewidths=0, rasterized=True
        )
        axis.plot(psi[inside & missed], theta[inside & missed], "kx", ms=4)
        axis.set_xlim(0, math.tau)
        axis.set_ylim(0, math.pi)
        axis.set_xlabel("ψ")
        axis.set_ylabel("θ")
    figure.suptitle("targets for l = 2, δ = 0.5; crosses: tested and not reached", fontsize=9)
    save_figure(figure, path)
