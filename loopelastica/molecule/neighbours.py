"""What else a structure holds where a hairpin loop goes: heavy atoms that stand in its way.

For :mod:`.surroundings` a structure is what gemmi has read; here it is a Universe, which may come
from anywhere and may have a trajectory.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record
from loopelastica.molecule._recognition import chains_of, preferred, strings
from loopelastica.molecule.ends import StemEnds
from loopelastica.molecule.hairpins import Hairpin
from loopelastica.molecule.nucleotides import Structure
from loopelastica.molecule.obstacles import CROWDED_A, HALIDES, in_reach

WATER: Final = ("HOH", "DOD", "WAT", "SOL", "H2O", "TIP", "TIP3", "TIP4")
_METALS: Final = (
    "LI NA K RB CS MG CA SR BA MN FE CO NI CU ZN CD HG AG PT PB TL SM GD TB EU YB LU LA CE PR ND HO"
    " ER DY TM AL GA IN IR OS RU RH PD AU CR V W MO Y ZR"
)
METALS: Final = frozenset(_METALS.split())
"""Residue names of metal ions."""


def elements(structure: Structure) -> NDArray[np.str_]:
    """Element of every atom, from its name (the file may have none)."""
    names = np.asarray(structure.universe.atoms.names, dtype=object).astype(str)
    return np.array([name.strip().lstrip("0123456789")[:1].upper() for name in names])


def waters(structure: Structure) -> NDArray[np.bool_]:
    """Which atoms are water: it gives way to the loop, and was placed with the file's own one."""
    water = np.isin(_resnames(structure), WATER)
    return np.asarray(water[structure.universe.atoms.resindices])


def solid(structure: Structure) -> NDArray[np.bool_]:
    """Heavy atoms but water, of alternative locations one."""
    hydrogen = np.isin(elements(structure), ["H", "D"])
    return np.asarray(~(hydrogen | waters(structure)) & one_location(structure))


def _resnames(structure: Structure) -> NDArray[np.str_]:
    residues = structure.universe.residues
    names = getattr(residues, "resnames", np.full(len(residues), ""))
    return np.char.upper(np.char.strip(np.asarray(names, dtype=object).astype(str)))


def one_location(structure: Structure) -> NDArray[np.bool_]:
    """Which atoms are left where of alternative locations one is taken.

    In each residue it is the one of highest mean occupancy, as the nucleotides were read; where
    residues of different names share a place, one of them is left: the nucleotide that was read,
    else that of highest occupancy.

    Parameters
    ----------
    structure : Structure
        What was read.

    Returns
    -------
    (n_atoms,) array of bool
    """
    atoms = structure.universe.atoms
    altloc = strings(atoms, "altLocs")
    if not (altloc != "").any():
        return np.ones(len(atoms), dtype=np.bool_)
    occupancy = np.asarray(getattr(atoms, "occupancies", np.ones(len(atoms))), dtype=np.float64)
    residue = np.asarray(atoms.resindices, dtype=np.int64)
    left = preferred(residue, altloc, occupancy)
    read = structure.nucleotides.atom_index.max(axis=1)
    nucleotides = set(residue[read].tolist())
    chain, icode = chains_of(atoms), strings(structure.universe.residues, "icodes")
    rivals: dict[tuple[str, int, str], list[int]] = {}
    for here in dict.fromkeys(residue[altloc != ""].tolist()):
        mine = np.flatnonzero(residue == here)
        if (altloc[mine] != "").all():
            place = (str(chain[mine[0]]), int(atoms.resids[mine[0]]), str(icode[here]))
            rivals.setdefault(place, []).append(here)
    for residues in rivals.values():
        if len(residues) > 1:
            best = max(
                residues,
                key=lambda r: (r in nucleotides, round(occupancy[left & (residue == r)].mean(), 4)),
            )
            left &= (residue == best) | ~np.isin(residue, residues)
    return np.asarray(left, dtype=np.bool_)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Neighbours(Record):
    """Atoms that stand in a line's way wherever it goes: heavy ones, no waters, no bare ions.

    Attributes
    ----------
    rows : (m,) array of int
        Which atoms of the structure.
    residue : (m,) array of int
        The residue of each.
    of_nucleotide : (n_nucleotides,) array of int
        The residue of each nucleotide.
    """

    rows: NDArray[np.int64]
    residue: NDArray[np.int64]
    of_nucleotide: NDArray[np.int64]

    def __repr__(self) -> str:
        return f"<Neighbours: {len(self.rows)} atoms>"

    def around(
        self, hairpin: Hairpin, ends: StemEnds, line_A: Array, positions: Array
    ) -> Array | None:
        """What a loop's line may run into, if anything but its own hairpin is near.

        Parameters
        ----------
        hairpin : Hairpin
            Which loop. It and its closing pair, from which the line comes, are not in the way.
        ends : StemEnds
            Ends and length of the line.
        line_A : (k, 3) array
            Points of it where nothing is in its way, Å.
        positions : (n_atoms, 3) array
            All atoms of the model, Å.

        Returns
        -------
        (m, 3) array or None
            Å; None where no atom of another nucleotide or molecule is within ``CROWDED_A`` of it.
        """
        places = positions[self.rows]
        near = np.flatnonzero(in_reach(ends, places))
        near = near[~self._of(near, [hairpin.loop, hairpin.stem_5[:1], hairpin.stem_3[:1]])]
        places = places[near]
        others = places[~self._of(near, [hairpin.stem_5, hairpin.stem_3])]
        if not len(others):
            return None
        apart = np.linalg.norm(others[:, None] - line_A, axis=2).min()
        return places if apart < CROWDED_A else None

    def _of(
        self, atoms: NDArray[np.intp], nucleotides: list[NDArray[np.int64]]
    ) -> NDArray[np.bool_]:
        rows = np.concatenate(nucleotides)
        return np.isin(self.residue[atoms], self.of_nucleotide[rows[rows >= 0]])


def neighbours(structure: Structure) -> Neighbours:
    """The atoms of a structure that stand in a line's way wherever it goes.

    Parameters
    ----------
    structure : Structure
        What was read.

    Returns
    -------
    Neighbours
    """
    residue = np.asarray(structure.universe.atoms.resindices)
    bare = np.bincount(residue)[residue] == 1
    ion = bare & np.isin(_resnames(structure), [*METALS, *HALIDES])[residue]
    rows = np.flatnonzero(solid(structure) & ~ion)
    # of each nucleotide any atom that is there tells the residue
    known = structure.nucleotides.atom_index.max(axis=1)
    return Neighbours(rows, residue[rows], residue[known])
