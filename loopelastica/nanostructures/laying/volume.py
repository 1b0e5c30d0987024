"""Strands clear of helices and of each other: rods of least energy under a soft repulsion.

Here a strand is a discrete rod: its bonds are springs, its hinges bend with the energy
K (1 − cos θ) / b, both ends are clamped to the tangents of their helices, and each nucleotide has a
base on an arm. Backbones, bases and middles of nucleotides repel each other softly out to a little
beyond the excluded volume of the model. Each strand moves downhill by itself (FIRE: Bitzek et al.,
Phys. Rev. Lett. 97 (2006) 170201, doi:10.1103/PhysRevLett.97.170201), all at once, with a step of
its own; so a strand that meets no other one does not depend on them.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.nanostructures.laying.chains import Chains
from loopelastica.nanostructures.laying.ends import unit
from loopelastica.nanostructures.laying.neighbours import Neighbours
from loopelastica.nanostructures.oxdna.energies import nearest_image

Index = NDArray[np.int64]

# oxDNA's units of energy: bending rigidity, of a persistence length near 1 at 300 K; stiffness of
# bonds, of bases across the strand and along their neighbours
_RIGIDITY: Final = 0.1
_SPRING: Final = 60.0
_ACROSS: Final = 0.5
_EVEN: Final = 0.02
# bonds are brought to within these, in so many rounds at most
_SHORT: Final = 0.56
_LONG: Final = 0.99
_PROJECTIONS: Final = 400
# FIRE: first and longest step; steps, also where bases only turn; largest move in one; forces at
# which a strand is at rest
_STEP: Final = 0.08
_LONGEST: Final = 0.13
_STEPS: Final = 500
_TURNING: Final = 40
_MOVE: Final = 0.1
# steps downhill after which they grow
_PATIENCE: Final = 5
# share of strands still moving below which the others are left out
_CROWDED: Final = 0.7
_REST: Final = 0.08


def clear(chains: Chains, which: Index, *, move: bool) -> None:
    """Move strands downhill until nothing repels them or they are at rest.

    Parameters
    ----------
    chains : Chains
        All nucleotides; those of these strands are changed in place.
    which : (k,) array of int
        Single strands.
    move : bool
        Whether strands move; else only their bases turn.
    """
    rows = np.flatnonzero(np.isin(chains.strand, which) & chains.placed)
    if not len(rows):
        return
    descent = _Descent(chains, rows)
    for _ in range(_STEPS if move else _TURNING):
        if not descent.step(move):
            break


class _Descent:
    """Strands on their way downhill; arrays over the strands that still move."""

    def __init__(self, chains: Chains, rows: Index) -> None:
        self.chains, self.rows = chains, rows
        _, self.own = np.unique(chains.strand[rows], return_inverse=True)
        count = int(self.own.max()) + 1
        self.forces = _Forces(chains, rows)
        self.velocity = np.zeros((2, len(rows), 3))
        self.size, self.mix = np.full(count, _STEP), np.full(count, 0.1)
        self.down = np.zeros(count, dtype=np.int64)
        self.going = np.ones(count, dtype=bool)

    def step(self, move: bool) -> bool:
        """Take one step; False if all strands are at rest."""
        force, own, count = self.forces(move), self.own, len(self.going)
        largest = np.zeros(count)
        np.maximum.at(largest, own, np.linalg.norm(force, axis=2).max(axis=0))
        self.going &= largest > _REST
        if not self.going.any():
            return False
        power, speed, pull = (
            np.bincount(own, np.einsum("kij,kij->i", a, b), count)
            for a, b in (
                (force, self.velocity),
                (self.velocity, self.velocity),
                (force, force),
            )
        )
        falling = power > 0
        self.down = np.where(falling, self.down + 1, 0)
        faster = self.down > _PATIENCE
        turn = self.mix * np.sqrt(speed / np.maximum(pull, 1e-300))
        velocity = (1 - self.mix)[own, None] * self.velocity + turn[own, None] * force
        velocity = np.where(falling[own, None], velocity, 0.0)
        grown = np.where(faster, np.minimum(1.1 * self.size, _LONGEST), self.size)
        self.size = np.maximum(np.where(falling, grown, 0.5 * self.size), 0.1 * _STEP)
        self.mix = np.where(falling, np.where(faster, 0.99 * self.mix, self.mix), 0.1)
        self.velocity = velocity + self.size[own, None] * force
        shift = (self.size * self.going)[own, None] * self.velocity
        far = np.linalg.norm(shift, axis=2, keepdims=True)
        self.forces.shift(shift * np.minimum(1.0, _MOVE / np.maximum(far, _MOVE)))
        if np.count_nonzero(self.going) < _CROWDED * count:
            self._drop()
        return True

    def _drop(self) -> None:
        """Leave strands that are at rest where they are, in the way of the others."""
        kept = self.going[self.own]
        self.rows, self.velocity = self.rows[kept], self.velocity[:, kept]
        _, self.own = np.unique(self.own[kept], return_inverse=True)
        self.size, self.mix, self.down = (
            values[self.going] for values in (self.size, self.mix, self.down)
        )
        self.going = self.going[self.going]
        self.forces = _Forces(self.chains, self.rows)


def into_window(chains: Chains, which: Index) -> None:
    """Move nucleotides of strands along their bonds until these are in the model's window.

    A strand squeezed between what repels it can have its bonds drawn too long; they come first.

    Parameters
    ----------
    chains : Chains
        All nucleotides; those of these strands are changed in place.
    which : (k,) array of int
        Single strands.
    """
    rows = np.flatnonzero(np.isin(chains.strand, which) & chains.placed)
    forces = _Forces(chains, rows) if len(rows) else None
    for _ in range(_PROJECTIONS if forces else 0):
        assert forces is not None
        vector, length = forces.bonds()
        wrong = length - np.clip(length, _SHORT, _LONG)
        if not wrong.any():
            return
        first, second = forces.local[forces.first], forces.local[forces.second]
        # each end goes half of the way; all of it where the other one is held
        share = np.where((first >= 0) & (second >= 0), 0.5, 1.0)
        by = (share * wrong / length)[:, None] * vector
        shift = np.zeros((2, len(rows), 3))
        forces.add(shift[0], first, by)
        forces.add(shift[0], second, -by)
        forces.shift(shift)


def bending(chains: Chains) -> Array:
    """Bending energy over rigidity (N,) at laid nucleotides, to be summed over each strand.

    Hinges count as (1 − cos θ) / b at their nucleotides; those at clamps, of half a bond, twice,
    at the nucleotide beside.
    """
    found = np.zeros(len(chains.sites))
    rows = np.flatnonzero((chains.strand >= 0) & chains.placed)
    steps = []
    for neighbour, sign in ((chains.n5, -1.0), (chains.n3, 1.0)):
        near = neighbour[rows]
        known = (near >= 0) & chains.placed[near]
        step = np.zeros((len(rows), 3))
        vector = chains.sites[near[known]] - chains.sites[rows[known]]
        step[known] = sign * nearest_image(vector, chains.box)
        # what begins or ends here has no hinge
        steps.append(unit(step))
        tangent = np.where(known[:, None], chains.tangent[near], 0.0)
        clamped = np.linalg.norm(tangent, axis=1) > 0
        turn = 1 - np.einsum("ij,ij->i", steps[-1], tangent)
        found[rows] += np.where(clamped, 2 * turn / chains.bond[rows], 0.0)
    both = (np.abs(steps[0]).max(axis=1) > 0) & (np.abs(steps[1]).max(axis=1) > 0)
    turn = 1 - np.einsum("ij,ij->i", *steps)
    found[rows] += np.where(both, turn / chains.bond[rows], 0.0)
    return found


class _Forces:
    """Forces on nucleotides that move, and on their directions."""

    def __init__(self, chains: Chains, rows: Index) -> None:
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
        self.neighbours = Neighbours(chains, rows)

    def shift(self, by: Array) -> None:
        sites, direction = self.chains.sites, self.chains.direction
        sites[self.rows] += by[0]
        direction[self.rows] = unit(direction[self.rows] + by[1])

    def __call__(self, move: bool) -> Array:
        chains, rows = self.chains, self.rows
        n = len(rows)
        force = np.zeros((2, n, 3))
        towards = chains.direction[rows]
        self.neighbours.push(force)
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
        along = np.einsum("ij,ij->i", force[1], towards)
        force[1] -= along[:, None] * towards
        return force

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
        sideways = turn - np.einsum("ij,ij->i", turn, direction)[:, None] * direction
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
        tilt = _ACROSS * np.einsum("ij,ij->i", towards[rows], span) * scale**2
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
        inside = index >= 0
        for k in range(3):
            total[:, k] += np.bincount(index[inside], values[inside, k], len(total))
