"""The report of the study of completeness, and its picture."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from loopelastica.studies.bench.machine import setting
from loopelastica.studies.bench.markdown import markdown_table
from loopelastica.studies.completeness.tables import coverage
from loopelastica.studies.figures import new_figure, save_figure

Row = dict[str, Any]

_COLORS = ("#1b6ca8", "#c8553d", "#588157", "#7b5ea7")
_RELIABILITY = {
    "effort": ("effort", ""),
    "poses": ("poses", "d"),
    "said_least": ("unseen, from", ".3f"),
    "said_most": ("to", ".3f"),
    "said": ("mean", ".4f"),
    "rods_missed": ("rods missed", ".4f"),
    "rods_missed_low": ("5 %", ".4f"),
    "rods_missed_high": ("95 %", ".4f"),
    "hits_missed": ("hits missed", ".4f"),
    "rods_missed_per_pose": ("mean of the poses", ".4f"),
}


def markdown(rows: Sequence[Row], bins: Sequence[Row], indices: Sequence[str], starts: int) -> str:
    """The report.

    Parameters
    ----------
    rows, bins : sequence of dict
        Lines of ``poses.csv`` and ``reliability.csv``.
    indices : sequence of str
        Columns of the Morse indices.
    starts : int
        Random loads per pose of the independent search.

    Returns
    -------
    str
    """
    columns = {
        "effort": ("effort", ""),
        "kind": ("poses", ""),
        "poses": ("number", "d"),
        "listed": ("listed", "d"),
        "listed_hit": ("of these hit", "d"),
        "rods": ("expected", "d"),
        "hits %": ("hits listed / %", ".2f"),
        "rods %": ("rods / %", ".2f"),
        **{f"{name} %": (f"{name} / %", ".2f") for name in indices},
        "seconds_median": ("s, median", ".3f"),
        "seconds_max": ("max", ".2f"),
    }
    poses = len({row["pose"] for row in rows})
    lost = len({row["pose"] for row in rows if not row["rods"]})
    parts = [
        "# Completeness of lists of equilibria", "", f"{setting()}; one core.", "",
        f"{poses} poses, each searched from {starts:,d} random loads by an integrator and a"
        " corrector of the study's own. A rod that was hit is expected where its energy is below"
        " the list's bound; hits count it as often as it was found. It is a sample: of the listed"
        f" rods it hit some only, and at {lost} of the poses none.",
        "", "## Listed", "", markdown_table(coverage(rows, indices), columns),
        "", "## Said and measured", "",
        "`unseen` beside the shares that were missing, in bins of at least 30 poses; the interval"
        " is that of other draws of poses.", "",
        markdown_table(bins, _RELIABILITY),
    ]  # fmt: skip
    return "\n".join(parts) + "\n"


def draw(rows: Sequence[Row], bins: Sequence[Row], indices: Sequence[str], path: Path) -> None:
    """Reliability diagram, and shares listed by Morse index.

    Parameters
    ----------
    rows, bins : sequence of dict
        Lines of ``poses.csv`` and ``reliability.csv``.
    indices : sequence of str
        Columns of the Morse indices.
    path : Path
        Of the PNG.
    """
    figure = new_figure(9.0, 3.8)
    left, right = figure.subplots(1, 2)
    efforts = list(dict.fromkeys(row["effort"] for row in rows))
    most = max((row[key] for row in bins for key in ("said", "rods_missed_high")), default=0.0)
    top = max(0.1, 1.1 * most)
    said = np.linspace(0.0, top, 3)
    left.plot(said, said, color="0.5", lw=1, label="as said")
    left.fill_between(
        said, 0.5 * said, 2.0 * said, color="0.9", lw=0, label="within a factor of two"
    )
    for color, effort in zip(_COLORS, efforts, strict=False):
        chosen = [row for row in bins if row["effort"] == effort]
        x, y = ([row[key] for row in chosen] for key in ("said", "rods_missed"))
        down = [row["rods_missed"] - row["rods_missed_low"] for row in chosen]
        up = [row["rods_missed_high"] - row["rods_missed"] for row in chosen]
        # draws of poses may all lie on one side of the share itself
        spread = np.maximum([down, up], 0.0)
        left.errorbar(x, y, spread, fmt="o", ms=4, color=color, capsize=2, label=f"{effort}, rods")
        left.plot(
            x, [row["hits_missed"] for row in chosen], "x", color=color, label=f"{effort}, hits"
        )
    left.set_xlim(0.0, top)
    left.set_ylim(0.0, top)
    left.set_xlabel("unseen, as the list says")
    left.set_ylabel("share that was missing")
    left.legend(fontsize=7, loc="upper left")
    table = {row["effort"]: row for row in coverage(rows, indices) if row["kind"] == "all"}
    width = 0.8 / len(efforts)
    for place, (color, effort) in enumerate(zip(_COLORS, efforts, strict=False)):
        names = ["hits", "rods", *indices]
        shares = [table[effort][f"{name} %"] for name in names]
        known = [i for i, share in enumerate(shares) if share is not None]
        at = [i + width * (place - 0.5 * (len(efforts) - 1)) for i in known]
        right.bar(at, [shares[i] for i in known], width, color=color, label=effort)
    right.set_xticks(range(len(names)), names, fontsize=8)
    right.set_ylim(0.0, 105.0)
    right.set_ylabel("listed / %")
    right.legend(fontsize=7, loc="lower left", framealpha=1.0)
    save_figure(figure, path)
