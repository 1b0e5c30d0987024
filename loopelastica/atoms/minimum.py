"""The minimum next to a start: all restraints on the atoms, and two minimizations."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.atoms.checks import puckers
from loopelastica.atoms.chemistry import LoopMolecule
from loopelastica.atoms.geometry import (
    BOND_SD_A,
    NEAREST_1_4_A,
    PLANAR_SD_A3,
    PUCKER_SD_A3,
    PUCKERS_DEG,
    TORSION_SD,
    VOLUME_SD_A3,
    backbone_torsions,
    chiral_quads,
    nearest_A,
    outer_distances,
    planar_quads,
    ring_quads,
    separations,
)
from loopelastica.atoms.ideal import ideal_value
from loopelastica.atoms.relax import Relaxed, Restraints, relax
from loopelastica.atoms.site import Site
from loopelastica.molecule.nucleotides import BACKBONE

TETHER_SD_A: Final = 2.0
"""How weakly each atom is held to where the line has carried it."""


def minimum(
    site: Site, centers: Array, line_sd: float, start: Array, max_steps: int, max_seconds: float
) -> Relaxed:
    """The minimum next to `start`, its sugars in one of the two usual puckers.

    A first minimization, free of any pucker, shows which of the two is nearer for each sugar, and
    which phosphates have turned over: their free oxygens are put anew.

    Parameters
    ----------
    site : Site
        The loop's molecule and what is around.
    centers : (n, 3) array
        Points of the line that the backbone centroids are held to, Å.
    line_sd : float
        How near they are held, Å.
    start : (N, 3) array
        Positions to begin at, Å.
    max_steps, max_seconds : int, float
        Limits of each minimization.

    Returns
    -------
    Relaxed
    """
    order = np.array(site.molecule.loop_atoms + sorted(site.fixed))
    whole = np.concatenate([start[order], site.around])
    restraints = _restraints(site, order, centers, line_sd, start)
    relaxed = relax(restraints, whole, max_steps=max_steps, max_seconds=max_seconds)
    place = np.empty((len(order), 3))
    place[order] = relaxed.positions_A[: len(order)]
    phases = np.array([phase for phase, _ in puckers(site.molecule, place)])
    away = np.abs((phases[:, None] - np.array(PUCKERS_DEG) + 180.0) % 360.0 - 180.0)
    pucker_deg = np.array(PUCKERS_DEG)[away.argmin(axis=1)]
    _right_phosphates(site.molecule, place)
    whole = np.concatenate([place[order], site.around])
    restraints = _restraints(site, order, centers, line_sd, start, pucker_deg)
    relaxed = relax(restraints, whole, max_steps=max_steps, max_seconds=max_seconds)
    place[order] = relaxed.positions_A[: len(order)]
    return Relaxed(place, relaxed.status, relaxed.steps, relaxed.cost)


def _right_phosphates(molecule: LoopMolecule, positions: Array) -> None:
    """Put oxygens of phosphates anew, in place, where they have the wrong hand or none."""
    quads, volumes = chiral_quads(molecule)
    for quad, volume in zip(quads, volumes, strict=True):
        if molecule.names[quad[0]] != "P":
            continue
        p, o3, op1, op2 = positions[quad]
        if (o3 - p) @ np.cross(op1 - p, op2 - p) > 0.5 * volume:
            continue
        o5 = positions[molecule.index(molecule.residue[quad[0]], "O5'")]
        u, v = (o3 - p) / np.linalg.norm(o3 - p), (o5 - p) / np.linalg.norm(o5 - p)
        outward, across = -(u + v), np.cross(u, v)
        outward, across = outward / np.linalg.norm(outward), across / np.linalg.norm(across)
        # half the ideal OP1–P–OP2 angle to either side of the plane of O3', P and O5'
        half = np.deg2rad(0.5 * _value("OP1", "P", "OP2"))
        length = _value("P", "OP1")
        for row, side in ((quad[2], 1.0), (quad[3], -1.0)):
            direction = np.cos(half) * outward + side * np.sin(half) * across
            positions[row] = p + length * direction
    _right_junction(molecule, positions)


def _right_junction(molecule: LoopMolecule, positions: Array) -> None:
    """Put the last O3', in place, where it belongs if it came to the stem's P from the wrong side.

    The stem's own oxygens then stand between the two sides, and no small step leads round them.
    """
    n = len(molecule.residues)
    place = dict(zip(zip(molecule.residue, molecule.names, strict=True), positions, strict=True))
    if any((n, name) not in place for name in ("P", "OP1", "OP2", "O5'")):
        return
    p = place[n, "P"]
    bonds = np.array([place[n, name] - p for name in ("OP1", "OP2", "O5'")])
    outward = -(bonds / np.linalg.norm(bonds, axis=1, keepdims=True)).sum(axis=0)
    row = molecule.index(n - 1, "O3'")
    if (positions[row] - p) @ outward < 0.0:
        positions[row] = p + _value("O3'", "P") * outward / np.linalg.norm(outward)


def _value(*names: str) -> float:
    """An ideal value that every nucleotide has."""
    value = ideal_value("A", False, *names)
    assert value is not None
    return value


def _restraints(
    site: Site,
    order: NDArray[np.int64],
    centers: Array,
    line_sd: float,
    start: Array,
    phases_deg: Array | None = None,
) -> Restraints:
    """All restraints on the atoms; `order` puts those that move first."""
    molecule, geometry = site.molecule, site.geometry
    n, moving = len(molecule.residues), molecule.loop_atoms
    new = np.empty(len(order), dtype=np.int64)
    new[order] = np.arange(len(order))
    pairs, outer, outer_sd = outer_distances(geometry)
    chiral, volume = chiral_quads(molecule)
    planar = planar_quads(molecule)
    quads = [(chiral, volume, VOLUME_SD_A3), (planar, np.zeros(len(planar)), PLANAR_SD_A3)]
    if phases_deg is not None:
        quads.append((*ring_quads(molecule, geometry, phases_deg), PUCKER_SD_A3))
    near, near_A = _near(site, order, len(moving))
    groups = [[new[molecule.index(k, name)] for name in BACKBONE] for k in range(n)]
    return Restraints(
        n_moving=len(moving),
        pairs=new[np.concatenate([geometry.bonds, pairs])],
        length_A=np.concatenate([geometry.length_A, outer]),
        length_sd=np.concatenate([np.full(len(geometry.bonds), BOND_SD_A), outer_sd]),
        quads=new[np.concatenate([q for q, _, _ in quads])],
        volume=np.concatenate([v for _, v, _ in quads]),
        volume_sd=np.concatenate([np.full(len(q), sd) for q, _, sd in quads]),
        torsions=new[backbone_torsions(molecule)],
        torsion_sd=TORSION_SD,
        groups=np.array(groups),
        center_A=centers,
        center_sd=line_sd,
        tether_A=start[moving],
        tether_sd=TETHER_SD_A,
        near=near,
        near_A=near_A,
    )


def _near(site: Site, order: NDArray[np.int64], n_moving: int) -> tuple[NDArray[np.int64], Array]:
    """Pairs of atoms that may not overlap, with their least distances."""
    molecule = site.molecule
    apart = separations(molecule)[np.ix_(order, order)]
    polar = np.array([molecule.mol.GetAtomWithIdx(int(row)).GetSymbol() in "NO" for row in order])
    least = nearest_A(polar, polar)
    least = np.where(apart == 3, np.minimum(least, NEAREST_1_4_A), least)
    inside = np.argwhere(np.triu(apart > 2, k=1))
    inside = inside[inside[:, 0] < n_moving]
    # the neighbours of the junctions in the stem are nearer by nature than anything else
    outside = nearest_A(polar[:n_moving], site.around_polar)
    i, j = np.indices(outside.shape)
    return (
        np.concatenate([inside, np.column_stack([i.ravel(), len(order) + j.ravel()])]),
        np.concatenate([least[inside[:, 0], inside[:, 1]], outside.ravel()]),
    )
