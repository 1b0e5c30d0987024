"""Loops of structures on their way into a library: which are taken, and why others are not."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

import numpy as np
from scipy.spatial.distance import pdist

from loopelastica._arrays import read_only
from loopelastica._names import printable
from loopelastica.errors import LoopelasticaError, StructureError
from loopelastica.folding.library import MAX_NUCLEOTIDES, MIN_NUCLEOTIDES, Library
from loopelastica.folding.shape_table import FoundLoop
from loopelastica.molecule.clamp_rule import plain_clamp
from loopelastica.molecule.folders import structure_files
from loopelastica.molecule.hairpins import Hairpin, find_hairpins
from loopelastica.molecule.identity import entry_of
from loopelastica.molecule.nucleotides import Nucleotides, Structure, read_structure
from loopelastica.molecule.shapes import LoopShape, loop_shape

STEP_A: Final = (2.5, 9.0)
"""Distances of neighbouring centroids in a sound chain; no two others are nearer than the first."""

# of what is written: the files that shapes are from have three decimals
_DECIMALS = 6


def loop_rows(
    structure: Structure, entry: str, with_contacts: bool = False
) -> list[dict[str, Any]]:
    """A row for each loop of the first model of a structure, with the reason where it is left out.

    Parameters
    ----------
    structure : Structure
        What was read.
    entry : str
        What its loops are said to be from.
    with_contacts : bool
        Take loops too that make a canonical pair elsewhere.

    Returns
    -------
    list of dict
        JSON-ready; :func:`found_loop` makes a shape of one that is not left out.
    """
    found = find_hairpins(structure, min_loop=MIN_NUCLEOTIDES, max_loop=MAX_NUCLEOTIDES)
    return [_row(structure, hairpin, entry, with_contacts) for hairpin in found]


def found_loop(row: Mapping[str, Any]) -> FoundLoop:
    """The loop of a row that is not left out."""
    steps, frame = read_only(row["steps_A"]), read_only(row["end_frame"])
    shape = LoopShape(row["sequence"], row["kind"] == "DNA", steps, frame, row["source"])
    return FoundLoop(shape, row["entry"], row["stem_rms_A"])


def library_of_folder(folder: Path) -> Library:
    """The library of the loops in the structures of a folder, made where it is needed.

    A process reads a folder once, unless a file in it changes. Files that cannot be read are passed
    over: ``loopelastica library build`` names them, and keeps the library.

    Parameters
    ----------
    folder : Path
        PDB and mmCIF files, and folders of them.

    Returns
    -------
    Library

    Raises
    ------
    LoopelasticaError
        If no structure of the folder has a loop.
    """
    try:
        files = structure_files(folder, deep=True, argument="library")
    except ValueError as error:
        raise LoopelasticaError(str(error)) from None
    stamps = tuple((path, path.stat().st_mtime_ns, path.stat().st_size) for path in files)
    return _gathered(folder, stamps)


@lru_cache(maxsize=2)
def _gathered(folder: Path, stamps: tuple[tuple[Path, int, int], ...]) -> Library:
    rows: list[dict[str, Any]] = []
    failed = 0
    for path, *_ in stamps:
        try:
            rows += loop_rows(read_structure(path), entry_of(path))
        except LoopelasticaError:
            failed += 1
    library = Library.of(found_loop(row) for row in rows if row["left_out"] is None)
    if not library:
        raise LoopelasticaError(
            f"{printable(str(folder))}: none of its {len(stamps)} structures has a loop for a"
            f" library ({failed} cannot be read)"
        )
    return library


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
