"""Where a loop is built: its molecule, the stem's fixed atoms, what is around; in one frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.atoms.chemistry import (
    JUNCTION_3,
    JUNCTION_5,
    LoopMolecule,
    Residue,
    loop_molecule,
)
from loopelastica.atoms.geometry import IdealGeometry, ideal_geometry
from loopelastica.atoms.turn import Surroundings
from loopelastica.errors import StructureError
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.nucleotides import BACKBONE, RING, Structure, atom_positions

GRID_A: Final = 6
"""Decimals that are kept: below them, turns of the input would make the arithmetic differ."""
WATER: Final = ("HOH", "DOD", "WAT", "SOL", "H2O", "TIP", "TIP3", "TIP4")
_NEIGHBOURHOOD_A: Final = 14.0


@dataclass(frozen=True, slots=True, eq=False)
class Site:
    """What all candidates of a loop share, in the frame of the line's start."""

    molecule: LoopMolecule
    geometry: IdealGeometry
    fixed: dict[int, Array]  # rows of the molecule that belong to the stem
    file_rows: dict[int, Array]  # the same in the file's coordinates
    around: Array  # heavy atoms near the loop that are no part of the molecule
    around_polar: NDArray[np.bool_]
    stem: Surroundings
    origin: Array
    frame: Array
    native: Array  # six backbone atoms of the file's own loop, its coordinates; NaN where missing


def loop_residues(structure: Structure, fold: LoopFold) -> list[Residue]:
    """The nucleotides to be built.

    Parameters
    ----------
    structure : Structure
        What was folded.
    fold : LoopFold
        One of its loops.

    Returns
    -------
    list of Residue

    Raises
    ------
    StructureError
        If one has no known base.
    """
    table = structure.nucleotides
    if (fold.hairpin.loop < 0).any():
        raise StructureError(
            f"{fold.hairpin.name}: nucleotides that are not in the file have no known base; the"
            " loop gets no atoms"
        )
    residues = []
    for row in fold.hairpin.loop:
        letter = str(table.letter[row])
        if letter not in "ACGUT":
            raise StructureError(
                f"{table.label(int(row))}: its base is unknown; the loop gets no atoms"
            )
        residues.append(Residue(letter, bool(table.is_dna[row]), str(table.resname[row])))
    return residues


def site_of(structure: Structure, fold: LoopFold, positions: Array) -> Site:
    """The site of a folded loop.

    Parameters
    ----------
    structure : Structure
        What was folded.
    fold : LoopFold
        One of its loops.
    positions : (n_atoms, 3) array
        Of all atoms, Å.

    Returns
    -------
    Site

    Raises
    ------
    StructureError
        If a base is unknown, or an atom that a junction needs is missing.
    """
    assert fold.ends is not None
    table, hairpin = structure.nucleotides, fold.hairpin
    molecule = loop_molecule(loop_residues(structure, fold))
    origin, frame = fold.ends.start_origin_A, fold.ends.start_frame
    n = len(hairpin.loop)
    in_file: dict[int, Array] = {}
    used: list[int] = []
    for residue, row, names in (
        (-1, int(hairpin.stem_5[0]), JUNCTION_5),
        (n, int(hairpin.stem_3[0]), JUNCTION_3),
    ):
        for name in names:
            atom = int(table.columns([name])[row, 0])
            if atom < 0 or not np.isfinite(positions[atom]).all():
                raise StructureError(
                    f"{table.label(row)}: no {name} atom; the loop cannot be joined to the stem"
                    " and gets no atoms"
                )
            used.append(atom)
            in_file[molecule.index(residue, name)] = positions[atom]
    local = np.round((positions - origin) @ frame, GRID_A)
    fixed = {row: np.round((at - origin) @ frame, GRID_A) for row, at in in_file.items()}
    around, polar = _around(structure, fold, local, used)
    rings = atom_positions(table, local, RING)[[hairpin.stem_5[0], hairpin.stem_3[0]]]
    stem = Surroundings(
        around,
        rings[np.isfinite(rings).all(axis=(1, 2))],
        fixed[molecule.index(-1, "O3'")],
        fixed[molecule.index(n, "P")],
    )
    return Site(
        molecule,
        ideal_geometry(molecule),
        fixed,
        in_file,
        around,
        polar,
        stem,
        origin,
        frame,
        atom_positions(table, positions, BACKBONE)[hairpin.loop],
    )


def _around(
    structure: Structure, fold: LoopFold, local: Array, used: list[int]
) -> tuple[Array, NDArray[np.bool_]]:
    """Heavy atoms near any candidate, the loop's own and the junctions' left out."""
    from scipy.spatial import cKDTree

    element = elements(structure)
    loop = structure.nucleotides.atom_index[fold.hairpin.loop, :]
    residues = np.unique(structure.universe.atoms.resindices[loop[loop >= 0]])
    outside = ~np.isin(structure.universe.atoms.resindices, residues)
    outside &= (element != "H") & (element != "D") & np.isfinite(local).all(axis=1)
    outside &= ~waters(structure) & _one_altloc(structure)
    outside[used] = False
    points = np.concatenate(
        [c.length_A * c.rod.centerline(4 * len(fold.hairpin.loop)) for c in fold.candidates]
    )
    rows = np.flatnonzero(outside)
    near = cKDTree(points).query(local[rows], distance_upper_bound=_NEIGHBOURHOOD_A)[0]
    rows = rows[np.isfinite(near)]
    return local[rows], np.isin(element[rows], ["N", "O"])


def waters(structure: Structure) -> NDArray[np.bool_]:
    """Which atoms are water: it gives way to the loop, and was placed with the file's own one."""
    names = np.asarray(structure.universe.atoms.resnames, dtype=object).astype(str)
    return np.isin(np.char.strip(names), WATER)


def _one_altloc(structure: Structure) -> NDArray[np.bool_]:
    """Leave one of the alternative locations: the one the nucleotides were read from, else A."""
    atoms = structure.universe.atoms
    altloc = np.asarray(getattr(atoms, "altLocs", np.zeros(len(atoms), "U1")), dtype=object)
    altloc = np.char.strip(altloc.astype(str))
    chosen = np.full(len(structure.universe.residues), "A", dtype=altloc.dtype)
    table = structure.nucleotides.atom_index
    read = table[table >= 0]
    read = read[altloc[read] != ""]
    chosen[atoms.resindices[read]] = altloc[read]
    return np.asarray((altloc == "") | (altloc == chosen[atoms.resindices]))


def elements(structure: Structure) -> NDArray[np.str_]:
    """Element of every atom, from its name (the file may have none)."""
    names = np.asarray(structure.universe.atoms.names, dtype=object).astype(str)
    return np.array([name.strip().lstrip("0123456789")[:1].upper() for name in names])
