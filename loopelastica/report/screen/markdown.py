"""Reports of studies, which are written as Markdown, on the screen."""

import re
from collections.abc import Iterator, Sequence
from itertools import groupby

from rich.cells import cell_len
from rich.table import Table
from rich.text import Text

from loopelastica.report.screen.console import add_row, new_table, width

_NUMBER = re.compile(r"[-−+<>≤≥~]?\d.*|–?")
# signs in a line of a cell of several words, in the first column and in others; of the longest
# word; between columns
_FIRST, _COMFORT, _WIDEST, _GAP = 26, 13, 30, 2


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


def _tables(rows: list[list[str]]) -> Iterator[Table | str]:
    """A table, or several below each other that begin with the same column."""
    head, *body = [row for row in rows if set("".join(row)) - set("-: ")]
    body = [[*row, *[""] * (len(head) - len(row))] for row in body]
    columns = zip(head, *(row[: len(head)] for row in body), strict=True)
    widths = [_width(texts, _COMFORT if k else _FIRST) for k, texts in enumerate(columns)]
    room, chosen = width() - widths[0], list[int]()
    for k in range(1, len(head)):
        if chosen and room < widths[k] + _GAP:
            yield from (_table(head, body, [0, *chosen], widths), "")
            room, chosen = width() - widths[0], []
        chosen.append(k)
        room -= widths[k] + _GAP
    yield _table(head, body, [0, *chosen], widths)


def _width(texts: Sequence[str], comfort: int) -> int:
    """What a column needs: its longest word, and so many signs for cells of several."""
    words = max(cell_len(word) for text in texts for word in (*text.split(), ""))
    return min(max(words, min(comfort, max(map(cell_len, texts)))), _WIDEST)


def _table(
    head: Sequence[str], body: Sequence[Sequence[str]], chosen: Sequence[int], widths: Sequence[int]
) -> Table:
    table = new_table([head[k] for k in chosen], [])
    for column, k in zip(table.columns, chosen, strict=True):
        column.min_width = widths[k]
        if k and all(_NUMBER.fullmatch(row[k]) for row in body):
            column.justify = "right"
    for row in body:
        add_row(table, *(row[k] for k in chosen))
    return table
