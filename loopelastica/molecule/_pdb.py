"""PDB files: looked through once, record by record, and handed to MDAnalysis without the rest.

MDAnalysis reads most files well, but fails late, loudly or not at all on damaged ones, keeps a copy
of all lines of a model, and cannot read models of unequal size. The scan checks what both need,
keeps the positions of all models, and of the records those of the first model.
"""

from __future__ import annotations

import codecs
import io
import re
from array import array
from collections.abc import Generator, Iterator
from contextlib import closing
from dataclasses import dataclass, field
from itertools import takewhile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.errors import StructureError
from loopelastica.molecule._frames import Frames, TableFrames, TrajectoryFrames, universe_with
from loopelastica.molecule._matching import matched
from loopelastica.molecule._source import Limits, name_of, pieces

_COORDINATES = (slice(30, 38), slice(38, 46), slice(46, 54))  # PDB format 3.3, columns 31-54
_NAMES = slice(12, 20)  # atom name, altloc, residue name: copies of a chain have these in common
_IDENTITY = slice(12, 27)  # atom name, altloc, residue name, chain, number, insertion code
_SERIAL, _NAME, _RESIDUE, _NUMBER = slice(6, 11), slice(12, 16), slice(17, 21), slice(22, 26)
_WIDTH = 80
# Anything longer is no record: what is left of a line at the end of a piece is kept up to here.
_LINE_MAX = 1000
# A serial of six digits begins in the sixth column.
_ATOM = r"ATOM[ \d][ \d]|HETATM"
_RECORD = re.compile(rf"^[ \t]*(?:{_ATOM}|MODEL |END).*", re.MULTILINE)
_KEPT = re.compile(rf"^[ \t]*(?:{_ATOM}|ANISOU|TER|CRYST1|ENDMDL).*", re.MULTILINE)


def open_pdb(path: Path, limits: Limits) -> tuple[Any, Frames]:
    """Universe and models of a PDB file.

    Parameters
    ----------
    path : Path
        The file.
    limits : Limits
        How large it may be.

    Raises
    ------
    StructureError
        If it is empty, too large, cut short or no PDB file, or has a record that cannot be read.
    """
    scan = _Scan(path, limits)
    with closing(_records(path, limits, _RECORD)) as records:
        for number, line in records:
            scan.take(number, line)
    positions, alike = scan.models_alike()
    as_it_is = alike and not scan.indented
    universe = universe_with(
        path, bytes(scan.topology), "PDB", positions[: None if as_it_is else 1]
    )
    return universe, TrajectoryFrames(universe) if as_it_is else TableFrames(positions, alike)


def pdb_text(path: Path, limits: Limits) -> str:
    """The whole content of a PDB file; lines begin with their record and end in a line feed."""
    text = b"".join(pieces(path, limits)).decode("utf-8-sig", "replace")
    if not text or text.isspace():
        raise StructureError(f"{name_of(path)}: the file is empty")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    return re.sub(rf"^[ \t]+(?={_ATOM}|MODEL |END|TER)", "", text, flags=re.MULTILINE)


def scan_pdb(path: Path, text: str, limits: Limits) -> int:
    """Look a text through as `open_pdb` does.

    Parameters
    ----------
    path : Path
        The file, for the sentence.
    text : str
        Its whole content.
    limits : Limits
        How many atoms a model may have.

    Returns
    -------
    int
        Number of models.

    Raises
    ------
    StructureError
        If a record cannot be read, or the text has no atoms or is cut short.
    """
    scan = _Scan(path, limits)
    for number, line in _wanted(text, 1, _RECORD):
        scan.take(number, line)
    return len(scan.models_alike()[0])


def pdb_records(path: Path) -> list[str]:
    """Lines of the first model of a PDB file as they are: atoms, ANISOU and TER, and CRYST1."""
    # The file was read within the limits of the user before.
    with closing(_records(path, Limits(max_size_MB=1e12), _KEPT)) as found:
        lines = (line.lstrip() for _, line in found)
        return list(takewhile(lambda line: not line.startswith("ENDMDL"), lines))


def _records(
    path: Path, limits: Limits, wanted: re.Pattern[str]
) -> Generator[tuple[int, str], None, None]:
    """Number and text of each line that is wanted; any line ends."""
    decoder = codecs.getincrementaldecoder("utf-8-sig")("replace")
    lines = io.IncrementalNewlineDecoder(decoder, translate=True)
    number, rest, blank = 1, "", True
    with closing(pieces(path, limits)) as content:
        for piece in content:
            text = lines.decode(piece)
            blank = blank and text.isspace()
            end = text.rfind("\n") + 1
            if not end:
                rest = (rest + text)[:_LINE_MAX]
                continue
            whole, rest = rest + text[:end], text[end:][:_LINE_MAX]
            yield from _wanted(whole, number, wanted)
            number += whole.count("\n")
    if blank:
        raise StructureError(f"{name_of(path)}: the file is empty")
    yield from _wanted(rest + lines.decode(b"", final=True), number, wanted)


def _wanted(text: str, number: int, wanted: re.Pattern[str]) -> Iterator[tuple[int, str]]:
    counted = 0
    for match in wanted.finditer(text):
        number += text.count("\n", counted, match.start())
        counted = match.start()
        yield number, match.group()


@dataclass(slots=True)
class _Model:
    """The atoms of one model; `closed` once its ENDMDL was seen."""

    positions: array[float] = field(default_factory=lambda: array("d"))
    identities: array[int] = field(default_factory=lambda: array("i"))
    closed: bool = False

    def __len__(self) -> int:
        return len(self.identities)


class _Scan:
    """What the records of a file come to."""

    def __init__(self, path: Path, limits: Limits) -> None:
        self._path, self._limits, self._name = path, limits, name_of(path)
        self._models = [_Model()]
        self._identities: dict[str, int] = {}
        self._unnumbered: dict[str, tuple[int, str]] = {}
        self._sugars: set[str] = set()
        self.topology = bytearray()
        self.indented = False

    def take(self, number: int, raw: str) -> None:
        """Take in the next record; `number` is that of its line."""
        line = raw.lstrip()
        self.indented |= len(line) != len(raw)
        if line.startswith(("ATOM", "HETATM")):
            self._take_atom(number, line)
        elif line.startswith("MODEL "):
            if len(self._models[-1]):
                self._models.append(_Model())
        elif line.startswith("END"):
            self._models[-1].closed = True

    def _take_atom(self, number: int, line: str) -> None:
        if len(line) < _COORDINATES[-1].stop:
            raise StructureError(
                f"{self._name}: line {number} is cut short before its coordinates end"
            )
        try:
            position = [float(line[part]) for part in _COORDINATES]
        except ValueError:
            raise StructureError(
                f"{self._name}: line {number} has no readable coordinates ({line[30:54].strip()!r})"
            ) from None
        model = self._models[-1]
        if model.closed and len(model):
            # Some programs write models without MODEL.
            model = _Model()
            self._models.append(model)
        self._limits.check_atoms(self._path, len(model) + 1)
        model.positions.extend(position)
        identity = line[_IDENTITY]
        model.identities.append(self._identities.setdefault(identity, len(self._identities)))
        if len(self._models) == 1:
            self._keep(number, line)

    def _keep(self, number: int, line: str) -> None:
        """Keep a record of the first model for MDAnalysis, with what it could stumble over mended.

        It reads serials that nothing here needs, and takes 1 for a residue number that it cannot
        read, which matters only where the residue may be a nucleotide.
        """
        line = line[:_WIDTH]
        if not line.isprintable():
            line = "".join(c if c.isprintable() else " " for c in line)
        if line[:4] == "ATOM":
            line = f"ATOM  {line[6:]}"
        if not line[_SERIAL].strip().isdecimal():
            line = f"{line[:6]}*****{line[11:]}"
        if line[_NAME].strip() in ("C1'", "C1*"):
            self._sugars.add(line[_RESIDUE])
        try:
            int(line[_NUMBER])
        except ValueError:
            self._unnumbered.setdefault(line[_RESIDUE], (number, line[_NUMBER].strip()))
        self.topology += line.encode()
        self.topology += b"\n"

    def models_alike(self) -> tuple[Array, bool]:
        """Positions (n_models, n_atoms, 3), and whether all models name the same atoms in order.

        Otherwise they are in the order of the first model, NaN where one lacks an atom.
        """
        models = self._models
        first, last = models[0], models[-1]
        if not len(first):
            raise StructureError(
                f"{self._name}: no ATOM or HETATM record, so this is not a PDB structure"
            )
        if not len(last):
            raise StructureError(
                f"{self._name}: the file is cut short, model {len(models)} has no atoms"
            )
        faults = [fault for name, fault in self._unnumbered.items() if name in self._sugars]
        if faults:
            number, text = min(faults)
            raise StructureError(
                f"{self._name}: line {number} has no readable residue number ({text!r})"
            )
        tables = [np.frombuffer(m.positions, dtype=np.float64).reshape(-1, 3) for m in models]
        codes = [np.frombuffer(m.identities, dtype=np.intc) for m in models]
        if all(len(m) == len(first) for m in models) and self._in_one_order(codes):
            return np.stack(tables), True
        if not last.closed:
            raise StructureError(
                f"{self._name}: the file is cut short, model {len(models)} has {len(last)} of"
                f" {len(first)} atoms"
            )
        return matched(codes, tables), False

    def _in_one_order(self, codes: list[NDArray[np.intc]]) -> bool:
        """Whether names agree from model to model, as MDAnalysis takes for granted."""
        kinds: dict[str, int] = {}
        width = _NAMES.stop - _NAMES.start
        kind = np.array([kinds.setdefault(i[:width], len(kinds)) for i in self._identities])
        first = kind[codes[0]]
        return all((kind[other] == first).all() for other in codes[1:])
