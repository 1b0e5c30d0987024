"""A resumable run over files: journal, growing table, final tables."""

import csv
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from loopelastica._files import NO_UTF8, NOTE, cells, refuse_other, whole_file, write_csv, writing
from loopelastica._progress import progress_bar
from loopelastica.batch.journal import Journal, Record
from loopelastica.batch.lock import alone_in
from loopelastica.batch.tasks import Task
from loopelastica.batch.workers import check_workers, outcomes
from loopelastica.errors import LoopelasticaError
from loopelastica.report.page.write import renew_report

Row = Mapping[str, Any]
FAILURE_COLUMNS = ("file", "failure")


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
    records : iterator of dict
        What has become of each file that is done, with its ``file``, in the same order.
    n_files, n_done, n_resumed, n_rows : int
        Files; those that are done, and need not be done again; those that were done before; rows
        of the table.
    failed : tuple of dict
        ``file`` and ``failure``, a sentence, for each file or loop that failed.
    notes : tuple of str
        One sentence for each thing about the run that a user should be aware of.
    page : Path or None
        Its report.html.
    """

    table: Path
    rows: Iterator[Row]
    records: Iterator[Row]
    n_files: int
    n_done: int
    n_resumed: int
    n_rows: int
    failed: tuple[dict[str, str], ...]
    notes: tuple[str, ...]
    page: Path | None = None

    @property
    def failures(self) -> tuple[str, ...]:
        """One sentence for each file or loop that failed."""
        return tuple(failure["failure"] for failure in self.failed)

    @property
    def so_far(self) -> str:
        """What is done, where something has ended the run."""
        return (
            f"{self.n_done} of {self.n_files} files are done and kept, and the same command goes on"
            " from there"
        )


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
        known = set(self.done)
        waiting = [task for key, task in self.tasks.items() if key not in known]
        write_csv(self.table, self.rows(), self.work.columns)
        total = len(self.tasks)
        with (
            progress_bar(total=total, initial=len(known), shown=progress, unit="file") as bar,
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
        for record in self.records():
            for row in record["rows"]:
                yield {**row, "file": record["file"]}

    def records(self) -> Iterator[Row]:
        """Records of what is done, in the order of the input."""
        done = set(self.done)
        for key, task in self.tasks.items():
            if key in done:
                yield {**self.journal[key], "file": task.file}

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
        failed = tuple(self._failures())
        write_csv(self.failures, failed, FAILURE_COLUMNS)
        _write_parquet(self.table)
        notes = list(self._notes())
        if damaged := self.journal.damaged:
            lines = "a line is" if damaged == 1 else f"{damaged} lines are"
            notes.append(f"{self.journal.path}: {lines} damaged; what stood there is done again")
        return Run(
            self.table,
            self.rows(),
            self.records(),
            len(self.tasks),
            len(self.done),
            self.n_resumed,
            n_rows,
            failed,
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
