"""The commands of ``loopelastica bench``. Heavy modules are imported inside them."""

from pathlib import Path
from typing import Annotated

import typer

from loopelastica._names import printable

bench = typer.Typer(help="Measure the solvers; write tables and pictures.", no_args_is_help=True)

_RESULTS = Path("loopelastica-bench")
_Out = Annotated[Path, typer.Option("-o", "--out", help="Folder for the results.")]
_Seed = Annotated[int, typer.Option(help="Seed of the random rods and poses.")]


def _say_where(out: Path) -> None:
    typer.echo(printable(f"written to {out}"))


@bench.command("paper")
def bench_paper(
    out: _Out = _RESULTS / "paper",
    full: Annotated[bool, typer.Option("--full", help="Every rod of the paper's sets.")] = False,
    sample: Annotated[int, typer.Option(help="Rods per cell otherwise.", min=1)] = 400,
    own_full: Annotated[
        bool, typer.Option("--own-full", help="Every rod for the package's own solver only.")
    ] = False,
) -> None:
    """Rerun the studies of Figs. 3, 4 and 5 of the 2018 paper: its printed method, and ours."""
    from loopelastica.studies.bench.paper import run

    run(out, full=full, sample=sample, progress=True, own_full=own_full)
    _say_where(out)


@bench.command("atoms")
def bench_atoms(
    folder: Annotated[Path, typer.Argument(help="Folder of structure files.", show_default=False)],
    out: _Out = _RESULTS / "atoms",
    sample: Annotated[
        int | None, typer.Option(help="Only so many files, evenly spread.", min=1)
    ] = None,
) -> None:
    """Build the first candidate's atoms for every simple loop of a folder; judge the models."""
    from loopelastica.studies.bench.atoms import run

    typer.echo(run(folder, out, sample=sample, progress=True))
    _say_where(out)


@bench.command("stability")
def bench_stability(
    out: _Out = _RESULTS / "stability",
    full: Annotated[bool, typer.Option("--full", help="Large samples; some minutes.")] = False,
    seed: _Seed = 2026,
) -> None:
    """Solve stiff, extreme and degenerate clampings; judge each result independently."""
    from loopelastica.studies.bench.stability import run

    run(out, full=full, seed=seed, progress=True)
    _say_where(out)


@bench.command("accuracy")
def bench_accuracy(
    out: _Out = _RESULTS / "accuracy",
    full: Annotated[bool, typer.Option("--full", help="Large samples, forty minutes.")] = False,
    seed: _Seed = 2026,
) -> None:
    """Compare error and run time with the paper's method and SciPy's, on the same targets."""
    from loopelastica.errors import MissingDependencyError
    from loopelastica.studies.bench.accuracy import run

    try:
        run(out, full=full, seed=seed, progress=True)
    except MissingDependencyError as error:
        typer.echo(printable(str(error)), err=True)
        raise typer.Exit(1) from None
    _say_where(out)


@bench.command("scaling")
def bench_scaling(
    out: _Out = _RESULTS / "scaling",
    full: Annotated[bool, typer.Option("--full", help="Up to a million rods.")] = False,
    seed: _Seed = 2026,
) -> None:
    """Measure time and memory over the number of rods, threads, length and equilibria."""
    from loopelastica.studies.bench.scaling import run

    run(out, full=full, seed=seed, progress=True)
    _say_where(out)
