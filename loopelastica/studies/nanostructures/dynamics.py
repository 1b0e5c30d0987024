"""Starts of a few designs under dynamics: whether they run, and how hot they become."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

from loopelastica.nanostructures.laying.lay import lay
from loopelastica.nanostructures.oxdna.model import KELVIN
from loopelastica.nanostructures.scadnano.reading import read_design
from loopelastica.nanostructures.system import System
from loopelastica.studies.nanostructures.designs import FAMILIES, Family, drawn
from loopelastica.studies.nanostructures.lammps import run
from loopelastica.studies.nanostructures.starts import chord, on_curves

Row = dict[str, Any]

# strands of a design that is run, and designs that are tried until one has nothing refused
_STRANDS: Final = 6
_TRIED: Final = range(40)
_LONGEST_REASON: Final = 160


def compared(seed: int, steps: int, progress: bool) -> list[Row]:
    """Run a small design of each family from rods and from straight chords.

    Parameters
    ----------
    seed : int
        Of the designs.
    steps : int
        Of each run, 0.001 of oxDNA's time long.
    progress : bool
        Show a bar on standard error.

    Returns
    -------
    list of dict
        A row per family and way: ``outcome`` is "ran" or what LAMMPS says.
    """
    from loopelastica._progress import progress_bar

    rows = []
    with TemporaryDirectory() as made:
        bar = progress_bar(FAMILIES, shown=progress, unit="family", leave=False)
        for family in bar:
            bar.set_description(f"dynamics, {family.key}")
            for way, number, system in _starts(family, seed, Path(made)):
                row = {"family": family.name, "design": number, "way": way}
                rows.append(row | _ran(system, Path(made), steps))
    return rows


def _starts(family: Family, seed: int, folder: Path) -> Iterator[tuple[str, int, System]]:
    """The first small design of a family that has nothing refused, laid in both ways."""
    for number in _TRIED:
        path = folder / "design.sc"
        path.write_text(drawn(family, number, seed, _STRANDS).to_json(), encoding="utf-8")
        system = read_design(path).system
        laid = lay(system)
        if not laid.refused:
            yield "rods", number, laid.system
            yield "straight chords", number, on_curves(system, laid.strands, chord)
            return


def _ran(system: System, folder: Path, steps: int) -> Row:
    row: Row = {"nucleotides": len(system), "steps": steps}
    try:
        ran = run(system, folder, steps)
    # LAMMPS has one exception for whatever happens
    except Exception as error:
        said = " ".join(str(error).split()).partition(" For more information")[0]
        return row | {"outcome": said[:_LONGEST_REASON]}
    n = len(system)
    return row | {
        "hottest_K": ran.hottest / KELVIN,
        "energy_begin": ran.begin / n,
        "energy_end": ran.end / n,
        "energy_highest": ran.highest / n,
        "outcome": "ran",
    }
