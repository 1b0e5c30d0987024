"""The file of a library: written whole, read table by table.

A NumPy archive (.npz) with an entry ``about``, JSON in UTF-8, and for each table, such as RNA4:

    letters  (k, n + 2) uint8       bases from closing to closing nucleotide, ASCII
    steps    (k, n + 1, 3) float32  Å, in the frame of the first node
    turns    (k, 4) float32         end frame in that of the first node, quaternion x y z w
    stem_rms (k,) float32           Å
    entries, sources (k,) str

Single precision keeps places to 1e-6 Å and turns to 1e-7; the files that shapes are from have three
decimals.
"""

from __future__ import annotations

import errno
import functools
import io
import json
import os
import re
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

import numpy as np

from loopelastica._checks import shown
from loopelastica._files import PROGRAM, TakenError, whole_file
from loopelastica._names import printable
from loopelastica._version import __version__
from loopelastica.errors import LoopelasticaError
from loopelastica.folding.library import Kind, Library
from loopelastica.folding.shape_table import ShapeTable, copies_of
from loopelastica.molecule.reading import first_line, name_of

FORMAT: Final = 1
_ABOUT: Final = "about"
# the first entry of the archive, and where its name stands
_HEAD: Final = f"{_ABOUT}.npy".encode()
_NAME_AT: Final = 30
_KIND: Final = re.compile(r"(RNA|DNA)([1-9]\d{0,3})")
_LETTERS: Final = np.frombuffer(b"ABCDEFGHIJKLMNOPQRSTUVWXYZ?", dtype=np.uint8)


def save_library(library: Library, path: str | os.PathLike[str]) -> None:
    """Write a library to one file, whole or not at all.

    Parameters
    ----------
    library : Library
        The same shapes give the same file to the byte.
    path : path
        Such as loops.lib. A library that is there is replaced.

    Raises
    ------
    TakenError
        If a file is there that is no library.
    OutputError
        If it cannot be written.
    """
    path = Path(path)
    check_place(path)
    arrays = {f"{kind}/{n}": a for kind, t in library.tables() for n, a in _packed(t).items()}
    about = {
        "program": PROGRAM,
        "version": __version__,
        "format": FORMAT,
        "tables": {str(kind): count for kind, count in library.counts.items()},
    }
    text = np.frombuffer(json.dumps(about, sort_keys=True).encode(), dtype=np.uint8)
    with whole_file(path) as part, part.open("wb") as file:
        # by a handle: to a name NumPy would add its suffix
        np.savez_compressed(file, **{_ABOUT: text, **arrays})


def check_place(path: Path) -> None:
    """TakenError where something is in the place of a library that is none."""
    if not os.path.lexists(path):
        return
    with suppress(LoopelasticaError, OSError):
        if path.is_file() and (path.stat().st_size == 0 or _archive(path)):
            return
    sentence = "this is no library of loop shapes, so none is written in its place"
    raise TakenError(errno.EEXIST, sentence, str(path))


def load_library(path: str | os.PathLike[str]) -> Library:
    """Open a library; its tables are read when they are first needed.

    Parameters
    ----------
    path : path
        What ``loopelastica library build`` has written. A process reads a file once, unless it
        changes.

    Returns
    -------
    Library

    Raises
    ------
    LoopelasticaError
        If the file is absent, damaged, no library, or of a later version.
    ValueError
        If `path` is no path.

    Examples
    --------
    >>> import tempfile
    >>> from loopelastica._files import data_path
    >>> from loopelastica.batch.shapes import build_library
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     build = build_library(data_path("hairpins/2koc.pdb"), f"{folder}/loops.lib")
    ...     table = load_library(f"{folder}/loops.lib").of_length(4)
    >>> print(table.sequence(0), table.sources[0], table.steps_A[0].round(1)[0])
    CUUCGG 2koc A.5-A.10 [1.1 0.5 5.9]
    """
    if not isinstance(path, str | os.PathLike):
        raise ValueError(f"`path` is {shown(path)}; it must be the path of a library")
    path = Path(path)
    if not path.is_file():
        what = "this is no file" if path.exists() else "there is no such file"
        raise LoopelasticaError(f"{name_of(path)}: {what}; a library was expected")
    now = path.stat()
    return _opened(path, (now.st_mtime_ns, now.st_size, now.st_ino, now.st_dev))


@functools.lru_cache(maxsize=4)
def _opened(path: Path, stamp: tuple[int, ...]) -> Library:
    tables = _Tables(path)
    return Library(tables.counts, tables)


class _Tables:
    """The tables of a file, each read when it is asked for; a copy opens the file by itself."""

    def __init__(self, path: Path) -> None:
        self.path, self.archive = path, _archive(path)
        self.counts = _about(path, self.archive)

    def __call__(self, kind: Kind) -> ShapeTable:
        try:
            return _unpacked(self.archive, kind, self.counts[kind])
        # whatever a damaged archive provokes
        except Exception as error:
            raise _damaged(self.path, first_line(error)) from error

    def __reduce__(self) -> tuple[Any, ...]:
        return _Tables, (self.path,)


def _archive(path: Path) -> Any:
    """The archive, in memory as it is on disk: the file may be replaced while it is in use."""
    try:
        with path.open("rb") as file:
            # before more is read of a file that may be anything
            if file.read(len(_HEAD) + _NAME_AT)[_NAME_AT:] == _HEAD:
                file.seek(0)
                archive = np.load(io.BytesIO(file.read()), allow_pickle=False)
                if _ABOUT in archive.files:
                    return archive
    except PermissionError:
        raise LoopelasticaError(f"{name_of(path)}: no permission to read the file") from None
    # half an archive, or none of NumPy
    except Exception:
        archive = None
    raise LoopelasticaError(
        f"{name_of(path)}: this is no library of loop shapes, or not a whole one;"
        " `loopelastica library build` makes one"
    )


def _about(path: Path, archive: Any) -> dict[Kind, int]:
    """Number of shapes by kind, by the archive's own account."""
    try:
        about = json.loads(archive[_ABOUT].tobytes())
        written, program = about["format"], about["program"]
        if program == PROGRAM and isinstance(written, int) and written > FORMAT:
            version = printable(str(about.get("version")))
            raise LoopelasticaError(
                f"{name_of(path)}: a library of loopelastica {version}, which this version"
                f" ({__version__}) cannot read; update the program, or build the library again"
            )
        if program != PROGRAM or written != FORMAT:
            raise ValueError("it is of another program")
        return {_kind(name): _count(count) for name, count in about["tables"].items()}
    except LoopelasticaError:
        raise
    except Exception as error:
        raise _damaged(path, first_line(error)) from None


def _damaged(path: Path, cause: str) -> LoopelasticaError:
    return LoopelasticaError(
        f"{name_of(path)}: the library is damaged ({printable(cause)}); build it again"
    )


def _kind(name: str) -> Kind:
    match = _KIND.fullmatch(name)
    if match is None:
        raise ValueError("it has a table of no kind")
    return Kind(match[1] == "DNA", int(match[2]))


def _count(count: Any) -> int:
    if not isinstance(count, int) or count < 1:
        raise ValueError("it has a table of no size")
    return count


def _packed(table: ShapeTable) -> dict[str, Any]:
    from scipy.spatial.transform import Rotation

    turns = Rotation.from_matrix(table.end_frames).as_quat(canonical=True)
    return {
        "letters": table.letters,
        "steps": table.steps_A.astype(np.float32),
        "turns": turns.astype(np.float32),
        "stem_rms": table.stem_rms_A.astype(np.float32),
        "entries": table.entries,
        "sources": table.sources,
    }


def _unpacked(archive: Any, kind: Kind, k: int) -> ShapeTable:
    """A table, each array of the type and the size that it must have."""
    from scipy.spatial.transform import Rotation

    n = kind.nucleotides
    expected = {
        "letters": ("u1", (k, n + 2)),
        "steps": ("f4", (k, n + 1, 3)),
        "turns": ("f4", (k, 4)),
        "stem_rms": ("f4", (k,)),
        "entries": ("U", (k,)),
        "sources": ("U", (k,)),
    }
    found: dict[str, Any] = {}
    for name, (kind_of_values, shape) in expected.items():
        values = archive[f"{kind}/{name}"]
        found[name] = values
        right = np.dtype(kind_of_values).kind == values.dtype.kind and values.shape == shape
        if not right or (values.dtype.kind == "f" and not np.isfinite(values).all()):
            raise ValueError(f"its {name} of {kind} are not what they must be")
    if not np.isin(found["letters"], _LETTERS).all() or not found["steps"].any(axis=2).all():
        raise ValueError(f"its {kind} are no loops")
    return ShapeTable(
        is_dna=np.full(k, kind.is_dna),
        letters=found["letters"],
        steps_A=found["steps"].astype(np.float64),
        end_frames=Rotation.from_quat(found["turns"].astype(np.float64)).as_matrix(),
        stem_rms_A=found["stem_rms"].astype(np.float64),
        entries=found["entries"],
        sources=found["sources"],
        copies=copies_of(found["letters"]),
    )
