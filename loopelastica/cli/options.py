"""Options that commands share, and how a refusal becomes a sentence and an exit status.

A sentence goes to the standard error. The exit status is 1 where the input cannot be used, 2 where
an argument or an option is wrong.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

Files = Annotated[
    list[Path], typer.Argument(help="PDB or mmCIF files, gzipped or not.", show_default=False)
]
File = Annotated[Path, typer.Argument(help="PDB or mmCIF file.", show_default=False)]
Out = Annotated[Path, typer.Option("-o", "--out", help="Folder for the results.")]
OUT = Path("loopelastica-out")

Irregular = Annotated[
    bool, typer.Option("--irregular", help="Fold loops on stems that are no A or B helix too.")
]
Pairs = Annotated[
    list[str] | None,
    typer.Option("--pair", help="A pair known from other data, such as A.12-A.25; repeatable."),
]
Brackets = Annotated[
    str | None,
    typer.Option(
        "--dot-bracket",
        help="Secondary structure in place of the pairs of the coordinates, all nucleotides of the"
        " file in their order.",
    ),
]
Loops = Annotated[
    list[str] | None,
    typer.Option(
        "--loop",
        help="Only this loop, by its first and last nucleotide, such as A.13-24; repeatable. It may"
        " be absent from the file, then the numbers give its length.",
    ),
]

MaxSize = Annotated[
    float | None,
    typer.Option(
        "--max-size", help="Largest file that is read, MB after decompression; default 500."
    ),
]
MaxAtoms = Annotated[
    int | None, typer.Option(help="Most atoms of a model that is read; default 1,000,000.")
]

Darboux = Annotated[
    bool,
    typer.Option(
        "--darboux/--free-spin",
        help="Clamp the direction to the helix axis too, or let the end turn freely.",
    ),
]
TorsionRatio = Annotated[
    float | None,
    typer.Option(help="K3/K0 of the backbone, with --darboux; default 1.", show_default=False),
]
LengthPerNucleotide = Annotated[
    float | None,
    typer.Option(help="Line length per nucleotide in Å; default 6.0 (RNA), 6.3 (DNA)."),
]
StemExtend5 = Annotated[
    int | None,
    typer.Option(help="Nucleotides that continue the 5' strand; default by length.", min=0),
]
StemExtend3 = Annotated[
    int | None,
    typer.Option(help="Nucleotides that continue the 3' strand; default by length.", min=0),
]
Taper = Annotated[
    float | None,
    typer.Option(help="Radius lost per nucleotide on the 3' strand; default 0.2 (RNA), 0 (DNA)."),
]
PersistenceLength = Annotated[
    float, typer.Option(help="Persistence length in Å that turns E/K0 into kT.")
]
EnergyMax = Annotated[
    float | None, typer.Option(help="List shapes up to this energy, in K0 per loop length.")
]
Candidates = Annotated[int, typer.Option(help="Shapes kept per loop.", min=1)]
AllModels = Annotated[
    bool, typer.Option("--all-models/--first-model", help="Fold every model of the file.")
]
Plot = Annotated[bool, typer.Option(help="Draw plot.png.")]
Whole = Annotated[
    bool | None,
    typer.Option(
        "--whole/--no-whole",
        help="Write whole.pdb, the structure with the trace in place; by default up to"
        " 20,000 atoms.",
        show_default=False,
    ),
]
Contact = Annotated[
    str | None,
    typer.Option(help="With atoms, seek a 'sheared' or 'watson-crick' pair of the loop's ends."),
]

Jobs = Annotated[
    int | None,
    typer.Option(help="Processes of a local dask cluster (extra `scale`); resumable.", min=1),
]
Scheduler = Annotated[
    str | None, typer.Option(help="Address of a running dask scheduler, tcp://…; resumable.")
]


def limits(max_size: float | None, max_atoms: int | None) -> dict[str, Any]:
    """The limits of a file that are given, by the names of Python's options."""
    named = {"max_size_MB": max_size, "max_atoms": max_atoms}
    return {name: value for name, value in named.items() if value is not None}


@contextmanager
def usage() -> Iterator[None]:
    """An argument out of range ends the program with exit status 2."""
    from loopelastica.errors import MissingDependencyError

    try:
        yield
    except (ValueError, MissingDependencyError) as error:
        raise typer.BadParameter(str(error)) from None


@contextmanager
def refusals(file: Path) -> Iterator[None]:
    """A file that cannot be used ends the program with one sentence and exit status 1."""
    from loopelastica.errors import LoopelasticaError

    try:
        yield
    except LoopelasticaError as error:
        fail([str(error)])
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None
    except OSError as error:
        fail([f"{error.filename or file}: {error.strerror}"])


def fail(sentences: Sequence[str]) -> None:
    """Print what failed and exit with status 1; do nothing if nothing failed."""
    for sentence in sentences:
        typer.echo(sentence, err=True)
    if sentences:
        raise typer.Exit(1)


def fail_of_many(failures: Sequence[str], out: Path) -> None:
    """Print what failed in a run over many files, up to a screenful, and exit with status 1.

    Parameters
    ----------
    failures : sequence of str
        One sentence each.
    out : Path
        Folder of the run, whose failures.csv has them all.
    """
    shown = 20
    more = [f"{len(failures) - shown} more in {out / 'failures.csv'}"]
    fail([*failures[:shown], *(more if len(failures) > shown else [])])
