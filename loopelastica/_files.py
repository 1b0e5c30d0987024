"""Files: where those that ship with the package are, and writing whole or not at all.

Everything is written beside its place under a hidden name and moved there when it is complete, so
that a reader never meets half of it. Nothing is removed that the program did not write.
"""

import csv
import errno
import filecmp
import hashlib
import json
import os
import re
import tempfile
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Final, Literal, TextIO

from loopelastica._names import printable

PROGRAM: Final = "loopelastica"
"""What every JSON file of the program says of where it is from."""

NOTE: Final = ".loopelastica"
"""Marks a folder that the program is writing: a lock, and the names of the files that are its own
while there is no manifest."""

_NOT_OURS = (
    "not written by this program, and a result needs its name; move it away, or choose another"
    " folder"
)

NO_UTF8 = "backslashreplace"
r"""How a file name that is no UTF-8 is written: \udcff for a byte, in JSON too."""


def data_path(name: str) -> Path:
    """Path of a shipped file: inside an installed package, else in the checkout beside it."""
    here = Path(__file__).resolve().parent
    inside = here / "data"
    return (inside if inside.is_dir() else here.parent / "data") / name


class OutputError(OSError):
    """Something could not be written; ``filename`` is the path that a user knows of."""

    def __str__(self) -> str:
        return f"{self.filename}: cannot be written ({self.strerror})"


class TakenError(OutputError, FileExistsError):
    """A place is taken by something that the program may not touch."""

    def __str__(self) -> str:
        return f"{self.filename}: {self.strerror}"


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
    except TakenError:
        raise
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
    beside = any(p.name.startswith((f".{place.name}.", f"{NOTE}-")) for p in hidden)
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
        suffix = path.suffix
        handle, name = tempfile.mkstemp(prefix=f"{NOTE}-", suffix=suffix, dir=path.parent)
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
def whole_folder(path: Path, manifest: str, shared: bool = False) -> Iterator[Path]:
    """A folder to write into, whose files come to ``path`` when the block ends without an error.

    Only files that the program wrote are replaced or removed: those that the manifest of a former
    result names. Whatever else is in the folder stays there. Where the manifest is, all its files
    are there and are of one result, for it goes first and comes last. A run that is killed on the
    way leaves a note of what is its own, from which the next one goes on.

    Parameters
    ----------
    path : Path
        The folder.
    manifest : str
        Name of one of the files, JSON, that says "program": "loopelastica" and lists all in
        "files".
    shared : bool
        Whether other results have manifests of their own in this folder.

    Raises
    ------
    TakenError
        If `path` is no folder, or holds something that was not written by this program under a
        name that is needed, or is being written by another run. Nothing is changed.
    """
    if path.is_symlink() or (path.exists() and not path.is_dir()):
        kind = "a symbolic link" if path.is_symlink() else "a file"
        raise _taken(path, f"this is {kind}, so no result is written there")
    make_folder(path if shared else path.parent)
    # always the same name, so that what a killed run has left is found again
    part = path / f".{manifest}.part" if shared else path.with_name(f".{path.name}.part")
    with writing(path), _locked(path, part):
        try:
            _clear(part)
            yield part
            _move(part, path, manifest)
        finally:
            # the mark last: without it nobody could say whose the folder is
            with suppress(OSError):
                _clear(part)
                (part / NOTE).unlink()
                part.rmdir()


def _clear(part: Path) -> None:
    for left in part.iterdir():
        if left.name != NOTE:
            left.unlink()


@contextmanager
def _locked(path: Path, part: Path) -> Iterator[None]:
    """The hidden folder, made or taken over from a killed run, for this process alone."""
    import fcntl

    try:
        part.mkdir()
    except FileExistsError:
        strange = part.is_symlink() or not part.is_dir()
        if strange or (any(part.iterdir()) and not (part / NOTE).is_file()):
            sentence = "not written by loopelastica, and in the way of the result beside it"
            raise _taken(part, sentence) from None
    with (part / NOTE).open("a") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            sentence = "another run is writing this folder now; its result is left alone"
            raise _taken(path, sentence) from None
        except OSError:
            pass  # a file system without locks
        yield


def _move(part: Path, path: Path, manifest: str) -> None:
    if not path.exists():
        part.rename(path)
    else:
        new = {entry.name for entry in part.iterdir()} - {NOTE}
        former = own_files(path, manifest)
        for name in sorted(new):
            place = path / name
            free = not os.path.lexists(place) or (name in former and not _is_folder(place))
            if not free and not _is_same(part / name, place):
                raise _taken(place, _NOT_OURS)
        note = part / f"{NOTE}.json"
        write_json(note, {"program": PROGRAM, "files": sorted(former | new)})
        note.replace(path / NOTE)
        (path / manifest).unlink(missing_ok=True)
        for name in former - new:
            if not _is_folder(path / name):
                (path / name).unlink(missing_ok=True)
        for name in sorted(new - {manifest}):
            (part / name).replace(path / name)
        (part / manifest).replace(path / manifest)
    (path / NOTE).unlink(missing_ok=True)


def _is_folder(place: Path) -> bool:
    return place.is_dir() and not place.is_symlink()


def _is_same(file: Path, place: Path) -> bool:
    """Whether nothing is lost where a file takes the place of what is there."""
    if file.is_symlink() or not place.is_file() or place.is_symlink():
        return False
    return filecmp.cmp(file, place, shallow=False)


def own_files(path: Path, manifest: str) -> set[str]:
    """Names of the files in a folder that the program has written there.

    Parameters
    ----------
    path : Path
        The folder.
    manifest : str
        As for :func:`whole_folder`.

    Returns
    -------
    set of str
        Empty where there is no manifest, or one of somebody else.
    """
    return {
        name
        for listed in (read_manifest(path / manifest), read_manifest(path / NOTE))
        for name in listed.get("files", ())
    }


def read_manifest(path: Path) -> dict[str, Any]:
    """The content of a manifest; empty where there is none that this program could have written."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError, IsADirectoryError, ValueError, RecursionError):
        return {}
    if not isinstance(content, dict) or content.get("program") != PROGRAM:
        return {}
    files = content.get("files")
    return content if isinstance(files, list) and all(_is_file_name(f) for f in files) else {}


def is_whole(manifest: Path, key: Mapping[str, Any]) -> bool:
    """Whether a folder still holds the whole result that a key stands for.

    Parameters
    ----------
    manifest : Path
        The manifest of the folder.
    key : mapping
        Entries that the manifest must have.

    Returns
    -------
    bool
    """
    content = read_manifest(manifest)
    return (
        bool(content)
        and all(content.get(name) == value for name, value in key.items())
        and all(os.path.lexists(manifest.parent / name) for name in content["files"])
    )


def _is_file_name(name: object) -> bool:
    # nothing that leads out of the folder
    return isinstance(name, str) and re.fullmatch(r"[^/\\\0]+", name) is not None and name != ".."


def _taken(path: Path, sentence: str) -> FileExistsError:
    return TakenError(errno.EEXIST, sentence, str(path))


def refuse_other(path: Path, begin: bytes) -> None:
    """TakenError where a file is there that has content and does not begin like our own."""
    if not path.is_file():
        return
    with path.open("rb") as file:
        head = file.read(len(begin))
    if head not in (b"", begin):
        raise _taken(path, _NOT_OURS)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text, whole or not at all."""
    with whole_file(path) as part:
        # of a name that is no UTF-8 an escape is left, in JSON one that stands for the same name
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
            writer.writerow(cells(row))
            count += 1
    return count


def cells(row: Mapping[str, object]) -> dict[str, object]:
    r"""A row of a table as it stands in a CSV file.

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
    >>> cells({"chain": "=1+1", "x_A": "-1.5", "loop": "a\nb", "rank": 1})
    {'chain': "'=1+1", 'x_A': '-1.5', 'loop': 'a\\nb', 'rank': 1}
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
