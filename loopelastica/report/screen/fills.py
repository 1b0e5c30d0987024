"""Filled and refused strands on the screen, from the rows of a run's table."""

from collections.abc import Iterable, Iterator, Mapping
from itertools import groupby, islice
from typing import Any, Final

from rich.table import Table

from loopelastica._names import printable
from loopelastica.folding.expected import expected_text
from loopelastica.report.screen.console import SCREENFUL, add_row, new_table

Row = Mapping[str, Any]

_QUANTILES: Final = ("expected_10_A", "expected_rmsd_A", "expected_90_A")


def fill_screen(rows: Iterable[Row], place: str) -> Iterator[Table | str]:
    """What was filled or refused, how, how good it may be, and where it is.

    A row per strand; that of several models is one. A screenful of strands is shown.

    Parameters
    ----------
    rows : iterable of mapping
        Those of summary.csv, taken one by one; ``file`` is shown as it is.
    place : str
        Folder of the run.

    Yields
    ------
    rich.table.Table or str
        In their order; sentences are strings, to be broken into lines.
    """
    strands = (models for own in _of_files(rows) for models in own)
    first = list(islice(strands, SCREENFUL))
    more = sum(1 for _ in strands)
    if not first:
        return
    right = ["expected\nerror (Å)", "E/K0\n(1/Å)", "sound\n"]
    table = new_table(["file and its folder\n  strand, sequence, shape"], right)
    shown = None
    for models in first:
        if models[0]["folder"] != shown:
            shown = models[0]["folder"]
            add_row(table, f"{printable(models[0]['file'])}, in {printable(shown)}", "", "", "")
        add_row(table, *_cells(models))
    yield table
    if more:
        yield f"and {more} more strands: {printable(place)}/summary.csv has all of them"
    yield ""
    yield (
        "Expected error: half of such strands are nearer than the first figure, 80 % lie in the"
        " interval; it is an RMSD of backbone centroids without superposition. E/K0 is the energy"
        " of deformation, and no confidence. Sound: bonds, angles and contacts are as they should"
        " be; a base may point elsewhere all the same."
    )


def _of_files(rows: Iterable[Row]) -> Iterator[list[list[Row]]]:
    """The strands of each file, a list of models each."""
    for _, own in groupby(rows, key=lambda row: row["folder"]):
        strands: dict[tuple[str, str, str], list[Row]] = {}
        for row in own:
            strands.setdefault((row["chain"], row["first"], row["last"]), []).append(row)
        yield list(strands.values())


def _cells(models: list[Row]) -> tuple[str, ...]:
    """The cells of one strand."""
    # the figures are those of the first model that could be filled
    row = next((r for r in models if r["expected_rmsd_A"] is not None), models[0])
    first, last = row["first"], row["last"]
    name = first if first == last else f"{first}-{last}"
    name = f"{row['chain']}.{name}" if row["chain"] else name
    about = "  ".join(printable(text) for text in (name, row["sequence"], row["shape"]) if text)
    expected, energy = "refused", ""
    if row["expected_rmsd_A"] is not None:
        expected = expected_text([row[name] for name in _QUANTILES])
        energy = f"{row['energy_per_A']:.4f}"
    sound = {True: "yes", False: "no", None: ""}[row["sound"]]
    if len(models) > 1:
        sound = f"{sum(r['sound'] is True for r in models)} of {len(models)}"
    # runs before this column was written have none
    if row.get("mate_A") is not None:
        about += f", {row['mate_A']:.1f} Å from a mate in the crystal"
    return f"  {about}", expected, energy, sound
