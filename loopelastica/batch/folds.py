"""The work of ``loopelastica fold`` on one file of many."""

from pathlib import Path
from typing import Any

from loopelastica.batch.journal import Record
from loopelastica.batch.run import Task, Work
from loopelastica.folding.fold import fold_hairpins
from loopelastica.folding.options import FoldOptions
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.hairpins import find_hairpins
from loopelastica.molecule.nucleotides import read_structure
from loopelastica.molecule.setting import Settings
from loopelastica.report.folder import Folders, is_there, write_fold
from loopelastica.report.records import ATOMS_COLUMNS, candidate_row

_LOOP = ("file", "loop", "kind", "closing_pair", "sequence", "nucleotides")
_CLAMP = ("stem_extend_5", "stem_extend_3", "taper", "length_per_nucleotide_A")
_SHAPE = (
    *("rank", "rank_energy", "shape", "expected_10_A", "expected_rmsd_A", "expected_90_A"),
    *("energy_per_A", "energy_kT", "energy_dimensionless", "stable", "residual"),
    *("rmsd_A", "rmsd_models_mean_A", "rmsd_models_sd_A", "n_models", "length_A"),
    *("touching", "stem_contact_A", "self_contact_A", "twist_turns"),
)
COLUMNS = (*_LOOP, *_CLAMP, "stem_rms_A", *_SHAPE, *ATOMS_COLUMNS, "folder")


def fold_file(task: Task) -> Record:
    """Fold all loops of a file and write their folders; a row per candidate.

    ``task.options`` holds the options of :func:`loopelastica.fold`, and ``plot``.
    """
    source = Path(task.source)
    options = dict(task.options)
    plot = options.pop("plot")
    checked = FoldOptions(**options)
    structure = read_structure(source, checked.limits)
    loops = fold_hairpins(structure, find_hairpins(structure, **checked.selection), checked)
    folders, settings = Folders(Path(task.out), task.number), Settings(structure)
    rows: list[dict[str, Any]] = []
    failures: list[str] = []
    record: Record = {"rows": rows, "failures": failures}
    if not loops:
        failures.append(f"{source}: no hairpin loop found; nothing to fold")
    for loop in loops:
        failures += [f"{source}: {sentence}" for sentence in loop.model_failures]
        if loop.failure is not None:
            failures.append(f"{source}: {loop.failure}")
            continue
        folder = folders.claim(source, loop)
        try:
            record["folder_key"] = write_fold(
                folder, source, loop, structure, plot=plot, settings=settings
            )
        except FileExistsError as error:
            failures.append(str(error))
            record["refused"] = True
            continue
        rows += [{**r, "folder": folder.name} for r in loop_rows(source, loop)]
    return record


def loop_rows(source: Path | str, loop: LoopFold) -> list[dict[str, Any]]:
    """Rows of one loop: what it is, its clamp, and each candidate.

    Parameters
    ----------
    source : Path or str
        The file it is from; of a run its path as it was given stands in the table.
    loop : LoopFold
        With at least one candidate.

    Returns
    -------
    list of dict
        In the columns `COLUMNS`, without ``folder`` and what atoms have.
    """
    assert loop.ends is not None
    hairpin = loop.hairpin
    about = {
        "file": str(source),
        "loop": hairpin.name,
        "kind": hairpin.kind,
        "closing_pair": hairpin.label,
        "sequence": hairpin.sequence,
        "nucleotides": len(hairpin),
        **loop.ends.clamp.to_dict(),
        "stem_rms_A": loop.ends.rms_A,
    }
    return [{**about, **candidate_row(candidate)} for candidate in loop.candidates]


def _results_are_there(task: Task, record: Record) -> bool:
    """Whether the folders still hold this result; a refused one is tried again."""
    folders, key = {row["folder"] for row in record["rows"]}, record.get("folder_key")
    return "refused" not in record and all(
        key is not None and is_there(Path(task.out) / folder, key) for folder in folders
    )


FOLDS = Work("summary", fold_file, COLUMNS, _results_are_there)
