"""The command line. Heavy modules are imported inside the commands that need them."""

import logging
from typing import Annotated

import typer

from loopelastica.cli.bench import bench
from loopelastica.cli.build import build
from loopelastica.cli.evaluate import evaluate
from loopelastica.cli.fill import fill
from loopelastica.cli.fold import fold
from loopelastica.cli.library import library
from loopelastica.cli.origami import origami
from loopelastica.cli.program import EPILOG, Command, Program
from loopelastica.cli.rod import solve, warm
from loopelastica.cli.structure import hairpins, scan
from loopelastica.cli.studies import studies

app = typer.Typer(
    cls=Program,
    help="Folds nucleic-acid hairpin loops as elastic rods clamped to their stems.",
    epilog=EPILOG,
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
    # plain help takes half the time of the coloured one
    rich_markup_mode=None,
)
for command in (fold, fill, build, origami, evaluate, scan, hairpins, solve, warm):
    app.command(cls=Command)(command)
app.add_typer(library, name="library")
app.add_typer(bench, name="bench")
app.add_typer(studies, name="studies")


def _version(requested: bool) -> None:
    if requested:
        from loopelastica._version import __version__

        typer.echo(f"loopelastica {__version__}")
        raise typer.Exit


@app.callback()
def _main(
    version: Annotated[
        bool,
        typer.Option(
            "-V", "--version", callback=_version, is_eager=True, help="Print the version."
        ),
    ] = False,
) -> None:
    # what the package has to say while it works
    logger = logging.getLogger("loopelastica")
    logger.setLevel(logging.INFO)
    logger.handlers = [logging.StreamHandler()]


if __name__ == "__main__":
    app()
