"""A resumable run over files: journal, growing table, final table."""

import csv
import hashlib
import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from loopelastica._files import whole_file, write_csv
from loopelastica._version import __version__
from loopelastica.batch.journal import Journal, Record
from loopelastica.batch.workers import outcomes


@dataclass(frozen=True, slots=True)
class Task:
    """One file and what is to be done with it.

    Attributes
    ----------
    source : str
        Path of the file.
    number : int
        1, or 2, 3 … for further files of the same name.
    options : dict
        Options of the work, JSON-ready.
    out : str
        Folder of the run.
    """

    source: str
    number: int
    options: dict[str, Any]
    out: str

    def __str__(self) -> str:
        return self.source

    @property
    def key(self) -> str:
        """Digest of the file's content and of all that determines the result."""
        digest = hashlib.sha256()
        try:
            # a pipe would block
            if not Path(self.source).is_file():
                raise OSError
            with Path(self.source).open("rb") as file:
                digest.update(hashlib.file_digest(file, "sha256").digest())
        except OSError:
            digest.update(b"unreadable")
        what = [self.source, self.number, self.options, __version__]
        digest.update(json.dumps(what, sort_keys=True).encode())
        return digest.hexdigest()[:24]


@dataclass(frozen=True, slots=True)
class Work:
    """What is done with each file, and the table that comes of it.

    Attributes
    ----------
    name : str
        Stem of the table's name, such as "candidates".
    function : callable
        Task → record with ``rows`` and ``failures``; importable by name.
    columns : tuple of str
        Columns of the table; further entries of a row stay in the journal.
    intact : callable
        Task, record → whether what the record speaks of is still there.
    """

    name: str
    function: Callable[[Task], Record]
    columns: tuple[str, ...]
    intact: Callable[[Task, Record], bool]


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """What a run has done.

    Attributes
    ----------
    table : Path
        Its table.
    records : iterator of dict
        What is in the journal, file by file in the order of the input.
    n_files, n_resumed, n_rows : int
        Files; those found done; rows of the table.
    failures : tuple of str
        One sentence for each file or loop that failed.
    """

    table: Path
    records: Iterator[Record]
    n_files: int
    n_resumed: int
    n_rows: int
    failures: tuple[str, ...]


def tasks_of(sources: Iterable[Path], options: dict[str, Any], out: Path) -> list[Task]:
    """One task per file.

    Parameters
    ----------
    sources : iterable of Path
        Files of one name are numbered in their order.
    options : dict
        Options of the work, JSON-ready.
    out : Path
        Folder of the run.

    Returns
    -------
    list of Task
    """
    seen: dict[str, int] = {}
    tasks = []
    for source in sources:
        stem = source.name.removesuffix(".gz").rsplit(".", 1)[0]
        seen[stem] = seen.get(stem, 0) + 1
        tasks.append(Task(str(source.resolve()), seen[stem], options, str(out.resolve())))
    return tasks


def run(
    work: Work,
    tasks: Sequence[Task],
    out: Path,
    jobs: int = 1,
    scheduler: str | None = None,
    progress: bool = False,
) -> Run:
    """Do the work on every file that is not in the journal in `out` yet.

    Writes ``<name>.csv`` (rows as they come, in the end in the order of the input),
    ``failures.csv``, and ``<name>.parquet`` where pandas and pyarrow are installed.

    Parameters
    ----------
    work : Work
        What to do.
    tasks : sequence of Task
        The files.
    out : Path
        Folder of journal and tables; made if absent.
    jobs, scheduler
        As for :func:`loopelastica.batch.workers.outcomes`.
    progress : bool
        Show a bar.

    Returns
    -------
    Run

    Raises
    ------
    MissingDependencyError
        If dask is needed and not installed.
    ValueError
        If `jobs` is below 1 or the scheduler cannot be reached.
    """
    from tqdm import tqdm

    out.mkdir(parents=True, exist_ok=True)
    journal = Journal(out / f".{work.name}.journal")
    table = out / f"{work.name}.csv"
    keys = [task.key for task in tasks]
    done = [
        key
        for key, task in zip(keys, tasks, strict=True)
        if key in journal and work.intact(task, journal[key])
    ]
    known = set(done)
    waiting = [task for key, task in zip(keys, tasks, strict=True) if key not in known]
    _write_rows(table, work.columns, journal.records(done))
    again = []
    with (
        table.open("a", newline="", encoding="utf-8") as file,
        tqdm(total=len(tasks), initial=len(done), disable=not progress, unit="file") as bar,
    ):
        writer = csv.DictWriter(file, work.columns, extrasaction="ignore", lineterminator="\n")
        for outcome in outcomes(work.function, waiting, jobs, scheduler):
            bar.update()
            if not outcome.final:
                again.append({"file": outcome.task.source, "failure": outcome.failure})
                continue  # not in the journal: the next run tries it again
            record = outcome.value or {"rows": [], "failures": [outcome.failure]}
            journal.add(outcome.task.key, {"file": outcome.task.source, **record})
            writer.writerows(record["rows"])
            file.flush()
    n_rows = _write_rows(table, work.columns, journal.records(keys))
    failures = [
        {"file": record["file"], "failure": sentence}
        for record in journal.records(keys)
        for sentence in record["failures"]
    ] + again
    write_csv(out / "failures.csv", failures, ("file", "failure"))
    _write_parquet(table)
    return Run(
        table,
        journal.records(keys),
        len(tasks),
        len(done),
        n_rows,
        tuple(f["failure"] for f in failures),
    )


def _write_rows(table: Path, columns: tuple[str, ...], records: Iterator[Record]) -> int:
    return write_csv(table, (row for record in records for row in record["rows"]), columns)


def _write_parquet(table: Path) -> None:
    try:
        import pandas
        import pyarrow  # noqa: F401 - what pandas writes parquet with
    except ImportError:
        return  # the extra `table` is not installed
    with whole_file(table.with_suffix(".parquet")) as part:
        pandas.read_csv(table, low_memory=False).to_parquet(part, index=False)
