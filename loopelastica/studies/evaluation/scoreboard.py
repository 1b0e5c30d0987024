"""From the rows of all loops to the scoreboard: CSV, markdown and pictures."""

import re
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from loopelastica._files import data_path, write_csv, write_text
from loopelastica._names import printable
from loopelastica.batch.run import Run, run
from loopelastica.batch.tasks import tasks_of
from loopelastica.folding.options import FoldOptions
from loopelastica.molecule.folders import distinct, structure_files
from loopelastica.molecule.nucleotides import Limits
from loopelastica.molecule.trace import rmsd_A
from loopelastica.studies.evaluation.expected import NEARER, expected_errors, wins
from loopelastica.studies.evaluation.loops import COLUMNS, EVALUATION, HONEST
from loopelastica.studies.evaluation.refit import interval, refitted_A

METHODS = {
    "rmsd_first_A": "first answer",
    "rmsd_best5_A": "best of five",
    "rmsd_best_A": "best of all",
    "models_first_A": "first answer, mean over models",
    "rod_A": "rod, rule",
    "surrounded_A": "rod in its surroundings",
    "refit_taper_A": "rod, taper refitted without the family",
    "refit_all_A": "rod, all refitted without the family",
    "plain_rod_A": "rod at the closing pair",
    "hermite_A": "cubic Hermite, same ends",
    "arc_A": "circular arc, same ends",
    "chord_A": "straight chord, same ends",
    "plain_hermite_A": "cubic Hermite at the closing pair",
    "plain_arc_A": "circular arc at the closing pair",
    "plain_chord_A": "straight chord at the closing pair",
    "mean_loop_A": "mean loop of other families",
}
SIMPLER = ("rod_A", "hermite_A", "mean_loop_A", "surrounded_A")
"""Those that are counted loop by loop."""
RIVALS = tuple(name for name in METHODS if not name.startswith(("rmsd_", "models_", "refit_")))
_COLUMNS = (*COLUMNS, "mean_loop_A", "refit_taper_A", "refit_all_A")


def evaluate(
    folder: Path,
    out: Path,
    jobs: int = 1,
    scheduler: str | None = None,
    progress: bool = False,
    limits: Limits | None = None,
) -> Run:
    """Measure every loop of every structure of a folder; write the scoreboard.

    Writes ``loops.csv`` as results come, then ``scoreboard.csv`` (a row per loop),
    ``scoreboard.md`` and four pictures. Of each loop nothing related to it is known.

    Parameters
    ----------
    folder : Path
        PDB and mmCIF files, gzipped or not.
    out : Path
        Folder of the results; a run that was stopped goes on there.
    jobs, scheduler
        As for :func:`loopelastica.batch.workers.outcomes`.
    progress : bool
        Show a bar.
    limits : Limits, optional
        How large a file may be.

    Returns
    -------
    Run
        Rows, failures and notes.

    Raises
    ------
    ValueError
        If `folder` holds no such file, or `jobs` or `scheduler` cannot be understood.
    """
    from loopelastica.studies.evaluation.pictures import draw

    files, again = distinct(structure_files(folder))
    options = FoldOptions(**asdict(limits or Limits()), **HONEST)
    # what is known of loops decides about the answers
    tables = [str(data_path(name)) for name in ("loops.lib", "motifs.json")]
    made = tasks_of(files, options.to_dict(), out, beside=tables)
    # in the tables a file has its name in the folder
    tasks = [replace(task, file=Path(task.file).name) for task in made]
    done = run(EVALUATION, tasks, out, jobs, scheduler, progress)
    rows = [dict(row) for row in done.rows]
    add_comparisons(rows)
    write_csv(out / "scoreboard.csv", ({c: row[c] for c in _COLUMNS} for row in rows), _COLUMNS)
    write_text(out / "scoreboard.md", scoreboard(rows, done.failures))
    if rows:
        draw(rows, out)
    return replace(done, notes=(*again, *done.notes))


def add_comparisons(rows: list[dict[str, Any]]) -> None:
    """Add what needs all loops at once: mean loops of other families, refitted constants."""
    simple = [row for row in rows if row["simple"]]
    for row in rows:
        others = [
            np.array(other["native"])
            for other in simple
            if other["nucleotides"] == row["nucleotides"]
            and other["kind"] == row["kind"]
            and other["family"] != row["family"]
        ]
        mean = np.mean(others, axis=0) if others else None
        row["mean_loop_A"] = None if mean is None else rmsd_A(mean, np.array(row["native"]))
        row["refit_taper_A"] = row["refit_all_A"] = None
    if simple:
        refits = refitted_A(simple)
        for name, values in refits.items():
            for row, value in zip(simple, values, strict=True):
                row[f"refit_{name}_A"] = float(value)


def groups(rows: list[dict[str, Any]]) -> dict[str, list[dict[str, Any]]]:
    """Simple loops by set, type and length; then those that are shown apart."""
    simple = [row for row in rows if row["simple"]]
    found = {"all simple loops": simple}
    for key, label in (("set", "{}"), ("type", "{}"), ("nucleotides", "{} nucleotides")):
        for value in sorted({row[key] for row in simple}):
            found[label.format(value)] = [row for row in simple if row[key] == value]
    apart = [row for row in rows if not row["simple"]]
    found["apart: with contacts or long"] = [r for r in apart if r["set"] != "not evidence"]
    for row in apart:
        if row["set"] == "not evidence":
            found[
                f"apart: {Path(row['file']).name} {row['loop']} (refined with elastic models)"
            ] = [row]
    return {name: members for name, members in found.items() if members}


def scoreboard(rows: list[dict[str, Any]], failures: tuple[str, ...] = ()) -> str:
    """The scoreboard in markdown.

    Parameters
    ----------
    rows : list of dict
        Of all loops, with their comparisons.
    failures : tuple of str
        A sentence for each loop or file without a row.

    Returns
    -------
    str
    """
    table = groups(rows)
    lines = [
        "# Scoreboard",
        "",
        "RMSD of loop centroids against the file's loop, model 1, no superposition, Å: median /"
        " 90 % (number of loops). No answer has seen a loop atom, and none was taken from a related"
        " loop: shapes of its own entry, of its sequence and of one much like it are left out"
        " (`--exclude-relatives`); homologues of another sequence are not, nor other sequences of"
        " its motif. In the sample: the rule's table was written with the loops of its evidence in"
        " view, the errors to expect were learned from the loops of the program's own library; the"
        " refitted columns have seen nothing of a loop's family.",
        "",
        "| loops | " + " | ".join(METHODS.values()) + " |",
        "|---|" + "---|" * len(METHODS),
    ]
    for name, members in table.items():
        cells = [_median_90([row[m] for row in members]) for m in METHODS]
        lines.append(f"| {_plain(name)} ({len(members)}) | " + " | ".join(cells) + " |")
    rivals = {name: METHODS[name] for name in SIMPLER}
    lines += ["", "## Where something simpler is better", "", NEARER, ""]
    lines.append(wins({_plain(name): members for name, members in table.items()}, rivals))
    lines += ["", "By medians, on loops that both have:", "", *_defeats(table)]
    lines += ["", "## Paired differences, first answer minus other", "", *_paired(rows)]
    lines += ["", "## Expected errors", "", *expected_errors(rows)]
    lines += ["", "## What failed", "", *(f"- {_plain(sentence)}" for sentence in failures)]
    if not failures:
        lines.append("Nothing.")
    return "\n".join(lines) + "\n"


def _plain(text: str) -> str:
    """A name or a sentence in which nothing is taken for markdown or HTML."""
    return re.sub(r"([\\`*\[\]<>&|$])", r"\\\1", printable(text))


def _median_90(values: list[float | None]) -> str:
    present = [v for v in values if v is not None]
    if not present:
        return "–"
    of = "" if len(present) == len(values) else f" ({len(present)})"
    return f"{np.median(present):.2f} / {np.percentile(present, 90):.2f}{of}"


def _defeats(table: dict[str, list[dict[str, Any]]]) -> list[str]:
    """A sentence for each group in which a rival has the lower median, on loops both have."""
    lines = []
    for name, members in table.items():
        better = []
        for rival in RIVALS:
            both = [(r["rmsd_first_A"], r[rival]) for r in members if r[rival] is not None]
            if both:
                ours, theirs = np.median(both, axis=0)
                if theirs < ours:
                    better.append(f"{METHODS[rival]} ({theirs:.2f} against {ours:.2f} Å)")
        if better:
            lines.append(f"- {_plain(name)}: {', '.join(better)}.")
    return lines or ["Nowhere in these sets."]


def _paired(rows: list[dict[str, Any]]) -> list[str]:
    lines = ["| loops | other | mean over families (95 % of the bootstrap over families), Å |"]
    lines.append("|---|---|---|")
    simple = [row for row in rows if row["simple"]]
    for kind, low, high in (("DNA", 3, 9), ("RNA", 3, 5), ("RNA", 6, 9)):
        of = [r for r in simple if r["kind"] == kind and low <= r["nucleotides"] <= high]
        for other in ("refit_taper_A", "refit_all_A", *RIVALS):
            both = [row for row in of if row[other] is not None]
            if both:
                difference = np.array([row["rmsd_first_A"] - row[other] for row in both])
                families = [row["family"] for row in both]
                mean, least, most = interval(difference, families)
                lines.append(
                    f"| {kind}, {low}–{high} nt ({len(both)}, {len(set(families))} families) |"
                    f" {METHODS[other]} | {mean:+.2f} ({least:+.2f} to {most:+.2f}) |"
                )
    return lines
