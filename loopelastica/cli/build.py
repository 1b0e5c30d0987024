"""``loopelastica build``: hairpins from their sequences, one or those of a FASTA file."""

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from loopelastica.cli import options as o
from loopelastica.cli.program import in_options

if TYPE_CHECKING:
    from loopelastica.atoms.hairpin import FoldedHairpin
    from loopelastica.atoms.sequence import HairpinSequence
    from loopelastica.folding.result import LoopFold
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
) -> None:
    """Build hairpins from their sequences alone: ideal stem, folded loop, atoms.

    Of a FASTA file each hairpin gets a folder; the folder for the results gets summary.csv, a row
    per candidate, and failures.csv.
    """
    from loopelastica.atoms.conventions import check_names
    from loopelastica.atoms.sequence import read_sequence
    from loopelastica.atoms.turn import check_contact

    with o.usage():
        check_contact(contact)
        check_names("names", names)
    written = {"hydrogens": hydrogens, "names": names, "separate": separate}
    page = o.has_report(report)
    options = _Options(rna, candidates, phosphate, mismatches, plot, page, contact, written)
    if _is_path(sequence):
        o.refuse((structure is not None, "STRUCTURE goes without a FASTA file"))
        _build_all(Path(sequence), out, options)
    else:
        with o.usage():
            hairpin = read_sequence(sequence, structure, rna=rna, mismatches=mismatches)
        _build_one(hairpin, out, options)


@dataclass(frozen=True)
class _Options:
    rna: bool | None
    candidates: int
    phosphate: bool
    mismatches: bool
    plot: bool
    report: bool
    contact: str | None
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


def _build_one(hairpin: "HairpinSequence", out: Path, options: _Options) -> None:
    from loopelastica._files import make_folder
    from loopelastica.report.folder import Folders
    from loopelastica.report.page.write import renew_report

    folded = _folded(hairpin, options)
    make_folder(out)
    built = _write(hairpin.letters, folded, Folders(out), options)
    _show([built], [])
    o.tell_report(renew_report(out, options.report))
    o.note([*folded.structure.remarks, *built.atoms.remarks])
    o.fail([built.failure] if built.failure else [])


def _build_all(path: Path, out: Path, options: _Options) -> None:
    """All hairpins of a FASTA file; one that fails leaves the others alone."""
    from tqdm import tqdm

    from loopelastica._files import write_csv
    from loopelastica.atoms.sequence import read_sequence
    from loopelastica.batch.folds import COLUMNS, loop_rows
    from loopelastica.batch.lock import alone_in
    from loopelastica.batch.run import FAILURE_COLUMNS, check_tables
    from loopelastica.batch.workers import attempt
    from loopelastica.molecule.fasta import Entry, read_fasta
    from loopelastica.report.folder import Folders
    from loopelastica.report.page.write import renew_report

    entries, folders = read_fasta(path), Folders(out)
    done: list[_Built] = []
    rows: list[dict[str, Any]] = []
    failures: list[dict[str, str]] = []

    def build_next(entry: Entry) -> _Built:
        read = read_sequence(entry.text, rna=options.rna, mismatches=options.mismatches)
        return _write(entry.name, _folded(read, options), folders, options)

    with alone_in(out):
        check_tables(out, "summary")
        try:
            for entry in tqdm(entries, disable=len(entries) < 2, unit="hairpin", leave=False):
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
    _show(done, [failure["file"] for failure in failures])
    o.tell_report(page)
    o.note(
        [
            f"{built.name}: {remark}"
            for built in done
            for remark in (*built.atoms.structure.remarks, *built.atoms.remarks)
        ]
    )
    o.fail_of_many([failure["failure"] for failure in failures], out)


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
    atoms = atoms_of(structure, fold, folded.positions_A, options.contact, **options.written)
    # a name has no suffix, whatever dots are in it
    folder = folders.claim(Path(f"{safe_name(name, 150)}.fasta"), fold)
    settings = Settings(structure, folded.positions_A)
    write_fold(
        folder, str(folded.sequence), fold, structure, options.plot, atoms=atoms,
        settings=settings, report=options.report,
    )  # fmt: skip
    return _Built(name, atoms, folder)


def _show(done: "Sequence[_Built]", failed: Sequence[str]) -> None:
    from loopelastica.report.tables import atoms_table, console, fold_table

    shown: list[tuple[str, LoopFold | str, Path | None]] = []
    shown += [(built.name, built.atoms.fold, built.folder) for built in done]
    shown += [(name, "", None) for name in failed if name not in {built.name for built in done}]
    console().print(fold_table(shown))
    if done:
        console().print(atoms_table([(built.name, built.atoms) for built in done]))
