"""The work of ``loopelastica fill`` on one file of many."""

from pathlib import Path

from loopelastica.batch.journal import Record
from loopelastica.batch.run import Work
from loopelastica.batch.tasks import Task
from loopelastica.filling.fill import fill_entry
from loopelastica.filling.folder import (
    STRAND_COLUMNS,
    folder_of,
    is_there,
    strand_row,
    write_folder,
)
from loopelastica.filling.options import FillOptions
from loopelastica.molecule.entry import read_entry

COLUMNS = ("file", *STRAND_COLUMNS, "folder")


def fill_file(task: Task) -> Record:
    """Fill the strands of a file and write its folder; a row per strand.

    ``task.options`` holds the options of :func:`loopelastica.fill`, and ``report`` where what
    report.html shows is to be written too.
    """
    source, given = Path(task.source), dict(task.options)
    report = given.pop("report", False)
    options = FillOptions(**given)
    filling = fill_entry(read_entry(source, options.limits), options)
    folder = folder_of(Path(task.out), source, task.number)
    record: Record = {
        "rows": [],
        "failures": [f"{source}: {sentence}" for sentence in filling.failures],
        "notes": [f"{source}: {sentence}" for sentence in filling.notes],
        "folder": folder.name,
    }
    try:
        record["folder_key"] = write_folder(folder, filling, scene=report)
    except FileExistsError as error:
        record["failures"].append(str(error))
        record["refused"] = True
        return record
    record["rows"] = [
        {"file": str(source), **strand_row(strand), "folder": folder.name}
        for strand in filling.strands
    ]
    return record


def _results_are_there(task: Task, record: Record) -> bool:
    """Whether the folder still holds this result; a refused one is tried again."""
    key = record.get("folder_key")
    return (
        "refused" not in record
        and key is not None
        and is_there(Path(task.out) / record["folder"], key)
    )


FILLS = Work("summary", fill_file, COLUMNS, _results_are_there)
