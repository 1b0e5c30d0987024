"""Strands out of helices: what keeps lines from axes, and lets them through all else.

A line that passes between the backbones of a helix is held there by the repulsion of its
nucleotides, from both sides. Spheres about the middles of base pairs push it out by the shorter
way; what it then meets is put right with the rest.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.nanostructures.laying.chains import Chains, Index
from loopelastica.nanostructures.oxdna.periodic import nearest_image, tree_of, wrapped

# radius of spheres: backbone sites of a helix are 1.0 from its axis
_RADIUS: Final = 1.3
# spheres that a site can be in
_MOST: Final = 6
# of repulsion, oxDNA's units of energy per squared length
_STIFFNESS: Final = 20.0


class Cores:
    """What pushes strands out of helices, in the place of :class:`.neighbours.Neighbours`.

    Parameters
    ----------
    chains : Chains
        All nucleotides.
    rows : (n,) array of int
        Those that move.
    """

    def __init__(self, chains: Chains, rows: Index) -> None:
        self.chains, self.rows = chains, rows
        self.tree = tree_of(chains.cores, chains.box)
        self.at, self.line = np.zeros(0, dtype=np.int64), np.zeros((0, 3))

    def push(self, force: Array) -> None:
        """Add forces on backbone sites, (2, n, 3)."""
        sites = self.chains.sites[self.rows]
        distance, which = self.tree.query(
            wrapped(sites, self.chains.box), k=_MOST, distance_upper_bound=_RADIUS
        )
        self.at, column = np.nonzero(np.isfinite(distance))
        away = sites[self.at] - self.chains.cores[which[self.at, column]]
        away = nearest_image(away, self.chains.box)
        far = np.maximum(distance[self.at, column], 1e-6)
        self.line = away / far[:, None]
        np.add.at(force[0], self.at, _STIFFNESS * (_RADIUS - far)[:, None] * self.line)

    def stiffness(self) -> Array:
        """How stiff this is, (2, n, 3, 3): of sites, and nothing of directions."""
        found = np.zeros((2, len(self.rows), 3, 3))
        np.add.at(found[0], self.at, _STIFFNESS * self.line[:, :, None] * self.line[:, None])
        return found
