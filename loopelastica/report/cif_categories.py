"""The categories of an mmCIF file that say something of its atoms."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final

from loopelastica.report.changes import AddedResidue, Changes
from loopelastica.report.placing import Plan, Row, today

_NOTE: Final = "99"
_NOTHING: Final = ("?", ".")
# columns outside the table of atoms that hold the id of an atom
_ATOM_ID: Final = re.compile(
    r"_atom_site_anisotrop\.id|_pdbx_solvent_atom_site_mapping\.id|.*\..*atom_site_id.*", re.I
)
_POLYMER: Final = ("_atom_site.", "_pdbx_poly_seq_scheme.", "_entity_poly_seq.")

_Columns = dict[str, list[str]]


@dataclass(frozen=True, slots=True)
class Written:
    """The table of atoms as it was and as it is.

    Attributes
    ----------
    rows : list of Row
        As it was.
    model_names : list of str
        What the file calls its models.
    ids : dict of str to str
        New id of each atom that is left, by its old one.
    old_ids, entities : list of str
        Of the rows as they were.
    seq_ids : dict of int to str
        `label_seq_id` of each added residue, by its `id()`.
    """

    rows: list[Row]
    model_names: list[str]
    ids: dict[str, str]
    old_ids: list[str]
    entities: list[str]
    seq_ids: dict[int, str]


def with_categories(block: Any, written: Written, plan: Plan, changes: Changes) -> None:
    """Make all other categories fit the table of atoms.

    Parameters
    ----------
    block : gemmi.cif.Block
        It is changed.
    written : Written
    plan : Plan
    changes : Changes
    """
    _follow_ids(block, written, plan)
    _drop_residues(block, written, plan)
    _observe(block, written, plan)
    if changes.software is not None:
        add_software(block, *changes.software)
    if changes.notes:
        add_remark(block, changes.lines)


def text_of(value: str) -> str:
    """A value without its quotes; "" where there is none.

    >>> text_of('"a b"'), text_of("?"), text_of("A")
    ('a b', '', 'A')
    """
    if value[:1] not in ("'", '"', ";"):
        return "" if value in _NOTHING else value
    from gemmi import cif

    text: str = cif.as_string(value)
    return text


def raw(text: str) -> str:
    """A text as a value, in quotes where it needs them."""
    from gemmi import cif

    value: str = cif.quote(text)
    return value


# --- tables ---------------------------------------------------------------------------------------


def _columns(block: Any, category: str) -> _Columns:
    """Values by the name of the column in lower case, of a loop or of single values."""
    table = block.find_mmcif_category(category)
    names = (tag.partition(".")[2].lower() for tag in table.tags)
    return {name: list(table.column(k)) for k, name in enumerate(names)}


def _texts(columns: _Columns, *names: str) -> list[str]:
    """The first of some columns that there is, without quotes; empty texts where none is."""
    length = len(next(iter(columns.values()), []))
    found = next((columns[name] for name in names if name in columns), None)
    return [""] * length if found is None else [text_of(value) for value in found]


def _write(block: Any, category: str, columns: _Columns, keep: Sequence[bool]) -> None:
    """Write a table back, with the rows that are kept; without any it goes."""
    table = block.find_mmcif_category(category)
    if not any(keep):
        table.erase()
        return
    table.ensure_loop()
    loop = block.find_mmcif_category(category).loop
    loop.set_all_values(
        [[v for v, kept in zip(c, keep, strict=True) if kept] for c in columns.values()]
    )


def _keep(block: Any, category: str, columns: _Columns, keep: Sequence[bool]) -> None:
    if not all(keep):
        _write(block, category, columns, keep)


def _appended(block: Any, category: str, values: dict[str, str]) -> None:
    """Add a row to a table, which is made where there is none."""
    table = block.find_mmcif_category(category)
    if not table.tags:
        block.init_mmcif_loop(category, list(values)).add_row(list(values.values()))
        return
    table.ensure_loop()
    loop = block.find_mmcif_category(category).loop
    names = [tag.partition(".")[2].lower() for tag in loop.tags]
    lacking = [name for name in values if name.lower() not in names]
    if lacking:
        loop.add_columns([f"{category}{name}" for name in lacking], "?")
    by_name = {name.lower(): value for name, value in values.items()}
    loop.add_row([by_name.get(tag.partition(".")[2].lower(), "?") for tag in loop.tags])


# --- what refers to atoms and residues ------------------------------------------------------------


def _follow_ids(block: Any, written: Written, plan: Plan) -> None:
    """New ids wherever atoms are named by them; rows of atoms that went, or moved, go."""
    ids = {old: new for old, new in written.ids.items() if old != new}
    lost = {written.old_ids[row] for row in plan.gone}
    moved = {written.old_ids[row] for row in plan.moved}
    if not ids and not lost and not moved:
        return
    for category in block.get_mmcif_category_names():
        table = block.find_mmcif_category(category)
        named = [tag.partition(".")[2].lower() for tag in table.tags if _ATOM_ID.fullmatch(tag)]
        if not named or category.lower() == "_atom_site.":
            continue
        columns = _columns(block, category)
        # the displacement of an atom is that of the place where it was
        out = lost | moved if category.lower() == "_atom_site_anisotrop." else lost
        keep = [not out.intersection(row) for row in zip(*(columns[n] for n in named), strict=True)]
        for name in named:
            columns[name] = [ids.get(value, value) for value in columns[name]]
        _write(block, category, columns, keep)


def _drop_residues(block: Any, written: Written, plan: Plan) -> None:
    """Rows that name a residue of which no atom is left in any model go, wherever they are."""
    here = {row.place for k, row in enumerate(written.rows) if k not in plan.gone}
    lost = {row.place: k for k in plan.gone for row in (written.rows[k],) if row.place not in here}
    gone = {(chain, str(number)) for chain, number, _ in lost}
    if not gone:
        return
    for category in block.get_mmcif_category_names():
        if category.lower() in _POLYMER:
            continue
        columns = _columns(block, category)
        numbers = [name for name in columns if "auth_seq_id" in name]
        pairs = [(name.replace("seq_id", "asym_id"), name) for name in numbers]
        pairs += [("pdb_strand_id", "pdb_seq_num")]
        named = [
            list(zip(_texts(columns, asym), _texts(columns, seq), strict=True))
            for asym, seq in pairs
            if asym in columns and seq in columns
        ]
        if named:
            _keep(
                block,
                category,
                columns,
                [not gone.intersection(r) for r in zip(*named, strict=True)],
            )
    _count_molecules(block, written, list(lost.values()))


def _count_molecules(block: Any, written: Written, rows: list[int]) -> None:
    """Fewer waters or ions in the entity of what went, one for each residue."""
    columns = _columns(block, "_entity.")
    if not written.entities or not {"id", "pdbx_number_of_molecules"} <= set(columns):
        return
    counts = columns["pdbx_number_of_molecules"]
    for row in rows:
        if written.entities[row] in columns["id"]:
            k = columns["id"].index(written.entities[row])
            if counts[k].isdecimal() and _texts(columns, "type")[k] != "polymer":
                counts[k] = str(max(int(counts[k]) - 1, 0))
    _write(block, "_entity.", columns, [True] * len(counts))


# --- what the file said was missing ---------------------------------------------------------------


def _observe(block: Any, written: Written, plan: Plan) -> None:
    """Added nucleotides and atoms are no longer among those that were not observed."""
    index = {name: k for k, name in enumerate(written.model_names)}
    whole = {id(a.residue): a.residue for a in plan.new if not a.completes}
    residues = {(r.model, *r.place) for r in whole.values()}
    atoms = {(a.residue.model, *a.residue.place, today(a.name)) for a in plan.new}
    _not_missing(block, "_pdbx_unobs_or_zero_occ_residues.", index, residues.__contains__)
    _not_missing(block, "_pdbx_unobs_or_zero_occ_atoms.", index, atoms.__contains__)
    _fill_scheme(block, written, list(whole.values()))


def _not_missing(
    block: Any, category: str, models: dict[str, int], there: Callable[[tuple[Any, ...]], bool]
) -> None:
    """Without the rows of what is there now; those of zero occupancy stay."""
    columns = _columns(block, category)
    if not columns:
        return
    parts = [
        _texts(columns, "auth_asym_id", "label_asym_id"),
        _texts(columns, "auth_seq_id", "label_seq_id"),
        _texts(columns, "pdb_ins_code"),
    ]
    if category.endswith("atoms."):
        parts.append([today(t) for t in _texts(columns, "auth_atom_id", "label_atom_id")])
    numbers = _texts(columns, "pdb_model_num")
    flags = _texts(columns, "occupancy_flag")
    keep = []
    for model, flag, chain, number, *rest in zip(numbers, flags, *parts, strict=True):
        mine = [models[model]] if model in models else list(models.values())
        key = (chain, int(number) if number.lstrip("-").isdecimal() else number, *rest)
        keep.append(flag == "0" or not all(there((k, *key)) for k in mine))
    _keep(block, category, columns, keep)


def _fill_scheme(block: Any, written: Written, residues: list[AddedResidue]) -> None:
    """Give the rows of added nucleotides the author's number and name."""
    category = "_pdbx_poly_seq_scheme."
    columns = _columns(block, category)
    if not columns or not residues:
        return
    by_seq: dict[tuple[str, ...], list[int]] = {}
    for names in (("asym_id", "seq_id"), ("pdb_strand_id", "pdb_seq_num", "pdb_ins_code")):
        for k, key in enumerate(zip(*(_texts(columns, name) for name in names), strict=True)):
            by_seq.setdefault(key, []).append(k)
    mon_ids = _texts(columns, "mon_id")
    asym_of = {row.place[0]: row.asym for row in reversed(written.rows)}
    for residue in residues:
        asym = residue.asym or asym_of.get(residue.chain, "")
        chain, number, icode = residue.place
        rows = by_seq.get((asym, written.seq_ids[id(residue)])) or by_seq.get(
            (chain, str(number), icode), []
        )
        # of several names of one place the one that was built
        row = next((k for k in rows if mon_ids[k] == residue.resname), next(iter(rows), None))
        if row is None:
            continue
        for name, value in (
            ("pdb_seq_num", str(number)),
            ("auth_seq_num", str(number)),
            ("pdb_mon_id", residue.resname),
            ("auth_mon_id", residue.resname),
        ):
            if name in columns and columns[name][row] in _NOTHING:
                columns[name][row] = raw(value)
    _write(block, category, columns, [True] * len(mon_ids))


# --- who did it -----------------------------------------------------------------------------------


def add_software(block: Any, name: str, version: str) -> None:
    """Add a program that has built atoms, if it is not among those of the file.

    Parameters
    ----------
    block : gemmi.cif.Block
        It is changed.
    name, version : str
        Of the program.
    """
    columns = _columns(block, "_software.")
    known = zip(_texts(columns, "name"), _texts(columns, "version"), strict=True)
    if (name, version) in known:
        return
    ordinals = [int(text) for text in _texts(columns, "pdbx_ordinal") if text.isdecimal()]
    values = {
        "pdbx_ordinal": str(max(ordinals, default=0) + 1),
        "name": raw(name),
        "version": raw(version),
        "classification": raw("model building"),
    }
    _appended(block, "_software.", values)


def add_remark(block: Any, notes: Sequence[str]) -> None:
    """Write notes as remark 99, after what that remark says already.

    Parameters
    ----------
    block : gemmi.cif.Block
        It is changed.
    notes : sequence of str
        One sentence each, or a line of its own.
    """
    category = "_database_PDB_remark."
    lines = [line for note in notes for line in textwrap.wrap(note, 80)]
    # a line that begins so would end the text
    text = "\n".join(f" {line}" if line.startswith(";") else line for line in lines)
    columns = _columns(block, category)
    ids = _texts(columns, "id")
    if _NOTE in ids and "text" in columns:
        row = ids.index(_NOTE)
        columns["text"][row] = raw(f"{text_of(columns['text'][row]).rstrip()}\n{text}")
        _write(block, category, columns, [True] * len(ids))
        return
    _appended(block, category, {"id": _NOTE, "text": raw(text)})
