"""The minimum next to a start: all restraints on the atoms, and its stages."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.atoms.checks import puckers
from loopelastica.atoms.geometry import (
    BOND_SD_A,
    NEAREST_1_4_A,
    PLANAR_SD_A3,
    PUCKER_SD_A3,
    PUCKERS_DEG,
    TORSION_SD,
    VOLUME_SD_A3,
    chiral_quads,
    everywhere,
    nearest_A,
    outer_distances,
    ring_quads,
    separations,
)
from loopelastica.atoms.relax import STAGES, Index, Relaxed, Restraints, relax
from loopelastica.atoms.site import Site
from loopelastica.molecule.nucleotides import BACKBONE

TETHER_SD_A: Final = 2.0
"""How weakly each atom is held to where the line has carried it."""
LOOSE_LINE_SD_A: Final = 4.0
"""How near the centroids are held to the line where it stands in the way of sound atoms."""
PIN_SD_A: Final = 0.1
FLOOR_A: Final = 2.4
"""Nearer than this no two atoms may be, but for nitrogen or oxygen and a metal."""
METAL_POLAR_A: Final = 2.05
METAL_A: Final = 2.9


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """The restraints of a site that no attempt changes, atoms that move first.

    Attributes
    ----------
    site : Site
    order : (N,) array of int
        Rows of the molecule in the order of the restraints.
    pairs, length_A, length_sd : (p, 2), (p,), (p,) array
    quads, volume, volume_sd : (q, 4), (q,), (q,) array
    torsions, rings, groups : (t, 4), (s, 5), (g, 6) array
    group_of : (g,) array of int
        Nucleotide of each group.
    least_A, floor_A : (n_moving, N + m) array
    pinned : dict of int to (3,) array
        Where atoms belong whose place all that is there determines, Å.
    tether_sd : float
        How near each atom is held to its start, Å.
    """

    site: Site
    order: Index
    pairs: Index
    length_A: Array
    length_sd: Array
    quads: Index
    volume: Array
    volume_sd: Array
    torsions: Index
    rings: Index
    groups: Index
    group_of: Index
    least_A: Array
    floor_A: Array
    pinned: dict[int, Array]
    tether_sd: float = TETHER_SD_A

    @classmethod
    def at(cls, site: Site) -> Problem:
        """The restraints at a site."""
        geometry, molecule = site.geometry, site.molecule
        order = np.concatenate([np.flatnonzero(site.moving), np.flatnonzero(~site.moving)])
        new = np.empty(len(order), dtype=np.int64)
        new[order] = np.arange(len(order))
        outer, outer_A, outer_sd = outer_distances(geometry)
        owned = {
            k: [molecule.rows.get((k, name), -1) for name in BACKBONE] for k in range(molecule.n)
        }
        groups = {k: rows for k, rows in owned.items() if -1 not in rows}
        least, floor = _least(site, order)
        n_chiral, n_planar = len(geometry.chiral), len(geometry.planar)
        return cls(
            site,
            order,
            new[np.concatenate([geometry.bonds, outer])],
            np.concatenate([geometry.length_A, outer_A]),
            np.concatenate([np.full(len(geometry.bonds), BOND_SD_A), outer_sd]),
            new[np.concatenate([geometry.chiral, geometry.planar])],
            np.concatenate([geometry.volume_A3, np.zeros(n_planar)]),
            np.repeat([VOLUME_SD_A3, PLANAR_SD_A3], [n_chiral, n_planar]),
            new[geometry.torsions],
            new[geometry.rings],
            new[np.array(list(groups.values()), dtype=np.int64).reshape(-1, len(BACKBONE))],
            np.array(list(groups), dtype=np.int64),
            least,
            floor,
            {int(new[row]): at for row, at in _junction_3(site).items()},
        )

    def restraints(
        self,
        centers: Array,
        line_sd: float,
        start: Array,
        phases_deg: Array | None = None,
        stress: Array | float = 1.0,
    ) -> Restraints:
        """All restraints of one attempt; `start` (N, 3) in rows of the molecule.

        `stress` (p,) makes bonds and angles so many times stiffer than they are.
        """
        quads, volume, volume_sd = self.quads, self.volume, self.volume_sd
        if phases_deg is not None:
            more, size = ring_quads(self.rings, phases_deg)
            quads = np.concatenate([quads, more])
            volume = np.concatenate([volume, size])
            volume_sd = np.concatenate([volume_sd, np.full(len(more), PUCKER_SD_A3)])
        n_moving = len(self.least_A)
        tether, tether_sd = start[self.order[:n_moving]], np.full(n_moving, self.tether_sd)
        for row, at in self.pinned.items():
            tether[row], tether_sd[row] = at, PIN_SD_A
        return Restraints(
            n_moving=n_moving,
            pairs=self.pairs,
            length_A=self.length_A,
            length_sd=self.length_sd / stress,
            quads=quads,
            volume=volume,
            volume_sd=volume_sd,
            torsions=self.torsions,
            torsion_sd=TORSION_SD,
            groups=self.groups,
            center_A=centers[self.group_of],
            center_sd=line_sd,
            tether_A=tether,
            tether_sd=tether_sd,
            least_A=self.least_A,
            floor_A=self.floor_A,
        )


def minimum(
    problem: Problem,
    centers: Array,
    line_sd: float,
    start: Array,
    max_steps: int,
    max_seconds: float,
) -> Relaxed:
    """The minimum next to `start`, its sugars in one of the two usual puckers.

    The loose stages, free of any pucker, show which of the two is nearer for each sugar, and which
    phosphates have turned over: their free oxygens are put anew.

    Parameters
    ----------
    problem : Problem
        The strand's molecule and what is around.
    centers : (n, 3) array
        Points of the line that the backbone centroids are held to, Å.
    line_sd : float
        How near they are held, Å.
    start : (N, 3) array
        Positions to begin at, Å.
    max_steps, max_seconds : int, float
        Limits of the minimization.

    Returns
    -------
    Relaxed
    """
    site, order = problem.site, problem.order
    limit = time.monotonic() + max_seconds
    whole = np.concatenate([start[order], site.around.positions_A])
    restraints = problem.restraints(centers, line_sd, start)
    loose = relax(restraints, whole, stages=STAGES[:2], max_seconds=max_seconds)
    whole = np.array(loose.positions_A)
    place = np.empty((len(order), 3))
    place[order] = whole[: len(order)]
    right_phosphates(site, place)
    whole[: len(order)] = place[order]
    strict = relax(
        problem.restraints(centers, line_sd, start, _near_puckers(whole, problem.rings)),
        whole,
        stages=STAGES[2:],
        max_steps=max_steps,
        max_seconds=max(limit - time.monotonic(), 0.0),
    )
    place[order] = strict.positions_A[: len(order)]
    return Relaxed(place, strict.status, loose.steps + strict.steps, strict.cost)


def mended(
    problem: Problem,
    centers: Array,
    relaxed: Relaxed,
    stress: Array,
    max_steps: int,
    max_seconds: float,
) -> Relaxed:
    """A minimum near to another one, the line nearly let go, some bonds and angles made stiffer.

    Parameters
    ----------
    problem : Problem
        The strand's molecule and what is around.
    centers : (n, 3) array
        Points of the line, Å.
    relaxed : Relaxed
        The other minimum.
    stress : (p,) array
        How many times stiffer.
    max_steps, max_seconds : int, float
        Limits of the minimization.

    Returns
    -------
    Relaxed
    """
    order = problem.order
    there = np.array(relaxed.positions_A)
    whole = np.concatenate([there[order], problem.site.around.positions_A])
    phases = _near_puckers(whole, problem.rings)
    again = relax(
        problem.restraints(centers, LOOSE_LINE_SD_A, there, phases, stress),
        whole,
        stages=STAGES[2:],
        max_steps=max_steps,
        max_seconds=max_seconds,
    )
    place = np.empty((len(order), 3))
    place[order] = again.positions_A[: len(order)]
    return Relaxed(place, again.status, relaxed.steps + again.steps, again.cost)


def _near_puckers(positions: Array, rings: Index) -> Array:
    """Of the two usual puckers the one next to each sugar's own, degrees."""
    phases = np.array([phase for phase, _ in puckers(positions, rings)])
    away = np.abs((phases[:, None] - np.array(PUCKERS_DEG) + 180.0) % 360.0 - 180.0)
    return np.asarray(np.array(PUCKERS_DEG)[away.argmin(axis=1)], dtype=np.float64)


def right_phosphates(site: Site, positions: Array) -> None:
    """Put oxygens of phosphates anew, in place, where they have the wrong hand or none.

    Parameters
    ----------
    site : Site
    positions : (N, 3) array
        Rows of its molecule, Å.
    """
    molecule = site.molecule
    quads, volumes = chiral_quads(molecule)
    for quad, volume in zip(quads, volumes, strict=True):
        residue = molecule.residue[quad[0]]
        o5_row = molecule.rows.get((residue, "O5'"))
        if molecule.names[quad[0]] != "P" or o5_row is None:
            continue
        p, o3, op1, op2 = positions[quad]
        if (o3 - p) @ np.cross(op1 - p, op2 - p) > 0.5 * volume:
            continue
        u, v = (o3 - p) / np.linalg.norm(o3 - p), (positions[o5_row] - p)
        v = v / np.linalg.norm(v)
        outward, across = -(u + v), np.cross(u, v)
        outward = outward / np.linalg.norm(outward)
        across = across / np.linalg.norm(across)
        # half the ideal OP1–P–OP2 angle to either side of the plane of O3', P and O5'
        half = np.deg2rad(0.5 * everywhere("OP1", "P", "OP2"))
        for row, side in ((quad[2], 1.0), (quad[3], -1.0)):
            if site.moving[row]:
                direction = np.cos(half) * outward + side * np.sin(half) * across
                positions[row] = p + everywhere("P", "OP1") * direction


def _junction_3(site: Site) -> dict[int, Array]:
    """Where the last O3' belongs, by row, if the phosphate that it is bonded to is there.

    The oxygens that are there stand between the right side of P and the wrong one, and no small
    step leads round them.
    """
    n, known = site.molecule.n, site.molecule.rows
    rows = [known.get((n, name), -1) for name in ("P", "OP1", "OP2", "O5'")]
    o3 = known.get((n - 1, "O3'"), -1)
    if -1 in (o3, *rows) or not site.moving[o3] or site.moving[rows].any():
        return {}
    p, *oxygens = site.fixed_A[rows]
    bonds = np.array(oxygens) - p
    # opposite to the three others
    away = -(bonds / np.linalg.norm(bonds, axis=1, keepdims=True)).sum(axis=0)
    return {o3: p + everywhere("O3'", "P") * away / np.linalg.norm(away)}


def _least(site: Site, order: Index) -> tuple[Array, Array]:
    """Distances that atoms like to keep, and that they must, of each moving atom to all."""
    molecule, around = site.molecule, site.around
    n_moving = int(site.moving.sum())
    apart = separations(molecule)[np.ix_(order[:n_moving], order)]
    polar = _polar(site)[order]
    owner = np.array(molecule.residue)[order[:n_moving]]
    inside = nearest_A(polar[:n_moving], polar)
    inside = np.where(apart == 3, np.minimum(inside, NEAREST_1_4_A), inside)
    outside = nearest_A(polar[:n_moving], around.polar)
    coordinated = np.where(polar[:n_moving], METAL_POLAR_A, METAL_A)[:, None]
    outside = np.where(around.metal, coordinated, outside)
    # the group of a modified nucleotide is bonded to it in ways that are not known here
    outside[owner[:, None] == around.owner] = 0.0
    least = np.concatenate([np.where(apart <= 2, 0.0, inside), outside], axis=1)
    return least, np.minimum(least, FLOOR_A)


def _polar(site: Site) -> NDArray[np.bool_]:
    return np.array([a.GetSymbol() in "NO" for a in site.molecule.mol.GetAtoms()])
