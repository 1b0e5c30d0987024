"""Options that commands share, and how a refusal becomes a sentence and an exit status.

A sentence goes to the standard error; :mod:`loopelastica.cli.program` has the exit statuses.
"""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from loopelastica._names import printable
from loopelastica.cli.program import in_options
from loopelastica.cli.screen import Screen

# as they are given: a path object would drop a leading ./
Files = Annotated[
    list[str],
    typer.Argument(
        metavar="FILES",
        help="PDB or mmCIF files, gzipped or not, and folders of them.",
        show_default=False,
    ),
]
# headings of the help, in their order
SELECT, ROD, SHAPES = "Which loops", "Rod", "Shapes and their order"
ATOMS, WRITE, MANY, SAY = "Atoms", "Results", "Many and large files", "Screen"

Out = Annotated[
    Path,
    typer.Option("-o", "--out", help="Folder for the results.", rich_help_panel=WRITE),
]
OUT = Path("loopelastica-out")

Quiet = Annotated[
    bool,
    typer.Option("--quiet", "-q", help="Print nothing but what has failed.", rich_help_panel=SAY),
]
AsJson = Annotated[
    bool,
    typer.Option("--json", help="Print one JSON document instead of tables.", rich_help_panel=SAY),
]

Irregular = Annotated[
    bool,
    typer.Option(
        "--irregular",
        help="Fold loops on stems that are no A or B helix too.",
        rich_help_panel=SELECT,
    ),
]
Pairs = Annotated[
    list[str] | None,
    typer.Option(
        "--pair",
        help="A pair known from other data, such as A.12-A.25; repeatable.",
        rich_help_panel=SELECT,
    ),
]
Brackets = Annotated[
    str | None,
    typer.Option(
        "--dot-bracket",
        help="Secondary structure in place of the pairs of the coordinates, all nucleotides of the"
        " file in their order.",
        rich_help_panel=SELECT,
    ),
]
Loops = Annotated[
    list[str] | None,
    typer.Option(
        "--loop",
        help="Only this loop, by its first and last nucleotide, such as A.13-24; repeatable. It may"
        " be absent from the file, then the numbers give its length.",
        rich_help_panel=SELECT,
    ),
]

MaxSize = Annotated[
    float | None,
    typer.Option(
        "--max-size",
        help="Largest file that is read, MB after decompression; default 500.",
        rich_help_panel=MANY,
    ),
]
MaxAtoms = Annotated[
    int | None,
    typer.Option(
        help="Most atoms of a model that is read; default 1,000,000.", rich_help_panel=MANY
    ),
]

Darboux = Annotated[
    bool,
    typer.Option(
        "--darboux/--free-spin",
        help="Clamp the direction to the helix axis too, or let the end turn freely.",
        rich_help_panel=ROD,
    ),
]
TorsionRatio = Annotated[
    float | None,
    typer.Option(
        help="K3/K0 of the backbone, with --darboux; default 1.",
        show_default=False,
        rich_help_panel=ROD,
    ),
]
LengthPerNucleotide = Annotated[
    float | None,
    typer.Option(
        help="Line length per nucleotide in Å; default 6.0 (RNA), 6.3 (DNA).", rich_help_panel=ROD
    ),
]
StemExtend5 = Annotated[
    int | None,
    typer.Option(
        help="Nucleotides that continue the 5' strand; default by length.",
        min=0,
        rich_help_panel=ROD,
    ),
]
StemExtend3 = Annotated[
    int | None,
    typer.Option(
        help="Nucleotides that continue the 3' strand; default by length.",
        min=0,
        rich_help_panel=ROD,
    ),
]
Taper = Annotated[
    float | None,
    typer.Option(
        help="Radius lost per nucleotide on the 3' strand; default 0.2 (RNA), 0 (DNA).",
        rich_help_panel=ROD,
    ),
]
PersistenceLength = Annotated[
    float,
    typer.Option(help="Persistence length in Å that turns E/K0 into kT.", rich_help_panel=ROD),
]
EnergyMax = Annotated[
    float | None,
    typer.Option(
        help="List shapes up to this energy, in K0 per loop length.", rich_help_panel=SHAPES
    ),
]
Candidates = Annotated[
    int, typer.Option(help="Shapes kept per loop.", min=1, rich_help_panel=SHAPES)
]
Rank = Annotated[
    str,
    typer.Option(
        help="Order of the shapes: 'default', measured to be the best one, or 'energy', least"
        " deformation energy per length first.",
        rich_help_panel=SHAPES,
    ),
]
Like = Annotated[
    str | None,
    typer.Option(
        help="Structure file whose loop this one is like, FILE, or one of its loops by the closing"
        " pair, FILE:A.4-A.9.",
        show_default=False,
        rich_help_panel=SHAPES,
    ),
]
Library = Annotated[
    str | None,
    typer.Option(
        help="Library of loops; default: the one that comes along.",
        show_default=False,
        rich_help_panel=SHAPES,
    ),
]
ExcludeRelatives = Annotated[
    bool,
    typer.Option(
        "--exclude-relatives", help="Use no shape of a related loop.", rich_help_panel=SHAPES
    ),
]
Shapes = Annotated[
    str,
    typer.Option(
        help="'all', or 'rod': only rods by the rule, no shapes of other loops.",
        rich_help_panel=SHAPES,
    ),
]
Around = Annotated[
    bool,
    typer.Option(
        "--surroundings/--no-surroundings",
        help="Where other atoms are near, fold the loop as a rod in its surroundings too.",
        rich_help_panel=SHAPES,
    ),
]
AllModels = Annotated[
    bool,
    typer.Option(
        "--all-models/--first-model", help="Fold every model of the file.", rich_help_panel=SELECT
    ),
]
Plot = Annotated[bool, typer.Option(help="Draw plot.png.", rich_help_panel=WRITE)]
Report = Annotated[
    bool | None,
    typer.Option(
        "--report/--no-report",
        help="Make report.html, every loop in 3D with the tables of the run; by default where"
        " plotly is installed (extra `report`).",
        show_default=False,
        rich_help_panel=WRITE,
    ),
]
Whole = Annotated[
    bool | None,
    typer.Option(
        "--whole/--no-whole",
        help="Write whole.pdb, the structure with the trace in place; by default up to"
        " 20,000 atoms.",
        show_default=False,
        rich_help_panel=WRITE,
    ),
]
Contact = Annotated[
    str | None,
    typer.Option(
        help="With atoms, seek a 'sheared' or 'watson-crick' pair of the loop's ends.",
        rich_help_panel=ATOMS,
    ),
]

Hydrogens = Annotated[
    bool,
    typer.Option(
        "--hydrogens",
        help="With atoms, give every nucleotide its hydrogens; without, nothing in the files has"
        " any.",
        rich_help_panel=ATOMS,
    ),
]
Names = Annotated[
    str,
    typer.Option(
        help="With atoms, names of nucleotides and their atoms: 'pdb', 'amber' or 'charmm'.",
        rich_help_panel=ATOMS,
    ),
]
NoPhosphate = Annotated[
    bool,
    typer.Option(
        "--no-5-phosphate",
        help="With atoms, take off phosphates at 5' ends of chains, which force fields refuse.",
        rich_help_panel=ATOMS,
    ),
]
Separate = Annotated[
    bool,
    typer.Option(
        "--separate",
        help="With atoms, write each candidate into files of its own too.",
        rich_help_panel=ATOMS,
    ),
]

Jobs = Annotated[
    int | None,
    typer.Option(
        help="Processes of a local dask cluster (extra `scale`); resumable.",
        min=1,
        rich_help_panel=MANY,
    ),
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        help="Address of a running dask scheduler, tcp://…; resumable.", rich_help_panel=MANY
    ),
]


def limits(max_size: float | None, max_atoms: int | None) -> dict[str, Any]:
    """The limits of a file that are given, by the names of Python's options."""
    named = {"max_size_MB": max_size, "max_atoms": max_atoms}
    return {name: value for name, value in named.items() if value is not None}


def has_report(requested: bool | None) -> bool:
    """Whether a run ends with a page: as requested, by default where plotly is installed."""
    from loopelastica.report.page.write import check_available, is_available

    if requested:
        check_available()
    return is_available() if requested is None else requested


def of_earlier_runs(
    out: Path, rows: Iterable[Mapping[str, Any]], manifest: str = "ranking.json"
) -> list[str]:
    """A note that names what lies in the folder besides the results of this run.

    Parameters
    ----------
    out : Path
        Folder of the run.
    rows : iterable of mapping
        Those of its table.
    manifest : str
        File that each folder of a result has.

    Returns
    -------
    list of str
    """
    from loopelastica.molecule.nucleotides import enumerated
    from loopelastica.report.folder import other_folders

    others = other_folders(out, {row["folder"] for row in rows}, manifest)
    if not others:
        return []
    names = enumerated(others)
    return [f"{out} holds results of earlier runs that are not in summary.csv: {names}"]


def failures_text(count: int) -> str:
    """What is said of failures behind the files that were written."""
    rows = "1 row" if count == 1 else f"{count} rows"
    return f" What failed is in failures.csv, {rows}." if count else ""


def page_text(page: Path | None) -> str:
    """What is said of the page of a run behind the other files."""
    return "" if page is None else f" {page.name} shows it all."


@contextmanager
def usage() -> Iterator[None]:
    """An argument out of range ends the program with exit status 2."""
    try:
        yield
    except ValueError as error:
        raise typer.BadParameter(printable(in_options(str(error)))) from None


@contextmanager
def study(out: Path, screen: Screen) -> Iterator[None]:
    """Make the folder before the study, keep other runs out of it, and say where it is."""
    from loopelastica.batch.lock import alone_in

    with alone_in(out):
        yield
    screen.show(f"written to {out}")


def either(jobs: int | None, scheduler: str | None) -> tuple[bool, str]:
    """The rule that workers are those of a cluster of one's own or of another."""
    return jobs is not None and scheduler is not None, "--jobs goes without --scheduler"


def refuse(*rules: tuple[bool, str]) -> None:
    """End the program with exit status 2 for the first rule that holds.

    Parameters
    ----------
    *rules : (bool, str)
        Whether options are given that do not go together, and a sentence.
    """
    for broken, sentence in rules:
        if broken:
            raise typer.BadParameter(sentence)
