"""``loopelastica solve`` and ``warm``: the dimensionless rod by itself."""

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any

import typer

from loopelastica.cli import options as o
from loopelastica.cli.screen import Screen, fail

if TYPE_CHECKING:
    from loopelastica.rod.equilibria import Equilibria


def solve(
    clamping: Annotated[
        str,
        typer.Option(
            "--clamping", help='The six clamping parameters, e.g. "-0.4 -0.1 0.5 4.8 1.4 2.2".'
        ),
    ],
    torsion_ratio: Annotated[
        float | None, typer.Option(help="K30 = K3/K0; default 1.", show_default=False)
    ] = None,
    free_spin: Annotated[
        bool, typer.Option("--free-spin", help="Let the end turn about its tangent.")
    ] = False,
    energy_max: Annotated[
        float | None, typer.Option(help="List equilibria up to this energy, in K0/L.")
    ] = None,
    rounds: Annotated[
        int | None,
        typer.Option(min=1, max=4, help="How deep to search; default 2.", show_default=False),
    ] = None,
    quiet: o.Quiet = False,
    as_json: o.AsJson = False,
) -> None:
    """Solve a dimensionless rod: its equilibria for a clamping.

    The clamping has six parameters, η1 η2 η3 ψ θ φ, angles in rad.

    The document of --json has what is known of the list beside the "equilibria", each with all that
    determines it.
    """
    from loopelastica._checks import optional, positive
    from loopelastica.rod.clamping import Clamping
    from loopelastica.rod.equilibria import equilibria

    screen = Screen("solve", "equilibria", quiet, as_json)
    o.refuse(
        (free_spin and torsion_ratio is not None, "--torsion-ratio goes without --free-spin"),
    )
    with o.usage():
        ratio = positive("torsion_ratio", 1.0 if torsion_ratio is None else torsion_ratio)
        energy_max = optional(positive)("energy_max", energy_max)
    try:
        values = _parameters(clamping)
        rods = equilibria(Clamping.from_parameters(values, free_spin), ratio, energy_max, rounds)
    except ValueError as error:
        sentence = str(error).removeprefix("`clamping` ")
        raise typer.BadParameter(f"--clamping {clamping!r}: {sentence}") from None
    if rods:
        from loopelastica.report.screen.tables import equilibria_table

        screen.show(equilibria_table(rods), "", rods.evidence)
    sentence = f"--clamping {clamping!r}: no equilibrium found in {rods.starts} starts"
    screen.end(
        [rod.to_dict() for rod in rods],
        () if rods else [{"file": None, "failure": sentence}],
        **(_known_of(rods) if as_json else {}),
    )


def _known_of(rods: "Equilibria") -> dict[str, Any]:
    """What is known of a list of equilibria, for its document."""
    return {
        "energy_max": rods.energy_max,
        "unseen": rods.unseen,
        "by_index": rods.by_index,
        "rounds": rods.rounds,
        "starts": rods.starts,
        "found_by": rods.found_by,
        "tours": asdict(rods.tours),
        "evidence": rods.evidence,
    }


def _parameters(clamping: str) -> list[float]:
    """The six numbers of a text."""
    try:
        values = [float(value) for value in clamping.replace(",", " ").split()]
    except ValueError:
        values = []
    if len(values) != 6 or not all(map(math.isfinite, values)):
        raise ValueError("it must be six finite numbers, η1 η2 η3 ψ θ φ")
    return values


def warm() -> None:
    """Compile everything now, for containers.

    For any processor of this architecture.

    The compiled code goes into the package if that can be written, else into the user's folder of
    caches, or where LOOPELASTICA_CACHE says. A minute; nothing where it is there already.
    """
    from loopelastica.rod.warm import warm as compile_all

    typer.echo("compiling what is not compiled yet", err=True)
    try:
        folder = compile_all("loopelastica.atoms.warm")
    except (OSError, RuntimeError) as error:
        fail([str(error)])
    else:
        typer.echo(f"compiled: {folder}")
