"""Rods in their surroundings: between the ends of a hairpin's stem or of any strand.

A rod of least energy under a soft repulsion of the atoms around it and of itself.
"""

from __future__ import annotations

from typing import Final

from loopelastica._arrays import Array
from loopelastica.molecule.ends import StemEnds
from loopelastica.molecule.strand_ends import StrandEnds
from loopelastica.rod.curves import standard_guesses
from loopelastica.rod.surrounded import SurroundedRod, surrounded_rods

SURROUNDED: Final = "rod in its surroundings"
"""What such a line is called in tables."""
CUTOFF_A: Final = 5.0
STIFFNESS: Final = 0.05
"""Repulsion of an atom, in units of the bending rigidity over Å⁴; any cutoff of 4–5 Å will do."""
BENT_FROM: Final = 5
"""Nucleotides from which on bends to all sides are tried: shorter lines have one minimum."""


def rods_among(
    ends: StemEnds | StrandEnds, atoms_A: Array, free_rod: Array | None
) -> tuple[SurroundedRod, ...]:
    """Rods of least energy among atoms, the least first.

    Parameters
    ----------
    ends : StemEnds or StrandEnds
        Where they begin and end.
    atoms_A : (m, 3) array
        What repels them, Å.
    free_rod : (k, 3) array or None
        Points of a rod without surroundings, to begin with, Å.

    Returns
    -------
    tuple of SurroundedRod
        One that did not converge if there is none.
    """
    span = (
        ends.start_origin_A, ends.start_frame[:, 2], ends.end_origin_A, ends.end_frame[:, 2],
        ends.length_A,
    )  # fmt: skip
    return surrounded_rods(
        *span,
        atoms_A,
        guesses=standard_guesses(*span, free_rod=free_rod, bends=ends.n_free >= BENT_FROM),
        cutoff=CUTOFF_A,
        stiffness=STIFFNESS,
        start_frame=ends.start_frame,
    )
