"""The restraints on the atoms of a site: ideal geometry, and what all attempts at it share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.atoms.geometry import (
    BOND_SD_A,
    FLOOR_A,
    NEAREST_A,
    PLANAR_SD_A3,
    PUCKER_SD_A3,
    SUITE_SD,
    VOLUME_SD_A3,
    everywhere,
    outer_distances,
    ring_quads,
    room_A,
    separations,
    sorts,
)
from loopelastica.atoms.relax import Index, Restraints
from loopelastica.atoms.site import Site
from loopelastica.molecule.nucleotides import BACKBONE

TETHER_SD_A: Final = 2.0
"""How weakly each atom is held to where the line has carried it."""
PIN_SD_A: Final = 0.1
METAL_POLAR_A: Final = 2.05
METAL_A: Final = 2.9
CONTACT_A: Final = 2.9
CONTACT_SD_A: Final = 0.05
"""Hydrogen bonds of a contact that is sought, and how near they are held to it."""


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

    def ordered(self, positions: Array) -> Array:
        """Positions (N, 3) in rows of the molecule as (N + m, 3) in the order of the restraints."""
        return np.concatenate([positions[self.order], self.site.around.positions_A])

    def in_molecule(self, whole: Array) -> Array:
        """The other way round: (N + m, 3) in the order of the restraints as (N, 3)."""
        positions = np.empty((len(self.order), 3))
        positions[self.order] = whole[: len(self.order)]
        return positions

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
    sort = sorts(molecule.symbols, molecule.names)[order]
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
