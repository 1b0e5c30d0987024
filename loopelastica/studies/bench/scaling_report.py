"""What is said about measured growth: slopes, and the report in markdown."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from loopelastica.studies.bench.machine import setting
from loopelastica.studies.bench.markdown import markdown_table

Row = dict[str, Any]

# from here on the time of one call no longer counts
_MANY = 1000
# rods drawn and solved at once; bound of |η| of the clampings whose equilibria are listed
CHUNK, NEAR = 8192, 0.95


def slope(x: Sequence[float], y: Sequence[float]) -> float | None:
    """Slope of log y over log x by least squares.

    Parameters
    ----------
    x, y : sequence of float
        Positive.

    Returns
    -------
    float or None
        None for fewer than two different x.
    """
    if len(set(x)) < 2:
        return None
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def named(threads: int) -> str:
    """The number of threads in words."""
    return f"{threads} thread{'s' * (threads > 1)}"


def slopes(rods: Sequence[Row], lengths: Sequence[Row], found: Sequence[Row]) -> list[Row]:
    """The slope of each measured curve.

    Parameters
    ----------
    rods, lengths, found : sequence of dict
        Lines of ``rods.csv``, ``lengths.csv`` and ``equilibria.csv``.

    Returns
    -------
    list of dict
        The lines of ``slopes.csv``.
    """
    rows: list[Row] = []

    def add(what: str, x: Sequence[float], y: Sequence[float]) -> None:
        rows.append({"what": what, "points": len(x), "slope": slope(x, y)})

    for threads in sorted({row["threads"] for row in rods}):
        chosen = [row for row in rods if row["threads"] == threads]
        many = [row for row in chosen if row["rods"] >= _MANY]
        for what, part in (("all", chosen), (f"{_MANY:,d} and more", many)):
            x = [row["rods"] for row in part]
            for key, name in (("seconds", "time"), ("processor_s", "processor time")):
                label = f"{name} over number of rods, {what}, {named(threads)}"
                add(label, x, [row[key] for row in part])
        add(
            f"memory over number of rods, {named(threads)}",
            [row["rods"] for row in chosen], [row["memory_MB"] for row in chosen],
        )  # fmt: skip
    x = [row["length"] for row in lengths]
    add("median time of an inversion over L/μ", x, [row["time_median_ms"] for row in lengths])
    add("time of the closed form over L/μ", x, [row["closed_form_us"] for row in lengths])
    add("time of the integrator over L/μ", x, [row["integrator_us"] for row in lengths])
    some = [row for row in found if row["equilibria"]]
    add(
        "time of `equilibria` over their number",
        [row["equilibria"] for row in some], [row["time_ms"] for row in some],
    )  # fmt: skip
    return rows


def _speedups(rods: Sequence[Row]) -> list[str]:
    single = {row["rods"]: row["seconds"] for row in rods if row["threads"] == 1}
    several = [row for row in rods if row["threads"] > 1 and row["rods"] >= _MANY]
    return [
        f"- {named(row['threads'])}, {row['rods']:,d} rods:"
        f" {single[row['rods']] / row['seconds']:.2f} × one"
        for row in several
    ]


_ROD_COLUMNS = {
    "rods": ("rods", ",d"),
    "threads": ("threads", "d"),
    "seconds": ("s", ".4g"),
    "processor_s": ("processor / s", ".4g"),
    "per_rod_us": ("µs per rod", ".4g"),
    "solved": ("solved", ",d"),
    "residual_max": ("residual, max", ".1e"),
    "memory_MB": ("peak memory / MB", ".0f"),
}
_LENGTH_COLUMNS = {
    "length": ("L/μ", ".3g"),
    "sample": ("sample", ",d"),
    "solved": ("solved", ",d"),
    "time_median_ms": ("ms, median", ".3f"),
    "time_mean_ms": ("mean", ".3f"),
    "time_p99_ms": ("p99", ".3f"),
    "closed_form_us": ("closed form / µs", ".2f"),
    "integrator_us": ("integrator / µs", ".2f"),
}
_FOUND_COLUMNS = {
    "equilibria": ("equilibria", "d"),
    "clampings": ("clampings", "d"),
    "time_median_ms": ("ms, median", ".1f"),
    "time_max_ms": ("max", ".1f"),
}
_SLOPE_COLUMNS = {"what": ("what", ""), "points": ("points", "d"), "slope": ("slope", ".3f")}


def _by_count(found: Sequence[Row]) -> list[Row]:
    rows = []
    for count in sorted({row["equilibria"] for row in found}):
        times = [row["time_ms"] for row in found if row["equilibria"] == count]
        rows.append({
            "equilibria": count, "clampings": len(times),
            "time_median_ms": float(np.median(times)), "time_max_ms": max(times),
        })  # fmt: skip
    return rows


def markdown(
    rods: Sequence[Row], lengths: Sequence[Row], found: Sequence[Row], stated: Sequence[Row]
) -> str:
    """The report.

    Parameters
    ----------
    rods, lengths, found, stated : sequence of dict
        Lines of ``rods.csv``, ``lengths.csv``, ``equilibria.csv`` and ``slopes.csv``.

    Returns
    -------
    str
    """
    times = [row["time_ms"] for row in found]
    parts = [
        "# Scaling", "", f"{setting()}; wall time where nothing else is said.",
        "", "## Slopes", "", markdown_table(stated, _SLOPE_COLUMNS),
        "", "## Number of rods", "",
        f"Load-drawn, the first equilibrium, drawn and solved in chunks of {CHUNK:,d}.", "",
        markdown_table(rods, _ROD_COLUMNS), "", *_speedups(rods),
        "", "## Arc length", "",
        "Ends of random rods with L/μ within a factor √2, one by one; the end alone by the closed"
        " form and by the integrator at 4 steps per radian.", "",
        markdown_table(lengths, _LENGTH_COLUMNS),
        "", "## Number of equilibria", "",
        f"Pose-drawn, |η| < {NEAR}; median of all {np.median(times):.0f} ms.", "",
        markdown_table(_by_count(found), _FOUND_COLUMNS),
    ]  # fmt: skip
    return "\n".join(parts) + "\n"
