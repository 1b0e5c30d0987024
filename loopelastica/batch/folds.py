"""The work of ``loopelastica fold`` on one file of many."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from loopelastica.batch.journal import Record
from loopelastica.batch.run import Work
from loopelastica.batch.tasks import Task
from loopelastica.errors import LoopelasticaError
from loopelastica.folding.fold import fold_hairpins
from loopelastica.folding.options import FoldOptions
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.hairpins import find_hairpins
from loopelastica.molecule.nucleotides import Structure, read_structure
from loopelastica.molecule.setting import Settings
from loopelastica.report import pdb
from loopelastica.report.folder import Folders, is_there, write_fold
from loopelastica.report.listing import remarks
from loopelastica.report.pdb import WholeStructure, renamed
from loopelastica.report.records import ATOMS_COLUMNS, candidate_row

if TYPE_CHECKING:
    from loopelastica.report.atoms import LoopAtoms

_LOOP = ("file", "loop", "kind", "closing_pair", "sequence", "nucleotides")
_CLAMP = ("stem_extend_5", "stem_extend_3", "taper", "length_per_nucleotide_A")
_SHAPE = (
    *("rank", "rank_energy", "shape", "expected_10_A", "expected_rmsd_A", "expected_90_A"),
    *("energy_per_A", "energy_kT", "energy_dimensionless", "stable", "residual"),
    *("rmsd_A", "rmsd_models_mean_A", "rmsd_models_sd_A", "n_models", "length_A"),
    *("touching", "stem_contact_A", "self_contact_A", "twist_turns"),
)
COLUMNS = (*_LOOP, *_CLAMP, "stem_rms_A", *_SHAPE, *ATOMS_COLUMNS, "folder")


@dataclass(frozen=True, slots=True)
class Written:
    """What is written of each loop beside its tables.

    Attributes
    ----------
    plot : bool
        Whether plot.png is drawn.
    whole : bool or None
        Whether whole.pdb is written; None for structures that are not large.
    atoms : callable or None
        Structure, loop → its atoms; None for none.
    report : bool
        Whether what report.html shows is written.
    """

    plot: bool = True
    whole: bool | None = False
    atoms: "Callable[[Structure, LoopFold], LoopAtoms] | None" = None
    report: bool = False


def fold_file(task: Task) -> Record:
    """Fold all loops of a file and write their folders; a row per candidate.

    ``task.options`` holds the options of :func:`loopelastica.fold`, ``plot``, and ``report`` where
    what report.html shows is to be written too.
    """
    options = dict(task.options)
    written = Written(options.pop("plot"), report=options.pop("report", False))
    folders = Folders(Path(task.out), task.number)
    return fold_into(folders, task.source, FoldOptions(**options), written)


def fold_into(folders: Folders, file: str, options: FoldOptions, written: Written) -> Record:
    """Fold all loops of a file and write their folders.

    Parameters
    ----------
    folders : Folders
        Names for the folders.
    file : str
        Its path, as sentences are to name it.
    options : FoldOptions
        As for :func:`loopelastica.fold`.
    written : Written
        What is written beside the tables.

    Returns
    -------
    dict
        ``rows``, a row per candidate, which may have ``atoms_not_sound_because`` beside the columns
        of the table; ``failures`` and ``notes``, sentences; ``folder_key``; ``refused`` where a
        folder could not be written.

    Raises
    ------
    StructureError
        If the file cannot be read or holds no nucleic acid.
    """
    path = Path(file)
    structure = read_structure(file, options.limits)
    found = find_hairpins(structure, **options.selection)
    notes = remarks(structure, found)
    loops = fold_hairpins(structure, found, options)
    notes += [
        f"chain {chain} is {letter} in the PDB files that are written"
        for chain, letter in renamed(structure).items()
    ]
    rows: list[dict[str, Any]] = []
    failures: list[str] = []
    record: Record = {"rows": rows, "failures": failures}
    if not loops:
        failures.append(f"{file}: no hairpin loop found; nothing to fold")
    small = len(structure.universe.atoms) <= pdb.WHOLE_ATOMS
    with_whole = small if written.whole is None else written.whole
    whole = WholeStructure(structure) if loops and with_whole else None
    settings = Settings(structure)
    for loop in loops:
        failures += [f"{file}: {sentence}" for sentence in loop.model_failures]
        if loop.failure is not None:
            failures.append(f"{file}: {loop.failure}")
            continue
        folder, atoms = folders.claim(path, loop), None
        try:
            if written.atoms is not None:
                atoms = written.atoms(structure, loop)
                notes += [f"{loop.hairpin.label}: {remark}" for remark in atoms.remarks]
        except LoopelasticaError as error:
            failures.append(f"{file}: {error}")
        try:
            record["folder_key"] = write_fold(
                folder, path, loop, structure, written.plot, whole, atoms, settings, written.report
            )
        except FileExistsError as error:
            failures.append(str(error))
            record["refused"] = True
            continue
        of_atoms = {} if atoms is None else {c.rank: atoms.figures(c.rank) for c in loop.candidates}
        rows += [
            {**row, **of_atoms.get(row["rank"], {}), "folder": folder.name}
            for row in loop_rows(file, loop)
        ]
        notes += loop.remarks
    record["notes"] = [f"{file}: {sentence}" for sentence in notes]
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
