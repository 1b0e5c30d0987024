"""The journal of a run: one line of JSON per finished file, never rewritten.

A killed run may leave half a line at the end; it is cut off when the journal is opened again.
Records stay on disk; only where each begins is kept in memory.
"""

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

Record = dict[str, Any]


class Journal:
    """Records by key, appended to a file.

    Parameters
    ----------
    path : Path
        The file; its folder must exist.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._begins: dict[str, int] = {}
        whole = 0
        if path.exists():
            with path.open("rb") as file:
                for line in file:
                    key = _key(line)
                    if key is None:
                        break
                    self._begins[key] = whole
                    whole += len(line)
            os.truncate(path, whole)

    def __contains__(self, key: str) -> bool:
        """Whether a file with this key is finished."""
        return key in self._begins

    def __getitem__(self, key: str) -> Record:
        """The record of a finished file, read from disk."""
        with self.path.open("rb") as file:
            file.seek(self._begins[key])
            record: Record = json.loads(file.readline())
        return record

    def add(self, key: str, record: Record) -> None:
        """Append a record; it is on disk when this returns.

        Parameters
        ----------
        key : str
            Digest of the file and of what is done.
        record : dict
            JSON-ready.
        """
        line = json.dumps({"key": key, **record}, allow_nan=False, ensure_ascii=False) + "\n"
        with self.path.open("ab") as file:
            begin = file.tell()
            # of a file name that is no UTF-8 an escape is left, which JSON reads back
            file.write(line.encode(errors="backslashreplace"))
            file.flush()
            os.fsync(file.fileno())
        self._begins[key] = begin

    def records(self, keys: list[str]) -> Iterator[Record]:
        """The records of these keys, in their order; keys without one are left out."""
        return (self[key] for key in keys if key in self)


def _key(line: bytes) -> str | None:
    """Key of a whole line; None where it is cut or no record."""
    if not line.endswith(b"\n"):
        return None
    try:
        return str(json.loads(line)["key"])
    except (ValueError, KeyError, TypeError):
        return None
