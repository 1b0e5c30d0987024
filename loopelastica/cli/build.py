"""``loopelastica build``: hairpins from their sequences, one or those of a FASTA file."""

import os
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from loopelastica.cli import options as o
from loopelastica.cli.program import in_options
from loopelastica.cli.screen import Screen

if TYPE_CHECKING:
    from loopelastica.atoms.hairpin import FoldedHairpin
    from loopelastica.atoms.sequence import HairpinSequence
    from loopelastica.molecule.fasta import Entry
    from loopelastica.report.atoms import LoopAtoms
    from loopelastica.report.folder import Folders

# what has a folder or a suffix in it is meant as a path
_PATH = re.compile(r"[/\\]|\.[A-Za-z]\w*$")


def build(
    sequence: Annotated[
        str,
        typer.Argument(
            help='Stem and loop, such as "GGCAC(UUCG)GUGCC", modified nucleotides in square'
            ' brackets, "GG[5MC]A(UUCG)UGCC"; or a FASTA file of hairpins.',
            show_default=False,
        ),
    ],
    structure: Annotated[
        str | None,
        typer.Argument(
            help='Dot-bracket of a sequence without brackets, such as "(((((....)))))".',
            show_default=False,
        ),
    ] = None,
    out: o.Out = o.OUT,
    rna: Annotated[
        bool | None,
        typer.Option("--rna/--dna", help="A-RNA or B-DNA; by default U or T decides."),
    ] = None,
    candidates: o.Candidates = 10,
    phosphate: Annotated[
        bool, typer.Option("--5-phosphate", help="Put a phosphate at the 5' end.")
    ] = False,
    mismatches: Annotated[
        bool,
        typer.Option(
            "--mismatches", help="Take nucleotides that do not pair into the stem, where they fit."
        ),
    ] = False,
    contact: o.Contact = None,
    hydrogens: o.Hydrogens = False,
    names: o.Names = "pdb",
    separate: o.Separate = False,
    plot: o.Plot = True,
    report: o.Report = None,
    quiet: o.Quiet = False,
    as_json: o.AsJson = False,
) -> None:
    """Build hairpins from their sequences alone.

    Each has an ideal stem, a folded loop and atoms, and gets a folder; the folder for the results
    gets summary.csv, a row per candidate, and failures.csv.
    """
    from loopelastica.atoms.conventions import check_names
    from loopelastica.atoms.sequence import read_sequence
    from loopelastica.atoms.turn import check_contact
    from loopelastica.molecule.fasta import Entry, read_fasta

    screen = Screen("build", "loops", quiet, as_json)
    with o.usage():
        check_contact(contact)
        check_names("names", names)
    written = {"hydrogens": hydrogens, "names": names, "separate": separate}
    page = o.has_report(report)
    options = _Options(
        rna, candidates, phosphate, mismatches, plot, page, contact, not quiet, written
    )
    if _is_path(sequence):
        o.refuse((structure is not None, "STRUCTURE goes without a FASTA file"))
        read = partial(_read_entry, options=options)
        _build_all(screen, read_fasta(Path(sequence)), read, out, options)
    else:
        # of one sequence a mistake is one of usage, and nothing is written
        with o.usage():
            hairpin = read_sequence(sequence, structure, rna=rna, mismatches=mismatches)
        _build_all(screen, [Entry(hairpin.letters, sequence)], lambda _: hairpin, out, options)


@dataclass(frozen=True)
class _Options:
    rna: bool | None
    candidates: int
    phosphate: bool
    mismatches: bool
    plot: bool
    report: bool
    contact: str | None
    progress: bool
    written: dict[str, Any]


class _Built(NamedTuple):
    """One hairpin that is done."""

    name: str
    atoms: "LoopAtoms"
    folder: Path

    @property
    def failure(self) -> str | None:
        """Why nothing of it can be used."""
        if self.atoms.written:
            return None
        return f"{self.name}: no candidate is sound; {self.folder / 'atoms.json'} says why"


def _is_path(text: str) -> bool:
    try:
        return os.path.exists(text) or _PATH.search(text) is not None
    except ValueError:  # a null character
        return False


def _read_entry(entry: "Entry", options: _Options) -> "HairpinSequence":
    from loopelastica.atoms.sequence import read_sequence

    return read_sequence(entry.text, rna=options.rna, mismatches=options.mismatches)


def _build_all(
    screen: Screen,
    entries: "Sequence[Entry]",
    read: "Callable[[Entry], HairpinSequence]",
    out: Path,
    options: _Options,
) -> None:
    """All hairpins; one that fails leaves the others alone."""
    from loopelastica._files import write_csv
    from loopelastica._progress import progress_bar
    from loopelastica.batch.folds import COLUMNS, loop_rows
    from loopelastica.batch.lock import alone_in
    from loopelastica.batch.run import FAILURE_COLUMNS, check_tables
    from loopelastica.batch.workers import attempt
    from loopelastica.report.folder import Folders
    from loopelastica.report.page.write import renew_report

    folders = Folders(out)
    done: list[_Built] = []
    rows: list[dict[str, Any]] = []
    failures: list[dict[str, str]] = []

    def build_next(entry: "Entry") -> _Built:
        return _write(entry.name, _folded(read(entry), options), folders, options)

    with alone_in(out):
        check_tables(out, "summary")
        try:
            several = options.progress and len(entries) > 1
            for entry in progress_bar(entries, shown=several, unit="hairpin", leave=False):
                outcome = attempt(build_next, entry)
                said, built = outcome.failure, outcome.value
                if built is not None:
                    done.append(built)
                    rows += [
                        {**row, **built.atoms.figures(row["rank"]), "folder": built.folder.name}
                        for row in loop_rows(entry.name, built.atoms.fold)
                    ]
                    said = built.failure
                if said is not None:
                    sentence = f"{entry}: {in_options(said.removeprefix(f'{entry}: '))}"
                    failures.append({"file": entry.name, "failure": sentence})
        finally:
            # what is done has its rows, however the run ends
            write_csv(out / "summary.csv", rows, COLUMNS)
            write_csv(out / "failures.csv", failures, FAILURE_COLUMNS)
            page = renew_report(out, options.report)
    _end(screen, out, done, rows, failures, page)


def _end(
    screen: Screen,
    out: Path,
    done: Sequence[_Built],
    rows: Sequence[dict[str, Any]],
    failures: Sequence[dict[str, str]],
    page: Path | None,
) -> None:
    """Say what was built and what was not."""
    from loopelastica.report.documents import fold_documents
    from loopelastica.report.screen.folds import fold_screen

    screen.show(*fold_screen(rows, str(out)))
    if rows:
        screen.show(
            "",
            f"Written to {out}: a folder per hairpin, with atoms.pdb, atoms.cif and ranking.csv,"
            " and summary.csv, a row per candidate."
            + o.page_text(page)
            + o.failures_text(len(failures)),
        )
    notes = [
        f"{built.name}: {remark}"
        for built in done
        for remark in (*built.atoms.structure.remarks, *built.atoms.remarks)
    ]
    names = [built.name for built in done] if len(done) + len(failures) == 1 else []
    screen.note(notes, "in the hairpins' atoms.json", names)
    screen.end(
        fold_documents(out, rows) if screen.as_json else (),
        failures,
        f"in {out / 'failures.csv'}",
        folder=str(out),
    )


def _folded(hairpin: "HairpinSequence", options: _Options) -> "FoldedHairpin":
    from loopelastica.atoms.hairpin import fold_sequence

    return fold_sequence(hairpin, max_candidates=options.candidates, phosphate=options.phosphate)


def _write(name: str, folded: "FoldedHairpin", folders: "Folders", options: _Options) -> _Built:
    """Build the atoms and write the folder of one hairpin."""
    from loopelastica._names import safe_name
    from loopelastica.cli.atoms import atoms_of
    from loopelastica.molecule.setting import Settings
    from loopelastica.report.folder import write_fold

    structure, fold = folded.structure, folded.fold
    atoms = atoms_of(
        structure,
        fold,
        folded.positions_A,
        contact=options.contact,
        progress=options.progress,
        **options.written,
    )
    # a name has no suffix, whatever dots are in it
    folder = folders.claim(Path(f"{safe_name(name, 150)}.fasta"), fold)
    settings = Settings(structure, folded.positions_A)
    write_fold(
        folder, str(folded.sequence), fold, structure, options.plot, atoms=atoms,
        settings=settings, report=options.report,
    )  # fmt: skip
    return _Built(name, atoms, folder)
