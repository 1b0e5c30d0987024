"""The minimum next to a start: all restraints on the atoms, and its stages."""

from __future__ import annotations

import time
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.atoms.checks import puckers
from loopelastica.atoms.geometry import (
    BOND_SD_A,
    FLOOR_A,
    NEAREST_A,
    PLANAR_SD_A3,
    PUCKER_SD_A3,
    PUCKERS_DEG,
    SUITE_SD,
    VOLUME_SD_A3,
    chiral_quads,
    everywhere,
    outer_distances,
    ring_quads,
    room_A,
    separations,
    sorts,
)
from loopelastica.atoms.relax import STAGES, Index, Relaxed, Restraints, relax
from loopelastica.atoms.site import Site
from loopelastica.atoms.suites import DELTA_DEG, MEANS_DEG, nearest, suite_torsions
from loopelastica.molecule.nucleotides import BACKBONE

TETHER_SD_A: Final = 2.0
"""How weakly each atom is held to where the line has carried it."""
LOOSE_LINE_SD_A: Final = 4.0
"""How near the centroids are held to the line where it stands in the way of sound atoms."""
PIN_SD_A: Final = 0.1
CONTACT_A: Final = 2.9
CONTACT_SD_A: Final = 0.05
"""Hydrogen bonds of a contact that is sought, and how near they are held to it."""
TURNING_SD: Final = 0.1
"""How near torsions are held that have to turn into a cluster, rad."""
TURNING_LINE_SD_A: Final = 1.0
"""And the centroids to the line meanwhile."""
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
    ring_of, group_of : (s,), (g,) array of int
        Nucleotide of each ring and group.
    suites : (u, 7, 4) array
        Torsions of the suites of RNA.
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
    ring_of: Index
    group_of: Index
    suites: Index
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
        contact = site.contact_pairs
        n_chiral, n_planar = len(geometry.chiral), len(geometry.planar)
        return cls(
            site,
            order,
            new[np.concatenate([geometry.bonds, outer, contact])],
            np.concatenate([geometry.length_A, outer_A, np.full(len(contact), CONTACT_A)]),
            np.concatenate(
                [
                    np.full(len(geometry.bonds), BOND_SD_A),
                    outer_sd,
                    np.full(len(contact), CONTACT_SD_A),
                ]
            ),
            new[np.concatenate([geometry.chiral, geometry.planar])],
            np.concatenate([geometry.volume_A3, np.zeros(n_planar)]),
            np.repeat([VOLUME_SD_A3, PLANAR_SD_A3], [n_chiral, n_planar]),
            new[geometry.torsions],
            new[geometry.rings],
            new[np.array(list(groups.values()), dtype=np.int64).reshape(-1, len(BACKBONE))],
            np.array(molecule.residue, dtype=np.int64)[geometry.rings[:, 0]],
            np.array(list(groups), dtype=np.int64),
            new[geometry.suites],
            least,
            floor,
            {int(new[row]): at for row, at in _junction_3(site).items()},
        )

    def restraints(
        self,
        centers: Array,
        line_sd: float,
        start: Array,
        phases_deg: Array,
        clusters_deg: Array | None = None,
        stress: Array | float = 1.0,
        suite_sd: float = SUITE_SD,
    ) -> Restraints:
        """All restraints of one attempt; `start` (N, 3) in rows of the molecule.

        `phases_deg` (s,) are puckers of its sugars, `clusters_deg` (u, 7) torsions of its suites,
        NaN for those that are free; `stress` (p,) makes bonds and angles so many times stiffer than
        they are; `suite_sd` is how near torsions of suites are held, rad.
        """
        quads, volume, volume_sd = self.quads, self.volume, self.volume_sd
        held = np.isfinite(phases_deg)
        if held.any():
            more, size = ring_quads(self.rings[held], phases_deg[held])
            quads = np.concatenate([quads, more])
            volume = np.concatenate([volume, size])
            volume_sd = np.concatenate([volume_sd, np.full(len(more), PUCKER_SD_A3)])
        torsions, fold, places, torsion_sd = self._torsions(clusters_deg, suite_sd)
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
            torsions=torsions,
            torsion_fold=fold,
            torsion_at=places,
            torsion_sd=torsion_sd,
            groups=self.groups,
            center_A=centers[self.group_of],
            center_sd=line_sd,
            tether_A=tether,
            tether_sd=tether_sd,
            least_A=self.least_A,
            floor_A=self.floor_A,
        )

    def _torsions(
        self, clusters_deg: Array | None, suite_sd: float
    ) -> tuple[Index, Array, Array, Array]:
        """Torsions, their number of places, one of these, and how near they are held to it."""
        own = self.site.geometry
        found, fold = [self.torsions], [own.torsion_fold]
        at, sd = [np.deg2rad(own.torsion_deg)], [own.torsion_sd]
        if clusters_deg is not None and (held := np.isfinite(clusters_deg)).any():
            n = int(held.sum())
            found.append(self.suites[held])
            fold.append(np.ones(n))
            at.append(np.deg2rad(clusters_deg[held]))
            sd.append(np.full(n, suite_sd))
        return tuple(np.concatenate(one) for one in (found, fold, at, sd))  # type: ignore[return-value]


def minimum(
    problem: Problem,
    centers: Array,
    line_sd: float,
    start: Array,
    c2_endo: Sequence[bool],
    max_steps: int,
    max_seconds: float,
) -> Relaxed:
    """The minimum next to `start`, its sugars in one of the two usual puckers.

    Where no pucker is given, the loose stages show which of the two is nearer for each sugar. They
    also show which phosphates have turned over, whose free oxygens are put anew, and which cluster
    is nearest to each suite.

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
    c2_endo : sequence of bool
        Pucker of each nucleotide's sugar, else none.
    max_steps, max_seconds : int, float
        Limits of the minimization.

    Returns
    -------
    Relaxed
    """
    site, order = problem.site, problem.order
    limit = time.monotonic() + max_seconds
    whole = np.concatenate([start[order], site.around.positions_A])
    given = _given_puckers(problem, c2_endo)
    restraints = problem.restraints(centers, line_sd, start, given)
    loose = relax(restraints, whole, stages=STAGES[:2], max_seconds=max_seconds)
    whole = np.array(loose.positions_A)
    place = np.empty((len(order), 3))
    place[order] = whole[: len(order)]
    right_phosphates(site, place)
    whole[: len(order)] = place[order]
    phases = np.where(np.isfinite(given), given, _near_puckers(whole, problem.rings))
    clusters, _ = _clusters(problem, whole, phases)
    strict = relax(
        problem.restraints(centers, line_sd, start, phases, clusters),
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
    clusters, _ = _clusters(problem, whole, phases)
    again = relax(
        problem.restraints(centers, LOOSE_LINE_SD_A, there, phases, clusters, stress),
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


def _given_puckers(problem: Problem, c2_endo: Sequence[bool]) -> Array:
    """Phases (s,) of the sugars whose pucker is given, degrees; NaN for others."""
    inside = (problem.ring_of >= 0) & (problem.ring_of < len(c2_endo))
    chosen = np.append(np.array(PUCKERS_DEG)[np.array(c2_endo, dtype=np.int64)], np.nan)
    return np.asarray(chosen[np.where(inside, problem.ring_of, -1)])


def _clusters(
    problem: Problem, positions: Array, phases_deg: Array, besides: Sequence[Collection[int]] = ()
) -> tuple[Array, list[int]]:
    """Torsions (u, 7) that each suite is to have, degrees, and the rows of their clusters.

    Those of the cluster that is nearest, of the puckers that its sugars have or are to have. δ
    follows from these and is left free.
    """
    torsions = suite_torsions(positions, problem.suites)
    held = np.full(torsions.shape, np.nan)
    rows = []
    for suite, (quads, found) in enumerate(zip(problem.suites, torsions, strict=True)):
        for place in (0, 6):
            # the third atom of C5' C4' C3' O3' says which sugar it is
            for ring in np.flatnonzero((problem.rings == quads[place, 2]).any(axis=1)):
                found[place] = DELTA_DEG[int(phases_deg[ring] > 90.0)]
        rows.append(nearest(found, besides[suite] if besides else ()))
        held[suite, 1:6] = MEANS_DEG[rows[-1], 1:6]
    return held, rows


def into_clusters(
    problem: Problem,
    centers: Array,
    relaxed: Relaxed,
    besides: Sequence[set[int]],
    turning: Sequence[bool],
    max_steps: int,
    max_seconds: float,
) -> Relaxed:
    """A minimum some of whose suites are turned into a cluster first.

    The chemistry is loose while they turn.

    Parameters
    ----------
    problem : Problem
        The strand's molecule and what is around.
    centers : (n, 3) array
        Points of the line, Å.
    relaxed : Relaxed
        Another minimum.
    besides : sequence of set of int
        Clusters that each suite has been turned to already; the one that it is turned to now is
        added.
    turning : sequence of bool
        Which of the suites turn; the others are held where they are nearest.
    max_steps, max_seconds : int, float
        Limits of the minimization.

    Returns
    -------
    Relaxed
    """
    order = problem.order
    limit = time.monotonic() + max_seconds
    there = np.array(relaxed.positions_A)
    whole = np.concatenate([there[order], problem.site.around.positions_A])
    phases = _near_puckers(whole, problem.rings)
    clusters, rows = _clusters(problem, whole, phases, besides)
    for suite, (row, out) in enumerate(zip(rows, turning, strict=True)):
        if out:
            besides[suite].add(row)
    loose = problem.restraints(
        centers, TURNING_LINE_SD_A, there, phases, clusters, suite_sd=TURNING_SD
    )
    turned = relax(loose, whole, stages=STAGES[1:2], max_seconds=max_seconds)
    strict = relax(
        problem.restraints(centers, TURNING_LINE_SD_A, there, phases, clusters),
        np.array(turned.positions_A),
        stages=STAGES[2:],
        max_steps=max_steps,
        max_seconds=max(limit - time.monotonic(), 0.0),
    )
    place = np.empty((len(order), 3))
    place[order] = strict.positions_A[: len(order)]
    return Relaxed(place, strict.status, relaxed.steps + turned.steps + strict.steps, strict.cost)


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
    symbols = [atom.GetSymbol() for atom in molecule.mol.GetAtoms()]
    sort = sorts(symbols, molecule.names)[order]
    own = sort[:n_moving, None]
    least, floor = room_A(own, sort, apart)
    outside = NEAREST_A[own, around.sort]
    coordinated = np.where(own == 1, METAL_POLAR_A, METAL_A)
    outside = np.where(around.metal, coordinated, outside)
    # the group of a modified nucleotide is bonded to it in ways that are not known here
    owner = np.array(molecule.residue)[order[:n_moving], None]
    outside[owner == around.owner] = 0.0
    # what is around may itself be nearer to the strand's place than it should
    floors = np.concatenate([floor, np.minimum(outside, FLOOR_A[0, 0])], axis=1)
    return np.concatenate([least, outside], axis=1), floors
