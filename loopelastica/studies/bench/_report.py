"""Tables of a study on disk: CSV and markdown, written whole or not at all."""

import csv
import io
import os
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path


def write_bytes(path: Path, content: bytes) -> None:
    """Write a file whole or not at all; a reader never meets half of it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        # mkstemp keeps files to their owner; a report is for everyone the folder is for
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(name, 0o666 & ~mask)
        os.replace(name, path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def write_text(path: Path, text: str) -> None:
    """`write_bytes` of UTF-8 text."""
    write_bytes(path, text.encode("utf-8"))


def write_csv(path: Path, rows: Sequence[Mapping[str, object]]) -> None:
    """Rows under the keys of the first one; None is an empty cell."""
    buffer = io.StringIO()
    if rows:
        writer = csv.DictWriter(buffer, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    write_text(path, buffer.getvalue())


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
