"""Where a loop is built: its molecule, the stem's fixed atoms, what is around; in one frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record
from loopelastica.atoms.chemistry import (
    BEYOND_3,
    BEYOND_5,
    JUNCTION_3,
    JUNCTION_5,
    LoopMolecule,
    Residue,
    loop_molecule,
)
from loopelastica.atoms.geometry import IdealGeometry, ideal_geometry, sorts
from loopelastica.atoms.habits import Habits, of_motif, usual
from loopelastica.atoms.turn import CONTACTS, Surroundings, check_contact
from loopelastica.errors import StructureError
from loopelastica.folding.lines import CandidateLine
from loopelastica.folding.motifs import motif_of
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.neighbours import METALS, elements, solid
from loopelastica.molecule.nucleotides import BACKBONE, RING, Structure, atom_positions

Index = NDArray[np.int64]
NOBODY: Final = -99
GRID_A: Final = 6
"""Decimals that are kept: below them, turns of the input would make the arithmetic differ."""
NEIGHBOURHOOD_A: Final = 16.0


@dataclass(frozen=True, slots=True, eq=False)
class Around(Record):
    """Heavy atoms near a strand that are no part of its molecule.

    Attributes
    ----------
    positions_A : (m, 3) array
        In the local frame, Å.
    sort : (m,) array of int
        Row of :data:`.geometry.NEAREST_A`.
    metal : (m,) array of bool
        Of metal ions.
    owner : (m,) array of int
        Nucleotide of the molecule that an atom belongs to, such as an unknown group of a modified
        one: atoms of that nucleotide do not avoid it. `NOBODY` for all others.
    label : (m,) array of str
    """

    positions_A: Array
    sort: Index
    metal: NDArray[np.bool_]
    owner: NDArray[np.int64]
    label: NDArray[np.str_]


@dataclass(frozen=True, slots=True, eq=False)
class Site:
    """What all attempts at a strand share, in a local frame.

    Attributes
    ----------
    molecule : LoopMolecule
    geometry : IdealGeometry
    moving : (N,) array of bool
        Atoms that are built.
    fixed_A : (N, 3) array
        Where the others are; NaN for what moves.
    around : Around
    stem : Surroundings
        The same for Ω and χ.
    origin, frame : (3,), (3, 3) array
        The local frame in the coordinates of the file.
    file_A : (N, 3) array
        The fixed atoms in the file's coordinates, to the digit.
    labels : mapping of int to str
        What sentences call each nucleotide.
    habits : Habits
        What is usual of its sugars and bases.
    contact : str or None
        Contact of the first and the last nucleotide that is sought.
    contact_pairs : (h, 2) array of int
        Donors and acceptors of its hydrogen bonds; none where the two bases make no such contact.
    """

    molecule: LoopMolecule
    geometry: IdealGeometry
    moving: NDArray[np.bool_]
    fixed_A: Array
    around: Around
    stem: Surroundings
    origin: Array
    frame: Array
    file_A: Array
    labels: Mapping[int, str]
    habits: Habits
    contact: str | None = None
    contact_pairs: Index = field(default_factory=lambda: np.empty((0, 2), dtype=np.int64))

    def seeking(self, contact: str | None) -> Site:
        """The same, with a contact to be sought, "sheared" or "watson-crick"."""
        check_contact(contact)
        if contact is None:
            return self
        last = self.molecule.n - 1
        letters = "".join(self.molecule.kinds[k].letter for k in (0, last))
        bonds = CONTACTS[contact].get(letters, ())
        rows = [(self.molecule.index(0, a), self.molecule.index(last, b)) for a, b in bonds]
        pairs = np.array(rows, dtype=np.int64).reshape(-1, 2)
        return replace(self, contact=contact, contact_pairs=pairs)

    def label(self, row: int) -> str:
        """An atom of the molecule or, from N on, of what is around, such as "2:C3'"."""
        n = len(self.molecule.names)
        if row >= n:
            return str(self.around.label[row - n])
        return f"{self.labels[self.molecule.residue[row]]}:{self.molecule.names[row]}"

    def given(self, near: Mapping[str, Mapping[str, Array]]) -> Array:
        """Atoms by label and name, in the coordinates of the file, as local positions (N, 3).

        NaN where none is given.
        """
        nowhere = np.full(3, np.nan)
        found = [
            near.get(self.labels[k], {}).get(name, nowhere)
            for name, k in zip(self.molecule.names, self.molecule.residue, strict=True)
        ]
        return np.asarray((np.array(found) - self.origin) @ self.frame)

    def in_file(self, positions: Array) -> Array:
        """Local positions (N, 3) in the coordinates of the file; fixed atoms as they are there."""
        return np.where(self.moving[:, None], positions @ self.frame.T + self.origin, self.file_A)


def placed(
    molecule: LoopMolecule,
    file_A: Array,
    around: Around,
    ring_A: Array,
    origin: Array,
    frame: Array,
    labels: Mapping[int, str],
    habits: Habits | None = None,
) -> Site:
    """A site from atoms in the coordinates of the file.

    Parameters
    ----------
    molecule : LoopMolecule
    file_A : (N, 3) array
        Atoms that are there, NaN for those to be built, Å.
    around : Around
        In the local frame.
    ring_A : (b, 6, 3) array
        Six-membered rings of the nucleotides before and after, local; NaN where one is missing.
    origin, frame : (3,), (3, 3) array
    labels : mapping of int to str
    habits : Habits, optional
        Default those usual of its sequence.

    Returns
    -------
    Site
    """
    moving = np.asarray(~np.isfinite(file_A).all(axis=1), dtype=np.bool_)
    fixed = np.round((file_A - origin) @ frame, GRID_A)
    near = [around.positions_A]
    # the flanks are in the way too, but for what the junctions bond
    for k in (-1, molecule.n):
        bonded = JUNCTION_5 if k < 0 else JUNCTION_3
        near += [fixed[[row]] for (number, name), row in molecule.rows.items()
                 if number == k and name not in bonded and not moving[row]]  # fmt: skip
    stem = Surroundings(
        np.concatenate(near),
        ring_A[np.isfinite(ring_A).all(axis=(1, 2))],
        _bonded(molecule, fixed, -1, "O3'"),
        _bonded(molecule, fixed, molecule.n, "P"),
    )
    if habits is None:
        kinds = molecule.residues
        habits = usual([kind.letter for kind in kinds], [kind.is_dna for kind in kinds])
    return Site(molecule, ideal_geometry(molecule, moving), moving, fixed, around, stem, origin,
                frame, file_A, labels, habits)  # fmt: skip


def _bonded(molecule: LoopMolecule, fixed: Array, residue: int, name: str) -> Array:
    row = molecule.rows.get((residue, name))
    return np.full(3, np.nan) if row is None else fixed[row]


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


def site_of(structure: Structure, fold: LoopFold, positions: Array, line: CandidateLine) -> Site:
    """The site of a folded loop.

    Parameters
    ----------
    structure : Structure
        What was folded.
    fold : LoopFold
        One of its loops.
    positions : (n_atoms, 3) array
        Of all atoms, Å.
    line : RodLine or ChainLine
        One of its candidates', in whose first frame everything is.

    Returns
    -------
    Site

    Raises
    ------
    StructureError
        If a base is unknown, or an atom that a junction needs is missing.
    """
    table, hairpin = structure.nucleotides, fold.hairpin
    closing_5, closing_3 = int(hairpin.stem_5[0]), int(hairpin.stem_3[0])
    molecule = loop_molecule(
        loop_residues(structure, fold),
        _there(structure, positions, closing_5, BEYOND_5),
        _there(structure, positions, closing_3, BEYOND_3),
    )
    origin, frame = line.start_origin_A, line.start_frame
    n = molecule.n
    file_A = np.full((len(molecule.names), 3), np.nan)
    used: list[int] = []
    closing = {-1: closing_5, n: closing_3}
    for (residue, name), row in molecule.rows.items():
        if residue not in closing:
            continue
        atom = int(table.columns([name])[closing[residue], 0])
        if atom < 0 or not np.isfinite(positions[atom]).all():
            raise StructureError(
                f"{table.label(closing[residue])}: no {name} atom; the loop cannot be joined to the"
                " stem and gets no atoms"
            )
        used.append(atom)
        file_A[row] = positions[atom]
    local = np.round((positions - origin) @ frame, GRID_A)
    rings = atom_positions(table, local, RING)[[closing[-1], closing[n]]]
    labels = {k: str(k + 1) for k in molecule.kinds}
    lines = [c.line.points(4 * n) for c in fold.candidates]
    near_A = (np.concatenate(lines) - origin) @ frame
    around = _around(structure, fold, local, used, near_A)
    return placed(molecule, file_A, around, rings, origin, frame, labels, _habits(fold))


def _there(
    structure: Structure, positions: Array, nucleotide: int, names: tuple[str, ...]
) -> list[str]:
    """Those of the named atoms that a nucleotide has."""
    rows = structure.nucleotides.columns(names)[nucleotide]
    return [name for name, row in zip(names, rows, strict=True)
            if row >= 0 and np.isfinite(positions[row]).all()]  # fmt: skip


def _habits(fold: LoopFold) -> Habits | None:
    """Those of a motif, where its other loops may be known."""
    hairpin, options = fold.hairpin, fold.options
    if hairpin.is_dna or options.exclude_relatives or options.shapes == "rod":
        return None
    motif = motif_of(hairpin.sequence)
    return None if motif is None else of_motif(motif)


def native_backbone(structure: Structure, fold: LoopFold, positions: Array) -> Array:
    """Six backbone atoms (n, 6, 3) of the file's own loop; NaN where one is missing."""
    return atom_positions(structure.nucleotides, positions, BACKBONE)[fold.hairpin.loop]


def _around(
    structure: Structure, fold: LoopFold, local: Array, used: list[int], near_A: Array
) -> Around:
    """Heavy atoms near some points, the loop's own and the junctions' left out."""
    from scipy.spatial import cKDTree

    element = elements(structure)
    loop = structure.nucleotides.atom_index[fold.hairpin.loop, :]
    residues = np.unique(structure.universe.atoms.resindices[loop[loop >= 0]])
    outside = ~np.isin(structure.universe.atoms.resindices, residues)
    outside &= solid(structure) & np.isfinite(local).all(axis=1)
    outside[used] = False
    rows = np.flatnonzero(outside)
    near = cKDTree(near_A).query(local[rows], distance_upper_bound=NEIGHBOURHOOD_A)[0]
    rows = rows[np.isfinite(near)]
    atoms = structure.universe.atoms[rows]
    resnames = np.char.upper(np.char.strip(atoms.resnames.astype(str)))
    metal = np.isin(resnames, sorted(METALS))
    label = [
        f"{resname}{resid}:{name}"
        for resname, resid, name in zip(atoms.resnames, atoms.resids, atoms.names, strict=True)
    ]
    return Around(
        local[rows],
        np.where(metal, 0, sorts(element[rows].tolist(), atoms.names.tolist())),
        metal,
        np.full(len(rows), NOBODY),
        np.array(label, dtype=np.str_),
    )
