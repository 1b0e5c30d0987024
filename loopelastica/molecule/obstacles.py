"""What a strand must not run into, and how crowded it is where it goes."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.molecule.ends import StemEnds
from loopelastica.molecule.polymer import Gap, HeavyAtoms
from loopelastica.molecule.strand_ends import StrandEnds

HALIDES: Final = ("F", "CL", "BR", "I")
CROWDED_A: Final = 10.0
"""How far from the chord atoms count for how crowded it is."""


def own_atoms(gap: Gap, atoms: HeavyAtoms) -> NDArray[np.bool_]:
    """Which atoms (N,) belong to a strand or to the two nucleotides it lies between.

    Parameters
    ----------
    gap : Gap
        The strand.
    atoms : HeavyAtoms
        Of the model.

    Returns
    -------
    (N,) array of bool
    """
    own = {monomer.label for monomer in (gap.before, *gap.monomers, *gap.replaces, gap.after)}
    rows = [row for row, label in enumerate(atoms.labels) if label in own]
    return np.isin(atoms.residue, rows)


def obstacles(gap: Gap, ends: StrandEnds, atoms: HeavyAtoms) -> NDArray[np.int64]:
    """Rows (m,) of the atoms that stand in a line's way.

    All heavy atoms in its reach, of proteins and ligands too, but for waters and single-atom ions,
    which go elsewhere, and the two nucleotides that the line comes from.

    Parameters
    ----------
    gap : Gap
        The strand.
    ends : StrandEnds
        Ends and length of its line.
    atoms : HeavyAtoms
        Of the model.

    Returns
    -------
    (m,) array of int
    """
    single = np.bincount(atoms.residue, minlength=len(atoms.labels))[atoms.residue] == 1
    ion = single & (atoms.metal | np.isin(atoms.element, HALIDES))
    out = ~(atoms.water | ion | own_atoms(gap, atoms))
    return np.flatnonzero(out & in_reach(ends, atoms.positions_A))


def in_reach(ends: StemEnds | StrandEnds, positions_A: Array) -> NDArray[np.bool_]:
    """Which places (m,) a line between two ends can come within ``CROWDED_A`` of.

    Parameters
    ----------
    ends : StemEnds or StrandEnds
        Ends and length of the line.
    positions_A : (m, 3) array
        Å; what is no number is out of reach.

    Returns
    -------
    (m,) array of bool
    """
    # no point of the line is farther from both ends together than it is long
    both = sum(
        np.linalg.norm(positions_A - end, axis=1)
        for end in (ends.start_origin_A, ends.end_origin_A)
    )
    return np.asarray(both < ends.length_A + 2.0 * CROWDED_A)


def crowding(ends: StrandEnds, positions_A: Array) -> float:
    """Atoms within ``CROWDED_A`` of the chord, per nucleotide.

    Parameters
    ----------
    ends : StrandEnds
        Ends of the line.
    positions_A : (m, 3) array
        What stands in its way, Å.

    Returns
    -------
    float
    """
    chord = ends.end_origin_A - ends.start_origin_A
    from_start = positions_A - ends.start_origin_A
    s = np.clip(from_start @ chord / max(float(chord @ chord), 1e-12), 0.0, 1.0)
    apart = np.linalg.norm(from_start - s[:, None] * chord, axis=1)
    return float((apart < CROWDED_A).sum() / ends.n)
