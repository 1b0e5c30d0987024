"""Reports of studies, which are written as Markdown, on the screen."""

import re
from collections.abc import Iterator
from itertools import groupby

from rich.table import Table
from rich.text import Text

from loopelastica.report.screen.console import add_row, new_table

_NUMBER = re.compile(r"[-−+<>≤≥~]?\d.*|")
# columns of a wider table go below each other
_MOST_COLUMNS = 7


def markdown_screen(text: str) -> Iterator[Table | Text | str]:
    """The headings, sentences and tables of a report.

    Parameters
    ----------
    text : str
        Markdown: headings, paragraphs, lists and tables; pictures are left out.

    Yields
    ------
    rich.table.Table, rich.text.Text or str
        In their order; sentences are strings, to be broken into lines.
    """
    for is_table, lines in groupby(text.splitlines(), lambda line: line.startswith("|")):
        if is_table:
            yield from _tables([_cells(line) for line in lines])
            continue
        for line in lines:
            if line.startswith("#"):
                yield Text(line.lstrip("# "), style="bold")
            elif not line.startswith("!["):
                yield line


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def _tables(rows: list[list[str]]) -> Iterator[Table]:
    """A table, or several below each other that begin with the same column."""
    head, *body = [row for row in rows if set("".join(row)) - set("-: ")]
    width = len(head)
    for first in range(1, max(width, 2), _MOST_COLUMNS - 1):
        chosen = [0, *range(first, min(first + _MOST_COLUMNS - 1, width))]
        table = new_table([head[k] for k in chosen], [])
        for column, k in zip(table.columns, chosen, strict=True):
            if k and all(_NUMBER.fullmatch(row[k]) for row in body if k < len(row)):
                column.justify = "right"
        for row in body:
            add_row(table, *(row[k] if k < len(row) else "" for k in chosen))
        yield table
