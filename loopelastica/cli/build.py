"""``loopelastica build``: hairpins from their sequences, one or those of a FASTA file."""

import os
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from loopelastica.cli import options as o
from loopelastica.cli.program import in_options

if TYPE_CHECKING:
    from loopelastica.atoms.hairpin import FoldedHairpin
    from loopelastica.atoms.sequence import HairpinSequence
    from loopelastica.folding.result import LoopFold
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
    hydrogens: Annotated[
        bool, typer.Option("--hydrogens", help="Give all nucleotides their hydrogens.")
    ] = False,
    names: Annotated[
        str,
        typer.Option(help="Names of nucleotides and atoms in the files: 'pdb', 'amber', 'charmm'."),
    ] = "pdb",
    plot: o.Plot = True,
    contact: o.Contact = None,
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
    files = {"hydrogens": hydrogens, "names": names}
    options = _Options(rna, candidates, phosphate, mismatches, plot, contact, files)
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
    contact: str | None
    files: dict[str, Any]


def _is_path(text: str) -> bool:
    try:
        return os.path.exists(text) or _PATH.search(text) is not None
    except ValueError:  # a null character
        return False


def _build_one(hairpin: "HairpinSequence", out: Path, options: _Options) -> None:
    from loopelastica._files import make_folder
    from loopelastica.report.folder import Folders
    from loopelastica.report.tables import console, fold_table

    folded = _folded(hairpin, options)
    make_folder(out)
    folder = _write(hairpin.letters, folded, Folders(out), options)
    console().print(fold_table([(hairpin.letters, folded.fold, folder)]))
    o.note(folded.structure.remarks)


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
    from loopelastica.report.tables import console, fold_table

    entries = read_fasta(path)
    folders = Folders(out)
    rows: list[dict[str, Any]] = []
    failures: list[dict[str, str]] = []
    shown: list[tuple[str, LoopFold | str, Path | None]] = []
    notes: list[str] = []

    def build_next(entry: Entry) -> None:
        read = read_sequence(entry.text, rna=options.rna, mismatches=options.mismatches)
        folded = _folded(read, options)
        folder = _write(entry.name, folded, folders, options)
        rows.extend({**r, "folder": folder.name} for r in loop_rows(entry.name, folded.fold))
        shown.append((entry.name, folded.fold, folder))
        notes.extend(f"{entry.name}: {remark}" for remark in folded.structure.remarks)

    with alone_in(out):
        check_tables(out, "summary")
        try:
            for entry in tqdm(entries, disable=len(entries) < 2, unit="hairpin", leave=False):
                said = attempt(build_next, entry).failure
                if said is not None:
                    failure = in_options(said.removeprefix(f"{entry}: "))
                    failures.append({"file": entry.name, "failure": f"{entry}: {failure}"})
                    shown.append((entry.name, failure, None))
        finally:
            # what is done has its rows, however the run ends
            write_csv(out / "summary.csv", rows, COLUMNS)
            write_csv(out / "failures.csv", failures, FAILURE_COLUMNS)
    console().print(fold_table(shown))
    o.note(notes)
    o.fail_of_many([failure["failure"] for failure in failures], out)


def _folded(hairpin: "HairpinSequence", options: _Options) -> "FoldedHairpin":
    from loopelastica.atoms.hairpin import fold_sequence

    return fold_sequence(hairpin, max_candidates=options.candidates, phosphate=options.phosphate)


def _write(name: str, folded: "FoldedHairpin", folders: "Folders", options: _Options) -> Path:
    """Build the atoms and write the folder of one hairpin."""
    from loopelastica._names import safe_name
    from loopelastica.cli.atoms import atoms_of
    from loopelastica.report.folder import write_fold

    built = atoms_of(folded.structure, folded.fold, folded.positions_A, options.contact)
    built = replace(built, **options.files)
    # a name has no suffix, whatever dots are in it
    folder = folders.claim(Path(f"{safe_name(name, 150)}.fasta"), folded.fold)
    source = str(folded.sequence)
    write_fold(folder, source, folded.fold, folded.structure, options.plot, atoms=built)
    return folder
