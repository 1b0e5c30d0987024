"""The sequence of record: what a file says a chain consists of, and what of it was not observed.

mmCIF: ``_pdbx_poly_seq_scheme`` (a row per residue, with the author's numbers), else
``_entity_poly_seq``, else the one-letter code of ``_entity_poly``. PDB: SEQRES. Numbers of what is
not there: the scheme, REMARK 465, ``_pdbx_unobs_or_zero_occ_residues``.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import groupby
from typing import Any, Final, NamedTuple

from loopelastica.molecule.components import BASES, component
from loopelastica.molecule.entry import Entry

_REMARK_465: Final = re.compile(
    r"^REMARK 465 +(?:(?P<model>\d+) +)?(?P<name>\w{1,3}) +(?:(?P<chain>\S) +)?"
    r"(?P<number>-?\d+)(?P<icode>[A-Za-z]?) *$",
    re.MULTILINE,
)
_TOKEN: Final = re.compile(r"\(([^)]+)\)|([A-Za-z])")


Rows = list[tuple[tuple[str, ...], int | None, str]]
"""Names, number and insertion code of each residue."""


class Listed(NamedTuple):
    """One residue of a sequence of record.

    Attributes
    ----------
    names : tuple of str
        Its component; several where the record lists alternatives.
    letter : str
        Parent base, "N" where the file does not say.
    is_dna : bool or None
        Whether it is of DNA, None where its name is one of both.
    number : int or None
        The author's number; None where the record has none.
    icode : str
        Insertion code or "".
    """

    names: tuple[str, ...]
    letter: str
    is_dna: bool | None
    number: int | None = None
    icode: str = ""


class Record(NamedTuple):
    """The sequence of record of a chain, and where the file has it."""

    residues: tuple[Listed, ...]
    source: str

    @property
    def names(self) -> frozenset[str]:
        """Components that occur in it."""
        return frozenset(name for one in self.residues for name in one.names)


class Absent(NamedTuple):
    """A residue that the file lists as not observed."""

    name: str
    number: int
    icode: str


class Records(NamedTuple):
    """Sequences of record of the nucleic acids of a file.

    Attributes
    ----------
    by_label : dict
        By the chain's own name in mmCIF, `label_asym_id`.
    by_author : dict
        By the author's name of the chain, where the file has no other.
    absent : dict
        What was not observed, by the author's name of the chain, in the order of the file.
    parents : dict
        Parent base of modified components, by name.
    """

    by_label: dict[str, Record]
    by_author: dict[str, Record]
    absent: dict[str, list[Absent]]
    parents: dict[str, str]


def records_of(entry: Entry, model: int = 0) -> Records:
    """All that a file says of its sequences.

    Parameters
    ----------
    entry : Entry
        What was read.
    model : int
        Which model, from 0, for what was not observed in it.

    Returns
    -------
    Records
    """
    parents = {
        one.res_id.name: base
        for one in entry.structure.mod_residues
        if (base := _base(one.parent_comp_id))
    }
    if entry.document is None:
        long_lines = _seqres(entry.text)
        found = {}
        for entity in entry.structure.entities:
            sequence = list(entity.full_sequence)
            # gemmi takes thirteen names of a line; some programs write more
            if len(own := long_lines.get(entity.name, [])) > len(sequence):
                sequence = own
            if sequence:
                found[entity.name] = _record(_listed(sequence), "", parents, "SEQRES")
        return Records({}, _nucleic(found), _remark_465(entry.text, model), parents)
    block = entry.document.sole_block()
    nonstandard = _category(block, "_chem_comp.")
    for name, parent in zip(
        nonstandard.get("id", ()), nonstandard.get("mon_nstd_parent_comp_id", ()), strict=False
    ):
        if name and parent and (base := _base(parent)):
            parents.setdefault(name, base)
    by_label, by_author = _mmcif_records(block, entry.model(model), parents)
    return Records(_nucleic(by_label), _nucleic(by_author), _unobserved(block, model), parents)


def _listed(sequence: Sequence[str]) -> Rows:
    return [(tuple(names.split(",")), None, "") for names in sequence]


def _base(parent: str) -> str:
    known = component(parent)
    return known.letter if known and known.letter in BASES else ""


def _nucleic(found: dict[str, Record]) -> dict[str, Record]:
    """Keep those that are nucleic acids, by half of their components."""
    return {name: record for name, record in found.items() if _is_nucleic(record.residues)}


def _is_nucleic(residues: Sequence[Listed]) -> bool:
    known = sum(component(one.names[0]) is not None for one in residues)
    return 0 < known >= len(residues) / 2


def _record(rows: Rows, canonical: str, parents: dict[str, str], source: str) -> Record:
    """A record of rows of names, number and insertion code.

    `canonical` has a letter per residue, or is of no use.
    """
    residues = []
    for names, number, icode in rows:
        known = component(names[0])
        letter = known.letter if known and known.letter != "N" else parents.get(names[0], "N")
        residues.append(Listed(names, letter, known.is_dna if known else None, number, icode))
    if len(canonical) == len(rows) and _is_nucleic(residues):
        residues = [
            one._replace(letter=code) if one.letter == "N" and code in BASES else one
            for one, code in zip(residues, canonical.upper(), strict=True)
        ]
    return Record(tuple(residues), source)


# --- PDB ------------------------------------------------------------------------------------------


def _seqres(text: str) -> dict[str, list[str]]:
    """Names in SEQRES, whatever columns they are in, by chain."""
    names: dict[str, list[str]] = {}
    for line in re.findall(r"^SEQRES.*", text, re.MULTILINE):
        names.setdefault(line[11:12].strip(), []).extend(line[19:].split())
    return names


def _remark_465(text: str, model: int) -> dict[str, list[Absent]]:
    absent: dict[str, list[Absent]] = {}
    for match in _REMARK_465.finditer(text):
        if match["model"] is None or int(match["model"]) == model + 1:
            one = Absent(match["name"], int(match["number"]), match["icode"])
            absent.setdefault(match["chain"] or "", []).append(one)
    return absent


# --- mmCIF ----------------------------------------------------------------------------------------


def _mmcif_records(
    block: Any, model: Any, parents: dict[str, str]
) -> tuple[dict[str, Record], dict[str, Record]]:
    entity_of, authors_of = _entities(block, model)
    canonical, coded = _one_letter(block)
    by_label = _scheme(block, canonical, entity_of, parents)
    by_entity = _poly_seq(block, canonical, parents)
    for entity, rows in coded.items():
        if entity not in by_entity:
            code = canonical.get(entity, "")
            source = "_entity_poly.pdbx_seq_one_letter_code"
            by_entity[entity] = _record(rows, code, parents, source)
    for label, entity in entity_of.items():
        if label not in by_label and entity in by_entity:
            by_label[label] = by_entity[entity]
    by_author = {
        author: by_entity[entity]
        for entity, authors in authors_of.items()
        if entity in by_entity
        for author in authors
    }
    return by_label, by_author


def _category(block: Any, name: str) -> dict[str, list[Any]]:
    """Columns of a category; none where it is absent or mixed with another one."""
    try:
        found: dict[str, list[Any]] = block.get_mmcif_category(name)
    except RuntimeError:
        return {}
    return found


def _entities(block: Any, model: Any) -> tuple[dict[str, str], dict[str, list[str]]]:
    """Entity of each chain by its own name; authors' names of the chains of each entity."""
    asym = _category(block, "_struct_asym.")
    pairs = zip(asym.get("id", ()), asym.get("entity_id", ()), strict=False)
    entity_of = {label: entity for label, entity in pairs if label and entity}
    for chain in model:
        for residue in chain:
            if residue.entity_id:
                entity_of.setdefault(residue.subchain, residue.entity_id)
    poly = _category(block, "_entity_poly.")
    strands = zip(poly.get("entity_id", ()), poly.get("pdbx_strand_id", ()), strict=False)
    return entity_of, {
        entity: [name.strip() for name in names.split(",")]
        for entity, names in strands
        if entity and names
    }


def _one_letter(block: Any) -> tuple[dict[str, str], dict[str, Rows]]:
    """Canonical code of each entity, and the sequence that its one-letter code stands for."""
    poly = _category(block, "_entity_poly.")
    canonical: dict[str, str] = {}
    coded: dict[str, Rows] = {}
    if "entity_id" not in poly:
        return canonical, coded
    nothing = [None] * len(poly["entity_id"])
    for entity, kind, code, plain in zip(
        poly["entity_id"],
        poly.get("type", nothing),
        poly.get("pdbx_seq_one_letter_code", nothing),
        poly.get("pdbx_seq_one_letter_code_can", nothing),
        strict=True,
    ):
        canonical[entity] = re.sub(r"\s", "", plain or "")
        kind = (kind or "").lower()
        if "ribonucleotide" not in kind:
            continue
        prefix = "D" if "deoxy" in kind and "hybrid" not in kind else ""
        tokens = _TOKEN.findall(re.sub(r"\s", "", code or plain or ""))
        if tokens:
            coded[entity] = [
                ((name or prefix + letter.upper(),), None, "") for name, letter in tokens
            ]
    return canonical, coded


def _poly_seq(block: Any, canonical: dict[str, str], parents: dict[str, str]) -> dict[str, Record]:
    rows = _category(block, "_entity_poly_seq.")
    if not {"entity_id", "num", "mon_id"} <= set(rows):
        return {}
    table = list(zip(rows["entity_id"], rows["num"], rows["mon_id"], strict=True))
    found = {}
    for entity, group in groupby(table, key=lambda row: row[0]):
        residues: Rows = [
            (tuple(name or "UNK" for _, _, name in alternatives), None, "")
            for _, alternatives in groupby(group, key=lambda row: row[1])
        ]
        code = canonical.get(entity, "")
        found[entity] = _record(residues, code, parents, "_entity_poly_seq")
    return found


def _scheme(
    block: Any, canonical: dict[str, str], entity_of: dict[str, str], parents: dict[str, str]
) -> dict[str, Record]:
    rows = _category(block, "_pdbx_poly_seq_scheme.")
    if not {"asym_id", "seq_id", "mon_id"} <= set(rows):
        return {}
    nothing = [None] * len(rows["asym_id"])
    columns = (
        *(rows["asym_id"], rows["seq_id"], rows["mon_id"]),
        *(rows.get("pdb_seq_num", nothing), rows.get("pdb_ins_code", nothing)),
    )
    found = {}
    for label, group in groupby(zip(*columns, strict=True), key=lambda row: row[0]):
        residues: Rows = []
        for _, alternatives in groupby(group, key=lambda row: row[1]):
            listed = list(alternatives)
            number, icode = listed[0][3:]
            names = tuple(row[2] or "UNK" for row in listed)
            residues.append((names, _whole(number), icode or ""))
        code = canonical.get(entity_of.get(label, ""), "")
        found[label] = _record(residues, code, parents, "_pdbx_poly_seq_scheme")
    return found


def _unobserved(block: Any, model: int) -> dict[str, list[Absent]]:
    rows = _category(block, "_pdbx_unobs_or_zero_occ_residues.")
    if not {"auth_asym_id", "auth_comp_id", "auth_seq_id"} <= set(rows):
        return {}
    nothing = [None] * len(rows["auth_asym_id"])
    absent: dict[str, list[Absent]] = {}
    for chain, name, number, icode, zero, k in zip(
        *(rows["auth_asym_id"], rows["auth_comp_id"], rows["auth_seq_id"]),
        *(rows.get("PDB_ins_code", nothing), rows.get("occupancy_flag", nothing)),
        rows.get("PDB_model_num", nothing),
        strict=True,
    ):
        place = _whole(number)
        # 0: it is there, with an occupancy of nothing
        if place is None or zero == "0" or _whole(k) not in (None, model + 1):
            continue
        absent.setdefault(chain or "", []).append(Absent(name or "UNK", place, icode or ""))
    return absent


def _whole(text: Any) -> int | None:
    return int(text) if isinstance(text, str) and re.fullmatch(r"[+-]?\d+", text) else None
