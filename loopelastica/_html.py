"""Tables of HTML, which notebooks show in place of a result's text."""

from collections.abc import Iterable, Sequence
from html import escape


def html_table(caption: str, head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table; whatever stands in it is text, and None an empty cell.

    Parameters
    ----------
    caption : str
        What stands over it.
    head : sequence of str
        Names of the columns.
    rows : iterable of sequences
        As long as `head`.

    Returns
    -------
    str

    Examples
    --------
    >>> html_table("a<b", ["rank"], [[1]])
    '<table><caption>a&lt;b</caption><tr><th>rank</th></tr><tr><td>1</td></tr></table>'
    """
    lines = [_row("th", head), *(_row("td", row) for row in rows)]
    return f"<table><caption>{escape(caption)}</caption>{''.join(lines)}</table>"


def html_line(text: str) -> str:
    """One sentence in place of a table.

    >>> html_line("no <pairs>")
    '<p>no &lt;pairs&gt;</p>'
    """
    return f"<p>{escape(text)}</p>"


def _row(tag: str, cells: Sequence[object]) -> str:
    shown = ("" if cell is None else escape(str(cell)) for cell in cells)
    return f"<tr>{''.join(f'<{tag}>{cell}</{tag}>' for cell in shown)}</tr>"
