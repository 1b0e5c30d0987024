"""``loopelastica fold``: files to folders, one by one or on many processes."""

from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from loopelastica.cli import options as o
from loopelastica.cli.program import in_options
from loopelastica.cli.screen import Screen

if TYPE_CHECKING:
    from collections.abc import Sequence

    from loopelastica.batch.folds import Written
    from loopelastica.batch.run import Row
    from loopelastica.folding.options import FoldOptions


def fold(
    files: o.Files,
    out: o.Out = o.OUT,
    plot: o.Plot = True,
    report: o.Report = None,
    whole: o.Whole = None,
    all_models: o.AllModels = True,
    loop: o.Loops = None,
    pair: o.Pairs = None,
    dot_bracket: o.Brackets = None,
    irregular: o.Irregular = False,
    candidates: o.Candidates = 10,
    rank: o.Rank = "default",
    energy_max: o.EnergyMax = None,
    shapes: o.Shapes = "all",
    like: o.Like = None,
    library: o.Library = None,
    exclude_relatives: o.ExcludeRelatives = False,
    surroundings: o.Around = True,
    atoms: Annotated[
        bool,
        typer.Option(
            "--atoms",
            help="Build the loop's atoms on every candidate's line.",
            rich_help_panel=o.ATOMS,
        ),
    ] = False,
    contact: o.Contact = None,
    hydrogens: o.Hydrogens = False,
    names: o.Names = "pdb",
    no_5_phosphate: o.NoPhosphate = False,
    separate: o.Separate = False,
    darboux: o.Darboux = False,
    torsion_ratio: o.TorsionRatio = None,
    length_per_nucleotide: o.LengthPerNucleotide = None,
    stem_extend_5: o.StemExtend5 = None,
    stem_extend_3: o.StemExtend3 = None,
    taper: o.Taper = None,
    persistence_length: o.PersistenceLength = 10.0,
    max_size: o.MaxSize = None,
    max_atoms: o.MaxAtoms = None,
    jobs: o.Jobs = None,
    scheduler: o.Scheduler = None,
    quiet: o.Quiet = False,
    as_json: o.AsJson = False,
) -> None:
    """Fold every hairpin loop of the files.

    Each loop gets a folder with tables, traces and a picture; the folder for the results gets
    summary.csv, a row per candidate, and failures.csv. With --jobs
    or --scheduler, for thousands of files, the same command resumes a run that was stopped.
    """
    from loopelastica.batch.folds import Written
    from loopelastica.cli.atoms import atoms_of
    from loopelastica.folding.options import FoldOptions
    from loopelastica.molecule.folders import with_folders
    from loopelastica.report.page.write import has_report

    screen = Screen("fold", "loops", quiet, as_json)
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
    page = has_report(report)
    files = with_folders(files)
    if many:
        shown = {"plot": plot, "report": page}
        _fold_many(screen, files, out, options, shown, jobs or 1, scheduler)
        return
    build = None
    if atoms:
        build = partial(
            atoms_of,
            contact=contact,
            progress=not quiet,
            hydrogens=hydrogens,
            names=names,
            no_5_phosphate=no_5_phosphate,
            separate=separate,
        )
    _fold_each(screen, files, out, options, Written(plot, whole, build, page))


def _fold_many(
    screen: Screen,
    files: list[str],
    out: Path,
    options: "FoldOptions",
    shown: dict[str, bool],
    jobs: int,
    scheduler: str | None,
) -> None:
    from loopelastica.batch.folds import FOLDS
    from loopelastica.batch.run import run
    from loopelastica.batch.tasks import tasks_of
    from loopelastica.folding.like import file_of
    from loopelastica.molecule.folders import distinct

    files, notes = distinct(files)
    with o.usage():
        beside = (file_of(options.like), options.library)
        tasks = tasks_of(files, {**options.to_dict(), **shown}, out, beside)
        progress, page = not screen.quiet, shown["report"]
        done = run(FOLDS, tasks, out, jobs, scheduler, progress, in_options, page)
    rows = list(done.rows)
    if done.n_files > 1 or done.n_resumed:
        screen.show(
            f"{done.n_files} files ({done.n_resumed} were done before), {done.n_rows} candidates"
            f" in {done.table}",
            "",
        )
    said = [*notes, *done.notes]
    _end(screen, files, out, options, rows, said, done.failed, done.page)


@dataclass
class _Results:
    """What became of the files: for the tables, and to be said."""

    rows: list[dict[str, Any]] = field(default_factory=list)
    failures: list[dict[str, str]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    n_done: int = 0

    def failed(self, file: str, sentence: str) -> None:
        """Keep what has failed, with options as they are called on the command line."""
        self.failures.append({"file": file, "failure": in_options(sentence)})

    def write(self, out: Path, report: bool) -> Path | None:
        """Write the tables, as a run over many files does, and the page if there is to be one."""
        from loopelastica.batch.folds import write_tables

        return write_tables(out, self.rows, self.failures, report)


def _fold_each(
    screen: Screen, files: list[str], out: Path, options: "FoldOptions", written: "Written"
) -> None:
    from loopelastica._files import OutputError
    from loopelastica._progress import progress_bar
    from loopelastica.batch.folds import fold_into
    from loopelastica.batch.lock import alone_in
    from loopelastica.batch.run import check_tables
    from loopelastica.batch.workers import attempt
    from loopelastica.molecule.folders import distinct
    from loopelastica.report.folder import Folders

    files, notes = distinct(files)
    results, folders = _Results(notes=notes), Folders(out)

    def fold_next(file: str) -> dict[str, Any]:
        return fold_into(folders, file, options, written)

    with alone_in(out):
        check_tables(out, "summary")
        try:
            several = len(files) > 1 and not screen.quiet
            for file in progress_bar(files, shown=several, unit="file", leave=False):
                outcome = attempt(fold_next, file)
                record = outcome.value or {"rows": [], "failures": [outcome.failure], "notes": []}
                results.rows += [{**row, "file": file} for row in record["rows"]]
                results.notes += record["notes"]
                for sentence in record["failures"]:
                    results.failed(file, sentence)
                results.n_done += 1
        except KeyboardInterrupt:
            results.write(out, written.report)
            raise KeyboardInterrupt(
                f"{results.n_done} of {len(files)} files are done; the same command folds all of"
                " them again, with --jobs 1 it goes on where it was stopped"
            ) from None
        except OutputError:
            # the disk is full: the folders that are there keep their rows, if those still fit
            with suppress(OutputError):
                results.write(out, written.report)
            raise
        page = results.write(out, written.report)
    _end(screen, files, out, options, results.rows, results.notes, results.failures, page)


def _end(
    screen: Screen,
    files: list[str],
    out: Path,
    options: "FoldOptions",
    rows: "Sequence[Row]",
    notes: list[str],
    failures: "Sequence[Row]",
    page: Path | None,
) -> None:
    """Say what was folded and what was not."""
    from loopelastica.report.documents import fold_documents
    from loopelastica.report.screen.folds import fold_screen

    shown = ({**row, "file": Path(row["file"]).name} for row in rows)
    screen.show(*fold_screen(shown, str(out), options.rank))
    if rows:
        screen.show(
            "",
            f"Written to {out}: a folder per loop, with ranking.csv, traces.pdb and view.pml for"
            " PyMOL, and summary.csv, a row per candidate."
            + o.page_text(page)
            + o.failures_text(len(failures)),
        )
    screen.note([*notes, *o.of_earlier_runs(out, rows)], "in the loops' ranking.json", files)
    screen.end(
        fold_documents(out, rows) if screen.as_json else (),
        failures,
        f"in {out / 'failures.csv'}",
        parameters=options.to_dict(),
        folder=str(out),
    )
