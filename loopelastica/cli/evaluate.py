"""``loopelastica evaluate``: how good the program is, on real loops."""

from pathlib import Path
from typing import Annotated

import typer

from loopelastica.cli import options as o
from loopelastica.cli.screen import Screen


def evaluate(
    folder: Annotated[
        Path, typer.Argument(help="Folder of PDB and mmCIF files.", show_default=False)
    ],
    out: o.Out = Path("loopelastica-evaluation"),
    jobs: o.Jobs = None,
    scheduler: o.Scheduler = None,
    max_size: o.MaxSize = None,
    max_atoms: o.MaxAtoms = None,
    quiet: o.Quiet = False,
    as_json: o.AsJson = False,
) -> None:
    """Compare folds and simple curves with real loops.

    The result is a scoreboard of the loops of many files.

    It says too how often expected errors hold. Shapes of loops related to the one at hand are not
    used. The same command resumes a run that was stopped.
    """
    from loopelastica.molecule.nucleotides import Limits
    from loopelastica.report.screen.markdown import markdown_screen
    from loopelastica.studies.evaluation.loops import EVALUATION
    from loopelastica.studies.evaluation.scoreboard import evaluate as evaluate_folder

    screen = Screen("evaluate", "loops", quiet, as_json)
    o.refuse(o.either(jobs, scheduler))
    with o.usage():
        limits = Limits(**o.limits(max_size, max_atoms))
        done = evaluate_folder(folder, out, jobs or 1, scheduler, not quiet, limits=limits)
    board = out / "scoreboard.md"
    if screen.talks:
        # its first section; the others are for those who want to know more
        first = board.read_text(encoding="utf-8").partition("\n## ")[0]
        screen.show(*markdown_screen(first), "")
    screen.show(f"{done.n_files} files, {done.n_rows} loops; all comparisons: {board}")
    screen.note(done.notes, "of the kind")
    loops = ({name: row[name] for name in EVALUATION.columns} for row in done.rows)
    screen.end(loops, done.failed, f"in {out / 'failures.csv'}", folder=str(out))
