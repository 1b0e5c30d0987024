"""The bytes of an input file: regular files only, decompressed up to a limit, a piece at a time."""

from __future__ import annotations

import bz2
import gzip
import lzma
import os
import re
import stat
import zlib
from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from loopelastica._checks import positive, whole
from loopelastica._names import printable
from loopelastica.errors import StructureError
from loopelastica.molecule.folders import structure_files

MAX_SIZE_MB: Final = 500.0
"""40 models of 100,000 atoms have 330 MB as PDB and 440 MB as mmCIF, the largest ribosomes 35."""
MAX_ATOMS: Final = 1_000_000
"""Most atoms of a model; the largest ribosomes have 250,000."""

_OPENERS: dict[str, Any] = {".gz": gzip.open, ".bz2": bz2.open}
# identifiers of the PDB, of four signs and of twelve
_ENTRY = re.compile(r"[1-9][A-Za-z0-9]{3}|pdb_[0-9a-z]{8}", re.IGNORECASE)
_LONGEST = 300
_PIECE = 1 << 20
_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


@dataclass(frozen=True, slots=True)
class Limits:
    """How large a file may be.

    Attributes
    ----------
    max_size_MB : float
        Most megabytes (10⁶ bytes) of a file, counted after decompression.
    max_atoms : int
        Most atoms of a model.
    """

    max_size_MB: float = MAX_SIZE_MB
    max_atoms: int = MAX_ATOMS

    def __post_init__(self) -> None:
        object.__setattr__(self, "max_size_MB", positive("max_size_MB", self.max_size_MB))
        object.__setattr__(self, "max_atoms", whole(1)("max_atoms", self.max_atoms))

    def check_atoms(self, path: Path, n_atoms: int) -> None:
        """Refuse a model of so many atoms if they are too many."""
        if n_atoms > self.max_atoms:
            raise StructureError(
                f"{name_of(path)}: a model has more than {self.max_atoms:,} atoms, which is the"
                " limit; `max_atoms` raises it"
            )


def kind_of(path: Path) -> str:
    """Suffix of a file in lower case, without that of its compression."""
    suffixes = [suffix.lower() for suffix in path.suffixes]
    if suffixes and suffixes[-1] in _OPENERS:
        suffixes.pop()
    return suffixes[-1] if suffixes else ""


def name_of(path: Path) -> str:
    r"""A path as sentences show it: in one line, and not endless.

    >>> print(name_of(Path("some.pdb")), name_of(Path("two\nlines.pdb")))
    some.pdb two\nlines.pdb
    """
    text = printable(str(path))
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST // 2]}…{text[-_LONGEST // 2 :]}"


def first_line(error: BaseException) -> str:
    """Return what an exception says, as one clause."""
    # MDAnalysis puts the cause behind its own words about parsers and temporary names
    text = str(error).rpartition("\nError: ")[2].strip() or type(error).__name__
    return text.splitlines()[0].strip().rstrip(".:")[:160]


def pieces(path: Path, limits: Limits) -> Generator[bytes, None, None]:
    """Content of a regular file, decompressed, in pieces of a megabyte.

    Parameters
    ----------
    path : Path
        The file, by its name compressed or not. What is no regular file is not opened: a pipe
        would block.
    limits : Limits
        Reading ends where the content exceeds them.

    Raises
    ------
    StructureError
        If the file is absent, not regular, unreadable, cut short or too large.
    """
    opener = _OPENERS.get(path.suffix.lower(), open)
    left = limits.max_size_MB * 1e6
    try:
        check_regular(path)
        with opener(path, "rb") as stream:
            while piece := stream.read(_PIECE):
                left -= len(piece)
                if left < 0:
                    raise StructureError(
                        f"{name_of(path)}: the content has more than {limits.max_size_MB:,g} MB,"
                        " which is the limit; `max_size_MB` raises it"
                    )
                yield piece
    except EOFError:
        raise StructureError(f"{name_of(path)}: the compressed file is cut short") from None
    except PermissionError:
        raise StructureError(f"{name_of(path)}: no permission to read the file") from None
    # ValueError: a null character in the name
    except (OSError, ValueError, zlib.error, lzma.LZMAError) as error:
        cause = getattr(error, "strerror", None) or first_line(error)
        raise StructureError(f"{name_of(path)}: the file cannot be read ({cause})") from None


def check_regular(path: Path) -> None:
    """Refuse what is not there and what is no regular file.

    Parameters
    ----------
    path : Path
        A file, or what is given as one.

    Raises
    ------
    StructureError
        If it is none.
    """
    try:
        mode = os.stat(path).st_mode
    except FileNotFoundError:
        raise StructureError(f"{name_of(path)}: {_absent(path)}") from None
    if stat.S_ISREG(mode):
        return
    what = next((name for is_so, name in _KINDS if is_so(mode)), "something else")
    raise StructureError(f"{name_of(path)}: this is {what}, not a structure file{_inside(path)}")


def _inside(path: Path) -> str:
    """What a folder has for those who meant its files; "" for what is none."""
    if not path.is_dir():
        return ""
    try:
        first = structure_files(path)[0].name
    except ValueError:
        return ", and holds none"
    return f"; give the files in it, such as {printable(first)}"


def _absent(path: Path) -> str:
    """What to do about a file that is not there, where its name is that of an entry of the PDB."""
    if _ENTRY.fullmatch(path.name) is None:
        return "there is no such file"
    entry = path.name.upper() if len(path.name) == 4 else path.name.lower()
    return (
        "there is no such file, and nothing is downloaded: if this is an entry of the PDB, fetch"
        f" https://files.rcsb.org/download/{entry}.cif and give that file"
    )
