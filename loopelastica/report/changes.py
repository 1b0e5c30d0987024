"""What is to change in a structure file: atoms added, moved and left out, and what is said of it.

Residues are named as the author of the file names them; models count from 0.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from loopelastica._arrays import Array, Record, read_only
from loopelastica._names import printable

Place = tuple[str, int, str]
"""The author's chain ("" where it has no name), residue number and insertion code ("" for none)."""

# What people write in sentences, in the letters that both formats hold.
_ASCII: Final = str.maketrans({"Å": "A", "–": "-", "—": "-", "−": "-", "…": "...", "×": "x"})


@dataclass(frozen=True, slots=True, eq=False)
class AddedResidue(Record):
    """Atoms of one nucleotide that the file does not have; all of them, or those that it lacks.

    Attributes
    ----------
    model : int
        Index of the model, from 0.
    chain, number, icode, resname : str, int, str, str
        As the author names it, or would. An incomplete nucleotide keeps the name it has.
    after : tuple of (str, int, str) or None
        Chain, number and insertion code of the nucleotide before it in the chain, which may be an
        added one; None where it begins the chain. An incomplete nucleotide stays where it is.
    names, elements : tuple of str
        Names (today's, of the wwPDB) and element symbols of the k atoms.
    positions_A : (k, 3) array
        Å.
    occupancy, b_factor_A2 : (k,) array
        One number serves for all atoms; B factors in Å².
    asym : str or None
        mmCIF's own name of the chain, `label_asym_id`; None: that of the neighbours.
    record : int or None
        Place in the sequence of record, from 1.

    Raises
    ------
    ValueError
        If the lengths do not fit, or a number is not finite.
    """

    model: int
    chain: str
    number: int
    icode: str
    resname: str
    after: Place | None
    names: tuple[str, ...]
    elements: tuple[str, ...]
    positions_A: Array
    occupancy: Array | float = 1.0
    b_factor_A2: Array | float = 0.0
    asym: str | None = None
    record: int | None = None

    def __post_init__(self) -> None:
        k = len(self.names)
        positions = read_only(self.positions_A)
        if k == 0 or len(set(self.names)) < k:
            raise ValueError(f"`names`: {self.label} needs atoms of different names")
        if len(self.elements) != k or positions.shape != (k, 3):
            raise ValueError(f"`elements`, `positions_A`: {self.label} has {k} names of atoms")
        object.__setattr__(self, "positions_A", positions)
        for name in ("occupancy", "b_factor_A2"):
            values = read_only(np.broadcast_to(getattr(self, name), (k,)))
            object.__setattr__(self, name, values)
        numbers = (positions, self.occupancy, self.b_factor_A2)
        if not all(np.isfinite(values).all() for values in numbers):
            raise ValueError(f"`positions_A`: {self.label} has a number that is not finite")

    def numbers(self, atom: int) -> tuple[float, float]:
        """Occupancy and B factor of one of its atoms."""
        occupancy, b_factor_A2 = np.asarray(self.occupancy), np.asarray(self.b_factor_A2)
        return float(occupancy[atom]), float(b_factor_A2[atom])

    @property
    def place(self) -> Place:
        """Chain, number and insertion code."""
        return self.chain, self.number, self.icode

    @property
    def label(self) -> str:
        """Label such as "A.G12"."""
        return label(self.place, self.resname)


@dataclass(frozen=True, slots=True)
class Removed:
    """A residue, or one atom of it, that is left out.

    Attributes
    ----------
    model : int
        Index of the model, from 0.
    chain, number, icode, resname : str, int, str, str
        As in the file.
    name : str or None
        Of the atom; None: the residue goes as a whole.
    at_A : tuple of (float, float, float) or None
        Where one of its atoms is, Å: tells apart waters of one number. None: all that have the
        name.
    """

    model: int
    chain: str
    number: int
    icode: str
    resname: str
    name: str | None = None
    at_A: tuple[float, float, float] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Changes(Record):
    """All that changes in a file.

    Attributes
    ----------
    added : tuple of AddedResidue
    moved : mapping of (model, chain, number, icode, atom name) to (3,) array
        New positions of atoms that are there, Å. A moved atom has one location afterwards and no
        anisotropic displacement.
    moved_b_factor_A2, moved_occupancy : float or None
        Written of moved atoms; None: as they were.
    removed : tuple of Removed
    notes : tuple of str
        Sentences for the file itself: REMARK 99, or `_database_PDB_remark`.
    software : tuple of (str, str) or None
        Name and version for mmCIF's `_software`.
    """

    added: tuple[AddedResidue, ...] = ()
    moved: Mapping[tuple[int, str, int, str, str], Array] = field(default_factory=dict)
    moved_b_factor_A2: float | None = None
    moved_occupancy: float | None = None
    removed: tuple[Removed, ...] = ()
    notes: tuple[str, ...] = ()
    software: tuple[str, str] | None = None

    def __post_init__(self) -> None:
        if not all(np.isfinite(position).all() for position in self.moved.values()):
            raise ValueError("`moved`: a position is not finite")

    def __bool__(self) -> bool:
        """Whether anything changes at all."""
        return bool(self.added or self.moved or self.removed or self.notes)

    @property
    def lines(self) -> list[str]:
        """The notes in the letters that both formats hold."""
        return [
            printable(note.translate(_ASCII)).encode("ascii", "replace").decode()
            for note in self.notes
        ]


def label(place: Place, resname: str = "") -> str:
    """Label of a residue in sentences, such as "A.G12", "A.12" or "A.G12^B".

    >>> label(("A", 12, "B"), "G"), label(("", 3, ""))
    ('A.G12^B', '3')
    """
    chain, number, icode = place
    whole = f"{chain}." if chain else ""
    return printable(f"{whole}{resname}{number}{f'^{icode}' if icode else ''}")
