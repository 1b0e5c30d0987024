"""A design of helices: its system, and what a system does not say, such as axes for pictures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record
from loopelastica.nanostructures.singles import Single
from loopelastica.nanostructures.system import System

NOT_PAIRED = "unpaired domain"
"""What is drawn on a helix and has no partner there; a bulge too."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class HelixAxis(Record):
    """The axis of a helix, from the first to the last base drawn on it; oxDNA's units.

    Attributes
    ----------
    index : int
        The helix's number in the design.
    direction : (3,) array
        Unit vector of rising offsets, which forward strands follow from 5' to 3'.
    begin, end : (3,) array
        The axis beside the bases of least and of greatest offset.
    """

    index: int
    direction: Array
    begin: Array
    end: Array

    def __repr__(self) -> str:
        length = float(np.linalg.norm(self.end - self.begin))
        return f"<HelixAxis {self.index}: {length:.2f} long>"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Design(Record):
    """What a file of helices says.

    Attributes
    ----------
    system : System
        All nucleotides, strand by strand from 5' to 3'. What has a partner is placed on its helix,
        nothing else is.
    axes : tuple of HelixAxis
        Of the helices that something is drawn on.
    helix : (n,) array of int
        Number of the helix that a nucleotide is drawn on; −1 for loopouts and extensions.
    offset : (n,) array of int
        Where on that helix; 0 where there is none.
    drawn : (n,) array of str
        "domain", "loopout" or "extension". Nucleotides of unpaired domains have centre and axes
        where the design draws them, as in a helix, though `placed` is False.
    notes : tuple of str
        What was ignored, filled in, or drawn so that it needs care; sentences.
    """

    system: System
    axes: tuple[HelixAxis, ...]
    helix: NDArray[np.int64]
    offset: NDArray[np.int64]
    drawn: NDArray[np.str_]
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        return f"<Design {self.system.name}: {len(self.system)} nucleotides, {len(self.axes)} axes>"

    def why(self, single: Single) -> str:
        """Why a single strand is single: what the design draws there, from 5' to 3'.

        Parameters
        ----------
        single : Single
            Of this design's system.

        Returns
        -------
        str
            Such as "loopout", "extension", "unpaired domain" or "unpaired domain, loopout".
        """
        kinds = self.drawn[single.nucleotides].tolist()
        changes = [kind for i, kind in enumerate(kinds) if i == 0 or kind != kinds[i - 1]]
        return ", ".join(NOT_PAIRED if kind == "domain" else kind for kind in changes)
