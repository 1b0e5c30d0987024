"""Sections of the scoreboard: who is nearer, loop by loop, and whether expected errors held."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from loopelastica.studies.bench.markdown import markdown_table
from loopelastica.studies.coverage import coverage

Row = Mapping[str, Any]


NEARER = (
    "In how many of the loops that both have it is nearer than the first answer; its median against"
    " that of the first answer, Å."
)


def wins(groups: Mapping[str, Sequence[Row]], rivals: Mapping[str, str]) -> str:
    """How often something else is nearer than the first answer.

    Parameters
    ----------
    groups : mapping of str to sequence of mapping
        Loops by the name of their group.
    rivals : mapping of str to str
        Column and name of each.

    Returns
    -------
    str
        A markdown table: in how many of the loops that both have it is nearer, and both medians.
    """
    table = []
    for name, rows in groups.items():
        cells: dict[str, object] = {"loops": f"{name} ({len(rows)})"}
        for rival in rivals:
            both = [(row["rmsd_first_A"], row[rival]) for row in rows if row[rival] is not None]
            if both:
                first, other = np.array(both).T
                cells[rival] = (
                    f"{100.0 * np.mean(other < first):.0f} % of {len(both)}:"
                    f" {np.median(other):.2f} against {np.median(first):.2f}"
                )
        table.append(cells)
    columns = {"loops": "loops", **rivals}
    return markdown_table(table, {key: (heading, "") for key, heading in columns.items()})


def expected_errors(rows: Sequence[Row]) -> Iterator[str]:
    """The section on expected errors.

    Parameters
    ----------
    rows : sequence of mapping
        Of all loops.

    Yields
    ------
    str
        Lines of markdown.
    """
    yield (
        "Of the first answer, each distinct sequence counted once: how often its RMSD lies within"
        " the 80 % interval, and below its 10 %, 50 % and 90 %; the median of 90 % over 10 %; the"
        " median RMSD (Å) in each quarter of the expected medians, the most certain first."
    )
    for title, of in (("All loops", rows), ("Simple loops", [r for r in rows if r["simple"]])):
        if of:
            yield from ("", f"### {title}", "", _table(of))


def _table(rows: Sequence[Row]) -> str:
    groups: dict[str, list[Row]] = {"all": list(rows)}
    for key, label in (("kind", "{}"), ("nucleotides", "{} nucleotides"), ("shape_source", "{}")):
        for value in sorted({row[key] for row in rows}):
            groups[label.format(value)] = [row for row in rows if row[key] == value]
    table = []
    for name, of in groups.items():
        error = np.array([row["rmsd_first_A"] for row in of])
        expected = np.array([[row[f"expected_{q}_A"] for q in (10, 50, 90)] for row in of])
        one = coverage(error, expected, _weights(of))
        shares = {k: 100.0 * v for k, v in one._asdict().items() if k.startswith(("in", "below"))}
        quarters = ", ".join(f"{median:.1f}" for median in one.quarters_A) or None
        count = f"{name} ({len(of)})"
        table.append({"loops": count, **one._asdict(), **shares, "quarters_A": quarters})
    columns = {
        "loops": ("loops", ""), "cases": ("sequences", ".0f"), "inside": ("within", ".0f"),
        "below_10": ("below 10 %", ".0f"), "below_50": ("below 50 %", ".0f"),
        "below_90": ("below 90 %", ".0f"), "ratio": ("90 % / 10 %", ".1f"),
        "quarters_A": ("RMSD by quarter", ""),
    }  # fmt: skip
    return markdown_table(table, columns)


def _weights(rows: Sequence[Row]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """One over the loops of the same sequence and kind, closing pair left out."""
    loops = [(row["kind"], row["sequence"][1:-1].upper().replace("T", "U")) for row in rows]
    return np.array([1.0 / loops.count(loop) for loop in loops])
