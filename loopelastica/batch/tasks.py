"""The files of a run, each once, and what is to be done with them."""

import hashlib
import json
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from loopelastica._names import printable, safe_stem
from loopelastica._version import __version__
from loopelastica.molecule.folders import structure_files


@dataclass(frozen=True, slots=True)
class Task:
    """One file and what is to be done with it.

    Attributes
    ----------
    source : str
        Absolute path of the file: workers may be at home in other folders.
    number : int
        1, or 2, 3 … for further files of the same name.
    options : dict
        Options of the work, JSON-ready.
    out : str
        Folder of the run.
    file : str
        The path as the user gave it, for tables and sentences.
    beside : tuple of str
        Further files that the result depends on, such as a template, and folders of structures.
    """

    source: str
    number: int
    options: dict[str, Any]
    out: str
    file: str
    beside: tuple[str, ...] = ()

    def __str__(self) -> str:
        return self.source

    def as_given(self, sentence: str, out: Path) -> str:
        """A sentence about the file or its results, with the paths as they were given."""
        # reading shows names in one line
        names = self.source, printable(self.source)
        for absolute, given in (
            *((f"{name}: ", f"{self.file}: ") for name in names),
            (self.out, str(out)),
        ):
            if sentence.startswith(absolute):
                return given + sentence[len(absolute) :]
        return sentence

    @property
    def key(self) -> str:
        """Digest of the file's content and of all that determines the result."""
        digest = hashlib.sha256()
        digest.update(_content(self.source))
        for place in self.beside:
            digest.update(_listing(place) if os.path.isdir(place) else _content(place))
        what = [self.source, self.number, self.options, __version__]
        digest.update(json.dumps(what, sort_keys=True).encode())
        return digest.hexdigest()[:24]


def _content(file: str) -> bytes:
    """Digest of a file's content."""
    try:
        # a pipe would block
        if not Path(file).is_file():
            raise OSError
        with Path(file).open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").digest()
    except OSError:
        return b"unreadable"


def _listing(folder: str) -> bytes:
    """Digest of which structures a folder holds, and when each was written."""
    try:
        stats = [(str(path), path.stat()) for path in structure_files(Path(folder), deep=True)]
    except (OSError, ValueError):
        return b"unreadable"
    return repr([(path, at.st_mtime_ns, at.st_size) for path, at in stats]).encode()


def tasks_of(
    sources: Iterable[str | Path],
    options: dict[str, Any],
    out: Path,
    beside: Iterable[str | None] = (),
) -> list[Task]:
    """One task per file.

    Parameters
    ----------
    sources : iterable of str or Path
        Files of one name are numbered in their order.
    options : dict
        Options of the work, JSON-ready.
    out : Path
        Folder of the run.
    beside : iterable of str or None
        Further files, or folders of structures, that all results depend on; None counts for
        none.

    Returns
    -------
    list of Task
    """
    further = tuple(os.path.abspath(file) for file in beside if file is not None)
    seen: dict[str, int] = {}
    tasks = []
    for source in map(str, sources):
        stem = safe_stem(Path(source))
        seen[stem] = seen.get(stem, 0) + 1
        absolute, folder = os.path.abspath(source), os.path.abspath(out)
        tasks.append(Task(absolute, seen[stem], options, folder, source, further))
    return tasks
