"""Base pairs by their hydrogen bonds, and the helices that pairs stack up to."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica._vectors import dot
from loopelastica.nanostructures.oxdna.energies import (
    base_numbers,
    hydrogen_bonds,
)
from loopelastica.nanostructures.oxdna.model import HELIX_RISE
from loopelastica.nanostructures.oxdna.periodic import nearest_image
from loopelastica.nanostructures.system import System

Index = NDArray[np.int64]

BOND_ENERGY: Final = -0.1
"""Two bases are a pair where the energy of their hydrogen bond is below this; a perfect one has
about −1. It is the criterion of the program (``HB_CUTOFF`` of OrderParameters.h in
lorenzo-rovigatti/oxDNA, by which its observable hb_list lists them), in its unit of energy."""

# Pairs stack where their middles are within two rises and their normals within 45 degrees. A step
# to another helix is longer than 2 and a base that is skipped leaves two rises.
_STEP: Final = 2 * HELIX_RISE
_COSINE: Final = np.sqrt(0.5)


def find_pairs(system: System, any_bases: bool = False) -> Index:
    """Partner of each nucleotide by the hydrogen bonds of the model.

    Bases pair where they are complementary, are no neighbours in a strand and have a hydrogen bond
    below :data:`BOND_ENERGY`. Of several partners a base has the one of least energy.

    Parameters
    ----------
    system : System
        Nucleotides; those without a place stay without a partner.
    any_bases : bool, optional
        Pair by geometry alone, as if all bases were complementary: for designs without sequences.

    Returns
    -------
    (n,) array of int
        −1 where there is none.
    """
    bonds = hydrogen_bonds(system, any_bases)
    pair = np.full(len(system), -1, dtype=np.int64)
    strong = np.flatnonzero(bonds.energy < BOND_ENERGY)
    order = strong[np.argsort(bonds.energy[strong], kind="stable")]
    for i, j in zip(bonds.first[order].tolist(), bonds.second[order].tolist(), strict=True):
        if pair[i] < 0 and pair[j] < 0:
            pair[i], pair[j] = j, i
    return pair


def are_bases_given(bases: NDArray[np.str_]) -> bool:
    """Whether any two of these bases can pair.

    Of a design without sequences exporters write one base for all, and no pair of its helices has
    an energy then.

    Examples
    --------
    >>> are_bases_given(np.array(["T", "T", "A"])), are_bases_given(np.array(["T", "T"]))
    (True, False)
    """
    number = base_numbers(bases)
    return bool(np.isin(3 - number, number).any())


def find_helices(system: System) -> list[Index]:
    """Helices: base pairs, each stacked on the next.

    A helix goes on where one of its strands does and the next pair lies on this one: a nick of the
    other strand does not end it, a crossover does.

    Parameters
    ----------
    system : System
        Nucleotides with their partners.

    Returns
    -------
    list of (k, 2) array of int
        The pairs of each helix in order: the first column runs from 5' to 3', the second is the
        partners. Ordered by their least nucleotide, which is in the first column.
    """
    pair = system.pair
    following = _following(system)
    seen = np.zeros(len(system), dtype=bool)
    found = []
    paired = np.flatnonzero(pair >= 0)
    before = np.full(len(system), -1, dtype=np.int64)
    before[following[following >= 0]] = np.flatnonzero(following >= 0)
    # rings have no first pair: they come last, begun anywhere
    for start in [*paired[before[paired] < 0].tolist(), *paired.tolist()]:
        if seen[start]:
            continue
        strand = []
        i = start
        while i >= 0 and not seen[i]:
            strand.append(i)
            seen[[i, pair[i]]] = True
            i = int(following[i])
        one = np.array(strand, dtype=np.int64)
        helix = np.stack([one, pair[one]], axis=1)
        found.append(helix if one.min() < pair[one].min() else helix[::-1, ::-1])
    return sorted(found, key=lambda helix: int(helix.min()))


def _following(system: System) -> Index:
    """Nucleotide after each paired one on its side of the helix, −1 where the helix ends."""
    pair, n3, n5 = system.pair, system.n3, system.n5
    following = np.full(len(system), -1, dtype=np.int64)
    # by the partner's strand first, so that the nucleotide's own has the last word
    i = np.flatnonzero(pair >= 0)
    i = i[n5[pair[i]] >= 0]
    i = i[pair[n5[pair[i]]] >= 0]
    _join(system, following, i, pair[n5[pair[i]]])
    i = np.flatnonzero((pair >= 0) & (n3 >= 0))
    i = i[pair[n3[i]] >= 0]
    _join(system, following, i, n3[i])
    # the same step must be seen from the other side, or helices would fork
    i = np.flatnonzero(following >= 0)
    back = following[pair[following[i]]]
    following[i[back != pair[i]]] = -1
    return following


def _join(system: System, following: Index, i: Index, j: Index) -> None:
    """Note j as following i where the pair of j is stacked on that of i and is another one."""
    step = nearest_image(_middle(system, j) - _middle(system, i), system.box)
    normals = dot(system.a3[i], system.a3[j])
    stacked = (np.linalg.norm(step, axis=1) < _STEP) & (normals > _COSINE) & (system.pair[i] != j)
    following[i[stacked]] = j[stacked]


def _middle(system: System, i: Index) -> Array:
    """Middle of the pair of each nucleotide."""
    across = system.centre[system.pair[i]] - system.centre[i]
    return system.centre[i] + 0.5 * nearest_image(across, system.box)
