"""How good starts of nanostructures are: rods beside straight chords, arcs and an exporter."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeVar

from loopelastica._files import make_folder, write_csv, write_text
from loopelastica.nanostructures.laying.lay import lay
from loopelastica.nanostructures.nanostructure import Nanostructure, nanostructure
from loopelastica.nanostructures.scadnano.reading import read_design
from loopelastica.nanostructures.system import System
from loopelastica.studies.nanostructures import dynamics, lammps, report
from loopelastica.studies.nanostructures.designs import FAMILIES, LARGE, Family, drawn
from loopelastica.studies.nanostructures.measures import measured, summed
from loopelastica.studies.nanostructures.round_trips import round_trips
from loopelastica.studies.nanostructures.sheet import GEOMETRIES, package
from loopelastica.studies.nanostructures.starts import arc, chord, exported, on_curves

Row = dict[str, Any]
_T = TypeVar("_T")

RODS, CHORDS, ARCS, EXPORTER = "rods", "straight chords", "circular arcs", "scadnano's exporter"
WAYS: Final = (RODS, CHORDS, ARCS, EXPORTER)
# strands of a large design in the quick study
_FEW: Final = 40


@dataclass(frozen=True, slots=True)
class _Case:
    """A design to be measured."""

    family: Family
    number: int
    strands: int


def run(
    out: Path, full: bool = False, seed: int = 2026, steps: int = 0, progress: bool = True
) -> list[Row]:
    """Draw designs, lay their single strands in four ways, and measure all of them.

    Parameters
    ----------
    out : Path
        Folder for ``nanostructures.md``, ``nanostructures.csv`` (a row per family and way),
        ``designs.csv`` (a row per design and way), ``nanostructures.png`` and the designs in
        ``designs``; ``round_trips.csv``, and with `steps` ``dynamics.csv``.
    full : bool
        Some 3,000 strands at random and twelve designs of 1,000; otherwise a tenth.
    seed : int
        Of the designs.
    steps : int
        Steps of dynamics of some starts in LAMMPS; none by default.
    progress : bool
        Show a bar on standard error.

    Returns
    -------
    list of dict
        The lines of ``nanostructures.csv``.

    Raises
    ------
    MissingDependencyError
        If scadnano is not installed, or with `steps` LAMMPS.
    """
    from loopelastica._progress import progress_bar

    check_packages(steps)
    make_folder(out / "designs")
    cases = [
        _Case(family, number, family.strands if full or family in FAMILIES else _FEW)
        for family in (*FAMILIES, *LARGE)
        for number in range(family.designs[full])
    ]
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
    _measure(cases[0], seed, out)  # compiled code is there before a clock starts
    rows: list[Row] = []
    bar = progress_bar(cases, shown=progress, unit="design", leave=False)
    for case in bar:
        bar.set_description(case.family.key)
        rows += _measure(case, seed, out)
    families = list(dict.fromkeys(case.family for case in cases))
    table = [_row(family, way, rows) for family in families for way in WAYS]
    write_csv(out / "designs.csv", rows, _names(rows))
    write_csv(out / "nanostructures.csv", table)
    report.draw(table, out / "nanostructures.png")
    trips = round_trips(
        out / "designs" / _file(family, number) for family in FAMILIES for number in (0, 1)
    )
    write_csv(out / "round_trips.csv", trips)
    moved = dynamics.compared(seed, steps, progress) if steps else []
    if moved:
        write_csv(out / "dynamics.csv", moved, _names(moved))
    write_text(out / "nanostructures.md", report.markdown(table, trips, moved, load))
    return table


def check_packages(steps: int) -> None:
    """See that what the study needs is there.

    Parameters
    ----------
    steps : int
        Of dynamics.

    Raises
    ------
    MissingDependencyError
        If scadnano is not installed, or with `steps` LAMMPS.
    """
    package()
    if steps:
        lammps.program().close()


def _names(rows: Sequence[Row]) -> list[str]:
    """Columns of rows that have not all of them."""
    return list(dict.fromkeys(key for row in rows for key in row))


def _file(family: Family, number: int) -> str:
    return f"{family.key}-{number}.sc"


def _measure(case: _Case, seed: int, out: Path) -> list[Row]:
    """The rows of one design, one for each way."""
    design = drawn(case.family, case.number, seed, case.strands)
    path = out / "designs" / _file(case.family, case.number)
    write_text(path, design.to_json())
    found, whole = _timed(lambda: nanostructure(path))
    system = read_design(path).system
    ways: dict[str, Callable[[], System]] = {
        RODS: lambda: lay(system).system,
        CHORDS: lambda: on_curves(system, found.strands, chord),
        ARCS: lambda: on_curves(system, found.strands, arc),
        EXPORTER: lambda: exported(design, system, found.strands),
    }
    rows, geometry = [], GEOMETRIES[case.number % len(GEOMETRIES)]
    for way, make in ways.items():
        row = {"family": case.family.name, "design": path.name, "geometry": geometry, "way": way}
        row |= _start(make, found, may_fail=way == EXPORTER)
        rows.append(row | {"whole_s": whole if way == RODS else None})
    return rows


def _start(make: Callable[[], System], found: Nanostructure, may_fail: bool) -> Row:
    """Lay the strands of a design in one way, and measure them."""
    try:
        start, seconds = _timed(make)
    # whatever the exporter stumbles over is its result
    except Exception as error:
        if not may_fail:
            raise
        laid = len(found.strands) - len(found.refused)
        return {"failed": laid, "failure": type(error).__name__}
    return {**measured(start, found.strands), "seconds": seconds}


def _timed(work: Callable[[], _T]) -> tuple[_T, float]:
    """What is returned, and seconds of processor time."""
    begin = time.process_time()
    result = work()
    return result, time.process_time() - begin


def _row(family: Family, way: str, rows: Sequence[Row]) -> Row:
    """The designs of a family, laid in one way."""
    own = [row for row in rows if row["family"] == family.name and row["way"] == way]
    row: Row = {"family": family.name, "way": way, "designs": len(own)}
    row["designs_failed"] = sum("failed" in one for one in own)
    row |= summed(own)
    whole = sum(one["whole_s"] or 0.0 for one in own)
    strands = row["strands"] + row["refused"]
    row["whole_ms_per_strand"] = 1e3 * whole / strands if way == RODS and strands else None
    return row
