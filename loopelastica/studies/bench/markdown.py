"""Tables of a report, in markdown."""

from collections.abc import Mapping, Sequence


def markdown_table(
    rows: Sequence[Mapping[str, object]], columns: Mapping[str, tuple[str, str]]
) -> str:
    """A markdown table.

    Parameters
    ----------
    rows
        Values by key; None or a missing key is shown as –.
    columns
        Key to heading and format, in order: ``{"time_ms": ("ms", ".2f")}``.

    Returns
    -------
    str
        Lines without a newline after the last one.

    Examples
    --------
    >>> print(markdown_table([{"a": 1.5}, {"a": None}], {"a": ("length", ".2f")}))
    | length |
    |---:|
    | 1.50 |
    | – |
    """
    lines = ["| " + " | ".join(heading for heading, _ in columns.values()) + " |"]
    lines.append("|" + "---:|" * len(columns))
    for row in rows:
        cells = []
        for key, (_, form) in columns.items():
            value = row.get(key)
            cells.append("–" if value is None else format(value, form))
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)
