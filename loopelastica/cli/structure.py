"""``loopelastica hairpins`` and ``scan``: what a structure holds, and what its stems allow."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from loopelastica.cli import options as o
from loopelastica.cli.program import in_options
from loopelastica.cli.screen import Screen

if TYPE_CHECKING:
    from loopelastica.folding.scan import LoopScan

_Failures = list[dict[str, str]]


def hairpins(
    files: o.Files,
    pair: o.Pairs = None,
    dot_bracket: o.Brackets = None,
    loop: o.Loops = None,
    max_size: o.MaxSize = None,
    max_atoms: o.MaxAtoms = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--out",
            help="Write it all to this file as JSON.",
            show_default=False,
            rich_help_panel=o.WRITE,
        ),
    ] = None,
    quiet: o.Quiet = False,
    as_json: o.AsJson = False,
) -> None:
    """List the hairpin loops of files, and their dot-brackets.

    The document of --json has an entry in "files" for each: input, chains, modified residues,
    remarks and hairpins. The file of --out has the same; of a single file, its entry alone.
    """
    from loopelastica._files import write_json
    from loopelastica.folding.options import LoopOptions
    from loopelastica.molecule.folders import with_folders
    from loopelastica.molecule.hairpins import find_hairpins
    from loopelastica.molecule.nucleotides import Limits, read_structure
    from loopelastica.report.listing import listing

    if as_json and out is None and len(files) > 1 and files[-1].endswith(".json"):
        # as it was written when --json took the name of the file
        files, out, as_json = files[:-1], Path(files[-1]), False
    screen = Screen("hairpins", "files", quiet, as_json)
    with o.usage():
        limits = Limits(**o.limits(max_size, max_atoms))
        selection = LoopOptions(pair=pair or (), dot_bracket=dot_bracket, loop=loop or ()).selection

    def listed(file: str) -> dict[str, Any]:
        structure = read_structure(file, limits)
        content = listing(structure, find_hairpins(structure, **selection))
        return {"file": file, **content}

    given = with_folders(files)
    contents, failures = _each(screen, given, listed)
    for content in contents:
        if not content["hairpins"]:
            file = content["file"]
            failures.append({"file": file, "failure": f"{file}: no hairpin loop found"})
    if out is not None and contents:
        single = len(given) == 1 and given == files
        entry = {name: value for name, value in contents[0].items() if name != "file"}
        write_json(out, entry if single else {"files": contents})
    _show_hairpins(screen, contents)
    screen.end(contents, failures)


def _show_hairpins(screen: Screen, contents: Sequence[dict[str, Any]]) -> None:
    """Tables and brackets of each file, and what is odd about it."""
    if not screen.talks:
        return
    from rich.text import Text

    from loopelastica._names import printable
    from loopelastica.report.screen.tables import chain_lines, hairpins_table

    several = len(contents) > 1
    for content in contents:
        if several:
            screen.show(Text(printable(content["file"]), style="bold"))
        if content["hairpins"]:
            screen.show(hairpins_table(content["hairpins"]), "")
        for chain in content["chains"]:
            screen.lines(*chain_lines(chain))
        refused = [hairpin["refusal"] for hairpin in content["hairpins"] if hairpin["refusal"]]
        screen.note([*content["remarks"], *refused], "in the document of --json")
        screen.show(*[""] * several)


def scan(
    files: o.Files,
    out: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--out",
            help="Write all shapes to this table, *.csv, or to scan.csv in this folder.",
            show_default=False,
            rich_help_panel=o.WRITE,
        ),
    ] = None,
    extend_5: Annotated[
        int,
        typer.Option(help="Most nucleotides on the 5' strand.", min=0, rich_help_panel=o.ROD),
    ] = 2,
    extend_3: Annotated[
        int,
        typer.Option(help="Most nucleotides on the 3' strand.", min=0, rich_help_panel=o.ROD),
    ] = 3,
    taper: Annotated[
        list[float] | None,
        typer.Option(
            help="Tapers of the 3' strand; default 0 and 0.2.",
            show_default=False,
            rich_help_panel=o.ROD,
        ),
    ] = None,
    irregular: o.Irregular = False,
    pair: o.Pairs = None,
    dot_bracket: o.Brackets = None,
    loop: o.Loops = None,
    max_size: o.MaxSize = None,
    max_atoms: o.MaxAtoms = None,
    shown: Annotated[
        int, typer.Option(help="Shapes shown per loop.", min=1, rich_help_panel=o.SAY)
    ] = 20,
    quiet: o.Quiet = False,
    as_json: o.AsJson = False,
) -> None:
    """Solve every clamp that a stem allows, and rank the shapes.

    By energy, those that touch the stem or themselves last.
    """
    from loopelastica._files import write_csv
    from loopelastica.folding.options import ScanOptions
    from loopelastica.folding.scan import scan as scan_file
    from loopelastica.molecule.folders import with_folders
    from loopelastica.report.documents import scan_document
    from loopelastica.report.records import SCAN_COLUMNS, scan_rows
    from loopelastica.report.screen.scans import SCAN_LEGEND, scan_screen

    screen = Screen("scan", "loops", quiet, as_json)
    options = {
        "extend_5_max": extend_5,
        "extend_3_max": extend_3,
        "tapers": taper or (0.0, 0.2),
        "irregular": irregular,
        "pair": pair or (),
        "dot_bracket": dot_bracket,
        "loop": loop or (),
        **o.limits(max_size, max_atoms),
    }
    with o.usage():
        ScanOptions(**options)
    table = None if out is None else _scan_table(out)
    given = with_folders(files)
    found, failures = _each(screen, given, lambda file: (file, scan_file(file, **options)))
    scans: list[tuple[str, LoopScan]] = []
    for file, loops in found:
        if not loops:
            failures.append({"file": file, "failure": f"{file}: no hairpin loop found"})
        for scanned in loops:
            if scanned.failure:
                failures.append({"file": file, "failure": f"{file}: {scanned.failure}"})
            else:
                scans.append((file, scanned))
    if table is not None:
        rows = ({**row, "file": file} for file, scanned in scans for row in scan_rows(scanned))
        write_csv(table, rows, SCAN_COLUMNS)
    for file, scanned in scans:
        screen.show(*scan_screen(scanned, shown, Path(file).name if len(given) > 1 else ""))
    if scans:
        screen.show(SCAN_LEGEND)
    if table is not None:
        screen.show(f"Written to {table}: a row per shape.")
    screen.end(
        [scan_document(file, scanned) for file, scanned in scans] if as_json else (),
        failures,
        **({} if table is None else {"table": str(table)}),
    )


def _scan_table(out: Path) -> Path:
    """The table that is written, which replaces no file of others."""
    from loopelastica._files import make_folder, refuse_other

    table = out if out.suffix.lower() == ".csv" else out / "scan.csv"
    make_folder(table.parent)
    refuse_other(table, b"file,")
    return table


def _each(
    screen: Screen, files: Sequence[str], function: Callable[[str], Any]
) -> tuple[list[Any], _Failures]:
    """What becomes of each file, and of those that cannot be used a sentence."""
    from loopelastica._progress import progress_bar
    from loopelastica.batch.workers import attempt
    from loopelastica.errors import LoopelasticaError
    from loopelastica.molecule.folders import distinct

    if len(files) == 1:
        (file,) = files
        try:
            # what this file alone shows to be wrong is a mistake of usage
            with o.usage():
                return [function(file)], []
        except LoopelasticaError as error:
            return [], [{"file": file, "failure": in_options(str(error))}]
    found: list[Any] = []
    failures: _Failures = []
    files, notes = distinct(files)
    for file in progress_bar(files, shown=not screen.quiet, unit="file", leave=False):
        outcome = attempt(function, file)
        if outcome.failure is None:
            found.append(outcome.value)
        else:
            failures.append({"file": file, "failure": in_options(outcome.failure)})
    screen.note(notes, "of the kind")
    return found, failures
