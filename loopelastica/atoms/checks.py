"""What is measured on every model, against ideal values and against the line."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.atoms.chemistry import LoopMolecule
from loopelastica.atoms.geometry import IdealGeometry, chiral_quads, separations
from loopelastica.atoms.measures import (
    angles_deg,
    bond_lengths,
    chi_torsion,
    pseudorotation,
    pucker_name,
    torsion_deg,
)
from loopelastica.molecule.nucleotides import BACKBONE

BOND_TOLERANCE_A: Final = 0.05
ANGLE_TOLERANCE_DEG: Final = 6.0
CLOSE_A: Final = 2.2
_OVERLAP_A: Final = 0.4
_RADII: Final = {"C": 1.7, "N": 1.55, "O": 1.52, "P": 1.8, "S": 1.8}
"""Bondi, J. Phys. Chem. 68 (1964) 441."""


@dataclass(frozen=True, slots=True)
class Checks:
    """Figures of one model; lengths in Å, angles in degrees.

    Attributes
    ----------
    bonds, bonds_within, bond_rms_A, bond_worst_A
        Number of bonds, share within 0.05 Å of ideal, rms and largest deviation.
    angles, angles_within, angle_rms_deg, angle_worst_deg
        The same for angles and 6°.
    junction_5_A, junction_3_A
        O3'–P to the 5' and to the 3' closing nucleotide.
    chain_worst_A
        Largest deviation from ideal among all O3'–P bonds.
    wrong_chirality : tuple of str
        Centres with the wrong hand, such as "2:C3'".
    pucker_deg, pucker_amplitude_deg, pucker
        Phase of pseudorotation, amplitude and name of each sugar.
    chi_deg, chi
        Glycosidic torsion and "anti" or "syn" of each nucleotide.
    closest_A
        Smallest distance of two heavy atoms with at least three bonds between them.
    clashes_per_1000
        Pairs that overlap by 0.4 Å or more, hydrogens left out, per thousand loop atoms; nitrogen
        and oxygen as in hydrogen bonds are none.
    line_before_A, line_after_A
        Root mean square distance of the backbone centroids from the line before and after.
    backbone_shift_A
        Root mean square shift of the six backbone atoms by the minimization.
    """

    bonds: int
    bonds_within: float
    bond_rms_A: float
    bond_worst_A: float
    angles: int
    angles_within: float
    angle_rms_deg: float
    angle_worst_deg: float
    junction_5_A: float
    junction_3_A: float
    chain_worst_A: float
    wrong_chirality: tuple[str, ...]
    pucker_deg: tuple[float, ...]
    pucker_amplitude_deg: tuple[float, ...]
    pucker: tuple[str, ...]
    chi_deg: tuple[float, ...]
    chi: tuple[str, ...]
    closest_A: float
    clashes_per_1000: float
    line_before_A: float
    line_after_A: float
    backbone_shift_A: float

    @property
    def sound(self) -> bool:
        """Right hands, whole chain, no contact below 2.2 Å."""
        return (
            not self.wrong_chirality
            and self.chain_worst_A <= BOND_TOLERANCE_A
            and self.closest_A >= CLOSE_A
        )

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {"sound": self.sound, **asdict(self)}


def check(
    molecule: LoopMolecule,
    geometry: IdealGeometry,
    positions: Array,
    around: Array,
    line: Array,
    start: Array,
) -> Checks:
    """Measure a model.

    Parameters
    ----------
    molecule : LoopMolecule
    geometry : IdealGeometry
        Its ideal lengths and angles.
    positions, start : (N, 3) array
        Rows of the molecule after and before the minimization, Å.
    around : (m, 3) array
        Heavy atoms near the loop that are no part of the molecule.
    line : (n, 3) array
        Points of the line at the nucleotides, Å.

    Returns
    -------
    Checks
    """
    n = len(molecule.residues)
    bond = bond_lengths(positions, geometry.bonds) - geometry.length_A
    angle = angles_deg(positions, geometry.angles) - geometry.angle_deg
    chain = [
        row
        for row, pair in enumerate(geometry.bonds.tolist())
        if {molecule.names[i] for i in pair} == {"O3'", "P"}
    ]
    lengths = bond_lengths(positions, geometry.bonds[chain])
    by_owner = {
        max(molecule.residue[i] for i in geometry.bonds[row]): length
        for row, length in zip(chain, lengths, strict=True)
    }
    rows = {key: i for i, key in enumerate(zip(molecule.residue, molecule.names, strict=True))}
    sugars = puckers(molecule, positions)
    chi = [
        torsion_deg(*(positions[rows[k, a]] for a in chi_torsion(molecule.residues[k].letter)))
        for k in range(n)
    ]
    closest, clashes = _contacts(molecule, positions, around)
    backbone = np.array([[rows[k, name] for name in BACKBONE] for k in range(n)])
    return Checks(
        bonds=len(bond),
        bonds_within=float((np.abs(bond) <= BOND_TOLERANCE_A).mean()),
        bond_rms_A=_rms(bond),
        bond_worst_A=float(np.abs(bond).max()),
        angles=len(angle),
        angles_within=float((np.abs(angle) <= ANGLE_TOLERANCE_DEG).mean()),
        angle_rms_deg=_rms(angle),
        angle_worst_deg=float(np.abs(angle).max()),
        junction_5_A=float(by_owner[0]),
        junction_3_A=float(by_owner[n]),
        chain_worst_A=float(np.abs(bond[chain]).max()),
        wrong_chirality=_wrong_hands(molecule, positions),
        pucker_deg=tuple(round(phase, 2) for phase, _ in sugars),
        pucker_amplitude_deg=tuple(round(amplitude, 2) for _, amplitude in sugars),
        pucker=tuple(pucker_name(phase) for phase, _ in sugars),
        chi_deg=tuple(round(value, 2) for value in chi),
        chi=tuple("syn" if abs(value) < 90.0 else "anti" for value in chi),
        closest_A=closest,
        clashes_per_1000=1000.0 * clashes / len(molecule.loop_atoms),
        line_before_A=_rms(np.linalg.norm(start[backbone].mean(axis=1) - line, axis=1)),
        line_after_A=_rms(np.linalg.norm(positions[backbone].mean(axis=1) - line, axis=1)),
        backbone_shift_A=_rms(np.linalg.norm(positions[backbone] - start[backbone], axis=-1)),
    )


def puckers(molecule: LoopMolecule, positions: Array) -> list[tuple[float, float]]:
    """Phase and amplitude of each sugar of the loop; see :func:`pseudorotation`.

    Parameters
    ----------
    molecule : LoopMolecule
    positions : (N, 3) array
        Its atoms, Å.

    Returns
    -------
    list of (float, float)
        Degrees.
    """
    ring = ("C1'", "C2'", "C3'", "C4'", "O4'")
    return [
        pseudorotation(*(positions[molecule.index(k, name)] for name in ring))
        for k in range(len(molecule.residues))
    ]


def _wrong_hands(molecule: LoopMolecule, positions: Array) -> tuple[str, ...]:
    quads, volume = chiral_quads(molecule)
    a, b, c, d = (positions[quads[:, column]] for column in range(4))
    found = ((b - a) * np.cross(c - a, d - a)).sum(axis=1)
    # half the volume is already a flattened centre
    wrong = quads[found < 0.5 * volume, 0]
    return tuple(f"{molecule.residue[row] + 1}:{molecule.names[row]}" for row in wrong)


def _contacts(molecule: LoopMolecule, positions: Array, around: Array) -> tuple[float, int]:
    """Smallest distance of unbonded heavy atoms, and the number of overlaps."""
    loop = molecule.loop_atoms
    radius = np.array([_RADII.get(a.GetSymbol(), 1.7) for a in molecule.mol.GetAtoms()])
    polar = np.array([a.GetSymbol() in "NO" for a in molecule.mol.GetAtoms()])
    apart = separations(molecule)
    distance = np.linalg.norm(positions[:, None] - positions[None], axis=-1)
    pair = np.triu(apart >= 3, k=1)
    ours = np.zeros(len(positions), dtype=np.bool_)
    ours[loop] = True
    pair &= ours[:, None] | ours[None]
    closest = float(distance[pair].min())
    pair &= (apart > 3) & ~(polar[:, None] & polar[None])
    clashes = int((pair & (radius[:, None] + radius[None] - distance > _OVERLAP_A)).sum())
    if len(around):
        to_stem = np.linalg.norm(positions[loop][:, None] - around[None], axis=-1)
        closest = min(closest, float(to_stem.min()))
        clashes += int((radius[loop][:, None] + 1.6 - to_stem > _OVERLAP_A + 0.1).sum())
    return closest, clashes


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
