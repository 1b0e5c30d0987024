"""Strands clear of helices and of each other: rods of least energy under a soft repulsion.

The rod of :mod:`.forces` moves downhill by damped steps of Newton's method, each strand by itself
and all at once. A strand's damping is its own and grows where a step has gone too far; so a strand
that meets no other one does not depend on them.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica._vectors import dot, unit
from loopelastica.nanostructures.laying.chains import Chains
from loopelastica.nanostructures.laying.cores import Cores
from loopelastica.nanostructures.laying.forces import Forces
from loopelastica.nanostructures.laying.neighbours import Neighbours
from loopelastica.nanostructures.oxdna.periodic import nearest_image

Index = NDArray[np.int64]

# bonds are brought to within these, in so many rounds at most
_SHORT: Final = 0.56
_LONG: Final = 0.99
_PROJECTIONS: Final = 400
# steps, also where bases only turn; largest move in one; forces at which a strand is at rest
_STEPS: Final = 200
_TURNING: Final = 20
_MOVE: Final = 0.35
_REST: Final = 0.15
# damping: at first, after a step that went too far or not, and bounds
_DAMPING: Final = 0.3
_TOO_FAR: Final = 0.3
_HARDER: Final = 3.0
_SOFTER: Final = 0.4
_LEAST: Final = 0.1
_MOST: Final = 60.0
# share of strands still moving below which the others are left out
_CROWDED: Final = 0.7


def clear(
    chains: Chains,
    which: Index,
    *,
    move: bool,
    repulsion: type[Neighbours] | type[Cores] = Neighbours,
) -> None:
    """Move strands downhill until nothing repels them or they are at rest.

    Parameters
    ----------
    chains : Chains
        All nucleotides; those of these strands are changed in place.
    which : (k,) array of int
        Single strands.
    move : bool
        Whether strands move; else only their bases turn.
    repulsion : type, optional
        Of what is in their way: all other nucleotides, or the cores of helices alone.
    """
    rows = _rows(chains, which)
    if not len(rows):
        return
    descent = _Descent(chains, rows, repulsion)
    for _ in range(_STEPS if move else _TURNING):
        if not descent.step(move):
            break


class _Descent:
    """Strands on their way downhill; arrays over the strands that still move."""

    def __init__(
        self, chains: Chains, rows: Index, repulsion: type[Neighbours] | type[Cores]
    ) -> None:
        self.chains, self.rows, self.repulsion = chains, rows, repulsion
        self.damping = np.full(int(chains.strand.max()) + 1, _DAMPING)
        self._begin()

    def _begin(self) -> None:
        self.numbers, self.own = np.unique(self.chains.strand[self.rows], return_inverse=True)
        self.going = np.ones(len(self.numbers), dtype=bool)
        self.forces = Forces(self.chains, self.rows, self.repulsion(self.chains, self.rows))
        self.last = np.zeros((2, len(self.rows), 3))
        self.gain = np.zeros(len(self.going))

    def step(self, move: bool) -> bool:
        """Take one step; False if all strands are at rest."""
        force, own, count = self.forces(move), self.own, len(self.going)
        self.going &= np.maximum(*map(self._largest, force)) > _REST
        if not self.going.any():
            return False
        # a step that went too far is met by forces against it
        power = self._power(force)
        scale = np.where(power < -_TOO_FAR * self.gain, _HARDER, _SOFTER)
        damping = np.clip(scale * self.damping[self.numbers], _LEAST, _MOST)
        self.damping[self.numbers] = damping
        step = self.forces.downhill(force, damping[own], move)
        for kind in step:
            far = self._largest(kind)
            kind *= (self.going * np.minimum(1.0, _MOVE / np.maximum(far, _MOVE)))[own, None]
        self.last = step
        self.gain = self._power(force)
        self.forces.shift(step)
        if np.count_nonzero(self.going) < _CROWDED * count:
            # strands at rest stay where they are, in the way of the others
            self.rows = self.rows[self.going[own]]
            self._begin()
        return True

    def _power(self, force: Array) -> Array:
        """Work of forces (2, n, 3) over the last step of each strand."""
        work = np.einsum("kij,kij->i", force, self.last)
        return np.asarray(np.bincount(self.own, work, len(self.going)), dtype=np.float64)

    def _largest(self, vector: Array) -> Array:
        """Greatest length of vectors (n, 3) on each strand."""
        found = np.zeros(len(self.going))
        np.maximum.at(found, self.own, np.linalg.norm(vector, axis=1))
        return found


def _rows(chains: Chains, which: Index) -> Index:
    """Nucleotides of strands, along them."""
    order = chains.order
    return order[np.isin(chains.strand[order], which) & chains.placed[order]]


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
    rows = _rows(chains, which)
    forces = Forces(chains, rows, Cores(chains, rows)) if len(rows) else None
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
        turn = 1 - dot(steps[-1], tangent)
        found[rows] += np.where(clamped, 2 * turn / chains.bond[rows], 0.0)
    both = (np.abs(steps[0]).max(axis=1) > 0) & (np.abs(steps[1]).max(axis=1) > 0)
    turn = 1 - dot(*steps)
    found[rows] += np.where(both, turn / chains.bond[rows], 0.0)
    return found
