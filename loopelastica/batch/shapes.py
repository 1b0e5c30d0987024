"""The work of ``loopelastica library build``: the loops of many files, and a library of them."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from scipy.spatial.distance import pdist

from loopelastica._arrays import read_only
from loopelastica._checks import flag, instance, shown
from loopelastica.batch.journal import Record
from loopelastica.batch.run import Row, Task, Work, distinct, run, tasks_of
from loopelastica.batch.sources import structure_files
from loopelastica.batch.workers import check_workers
from loopelastica.errors import LoopelasticaError, StructureError
from loopelastica.folding.library import MAX_NUCLEOTIDES, MIN_NUCLEOTIDES, Library
from loopelastica.folding.library_file import check_place, save_library
from loopelastica.folding.shape_table import COPY_A, FoundLoop
from loopelastica.molecule.clamp_rule import plain_clamp
from loopelastica.molecule.hairpins import Hairpin, find_hairpins
from loopelastica.molecule.identity import entry_of
from loopelastica.molecule.nucleotides import Limits, Nucleotides, Structure, read_structure
from loopelastica.molecule.shapes import LoopShape, loop_shape

STEP_A: Final = (2.5, 9.0)
"""Distances of neighbouring centroids in a sound chain; no two others are nearer than the first."""

COLUMNS = ("file", "loop", "entry", "kind", "nucleotides", "sequence", "stem_rms_A", "left_out")

# of what is written: the files that shapes are from have three decimals
_DECIMALS = 6


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
    found = find_hairpins(structure, min_loop=MIN_NUCLEOTIDES, max_loop=MAX_NUCLEOTIDES)
    entry = entry_of(source)
    return {"rows": [_row(structure, h, entry, with_contacts) for h in found], "failures": []}


def _row(structure: Structure, hairpin: Hairpin, entry: str, with_contacts: bool) -> dict[str, Any]:
    table = structure.nucleotides
    source = f"{entry} {_place(table, hairpin)}"
    row: dict[str, Any] = {
        "loop": hairpin.name,
        "entry": entry,
        "kind": hairpin.kind,
        "nucleotides": len(hairpin),
        "sequence": hairpin.sequence.replace("T", "U"),
        "stem_rms_A": None,
    }
    try:
        made = loop_shape(table, hairpin, structure.positions(0), source)
    except StructureError:
        return {**row, "left_out": "its stem cannot be placed"}
    if made is None:
        return {**row, "left_out": "a backbone atom is missing"}
    shape, stem = made
    ends = stem.ends(plain_clamp(hairpin.is_dna))
    reasons = (
        (bool(hairpin.contacts) and not with_contacts, "it pairs elsewhere"),
        (not ends.regular, "its stem is no A or B helix"),
        (not _is_sound(shape), "its chain is broken or runs into itself"),
    )
    return {
        **row,
        "stem_rms_A": ends.rms_A,
        "left_out": next((reason for holds, reason in reasons if holds), None),
        "source": source,
        "steps_A": np.round(shape.steps_A, _DECIMALS).tolist(),
        "end_frame": shape.end_frame.tolist(),
    }


def _place(table: Nucleotides, hairpin: Hairpin) -> str:
    """The closing nucleotides, such as "A.4-A.9"."""
    chain = f"{hairpin.chain}." if hairpin.chain else ""
    first, last = (table.number(int(rows[0])) for rows in (hairpin.stem_5, hairpin.stem_3))
    return f"{chain}{first}-{chain}{last}"


def _is_sound(shape: LoopShape) -> bool:
    shortest, longest = STEP_A
    steps = np.linalg.norm(shape.steps_A, axis=1)
    return bool(pdist(shape.nodes_A).min() >= shortest and steps.max() <= longest)


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
    failures, notes : tuple of str
        One sentence for each file that failed; for what was left out, and why.
    """

    library: Library
    table: Path
    n_files: int
    n_resumed: int
    failures: tuple[str, ...]
    notes: tuple[str, ...]


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
    jobs, scheduler
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
    ...     print(build_library(data_path("hairpins"), f"{folder}/loops.lib").library)
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
            loops.append(_loop(row))
        else:
            left_out[row["left_out"]] += 1
    library = Library.of(loops)
    notes = [*_left_out(left_out, len(loops) - len(library))]
    if none := done.n_files - len(with_loop):
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
        done.failures,
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


def _loop(row: Row) -> FoundLoop:
    steps, frame = read_only(row["steps_A"]), read_only(row["end_frame"])
    shape = LoopShape(row["sequence"], row["kind"] == "DNA", steps, frame, row["source"])
    return FoundLoop(shape, row["entry"], row["stem_rms_A"])


def _left_out(reasons: Counter[str], n_copies: int) -> Iterator[str]:
    for reason, count in sorted(reasons.items()):
        what = "1 loop is" if count == 1 else f"{count} loops are"
        more = "; `with_contacts` takes such loops" if "elsewhere" in reason else ""
        yield f"{what} left out: {reason}{more}"
    if n_copies:
        what = "1 loop is a copy" if n_copies == 1 else f"{n_copies} loops are copies"
        yield f"{what} of another one of the same entry, within {COPY_A} Å, and left out"
