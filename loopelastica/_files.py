"""Files: where those that ship with the package are, and writing whole or not at all.

Everything is written beside its place under a hidden name and moved there when it is complete, so
that a reader never meets half of it and an interrupted run leaves nothing behind.
"""

import csv
import hashlib
import json
import os
import shutil
import tempfile
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal, TextIO

from loopelastica._names import printable


def data_path(name: str) -> Path:
    """Path of a shipped file: inside an installed package, else in the checkout beside it."""
    here = Path(__file__).resolve().parent
    inside = here / "data"
    return (inside if inside.is_dir() else here.parent / "data") / name


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A path to write to, of the same suffix, that becomes ``path`` only without an error."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(prefix=f".{path.stem}.", suffix=path.suffix, dir=path.parent)
    os.close(handle)
    part = Path(name)
    try:
        yield part
        # the temporary file is its owner's alone; a result is for whom the folder is for
        part.chmod(0o666 & ~_umask())
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


@contextmanager
def whole_folder(path: Path) -> Iterator[Path]:
    """A folder to write into that becomes ``path`` only when the block ends without an error."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = Path(tempfile.mkdtemp(prefix=f".{path.name}.", dir=path.parent))
    try:
        yield part
        part.chmod(0o777 & ~_umask())
        if path.exists():
            shutil.rmtree(path)
        part.replace(path)
    finally:
        shutil.rmtree(part, ignore_errors=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text, whole or not at all."""
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8", newline="\n")


def write_json(path: Path, content: Any) -> None:
    """Write JSON, whole or not at all; ValueError for NaN and infinities."""
    write_text(path, json.dumps(content, indent=1, allow_nan=False, ensure_ascii=False) + "\n")


def write_csv(
    path: Path, rows: Iterable[Mapping[str, object]], columns: Sequence[str] | None = None
) -> int:
    """Write a table, whole or not at all; None is an empty cell.

    Parameters
    ----------
    path : Path
        The file.
    rows : iterable of mapping
        Taken one by one.
    columns : sequence of str, optional
        What is written of each row; default the keys of the first one.

    Returns
    -------
    int
        How many rows there were.
    """
    count = 0
    with whole_file(path) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = None if columns is None else _writer(file, columns, "ignore")
        for row in rows:
            if writer is None:
                writer = _writer(file, list(row), "raise")
            writer.writerow(cells(row))
            count += 1
    return count


def cells(row: Mapping[str, object]) -> dict[str, object]:
    """A row of a table as it stands in a CSV file.

    A text that a spreadsheet would take for a formula, because it begins with = + - or @ and is no
    number, begins with an apostrophe instead; what would break a line becomes an escape.

    Parameters
    ----------
    row : mapping
        Values by column.

    Returns
    -------
    dict

    Examples
    --------
    >>> cells({"chain": "=1+1", "x_A": "-1.5", "loop": "a\\nb", "rank": 1})
    {'chain': "'=1+1", 'x_A': '-1.5', 'loop': 'a\\\\nb', 'rank': 1}
    """
    return {name: _cell(value) if isinstance(value, str) else value for name, value in row.items()}


def _cell(text: str) -> str:
    text = printable(text)
    # spreadsheets know the wide forms of the signs too
    if unicodedata.normalize("NFKC", text.lstrip()[:1]) not in ("=", "+", "-", "@"):
        return text
    try:
        float(text)
    except ValueError:
        return f"'{text}"
    return text


def _writer(
    file: TextIO, columns: Sequence[str], extra: Literal["ignore", "raise"]
) -> "csv.DictWriter[str]":
    writer = csv.DictWriter(file, columns, extrasaction=extra, lineterminator="\n")
    writer.writeheader()
    return writer


def sha256(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
