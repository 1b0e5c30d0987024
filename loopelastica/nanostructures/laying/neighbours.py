"""Soft repulsion between nucleotides that move and all others, by lists of what is near."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.nanostructures.laying.bases import MIDDLE, REACH
from loopelastica.nanostructures.laying.cells import beside
from loopelastica.nanostructures.laying.chains import Chains, Index
from loopelastica.nanostructures.oxdna.energies import nearest_image

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

# sites: backbone, base, and beside the centre; how far each is from the backbone site
_SHARES: Final = (0.0, REACH, MIDDLE * REACH)
# Distances below which two kinds of sites repel, and whether those of bonded neighbours do: the
# ranges of the model's excluded volume (0.711, 0.522, 0.335) and a margin. Middles stay well above
# the 0.4 that centres must have.
_REACHES: Final = (
    (0, 0, 0.74, False),
    (0, 1, 0.55, True),
    (1, 0, 0.55, True),
    (1, 1, 0.37, True),
    (2, 2, 0.65, False),
)
# of repulsion, oxDNA's units of energy per squared length
_STIFFNESS: Final = 60.0
# how much further than the distances above neighbours are listed
_SKIN: Final = 0.4
# what is further than this from all that moves at first is not looked at; what comes there is put
# right in the next round
_AROUND: Final = 5.0


class Neighbours:
    """What repels nucleotides that move.

    Parameters
    ----------
    chains : Chains
        All nucleotides.
    rows : (n,) array of int
        Those that move, rising.
    """

    def __init__(self, chains: Chains, rows: Index) -> None:
        self.chains, self.rows = chains, rows
        self.box = chains.box if (chains.box > 0).all() else None
        still = chains.placed.copy()
        still[rows] = False
        if self.box is None:
            still &= beside(chains.sites, chains.sites[rows], _AROUND)
        self.others = np.flatnonzero(still)
        self.still = [
            chains.sites[self.others] + share * chains.direction[self.others] for share in _SHARES
        ]
        self.trees = [self._tree(points) for points in self.still]
        self.listed = np.full((len(_SHARES), len(rows), 3), np.inf)

    def push(self, force: Array) -> None:
        """Add forces on backbone sites and on directions, (2, n, 3)."""
        now = self._moving()
        if self._moved(now) > _SKIN / 2:
            self._list(now)
        n = len(self.rows)
        points = np.concatenate([*now, self.fixed])
        apart = points[self.second] - points[self.first]
        if self.box is not None:
            apart = nearest_image(apart, self.box)
        square = np.einsum("ij,ij->i", apart, apart)
        near = np.flatnonzero(square < self.reach**2)
        if not len(near):
            return
        distance = np.sqrt(np.maximum(square[near], 1e-12))
        push = (_STIFFNESS * (self.reach[near] / distance - 1))[:, None] * apart[near]
        first, second = self.first[near], self.second[near]
        for k in range(3):
            total = np.bincount(second, push[:, k], len(points))
            total -= np.bincount(first, push[:, k], len(points))
            for kind, share in enumerate(_SHARES):
                own = total[kind * n : (kind + 1) * n]
                force[0][:, k] += own
                force[1][:, k] += share * own

    def _moving(self) -> Array:
        sites, direction = self.chains.sites[self.rows], self.chains.direction[self.rows]
        return np.stack([sites + share * direction for share in _SHARES])

    def _moved(self, now: Array) -> float:
        return float(np.linalg.norm(now - self.listed, axis=2).max())

    def _list(self, now: Array) -> None:
        """Note which sites are near each other."""
        n = len(self.rows)
        self.listed = now
        trees = [self._tree(points) for points in now]
        first, second, reach, fixed = [], [], [], [np.zeros((0, 3))]
        used = 3 * n
        for a, b, distance, bonded in _REACHES:
            i, j = self._pairs(trees[a], self.trees[b], distance)
            if not bonded:
                apart = self._apart(i, self.others[j])
                i, j = i[apart], j[apart]
            met, place = np.unique(j, return_inverse=True)
            fixed.append(self.still[b][met])
            first.append(a * n + i)
            second.append(used + place)
            used += len(met)
            reach.append(np.full(len(i), distance))
            # two that move: backbone and base from one side only, which finds both orders
            if a > b:
                continue
            i, j = self._pairs(trees[a], trees[b], distance)
            keep = i < j if a == b else i != j
            if not bonded:
                keep &= self._apart(i, self.rows[j])
            first.append(a * n + i[keep])
            second.append(b * n + j[keep])
            reach.append(np.full(int(keep.sum()), distance))
        self.first, self.second = np.concatenate(first), np.concatenate(second)
        self.reach, self.fixed = np.concatenate(reach), np.concatenate(fixed)

    def _apart(self, i: Index, other: Index) -> NDArray[np.bool_]:
        """Whether nucleotides that move are not bonded to others."""
        own = self.rows[i]
        apart: NDArray[np.bool_] = (self.chains.n3[own] != other) & (self.chains.n5[own] != other)
        return apart

    @staticmethod
    def _pairs(one: cKDTree, other: cKDTree, distance: float) -> tuple[Index, Index]:
        found = one.sparse_distance_matrix(other, distance + _SKIN, output_type="ndarray")
        # one order, whatever the trees: sums are the same to the last bit
        i, j = found["i"].astype(np.int64), found["j"].astype(np.int64)
        order = np.argsort(i * other.n + j)
        return i[order], j[order]

    def _tree(self, points: Array) -> cKDTree:
        from scipy.spatial import cKDTree

        if self.box is not None:
            points = points % self.box
            # a tiny negative number comes out as the side itself
            points = np.where(points >= self.box, 0.0, points)
        return cKDTree(points, boxsize=self.box)
