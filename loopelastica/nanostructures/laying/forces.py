"""Forces on strands that move, and how stiff they are.

Here a strand is a discrete rod: its bonds are springs, its hinges bend with the energy
K (1 − cos θ) / b, both ends are clamped to the tangents of their helices, and each nucleotide has a
base on an arm. What repels it is in :mod:`.neighbours`.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica._vectors import dot, perpendicular, unit
from loopelastica.nanostructures.laying.chains import Chains, Index
from loopelastica.nanostructures.laying.cores import Cores
from loopelastica.nanostructures.laying.neighbours import Neighbours
from loopelastica.nanostructures.oxdna.periodic import nearest_image

# oxDNA's units of energy: bending rigidity, of a persistence length near 1 at 300 K; stiffness of
# bonds, of bases across the strand and along their neighbours
_RIGIDITY: Final = 0.1
_SPRING: Final = 60.0
_ACROSS: Final = 0.5
_EVEN: Final = 0.02


class Forces:
    """Forces on nucleotides that move, and on their directions.

    Parameters
    ----------
    chains : Chains
        All nucleotides.
    rows : (n,) array of int
        Those that move, along their strands.
    repulsion : Neighbours or Cores
        What keeps them away from others.
    """

    def __init__(self, chains: Chains, rows: Index, repulsion: Neighbours | Cores) -> None:
        self.chains, self.rows = chains, rows
        self.local = np.full(len(chains.sites), -1)
        self.local[rows] = np.arange(len(rows))
        n3, n5, local = chains.n3, chains.n5, self.local
        # a bond has a nucleotide that moves at one end or at both
        before = rows[(n5[rows] >= 0)]
        before = n5[before]
        self.first = np.unique(np.concatenate([rows[n3[rows] >= 0], before]))
        self.first = self.first[chains.placed[self.first] & chains.placed[n3[self.first]]]
        self.second = n3[self.first]
        place = np.full(len(local), -1)
        place[self.first] = np.arange(len(self.first))
        self.length = np.where(local[self.first] >= 0, chains.bond[self.first],
                               chains.bond[self.second])  # fmt: skip
        # hinges: bonds before and after a nucleotide that moves
        inner = rows[(n5[rows] >= 0) & (n3[rows] >= 0)]
        inner = inner[(place[n5[inner]] >= 0) & (place[inner] >= 0)]
        self.hinge = place[n5[inner]], place[inner]
        # clamps: the bond after or before a helix
        self.clamp_start = np.flatnonzero(local[self.first] < 0)
        self.clamp_end = np.flatnonzero(local[self.second] < 0)
        self.repulsion = repulsion

    def shift(self, by: Array) -> None:
        """Move backbone sites and directions by (2, n, 3)."""
        sites, direction = self.chains.sites, self.chains.direction
        sites[self.rows] += by[0]
        direction[self.rows] = unit(direction[self.rows] + by[1])

    def __call__(self, move: bool) -> Array:
        """On backbone sites and on directions, (2, n, 3); without `move` on directions only."""
        chains, rows = self.chains, self.rows
        n = len(rows)
        force = np.zeros((2, n, 3))
        towards = chains.direction[rows]
        self.repulsion.push(force)
        vector, length = self.bonds()
        direction = vector / length[:, None]
        if move:
            pull = (_SPRING * (length - self.length))[:, None] * direction
            pull += self._bending(direction, length)
            self.add(force[0], self.local[self.first], pull)
            self.add(force[0], self.local[self.second], -pull)
        self._bases(force, vector, move)
        if not move:
            force[0] = 0.0
        force[1] = perpendicular(force[1], towards)
        return force

    def downhill(self, force: Array, damping: Array, move: bool) -> Array:
        """Where forces (2, n, 3) lead: steps of Newton's method, (2, n, 3).

        The matrix is that of second derivatives without what could make it indefinite: bonds and
        repulsion are stiff along their lines, hinges bend alike to all sides. Neighbours in a
        strand are coupled; sites and directions are not, nor are strands, so that each is solved as
        if it were alone.

        Parameters
        ----------
        force : (2, n, 3) array
            Of this place.
        damping : (n,) array
            What is added to the diagonal.
        move : bool
            Whether sites move.
        """
        n = len(self.rows)
        step = np.zeros((2, n, 3))
        block = self.repulsion.stiffness()
        block += damping[:, None, None] * np.eye(3)
        # directions turn by less than a radian
        block[1] += np.linalg.norm(force[1], axis=1)[:, None, None] * np.eye(3)
        if move:
            step[0] = _solved(*self._line(block[0]), force[0])
        step[1] = _solved(*self._turning(block[1]), force[1])
        return step

    def _line(self, block: Array) -> tuple[Array, Array, Array]:
        """Stiffness of the line: of sites (n, 3, 3), of each with the next, and the one after."""
        n = len(self.rows)
        first, second = self.local[self.first], self.local[self.second]
        vector, length = self.bonds()
        along = vector / length[:, None]
        spring = along[:, :, None] * along[:, None]
        # a stretched bond is stiff to the sides too
        taut = np.maximum(1 - self.length / length, 0.0)[:, None, None]
        spring = _SPRING * (spring + taut * (np.eye(3) - spring))
        bending = (_RIGIDITY / self.length**3)[:, None, None] * np.eye(3)
        clamped = (first < 0) | (second < 0)
        spring_at_ends = spring + np.where(clamped[:, None, None], 2 * bending, 0.0)
        for end in (first, second):
            block[end[end >= 0]] += spring_at_ends[end >= 0]
        beside, beyond = np.zeros((n, 3, 3)), np.zeros(n)
        inner = ~clamped
        beside[first[inner]] -= spring[inner]
        # a hinge's three sites: before, at it, after; what is on a helix stays
        one, two = self.hinge
        sites = first[one], second[one], second[two]
        for site, times in zip(sites, (1, 4, 1), strict=True):
            block[site[site >= 0]] += times * bending[one[site >= 0]]
        for a, b, bond in ((sites[0], sites[1], one), (sites[1], sites[2], two)):
            both = (a >= 0) & (b >= 0)
            beside[a[both]] -= 2 * bending[bond[both]]
        both = (sites[0] >= 0) & (sites[2] >= 0)
        beyond[sites[0][both]] = bending[one[both], 0, 0]
        return block, beside, beyond

    def _turning(self, block: Array) -> tuple[Array, Array, Array]:
        """The same of directions."""
        n, rows = len(self.rows), self.rows
        first, second = self.local[self.first], self.local[self.second]
        span = np.zeros((n, 3))
        vector, _ = self.bonds()
        self.add(span, first, vector)
        self.add(span, second, vector)
        span /= 2 * self.chains.bond[rows][:, None]
        block += _ACROSS * span[:, :, None] * span[:, None]
        for end in (first, second):
            block[end[end >= 0]] += _EVEN * np.eye(3)
        beside = np.zeros((n, 3, 3))
        inner = (first >= 0) & (second >= 0)
        beside[first[inner]] = -_EVEN * np.eye(3)
        return block, beside, np.zeros(n)

    def bonds(self) -> tuple[Array, Array]:
        """Vectors (m, 3) and lengths (m,) of bonds."""
        chains = self.chains
        vector = nearest_image(chains.sites[self.second] - chains.sites[self.first], chains.box)
        return vector, np.maximum(np.linalg.norm(vector, axis=1), 1e-9)

    def _bending(self, direction: Array, length: Array) -> Array:
        """What hinges do to bonds (m, 3): force on the first end, its opposite on the second."""
        turn = np.zeros_like(direction)
        i, j = self.hinge
        # a bond is the first one of a hinge at most, and the second one of another
        turn[i] += direction[j]
        turn[j] += direction[i]
        tangent = self.chains.tangent
        turn[self.clamp_start] += 2 * tangent[self.first[self.clamp_start]]
        turn[self.clamp_end] += 2 * tangent[self.second[self.clamp_end]]
        sideways = perpendicular(turn, direction)
        # the energy falls as the bond turns towards its neighbours
        return np.asarray(-_RIGIDITY * sideways / (self.length * length)[:, None])

    def _bases(self, force: Array, vector: Array, move: bool) -> None:
        """Bases look across the strand and are like their neighbours."""
        chains, rows, local = self.chains, self.rows, self.local
        towards = chains.direction
        for at, other in ((self.first, self.second), (self.second, self.first)):
            inside = local[at] >= 0
            mine = local[at[inside]]
            force[1][mine] += _EVEN * (towards[other[inside]] - towards[at[inside]])
        # the sum of both bonds is the tangent
        span = np.zeros((len(rows), 3))
        self.add(span, local[self.first], vector)
        self.add(span, local[self.second], vector)
        scale = 1 / (2 * chains.bond[rows])
        tilt = _ACROSS * dot(towards[rows], span) * scale**2
        force[1] -= tilt[:, None] * span
        if move:
            pull = tilt[:, None] * towards[rows]
            for ends in (self.first, self.second):
                inside = local[ends] >= 0
                bond = pull[local[ends[inside]]]
                self.add(force[0], local[self.first[inside]], bond)
                self.add(force[0], local[self.second[inside]], -bond)

    @staticmethod
    def add(total: Array, index: Index, values: Array) -> None:
        """Sum values (m, 3) into rows of a total (n, 3); those of index −1 are left out."""
        inside = index >= 0
        for k in range(3):
            total[:, k] += np.bincount(index[inside], values[inside, k], len(total))


def _solved(block: Array, beside: Array, beyond: Array, right: Array) -> Array:
    """Solution (n, 3) of a banded system of n sites.

    Its blocks are those of each site (n, 3, 3), of the next site with it, and a multiple (n,) of
    one for the site after that.
    """
    from scipy.linalg import solveh_banded

    n = len(block)
    # by rows below the diagonal; block (r, c) of the next site is r − c + 3 below it
    band = np.zeros((7, n, 3))
    for r in range(3):
        for c in range(3):
            if r >= c:
                band[r - c, :, c] = block[:, r, c]
            band[r - c + 3, :, c] = beside[:, r, c]
    band[6] = beyond[:, None]
    return np.asarray(
        solveh_banded(
            band.reshape(7, 3 * n), right.reshape(-1), lower=True, overwrite_ab=True,
            check_finite=False,
        ).reshape(n, 3)
    )  # fmt: skip
