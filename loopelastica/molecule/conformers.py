"""One alternative location of everything: residues and atoms of a model as all others see them.

Of alternative locations the one of highest mean occupancy is taken, in a row of residues that have
them the same one, the first by letter among equals; of two residues that share one place, the one
of higher occupancy.
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
    def repeated(self) -> bool:
        """Whether an atom is there twice: residues of one name and number that gemmi joins."""
        return len({atom.name for atom in self.atoms}) < len(self.atoms)

    @property
    def is_nucleotide(self) -> bool:
        """Whether it may stand in a chain of nucleotides."""
        return is_nucleotide(self.residue.name, (atom.name for atom in self.atoms))


def taken(chain: Any) -> Iterator[Taken]:
    """Residues of a chain of gemmi in the order of the file, one at each place."""
    places = [_rivals(list(group)) for _, group in groupby(chain, key=_seqid)]
    for run in _runs([rivals for place in places for rivals in place]):
        mean = _means(run)
        for rivals in run:
            if len(rivals) == 1:
                yield Taken(rivals[0].residue, *rivals[0].chosen(mean))
                continue
            ranked = sorted(rivals, key=lambda one: max(mean[x] for x in one.letters), reverse=True)
            names = tuple(other.residue.name for other in ranked[1:])
            yield Taken(ranked[0].residue, *ranked[0].chosen(mean), names)


@dataclass(slots=True, eq=False)
class _Heavy:
    """A residue with its heavy atoms, and its alternative locations by letter."""

    residue: Any
    atoms: list[Any]
    letters: list[str]

    def chosen(self, mean: dict[str, float]) -> tuple[list[Any], str]:
        """Atoms of the location of highest occupancy; what it lacks from the next best one."""
        if not self.letters:
            return self.atoms, ""
        order = sorted(self.letters, key=lambda letter: -mean[letter])
        rank = {letter: k for k, letter in enumerate([_NONE, *order])}
        best = _once(sorted(self.atoms, key=lambda atom: rank[atom.altloc]))
        kept = {id(atom) for atom in best}
        return [atom for atom in self.atoms if id(atom) in kept], order[0]


def _seqid(residue: Any) -> tuple[int, str]:
    seqid = residue.seqid
    return seqid.num, seqid.icode


def _heavy(residue: Any) -> _Heavy:
    atoms = [atom for atom in residue if not is_hydrogen(atom)]
    return _Heavy(residue, atoms, sorted({atom.altloc for atom in atoms} - {_NONE}))


def _rivals(residues: list[Any]) -> list[list[_Heavy]]:
    """Put residues of one number together where they are alternatives of each other."""
    found = [one for residue in residues if (one := _heavy(residue)).atoms]
    if len(found) > 1 and all(atom.altloc != _NONE for one in found for atom in one.atoms):
        return [found]
    return [[one] for one in found]


def _runs(places: list[list[_Heavy]]) -> Iterator[list[list[_Heavy]]]:
    """Neighbours with alternative locations belong together: one location is taken in all."""
    run: list[list[_Heavy]] = []
    for rivals in places:
        alone = rivals[0].residue.is_water() or not any(one.letters for one in rivals)
        if run and (alone or not _neighbours(run[-1][0].residue, rivals[0].residue)):
            yield run
            run = []
        if alone:
            yield [rivals]
        else:
            run.append(rivals)
    if run:
        yield run


def _neighbours(first: Any, second: Any) -> bool:
    # across a gap too: what stands on both its sides must be of one location
    in_chain = first.het_flag == second.het_flag == "A"
    return in_chain or bool(second.seqid.num - first.seqid.num <= 1)


def _means(run: list[list[_Heavy]]) -> dict[str, float]:
    """Mean occupancy of each alternative location of a run, the first letter first."""
    found: dict[str, list[float]] = {}
    for rivals in run:
        for one in rivals:
            if one.letters:
                for atom in one.atoms:
                    found.setdefault(atom.altloc, []).append(atom.occ)
    # occupancies come in hundredths: rounding keeps a tie a tie
    return {letter: round(float(np.mean(found[letter])), 4) for letter in sorted(found)}


def _once(atoms: Sequence[Any]) -> list[Any]:
    """Atoms without those whose name came before."""
    found: dict[str, Any] = {}
    for atom in atoms:
        found.setdefault(atom.name, atom)
    return list(found.values())


def is_hydrogen(atom: Any) -> bool:
    """Whether an atom is hydrogen, by its element or, where that is unknown, by its name."""
    if atom.is_hydrogen():
        return True
    first = atom.name.lstrip("0123456789")[:1]
    return first in ("H", "D") and atom.element.name == "X"


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
