"""Single strands of nanostructures on the screen, from the rows of a run's table."""

from collections.abc import Iterable, Iterator, Mapping
from itertools import chain, islice
from typing import Any, Final

from rich.table import Table

from loopelastica._names import printable
from loopelastica.report.screen.console import SCREENFUL, add_row, new_table

Row = Mapping[str, Any]

_RIGHT: Final = ("nt\n", "distance\n(nm)", "spacing\n(nm)", "status\n")


def nanostructure_screen(rows: Iterable[Row], place: str) -> Iterator[Table | str]:
    """What was laid or refused, and between what: a row per single strand, up to a screenful.

    Refused strands come first.

    Parameters
    ----------
    rows : iterable of mapping
        Those of summary.csv; ``file`` is shown as it is.
    place : str
        Folder of the run.

    Yields
    ------
    rich.table.Table or str
        In their order; sentences are strings, to be broken into lines.
    """
    kept = list(rows)
    refused = [row for row in kept if row["status"] == "refused"]
    laid = (row for row in kept if row["status"] != "refused")
    first = list(islice(chain(refused, laid), SCREENFUL))
    if not first:
        return
    table = new_table(["design\n  single strand, helix:offset"], _RIGHT)
    shown = None
    for row in first:
        if row["output"] != shown:
            shown = row["output"]
            add_row(table, printable(row["file"]), "", "", "", "")
        add_row(table, *_cells(row))
    yield table
    more = len(kept) - len(first)
    if more:
        yield f"and {more} more single strands: {printable(place)}/summary.csv has all of them"


def _cells(row: Row) -> tuple[str, ...]:
    ends = [end for end in dict.fromkeys((row["before"], row["after"])) if end is not None]
    # "helix 2:31" leaves room for both ends in a line
    where = " – ".join(printable(end).replace(", offset ", ":") for end in ends)
    lengths = (row[name] for name in ("distance_nm", "spacing_nm"))
    numbers = ("" if length is None else f"{length:.2f}" for length in lengths)
    name = f"{row['kind']}, {where or printable(row['strand'])}"
    return (f"  {name}", str(row["nucleotides"]), *numbers, row["status"])
