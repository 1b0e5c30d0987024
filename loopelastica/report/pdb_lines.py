"""A PDB file as lines: which are atoms of which model, which belong to them, and its format."""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Final

from loopelastica.report.changes import Place
from loopelastica.report.placing import NewAtom, Row

LAST_SERIAL: Final = 99_999
# hybrid-36 (cctbx): five digits, then a capital and four signs of base 36, then the same in lower
# case
_BASE: Final = 36
_PER_CASE: Final = 26 * _BASE**4
_SHIFT: Final = 10 * _BASE**4
_ELEMENT: Final = re.compile(r" [A-Za-z]|[A-Za-z][A-Za-z]")
# A serial of six digits begins in the sixth column.
_ATOM: Final = re.compile(r"ATOM[ \d][ \d]|HETATM", re.IGNORECASE)
_FOLLOWS: Final = ("ANISOU", "SIGATM", "SIGUIJ")
_SERIAL: Final = frozenset(("ATOM", "HETATM", "TER", *_FOLLOWS))
_WIDTH: Final = 80


@dataclass(frozen=True, slots=True)
class Line:
    """A line without its end.

    Attributes
    ----------
    text : str
        From its first sign on.
    indent, end : str
        What is before it, and how the line ends.
    kind : str
        Name of the record in capitals, such as "ATOM", "TER", "REMARK".
    serial : str
        What stands for the serial number, if there is one.
    """

    text: str
    indent: str
    end: str
    kind: str
    serial: str = ""

    @property
    def is_atom(self) -> bool:
        """Whether it is an atom."""
        return self.kind in ("ATOM", "HETATM")

    @property
    def position_A(self) -> tuple[float, float, float]:
        """Å."""
        return float(self.text[30:38]), float(self.text[38:46]), float(self.text[46:54])

    def numbered(self, serial: str) -> Line:
        """The line with another serial number, of five columns."""
        head = self.text[:6] if self.kind != "ATOM" else f"{self.text[:4]}  "
        text = f"{head:<6}{serial}{self.text[11:]}"
        return Line(text, self.indent, self.end, self.kind, serial.strip())


@dataclass(slots=True)
class PdbFile:
    """The lines of a file, and the atoms among them.

    Attributes
    ----------
    lines : list of Line
    atoms : list of int
        Lines of the atoms.
    rows : list of Row
        One for each of them.
    row_of : dict of int to int
        The atom that a line is, or that an ANISOU record belongs to.
    model_of : list of int
        Model of each line, from 0.
    model_numbers : list of int
        What the file calls its models.
    """

    lines: list[Line]
    atoms: list[int] = field(default_factory=list)
    rows: list[Row] = field(default_factory=list)
    row_of: dict[int, int] = field(default_factory=dict)
    model_of: list[int] = field(default_factory=list)
    model_numbers: list[int] = field(default_factory=list)

    @classmethod
    def read(cls, text: str) -> PdbFile:
        """Look through a text, as the reader of PDB files does: models may end without MODEL."""
        file = cls(list(_lines(text)))
        model, closed, filled, number = 0, False, False, 1
        serials: dict[str, int] = {}
        for place, line in enumerate(file.lines):
            if line.is_atom:
                if closed and filled:
                    model, filled, number, serials = model + 1, False, number + 1, {}
                closed = False
                if not filled:
                    file.model_numbers.append(number)
                filled = True
                serials[line.serial] = file.row_of[place] = len(file.atoms)
                file.atoms.append(place)
                file.rows.append(_row(line.text, model))
            elif line.kind == "MODEL":
                if filled:
                    model, filled, serials = model + 1, False, {}
                closed = False
                number = _integer(line.text[10:14], number + 1)
            elif line.kind in ("END", "ENDMDL"):
                closed = True
            elif line.kind in _FOLLOWS and line.serial in serials:
                file.row_of[place] = serials[line.serial]
            file.model_of.append(model)
        return file

    def end_of(self, row: int) -> int:
        """The last of the lines of an atom that follow each other."""
        place = self.atoms[row]
        while self.row_of.get(place + 1) == row:
            place += 1
        return place

    @property
    def has_elements(self) -> bool:
        """Whether its atoms have element symbols."""
        return any(_ELEMENT.fullmatch(self.lines[place].text[76:78]) for place in self.atoms)

    @property
    def line_end(self) -> str:
        """How its lines end."""
        return next((line.end for line in self.lines if line.end), "\n")


def decoded(serial: str) -> int | None:
    """A serial number in digits or in hybrid-36; None where it is neither.

    >>> decoded("99999"), decoded("A0000"), decoded("*****")
    (99999, 100000, None)
    """
    if serial.isdecimal():
        return int(serial)
    if len(serial) == 5 and serial.isalnum() and serial.isascii() and serial[0].isalpha():
        if serial == serial.upper():
            return int(serial, _BASE) - _SHIFT + LAST_SERIAL + 1
        if serial == serial.lower():
            return int(serial, _BASE) - _SHIFT + LAST_SERIAL + 1 + _PER_CASE
    return None


def encoded(serial: int) -> str:
    """A serial number in five columns, beyond 99,999 in hybrid-36.

    >>> encoded(7), encoded(100_000), encoded(100_000 + 26 * 36**4)
    ('    7', 'A0000', 'a0000')
    """
    if serial <= LAST_SERIAL:
        return f"{serial:5d}"
    lower, rest = divmod(serial - LAST_SERIAL - 1, _PER_CASE)
    signs, rest = "", rest + _SHIFT
    while rest:
        rest, digit = divmod(rest, _BASE)
        signs = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ"[digit] + signs
    return signs.lower() if lower else signs


def holds(atom: NewAtom, like: str) -> bool:
    """Whether the columns of the format hold an atom; `like` is an atom of its chain."""
    residue = atom.residue
    xyz = residue.positions_A[atom.atom].tolist()
    return (
        len(atom.name) <= 4
        and (atom.completes or len(residue.resname) <= 3)
        and (atom.completes or -999 <= residue.number <= 9999)
        and len(residue.icode) <= 1
        and residue.chain in ("", *_chains(like))
        and fits_columns(xyz)
    )


def fits_columns(position_A: Iterable[float]) -> bool:
    """Whether the columns of the format hold coordinates, Å."""
    return all(-999.9995 < x < 9999.9995 for x in position_A)


def atom_text(atom: NewAtom, like: str, kind: str, elements: bool) -> str:
    """The record of a new atom, all but its serial number.

    Parameters
    ----------
    atom : NewAtom
    like : str
        An atom of its chain, or of its residue where that has atoms.
    kind : str
        ATOM or HETATM.
    elements : bool
        Whether element symbols are written.

    Returns
    -------
    str
    """
    residue, k = atom.residue, atom.atom
    element = residue.elements[k].upper()
    like = f"{like:<{_WIDTH}}"
    name = atom.name if len(atom.name) == 4 or len(element) == 2 else f" {atom.name}"
    if atom.completes:
        place = like[17:27]
    else:
        place = f"{residue.resname:>3}{like[20:22]}{residue.number:4d}{residue.icode:1}"
    x, y, z = residue.positions_A[k].tolist()
    numbers = "".join(map(number_text, residue.numbers(k)))
    return (
        f"{kind:<6}      {name:4s}{atom.altloc:1s}{place}   "
        f"{x:8.3f}{y:8.3f}{z:8.3f}{numbers}      {like[72:76]}{element if elements else '':>2}  "
    )


def number_text(value: float) -> str:
    """An occupancy or a B factor in its six columns.

    >>> number_text(1.0), number_text(1234.5)
    ('  1.00', '1234.5')
    """
    text = f"{value:6.2f}"
    return text if len(text) == 6 else f"{value:6.1f}"[:6]


def as_wide(text: str, like: str) -> str:
    """A text with blanks at its end, to the width of another one, if that has some.

    >>> as_wide("TER", "CONECT    "), as_wide("TER ", "CONECT")
    ('TER       ', 'TER')
    """
    text = text.rstrip()
    return f"{text:<{len(like)}}" if like.endswith(" ") else text


def with_position(text: str, position_A: tuple[float, ...]) -> str:
    """The record of an atom at another place."""
    return f"{text[:30]}{''.join(f'{x:8.3f}' for x in position_A)}{text[54:]}"


def _lines(text: str) -> Iterator[Line]:
    for raw in io.StringIO(text, newline=""):
        body = raw.rstrip("\r\n")
        own = body.lstrip(" \t")
        kind = own[:6].rstrip().upper()
        if kind[:4] == "ATOM" and _ATOM.match(own):
            kind = "ATOM"
        elif kind[:3] == "TER" and not kind[3:].strip("0123456789 "):
            kind = "TER"
        begin = 4 if kind == "ATOM" else 6
        serial = own[begin:11].strip() if kind in _SERIAL else ""
        yield Line(own, body[: len(body) - len(own)], raw[len(body) :], kind, serial)


def _row(text: str, model: int) -> Row:
    one, two = _chains(text)
    number = _integer(text[22:26], 0)
    place: Place = (one, number, text[26:27].strip())
    return Row(model, place, text[17:21].strip(), text[12:16].strip(), text[16].strip(), "", two)


def _chains(text: str) -> tuple[str, str]:
    """The chain of an atom, and another name that it may have.

    Its letter and that with the column before, where some programs write a first letter; without a
    letter its segment, and no name.
    """
    letter = text[21:22].strip()
    if letter:
        return letter, f"{text[20]}{letter}".strip()
    return text[72:76].strip(), ""


def _integer(text: str, otherwise: int) -> int:
    try:
        return int(text)
    except ValueError:
        return otherwise
