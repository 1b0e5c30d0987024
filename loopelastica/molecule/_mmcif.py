"""mmCIF files: read by gemmi, which MDAnalysis uses too but for the first model only."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from loopelastica.errors import StructureError
from loopelastica.molecule._frames import Frames, TableFrames, TrajectoryFrames, universe_with
from loopelastica.molecule._matching import matched
from loopelastica.molecule._source import Limits, first_line, name_of, pieces

_NEEDED = (
    *("id", "type_symbol", "label_alt_id", "label_asym_id", "auth_seq_id"),
    *("Cartn_x", "Cartn_y", "Cartn_z"),
)
_UNUSED = ("label_entity_id", "label_seq_id", "B_iso_or_equiv", "pdbx_formal_charge")
_NO_NUMBER = -(2**31)  # what gemmi gives for a residue number that is absent
_NAME_MAX = 8
_VALUE = re.compile(rb"'.*?'(?=\s|$)|\".*?\"(?=\s|$)|\S+")
# "data:114:0(1806): Wrong number of values", "data:114 in data_2koc: duplicate tag"
_PLACE = re.compile(r"^(?:data|string):(\d+)(?::\d+)?(?:\(\d+\))?(?=:| in )")


class Parsed(NamedTuple):
    """An mmCIF file that gemmi could read: document and block, structure, all atoms as arrays."""

    document: Any
    block: Any
    structure: Any
    flat: Any


def open_mmcif(path: Path, limits: Limits) -> tuple[Any, Frames]:
    """Universe and models of an mmCIF file.

    Parameters
    ----------
    path : Path
        The file.
    limits : Limits
        How large it may be.

    Raises
    ------
    StructureError
        If it is empty, too large or no mmCIF file, or has a row that cannot be read.
    """
    text = read_text(path, limits)
    _, _, structure, flat = parse_mmcif(path, text, limits)
    topology = _first_model(structure)
    if not topology.isascii():
        raise StructureError(f"{name_of(path)}: {_no_ascii(text)}")
    del text, structure
    begins = np.flatnonzero(np.diff(flat.model_num, prepend=flat.model_num[0] - 1))
    if len(begins) == 1:
        universe = universe_with(path, topology, "CIF", np.array([flat.pos]))
        return universe, TrajectoryFrames(universe)
    identities = np.split(_identities(flat), begins[1:])
    positions = matched(identities, np.split(np.asarray(flat.pos), begins[1:]))
    universe = universe_with(path, topology, "CIF", positions[:1])
    complete = len({len(codes) for codes in identities}) == 1
    return universe, TableFrames(positions, complete)


def parse_mmcif(path: Path, text: bytes, limits: Limits) -> Parsed:
    """What gemmi reads from the text of an mmCIF file.

    Parameters
    ----------
    path : Path
        The file, for the sentence.
    text : bytes
        Its content.
    limits : Limits
        How many atoms it may have.

    Raises
    ------
    StructureError
        If it is empty, too large or no mmCIF structure, or has a row that cannot be read.
    """
    import gemmi

    if not text.strip():
        raise StructureError(f"{name_of(path)}: the file is empty")
    block = None
    try:
        document = gemmi.cif.read_string(text)
        block = document.sole_block()
        structure = gemmi.make_structure_from_block(block)
        if len(structure) == 0 or structure[0].count_atom_sites() == 0:
            raise StructureError(
                f"{name_of(path)}: {_absent(block)}, so this is not an mmCIF structure"
            )
        limits.check_atoms(path, max(model.count_atom_sites() for model in structure))
        flat = gemmi.FlatStructure(structure)
    except StructureError:
        raise
    # gemmi raises ValueError, RuntimeError or IndexError by the place of the fault.
    except Exception as error:
        cause = _fault(block) or _odd_row(text, error) or _PLACE.sub(r"line \1", first_line(error))
        raise StructureError(f"{name_of(path)}: gemmi cannot read it ({cause})") from error
    if not np.isfinite(flat.pos).all() or (flat.resnums == _NO_NUMBER).any():
        fault = _fault(block)
        if fault is not None:
            raise StructureError(f"{name_of(path)}: {fault}")
    return Parsed(document, block, structure, flat)


def _first_model(structure: Any) -> bytes:
    """The first model as mmCIF of its own, in the columns that are used."""
    import gemmi

    first = gemmi.Structure()
    first.add_model(structure[0])
    groups = gemmi.MmcifOutputGroups(False, atoms=True, group_pdb=True)
    document = first.make_mmcif_document(groups)
    loop = document.sole_block().find_loop("_atom_site.id").get_loop()
    for column in _UNUSED:
        loop.remove_column(f"_atom_site.{column}")
    text: str = document.as_string()
    return text.encode()


def _no_ascii(text: bytes) -> str:
    """Where an atom has a name that mmCIF has no signs for."""
    rows = enumerate(text.splitlines(), 1)
    atoms = (n for n, row in rows if row.startswith((b"ATOM", b"HETATM")) and not row.isascii())
    line = next(atoms, None)
    place = "an atom" if line is None else f"line {line}"
    return f"{place} has a name with a sign that is no ASCII; mmCIF allows no other"


def read_text(path: Path, limits: Limits) -> bytes:
    """The content; of blanks by the megabyte one is kept."""
    return b"".join(b"\n" if p.isspace() else p for p in pieces(path, limits))


def _identities(flat: Any) -> NDArray[np.intc]:
    """A number for what names each atom: chain, residue, atom name and alternative location."""
    names = ("chain_ids", "resnums", "icodes", "residue_names", "atom_names", "altlocs")
    columns = [np.ascontiguousarray(getattr(flat, name)) for name in names]
    n = len(flat.resnums)
    rows = np.hstack([column.reshape(n, -1).view(np.uint8).reshape(n, -1) for column in columns])
    keys = rows.view(f"V{rows.shape[1]}").ravel()
    codes: dict[bytes, int] = {}
    return np.array([codes.setdefault(key, len(codes)) for key in keys.tolist()], dtype=np.intc)


# --- what is wrong, in the words of the file ------------------------------------------------------


def _absent(block: Any) -> str:
    if not block.find_mmcif_category("_atom_site."):
        return "no atoms"
    lacking = [name for name in _NEEDED if not block.find_values(f"_atom_site.{name}")]
    return f"no column _atom_site.{lacking[0]}" if lacking else "no atoms"


def _odd_row(text: bytes, error: Exception) -> str | None:
    """The first line of a loop that has not a value for each of its columns."""
    place = _PLACE.match(str(error))
    if place is None or "Wrong number of values" not in str(error):
        return None
    begin, tags = int(place[1]), 0
    for number, line in enumerate(io.BytesIO(text), start=1):
        word = line.lstrip()[:1]
        if number <= begin and not (number == begin and word == b"_"):
            continue
        if word == b"_" and not line.split()[1:]:
            tags += 1
            continue
        n = len(_VALUE.findall(line))
        if n != tags:
            return f"line {number} has {n} values in place of {tags}"
    return None


def _integer(text: str) -> bool:
    return re.fullmatch(r"[+-]?\d+", text) is not None


def _number(text: str) -> bool:
    try:
        return bool(np.isfinite(float(text.split("(")[0])))
    except ValueError:
        return False


def _open(test: Callable[[str], bool]) -> Callable[[str], bool]:
    """The same test of a value that may be absent."""
    return lambda text: text in ("?", ".") or test(text)


_COLUMNS: tuple[tuple[str, str, Callable[[str], bool]], ...] = (
    *((f"Cartn_{axis}", "coordinates", _number) for axis in "xyz"),
    ("auth_seq_id", "residue number", _integer),
    ("label_seq_id", "residue number", _open(_integer)),
    ("pdbx_PDB_model_num", "model number", _integer),
    ("label_alt_id", "alternative location", lambda text: len(text) == 1),
    ("pdbx_PDB_ins_code", "insertion code", lambda text: len(text) == 1),
    ("pdbx_formal_charge", "charge", _open(_integer)),
    *(
        (column, f"{what} of fewer than {_NAME_MAX} characters", lambda t: len(t) < _NAME_MAX)
        for column, what in (
            *(("label_atom_id", "atom name"), ("auth_atom_id", "atom name")),
            *(("label_comp_id", "residue name"), ("auth_comp_id", "residue name")),
            *(("label_asym_id", "chain"), ("auth_asym_id", "chain")),
        )
    ),
)


def _fault(block: Any) -> str | None:
    """The first row of an atom that cannot be read, None where each can."""
    import gemmi

    if block is None:
        return None
    for column, what, readable in _COLUMNS:
        for row, value in enumerate(block.find_values(f"_atom_site.{column}"), start=1):
            text = gemmi.cif.as_string(value) or value
            if not readable(text):
                return f"row {row} of _atom_site has no readable {what} ({text[:40]!r})"
    return None
