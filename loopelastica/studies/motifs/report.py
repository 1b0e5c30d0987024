"""The tables of the study in markdown."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from loopelastica._arrays import Array
from loopelastica.folding.known import FIRST
from loopelastica.studies.bench.markdown import markdown_table
from loopelastica.studies.coverage import coverage
from loopelastica.studies.motifs.judge import ENTRY, LEVELS, RELATIVES, per_sequence
from loopelastica.studies.motifs.tables import (
    by_kind,
    held_out,
    sequence_weights,
)

Row = Mapping[str, Any]
_CLASSES: dict[str, Callable[[Row], bool]] = {
    "3": lambda row: row["n"] == 3,
    "GNRA": lambda row: row["motif"] == "GNRA",
    "UNCG": lambda row: row["motif"] == "UNCG",
    "other 4": lambda row: row["n"] == 4 and not row["motif"],
    "5": lambda row: row["n"] == 5,
    "6": lambda row: row["n"] == 6,
    "7": lambda row: row["n"] == 7,
    "8-9": lambda row: 8 <= row["n"] <= 9,
    "10-12": lambda row: row["n"] >= 10,
}
_MEASURES: dict[str, Callable[[Sequence[Row]], float]] = {
    "first answer": lambda rows: rows[0]["rmsd_A"],
    f"best of the first {FIRST}": lambda rows: min(row["rmsd_A"] for row in rows[:FIRST]),
    "straight rod by the rule": lambda rows: next(
        (row["rmsd_A"] for row in rows if row["kind"] == "rod"), np.nan
    ),
    "shape of least energy": lambda rows: rows[0]["least_energy_A"],
    "the best there is": lambda rows: rows[0]["oracle_A"],
}


_TRIALS = {
    "name": ("pattern", ""),
    "pattern": ("loop", ""),
    "loops": ("loops", ""),
    "sequences": ("sequences", ""),
    "families": ("families", ""),
    "judged": ("judged", ""),
    "own_median_A": ("its mean: median (Å)", ".2f"),
    "own_mean_A": ("mean (Å)", ".2f"),
    "all_median_A": ("all: median (Å)", ".2f"),
    "all_mean_A": ("mean (Å) ", ".2f"),
}


def report(
    rows: Sequence[Row],
    motifs: Sequence[Row],
    lengths: Sequence[Row],
    trials: Sequence[Row],
    habits: Sequence[Row],
) -> str:
    """The tables of the study.

    Parameters
    ----------
    rows : sequence of mapping
        Of all levels (:func:`loopelastica.studies.motifs.judge.rows_of`); expected errors are put
        into them.
    motifs, lengths : sequence of mapping
        As in ``motifs.json``.
    trials : sequence of mapping
        Of :func:`loopelastica.studies.motifs.trials.trial_rows`.

    habits : sequence of mapping
        Of :func:`loopelastica.studies.motifs.habits.habit_rows`.

    Returns
    -------
    str
        Markdown.
    """
    lines = [
        "# Loop shapes: how good answers are",
        "",
        "RMSD of the loop's backbone centroids, no superposition, Å: median / 90 % over distinct"
        " loop sequences (mean over the loops of one first; in brackets how many). *strict*:"
        " nothing of the loop's family was known, for GNRA and UNCG nothing of the motif;"
        " *relatives out*: other sequences of these motifs were; *entry out*: all other entries"
        " were, as for a user's loop.",
    ]
    for acid in sorted({row["acid"] for row in rows}, reverse=True):
        lines += ["", f"## {acid}, 3 to 9 nucleotides", ""]
        lines.append(_answers([row for row in rows if row["acid"] == acid]))
    lines += ["", "## Motifs, and one shape per length", "", _shapes([*motifs, *lengths])]
    lines += ["", "## C2'-endo and syn of families left out of the fit", "", _habits(habits)]
    lines += [
        "",
        "Patterns that were tried: mean over loops that have it against mean over all of the"
        " length, nothing of the same family (of GNRA and UNCG other sequences):",
        "",
        markdown_table(list(trials), _TRIALS),
    ]
    lines += ["", "## Expected errors", "", _coverage(rows), ""]
    return "\n".join(lines)


def _answers(rows: Sequence[Row]) -> str:
    table = []
    for level in LEVELS:
        by_loop: dict[str, list[Row]] = {}
        for row in rows:
            # those of no place are the same answers, judged as if there were no library
            if row["level"] == level and row["place"]:
                by_loop.setdefault(row["source"], []).append(row)
        loops = [sorted(of, key=lambda row: row["place"]) for of in by_loop.values()]
        if not loops:
            continue
        for name, measure in _MEASURES.items():
            values = np.array([measure(of) for of in loops])
            there = np.isfinite(values)
            firsts = [of[0] for of, is_there in zip(loops, there, strict=True) if is_there]
            each, mean = per_sequence(firsts, values[there])
            short = np.array([row["n"] <= 9 for row in each])
            cells = [_quantiles(mean[short])]
            for is_of in _CLASSES.values():
                of = np.array([is_of(row) for row in each])
                cells.append(_median(mean[of]))
            table.append((level, name, *cells))
    return _table(("known", "answer", "all 3–9", *_CLASSES), table)


def _quantiles(values: Array) -> str:
    if not len(values):
        return ""
    median, most = np.quantile(values, [0.5, 0.9])
    return f"{median:.2f} / {most:.2f} ({len(values)})"


def _median(values: Array) -> str:
    return f"{np.median(values):.2f} ({len(values)})" if len(values) else ""


def _shapes(rows: Sequence[Row]) -> str:
    return _table(
        ("shape", "acid", "pattern", "loops", "sequences", "families", "median / 90 % (Å)"),
        [
            (
                row["name"], row["kind"], row["pattern"], row["loops"], row["sequences"],
                row["families"], "{} / {}".format(*row["rmsd_A"]),
            )
            for row in rows
        ],
    )  # fmt: skip


def _habits(rows: Sequence[Row]) -> str:
    return _table(
        ["", "nucleotides", "share", "loss by the share", "by the terms", "ordered rightly"],
        [
            [row["habit"], row["nucleotides"], f"{row['share']:.2f}", f"{row['loss_flat']:.4f}",
             f"{row['loss']:.4f}", f"{row['ordered']:.2f}"]
            for row in rows
        ],
    )  # fmt: skip


def _coverage(rows: Sequence[Row]) -> str:
    """Coverage by kind of answer; what is expected goes into the rows."""
    table = []
    wanted = [
        row
        for row in rows
        if row["level"] == (ENTRY if row["kind"] == "same sequence" else RELATIVES)
    ]
    for kind, of in by_kind(wanted).items():
        if len({row["loop"] for row in of}) < 5:
            continue
        expected = held_out(of)
        names = ("expected_10_A", "expected_50_A", "expected_90_A")
        for row, values in zip(of, expected.tolist(), strict=True):
            row.update(zip(names, values, strict=True))  # type: ignore[attr-defined]
        table.append((kind, *_covered(of)))
    firsts = [
        row
        for row in wanted
        if row["place"] == 1 and row["level"] == RELATIVES and "expected_50_A" in row
    ]
    if firsts:
        table.append((f"first answers, {RELATIVES}", *_covered(firsts)))
    head = ("answers", "sequences", "within 80 %", "below median", "90 % / 10 %", "by quarter (Å)")
    return _table((*head, *_CLASSES), table)


def _covered(rows: Sequence[Row]) -> tuple[str, ...]:
    error = np.array([row["rmsd_A"] for row in rows])
    expected = np.array([[row[f"expected_{q}_A"] for q in (10, 50, 90)] for row in rows])
    weights = sequence_weights(rows)
    all_of_it = coverage(error, expected, weights)
    cells = []
    for is_of in _CLASSES.values():
        of = np.array([is_of(row) for row in rows])
        one = coverage(error[of], expected[of], weights[of]) if of.any() else None
        cells.append("" if one is None else f"{100.0 * one.inside:.0f} % ({one.cases:.0f})")
    return (
        f"{all_of_it.cases:.0f}",
        f"{100.0 * all_of_it.inside:.0f} %",
        f"{100.0 * all_of_it.below_50:.0f} %",
        f"{all_of_it.ratio:.1f}",
        ", ".join(f"{median:.1f}" for median in all_of_it.quarters_A),
        *cells,
    )


def _table(head: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    return markdown_table(
        [dict(zip(head, row, strict=True)) for row in rows], {name: (name, "") for name in head}
    )
