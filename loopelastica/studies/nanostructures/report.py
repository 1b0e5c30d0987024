"""What is said about starts of nanostructures: a page in markdown, and a picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from loopelastica.studies.bench.machine import setting
from loopelastica.studies.bench.markdown import markdown_table
from loopelastica.studies.figures import new_figure, save_figure

Row = dict[str, Any]

_NOTE = (
    "Lengths and energies are in oxDNA's units (0.8518 nm; 10 kT at 300 K). What is counted belongs"
    " to the laid strands, with the bonds to their helices. A bond is out of the window of the"
    " model below 0.5064 and above 1.0064; a conflict is two nucleotides whose excluded volume is"
    " 5 kT and more. A strand can start if it has no such bond, no centre nearer than 0.4 to one"
    " that is no neighbour's, and no conflict. Times are processor time, warm; of rods also that of"
    " `le.nanostructure` from the file on. Small designs take longer per strand than large ones."
)
_WAYS_NOTE = (
    "On the same strands, without those that were refused. Chords and arcs are between the same"
    " backbone sites as the rods; arcs have bonds of unstretched length, lie in the plane in which"
    " the strands leave their helices, and are not clamped. scadnano's exporter has its own"
    " helices; strands of designs on which it raised an error count as strands that cannot start."
    " The backbone's energy is that of bonds within the window. Times of the exporter are those of"
    " whole designs."
)
_RODS = {
    "family": ("designs", ""),
    "designs": ("number", ",d"),
    "strands": ("strands laid", ",d"),
    "refused": ("refused", ",d"),
    "bonds": ("bonds", ",d"),
    "broken": ("out of the window", ",d"),
    "nearest": ("nearest centres", ".3f"),
    "skew": ("axes off by", ".0e"),
    "conflicts": ("conflicts", ",d"),
    "ms_per_strand": ("s per 1,000: lay", ".2f"),
    "whole_ms_per_strand": ("s per 1,000: all", ".2f"),
}
_WAYS = {
    "family": ("designs", ""),
    "way": ("single strands as", ""),
    "failed": ("strands not exported", ",d"),
    "ready_share": ("can start", ".1%"),
    "broken": ("bonds out of the window", ",d"),
    "close": ("centres under 0.4", ",d"),
    "conflicts": ("conflicts", ",d"),
    "backbone_per_bond": ("backbone energy per bond", ".4f"),
    "volume_per_nucleotide": ("excluded volume per nucleotide", ".4g"),
    "largest": ("largest energy", ".3g"),
    "ms_per_strand": ("ms per strand", ".3f"),
}
_TRIPS = {
    "form": ("topology", ""),
    "designs": ("designs", ",d"),
    "paired": ("paired nucleotides", ",d"),
    "lost": ("with another partner or none", ",d"),
    "changed": ("lines changed", ",d"),
    "broken": ("bonds out of the window", ",d"),
    "close": ("centres under 0.4", ",d"),
}
_DYNAMICS = {
    "family": ("designs", ""),
    "way": ("single strands as", ""),
    "nucleotides": ("nucleotides", ",d"),
    "steps": ("steps", ",d"),
    "hottest_K": ("hottest / K", ".0f"),
    "energy_begin": ("energy per nucleotide, begin", ".3g"),
    "energy_end": ("end", ".3g"),
    "outcome": ("outcome", ""),
}
_STYLES = (("#1b6ca8", "*"), ("#c8553d", "^"), ("#588157", "s"), ("#7b5ea7", "X"))


def markdown(
    rows: Sequence[Row], trips: Sequence[Row], moved: Sequence[Row], load: float | None
) -> str:
    """The page.

    Parameters
    ----------
    rows, trips, moved : sequence of dict
        Lines of ``nanostructures.csv``, ``round_trips.csv`` and ``dynamics.csv``.
    load : float or None
        Average load of the machine when the study began.

    Returns
    -------
    str
    """
    busy = "" if load is None else f"; load of the machine before: {load:.1f}"
    ours = [row for row in rows if row["whole_ms_per_strand"] is not None]
    parts = [
        "# Starts of nanostructures", "", f"{setting()}{busy}.", "", _NOTE,
        "", "## Rods", "", markdown_table(ours, _RODS),
        "", "## Beside other lines", "", _WAYS_NOTE, "", markdown_table(rows, _WAYS),
        "", "## Through files of oxDNA", "",
        "Written, read, laid anew and written again.", "",
        markdown_table(_by_form(trips), _TRIPS),
    ]  # fmt: skip
    if moved:
        parts += [
            "", "## Dynamics", "",
            "In LAMMPS (package CG-DNA), 300 K, from rest, small designs of each family. LAMMPS"
            " bears bonds beyond the window with which oxDNA does not begin.", "",
            markdown_table(moved, _DYNAMICS),
        ]  # fmt: skip
    return "\n".join(parts) + "\n"


def _by_form(trips: Sequence[Row]) -> list[Row]:
    """Sums over designs, a row per form of the topology."""
    rows = []
    for form in dict.fromkeys(trip["form"] for trip in trips):
        own = [trip for trip in trips if trip["form"] == form]
        counts = ("paired", "lost", "changed", "broken", "close")
        sums = {key: sum(trip[key] for trip in own) for key in counts}
        rows.append({"form": form, "designs": len(own), **sums})
    return rows


def draw(rows: Sequence[Row], path: Path) -> None:
    """Share of strands that cannot start over run time, a point per family and way.

    Parameters
    ----------
    rows : sequence of dict
        Lines of ``nanostructures.csv``.
    path : Path
        Of the PNG.
    """
    figure = new_figure(6.4, 4.0)
    axis = figure.subplots()
    ways = dict.fromkeys(row["way"] for row in rows)
    for way, (color, marker) in zip(ways, _STYLES, strict=True):
        own = [row for row in rows if row["way"] == way and row["ms_per_strand"]]
        axis.semilogx(
            [row["ms_per_strand"] for row in own],
            [100 * (1 - row["ready_share"]) for row in own],
            marker, color=color, ms=9 if marker == "*" else 6, alpha=0.8, label=way,
        )  # fmt: skip
    axis.set_xlabel("processor time / ms per strand")
    axis.set_ylabel("strands that cannot start / %")
    axis.set_ylim(-3, 103)
    axis.grid(color="0.92", lw=0.6)
    axis.set_axisbelow(True)
    axis.legend(fontsize=8)
    save_figure(figure, path)
