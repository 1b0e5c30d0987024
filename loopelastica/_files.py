"""Files: where those that ship with the package are, and writing whole or not at all.

Everything is written beside its place under a hidden name and moved there when it is complete, so
that a reader never meets half of it and an interrupted run leaves nothing behind.
"""

import csv
import errno
import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal, TextIO

NO_UTF8 = "backslashreplace"
r"""How a file name that is no UTF-8 is written: \udcff for a byte, in JSON too."""


def data_path(name: str) -> Path:
    """Path of a shipped file: inside an installed package, else in the checkout beside it."""
    here = Path(__file__).resolve().parent
    inside = here / "data"
    return (inside if inside.is_dir() else here.parent / "data") / name


def printable(name: str) -> str:
    """A file name as it is written in texts, tables and pictures."""
    return name.encode(errors=NO_UTF8).decode()


class OutputError(OSError):
    """Something could not be written; ``filename`` is the path that a user knows of."""

    def __str__(self) -> str:
        return f"{self.filename}: cannot be written ({self.strerror})"


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Name ``path`` where the block cannot write to it, or to a hidden place beside it.

    Raises
    ------
    OutputError
        For what the system refused. An error of reading another file passes as it is.
    """
    try:
        yield
    except OSError as error:
        if not _is_of(path, error.filename):
            raise
        reason = "a file is there" if error.errno == errno.EEXIST else error.strerror or str(error)
        raise OutputError(error.errno, reason, str(path)) from None


def _is_of(path: Path, filename: Any) -> bool:
    """Whether an error with this file name, or with none, is one of writing to a path."""
    if not isinstance(filename, str):
        return True
    place, name = (Path(os.path.abspath(p)) for p in (path, filename))
    hidden = (p for p in (name, *name.parents) if p.parent == place.parent)
    beside = any(p.name.startswith(f".{place.stem}.") for p in hidden)
    return beside or name in (place, *place.parents) or place in name.parents


def make_folder(path: Path) -> None:
    """Make a folder for results, and those above it; OutputError where that cannot be."""
    with writing(path):
        path.mkdir(parents=True, exist_ok=True)


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A path to write to, of the same suffix, that becomes ``path`` only without an error."""
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        prefix = f".{path.stem}."
        handle, name = tempfile.mkstemp(prefix=prefix, suffix=path.suffix, dir=path.parent)
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
    with writing(path):
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
        part.write_text(text, encoding="utf-8", errors=NO_UTF8, newline="\n")


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
    with (
        whole_file(path) as part,
        part.open("w", newline="", encoding="utf-8", errors=NO_UTF8) as file,
    ):
        writer = None if columns is None else _writer(file, columns, "ignore")
        for row in rows:
            if writer is None:
                writer = _writer(file, list(row), "raise")
            writer.writerow(row)
            count += 1
    return count


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
