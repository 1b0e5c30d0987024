"""Ideal geometry of a loop: which atoms, what lengths, angles, volumes and least distances."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.atoms.chemistry import LoopMolecule
from loopelastica.atoms.ideal import ideal_value
from loopelastica.atoms.suites import TORSIONS

Index = NDArray[np.int64]
Moving = NDArray[np.bool_]

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

RING_OF_SUGAR: Final = ("C1'", "C2'", "C3'", "C4'", "O4'")
_AMPLITUDE_DEG: Final = 38.0
PUCKERS_DEG: Final = (18.0, 162.0)
"""C3'-endo and C2'-endo, the two puckers that sugars have."""
PUCKER_SD_A3: Final = 0.3
LIKED_TORSIONS: Final[tuple[Any, ...]] = (
    # four atoms, 0 of the nucleotide and −1 of the one before; places on the circle, one of them
    # (°), and how near (rad): an eclipsed α, γ or ζ costs (2/3 · 1/0.27)² = 6, a bond that is
    # 0.03 Å too long the same; ε, β and the side of γ are those where nucleotides are found
    (((-1, "O3'"), (0, "P"), (0, "O5'"), (0, "C5'")), 3, 60.0, 0.27),
    (((0, "O5'"), (0, "C5'"), (0, "C4'"), (0, "C3'")), 3, 60.0, 0.27),
    (((-1, "C3'"), (-1, "O3'"), (0, "P"), (0, "O5'")), 3, 60.0, 0.27),
    (((-1, "C4'"), (-1, "C3'"), (-1, "O3'"), (0, "P")), 1, 215.0, 0.4),
    (((0, "P"), (0, "O5'"), (0, "C5'"), (0, "C4'")), 1, 180.0, 0.6),
    (((0, "O5'"), (0, "C5'"), (0, "C4'"), (0, "C3'")), 1, 115.0, 0.7),
)
SUITE_SD: Final = 0.35
"""Of a torsion of a suite from its cluster, rad: half as wide as clusters are."""

NEAREST_1_4_A: Final = 2.5
"""Least distance of atoms three bonds apart."""
NEAREST_A: Final = np.array([[3.4, 3.1, 3.5], [3.1, 2.7, 3.15], [3.5, 3.15, 3.6]])
FLOOR_A: Final = np.array([[2.4, 2.4, 3.2], [2.4, 2.4, 2.9], [3.2, 2.9, 3.4]])
"""Distances that atoms four or more bonds apart like to keep, and that they must, by their sorts:
others, nitrogen and oxygen, carbons of sugars and methyls. Van der Waals radii less what hydrogen
bonds and close contacts in crystals take away; the last need room for their hydrogens, which are
not there. Of 649 steps of RNA in 40 entries 1 % have C3' of one nucleotide and C5' of the next
nearer than 3.39 Å."""
METHYL: Final = "C7"
FAR: Final = 3
"""Atoms this many bonds apart or more are in each other's way."""


@dataclass(frozen=True, slots=True, eq=False)
class IdealGeometry:
    """What the chemistry asks of every term with a moving atom in it; rows of a `LoopMolecule`.

    Attributes
    ----------
    bonds, length_A : (b, 2), (b,) array
    angles, angle_deg : (a, 3), (a,) array
    chiral, volume_A3 : (q, 4), (q,) array
        Centre and three neighbours, and their signed volume.
    planar : (p, 4) array
        Atoms in a plane.
    torsions, torsion_fold, torsion_deg, torsion_sd : (t, 4), (t,), (t,), (t,) array
        Torsions of the backbone, on how many places of the circle they like to be, one of these,
        and how near, rad.
    rings : (s, 5) array
        C1' C2' C3' C4' O4' of each sugar.
    suites : (u, 7, 4) array
        Torsions of each suite of RNA (:mod:`.suites`).
    """

    bonds: Index
    length_A: Array
    angles: Index
    angle_deg: Array
    chiral: Index
    volume_A3: Array
    planar: Index
    torsions: Index
    torsion_fold: Array
    torsion_deg: Array
    torsion_sd: Array
    rings: Index
    suites: Index


def ideal_geometry(molecule: LoopMolecule, moving: Moving | None = None) -> IdealGeometry:
    """Ideal values of every bond, angle, … that has a moving atom in it.

    A phosphorus whose two free oxygens are there already is no centre: they keep their names.

    Parameters
    ----------
    molecule : LoopMolecule
    moving : (N,) array of bool, optional
        Atoms that are built; default those of the strand itself.

    Returns
    -------
    IdealGeometry
    """
    if moving is None:
        moving = np.zeros(len(molecule.names), dtype=np.bool_)
        moving[molecule.loop_atoms] = True
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
    torsions, liked = _torsions(molecule, moving)
    return IdealGeometry(
        np.array(bonds, dtype=np.int64).reshape(-1, 2),
        np.array(lengths),
        np.array(angles, dtype=np.int64).reshape(-1, 3),
        np.array(degrees),
        *_centres(molecule, moving),
        _with_one(planar_quads(molecule), moving),
        torsions,
        liked[:, 0],
        liked[:, 1],
        liked[:, 2],
        _with_one(np.array(list(sugars(molecule).values()), dtype=np.int64).reshape(-1, 5), moving),
        _suites(molecule, moving),
    )


def _centres(molecule: LoopMolecule, moving: Moving) -> tuple[Index, Array]:
    quads, volumes = chiral_quads(molecule)
    phosphorus = np.array([molecule.names[row] == "P" for row in quads[:, 0]], dtype=np.bool_)
    own = moving[quads].any(axis=1) & ~(phosphorus & ~moving[quads[:, [0, 2, 3]]].any(axis=1))
    return quads[own], volumes[own]


def _with_one(rows: Index, moving: Moving) -> Index:
    """Those rows of which an atom moves."""
    return rows[moving[rows].any(axis=1)]


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
    return np.array(pairs, dtype=np.int64).reshape(-1, 2), np.array(values), np.array(deviations)


def chiral_quads(molecule: LoopMolecule) -> tuple[Index, Array]:
    """Centre and three neighbours (q, 4) and their signed volume (q,), Å³."""
    rows = molecule.rows
    quads, volumes = [], []
    for residue in molecule.kinds:
        for centre, neighbours, volume in CHIRALITY:
            quad = [rows.get((residue, centre))]
            for name in neighbours:
                owner = residue - 1 if (centre, name) == ("P", "O3'") else residue
                quad.append(_named(molecule, owner, name))
            if None not in quad:
                quads.append(quad)
                volumes.append(volume)
    return np.array(quads, dtype=np.int64).reshape(-1, 4), np.array(volumes)


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


def sugars(molecule: LoopMolecule) -> dict[int, list[int]]:
    """Rows of C1' C2' C3' C4' O4' of every nucleotide that has them all."""
    found = {
        residue: [molecule.rows.get((residue, name), -1) for name in RING_OF_SUGAR]
        for residue in molecule.kinds
    }
    return {residue: ring for residue, ring in found.items() if -1 not in ring}


def ring_quads(rings: Index, phases_deg: Array) -> tuple[Index, Array]:
    """Four neighbours along each sugar ring (5 s, 4) and their volume (5 s,) at a pucker, Å³.

    Torsions of the ring are 38° cos(P + 144° j), 38° being the amplitude that is usual in
    nucleotides: Altona & Sundaralingam, J. Am. Chem. Soc. 94 (1972) 8205, doi:10.1021/ja00778a043.

    Parameters
    ----------
    rings : (s, 5) array of int
        Rows of each sugar, as :func:`sugars` has them.
    phases_deg : (s,) array
        Phase of pseudorotation of each sugar.

    Returns
    -------
    quads : (5 s, 4) array of int
    volume : (5 s,) array
        Å³.
    """
    turns = (np.arange(5)[:, None] + np.arange(4)) % 5
    torsion = np.cos(np.deg2rad(np.asarray(phases_deg)[:, None] + 144.0 * np.arange(5)))
    volume = _ring_sizes() * np.sin(np.deg2rad(_AMPLITUDE_DEG * torsion))
    return rings[:, turns].reshape(-1, 4), volume.ravel()


@lru_cache
def _ring_sizes() -> Array:
    """Volume of four neighbours of the ring per sine of their torsion (5,), Å³."""
    sizes = []
    for j in range(5):
        a, b, c, d = (RING_OF_SUGAR[(j + step) % 5] for step in range(4))
        size = everywhere(a, b) * everywhere(b, c) * everywhere(c, d)
        size *= np.sin(np.deg2rad(everywhere(a, b, c))) * np.sin(np.deg2rad(everywhere(b, c, d)))
        sizes.append(size)
    return np.array(sizes)


def everywhere(*names: str) -> float:
    """An ideal length or angle of sugar and phosphate, which every nucleotide has."""
    value = ideal_value("A", False, *names)
    assert value is not None
    return value


def _torsions(molecule: LoopMolecule, moving: Moving) -> tuple[Index, Array]:
    """Rows (t, 4) of torsions, and their number of places, one of these and how near (t, 3)."""
    quads, liked = [], []
    for k in molecule.kinds:
        for names, *how in LIKED_TORSIONS:
            quad = [molecule.rows.get((k + step, name), -1) for step, name in names]
            if -1 not in quad and moving[quad].any():
                quads.append(quad)
                liked.append(how)
    return np.array(quads, dtype=np.int64).reshape(-1, 4), np.array(liked).reshape(-1, 3)


def _suites(molecule: LoopMolecule, moving: Moving) -> Index:
    found = []
    for k, kind in molecule.kinds.items():
        before = molecule.kinds.get(k - 1)
        if before is None or before.is_dna or kind.is_dna:
            continue
        quads = [
            [molecule.rows.get((k - 1 + step, name), -1) for step, name in quad]
            for quad in TORSIONS
        ]
        if all(-1 not in quad for quad in quads) and moving[quads].any():
            found.append(quads)
    return np.array(found, dtype=np.int64).reshape(-1, 7, 4)


def separations(molecule: LoopMolecule) -> Array:
    """Bonds between each two atoms (N, N) up to `FAR`, else infinity."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    bonds = np.array(molecule.bonds, dtype=np.int64).reshape(-1, 2).T
    shape = (len(molecule.names), len(molecule.names))
    graph = coo_array((np.ones(bonds.shape[1]), tuple(bonds)), shape=shape).tocsr()
    return np.asarray(dijkstra(graph, directed=False, unweighted=True, limit=FAR))


def room_A(own: Index, sort: Index, apart: Array) -> tuple[Array, Array]:
    """Distances that atoms of a molecule like to keep, and that they must; 0 next to a bond.

    Parameters
    ----------
    own, sort : (n, 1), (N,) array of int
        What :func:`sorts` says of them.
    apart : (n, N) array
        Bonds between each two.

    Returns
    -------
    least, floor : (n, N) array
        Å.
    """
    like, floor = NEAREST_A[own, sort], FLOOR_A[own, sort]
    like = np.where(apart == 3, np.minimum(like, NEAREST_1_4_A), like)
    like = np.where(apart <= 2, 0.0, like)
    return like, np.minimum(like, np.where(apart == 3, FLOOR_A[0, 0], floor))


def sorts(symbols: Sequence[str], names: Sequence[str]) -> Index:
    """Rows of `NEAREST_A` and `FLOOR_A`.

    Parameters
    ----------
    symbols, names : sequence of str
        Elements and names of the wwPDB, of each atom.

    Returns
    -------
    (n,) array of int
    """
    return np.array(
        [
            1 if symbol in ("N", "O") else
            2 if symbol == "C" and (name.endswith("'") or name == METHYL) else 0
            for symbol, name in zip(symbols, names, strict=True)
        ],
        dtype=np.int64,
    )  # fmt: skip


def _named(molecule: LoopMolecule, residue: int, name: str) -> int | None:
    if name == "base":
        name = "N9" if molecule.kinds[residue].letter in "AG" else "N1"
    return molecule.rows.get((residue, name))


def _angles(molecule: LoopMolecule) -> Iterator[tuple[int, int, int]]:
    for atom in molecule.mol.GetAtoms():
        around = [other.GetIdx() for other in atom.GetNeighbors()]
        for place, i in enumerate(around):
            for k in around[place + 1 :]:
                yield i, atom.GetIdx(), k


def _tabulated(molecule: LoopMolecule, *rows: int) -> float | None:
    # the middle atom says which nucleotide it is
    kind = molecule.kinds[molecule.residue[rows[1]]]
    return ideal_value(kind.letter, kind.is_dna, *(molecule.names[row] for row in rows))


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
