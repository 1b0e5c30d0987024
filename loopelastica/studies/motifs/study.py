"""The study of loop shapes: from a folder of loops to the data of the package and a report."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from loopelastica._files import write_csv, write_json, write_text
from loopelastica._names import printable
from loopelastica._progress import progress_bar
from loopelastica.errors import LoopelasticaError
from loopelastica.folding.library import Library
from loopelastica.folding.library_file import save_library
from loopelastica.report.records import program
from loopelastica.studies.motifs.corpus import StudyLoop, library_of, read_corpus
from loopelastica.studies.motifs.habits import habit_rows, habit_table
from loopelastica.studies.motifs.judge import ENTRY, LEVELS, RELATIVES, rows_of
from loopelastica.studies.motifs.report import report
from loopelastica.studies.motifs.tables import error_tables, length_rows, motif_rows
from loopelastica.studies.motifs.trials import trial_rows

COLUMNS = (
    "source", "loop", "acid", "family", "motif", "n", "level", "place", "kind", "energy",
    "spread_A", "rmsd_A", "expected_10_A", "expected_50_A", "expected_90_A",
)  # fmt: skip


class Done(NamedTuple):
    """What a study has to say: its tables in markdown, and a sentence for each file it lacks."""

    tables: str
    failures: list[str]


def run(folder: Path, out: Path, progress: bool = False) -> Done:
    """Make ``loops.lib`` and ``motifs.json``, and measure how good answers from them are.

    Parameters
    ----------
    folder : Path
        PDB or mmCIF files of loops, and ``loops.csv`` where there is one
        (:mod:`loopelastica.studies.motifs.corpus`).
    out : Path
        Gets both, ``answers.csv`` with a row per loop and answer, and ``motifs.md``.
    progress : bool
        Show bars.

    Returns
    -------
    Done

    Raises
    ------
    LoopelasticaError
        If there is no loop to judge, or the folder's table cannot be read.
    ValueError
        If `folder` holds no structure file.
    """
    loops, left_out, failures = read_corpus(folder, progress)
    if not loops:
        why = (failures + left_out)[0]
        raise LoopelasticaError(f"{folder}: no loop in it can be judged; the first: {why}")
    library = library_of(loops)
    rows = answered(loops, library, progress)
    motifs, lengths = motif_rows(loops), length_rows(loops)
    content = {
        **program(),
        "motifs": motifs,
        "lengths": lengths,
        "habits": habit_table(loops),
        "errors": error_tables(calibrating(rows)),
    }
    tables = report(rows, motifs, lengths, trial_rows(loops, library), habit_rows(loops))
    counts = f"{len(failures)} files could not be read, {len(left_out)} loops were not judged:"
    sentences = [f"- {printable(sentence)}" for sentence in failures + left_out]
    out.mkdir(parents=True, exist_ok=True)
    save_library(library, out / "loops.lib")
    write_json(out / "motifs.json", content)
    # those of no place are the same answers again, for the errors where there is no library
    answers = ({c: row.get(c) for c in COLUMNS} for row in rows if row["place"])
    write_csv(out / "answers.csv", answers, COLUMNS)
    write_text(out / "motifs.md", "\n".join([tables, counts, "", *sentences, ""]))
    return Done(tables, failures)


def answered(
    loops: list[StudyLoop], library: Library, progress: bool = False
) -> list[dict[str, Any]]:
    """Rows of all levels."""
    return [
        row
        for level in LEVELS
        for row in progress_bar(
            rows_of(loops, library, level), desc=level, unit="answer", shown=progress
        )
    ]


def calibrating(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """What errors are learned from: nothing related was known, or the same sequence was."""
    return [
        row
        for row in rows
        if row["level"] == (ENTRY if row["kind"] == "same sequence" else RELATIVES)
    ]
