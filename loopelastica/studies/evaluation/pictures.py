"""Pictures of the scoreboard; matplotlib is loaded when the first one is drawn."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from loopelastica.studies.figures import new_figure, save_figure

_SHOWN = {
    "rmsd_first_A": "first answer",
    "rod_A": "rod, rule",
    "plain_rod_A": "rod at the closing pair",
    "hermite_A": "cubic Hermite",
    "arc_A": "circular arc",
    "chord_A": "straight chord",
    "mean_loop_A": "mean loop",
}

_LEAST_A = 0.1
_TICKS_A = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0)


def draw(rows: list[dict[str, Any]], out: Path) -> None:
    """Write the pictures of the scoreboard.

    ``rmsd_by_length.png``, ``energy_and_rmsd.png``, ``rank_of_best.png`` and
    ``expected_and_true_error.png``.

    Parameters
    ----------
    rows : list of dict
        Of all loops; simple ones are drawn, and all where errors were expected.
    out : Path
        Folder.
    """
    simple = [row for row in rows if row["simple"]]
    _picture(out / "rmsd_by_length.png", lambda axes: _by_length(axes, simple))
    _picture(out / "energy_and_rmsd.png", lambda axes: _energy(axes, simple))
    _picture(out / "rank_of_best.png", lambda axes: _rank(axes, simple))
    _picture(out / "expected_and_true_error.png", lambda axes: _expected(axes, rows))


def _picture(path: Path, fill: Callable[[Any], None]) -> None:
    figure = new_figure(7.5, 4.5)
    fill(figure.add_subplot())
    save_figure(figure, path, dpi=110)


def _by_length(axes: Any, rows: list[dict[str, Any]]) -> None:
    lengths = sorted({row["nucleotides"] for row in rows})
    width = 0.8 / len(_SHOWN)
    for k, (name, label) in enumerate(_SHOWN.items()):
        places, medians = [], []
        for n in lengths:
            values = [r[name] for r in rows if r["nucleotides"] == n and r[name] is not None]
            x = n + (k - 0.5 * (len(_SHOWN) - 1)) * width
            axes.plot([x] * len(values), values, ".", color=f"C{k}", ms=3, alpha=0.5)
            if values:
                places.append(x)
                medians.append(float(np.median(values)))
        axes.bar(places, medians, width, color=f"C{k}", alpha=0.45, label=label)
    axes.set_xticks(lengths)
    axes.set_xlabel("loop nucleotides")
    axes.set_ylabel("RMSD (Å): loops and their median")
    axes.legend(fontsize=8)


def _energy(axes: Any, rows: list[dict[str, Any]]) -> None:
    for k, name in enumerate(sorted({row["set"] for row in rows})):
        points = [(r["energy_per_A"], r["rmsd_first_A"]) for r in rows if r["set"] == name]
        axes.plot(*np.transpose(points), "o", color=f"C{k}", ms=4, label=name)
    axes.set_xlabel("E/K0 of the first answer (1/Å)")
    axes.set_ylabel("RMSD (Å)")
    axes.set_ylim(bottom=0)
    axes.set_title("Energy is no confidence", fontsize=10)
    if rows:
        axes.legend(fontsize=8)


def _rank(axes: Any, rows: list[dict[str, Any]]) -> None:
    ranks = np.array([row["rank_of_best"] for row in rows], dtype=int)
    counts = np.bincount(ranks)[1:] if len(ranks) else np.zeros(0)
    axes.bar(np.arange(1, len(counts) + 1), counts, color="C0")
    axes.set_xticks(np.arange(1, len(counts) + 1))
    axes.set_xlabel("rank of the candidate nearest to the file's loop")
    axes.set_ylabel("loops")


def _expected(axes: Any, rows: list[dict[str, Any]]) -> None:
    """Points within their bars held what was expected."""
    low, middle, high, error = (
        # on these axes there is no zero
        np.maximum([row[name] for row in rows], _LEAST_A)
        for name in ("expected_10_A", "expected_50_A", "expected_90_A", "rmsd_first_A")
    )
    axes.vlines(middle, low, high, color="0.8", lw=1.0, zorder=1, label="80 % interval")
    inside = np.array([row["inside"] for row in rows], dtype=bool)
    for of, color, label in ((inside, "C0", "inside"), (~inside, "C3", "outside")):
        label = f"{label}: {of.sum()}"
        axes.plot(middle[of], error[of], ".", color=color, ms=4, alpha=0.7, label=label)
    limits = min(middle.min(), error.min(), low.min()), max(error.max(), high.max())
    axes.plot(limits, limits, color="0.3", lw=0.8, zorder=1)
    axes.set_xscale("log")
    axes.set_yscale("log")
    from matplotlib.ticker import FixedLocator, NullLocator

    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(FixedLocator(_TICKS_A))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_locator(NullLocator())
    axes.set_xlim(0.9 * middle.min(), 1.1 * middle.max())
    axes.set_xlabel("expected error of the first answer, median (Å)")
    axes.set_ylabel("RMSD (Å)")
    axes.legend(fontsize=8)
