"""The stem of a built hairpin: the fibre's double helix with right pairs and ideal chemistry.

    fibre → hydrogen bonds, lengths and angles by least squares over the whole stem → checks

The two strands of the fibre are laid side by side. A least-squares problem of the kind that loops
have (:mod:`.relax`) then brings hydrogen bonds, bonds and angles to their ideal values, every atom
held weakly to its place in the fibre. G·U and G·T, which the fibre pairs as Watson and Crick did,
slide to the wobble.

Hydrogen bonds of Watson–Crick pairs have the lengths that are usually given for the crystals of ApU
and GpC (after Saenger, Principles of Nucleic Acid Structure, 1984; not read for this project). What
was measured for it, medians over pairs in helices of 15 crystals of 1.4 to 2.4 Å (1S72, 1EHZ, 1MSY,
1Y26, 430D, 3K1V, 3NPQ, 3P59, 4OJI, 5C0Y, 5D0A, 5EEU, 5JBG, 5ZW4, 6YL5), lies within 0.08 Å of them:
G·C 2.96, 2.91, 2.78 Å (667 pairs), A·U 3.02, 2.83 Å (250).

The wobble is that of the 43 G·U pairs of the same crystals: medians O6–N3 2.86 Å, N1–O2 2.70 Å and,
which is no hydrogen bond but tells how far the bases have slid, N1–N3 3.60 Å. N1–O2 is taken 0.06 Å
longer, for the shortest hydrogen bonds come out too short there, N2–O2 of G·C by 0.08 Å.

The fibre of A-RNA has C2' of a nucleotide and C8 or C6 of the next one 3.48 Å apart, and so H2' and
H8 or H6 1.6 Å. In the crystals they are 3.87 Å apart (median of 1,165 steps; H2' 2.1 Å), and here.
The fibre of B-DNA has 3.76 Å (38 steps of 1BJH, 1AC7 and 1JVE: 3.71 Å), which wobbles keep too.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record
from loopelastica.atoms.checks import BOND_TOLERANCE_A, CLOSE_A, WORST_ANGLE_DEG, wrong_hands
from loopelastica.atoms.chemistry import LoopMolecule, atom_names, strand_molecule
from loopelastica.atoms.fibre import fibre_nucleotide
from loopelastica.atoms.geometry import (
    BOND_SD_A,
    FAR,
    PLANAR_SD_A3,
    PUCKER_SD_A3,
    PUCKERS_DEG,
    VOLUME_SD_A3,
    IdealGeometry,
    ideal_geometry,
    outer_distances,
    ring_quads,
    room_A,
    separations,
    sorts,
)
from loopelastica.atoms.measures import angles_deg, bond_lengths
from loopelastica.atoms.relax import STAGES, Restraints, Status, relax
from loopelastica.atoms.sequence import HairpinSequence, pair_of
from loopelastica.errors import StructureError
from loopelastica.molecule.components import PHOSPHATE
from loopelastica.molecule.strands import ideal_strand

HYDROGEN_BONDS: Final = {
    "GC": (("O6", "N4", 2.91), ("N1", "N3", 2.95), ("N2", "O2", 2.86)),
    "AU": (("N6", "O4", 2.95), ("N1", "N3", 2.82)),
    "GU": (("O6", "N3", 2.86), ("N1", "O2", 2.76)),
}
"""Atom of the purine, atom of the pyrimidine, length in Å; T pairs as U does."""
_SLID: Final = {"GU": (("N1", "N3", 3.60),)}
"""Without it the least squares end half way, with N1–N3 at 2.85 Å."""
STEP_A: Final = {False: 3.87, True: 3.76}
"""C2' to C8 or C6 of the next nucleotide, of RNA and of DNA."""
_STEP_SD_A: Final = 0.05
HYDROGEN_BOND_SD_A: Final = 0.02
TETHER_SD_A: Final = 0.5
"""How near each atom is held to the fibre; with 2 Å the ends of a stem of DNA come apart by 0.7 Å
from it, with no gain for bonds and angles."""
_MISMATCH_SD_A: Final = 2.0
"""The same in pairs that are none: purines need room."""
_TERMINAL_A: Final = 1.51
_TERMINAL_DEG: Final = 106.0
"""P–O and O5'–P–O of a phosphate at the end of a chain; its O–P–O are then 112.7°."""


@dataclass(frozen=True, slots=True, eq=False)
class Duplex(Record):
    """The atoms of a stem.

    Attributes
    ----------
    molecule : LoopMolecule
        Its nucleotides by their places in the hairpin, from 0.
    positions_A : (N, 3) array
        Rows of the molecule; the helix axis is along z, Å.
    oxygen_A : (3,) array or None
        OP3 of a phosphate at the 5' end.
    """

    molecule: LoopMolecule
    positions_A: Array
    oxygen_A: Array | None

    def atoms(self, number: int) -> dict[str, Array]:
        """Positions of one nucleotide's atoms by their names, Å.

        Parameters
        ----------
        number : int
            Its place in the hairpin, from 0.

        Returns
        -------
        dict of str to (3,) array
        """
        names = atom_names(self.molecule.kinds[number])
        rows = {name: self.molecule.rows.get((number, name)) for name in names}
        found = {name: self.positions_A[row] for name, row in rows.items() if row is not None}
        return found if number or self.oxygen_A is None else {"OP3": self.oxygen_A, **found}


def duplex(hairpin: HairpinSequence, phosphate: bool = False) -> Duplex:
    """The stem of a hairpin.

    Parameters
    ----------
    hairpin : HairpinSequence
        What it is made of.
    phosphate : bool
        Put a phosphate at the 5' end.

    Returns
    -------
    Duplex

    Raises
    ------
    StructureError
        If its chemistry is not sound, as may be where nucleotides do not pair.

    Examples
    --------
    >>> from loopelastica.atoms.sequence import read_sequence
    >>> stem = duplex(read_sequence("GGC(UUCG)GUC"))
    >>> wobble = np.linalg.norm(stem.atoms(1)["O6"] - stem.atoms(8)["N3"])
    >>> print(f"{wobble:.1f} Å")
    2.9 Å
    """
    molecule = _molecule(hairpin, phosphate)
    geometry = ideal_geometry(molecule, np.ones(len(molecule.names), dtype=np.bool_))
    fibre = _laid(molecule, hairpin)
    apart = separations(molecule)
    restraints = _restraints(molecule, geometry, hairpin, fibre, apart)
    relaxed = relax(restraints, fibre, stages=STAGES[1:], max_seconds=600.0)
    wrong = list(_wrong(molecule, geometry, relaxed.positions_A, apart))
    if relaxed.status != Status.CONVERGED:
        wrong.append(relaxed.message)
    if wrong:
        raise StructureError(f"{hairpin}: no sound stem, {'; '.join(wrong)}; nothing is built")
    if not phosphate:
        return Duplex(molecule, relaxed.positions_A, None)
    rows = [molecule.index(0, name) for name in ("O5'", *PHOSPHATE)]
    positions = np.array(relaxed.positions_A)
    *positions[rows[2:]], oxygen = _terminal(*positions[rows])
    return Duplex(molecule, positions, oxygen)


def _molecule(hairpin: HairpinSequence, phosphate: bool) -> LoopMolecule:
    """Both strands; without the loop between them they are not bonded."""
    total = len(hairpin.residues)
    stem = [k for k in range(total) if min(k, total - 1 - k) < hairpin.pairs]
    first = [name for name in atom_names(hairpin.residues[0]) if name not in PHOSPHATE]
    parts = {k: (hairpin.residues[k], first if k == 0 and not phosphate else None) for k in stem}
    return strand_molecule(parts, total)


def _laid(molecule: LoopMolecule, hairpin: HairpinSequence) -> Array:
    """Positions (N, 3) in the fibre."""
    last = len(hairpin.residues) - 1
    positions = np.full((len(molecule.names), 3), np.nan)
    for (number, name), row in molecule.rows.items():
        at = fibre_nucleotide(molecule.kinds[number].letter, hairpin.is_dna).get(name)
        if at is not None:
            # the nucleotide that pairs with number k is its image by the dyad there
            paired = number >= hairpin.pairs
            step = last - number if paired else number
            positions[row] = screwed(at * [1.0, -1.0, -1.0] if paired else at, step, hairpin.is_dna)
    for row in np.flatnonzero(~np.isfinite(positions).all(axis=1)).tolist():
        number = molecule.residue[row]
        (carrier,) = (a.GetIdx() for a in molecule.mol.GetAtomWithIdx(row).GetNeighbors())
        partner = positions[molecule.index(last - number, "C1'")]
        positions[row] = _methyl(molecule, positions, carrier, partner)
    return positions


def _methyl(molecule: LoopMolecule, positions: Array, carrier: int, partner: Array) -> Array:
    """Opposite to the bonds of its carrier, on the side that does not pair."""
    others = [
        atom.GetIdx()
        for atom in molecule.mol.GetAtomWithIdx(carrier).GetNeighbors()
        if np.isfinite(positions[atom.GetIdx()]).all()
    ]
    at = positions[carrier]
    outwards, aside = at - positions[others].mean(axis=0), at - partner
    away = outwards / np.linalg.norm(outwards) + aside / np.linalg.norm(aside)
    return np.asarray(at + 1.5 * away / np.linalg.norm(away))


def screwed(at: Array, step: int, is_dna: bool) -> Array:
    """A point of nucleotide 0 of an ideal strand, so many steps further, Å.

    Parameters
    ----------
    at : (3,) array
        Å.
    step : int
        Nucleotides, 5' to 3'.
    is_dna : bool
        B-DNA, else A-RNA.

    Returns
    -------
    (3,) array
    """
    strand = ideal_strand(is_dna)
    angle = np.deg2rad(step * strand.turn_deg)
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = at
    return np.array([c * x - s * y, s * x + c * y, z + step * strand.rise_A])


def _restraints(
    molecule: LoopMolecule,
    geometry: IdealGeometry,
    hairpin: HairpinSequence,
    fibre: Array,
    apart: NDArray[np.float64],
) -> Restraints:
    outer, outer_A, outer_sd = outer_distances(geometry)
    held = [*_hydrogen_bonds(molecule, hairpin), *_steps(molecule, hairpin)]
    # a single mismatch has none
    held_rows = np.array([one.atoms for one in held], dtype=np.int64).reshape(-1, 2)
    n_sugars = len(geometry.rings)
    phases = np.full(n_sugars, PUCKERS_DEG[1 if hairpin.is_dna else 0])
    sugars, sugars_A3 = ring_quads(geometry.rings, phases)
    counts = [len(geometry.chiral), len(geometry.planar), len(sugars)]
    sort = sorts(molecule.symbols, molecule.names)
    least, floor = room_A(sort[:, None], sort, apart)
    free = _mismatched(hairpin)
    return Restraints(
        n_moving=len(fibre),
        pairs=np.concatenate([geometry.bonds, outer, held_rows]),
        length_A=np.concatenate([geometry.length_A, outer_A, [one.length_A for one in held]]),
        length_sd=np.concatenate(
            [np.full(len(geometry.bonds), BOND_SD_A), outer_sd, [one.sd_A for one in held]]
        ),
        quads=np.concatenate([geometry.chiral, geometry.planar, sugars]),
        volume=np.concatenate([geometry.volume_A3, np.zeros(counts[1]), sugars_A3]),
        volume_sd=np.repeat([VOLUME_SD_A3, PLANAR_SD_A3, PUCKER_SD_A3], counts),
        torsions=geometry.torsions,
        torsion_fold=geometry.torsion_fold,
        torsion_at=np.deg2rad(geometry.torsion_deg),
        torsion_sd=geometry.torsion_sd,
        groups=np.empty((0, 6), dtype=np.int64),
        center_A=np.empty((0, 3)),
        center_sd=1.0,
        tether_A=fibre,
        tether_sd=np.where(np.isin(molecule.residue, sorted(free)), _MISMATCH_SD_A, TETHER_SD_A),
        least_A=least,
        floor_A=floor,
    )


class _Held(NamedTuple):
    """A distance of two atoms, by their rows."""

    atoms: tuple[int, int]
    length_A: float
    sd_A: float


def _hydrogen_bonds(molecule: LoopMolecule, hairpin: HairpinSequence) -> Iterator[_Held]:
    last = len(hairpin.residues) - 1
    for k in range(hairpin.pairs):
        purine, other = (k, last - k) if hairpin.residues[k].letter in "AG" else (last - k, k)
        pair = pair_of(hairpin.residues[k], hairpin.residues[last - k]) or ""
        for name, other_name, length in (*HYDROGEN_BONDS.get(pair, ()), *_SLID.get(pair, ())):
            atoms = molecule.index(purine, name), molecule.index(other, other_name)
            yield _Held(atoms, length, HYDROGEN_BOND_SD_A)


def _steps(molecule: LoopMolecule, hairpin: HairpinSequence) -> Iterator[_Held]:
    """Sugar and next base of each step."""
    for k, residue in molecule.kinds.items():
        if k - 1 in molecule.kinds:
            name = "C8" if residue.letter in "AG" else "C6"
            atoms = molecule.index(k - 1, "C2'"), molecule.index(k, name)
            yield _Held(atoms, STEP_A[hairpin.is_dna], _STEP_SD_A)


def _mismatched(hairpin: HairpinSequence) -> set[int]:
    last, residues = len(hairpin.residues) - 1, hairpin.residues
    return {
        number
        for k in range(hairpin.pairs)
        if pair_of(residues[k], residues[last - k]) is None
        for number in (k, last - k)
    }


def _wrong(
    molecule: LoopMolecule, geometry: IdealGeometry, positions: Array, apart: NDArray[np.float64]
) -> Iterator[str]:
    """What keeps a stem from being sound, by the limits that loops have."""
    from scipy.spatial import cKDTree

    def where(rows: NDArray[np.int64]) -> str:
        return "–".join(f"{molecule.residue[row] + 1}:{molecule.names[row]}" for row in rows)

    hands = wrong_hands(geometry, positions)
    if hands.any():
        yield f"wrong hand at {where(geometry.chiral[hands, 0][:1])}"
    for rows, off, most, unit in (
        (geometry.bonds, bond_lengths(positions, geometry.bonds) - geometry.length_A,
         BOND_TOLERANCE_A, " Å"),
        (geometry.angles, angles_deg(positions, geometry.angles) - geometry.angle_deg,
         WORST_ANGLE_DEG, "°"),
    ):  # fmt: skip
        worst = int(np.abs(off).argmax())
        if abs(off[worst]) > most:
            yield f"{where(rows[worst])} off by {abs(off[worst]):.2g}{unit}"
    near = cKDTree(positions).query_pairs(CLOSE_A, output_type="ndarray")
    for i, j in near[apart[near[:, 0], near[:, 1]] >= FAR][:1]:
        yield f"{where(np.array([i, j]))} closer than {CLOSE_A} Å"


def _terminal(o5: Array, p: Array, op1: Array, op2: Array) -> tuple[Array, Array, Array]:
    """OP1, OP2 and OP3 of a phosphate that ends a chain: three equal oxygens about O5'–P."""
    axis = (p - o5) / np.linalg.norm(p - o5)
    across = 0.5 * (op1 + op2) - p
    across -= (across @ axis) * axis
    # OP3 where the O3' of a nucleotide before would be, OP1 on its own side
    u = -across / np.linalg.norm(across)
    v = np.cross(axis, u) * np.sign(np.cross(axis, u) @ (op1 - op2))
    bend = np.deg2rad(_TERMINAL_DEG)
    turns = np.deg2rad([120.0, -120.0, 0.0])
    first, second, third = (
        p + _TERMINAL_A * (-np.cos(bend) * axis + np.sin(bend) * (np.cos(a) * u + np.sin(a) * v))
        for a in turns
    )
    return first, second, third
