"""``loopelastica origami``: single strands of DNA nanostructures, between their helices."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from loopelastica.cli import options as o
from loopelastica.cli.program import in_options
from loopelastica.cli.screen import Screen

if TYPE_CHECKING:
    from loopelastica.batch.run import Run
    from loopelastica.batch.tasks import Task

_Designs = Annotated[
    list[str],
    typer.Argument(
        metavar="DESIGN...",
        help="Designs of scadnano (.sc), topologies of oxDNA (.top) with or without their"
        " configurations (.dat, .oxdna, .conf), and folders of them.",
        show_default=False,
    ),
]
_Form = Annotated[
    str,
    typer.Option(help="Form of the topology: 'old', four columns, or 'new', a line per strand."),
]
_Helices = Annotated[
    str,
    typer.Option(
        help="Helices of a scadnano design: 'drawn', where it has them, or 'fitted', moved so that"
        " strands can cross between them by bonds of the model."
    ),
]
_Tails = Annotated[
    str,
    typer.Option(
        help="Single strands with a free end: 'straight', or 'relaxed', rods of least energy in"
        " their surroundings."
    ),
]
_Sample = Annotated[
    int,
    typer.Option(
        metavar="N",
        help="Write N random coils too, worm-like chains clamped at both ends: for strands that are"
        " longer than a few persistence lengths.",
        min=0,
    ),
]
_Seed = Annotated[
    int, typer.Option(help="Of the samples, and of bases that a design leaves open.", min=0)
]
_Pairs = Annotated[
    str,
    typer.Option(
        help="Base pairs of oxDNA files: by the 'energy' of their hydrogen bonds, or by 'geometry'"
        " alone, whatever the bases are."
    ),
]
_PersistenceLength = Annotated[
    float | None,
    typer.Option("--persistence-length", help="Of single strands, nm.", show_default=False),
]


def origami(
    designs: _Designs,
    out: o.Out = o.OUT,
    form: _Form = "old",
    helices: _Helices = "drawn",
    tails: _Tails = "straight",
    sample: _Sample = 0,
    seed: _Seed = 0,
    pairs: _Pairs = "energy",
    persistence_length_nm: _PersistenceLength = None,
    quiet: o.Quiet = False,
    as_json: o.AsJson = False,
) -> None:
    """Lay the single strands of DNA nanostructures.

    Each design gets <stem>.top and <stem>.dat for oxDNA, <stem>.json, a coarse trace as mmCIF and
    PDB, and scripts for viewers; what is paired stays where it is. A design with a strand that
    cannot be laid gets <stem>.json alone, which names it. The folder for the results gets
    summary.csv, a row per single strand, and failures.csv.
    """
    from loopelastica._checks import one_of
    from loopelastica.batch.origamis import ORIGAMIS, design_tasks
    from loopelastica.batch.run import run
    from loopelastica.nanostructures.inputs import designs_of
    from loopelastica.nanostructures.options import NanostructureOptions

    screen = Screen("origami", "designs", quiet, as_json)
    with o.usage():
        one_of("old", "new")("form", form)
        options = NanostructureOptions(
            pairs=pairs,
            helices=helices,
            tails=tails,
            sample=sample,
            seed=seed,
            persistence_length_nm=persistence_length_nm,
        )
    found, notes = designs_of(designs)
    tasks = design_tasks(found, options.to_dict(), form, out)
    done = run(ORIGAMIS, tasks, out, progress=len(tasks) > 1 and not quiet, wording=in_options)
    _end(screen, tasks, out, done, notes)


def _end(screen: Screen, tasks: "list[Task]", out: Path, done: "Run", notes: list[str]) -> None:
    """Say what was laid and what was not."""
    from loopelastica.report.screen.nanostructures import nanostructure_screen

    shown = ({**row, "file": Path(row["file"]).name} for row in done.rows)
    screen.show(*nanostructure_screen(shown, str(out)))
    results = list(_results(tasks, out))
    written = [result for result in results if result["status"] == "written"]
    if written:
        stem = written[0]["output"] if len(written) == 1 else "<design>"
        screen.show(
            "",
            f"Written to {out}: {stem}.top and {stem}.dat for oxDNA, {stem}.json, a coarse trace"
            f" for viewers, and summary.csv, a row per single strand.",
        )
    screen.note([*notes, *done.notes], "in the designs' JSON files", [task.file for task in tasks])
    screen.end(results, done.failed, f"in {out / 'failures.csv'}", folder=str(out))


def _results(tasks: "list[Task]", out: Path) -> Any:
    """What the JSON files of the designs say, and which design each is of."""
    from loopelastica._files import read_manifest

    for task in tasks:
        stem = task.options["stem"]
        content = read_manifest(out / f"{stem}.json")
        if content:
            kept = {k: v for k, v in content.items() if k not in ("program", "version", "input")}
            yield {"file": task.file, "output": stem, **kept}
