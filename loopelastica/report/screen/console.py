"""The width of the screen, tables on it, and sentences broken into its lines."""

import os
import sys
import textwrap
from collections.abc import Sequence
from typing import Final

from rich import box
from rich.cells import cell_len
from rich.console import Console
from rich.table import Table

from loopelastica._names import printable

WIDTH: Final = 80
"""Columns where the standard output is no terminal."""
SCREENFUL: Final = 20
"""Lines or rows after which the rest is counted."""
_NARROWEST: Final = 60


def console() -> Console:
    """Where tables go: as wide as the terminal, or as COLUMNS says; 80 columns for a pipe."""
    # brackets and colons in a name are no markup, and numbers need no colour
    screen = Console(markup=False, emoji=False, highlight=False)
    screen.width = width(screen.is_terminal)
    return screen


def width(terminal: bool | None = None) -> int:
    """Columns of the screen; never so few that a table would have to cut its numbers.

    Parameters
    ----------
    terminal : bool, optional
        Whether output goes to a terminal; by default the standard output is asked.

    Returns
    -------
    int
    """
    if terminal is None:
        terminal = sys.stdout.isatty()
    columns = os.environ.get("COLUMNS", "")
    if columns.isdecimal() and int(columns) > 0:
        wide = int(columns)
    else:
        wide = _of_terminal() if terminal else WIDTH
    return max(wide, _NARROWEST)


def _of_terminal() -> int:
    try:
        return os.get_terminal_size(sys.stdout.fileno()).columns or WIDTH
    except (OSError, ValueError):
        return WIDTH


def wrapped(sentence: str, columns: int, indent: str = "  ") -> list[str]:
    """A sentence in lines, broken between words; a path or another long word stays whole.

    Parameters
    ----------
    sentence : str
        Any text.
    columns : int
        Of the screen.
    indent : str
        What lines but the first begin with.

    Returns
    -------
    list of str

    Examples
    --------
    >>> wrapped("note: some/long/path.pdb: no loop", 16)
    ['note:', '  some/long/path.pdb:', '  no loop']
    """
    return textwrap.wrap(
        printable(sentence),
        columns,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )


def new_table(left: Sequence[str], right: Sequence[str], title: str | None = None) -> Table:
    """A table with a line below its head and nothing else.

    Parameters
    ----------
    left, right : sequence of str
        Heads of columns of text, which are broken into lines where there is no room, and of
        columns of numbers behind them, which stay whole.
    title : str, optional
        Above it.

    Returns
    -------
    rich.table.Table
    """
    table = Table(
        title=None if title is None else printable(title),
        title_justify="left",
        title_style="bold",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
        show_edge=False,
        collapse_padding=True,
    )
    for name in left:
        table.add_column(name, overflow="fold", vertical="top")
    for name in right:
        table.add_column(name, justify="right", no_wrap=True, vertical="top")
    return table


def add_row(table: Table, *texts: str) -> None:
    """Add a row; columns of numbers become as wide as what is in them.

    Parameters
    ----------
    table : rich.table.Table
        Made by :func:`new_table`.
    *texts : str
        A cell each. Line feeds in it are its own: names have been made harmless before.
    """
    for column, text in zip(table.columns, texts, strict=True):
        if column.no_wrap:
            column.min_width = max(column.min_width or 0, cell_len(text))
    table.add_row(*("\n".join(map(printable, text.split("\n"))) for text in texts))
