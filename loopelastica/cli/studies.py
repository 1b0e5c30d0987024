"""``loopelastica studies``: the numbers of the package made anew from structures, and judged."""

from pathlib import Path
from typing import Annotated

import typer

from loopelastica.cli import options as o
from loopelastica.cli.program import Command
from loopelastica.cli.screen import Screen, fail

studies = typer.Typer(
    help="Make the tables of the package anew; say how good they are.", no_args_is_help=True
)


@studies.command("motifs", cls=Command)
def study_motifs(
    folder: Annotated[Path, typer.Argument(help="Folder of structure files.", show_default=False)],
    out: Annotated[Path, typer.Option("-o", "--out", help="Folder for the results.")] = Path(
        "loopelastica-studies/motifs"
    ),
    quiet: o.Quiet = False,
) -> None:
    """Shapes of loops by motif and length, and a library.

    And the errors to expect of answers.

    Where the folder holds loops.csv, that says which loop of a file counts, which make a pair
    elsewhere, and which are of one family; else all hairpin loops count, and relatives are those by
    sequence.
    """
    from loopelastica.molecule.folders import structure_files
    from loopelastica.report.screen.markdown import markdown_screen
    from loopelastica.studies.motifs.study import run

    screen = Screen("studies motifs", "tables", quiet)
    with o.usage():
        structure_files(folder)  # before a folder is made
    with o.study(out, screen):
        done = run(folder, out, progress=not quiet)
        screen.show(*markdown_screen(done.tables))
    fail(done.failures, f"in {out / 'motifs.md'}")
