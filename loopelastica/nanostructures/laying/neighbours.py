"""Soft repulsion between nucleotides that move and all others, by lists of what is near."""

from __future__ import annotations

from typing import Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica._vectors import dot
from loopelastica.nanostructures.laying.bases import MIDDLE, REACH
from loopelastica.nanostructures.laying.cells import beside
from loopelastica.nanostructures.laying.chains import Chains, Index
from loopelastica.nanostructures.oxdna.periodic import nearest_image, tree_of

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
# nucleotides are listed by their middles first, within the longest distance and what backbones
# stick out
_COARSE: Final = 2
# of repulsion, oxDNA's units of energy per squared length
_STIFFNESS: Final = 60.0
# what is so much further than the distances above counts for stiffness, lest a step go into it
_AHEAD: Final = 0.03
# how much further than the distances above neighbours are listed
_SKIN: Final = 0.6
_FAR: Final = _REACHES[0][2] + _SKIN + 2 * MIDDLE * REACH
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
        Those that move.
    """

    def __init__(self, chains: Chains, rows: Index) -> None:
        self.chains, self.rows = chains, rows
        still = chains.placed.copy()
        still[rows] = False
        if not (chains.box > 0).any():
            still &= beside(chains.sites, chains.sites[rows], _AROUND)
        self.others = np.flatnonzero(still)
        self.still = _sites(chains, self.others)
        self.tree = tree_of(self.still[_COARSE], chains.box)
        self.listed = np.full((len(_SHARES), len(rows), 3), np.inf)

    def push(self, force: Array) -> None:
        """Add forces on backbone sites and on directions, (2, n, 3)."""
        now = _sites(self.chains, self.rows)
        if float(((now - self.listed) ** 2).sum(axis=2).max()) > (_SKIN / 2) ** 2:
            self._list(now)
        points = np.concatenate([now, self.fixed], axis=1).reshape(-1, 3)
        apart = nearest_image(points[self.second] - points[self.first], self.chains.box)
        square = dot(apart, apart)
        near = np.flatnonzero(square < (self.reach + _AHEAD) ** 2)
        distance = np.sqrt(np.maximum(square[near], 1e-12))
        line = apart[near] / distance[:, None]
        self.meeting = self.first[near], self.second[near], line
        push = _STIFFNESS * np.maximum(self.reach[near] - distance, 0.0)[:, None] * line
        for k in range(3):
            total = np.bincount(self.meeting[1], push[:, k], len(points))
            total -= np.bincount(self.meeting[0], push[:, k], len(points))
            own = total.reshape(len(_SHARES), -1)[:, : len(self.rows)]
            force[0][:, k] += own.sum(axis=0)
            force[1][:, k] += np.array(_SHARES) @ own

    def stiffness(self) -> Array:
        """How stiff the repulsion last found is, (2, n, 3, 3): of sites, and of directions.

        Along the line of each two sites only; and twice as much for two that both move, and for
        bases, which move with their sites and with their directions: then what each does by itself
        does not go too far together.
        """
        n, (first, second, line) = len(self.rows), self.meeting
        every = n + self.fixed.shape[1]
        both = second % every < n
        weight = _STIFFNESS * np.where(both, 2.0, 1.0)
        ends = np.concatenate([first, second[both]])
        line, weight = (np.concatenate([part, part[both]]) for part in (line, weight))
        share, own = np.array(_SHARES)[ends // every], ends % every
        weight *= np.where(share > 0, 2.0, 1.0)
        found = np.zeros((2, n, 3, 3))
        for i in range(3):
            for j in range(i + 1):
                product = weight * line[:, i] * line[:, j]
                for kind, scale in enumerate((1.0, share**2)):
                    total = np.bincount(own, product * scale, n)
                    found[kind, :, i, j] = found[kind, :, j, i] = total
        return found

    def _list(self, now: Array) -> None:
        """Note which sites are near each other."""
        n, chains = len(self.rows), self.chains
        self.listed = now
        tree = tree_of(now[_COARSE], chains.box)
        moving = tree.query_pairs(_FAR, output_type="ndarray").astype(np.int64)
        found = tree.sparse_distance_matrix(self.tree, _FAR, output_type="ndarray")
        met, place = np.unique(found["j"], return_inverse=True)
        self.fixed = self.still[:, met]
        points = np.concatenate([now, self.fixed], axis=1)
        names = np.concatenate([self.rows, self.others[met]])
        pairs = np.concatenate([moving @ [len(names), 1], found["i"] * len(names) + n + place])
        # one order, whatever the trees: sums are the same to the last bit
        pairs.sort()
        i, j = np.divmod(pairs, len(names))
        bonded = (chains.n3[names[i]] == names[j]) | (chains.n5[names[i]] == names[j])
        first, second, reach = [], [], []
        for a, b, distance, also_bonded in _REACHES:
            apart = nearest_image(points[b, j] - points[a, i], chains.box)
            near = dot(apart, apart) < (distance + _SKIN) ** 2
            near &= also_bonded | ~bonded
            first.append(a * len(names) + i[near])
            second.append(b * len(names) + j[near])
            reach.append(np.full(len(first[-1]), distance))
        self.first, self.second = np.concatenate(first), np.concatenate(second)
        self.reach = np.concatenate(reach)


def _sites(chains: Chains, rows: Index) -> Array:
    """Backbone, base and middle (3, m, 3) of nucleotides."""
    share = np.array(_SHARES)[:, None, None]
    return np.asarray(chains.sites[rows] + share * chains.direction[rows])
