"""Lengths of the bonds along the backbone, and which of them oxDNA would refuse.

The bond of oxDNA is a spring that must not leave a window (FENE): a start with a bond outside of
it ends the program. Helices of a design stand where its grid puts them, so crossovers without a
nucleotide between two of them are often too long; oxDNA relaxes these with `max_backbone_force`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record
from loopelastica.nanostructure.system import System

# Sites and window of oxDNA2, in its units: src/model.h of the program (POS_MM_BACK1, POS_MM_BACK2,
# FENE_R0_OXDNA2, FENE_DELTA) and docs/source/configurations.md
_BACKBONE_A1: Final = -0.34
_BACKBONE_A2: Final = 0.3408
SHORTEST: Final = 0.7564 - 0.25
"""Shortest bond of oxDNA2, in its units."""
LONGEST: Final = 0.7564 + 0.25
"""Longest bond of oxDNA2, in its units."""


def backbone_sites(centre: Array, a1: Array, a3: Array) -> Array:
    """Sites of the backbone (n, 3) of oxDNA2 from centres and axes, in oxDNA's units."""
    sites: Array = centre + _BACKBONE_A1 * a1 + _BACKBONE_A2 * np.cross(a3, a1)
    return sites


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Bonds(Record):
    """Bonds along the backbone between nucleotides that are both placed.

    Attributes
    ----------
    first, second : (m,) array of int
        Nucleotides on the 5' and on the 3' side.
    length : (m,) array
        Distance of their backbone sites; oxDNA's units.
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    length: Array

    def __len__(self) -> int:
        """Return the number of bonds."""
        return len(self.length)

    def __repr__(self) -> str:
        return f"<Bonds: {len(self)}, {int(self.outside.sum())} outside the window>"

    @property
    def outside(self) -> NDArray[np.bool_]:
        """Which bonds (m,) are outside oxDNA's window, 0.5064 to 1.0064."""
        # written so that NaN is outside
        return ~((self.length > SHORTEST) & (self.length < LONGEST))

    def sentence(self, system: System) -> str:
        """How many bonds are outside the window, and the worst; "" where none is."""
        outside = np.flatnonzero(self.outside)
        if not len(outside):
            return ""
        middle = (SHORTEST + LONGEST) / 2
        worst = outside[np.argmax(abs(self.length[outside] - middle))]
        first, second = self.first[worst], self.second[worst]
        return (
            f"{len(outside)} of {len(self)} bonds are outside oxDNA's window of"
            f" {SHORTEST:.4f} to {LONGEST:.4f}; the worst is {self.length[worst]:.2f}, from"
            f" {system.label[first]} to {system.label[second]} of"
            f" {system.strand_name[system.strand[first]]}"
        )


def bond_lengths(system: System) -> Bonds:
    """Lengths of all bonds between nucleotides that are both placed.

    Parameters
    ----------
    system : System
        Positions as they are: the images of a periodic box are not taken together.

    Returns
    -------
    Bonds
    """
    first = np.flatnonzero((system.n3 >= 0) & system.placed & system.placed[system.n3])
    second = system.n3[first]
    sites = backbone_sites(system.centre, system.a1, system.a3)
    return Bonds(first, second, np.linalg.norm(sites[second] - sites[first], axis=1))
