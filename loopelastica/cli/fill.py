"""``loopelastica fill``: files with gaps to files without, one by one or on many processes."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from loopelastica.cli import options as o
from loopelastica.cli.program import in_options
from loopelastica.cli.screen import Screen

if TYPE_CHECKING:
    from loopelastica.batch.run import Run

_Strands = Annotated[
    list[str] | None,
    typer.Option(
        "--strand",
        help="Only this strand, by its first and last nucleotide, such as A.6-9, or with its"
        " sequence, A.6-9=UUCG; repeatable. One that is there is built anew.",
    ),
]
_Repair = Annotated[
    bool,
    typer.Option(
        "--repair",
        help="Build anew what is broken: bonds over 2 Å in a chain, wrong hands, clashes inside a"
        " strand. Without it no existing atom moves.",
    ),
]
_Hydrogens = Annotated[
    bool,
    typer.Option(
        "--hydrogens",
        help="Add hydrogens: to what is built where the file's other nucleotides have them, to"
        " every nucleotide where they have none.",
    ),
]
_NoPhosphate = Annotated[
    bool,
    typer.Option(
        "--no-5-phosphate",
        help="Take off phosphates at 5' ends of chains, which force fields refuse.",
    ),
]
_Like = Annotated[
    str | None,
    typer.Option(
        help="Strand of another structure that these are like, by the nucleotides before and after"
        " it, FILE:A.4-A.9; or FILE, any with the same letters, else its hairpin loops.",
        show_default=False,
    ),
]
_Library = Annotated[
    str | None,
    typer.Option(
        help="Library of loops, a file or a folder of structures: its shapes for strands whose ends"
        " are like those of a hairpin loop.",
        show_default=False,
    ),
]
_Candidates = Annotated[int, typer.Option(help="Most models per strand.", min=1)]


def fill(
    files: o.Files,
    out: o.Out = o.OUT,
    strand: _Strands = None,
    repair: _Repair = False,
    hydrogens: _Hydrogens = False,
    no_5_phosphate: _NoPhosphate = False,
    candidates: _Candidates = 1,
    like: _Like = None,
    library: _Library = None,
    max_size: o.MaxSize = None,
    max_atoms: o.MaxAtoms = None,
    report: o.Report = None,
    jobs: o.Jobs = None,
    scheduler: o.Scheduler = None,
    quiet: o.Quiet = False,
    as_json: o.AsJson = False,
) -> None:
    """Fill every internal gap of DNA and RNA chains.

    Each file gets a folder with filled.pdb or filled.cif, as it came, and fill.json; the folder for
    the results gets summary.csv, a row per strand, and failures.csv. The same command resumes a run
    that was stopped.
    """
    from loopelastica.batch.fills import FILLS
    from loopelastica.batch.run import run
    from loopelastica.batch.tasks import tasks_of
    from loopelastica.filling.options import FillOptions
    from loopelastica.folding.known import library_at
    from loopelastica.folding.like import check_strands, file_of
    from loopelastica.molecule.folders import distinct, with_folders
    from loopelastica.report.page.write import has_report

    screen = Screen("fill", "files", quiet, as_json)
    o.refuse(o.either(jobs, scheduler))
    files, notes = distinct(with_folders(files))
    with o.usage():
        options = FillOptions(
            strands=strand or None,
            repair=repair,
            hydrogens=hydrogens,
            no_5_phosphate=no_5_phosphate,
            candidates=candidates,
            like=like,
            library=library,
            **o.limits(max_size, max_atoms),
        )
    if options.like is not None:
        # a template or a library that is none fails once, not for each file
        check_strands(options.like, (), options.limits)
    if options.library is not None:
        library_at(options.library)
    page = has_report(report)
    with o.usage():
        beside = (file_of(options.like), options.library)
        tasks = tasks_of(files, {**options.to_dict(), "report": page}, out, beside)
        progress = len(files) > 1 and not quiet
        done = run(FILLS, tasks, out, jobs or 1, scheduler, progress, in_options, page)
    _end(screen, files, out, done, notes)


def _end(screen: Screen, files: list[str], out: Path, done: "Run", notes: list[str]) -> None:
    """Say what was filled and what was not."""
    from loopelastica.report.documents import fill_documents
    from loopelastica.report.screen.fills import fill_screen

    if done.n_files > 1 or done.n_resumed:
        screen.show(
            f"{done.n_files} files ({done.n_resumed} were done before), {done.n_rows} strands in"
            f" {done.table}",
            "",
        )
    shown = ({**row, "file": Path(row["file"]).name} for row in done.rows)
    screen.show(*fill_screen(shown, str(out)))
    records = [record for record in done.records if record.get("folder_key")]
    written = [(record["file"], record["folder"]) for record in records]
    if written:
        screen.show(
            "",
            f"Written to {out}: a folder per file, with fill.json and, where anything was built,"
            " filled.pdb or filled.cif, and summary.csv, a row per strand."
            + o.page_text(done.page)
            + o.failures_text(len(done.failed)),
        )
    # what a model is not good for stands before what was chosen in reading
    told = sorted(done.notes, key=lambda sentence: "not sound" not in sentence)
    known = [{"folder": record["folder"]} for record in records]
    earlier = o.of_earlier_runs(out, known, "fill.json")
    screen.note([*notes, *told, *earlier], "in the files' fill.json", files)
    screen.end(
        fill_documents(out, written) if screen.as_json else (),
        done.failed,
        f"in {out / 'failures.csv'}",
        folder=str(out),
    )
