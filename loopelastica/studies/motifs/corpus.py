"""The loops of a folder, as they are judged: shape, native line, rods, relatives.

A table ``loops.csv`` in the folder, with the columns file, closing_5, closing_3, sequence,
contact_elsewhere and family, says which loop of a file is meant, which loops pair with something
that the file does not show, and which are relatives; without it all hairpin loops count, and
relatives are those by sequence.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from loopelastica._arrays import Array, Record
from loopelastica._progress import progress_bar
from loopelastica.atoms.geometry import RING_OF_SUGAR
from loopelastica.atoms.measures import chi_torsion, pseudorotation, torsion_deg
from loopelastica.errors import LoopelasticaError
from loopelastica.folding.fold import fold_model
from loopelastica.folding.library import Library
from loopelastica.folding.motifs import pattern_fits
from loopelastica.folding.options import FoldOptions
from loopelastica.folding.shape_table import FoundLoop, letters_of, table_of
from loopelastica.molecule.clamp_rule import STEM_RMS_MAX_A
from loopelastica.molecule.ends import ClosingPoses
from loopelastica.molecule.folders import structure_files
from loopelastica.molecule.hairpins import Hairpin, find_hairpins
from loopelastica.molecule.identity import entry_of
from loopelastica.molecule.nucleotides import Nucleotides, Structure, read_structure
from loopelastica.molecule.shapes import loop_shape

SHORTEST, LONGEST = 3, 12
COLUMNS: Final = ("file", "sequence")
"""Without these the table of a folder says nothing."""
STEPS_A = (2.0, 9.5)
"""Beyond, two neighbouring centroids are no neighbours."""
NOT_EVIDENCE = ("2l5k",)
"""Refined with elastic models of hairpins itself."""
MOTIFS = {"GNRA": "GNRA", "UNCG": "UNCG"}
"""Motifs whose sequences are no relatives of each other by themselves."""


class StudyRod(NamedTuple):
    """A rod by the rule: its trace (n, 3) in the frame of the 5' closing nucleotide, its energy."""

    trace: Array
    energy: float


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class StudyLoop(Record):
    """One loop of the corpus.

    Attributes
    ----------
    found : FoundLoop
        Its shape, entry and stem.
    hairpin : Hairpin
    poses : ClosingPoses
        In the frame of the 5' closing nucleotide.
    native_A : (n, 3) array
        Its centroids in that frame, Å.
    rods : tuple of StudyRod
        Rods by the rule, least energy first.
    family : str
        What relatives share.
    motif : str
        "GNRA", "UNCG" or "".
    c2_endo, syn : (n,) array
        1 or 0 of each nucleotide, NaN where it is not known.
    """

    found: FoundLoop
    hairpin: Hairpin
    poses: ClosingPoses
    native_A: Array
    rods: tuple[StudyRod, ...]
    family: str
    motif: str
    c2_endo: Array
    syn: Array

    @property
    def n(self) -> int:
        """Number of loop nucleotides."""
        return len(self.native_A)

    @property
    def loop(self) -> str:
        """Kind and loop sequence: what is one case."""
        return f"{self.hairpin.kind} {self.found.shape.sequence[1:-1]}"

    def __repr__(self) -> str:
        return f"<StudyLoop {self.found.shape.source} {self.loop}>"


class Corpus(NamedTuple):
    """What a folder holds: loops by file, one of each sequence in an entry, and the rest in words.

    Attributes
    ----------
    loops : list of StudyLoop
    left_out : list of str
        A sentence for each loop that is no case of the study.
    failures : list of str
        A sentence for each file that cannot be read.
    """

    loops: list[StudyLoop]
    left_out: list[str]
    failures: list[str]


def read_corpus(folder: Path, progress: bool = False) -> Corpus:
    """The loops of a folder that can be judged.

    Parameters
    ----------
    folder : Path
        PDB and mmCIF files.
    progress : bool
        Show a bar.

    Returns
    -------
    Corpus

    Raises
    ------
    LoopelasticaError
        If the folder's table cannot be read.
    ValueError
        If `folder` holds no structure file.
    """
    table = _table(folder)
    loops, left_out, failures, seen = [], [], [], set()
    for path in progress_bar(structure_files(folder), unit="file", shown=progress):
        rows = table.get(path.name, []) if table else [{}]
        try:
            structure = read_structure(path)
            found = [pair for row in rows for pair in _named(structure, row)]
        except LoopelasticaError as error:
            failures.append(str(error))
            continue
        if not found:
            left_out.append(f"{path.name}: no such loop is found in it")
        for hairpin, row in found:
            loop = _study_loop(structure, hairpin, row, path)
            if isinstance(loop, str):
                left_out.append(f"{path.name} {hairpin.name}: {loop}")
            elif (key := (loop.found.entry, loop.hairpin.sequence)) not in seen:
                seen.add(key)
                loops.append(loop)
    return Corpus(_with_families(loops), left_out, failures)


def library_of(loops: Iterable[StudyLoop]) -> Library:
    """Their library."""
    return Library.of(loop.found for loop in loops)


def _table(folder: Path) -> dict[str, list[dict[str, str]]]:
    path = folder / "loops.csv"
    table: dict[str, list[dict[str, str]]] = {}
    if not path.is_file():
        return table
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = list(csv.DictReader(file, restval=""))
    except (UnicodeDecodeError, csv.Error) as error:
        raise LoopelasticaError(f"{path}: this is no table ({error})") from None
    missing = [name for name in COLUMNS if rows and name not in rows[0]]
    if missing or not rows:
        lack = f"column {missing[0]}" if missing else "row"
        raise LoopelasticaError(f"{path}: it has no {lack}; which loops count it cannot say")
    for row in rows:
        table.setdefault(row["file"], []).append(row)
    return table


def _named(
    structure: Structure, row: Mapping[str, str]
) -> Iterator[tuple[Hairpin, Mapping[str, str]]]:
    """The hairpins of a structure; the one that a row of the table names."""
    for hairpin in find_hairpins(structure):
        if not row:
            yield hairpin, row
        elif hairpin.sequence.replace("T", "U") == row["sequence"].replace("T", "U"):
            yield hairpin, row
            return


def _study_loop(
    structure: Structure, hairpin: Hairpin, row: Mapping[str, str], path: Path
) -> StudyLoop | str:
    """A loop as it is judged; why not, where it is not."""
    n = len(hairpin)
    entry = row.get("entry") or entry_of(path)
    if not SHORTEST <= n <= LONGEST:
        return f"it has {n} nucleotides"
    if row.get("contact_elsewhere") == "1" or (not row and hairpin.contacts):
        return "it pairs with something else"
    if entry in NOT_EVIDENCE:
        return "it was refined with elastic models of hairpins itself"
    positions = structure.positions(0)
    chain = row.get("chain") or hairpin.chain or "_"
    closing = (int(rows[0]) for rows in (hairpin.stem_5, hairpin.stem_3))
    five, three = (structure.nucleotides.number(k) for k in closing)
    source = f"{entry} {chain}.{five}-{chain}.{three}"
    try:
        shaped = loop_shape(structure.nucleotides, hairpin, positions, source)
    except LoopelasticaError as error:
        return str(error)
    if shaped is None:
        return "a backbone atom of it is missing"
    shape, stem = shaped
    rms_A = float(np.max(stem.fit_rms_A if stem.stem_rms_A is None else stem.stem_rms_A))
    if rms_A > STEM_RMS_MAX_A:
        return f"its stem is no A or B helix ({rms_A:.1f} Å)"
    lengths = np.linalg.norm(shape.steps_A, axis=1)
    if not (STEPS_A[0] < lengths.min() and lengths.max() < STEPS_A[1]):
        return "neighbouring nucleotides are no neighbours"
    poses = stem.closing()
    fold = fold_model(
        structure.nucleotides, hairpin, positions, FoldOptions(shapes="rod", max_candidates=5)
    )
    rods = [
        StudyRod((c.trace - poses.start_origin_A) @ poses.start_frame, c.line.energy)
        for c in fold.candidates
    ]
    return StudyLoop(
        FoundLoop(shape, _databank(entry), rms_A),
        hairpin,
        poses.local,
        shape.nodes_A[1:-1],
        tuple(rods),
        row.get("family", ""),
        row.get("motif", "") if row.get("motif") in MOTIFS else "",
        *_habits(structure.nucleotides, hairpin, positions),
    )


def _habits(nucleotides: Nucleotides, hairpin: Hairpin, positions: Array) -> tuple[Array, Array]:
    """Which sugars are C2'-endo, the half circle of phases about it, and which bases syn."""
    found = np.full((2, len(hairpin)), np.nan)
    for k, row in enumerate(hairpin.loop):
        ring = _atoms(nucleotides, int(row), RING_OF_SUGAR, positions)
        base = _atoms(nucleotides, int(row), chi_torsion(hairpin.sequence[k + 1]), positions)
        if ring is not None:
            found[0, k] = 90.0 < pseudorotation(*ring)[0] < 270.0
        if base is not None:
            found[1, k] = abs(torsion_deg(*base)) < 90.0
    return found[0], found[1]


def _atoms(
    nucleotides: Nucleotides, row: int, names: Sequence[str], positions: Array
) -> Array | None:
    if row < 0:
        return None
    columns = nucleotides.columns(tuple(names))[row]
    places = positions[columns]
    return places if (columns >= 0).all() and np.isfinite(places).all() else None


def _databank(entry: str) -> str:
    """The entry of the databank, for one that stands for a part of it, such as 6ha1s."""
    found = re.match(r"[0-9][0-9a-z]{3}(?=[a-z]?$)", entry.lower())
    return found[0] if found else entry.lower()


def _with_families(loops: list[StudyLoop]) -> list[StudyLoop]:
    """Families by sequence where the table has none; chains of relatives are one family."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if all(loop.family for loop in loops):
        return loops
    pairs = []
    for n in {loop.n for loop in loops}:
        rows = [i for i, loop in enumerate(loops) if loop.n == n]
        table = table_of(n, [loops[i].found for i in rows])
        for i in rows:
            near = table.relatives(loops[i].found.shape.sequence)
            pairs += [(i, rows[j]) for j in np.flatnonzero(near)]
    first, second = np.array(pairs).T
    links = coo_array((np.ones(len(first)), (first, second)), shape=(len(loops), len(loops)))
    family = connected_components(links, directed=False)[1]
    named = []
    for loop, number in zip(loops, family, strict=True):
        codes = letters_of(loop.found.shape.sequence)[None]
        motif = next((m for m, p in MOTIFS.items() if pattern_fits(p, codes)[0]), "")
        motif = "" if loop.hairpin.is_dna else motif
        named.append(replace(loop, family=motif or f"{number}", motif=motif))
    return named
