"""``loopelastica evaluate``: how good the program is, on real loops."""

from pathlib import Path
from typing import Annotated

import typer

from loopelastica.cli import options as o
from loopelastica.cli.program import tell


def evaluate(
    folder: Annotated[
        Path, typer.Argument(help="Folder of PDB and mmCIF files.", show_default=False)
    ],
    out: o.Out = Path("loopelastica-evaluation"),
    jobs: o.Jobs = None,
    scheduler: o.Scheduler = None,
    max_size: o.MaxSize = None,
    max_atoms: o.MaxAtoms = None,
) -> None:
    """Compare folds and simple curves with the loops of many files; write a scoreboard.

    It says too how often expected errors hold. Shapes of loops related to the one at hand are not
    used. The same command resumes a run that was stopped.
    """
    from loopelastica.molecule.nucleotides import Limits
    from loopelastica.studies.evaluation.scoreboard import evaluate as evaluate_folder

    o.refuse(o.either(jobs, scheduler))
    with o.usage():
        limits = Limits(**o.limits(max_size, max_atoms))
        done = evaluate_folder(folder, out, jobs or 1, scheduler, progress=True, limits=limits)
    tell(f"{done.n_files} files, {done.n_rows} loops: {out / 'scoreboard.md'}")
    o.note(done.notes)
    o.fail_of_many(done.failures, out)
