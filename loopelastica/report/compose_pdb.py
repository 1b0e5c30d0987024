"""A PDB file with atoms added, moved and left out, line by line.

Lines that nothing of this concerns stay as they are to the byte. Serial numbers rise only where
room is needed, alike in all models; ANISOU, TER and CONECT follow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import groupby, pairwise, product, takewhile
from typing import Final

from loopelastica.report.changes import Changes, Place
from loopelastica.report.pdb_header import with_header
from loopelastica.report.pdb_lines import (
    LAST_SERIAL,
    Line,
    PdbFile,
    as_wide,
    atom_text,
    decoded,
    encoded,
    fits_columns,
    holds,
    number_text,
    with_position,
)
from loopelastica.report.placing import NewAtom, Plan, plan_for, record_name, renumbered, today

# O3'-P: a bond has 1.6 Å; where they are farther apart one chain ends and another begins
_BONDED_A: Final = 2.5
_CONECT_BONDS: Final = range(11, 31, 5)
_CONECT_OTHERS: Final = range(31, 61, 5)


@dataclass(slots=True)
class _Entry:
    """A line of the result; `row` is its atom in the file, or that of its ANISOU record."""

    line: Line
    model: int
    row: int | None = None
    new: NewAtom | None = None

    @property
    def is_numbered(self) -> bool:
        return self.line.is_atom or (self.line.kind == "TER" and bool(self.line.serial))


def compose_pdb(text: str, changes: Changes) -> str | None:
    """The text of a PDB file with changes; None where the format cannot hold the result.

    Parameters
    ----------
    text : str
        The file.
    changes : Changes

    Raises
    ------
    StructureError
        If the changes do not fit the file.
    """
    file = PdbFile.read(text)
    plan = plan_for(file.rows, lambda row: file.lines[file.atoms[row]].position_A, changes)
    likes = {atom.like: file.lines[file.atoms[atom.like]].text for atom in plan.new}
    fits = all(holds(atom, likes[atom.like]) for atom in plan.new)
    if not fits or not all(map(fits_columns, plan.moved.values())):
        return None
    entries = _entries(file, plan, changes)
    if plan.new:
        entries = _without_breaks(entries, file)
        serials = _serials(entries)
        if serials is None:
            return None
        _number(entries, serials)
    _connect(entries, file, plan)
    lines = with_header([entry.line for entry in entries], file, plan, changes)
    # the last line of a file may lack its end; others need theirs
    return "".join(
        f"{line.indent}{line.text}{line.end or file.line_end}" for line in lines[:-1]
    ) + "".join(f"{line.indent}{line.text}{line.end}" for line in lines[-1:])


def fits_pdb(text: str, changes: Changes) -> bool:
    """Whether a PDB file can hold its changes.

    Parameters
    ----------
    text : str
        The file.
    changes : Changes

    Returns
    -------
    bool
    """
    return compose_pdb(text, changes) is not None


def _entries(file: PdbFile, plan: Plan, changes: Changes) -> list[_Entry]:
    """Lines in their new order, under their old serial numbers."""
    before = {file.atoms[row]: atoms for row, atoms in plan.before.items()}
    after = {file.end_of(row): atoms for row, atoms in plan.after.items()}
    kinds = {row.resname: file.lines[file.atoms[i]].kind for i, row in enumerate(file.rows)}
    has_elements, end = bool(plan.new) and file.has_elements, file.line_end

    def added(atoms: list[NewAtom]) -> list[_Entry]:
        out = []
        for atom in atoms:
            like = file.lines[file.atoms[atom.like]]
            kind = record_name(atom, like.kind, kinds)
            text = atom_text(atom, like.text, kind, has_elements)
            out.append(_Entry(Line(text, "", end, kind), atom.residue.model, None, atom))
        return out

    out: list[_Entry] = []
    for place, line in enumerate(file.lines):
        row = file.row_of.get(place)
        out += added(before.get(place, []))
        if row in plan.moved and line.is_atom:
            line = _moved(line, plan.moved[row], changes)
        elif row in plan.moved or row in plan.gone:
            out += added(after.get(place, []))
            continue
        out.append(_Entry(line, file.model_of[place], row))
        out += added(after.get(place, []))
    return out


def _moved(line: Line, position_A: tuple[float, ...], changes: Changes) -> Line:
    text = with_position(line.text, position_A)
    # of its locations one is left
    text = f"{text[:16]} {text[17:]}"
    for column, value in ((54, changes.moved_occupancy), (60, changes.moved_b_factor_A2)):
        if value is not None:
            text = f"{text[:column]:<{column}}{number_text(value)}{text[column + 6 :]}"
    return replace(line, text=text)


# --- where chains end -----------------------------------------------------------------------------


def _without_breaks(entries: list[_Entry], file: PdbFile) -> list[_Entry]:
    """Chains that end with their last residue, and do not end where a strand was filled."""
    atoms = [entry for entry in entries if entry.line.is_atom]
    out, n = [], 0
    for entry in entries:
        n += entry.line.is_atom
        if entry.line.kind == "TER":
            before = _residue(atoms[n - 1 :: -1] if n else [], file)
            behind = _residue(atoms[n:], file)
            if any(atom.new is not None for atom in (*before, *behind)):
                if _joined(before, behind, file):
                    continue
                entry = _ended(entry, before)
        out.append(entry)
    return out


def _residue(atoms: list[_Entry], file: PdbFile) -> list[_Entry]:
    """The atoms of the residue that the first one belongs to."""
    return list(takewhile(lambda atom: _key(atom, file) == _key(atoms[0], file), atoms))


def _key(atom: _Entry, file: PdbFile) -> tuple[int, Place]:
    if atom.new is not None:
        # under the name of its chain in the file
        chain = file.rows[atom.new.like].place[0]
        return atom.model, (chain, *atom.new.residue.place[1:])
    assert atom.row is not None
    return atom.model, file.rows[atom.row].place


def _joined(before: list[_Entry], behind: list[_Entry], file: PdbFile) -> bool:
    """Whether O3' of a residue is bonded to P of another one of the same chain."""
    if not before or not behind:
        return False
    models, places = zip(*(_key(atoms[0], file) for atoms in (before, behind)), strict=True)
    if models[0] != models[1] or places[0][0] != places[1][0]:
        return False
    ends = (
        [x.line.position_A for x in atoms if today(x.line.text[12:16].strip()) == name]
        for atoms, name in ((before, "O3'"), (behind, "P"))
    )
    return any(math.dist(a, b) < _BONDED_A for a, b in product(*ends))


def _ended(ter: _Entry, before: list[_Entry]) -> _Entry:
    """A TER record that names the residue it follows, if it names one."""
    text = ter.line.text
    if not before or not text[17:27].strip():
        return ter
    named = f"{text[:17]}{before[0].line.text[17:27]}{text[27:]}"
    return replace(ter, line=replace(ter.line, text=as_wide(named, text)))


# --- serial numbers -------------------------------------------------------------------------------


def _serials(entries: list[_Entry]) -> list[int] | None:
    """Serial numbers of all lines that have one; None where the columns cannot hold them."""
    numbered = [entry for entry in entries if entry.is_numbered]
    models = [list(group) for _, group in groupby(numbered, key=lambda entry: entry.model)]
    texts = [[e.line.serial for e in model if e.new is None] for model in models]
    olds = [[decoded(text) for text in model] for model in texts]
    if all(_rises(old) for old in olds):
        serials = _raised(models)
        hybrid = any(not text.isdecimal() for model in texts for text in model)
        if hybrid or max(serials) <= LAST_SERIAL:
            return serials
    # where the old numbers do not serve, from 1 in each model
    serials = [k for model in models for k in range(1, len(model) + 1)]
    return serials if max(serials) <= LAST_SERIAL else None


def _rises(serials: list[int | None]) -> bool:
    return all(a is not None and b is not None and a < b for a, b in pairwise([-1, *serials]))


def _raised(models: list[list[_Entry]]) -> list[int]:
    """The old serial numbers, raised where room is needed; the same atoms alike in all models."""
    olds = [[None if e.new is not None else decoded(e.line.serial) for e in m] for m in models]
    floor: dict[int, int] = {}
    while True:
        known, serials, last, highest = dict(floor), [], 0, -1
        for old in olds:
            lowest = min((s for s in old if s is not None), default=1)
            if lowest <= highest:
                # each model counts from its own beginning
                last = lowest - 1
            serials += renumbered(old, floor, last)
            last, highest = serials[-1], max((s for s in old if s is not None), default=highest)
        if floor == known:
            return serials


def _number(entries: list[_Entry], serials: list[int]) -> None:
    """Write the serial numbers, of ANISOU records too."""
    of_row: dict[int, str] = {}
    places = [k for k, entry in enumerate(entries) if entry.is_numbered]
    for k, serial in zip(places, serials, strict=True):
        entry = entries[k]
        text = encoded(serial)
        if entry.row is not None:
            of_row[entry.row] = text
        if entry.line.serial != text.strip():
            entry.line = entry.line.numbered(text)
    for entry in entries:
        if entry.row is not None and not entry.line.is_atom:
            entry.line = entry.line.numbered(of_row[entry.row])


def _connect(entries: list[_Entry], file: PdbFile, plan: Plan) -> None:
    """Make CONECT records point to the atoms that they pointed to."""
    has_records = any(entry.line.kind == "CONECT" for entry in entries)
    if not has_records or not (plan.new or plan.gone):
        return
    now: dict[int, int] = {}
    for entry in entries:
        if entry.row is not None and entry.line.is_atom:
            old = decoded(file.lines[file.atoms[entry.row]].serial)
            new = decoded(entry.line.serial)
            if old is not None and new is not None:
                # of atoms of one number that of the first model
                now.setdefault(old, new)
    mapped = (_connected(entry, now) if entry.line.kind == "CONECT" else entry for entry in entries)
    entries[:] = [entry for entry in mapped if entry is not None]


def _connected(entry: _Entry, now: dict[int, int]) -> _Entry | None:
    """A CONECT record under new numbers; None where nothing is left of it."""
    text = entry.line.text

    def mapped(start: int) -> str:
        old = decoded(text[start : start + 5].strip())
        return encoded(now[old]) if old in now else ""

    base = mapped(6)
    bonds = [field for field in map(mapped, _CONECT_BONDS) if field]
    others = [f"{mapped(start):5}" for start in _CONECT_OTHERS]
    if not base or not (bonds or any(field.strip() for field in others)):
        return None
    whole = f"CONECT{base}{''.join(bonds):20}{''.join(others)}{text[61:]}"
    entry.line = replace(entry.line, text=as_wide(whole, text))
    return entry
