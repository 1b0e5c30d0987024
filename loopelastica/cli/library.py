"""``loopelastica library``: loop shapes of many files in one, and what is in it."""

from pathlib import Path
from typing import Annotated

import typer

from loopelastica.cli import options as o
from loopelastica.cli.program import Command, in_options
from loopelastica.cli.screen import Screen

library = typer.Typer(help="Keep loop shapes of many structures in one file.", no_args_is_help=True)


@library.command("build", cls=Command)
def build_library(
    sources: Annotated[
        list[str],
        typer.Argument(
            help="Folders of PDB and mmCIF files, gzipped or not, or such files.",
            show_default=False,
        ),
    ],
    out: Annotated[Path, typer.Option("-o", "--out", help="The library.")] = Path("loops.lib"),
    with_contacts: Annotated[
        bool, typer.Option("--with-contacts", help="Take loops that make a pair elsewhere too.")
    ] = False,
    max_size: o.MaxSize = None,
    max_atoms: o.MaxAtoms = None,
    jobs: o.Jobs = None,
    scheduler: o.Scheduler = None,
    quiet: o.Quiet = False,
    as_json: o.AsJson = False,
) -> None:
    """Make a library of the hairpin loops of many files.

    It takes loops of 3 to 12 nucleotides. Beside it a folder, loops.lib.run, gets loops.csv, a row
    per loop, and failures.csv. The same command resumes a run that was stopped.
    """
    from loopelastica.batch.shapes import build_library as build
    from loopelastica.molecule.nucleotides import Limits
    from loopelastica.report.documents import library_rows

    screen = Screen("library build", "kinds", quiet, as_json)
    o.refuse(o.either(jobs, scheduler))
    with o.usage():
        done = build(
            sources,
            out,
            with_contacts=with_contacts,
            jobs=jobs or 1,
            scheduler=scheduler,
            progress=not quiet,
            limits=Limits(**o.limits(max_size, max_atoms)),
            wording=in_options,
        )
    files = "1 file" if done.n_files == 1 else f"{done.n_files} files"
    loops = "1 loop" if len(done.library) == 1 else f"{len(done.library)} loops"
    screen.show(f"{files} ({done.n_resumed} done before), {loops} in {out}")
    screen.note(done.notes, "of the kind")
    rest = f"in {done.table.parent / 'failures.csv'}"
    kinds = library_rows(done.library) if as_json else ()
    screen.end(kinds, done.failed, rest, library=str(out), table=str(done.table))


@library.command("list", cls=Command)
def list_library(
    file: Annotated[Path, typer.Argument(help="A library.", show_default=False)],
    quiet: o.Quiet = False,
    as_json: o.AsJson = False,
) -> None:
    """Show what a library holds, by kind and length."""
    from loopelastica.folding.library_file import load_library
    from loopelastica.report.documents import library_rows
    from loopelastica.report.screen.tables import library_table

    screen = Screen("library list", "kinds", quiet, as_json)
    rows = library_rows(load_library(file))
    screen.show(library_table(rows))
    screen.end(rows)
