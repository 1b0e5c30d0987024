"""Pictures of the scoreboard; matplotlib is loaded when the first one is drawn."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from loopelastica.studies.figures import new_figure, save_figure

_SHOWN = {
    "rmsd_first_A": "rod, rule",
    "plain_rod_A": "rod at the closing pair",
    "hermite_A": "cubic Hermite",
    "arc_A": "circular arc",
    "chord_A": "straight chord",
    "mean_loop_A": "mean loop",
}


def draw(rows: list[dict[str, Any]], out: Path) -> None:
    """Write ``rmsd_by_length.png``, ``energy_and_rmsd.png`` and ``rank_of_best.png``.

    Parameters
    ----------
    rows : list of dict
        Of all loops; simple ones are drawn.
    out : Path
        Folder.
    """
    simple = [row for row in rows if row["simple"]]
    _picture(out / "rmsd_by_length.png", lambda axes: _by_length(axes, simple))
    _picture(out / "energy_and_rmsd.png", lambda axes: _energy(axes, simple))
    _picture(out / "rank_of_best.png", lambda axes: _rank(axes, simple))


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
    axes.set_xlabel("E/K0 of the first-ranked rod (1/Å)")
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
