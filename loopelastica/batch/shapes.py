"""The work of ``loopelastica library build``: the loops of many files, and a library of them."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from loopelastica._checks import flag, instance, shown
from loopelastica.batch.journal import Record
from loopelastica.batch.run import Work, run
from loopelastica.batch.tasks import Task, tasks_of
from loopelastica.batch.workers import check_workers
from loopelastica.errors import LoopelasticaError
from loopelastica.folding.gathering import found_loop, loop_rows
from loopelastica.folding.library import MAX_NUCLEOTIDES, MIN_NUCLEOTIDES, Library
from loopelastica.folding.library_file import check_place, save_library
from loopelastica.folding.shape_table import COPY_A, FoundLoop
from loopelastica.molecule.folders import distinct, structure_files
from loopelastica.molecule.identity import entry_of
from loopelastica.molecule.nucleotides import Limits, read_structure

COLUMNS = ("file", "loop", "entry", "kind", "nucleotides", "sequence", "stem_rms_A", "left_out")


def shape_file(task: Task) -> Record:
    """The shapes of all loops of a file; a row per loop, with the reason where it is left out.

    ``task.options`` holds `with_contacts`, and the limits of a file. Beside the columns of the
    table a row has ``source``, ``steps_A`` and ``end_frame``.
    """
    source = Path(task.source)
    options = dict(task.options)
    with_contacts = options.pop("with_contacts")
    limits = Limits(**options)
    structure = read_structure(source, limits)
    return {"rows": loop_rows(structure, entry_of(source), with_contacts), "failures": []}


SHAPES = Work("loops", shape_file, COLUMNS, lambda task, record: True)


@dataclass(frozen=True, slots=True, eq=False)
class LibraryBuild:
    """What has come of many files.

    Attributes
    ----------
    library : Library
        What was written.
    table : Path
        A row per loop found.
    n_files, n_resumed : int
        Files; those that were done before.
    failed : tuple of dict
        ``file`` and ``failure``, a sentence, for each file that failed.
    notes : tuple of str
        One sentence for what was left out, and why.
    """

    library: Library
    table: Path
    n_files: int
    n_resumed: int
    failed: tuple[dict[str, str], ...]
    notes: tuple[str, ...]

    @property
    def failures(self) -> tuple[str, ...]:
        """One sentence for each file that failed."""
        return tuple(failure["failure"] for failure in self.failed)


def build_library(
    sources: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
    out: str | os.PathLike[str],
    *,
    with_contacts: bool = False,
    jobs: int = 1,
    scheduler: str | None = None,
    progress: bool = False,
    limits: Limits | None = None,
    wording: Callable[[str], str] = str,
) -> LibraryBuild:
    """Make a library of the hairpin loops of many structures.

    Taken are loops of 3 to 12 nucleotides in the first model of a file, all atoms of whose backbone
    are there, on a stem that is an A or B helix, with no canonical pair elsewhere, and in a sound
    chain. Of copies of a loop in one entry (same sequence, nodes within 0.5 Å RMS) the first by
    chain and number is kept.

    Beside the library, in the folder ``<out>.run``, stand ``loops.csv``, a row for each loop with
    the reason where it is left out, ``failures.csv``, and the journal from which the same call goes
    on if it was stopped. The library itself is written whole in the end.

    Parameters
    ----------
    sources : path or iterable of path
        PDB and mmCIF files, gzipped or not, and folders of them; what is in their folders counts
        too, but for hidden folders and results of this program.
    out : path
        The library, such as loops.lib.
    with_contacts : bool
        Take loops too that make a canonical pair elsewhere.
    jobs : int
        How many processes.
    scheduler : str, optional
        As for :func:`loopelastica.batch.workers.outcomes`.
    progress : bool
        Show a bar.
    limits : Limits, optional
        How large a file may be.
    wording : callable
        As for :func:`loopelastica.batch.run.run`.

    Returns
    -------
    LibraryBuild

    Raises
    ------
    ValueError
        If `sources` is empty or has a folder without structures, or an argument cannot be
        understood.
    TakenError
        If a file is in the place of the library that is none.
    LoopelasticaError
        If there is no loop for it; no library is written then. If the run ends early.

    Examples
    --------
    >>> import tempfile
    >>> from loopelastica._files import data_path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     print(build_library(data_path("hairpins/2koc.pdb"), f"{folder}/loops.lib").library)
    <Library of 1 loop: RNA4>
    """
    if not isinstance(out, str | os.PathLike):
        raise ValueError(f"`out` is {shown(out)}; it must be a path")
    out = Path(out)
    limits = instance("limits", Limits() if limits is None else limits, Limits)
    options = {"with_contacts": flag("with_contacts", with_contacts), **asdict(limits)}
    check_workers(jobs, scheduler)
    files, again = distinct(_files(sources))
    check_place(out)
    folder = out.with_name(f"{out.name}.run")
    done = run(SHAPES, tasks_of(files, options, folder), folder, jobs, scheduler, progress, wording)
    loops: list[FoundLoop] = []
    left_out: Counter[str] = Counter()
    with_loop = set()
    for row in done.rows:
        with_loop.add(row["file"])
        if row["left_out"] is None:
            loops.append(found_loop(row))
        else:
            left_out[row["left_out"]] += 1
    library = Library.of(loops)
    notes = [*_left_out(left_out, len(loops) - len(library))]
    if none := max(done.n_files - len(with_loop) - len(done.failures), 0):
        have = "1 file has" if none == 1 else f"{none} files have"
        notes.append(f"{have} no loop of {MIN_NUCLEOTIDES} to {MAX_NUCLEOTIDES} nucleotides")
    if not library:
        causes = "; ".join([*done.failures[:1], *notes])
        raise LoopelasticaError(f"{out}: no library is written, for there is no loop: {causes}")
    save_library(library, out)
    return LibraryBuild(
        library,
        done.table,
        done.n_files,
        done.n_resumed,
        done.failed,
        (*again, *done.notes, *notes),
    )


def _files(sources: Any) -> list[Path]:
    if isinstance(sources, str | os.PathLike):
        sources = [sources]
    try:
        given = list(sources)
    except TypeError:
        given = []
    if not given or not all(isinstance(source, str | os.PathLike) for source in given):
        raise ValueError(f"`sources` is {shown(sources)}; it must be one or more paths")
    return [
        file
        for path in map(Path, given)
        for file in (
            structure_files(path, deep=True, argument="sources") if path.is_dir() else [path]
        )
    ]


def _left_out(reasons: Counter[str], n_copies: int) -> Iterator[str]:
    for reason, count in sorted(reasons.items()):
        what = "1 loop is" if count == 1 else f"{count} loops are"
        more = "; `with_contacts` takes such loops" if "elsewhere" in reason else ""
        yield f"{what} left out: {reason}{more}"
    if n_copies:
        what = "1 loop is a copy" if n_copies == 1 else f"{n_copies} loops are copies"
        yield f"{what} of another one of the same entry, within {COPY_A} Å, and left out"
