"""``loopelastica fold``: files to folders, one by one or on many processes."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from loopelastica.cli import options as o

if TYPE_CHECKING:
    from loopelastica.folding.options import FoldOptions
    from loopelastica.folding.result import LoopFold
    from loopelastica.report.folder import Folders


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
) -> None:
    """Fold every hairpin loop of the files; write tables, traces and a picture per hairpin.

    With --jobs or --scheduler for thousands of files: candidates.csv grows as results come, and the
    same command resumes a run that was stopped.
    """
    from loopelastica.folding.options import FoldOptions

    many = jobs is not None or scheduler is not None
    for refused, sentence in (
        (torsion_ratio is not None and not darboux, "--torsion-ratio needs --darboux"),
        (contact is not None and not atoms, "--contact needs --atoms"),
        (many and atoms, "--atoms goes without --jobs and --scheduler"),
        (many and whole is True, "--whole goes without --jobs and --scheduler"),
    ):
        if refused:
            raise typer.BadParameter(sentence)
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
            irregular=irregular,
            pair=pair or (),
            dot_bracket=dot_bracket,
            loop=loop or (),
            **o.limits(max_size, max_atoms),
        )
    if many:
        _fold_many(files, out, options, plot, jobs or 1, scheduler)
    else:
        _fold_each(files, out, options, _Output(plot, whole, atoms, contact))


def _fold_many(
    files: list[Path],
    out: Path,
    options: "FoldOptions",
    plot: bool,
    jobs: int,
    scheduler: str | None,
) -> None:
    from loopelastica.batch.folds import FOLDS
    from loopelastica.batch.run import run, tasks_of

    with o.usage():
        tasks = tasks_of(files, {**options.to_dict(), "plot": plot}, out)
        done = run(FOLDS, tasks, out, jobs, scheduler, progress=True)
    typer.echo(
        f"{done.n_files} files ({done.n_resumed} were done before), {done.n_rows} candidates in"
        f" {done.table}"
    )
    o.fail_of_many(done.failures, out)


@dataclass(frozen=True)
class _Output:
    """What is written of each loop beside the tables."""

    plot: bool
    whole: bool | None
    atoms: bool
    contact: str | None


@dataclass
class _Results:
    """What became of the files: rows of the table, notes, and sentences for what failed."""

    rows: "list[tuple[str, LoopFold | str, Path | None]]" = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    without_atoms: list[str] = field(default_factory=list)

    @property
    def failures(self) -> list[str]:
        failed = [
            result if isinstance(result, str) else f"{name}: {result.failure}"
            for name, result, _ in self.rows
            if isinstance(result, str) or result.failure
        ]
        return failed + self.without_atoms

    @property
    def model_failures(self) -> list[str]:
        return [
            f"{name}: {sentence}"
            for name, result, _ in self.rows
            if not isinstance(result, str)
            for sentence in result.model_failures
        ]


def _fold_each(files: list[Path], out: Path, options: "FoldOptions", output: _Output) -> None:
    from tqdm import tqdm

    from loopelastica.errors import LoopelasticaError
    from loopelastica.report.folder import Folders
    from loopelastica.report.tables import console, fold_table

    results, folders = _Results(), Folders(out)
    for file in tqdm(files, disable=len(files) < 2, unit="file", leave=False):
        try:
            _fold_file(file, options, folders, results, output)
        except LoopelasticaError as error:
            results.rows.append((file.name, str(error), None))
        except ValueError as error:
            # an option out of range concerns every file
            raise typer.BadParameter(str(error)) from None
        except OSError as error:
            sentence = f"{error.filename or file}: {error.strerror}"
            results.rows.append((file.name, sentence, None))
    console().print(fold_table(results.rows))
    for sentence in results.notes:
        typer.echo(f"note: {sentence}")
    failures = results.failures
    for sentence in (*failures, *results.model_failures):
        typer.echo(sentence, err=True)
    if failures:
        raise typer.Exit(1)


def _fold_file(
    file: Path, options: "FoldOptions", folders: "Folders", results: _Results, output: _Output
) -> None:
    from loopelastica.cli.build import atoms_of
    from loopelastica.errors import LoopelasticaError
    from loopelastica.folding.fold import fold_hairpins
    from loopelastica.molecule.hairpins import find_hairpins
    from loopelastica.molecule.nucleotides import read_structure
    from loopelastica.report.folder import write_fold
    from loopelastica.report.listing import remarks
    from loopelastica.report.pdb import WHOLE_ATOMS, WholeStructure, renamed

    structure = read_structure(file, options.limits)
    found = find_hairpins(structure, **options.selection)
    sentences = remarks(structure, found)
    loops = fold_hairpins(structure, found, options)
    small = len(structure.universe.atoms) <= WHOLE_ATOMS
    with_whole = small if output.whole is None else output.whole
    full = WholeStructure(structure) if loops and with_whole else None
    sentences += [
        f"chain {chain} is {letter} in the PDB files that are written"
        for chain, letter in renamed(structure.nucleotides.chain.tolist()).items()
    ]
    if not loops:
        results.rows.append((file.name, f"{file}: no hairpin loop found; nothing to fold", None))
    for loop in loops:
        folder = None
        if loop.failure is None:
            folder, built = folders.claim(file, loop), None
            try:
                if output.atoms:
                    built = atoms_of(structure, loop, structure.positions(0), output.contact)
            except LoopelasticaError as error:
                results.without_atoms.append(f"{file.name}: {error}")
            write_fold(folder, file, loop, structure, output.plot, full, built)
        sentences += loop.remarks
        results.rows.append((file.name, loop, folder))
    results.notes += [f"{file.name}: {sentence}" for sentence in sentences]
