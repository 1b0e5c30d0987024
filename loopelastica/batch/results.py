"""Folds that are there, written as the command writes them: a folder per loop, and the tables."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import groupby
from os import PathLike
from pathlib import Path
from typing import Any

from loopelastica._checks import file_name, flag, known_keywords, optional, shown
from loopelastica._files import make_folder, write_csv
from loopelastica._names import safe_name
from loopelastica.atoms.conventions import check_names
from loopelastica.atoms.model import AtomModel, build_atoms
from loopelastica.atoms.turn import check_contact
from loopelastica.batch.folds import COLUMNS, loop_rows
from loopelastica.batch.lock import alone_in
from loopelastica.batch.run import FAILURE_COLUMNS, check_tables
from loopelastica.errors import StructureError
from loopelastica.folding.options import Options, option
from loopelastica.folding.result import LoopFold
from loopelastica.folding.source import FileSource, Snapshot
from loopelastica.molecule.nucleotides import Structure
from loopelastica.molecule.setting import Settings
from loopelastica.report.atoms import LoopAtoms
from loopelastica.report.folder import Folders, write_fold
from loopelastica.report.page.write import check_available, is_available, renew_report
from loopelastica.report.pdb import WHOLE_ATOMS, WholeStructure

_OF_ATOMS = ("contact", "hydrogens", "names", "no_5_phosphate", "separate")


def _atoms(name: str, value: Any) -> bool | tuple[AtomModel, ...]:
    if isinstance(value, Sequence) and value and all(isinstance(m, AtomModel) for m in value):
        return tuple(value)
    try:
        return flag(name, value)
    except ValueError:
        raise ValueError(
            f"`{name}` is {shown(value)}; it must be True, False or the models that were built"
        ) from None


def _contact(_: str, value: Any) -> str | None:
    check_contact(value)
    return None if value is None else str(value)


@dataclass(frozen=True, slots=True, kw_only=True)
class WriteOptions(Options):
    """What is written of a loop; :meth:`loopelastica.LoopFold.write` says what each means."""

    atoms: bool | Sequence[AtomModel] = option(False, _atoms)
    contact: str | None = option(None, _contact)
    hydrogens: bool = option(False, flag)
    names: str = option("pdb", check_names)
    no_5_phosphate: bool = option(False, flag)
    separate: bool = option(False, flag)
    plot: bool = option(True, flag)
    report: bool | None = option(None, optional(flag))
    whole: bool | None = option(None, optional(flag))

    def __post_init__(self) -> None:
        Options.__post_init__(self)
        defaults = {item.name: item.default for item in fields(self)}
        if self.report:
            check_available()
        for name in _OF_ATOMS:
            if self.atoms is False and getattr(self, name) != defaults[name]:
                raise ValueError(f"`{name}` needs `atoms`")

    @property
    def has_report(self) -> bool:
        """Whether what report.html shows is written."""
        return is_available() if self.report is None else self.report

    @classmethod
    def given(cls, options: Mapping[str, Any]) -> WriteOptions:
        """From keywords, of which one that is unknown is named."""
        known_keywords("write", options, [item.name for item in fields(cls)])
        return cls(**options)


class _Writer:
    """Loops of one source: what is read once for all of them."""

    def __init__(self, source: FileSource | Snapshot, structure: Structure) -> None:
        self.source, self.structure = source, structure
        self._whole: WholeStructure | None = None
        self._settings = Settings(structure)

    def folder(self, folders: Folders, fold: LoopFold) -> Path:
        """The folder of one loop."""
        if isinstance(self.source, FileSource):
            return folders.claim(self.source.path, fold)
        # a name has no suffix, whatever dots are in it
        return folders.claim(Path(f"{safe_name(self.source.name, 150)}.pdb"), fold)

    def write(
        self, folder: Path, fold: LoopFold, options: WriteOptions, atoms: LoopAtoms | None
    ) -> None:
        """Write one loop; OutputError where that cannot be."""
        write_fold(
            folder,
            self.source.path if isinstance(self.source, FileSource) else self.source.about,
            fold,
            self.structure,
            options.plot,
            self._full(options.whole),
            atoms,
            self._settings,
            options.has_report,
        )

    def atoms(self, fold: LoopFold, options: WriteOptions) -> LoopAtoms | None:
        """The atoms of one loop, None where none are wanted; StructureError where it gets none."""
        if options.atoms is False:
            return None
        positions = self.structure.positions(0)
        models = options.atoms
        if isinstance(models, bool):
            models = build_atoms(self.structure, fold, positions=positions, contact=options.contact)
        ranks = {candidate.rank for candidate in fold.candidates}
        if any(model.rank not in ranks for model in models):
            raise ValueError(f"`atoms` holds models that are none of {fold.hairpin.label}")
        written = {name: getattr(options, name) for name in _OF_ATOMS}
        return LoopAtoms(self.structure, fold, tuple(models), positions, **written)

    def _full(self, given: bool | None) -> WholeStructure | None:
        # an ideal hairpin has no loop that a line could take the place of
        small = len(self.structure.universe.atoms) <= WHOLE_ATOMS and not self._ideal
        if not (small if given is None else given):
            return None
        self._whole = self._whole or WholeStructure(self.structure)
        return self._whole

    @property
    def _ideal(self) -> bool:
        return isinstance(self.source, Snapshot) and "sequence" in self.source.about


def write_loop(root: str | PathLike[str], fold: LoopFold, options: WriteOptions) -> Path:
    """Write the folder of one loop.

    Parameters
    ----------
    root : path
        Folder for results.
    fold : LoopFold
        With at least one candidate, and its source.
    options : WriteOptions
        What is written.

    Returns
    -------
    Path
        The loop's own folder.

    Raises
    ------
    StructureError, ValueError, OutputError
        As :meth:`loopelastica.LoopFold.write`.
    """
    place = Path(file_name("folder", root))
    fold.check_folded()
    structure = fold.structure()
    assert fold.source is not None
    writer = _Writer(fold.source, structure)
    atoms = writer.atoms(fold, options)
    make_folder(place)
    folder = writer.folder(Folders(place), fold)
    writer.write(folder, fold, options, atoms)
    return folder


def write_folds(
    root: str | PathLike[str], folds: Iterable[LoopFold], options: WriteOptions
) -> Path:
    """Write the folders of many loops, summary.csv and failures.csv.

    Parameters
    ----------
    root : path
        Folder for results.
    folds : iterable of LoopFold
        Loops of one source after the other: a source is read once for those that follow each other.
    options : WriteOptions
        What is written.

    Returns
    -------
    Path
        The folder for results.

    Raises
    ------
    ValueError, OutputError
        As :meth:`loopelastica.Folds.write`.
    """
    place, folders = Path(file_name("folder", root)), Folders(Path(root))
    if not isinstance(options.atoms, bool):
        raise ValueError("`atoms` is a list of models; of several loops they are built: True")
    tables = _Tables()
    with alone_in(place):
        check_tables(place, "summary")
        try:
            for _, loops in groupby(folds, key=lambda fold: id(fold.source)):
                _write_source([*loops], folders, options, tables)
        finally:
            # what is done has its rows, however it ends
            tables.write(place)
            renew_report(place, options.has_report)
    return place


class _Tables:
    """Rows of what is done and of what failed."""

    def __init__(self) -> None:
        self.rows: list[dict[str, Any]] = []
        self.failures: list[dict[str, str]] = []

    def failed(self, file: str, sentence: str) -> None:
        """Keep why something failed, with the file at the head of the sentence."""
        told = sentence.startswith(f"{file}: ")
        self.failures.append({"file": file, "failure": sentence if told else f"{file}: {sentence}"})

    def write(self, place: Path) -> None:
        """Write both tables."""
        write_csv(place / "summary.csv", self.rows, COLUMNS)
        write_csv(place / "failures.csv", self.failures, FAILURE_COLUMNS)


def _write_source(
    loops: Sequence[LoopFold], folders: Folders, options: WriteOptions, tables: _Tables
) -> None:
    """Write loops of one source."""
    source, writer = loops[0].source, None
    file = "" if source is None else source.file
    for fold in loops:
        for sentence in (*fold.model_failures, fold.failure):
            if sentence is not None:
                tables.failed(file, sentence)
        if fold.failure is not None:
            continue
        atoms: LoopAtoms | None = None
        try:
            if writer is None:
                structure = fold.structure()
                assert source is not None
                writer = _Writer(source, structure)
            try:
                atoms = writer.atoms(fold, options)
            except StructureError as error:
                # the line is there all the same
                tables.failed(file, str(error))
            folder = writer.folder(folders, fold)
            writer.write(folder, fold, options, atoms)
        except StructureError as error:
            tables.failed(file, str(error))
            continue
        except FileExistsError as error:
            tables.failures.append({"file": file, "failure": str(error)})
            continue
        for row in loop_rows(file, fold):
            figures = {} if atoms is None else atoms.figures(row["rank"])
            tables.rows.append({**row, **figures, "folder": folder.name})
