"""The journal of a run: one line of JSON per finished file, never rewritten.

A killed run may leave half a line at the end; it is cut off when the journal is opened again. Each
line carries a checksum. One that is damaged, wherever it stands and however, is passed over, and
its file is done again. Records stay on disk; only where each begins is kept in memory.
"""

import hashlib
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from loopelastica._files import writing

Record = dict[str, Any]


class Journal:
    """Records by key, appended to a file.

    Parameters
    ----------
    path : Path
        The file; its folder must exist.

    Attributes
    ----------
    damaged : int
        Lines that were found to be no records.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.damaged = 0
        self._begins: dict[str, int] = {}
        begin = whole = 0
        if not path.exists():
            return
        with path.open("rb") as file:
            for line in file:
                begin, whole = whole, whole + len(line)
                if not line.endswith(b"\n"):
                    whole = begin
                    break
                record = _record(line)
                if record is None:
                    self.damaged += 1
                else:
                    self._begins[record["key"]] = begin
        with writing(path):
            os.truncate(path, whole)

    def __contains__(self, key: str) -> bool:
        """Whether a file with this key is finished."""
        return key in self._begins

    def __getitem__(self, key: str) -> Record:
        """The record of a finished file, read from disk."""
        with self.path.open("rb") as file:
            file.seek(self._begins[key])
            record = _record(file.readline())
        assert record is not None
        return record

    def add(self, key: str, record: Record) -> None:
        """Append a record; it is on disk when this returns.

        Parameters
        ----------
        key : str
            Digest of the file and of what is done.
        record : dict
            JSON-ready.

        Raises
        ------
        OutputError
            If it cannot be written.
        """
        content = {"key": key, **record}
        line = json.dumps({"check": _check(content), **content}, allow_nan=False) + "\n"
        with writing(self.path), self.path.open("ab") as file:
            begin = file.tell()
            # of a file name that is no UTF-8 an escape is left, which JSON reads back
            file.write(line.encode(errors="backslashreplace"))
            file.flush()
            os.fsync(file.fileno())
        self._begins[key] = begin

    def records(self, keys: list[str]) -> Iterator[Record]:
        """The records of these keys, in their order; keys without one are left out."""
        return (self[key] for key in keys if key in self)


def _check(content: Record) -> str:
    return hashlib.sha256(json.dumps(content, allow_nan=False).encode()).hexdigest()[:16]


def _record(line: bytes) -> Record | None:
    """The record of a line; None where it is damaged."""
    try:
        record: Record = json.loads(line)
        return record if record.pop("check") == _check(record) else None
    # whatever a line of other text, other JSON or other types provokes
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None
