"""The entries of a FASTA file."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from loopelastica._names import printable
from loopelastica.errors import StructureError
from loopelastica.molecule._source import Limits, name_of, pieces


class Entry(NamedTuple):
    """One entry: its name, and what stands below it."""

    name: str
    text: str

    def __str__(self) -> str:
        return self.name


def read_fasta(path: Path) -> list[Entry]:
    """The entries of a FASTA file, compressed or not, in their order.

    Parameters
    ----------
    path : Path
        Each entry has a line that begins with ">" and a name, and lines with its sequence. Lines
        that begin with ";" mean nothing.

    Returns
    -------
    list of Entry
        One without a name gets its number.

    Raises
    ------
    StructureError
        If it cannot be read, is no FASTA file, or has no entry.
    """
    where = name_of(path)
    try:
        lines = b"".join(pieces(path, Limits())).decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise StructureError(f"{where}: this is no text in UTF-8, as a FASTA file is") from None
    entries: list[tuple[str, list[str]]] = []
    for number, line in enumerate(map(str.strip, lines), start=1):
        if line.startswith(">"):
            words = line[1:].split()
            entries.append((printable(words[0]) if words else str(len(entries) + 1), []))
        elif line and not line.startswith(";"):
            if not entries:
                raise StructureError(
                    f'{where}, line {number}: no entry begins here; in a FASTA file a line with ">"'
                    " and a name comes first"
                )
            entries[-1][1].append(line)
    if not entries:
        raise StructureError(f"{where}: the file is empty; nothing to build")
    return [Entry(name, "\n".join(body)) for name, body in entries]
