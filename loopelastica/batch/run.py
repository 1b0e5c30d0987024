"""A resumable run over files: journal, growing table, final tables."""

import csv
import hashlib
import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from loopelastica._files import NO_UTF8, NOTE, cells, refuse_other, whole_file, write_csv, writing
from loopelastica._names import printable, safe_stem
from loopelastica._version import __version__
from loopelastica.batch.journal import Journal, Record
from loopelastica.batch.lock import alone_in
from loopelastica.batch.workers import check_workers, outcomes
from loopelastica.errors import LoopelasticaError
from loopelastica.molecule.folders import structure_files
from loopelastica.report.page.write import renew_report

Row = Mapping[str, Any]
FAILURE_COLUMNS = ("file", "failure")


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


@dataclass(frozen=True, slots=True)
class Work:
    """What is done with each file, and the table that comes of it.

    Attributes
    ----------
    name : str
        Stem of the table's name, such as "summary".
    function : callable
        Task → record with ``rows`` and ``failures``, and perhaps ``notes``; importable by name.
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
    rows : iterator of dict
        Of the journal, with all entries, in the order of the input.
    n_files, n_done, n_resumed, n_rows : int
        Files; those that are done, and need not be done again; those that were done before; rows
        of the table.
    failures : tuple of str
        One sentence for each file or loop that failed.
    notes : tuple of str
        One sentence for each thing about the run that a user should be aware of.
    page : Path or None
        Its report.html.
    """

    table: Path
    rows: Iterator[Row]
    n_files: int
    n_done: int
    n_resumed: int
    n_rows: int
    failures: tuple[str, ...]
    notes: tuple[str, ...]
    page: Path | None = None

    @property
    def so_far(self) -> str:
        """What is done, where something has ended the run."""
        return (
            f"{self.n_done} of {self.n_files} files are done and kept, and the same command goes on"
            " from there"
        )


def distinct(sources: Iterable[str | Path]) -> tuple[list[str], list[str]]:
    """Each file once, however often and by whatever path it is given.

    Parameters
    ----------
    sources : iterable of str or Path
        Relative or absolute, symbolic links too.

    Returns
    -------
    first : list of str
        The path by which each file was given first, in their order.
    notes : list of str
        One sentence for each that was left out.
    """
    first: dict[str, str] = {}
    notes = []
    for source in map(str, sources):
        place = os.path.realpath(source)
        if place in first:
            known = first[place]
            same = "was given before" if known == source else f"is the same file as {known}"
            notes.append(f"{source} {same}; it counts once")
        else:
            first[place] = source
    return list(first.values()), notes


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


def check_tables(out: Path, name: str) -> None:
    """Refuse to put the tables of a run in the place of files that are none.

    Parameters
    ----------
    out : Path
        Folder of the run.
    name : str
        Of its table.

    Raises
    ------
    TakenError
        If a file there does not begin as a table of this program does.
    """
    begins = {f"{name}.csv": b"file,", "failures.csv": b"file,failure", f"{name}.parquet": b"PAR1"}
    for table, begin in begins.items():
        refuse_other(out / table, begin)


def run(
    work: Work,
    tasks: Sequence[Task],
    out: Path,
    jobs: int = 1,
    scheduler: str | None = None,
    progress: bool = False,
    wording: Callable[[str], str] = str,
    report: bool = False,
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
    wording : callable
        Sentence → sentence, for those of failures: how options are called where the user sees them.
    report : bool
        End with report.html, however the run ends; the options of the tasks say whether folders
        get what it shows.

    Returns
    -------
    Run

    Raises
    ------
    MissingDependencyError
        If dask is needed and not installed.
    ValueError
        If `jobs` is no whole number, 1 or more, or `scheduler` no address.
    LoopelasticaError
        If another run is at work in the folder; or the scheduler, all workers or the disk end this
        one early. The tables then hold what is done, and a further run goes on from there.
    KeyboardInterrupt
        As before, with a sentence.
    """
    jobs = check_workers(jobs, scheduler)
    with alone_in(out):
        book = _Book(work, tasks, out, wording, report)
        try:
            book.work_off(jobs, scheduler, progress)
        except KeyboardInterrupt:
            raise KeyboardInterrupt(book.close().so_far) from None
        except (LoopelasticaError, OSError) as error:
            raise LoopelasticaError(f"{error}; {book.close().so_far}") from None
        return book.close()


class _Book:
    """Journal and tables of a run under way."""

    def __init__(
        self,
        work: Work,
        tasks: Sequence[Task],
        out: Path,
        wording: Callable[[str], str],
        report: bool = False,
    ) -> None:
        self.work, self.out, self.wording, self.report = work, out, wording, report
        self.table = out / f"{work.name}.csv"
        self.failures = out / "failures.csv"
        check_tables(out, work.name)
        for suffix in (".csv", ".parquet"):
            # tables that a killed run has begun
            for begun in out.glob(f"{NOTE}-*{suffix}"):
                begun.unlink(missing_ok=True)
        self.journal = Journal(out / f".{work.name}.journal")
        self.tasks = {task.key: task for task in tasks}
        # a file that changes meanwhile is done again by the next run: its key is that of the start
        self.keys = {(task.source, task.number): key for key, task in self.tasks.items()}
        self.done = [
            key
            for key, task in self.tasks.items()
            if key in self.journal and work.intact(task, self.journal[key])
        ]
        self.n_resumed = len(self.done)
        # failures that another run may not meet again, and that the journal does not keep
        self.again: dict[str, str] = {}

    def work_off(self, jobs: int, scheduler: str | None, progress: bool) -> None:
        """Do what is not done yet; the table grows with it."""
        from tqdm import tqdm

        known = set(self.done)
        waiting = [task for key, task in self.tasks.items() if key not in known]
        write_csv(self.table, self.rows(), self.work.columns)
        total = len(self.tasks)
        with (
            tqdm(total=total, initial=len(known), disable=not progress, unit="file") as bar,
            writing(self.table),
            self.table.open("a", newline="", encoding="utf-8", errors=NO_UTF8) as file,
            ExitStack() as stack,
        ):
            writer = csv.DictWriter(
                file, self.work.columns, extrasaction="ignore", lineterminator="\n"
            )
            if not waiting:
                return
            # no more processes than files, but never this one where others are wanted
            few = jobs if jobs == 1 else max(2, min(jobs, len(waiting)))
            found = stack.enter_context(
                closing(outcomes(self.work.function, waiting, few, scheduler))
            )
            for outcome in found:
                bar.update()
                task = outcome.task
                key = self.keys[task.source, task.number]
                if not outcome.final:
                    self.again[key] = outcome.failure or ""
                    continue  # not in the journal: the next run tries it again
                record = outcome.value or {"rows": [], "failures": [outcome.failure]}
                self.journal.add(key, {"file": task.source, **record})
                self.done.append(key)
                writer.writerows(cells({**row, "file": task.file}) for row in record["rows"])
                file.flush()

    def rows(self) -> Iterator[Row]:
        """Rows of what is done, in the order of the input."""
        done = set(self.done)
        for key, task in self.tasks.items():
            if key in done:
                for row in self.journal[key]["rows"]:
                    yield {**row, "file": task.file}

    def _failures(self) -> Iterator[dict[str, str]]:
        done = set(self.done)
        for key, task in self.tasks.items():
            sentences = self.journal[key]["failures"] if key in done else []
            if key in self.again:
                sentences = [self.again[key]]
            for sentence in sentences:
                yield {
                    "file": task.file,
                    "failure": self.wording(task.as_given(sentence, self.out)),
                }

    def _notes(self) -> Iterator[str]:
        done = set(self.done)
        for key, task in self.tasks.items():
            for sentence in self.journal[key].get("notes", ()) if key in done else ():
                yield task.as_given(sentence, self.out)

    def close(self) -> Run:
        """Write the tables in the order of the input."""
        n_rows = write_csv(self.table, self.rows(), self.work.columns)
        failures = list(self._failures())
        write_csv(self.failures, failures, FAILURE_COLUMNS)
        _write_parquet(self.table)
        notes = list(self._notes())
        if damaged := self.journal.damaged:
            lines = "a line is" if damaged == 1 else f"{damaged} lines are"
            notes.append(f"{self.journal.path}: {lines} damaged; what stood there is done again")
        return Run(
            self.table,
            self.rows(),
            len(self.tasks),
            len(self.done),
            self.n_resumed,
            n_rows,
            tuple(f["failure"] for f in failures),
            tuple(notes),
            renew_report(self.out, self.report),
        )


def _write_parquet(table: Path) -> None:
    try:
        import pandas
        import pyarrow  # noqa: F401 - what pandas writes parquet with
    except ImportError:
        return  # the extra `table` is not installed
    with whole_file(table.with_suffix(".parquet")) as part:
        pandas.read_csv(table, low_memory=False).to_parquet(part, index=False)
