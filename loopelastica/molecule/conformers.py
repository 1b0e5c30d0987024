"""One alternative location of everything: residues and atoms of a model as all others see them.

Of alternative locations the one of highest mean occupancy in its residue is taken, the first by
letter among equals; of two residues that share one place, the one of higher occupancy.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np

from loopelastica._arrays import Array
from loopelastica.molecule.components import (
    atom_name,
    component,
    is_nucleotide,
    letter_of,
    sugar_of,
)
from loopelastica.molecule.polymer import Monomer

_NONE = "\0"  # gemmi's sign for no alternative location


@dataclass(frozen=True, slots=True, eq=False)
class Taken:
    """A residue, and its heavy atoms that were taken.

    Attributes
    ----------
    residue : gemmi.Residue
    atoms : list of gemmi.Atom
        Heavy atoms of one alternative location, in the order of the file.
    altloc : str
        That location; "" where the residue has but one.
    rivals : tuple of str
        Names of other residues at the same place that were not taken.
    """

    residue: Any
    atoms: list[Any]
    altloc: str = ""
    rivals: tuple[str, ...] = ()

    @property
    def place(self) -> tuple[int, str]:
        """Author number and insertion code."""
        seqid = self.residue.seqid
        return seqid.num, seqid.icode.strip()

    @property
    def is_nucleotide(self) -> bool:
        """Whether it may stand in a chain of nucleotides."""
        return is_nucleotide(self.residue.name, (atom.name for atom in self.atoms))


def taken(chain: Any) -> Iterator[Taken]:
    """Residues of a chain of gemmi in the order of the file, one at each place."""
    for _, group in groupby(chain, key=lambda residue: str(residue.seqid)):
        residues = list(group)
        for rivals in _rivals(residues):
            ranked = sorted(rivals, key=_occupancy, reverse=True)
            names = tuple(other.name for other in ranked[1:])
            atoms, altloc = _one_location(ranked[0])
            yield Taken(ranked[0], atoms, altloc, names)


def _rivals(residues: list[Any]) -> list[list[Any]]:
    """Put residues of one number together where they are alternatives of each other."""
    if len(residues) > 1 and all(_alternative(residue) for residue in residues):
        return [residues]
    return [[residue] for residue in residues]


def _alternative(residue: Any) -> bool:
    return all(atom.altloc != _NONE for atom in residue)


def _occupancy(residue: Any) -> float:
    # occupancies come in hundredths: rounding keeps a tie a tie
    return round(float(np.mean([atom.occ for atom in residue])), 4)


def _one_location(residue: Any) -> tuple[list[Any], str]:
    atoms = [atom for atom in residue if not is_hydrogen(atom)]
    letters = sorted({atom.altloc for atom in atoms} - {_NONE})
    if not letters:
        return _once(atoms), ""
    mean = {
        letter: round(float(np.mean([a.occ for a in atoms if a.altloc == letter])), 4)
        for letter in letters
    }
    chosen = max(letters, key=lambda letter: (mean[letter], -ord(letter)))
    # an atom that the chosen location lacks is taken from the next best one
    order = {_NONE: 0, chosen: 1}
    found = sorted(atoms, key=lambda a: (order.get(a.altloc, 2), -mean.get(a.altloc, 1.0)))
    kept = {id(atom) for atom in _once(found)}
    return [atom for atom in atoms if id(atom) in kept], chosen


def _once(atoms: Sequence[Any]) -> list[Any]:
    """Atoms without those whose name came before."""
    found: dict[str, Any] = {}
    for atom in atoms:
        found.setdefault(atom.name, atom)
    return list(found.values())


def is_hydrogen(atom: Any) -> bool:
    """Whether an atom is hydrogen, by its element or, where that is unknown, by its name."""
    if atom.element.name != "X":
        return bool(atom.is_hydrogen())
    return atom.name.lstrip("0123456789")[:1] in ("H", "D")


def monomer(chain: str, one: Taken, record: int | None = None, letter: str = "N") -> Monomer:
    """Nucleotide of a residue.

    Parameters
    ----------
    chain : str
        The author's name of its chain.
    one : Taken
        The residue.
    record : int, optional
        Its place in the sequence of record, from 1.
    letter : str
        Parent base that the file states, "N" where it states none.

    Returns
    -------
    Monomer
    """
    resname = one.residue.name
    atoms_A = {atom_name(atom.name, resname): _position(atom) for atom in one.atoms}
    known = component(resname)
    is_dna = sugar_of(atoms_A)
    if is_dna is None:
        is_dna = bool(known and known.is_dna)
    if known and known.letter != "N":
        letter = known.letter
    elif letter == "N":
        letter = letter_of(atoms_A, is_dna)
    number, icode = one.place
    return Monomer(chain, number, icode, resname, letter, is_dna, record, atoms_A)


def _position(atom: Any) -> Array:
    position = np.array(atom.pos.tolist())
    position.setflags(write=False)
    return position
