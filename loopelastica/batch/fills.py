"""The work of ``loopelastica fill`` on one file of many."""

from pathlib import Path
from typing import Any

from loopelastica.batch.journal import Record
from loopelastica.batch.run import Task, Work
from loopelastica.filling.fill import fill_entry
from loopelastica.filling.folder import folder_of, is_there, strand_record, write_folder
from loopelastica.filling.options import FillOptions
from loopelastica.molecule.entry import read_entry

COLUMNS = (
    *("file", "model", "chain", "first", "last", "sequence", "kind", "nucleotides"),
    *("status", "reason", "sound", "expected_10_A", "expected_rmsd_A", "expected_90_A"),
    *("shape", "distance_A", "length_A", "crowding", "energy_per_A", "contact_energy_per_A"),
    *("nearest_A", "worst_bond_A", "worst_angle_deg", "closest_contact_A", "folder"),
)


def fill_file(task: Task) -> Record:
    """Fill the strands of a file and write its folder; a row per strand.

    ``task.options`` holds the options of :func:`loopelastica.fill`.
    """
    source = Path(task.source)
    options = FillOptions(**task.options)
    filling = fill_entry(read_entry(source, options.limits), options)
    folder = folder_of(Path(task.out), source, task.number)
    rows: list[dict[str, Any]] = []
    failures = [f"{source}: {sentence}" for sentence in filling.failures]
    record: Record = {"rows": rows, "failures": failures, "folder": folder.name}
    notes = [f"{source}: {sentence}" for sentence in filling.remarks]
    if not filling.strands and not filling.completed and not filling.repaired:
        notes.append(f"{source}: no internal gap; nothing to fill")
    record["notes"] = notes
    try:
        record["folder_key"] = write_folder(folder, filling)
    except FileExistsError as error:
        failures.append(str(error))
        record["refused"] = True
        return record
    for strand in filling.strands:
        rows.append({"file": str(source), **_row(strand_record(strand)), "folder": folder.name})
    return record


def _row(record: dict[str, Any]) -> dict[str, Any]:
    """Columns of the table from what fill.json has of a strand."""
    low, middle, high = record["expected_rmsd_A"] or (None, None, None)
    first = record["candidates"][0] if record["candidates"] else {}
    own = {"expected_10_A": low, "expected_rmsd_A": middle, "expected_90_A": high}
    return {name: {**first, **record, **own}.get(name) for name in COLUMNS if name != "file"}


def _results_are_there(task: Task, record: Record) -> bool:
    """Whether the folder still holds this result; a refused one is tried again."""
    key = record.get("folder_key")
    return (
        "refused" not in record
        and key is not None
        and is_there(Path(task.out) / record["folder"], key)
    )


FILLS = Work("summary", fill_file, COLUMNS, _results_are_there)
