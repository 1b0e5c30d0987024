"""The work of ``loopelastica origami`` on one design of many."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from loopelastica._names import safe_stem
from loopelastica.batch.journal import Record
from loopelastica.batch.run import Work
from loopelastica.batch.tasks import Task
from loopelastica.nanostructures.inputs import input_paths
from loopelastica.nanostructures.nanostructure import STRAND_COLUMNS, nanostructure
from loopelastica.report.nanostructure import is_there, write_folder

COLUMNS = ("file", *STRAND_COLUMNS, "output")


def design_tasks(
    designs: Sequence[tuple[str, str | None]], options: dict[str, Any], form: str, out: Path
) -> list[Task]:
    """One task per design, each with names of its own for what it writes.

    Parameters
    ----------
    designs : sequence of (str, str or None)
        A file, and of a pair of oxDNA files the other one where it was given.
    options : dict
        Of :func:`loopelastica.nanostructure`, JSON-ready.
    form : {"old", "new"}
        Of the topologies.
    out : Path
        Folder of the run.

    Returns
    -------
    list of Task
    """
    read = [input_paths(*design) for design in designs]
    inputs = sorted({path for paths in read for path in paths})
    taken: set[str] = set()
    tasks = []
    for (design, _), (source, *beside) in zip(designs, read, strict=True):
        stem = _free(safe_stem(Path(design)), taken)
        own = {"other": beside[0] if beside else None, "form": form, "stem": stem, "inputs": inputs}
        tasks.append(Task(source, 1, {**options, **own}, str(out.absolute()), design, (*beside,)))
    return tasks


def _free(stem: str, taken: set[str]) -> str:
    """The stem, numbered from the second of a name on; file systems may not tell cases apart."""
    name, number = stem, 1
    while name.casefold() in taken:
        number += 1
        name = f"{stem}_{number}"
    taken.add(name.casefold())
    return name


def lay_design(task: Task) -> Record:
    """Lay the single strands of a design and write its files; a row per strand.

    ``task.options`` holds the options of :func:`loopelastica.nanostructure`, and with them what is
    written: ``form``, ``stem``, and ``inputs``, which are not written over.
    """
    source, out = task.source, Path(task.out)
    options = dict(task.options)
    form, stem, inputs = (options.pop(name) for name in ("form", "stem", "inputs"))
    found = nanostructure(source, **options)
    record: Record = {
        "rows": [],
        "failures": [f"{source}: {strand.reason}" for strand in found.refused],
        "notes": [f"{source}: {sentence}" for sentence in found.notes],
        "stem": stem,
    }
    try:
        record["folder_key"] = write_folder(out, stem, found, form, map(Path, inputs))
    except FileExistsError as error:
        record["failures"].append(str(error))
        return record
    record["rows"] = [
        {"file": source, **found.row(strand), "output": stem} for strand in found.strands
    ]
    return record


def _results_are_there(task: Task, record: Record) -> bool:
    """Whether the folder still holds this result; one that could not be written is tried again."""
    return "folder_key" in record and is_there(Path(task.out), record["stem"], record["folder_key"])


ORIGAMIS = Work("summary", lay_design, COLUMNS, _results_are_there)
