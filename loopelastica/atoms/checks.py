"""What is measured on every model, against ideal values and against the line."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.atoms.geometry import RING_OF_SUGAR, IdealGeometry, separations
from loopelastica.atoms.measures import (
    angles_deg,
    bond_lengths,
    chi_torsion,
    pseudorotation,
    pucker_name,
    torsion_deg,
)
from loopelastica.atoms.relax import MESSAGES, Status
from loopelastica.atoms.site import Site
from loopelastica.atoms.suites import suite_name, suite_torsions
from loopelastica.molecule.nucleotides import BACKBONE

BOND_TOLERANCE_A: Final = 0.05
ANGLE_TOLERANCE_DEG: Final = 6.0
WORST_ANGLE_DEG: Final = 10.0
CLOSE_A: Final = 2.2
OUTSIDE: Final = "!!"
HYDROGEN_BOND_A: Final = 3.2
METAL_CLOSE_A: Final = 1.9
"""Nearest that nitrogen or oxygen comes to a metal which it may coordinate."""
_OVERLAP_A: Final = 0.4
_RADII: Final = {"C": 1.7, "N": 1.55, "O": 1.52, "P": 1.8, "S": 1.8}
"""Bondi, J. Phys. Chem. 68 (1964) 441."""


@dataclass(frozen=True, slots=True)
class Checks:
    """Figures of one model; lengths in Å, angles in degrees.

    Bonds, angles and hands are those with a built atom in them, junctions included; contacts are
    those of a built atom with anything, of the strand or around.

    Attributes
    ----------
    status : str
        How the minimization ended, such as "converged".
    bonds, bonds_within, bond_rms_A, worst_bond_A, worst_bond
        Number of bonds, share within 0.05 Å of ideal, rms and largest deviation, and where that is.
    angles, angles_within, angle_rms_deg, worst_angle_deg, worst_angle
        The same for angles and 6°.
    junction_5_A, junction_3_A
        O3'–P to the nucleotides before and after; None where there is none.
    chain_worst_A
        Largest deviation from ideal among all O3'–P bonds.
    wrong_chirality : tuple of str
        Centres with the wrong hand, such as "2:C3'".
    pucker_deg, pucker_amplitude_deg, pucker
        Phase of pseudorotation, amplitude and name of each sugar.
    suites : tuple of str
        Cluster of the backbone from each sugar to the next of RNA, "!!" outside all of them
        (:mod:`.suites`); the first is that from the nucleotide before.
    chi_deg, chi
        Glycosidic torsion and "anti" or "syn" of each nucleotide.
    closest_A, closest
        Smallest distance of two heavy atoms with at least three bonds between them, and which they
        are. Nitrogen or oxygen at 1.9 Å or more from a metal are left out.
    clashes_per_1000
        Pairs that overlap by 0.4 Å or more, hydrogens left out, per thousand built atoms; nitrogen
        and oxygen as in hydrogen bonds are none.
    contact_A
        Longest of the hydrogen bonds of a contact that was sought; None where none was, or the two
        bases make no such contact.
    line_before_A, line_after_A
        Root mean square distance of the backbone centroids from the line before and after.
    backbone_shift_A
        Root mean square shift of the six backbone atoms by the minimization.
    """

    status: str
    bonds: int
    bonds_within: float
    bond_rms_A: float
    worst_bond_A: float
    worst_bond: str
    angles: int
    angles_within: float
    angle_rms_deg: float
    worst_angle_deg: float
    worst_angle: str
    junction_5_A: float | None
    junction_3_A: float | None
    chain_worst_A: float
    wrong_chirality: tuple[str, ...]
    pucker_deg: tuple[float, ...]
    pucker_amplitude_deg: tuple[float, ...]
    pucker: tuple[str, ...]
    suites: tuple[str, ...]
    chi_deg: tuple[float, ...]
    chi: tuple[str, ...]
    closest_A: float
    closest: str
    clashes_per_1000: float
    contact_A: float | None
    line_before_A: float
    line_after_A: float
    backbone_shift_A: float

    @property
    def sound(self) -> bool:
        """Whether nothing is :attr:`wrong`."""
        return not self.wrong

    @property
    def wrong(self) -> tuple[str, ...]:
        """What keeps the model from being sound, a phrase each.

        Hands, bonds within 0.05 Å, angles within 10°, no contact below 2.2 Å (1.9 Å of nitrogen or
        oxygen and a metal), converged.
        """
        found = []
        if self.wrong_chirality:
            found.append(f"wrong hand at {', '.join(self.wrong_chirality)}")
        if self.worst_bond_A > BOND_TOLERANCE_A:
            found.append(f"bond {self.worst_bond} off by {self.worst_bond_A:.2f} Å")
        if self.worst_angle_deg > WORST_ANGLE_DEG:
            found.append(f"angle {self.worst_angle} off by {self.worst_angle_deg:.0f}°")
        if self.closest_A < CLOSE_A:
            found.append(f"{self.closest} are {self.closest_A:.2f} Å apart")
        if self.status != MESSAGES[Status.CONVERGED]:
            found.append(self.status)
        return tuple(found)

    @property
    def contact_reached(self) -> bool | None:
        """Whether the hydrogen bonds of a contact that was sought are 3.2 Å long at most."""
        return None if self.contact_A is None else self.contact_A <= HYDROGEN_BOND_A

    @property
    def excess(self) -> float:
        """How far from sound, in tolerances: 0 for a sound model."""
        return (
            10.0 * len(self.wrong_chirality)
            + max(self.worst_bond_A / BOND_TOLERANCE_A - 1.0, 0.0)
            + max(self.worst_angle_deg / WORST_ANGLE_DEG - 1.0, 0.0)
            + max((CLOSE_A - self.closest_A) / 0.2, 0.0)
            + (self.status != MESSAGES[Status.CONVERGED])
        )

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {"sound": self.sound, **asdict(self)}


def check(site: Site, positions: Array, line: Array, start: Array, status: Status) -> Checks:
    """Measure a model.

    Parameters
    ----------
    site : Site
        Its molecule, ideal geometry and what is around.
    positions, start : (N, 3) array
        Rows of the molecule after and before the minimization, Å.
    line : (n, 3) array
        Points of the line at the nucleotides, Å.
    status : Status
        How the minimization ended.

    Returns
    -------
    Checks
    """
    molecule, geometry = site.molecule, site.geometry
    rows = molecule.rows
    bond = bond_lengths(positions, geometry.bonds) - geometry.length_A
    angle = angles_deg(positions, geometry.angles) - geometry.angle_deg
    chain = [
        row
        for row, pair in enumerate(geometry.bonds.tolist())
        if {molecule.names[i] for i in pair} == {"O3'", "P"}
    ]
    junctions = [_o3_p(site, positions, k) for k in (0, molecule.n)]
    own = range(molecule.n)
    rings = np.array([[rows.get((k, name), -1) for name in RING_OF_SUGAR] for k in own])
    sugars = puckers(positions, rings)
    chi = [
        torsion_deg(*(positions[rows[k, a]] for a in chi_torsion(molecule.kinds[k].letter)))
        for k in own
    ]
    closest, pair, clashes = _contacts(site, positions)
    # a nucleotide at a 5' end may have no phosphate
    backbone = [[rows[k, name] for name in BACKBONE if (k, name) in rows] for k in own]
    return Checks(
        status=MESSAGES[status],
        bonds=len(bond),
        bonds_within=_share(bond, BOND_TOLERANCE_A),
        bond_rms_A=_rms(bond),
        worst_bond_A=_worst(bond),
        worst_bond=_where(site, geometry.bonds, bond),
        angles=len(angle),
        angles_within=_share(angle, ANGLE_TOLERANCE_DEG),
        angle_rms_deg=_rms(angle),
        worst_angle_deg=_worst(angle),
        worst_angle=_where(site, geometry.angles, angle),
        junction_5_A=junctions[0],
        junction_3_A=junctions[1],
        chain_worst_A=_worst(bond[chain]),
        wrong_chirality=_wrong_hands(site, positions),
        pucker_deg=tuple(round(phase, 2) for phase, _ in sugars),
        pucker_amplitude_deg=tuple(round(amplitude, 2) for _, amplitude in sugars),
        pucker=tuple(pucker_name(phase) for phase, _ in sugars),
        suites=tuple(
            suite_name(torsions) or OUTSIDE
            for torsions in suite_torsions(positions, geometry.suites)
        ),
        chi_deg=tuple(round(value, 2) for value in chi),
        chi=tuple("syn" if abs(value) < 90.0 else "anti" for value in chi),
        closest_A=closest,
        closest=" and ".join(site.label(row) for row in pair),
        clashes_per_1000=1000.0 * clashes / max(int(site.moving.sum()), 1),
        contact_A=_contact(site, positions),
        line_before_A=_from_line(start, backbone, line),
        line_after_A=_from_line(positions, backbone, line),
        backbone_shift_A=_rms(
            np.linalg.norm((positions - start)[np.concatenate(backbone)], axis=1)
        ),
    )


def puckers(positions: Array, rings: NDArray[np.int64]) -> list[tuple[float, float]]:
    """Phase and amplitude of sugars; see :func:`pseudorotation`.

    Parameters
    ----------
    positions : (N, 3) array
        Å.
    rings : (s, 5) array of int
        Rows of C1' C2' C3' C4' O4'.

    Returns
    -------
    list of (float, float)
        Degrees.
    """
    return [pseudorotation(*positions[ring]) for ring in rings]


def wrong_hands(geometry: IdealGeometry, positions: Array) -> NDArray[np.bool_]:
    """Which of the centres have the wrong hand or none.

    Parameters
    ----------
    geometry : IdealGeometry
    positions : (N, 3) array
        Å.

    Returns
    -------
    (q,) array of bool
    """
    a, b, c, d = (positions[geometry.chiral[:, column]] for column in range(4))
    found = ((b - a) * np.cross(c - a, d - a)).sum(axis=1)
    # half the volume is already a flattened centre
    return np.asarray(found < 0.5 * geometry.volume_A3)


def _wrong_hands(site: Site, positions: Array) -> tuple[str, ...]:
    wrong = wrong_hands(site.geometry, positions)
    return tuple(site.label(row) for row in site.geometry.chiral[wrong, 0])


def _o3_p(site: Site, positions: Array, k: int) -> float | None:
    """Length of the bond from nucleotide k − 1 to k."""
    pair = [site.molecule.rows.get(key) for key in ((k - 1, "O3'"), (k, "P"))]
    if None in pair:
        return None
    return float(np.linalg.norm(positions[pair[0]] - positions[pair[1]]))


def _contacts(site: Site, positions: Array) -> tuple[float, tuple[int, ...], int]:
    """Smallest distance of unbonded heavy atoms, which they are, and the number of overlaps.

    Pairs are of a built atom and any other, from row N on of what is around.
    """
    from scipy.spatial.distance import cdist

    molecule, around = site.molecule, site.around
    symbols = molecule.symbols
    radius = np.array([_RADII.get(symbol, 1.7) for symbol in symbols])
    polar = np.array([symbol in "NO" for symbol in symbols])
    moving = site.moving
    inside = cdist(positions, positions)
    bonds = separations(molecule)
    later = np.arange(len(positions)) > np.arange(len(positions))[:, None]
    pair = (bonds >= 3) & (moving[:, None] | moving) & later
    clash = pair & (bonds > 3) & ~(polar[:, None] & polar)
    clashes = int((clash & (radius[:, None] + radius - inside > _OVERLAP_A)).sum())
    inside = np.where(pair, inside, np.inf)
    outside = cdist(positions, around.positions_A)
    owner = np.array(molecule.residue)
    outside[~moving] = np.inf
    outside[owner[:, None] == around.owner] = np.inf
    coordinated = polar[:, None] & around.metal & (outside >= METAL_CLOSE_A)
    outside[coordinated] = np.inf
    clashes += int((radius[:, None] + 1.6 - outside > _OVERLAP_A + 0.1).sum())
    every = np.concatenate([inside, outside], axis=1)
    if not np.isfinite(every).any():
        return np.inf, (), 0
    row, column = np.unravel_index(int(every.argmin()), every.shape)
    return float(every[row, column]), (int(row), int(column)), clashes


def _contact(site: Site, positions: Array) -> float | None:
    if len(site.contact_pairs) == 0:
        return None
    return float(bond_lengths(positions, site.contact_pairs).max())


def _from_line(positions: Array, backbone: list[list[int]], line: Array) -> float:
    centroids = np.array([positions[rows].mean(axis=0) for rows in backbone])
    return _rms(np.linalg.norm(centroids - line, axis=1))


def _where(site: Site, rows: NDArray[np.int64], off: Array) -> str:
    if len(off) == 0:
        return ""
    return "–".join(site.label(row) for row in rows[np.abs(off).argmax()])


def _worst(off: Array) -> float:
    return float(np.abs(off).max(initial=0.0))


def _share(off: Array, tolerance: float) -> float:
    return float((np.abs(off) <= tolerance).mean()) if len(off) else 1.0


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if values.size else 0.0
