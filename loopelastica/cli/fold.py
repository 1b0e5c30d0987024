"""``loopelastica fold``: files to folders, one by one or on many processes."""

from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from loopelastica.cli import options as o
from loopelastica.cli.program import in_options, tell

if TYPE_CHECKING:
    from collections.abc import Iterable

    from loopelastica.batch.run import Row
    from loopelastica.folding.options import FoldOptions
    from loopelastica.folding.result import LoopFold
    from loopelastica.report.folder import Folders
    from loopelastica.report.tables import LoopModels


def fold(
    files: o.Files,
    out: o.Out = o.OUT,
    darboux: o.Darboux = False,
    torsion_ratio: o.TorsionRatio = None,
    length_per_nucleotide: o.LengthPerNucleotide = None,
    stem_extend_5: o.StemExtend5 = None,
    stem_extend_3: o.StemExtend3 = None,
    taper: o.Taper = None,
    persistence_length: o.PersistenceLength = 10.0,
    energy_max: o.EnergyMax = None,
    candidates: o.Candidates = 10,
    all_models: o.AllModels = True,
    shapes: o.Shapes = "all",
    rank: o.Rank = "default",
    like: o.Like = None,
    library: o.Library = None,
    exclude_relatives: o.ExcludeRelatives = False,
    surroundings: o.Around = True,
    irregular: o.Irregular = False,
    pair: o.Pairs = None,
    dot_bracket: o.Brackets = None,
    loop: o.Loops = None,
    max_size: o.MaxSize = None,
    max_atoms: o.MaxAtoms = None,
    plot: o.Plot = True,
    whole: o.Whole = None,
    jobs: o.Jobs = None,
    scheduler: o.Scheduler = None,
    atoms: Annotated[
        bool, typer.Option("--atoms", help="Build the loop's atoms on every candidate's line.")
    ] = False,
    contact: o.Contact = None,
    hydrogens: o.Hydrogens = False,
    names: o.Names = "pdb",
    no_5_phosphate: o.NoPhosphate = False,
    separate: o.Separate = False,
) -> None:
    """Fold every hairpin loop of the files; write tables, traces and a picture per hairpin.

    The folder for the results gets summary.csv, a row per candidate, and failures.csv. With --jobs
    or --scheduler, for thousands of files, the same command resumes a run that was stopped.
    """
    from loopelastica.folding.options import FoldOptions

    many = jobs is not None or scheduler is not None
    o.refuse(
        (torsion_ratio is not None and not darboux, "--torsion-ratio needs --darboux"),
        (contact is not None and not atoms, "--contact needs --atoms"),
        (hydrogens and not atoms, "--hydrogens needs --atoms"),
        (names != "pdb" and not atoms, "--names needs --atoms"),
        (no_5_phosphate and not atoms, "--no-5-phosphate needs --atoms"),
        (separate and not atoms, "--separate needs --atoms"),
        (many and atoms, "--atoms goes without --jobs and --scheduler"),
        (many and whole is True, "--whole goes without --jobs and --scheduler"),
        o.either(jobs, scheduler),
    )
    with o.usage():
        options = FoldOptions(
            free_spin=not darboux,
            torsion_ratio=1.0 if torsion_ratio is None else torsion_ratio,
            length_per_nucleotide_A=length_per_nucleotide,
            stem_extend_5=stem_extend_5,
            stem_extend_3=stem_extend_3,
            taper=taper,
            persistence_length_A=persistence_length,
            energy_max=energy_max,
            max_candidates=candidates,
            all_models=all_models,
            shapes=shapes,
            rank=rank,
            like=like,
            library=library,
            exclude_relatives=exclude_relatives,
            surroundings=surroundings,
            irregular=irregular,
            pair=pair or (),
            dot_bracket=dot_bracket,
            loop=loop or (),
            **o.limits(max_size, max_atoms),
        )
        if atoms:
            from loopelastica.atoms.conventions import check_names
            from loopelastica.atoms.turn import check_contact

            check_contact(contact)
            check_names("names", names)
    if options.like is not None:
        from loopelastica.folding.like import check_loops

        # a template that is none fails once, not for each file
        check_loops(options.like, (), options.limits)
    if options.library is not None and options.shapes == "all":
        from loopelastica.folding.known import library_at

        library_at(options.library)
    if many:
        _fold_many(files, out, options, plot, jobs or 1, scheduler)
    else:
        written = {
            "hydrogens": hydrogens,
            "names": names,
            "no_5_phosphate": no_5_phosphate,
            "separate": separate,
        }
        _fold_each(files, out, options, _Output(plot, whole, contact, written if atoms else None))


def _fold_many(
    files: list[str],
    out: Path,
    options: "FoldOptions",
    plot: bool,
    jobs: int,
    scheduler: str | None,
) -> None:
    from loopelastica.batch.folds import FOLDS
    from loopelastica.batch.run import distinct, run, tasks_of
    from loopelastica.folding.like import file_of

    files, notes = distinct(files)
    with o.usage():
        beside = (file_of(options.like), options.library)
        tasks = tasks_of(files, {**options.to_dict(), "plot": plot}, out, beside)
        done = run(FOLDS, tasks, out, jobs, scheduler, progress=True, wording=in_options)
    tell(
        f"{done.n_files} files ({done.n_resumed} were done before), {done.n_rows} candidates in"
        f" {done.table}"
    )
    o.note([*notes, *done.notes, *_of_earlier_runs(out, done.rows)])
    o.fail_of_many(done.failures, out)


def _of_earlier_runs(out: Path, rows: "Iterable[Row]") -> list[str]:
    """A note that names what lies in the folder besides the results of this run."""
    from loopelastica.report.folder import other_folds

    others = other_folds(out, {row["folder"] for row in rows})
    if not others:
        return []
    names = ", ".join(o.screenful(others, "of the kind"))
    return [f"{out} holds results of earlier runs that are not in summary.csv: {names}"]


@dataclass(frozen=True)
class _Output:
    """What is written of each loop beside the tables."""

    plot: bool
    whole: bool | None
    contact: str | None
    # None: no atoms
    atoms: dict[str, Any] | None


@dataclass
class _Results:
    """What became of the files: for the screen, for the tables, and to be said."""

    shown: "list[tuple[str, LoopFold | str, Path | None]]" = field(default_factory=list)
    built: "list[tuple[str, LoopModels]]" = field(default_factory=list)
    rows: list[dict[str, Any]] = field(default_factory=list)
    failures: list[dict[str, str]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    n_done: int = 0

    def failed(self, file: str, sentence: str) -> None:
        """Keep what has failed, with options as they are called on the command line."""
        self.failures.append({"file": file, "failure": in_options(sentence)})

    def write(self, out: Path) -> None:
        """Write the tables, as a run over many files does."""
        from loopelastica._files import write_csv
        from loopelastica.batch.folds import COLUMNS
        from loopelastica.batch.run import FAILURE_COLUMNS

        write_csv(out / "summary.csv", self.rows, COLUMNS)
        write_csv(out / "failures.csv", self.failures, FAILURE_COLUMNS)


def _fold_each(files: list[str], out: Path, options: "FoldOptions", output: _Output) -> None:
    from tqdm import tqdm

    from loopelastica._files import OutputError
    from loopelastica.batch.lock import alone_in
    from loopelastica.batch.run import check_tables, distinct
    from loopelastica.batch.workers import attempt
    from loopelastica.report.folder import Folders
    from loopelastica.report.tables import atoms_table, console, fold_table

    files, notes = distinct(files)
    results, folders = _Results(notes=notes), Folders(out)

    def fold_next(file: str) -> None:
        _fold_file(file, options, folders, results, output)

    with alone_in(out):
        check_tables(out, "summary")
        try:
            for file in tqdm(files, disable=len(files) < 2, unit="file", leave=False):
                outcome = attempt(fold_next, file)
                if outcome.failure is not None:
                    results.failed(file, outcome.failure)
                    results.shown.append((Path(file).name, outcome.failure, None))
                results.n_done += 1
        except KeyboardInterrupt:
            results.write(out)
            raise KeyboardInterrupt(
                f"{results.n_done} of {len(files)} files are done; the same command folds all of"
                " them again, with --jobs 1 it goes on where it was stopped"
            ) from None
        except OutputError:
            # the disk is full: the folders that are there keep their rows, if those still fit
            with suppress(OutputError):
                results.write(out)
            raise
        results.write(out)
        results.notes += _of_earlier_runs(out, results.rows)
    console().print(fold_table(results.shown))
    if results.built:
        console().print(atoms_table(results.built))
    o.note(results.notes)
    o.fail([failure["failure"] for failure in results.failures])


def _fold_file(
    file: str, options: "FoldOptions", folders: "Folders", results: _Results, output: _Output
) -> None:
    from loopelastica.batch.folds import loop_rows
    from loopelastica.cli.atoms import atoms_of
    from loopelastica.errors import LoopelasticaError, StructureError
    from loopelastica.folding.fold import fold_hairpins
    from loopelastica.molecule.hairpins import find_hairpins
    from loopelastica.molecule.nucleotides import read_structure
    from loopelastica.molecule.setting import Settings
    from loopelastica.report.folder import write_fold
    from loopelastica.report.listing import remarks
    from loopelastica.report.pdb import WHOLE_ATOMS, WholeStructure, renamed
    from loopelastica.report.tables import LoopModels

    path = Path(file)
    structure = read_structure(file, options.limits)
    found = find_hairpins(structure, **options.selection)
    sentences = remarks(structure, found)
    loops = fold_hairpins(structure, found, options)
    small = len(structure.universe.atoms) <= WHOLE_ATOMS
    with_whole = small if output.whole is None else output.whole
    full = WholeStructure(structure) if loops and with_whole else None
    settings = Settings(structure)
    sentences += [
        f"chain {chain} is {letter} in the PDB files that are written"
        for chain, letter in renamed(structure).items()
    ]
    if not loops:
        results.notes += [f"{file}: {sentence}" for sentence in sentences]
        raise StructureError(f"{file}: no hairpin loop found; nothing to fold")
    for loop in loops:
        for sentence in loop.model_failures:
            results.failed(file, f"{file}: {sentence}")
        if loop.failure is not None:
            results.failed(file, f"{file}: {loop.failure}")
            results.shown.append((path.name, loop, None))
            continue
        folder, built = folders.claim(path, loop), None
        try:
            if output.atoms is not None:
                first = structure.positions(0)
                built = atoms_of(structure, loop, first, output.contact, **output.atoms)
                sentences += [f"{loop.hairpin.label}: {remark}" for remark in built.remarks]
        except LoopelasticaError as error:
            results.failed(file, f"{file}: {error}")
        try:
            write_fold(folder, path, loop, structure, output.plot, full, built, settings)
        except FileExistsError as error:
            results.failed(file, str(error))
            results.shown.append((path.name, str(error), None))
            continue
        rows = loop_rows(file, loop)
        if built is not None:
            rows = [{**row, **built.figures(row["rank"])} for row in rows]
            results.built.append((path.name, LoopModels(loop, built.models)))
        results.rows += [{**row, "folder": folder.name} for row in rows]
        results.shown.append((path.name, loop, folder))
        sentences += loop.remarks
    results.notes += [f"{file}: {sentence}" for sentence in sentences]
