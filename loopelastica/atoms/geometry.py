"""Ideal geometry of a loop: which atoms, what lengths, angles, volumes and least distances."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.atoms.chemistry import LoopMolecule, Residue
from loopelastica.atoms.ideal import ideal_value

Index = NDArray[np.int64]

BOND_SD_A: Final = 0.012
ANGLE_SD_DEG: Final = 2.0
"""The sources have 0.004–0.017 Å and 0.4–3.2°; one for all keeps it simple."""
VOLUME_SD_A3: Final = 0.15
PLANAR_SD_A3: Final = 0.10

CHIRALITY: Final = (
    # centre, three neighbours whose signed volume is positive, and its size from the fibre, Å³;
    # of the phosphorus it decides which oxygen is OP1
    ("C1'", ("O4'", "C2'", "base"), 2.45),
    ("C3'", ("C4'", "C2'", "O3'"), 2.6),
    ("C4'", ("C5'", "C3'", "O4'"), 2.55),
    ("C2'", ("C1'", "O2'", "C3'"), 2.6),
    ("P", ("O3'", "OP1", "OP2"), 2.45),
)

_RING: Final = ("C1'", "C2'", "C3'", "C4'", "O4'")
_AMPLITUDE_DEG: Final = 38.0
PUCKERS_DEG: Final = (18.0, 162.0)
"""C3'-endo and C2'-endo, the two puckers that sugars have."""
PUCKER_SD_A3: Final = 0.3
TORSION_SD: Final = 0.4
"""An eclipsed torsion costs (1/0.4)² = 6, a bond that is 0.03 Å too long the same."""

NEAREST_A: Final = 3.1
NEAREST_POLAR_A: Final = 2.7
NEAREST_1_4_A: Final = 2.5
"""Least distances of atoms four or more bonds apart, of nitrogen and oxygen among them, and of
atoms three bonds apart. Van der Waals radii less what hydrogen bonds and close contacts in crystals
take away."""


@dataclass(frozen=True, slots=True, eq=False)
class IdealGeometry:
    """Bonds (b, 2), lengths; angles (a, 3), degrees; both over the rows of a `LoopMolecule`."""

    bonds: Index
    length_A: Array
    angles: Index
    angle_deg: Array


def ideal_geometry(molecule: LoopMolecule) -> IdealGeometry:
    """Ideal lengths and angles of every bond and angle that has a loop atom in it."""
    n = len(molecule.residues)
    moving = [0 <= r < n for r in molecule.residue]
    fallback = _Mmff(molecule.mol)
    bonds, lengths, angles, degrees = [], [], [], []
    for i, j in molecule.bonds:
        if moving[i] or moving[j]:
            bonds.append((i, j))
            value = _tabulated(molecule, i, j)
            lengths.append(fallback.length(i, j) if value is None else value)
    for i, j, k in _angles(molecule):
        if moving[i] or moving[j] or moving[k]:
            angles.append((i, j, k))
            value = _tabulated(molecule, i, j, k)
            degrees.append(fallback.angle(i, j, k) if value is None else value)
    return IdealGeometry(np.array(bonds), np.array(lengths), np.array(angles), np.array(degrees))


def outer_distances(geometry: IdealGeometry) -> tuple[Index, Array, Array]:
    """Angles as distances of their outer atoms: pairs (a, 2), lengths and deviations (a,), Å."""
    length = {
        frozenset(pair): value
        for pair, value in zip(geometry.bonds.tolist(), geometry.length_A.tolist(), strict=True)
    }
    pairs, values, deviations = [], [], []
    for (i, j, k), degrees in zip(
        geometry.angles.tolist(), geometry.angle_deg.tolist(), strict=True
    ):
        # a bond of two stem atoms is not restrained, its length is near enough to this
        a, b = (length.get(frozenset(pair), 1.5) for pair in ((i, j), (j, k)))
        angle = np.deg2rad(degrees)
        outer = np.sqrt(a * a + b * b - 2.0 * a * b * np.cos(angle))
        pairs.append((i, k))
        values.append(outer)
        deviations.append(a * b * np.sin(angle) / outer * np.deg2rad(ANGLE_SD_DEG))
    return np.array(pairs), np.array(values), np.array(deviations)


def chiral_quads(molecule: LoopMolecule) -> tuple[Index, Array]:
    """Centre and three neighbours (q, 4) and their signed volume (q,), Å³.

    The phosphorus of the 3' closing nucleotide is not among them: its oxygens are the stem's.
    """
    rows = _rows(molecule)
    quads, volumes = [], []
    for residue in range(len(molecule.residues)):
        for centre, neighbours, volume in CHIRALITY:
            quad = [rows.get((residue, centre))]
            for name in neighbours:
                owner = residue - 1 if (centre, name) == ("P", "O3'") else residue
                quad.append(_named(molecule, rows, owner, name))
            if None not in quad:
                quads.append(quad)
                volumes.append(volume)
    return np.array(quads, dtype=np.int64), np.array(volumes)


def planar_quads(molecule: LoopMolecule) -> Index:
    """Quadruples (q, 4) in a plane: trigonal atoms, and neighbours along aromatic bonds."""
    from rdkit import Chem

    mol = molecule.mol
    quads = []
    for atom in mol.GetAtoms():
        around = [other.GetIdx() for other in atom.GetNeighbors()]
        flat = atom.GetHybridization() == Chem.HybridizationType.SP2
        if flat and len(around) == 3:
            quads.append((atom.GetIdx(), *around))
    for bond in mol.GetBonds():
        if not bond.GetIsAromatic():
            continue
        a, b = bond.GetBeginAtom(), bond.GetEndAtom()
        quads += [
            (i.GetIdx(), a.GetIdx(), b.GetIdx(), j.GetIdx())
            for i in a.GetNeighbors()
            for j in b.GetNeighbors()
            if i.GetIdx() != b.GetIdx() and j.GetIdx() not in (a.GetIdx(), i.GetIdx())
        ]
    return np.array(quads, dtype=np.int64).reshape(-1, 4)


def ring_quads(
    molecule: LoopMolecule, geometry: IdealGeometry, phases_deg: Array
) -> tuple[Index, Array]:
    """Four neighbours along each sugar ring (5 n, 4) and their volume (5 n,) at a pucker, Å³.

    Torsions of the ring are 38° cos(P + 144° j), 38° being the amplitude that is usual in
    nucleotides: Altona & Sundaralingam, J. Am. Chem. Soc. 94 (1972) 8205, doi:10.1021/ja00778a043.

    Parameters
    ----------
    molecule : LoopMolecule
    geometry : IdealGeometry
        Its lengths and angles.
    phases_deg : (n,) array
        Phase of pseudorotation of each sugar.

    Returns
    -------
    quads : (5 n, 4) array of int
    volume : (5 n,) array
        Å³.
    """
    rows = _rows(molecule)
    length = {
        frozenset(b): v for b, v in zip(geometry.bonds.tolist(), geometry.length_A, strict=True)
    }
    angle = {
        (frozenset((i, k)), j): v
        for (i, j, k), v in zip(geometry.angles.tolist(), geometry.angle_deg, strict=True)
    }
    quads, volumes = [], []
    for residue, phase in enumerate(phases_deg):
        ring = [rows[residue, name] for name in _RING]
        for j in range(5):
            a, b, c, d = (ring[(j + step) % 5] for step in range(4))
            torsion = np.deg2rad(_AMPLITUDE_DEG * np.cos(np.deg2rad(phase + 144.0 * j)))
            size = length[frozenset((a, b))] * length[frozenset((b, c))] * length[frozenset((c, d))]
            size *= np.sin(np.deg2rad(angle[frozenset((a, c)), b]))
            size *= np.sin(np.deg2rad(angle[frozenset((b, d)), c]))
            quads.append((a, b, c, d))
            volumes.append(size * np.sin(torsion))
    return np.array(quads, dtype=np.int64), np.array(volumes)


def backbone_torsions(molecule: LoopMolecule) -> Index:
    """α, γ and ζ (t, 4) of the loop's backbone: torsions with three staggered places."""
    rows = _rows(molecule)
    quads = []
    for k in range(len(molecule.residues) + 1):
        for names in (
            ((-1, "O3'"), (0, "P"), (0, "O5'"), (0, "C5'")),
            ((0, "O5'"), (0, "C5'"), (0, "C4'"), (0, "C3'")),
            ((-1, "C3'"), (-1, "O3'"), (0, "P"), (0, "O5'")),
        ):
            quad = [rows.get((k + step, name)) for step, name in names]
            if None not in quad:
                quads.append(quad)
    return np.array(quads, dtype=np.int64)


def separations(molecule: LoopMolecule) -> Array:
    """Bonds between each two atoms (N, N)."""
    from rdkit import Chem

    return np.asarray(Chem.GetDistanceMatrix(molecule.mol))


def nearest_A(polar: NDArray[np.bool_], other_polar: NDArray[np.bool_]) -> Array:
    """Least distance of unbonded atoms.

    Parameters
    ----------
    polar, other_polar : (n,), (m,) array of bool
        True for nitrogen and oxygen.

    Returns
    -------
    (n, m) array
        Å.
    """
    return np.where(polar[:, None] & other_polar[None], NEAREST_POLAR_A, NEAREST_A)


def _rows(molecule: LoopMolecule) -> dict[tuple[int, str], int]:
    return {key: row for row, key in enumerate(zip(molecule.residue, molecule.names, strict=True))}


def _named(
    molecule: LoopMolecule, rows: dict[tuple[int, str], int], residue: int, name: str
) -> int | None:
    if name == "base":
        name = "N9" if molecule.residues[residue].letter in "AG" else "N1"
    return rows.get((residue, name))


def _angles(molecule: LoopMolecule) -> Iterator[tuple[int, int, int]]:
    for atom in molecule.mol.GetAtoms():
        around = [other.GetIdx() for other in atom.GetNeighbors()]
        for place, i in enumerate(around):
            for k in around[place + 1 :]:
                yield i, atom.GetIdx(), k


def _tabulated(molecule: LoopMolecule, *rows: int) -> float | None:
    n = len(molecule.residues)
    # the middle atom says which nucleotide it is; at the junctions the loop's own neighbour does
    owner = molecule.residue[rows[1]]
    residue: Residue = molecule.residues[min(max(owner, 0), n - 1)]
    return ideal_value(residue.letter, residue.is_dna, *(molecule.names[row] for row in rows))


class _Mmff:
    """Equilibrium values of MMFF94, typed when the first one is needed."""

    def __init__(self, mol: Any) -> None:
        self._mol = mol
        self._typed: Any = None

    def length(self, i: int, j: int) -> float:
        found = self._properties().GetMMFFBondStretchParams(self._with_h, i, j)
        return float(found[2]) if found else 1.5

    def angle(self, i: int, j: int, k: int) -> float:
        found = self._properties().GetMMFFAngleBendParams(self._with_h, i, j, k)
        return float(found[2]) if found else 109.5

    def _properties(self) -> Any:
        from rdkit import Chem
        from rdkit.Chem import rdForceFieldHelpers
        from rdkit.ForceField import rdForceField  # noqa: F401 (makes its classes known)

        if self._typed is None:
            self._with_h = Chem.AddHs(self._mol)
            self._typed = rdForceFieldHelpers.MMFFGetMoleculeProperties(self._with_h)
        return self._typed
