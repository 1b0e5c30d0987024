"""What an input says besides its atoms: its unit cell, and where it ends its chains."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from loopelastica.molecule._mmcif import read_text
from loopelastica.molecule._source import Limits
from loopelastica.molecule.nucleotides import Structure, is_pdb, pdb_records
from loopelastica.molecule.reading import is_mmcif

# what is no unit cell is written as a cube of 1 Å, or of none
_PLACEHOLDER_A: Final = 1.001
_CELL: Final = ("length_a", "length_b", "length_c", "angle_alpha", "angle_beta", "angle_gamma")


@dataclass(frozen=True, slots=True, eq=False)
class Origin:
    """What an input says besides its atoms.

    Attributes
    ----------
    cell : tuple of float or None
        Lengths (Å) and angles (°) of the unit cell; None where the input has none, or only a
        placeholder.
    space_group : str
        Its name, "" where the input has none.
    ends : frozenset of int or None
        Atoms of the structure that a TER record follows; None where the input has no such records.
    """

    cell: tuple[float, ...] | None = None
    space_group: str = ""
    ends: frozenset[int] | None = None


def origin_of(structure: Structure) -> Origin:
    """What the input of a structure says besides its atoms.

    Parameters
    ----------
    structure : Structure
        From a file or a Universe.

    Returns
    -------
    Origin
    """
    path = Path(structure.source) if structure.source else None
    if path is not None and is_pdb(path):
        return _of_pdb(pdb_records(path), len(structure.universe.atoms))
    if path is not None and is_mmcif(path):
        # the file was read within the limits of the user before
        return _of_mmcif(read_text(path, Limits(max_size_MB=1e12)))
    dimensions = getattr(structure.universe, "dimensions", None)
    return Origin(None if dimensions is None else _real([float(value) for value in dimensions]))


def _of_pdb(records: list[str], n_atoms: int) -> Origin:
    import gemmi

    cell, space_group, ends, atom = None, "", set(), -1
    for record in records:
        if record.startswith(("ATOM", "HETATM")):
            atom += 1
        elif record.startswith("TER"):
            ends.add(atom)
        elif record.startswith("CRYST1"):
            header = gemmi.read_pdb_string(record)
            cell, space_group = _real(header.cell.parameters), header.spacegroup_hm
    known = frozenset(ends) if ends and atom + 1 == n_atoms else None
    return Origin(cell, space_group if cell else "", known)


def _of_mmcif(text: bytes) -> Origin:
    from gemmi import cif

    block = cif.read_string(text).sole_block()
    values = [cif.as_number(block.find_value(f"_cell.{name}") or "?") for name in _CELL]
    names = ("_symmetry.space_group_name_H-M", "_space_group.name_H-M_alt")
    found = (cif.as_string(block.find_value(name) or "?") for name in names)
    cell = _real(values)
    return Origin(cell, next(filter(None, found), "") if cell else "")


def _real(values: Any) -> tuple[float, ...] | None:
    """A unit cell; None for a placeholder."""
    cell = tuple(float(value) for value in values)
    # not a number is never more than something
    return cell if all(length > _PLACEHOLDER_A for length in cell[:3]) else None
