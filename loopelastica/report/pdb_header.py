"""The records of a PDB file that say something of its atoms: remarks, links, sites, counts."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Final

from loopelastica.report.changes import Changes, Place
from loopelastica.report.pdb_lines import Line, PdbFile, as_wide
from loopelastica.report.placing import Plan, today

_NOTE: Final = 99
_WIDTH: Final = 80
# what comes before the remarks, PDB format 3.3
_BEFORE_REMARKS: Final = (
    *("HEADER", "OBSLTE", "TITLE", "SPLIT", "CAVEAT", "COMPND", "SOURCE", "KEYWDS", "EXPDTA"),
    *("NUMMDL", "MDLTYP", "AUTHOR", "REVDAT", "SPRSDE", "JRNL"),
)
# columns of chain, number and insertion code of the two ends of a bond
_LINK_ENDS: Final = (21, 51)
_SITE_PARTS: Final = range(18, 62, 11)
_WATERS: Final = re.compile(r"(FORMUL.*HOH.*?\*?)(\d+)(\(H2 O\).*)")
_MODELS: Final = re.compile(r"\s*MODELS?\s+(\d+)(?:\s*-\s*(\d+))?\s*$")

_TABLE: Final = re.compile(r"RES C ?S*SEQI")
_RESIDUE: Final = re.compile(
    r"\s*(?:\d+\s+)?\S{1,3}\s+(?:(?P<chain>\S)\s+)?(?P<number>-?\d+)(?P<icode>[A-Za-z]?)"
)
# MASTER: where the count of which records begins
_COUNTS: Final = {
    10: ("REMARK",),
    40: ("SITE",),
    50: ("ATOM", "HETATM"),
    55: ("TER",),
    60: ("CONECT",),
}

_RowOf = Callable[[Line, Iterable[int]], Line | None]


def with_header(lines: list[Line], file: PdbFile, plan: Plan, changes: Changes) -> list[Line]:
    """The lines with a header that fits them.

    Parameters
    ----------
    lines : list of Line
        Of the result; the header is that of the input.
    file : PdbFile
        The input.
    plan : Plan
    changes : Changes

    Returns
    -------
    list of Line
    """
    lines = _without_residues(lines, file, plan)
    lines = _missing(lines, 465, _missing_residues(file, plan), file.model_numbers)
    lines = _missing(lines, 470, _missing_atoms(file, plan), file.model_numbers)
    lines = _noted(lines, changes.lines, file.line_end)
    return _counted(lines, file)


# --- residues that went ---------------------------------------------------------------------------


def _without_residues(lines: list[Line], file: PdbFile, plan: Plan) -> list[Line]:
    """Without links and sites of residues that have no atom left in any model."""
    here = {file.rows[row].place for row in range(len(file.rows)) if row not in plan.gone}
    gone = {file.rows[row].place for row in plan.gone} - here
    if not gone:
        return lines
    waters = {
        row.place for k, row in enumerate(file.rows) if k in plan.gone and row.resname == "HOH"
    }
    lines = [
        line
        for line in lines
        if line.kind != "LINK" or not any(_place(line.text, k) in gone for k in _LINK_ENDS)
    ]
    return [_fewer_waters(line, len(waters & gone)) for line in _sites(lines, gone)]


def _place(text: str, start: int) -> Place | None:
    """Chain, number and insertion code that begin in a column."""
    try:
        number = int(text[start + 1 : start + 5])
    except ValueError:
        return None
    return text[start].strip(), number, text[start + 5 : start + 6].strip()


def _sites(lines: list[Line], gone: set[Place]) -> list[Line]:
    """SITE records without some residues; what follows in the site moves up."""
    parts: dict[str, list[str]] = {}
    for line in lines:
        if line.kind == "SITE":
            site = parts.setdefault(line.text[11:14], [])
            found = (f"{line.text[k : k + 10]:10}" for k in _SITE_PARTS)
            site += [part for part in found if part.strip() and _place(part, 4) not in gone]
    fewer = {site: len(left) for site, left in parts.items()}
    out = []
    for line in lines:
        if line.kind == "SITE":
            name = line.text[11:14]
            mine, parts[name] = parts[name][:4], parts[name][4:]
            if not mine:
                continue
            text = f"{line.text[:15]}{fewer[name]:2d} {' '.join(mine)}"
            line = replace(line, text=as_wide(text, line.text))
        out.append(line)
    return out


def _fewer_waters(line: Line, fewer: int) -> Line:
    match = _WATERS.match(line.text) if line.kind == "FORMUL" else None
    if match is None:
        return line
    text = f"{match[1]}{max(int(match[2]) - fewer, 0)}{match[3]}"
    return replace(line, text=as_wide(text, line.text))


# --- what the file said was missing ---------------------------------------------------------------


def _missing_residues(file: PdbFile, plan: Plan) -> _RowOf:
    """What becomes of a row of REMARK 465: nothing where the residue is there in its models."""
    filled = {(a.residue.model, _letter(file, a.like), *a.residue.place[1:]) for a in plan.new}

    def row(line: Line, models: Iterable[int]) -> Line | None:
        match = _RESIDUE.fullmatch(line.text[10:].rstrip())
        if match is None:
            return line
        place = match["chain"] or "", int(match["number"]), match["icode"]
        return None if all((model, *place) in filled for model in models) else line

    return row


def _missing_atoms(file: PdbFile, plan: Plan) -> _RowOf:
    """What becomes of a row of REMARK 470: only atoms that are missing still."""
    filled: dict[tuple[int, str, int, str], set[str]] = {}
    for a in plan.new:
        key = (a.residue.model, _letter(file, a.like), *a.residue.place[1:])
        filled.setdefault(key, set()).add(today(a.name))

    def row(line: Line, models: Iterable[int]) -> Line | None:
        place = _place(f"{line.text:<26}", 19)
        if place is None:
            return line
        there = [filled.get((model, *place), set()) for model in models]
        names = line.text[25:].split()
        left = [name for name in names if not all(today(name) in known for known in there)]
        if len(left) == len(names):
            return line
        columns = "".join(f" {name if len(name) > 3 else f' {name}':4}" for name in left)
        return (
            replace(line, text=as_wide(f"{line.text[:25]} {columns}", line.text)) if left else None
        )

    return row


def _letter(file: PdbFile, row: int) -> str:
    return file.lines[file.atoms[row]].text[21:22].strip()


def _missing(lines: list[Line], number: int, row: _RowOf, model_numbers: list[int]) -> list[Line]:
    """A remark that lists what is missing, row by row; when no row is left the remark goes."""
    index = {of_file: model for model, of_file in enumerate(model_numbers)}
    every: list[int] = list(index.values())
    models, in_table = every, False
    becomes: dict[int, Line | None] = {}
    remark = [k for k, x in enumerate(lines) if x.kind == "REMARK" and _number(x) == number]
    for k in remark:
        text = lines[k].text[10:].rstrip()
        some = _MODELS.fullmatch(text)
        if some is not None:
            last = int(some[2] or some[1])
            models = [m for of_file, m in index.items() if int(some[1]) <= of_file <= last]
        elif _TABLE.search(text):
            in_table = True
        elif in_table and text.strip():
            own = text[:4].strip()
            one = [index[int(own)]] if own.isdecimal() and int(own) in index else models
            becomes[k] = row(lines[k], one or every)
    emptied = bool(becomes) and not any(becomes.values())
    gone = set(remark) if emptied else {k for k, line in becomes.items() if line is None}
    return [becomes.get(k) or line for k, line in enumerate(lines) if k not in gone]


# --- notes and counts -----------------------------------------------------------------------------


def _noted(lines: list[Line], notes: Iterable[str], end: str) -> list[Line]:
    """Notes as REMARK 99, where the order of the remarks has it."""
    wrapped = [part for note in notes for part in textwrap.wrap(note, _WIDTH - 11)]
    if not wrapped:
        return lines
    place = 0
    for k, line in enumerate(lines):
        if line.kind in _BEFORE_REMARKS or (line.kind == "REMARK" and _number(line) <= _NOTE):
            place = k + 1
        elif line.is_atom or line.kind == "MODEL":
            break
    texts = [f"REMARK {_NOTE:3d} {part}" for part in ("", *wrapped)]
    remarks = [Line(f"{text:<{_WIDTH}}", "", end, "REMARK") for text in texts]
    return [*lines[:place], *remarks, *lines[place:]]


def _number(line: Line) -> int:
    text = line.text[6:10].strip()
    return int(text) if text.isdecimal() else 0


def _counted(lines: list[Line], file: PdbFile) -> list[Line]:
    """MASTER with the new counts, each of what it counted before.

    Of models it counts all, or the first one, and of that some files count no hydrogen atoms.
    """
    master = next((k for k, line in enumerate(lines) if line.kind == "MASTER"), None)
    if master is None:
        return lines
    text = lines[master].text
    for start, kinds in _COUNTS.items():
        field = text[start : start + 5].strip()
        if field.isdecimal():
            pairs = zip(_counts(file.lines, kinds), _counts(lines, kinds), strict=True)
            # of a file that was cut by hand only the result may fit
            count = min(pairs, key=lambda pair: min(abs(n - int(field)) for n in pair))[1]
            text = f"{text[:start]}{count:5d}{text[start + 5 :]}"
    lines[master] = replace(lines[master], text=text)
    return lines


def _counts(lines: list[Line], kinds: tuple[str, ...]) -> tuple[int, int, int]:
    """Records of all models, of the first one, and of its heavy atoms."""
    end = next((k for k, line in enumerate(lines) if line.kind == "ENDMDL"), len(lines))
    places = [k for k, line in enumerate(lines) if line.kind in kinds]
    first = [lines[k] for k in places if k < end]
    heavy = [x for x in first if not x.is_atom or x.text[12:16].strip(" 0123456789")[:1] != "H"]
    return len(places), len(first), len(heavy)
