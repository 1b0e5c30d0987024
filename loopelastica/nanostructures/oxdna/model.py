"""The nucleotide and the helix of oxDNA2: where its sites are, how long its bonds may be.

Sources. [docs]: *Configuration and topology files* in the documentation of the program
(docs/source/configurations.md of lorenzo-rovigatti/oxDNA). [model.h], [generate-sa.py]: src/model.h
and utils/generate-sa.py there. The model is that of Snodin et al., J. Chem. Phys. 142 (2015)
234901, doi:10.1063/1.4921957, which builds on Ouldridge, Louis and Doye, J. Chem. Phys. 134 (2011)
085101, doi:10.1063/1.3552946.

A nucleotide is a rigid body: a centre, ``a1`` from the backbone to the base, ``a3`` normal to the
base, and ``a2 = a3 × a1`` [docs]. In a helix ``a3`` points from the 3' to the 5' neighbour: the
stacking term of the program is strongest where −a3 looks at the 3' neighbour, and generate-sa.py
goes on along ``a3`` while it lists a strand from 3' to 5'.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from loopelastica._arrays import Array

UNIT_NM: Final = 0.8518
"""The unit of length, nm (``LENGTH_FACT`` 8.518 Å of the program's utils/base.py)."""
KELVIN: Final = 1 / 3000
"""One kelvin in units of temperature: 300 K is 0.1 (``Utils::get_temperature``)."""

BACKBONE_A1: Final = -0.34
BACKBONE_A2: Final = 0.3408
"""Backbone site r − 0.34 a1 + 0.3408 a2; off the line of the bases, which makes the grooves of
different width ([docs]; ``POS_MM_BACK1``, ``POS_MM_BACK2`` of [model.h])."""
STACK_A1: Final = 0.34
"""Stacking site r + 0.34 a1 ([docs]; ``POS_STACK``)."""
BASE_A1: Final = 0.4
"""Base site r + 0.4 a1, of hydrogen bonds and the base's volume ([docs]; ``POS_BASE``)."""
REFERENCE_A1: Final = -0.4
"""Backbone of grooves of equal width, r − 0.4 a1; the angles of stacking refer to it
(``POS_BACK``)."""

BOND_LENGTH: Final = 0.7564
"""Length of an unstretched bond between backbone sites (``FENE_R0_OXDNA2``)."""
BOND_DELTA: Final = 0.25
"""The bond's energy is infinite where its length differs by so much (``FENE_DELTA``)."""
BOND_SHORTEST: Final = BOND_LENGTH - BOND_DELTA
BOND_LONGEST: Final = BOND_LENGTH + BOND_DELTA
"""The window of bond lengths, outside of which the program refuses to start
(``check_input_sanity`` of DNAInteraction.cpp)."""

HELIX_RISE: Final = 0.3897628551303122
"""Height of a base pair, 0.332 nm (``BASE_BASE`` of [generate-sa.py])."""
HELIX_TWIST: Final = np.deg2rad(35.9)
"""Turn of a base pair about the axis, right-handed ([generate-sa.py])."""
HELIX_RADIUS: Final = BASE_A1 + 0.2
"""Distance of the centres from the axis: base sites of a pair are 0.4 apart, where their hydrogen
bond is strongest (``CM_CENTER_DS`` of [generate-sa.py]).

These three are for a start. Simulated in LAMMPS at 300 K and 0.5 mol/l (30 pairs, 1.5e5 steps of
0.002) the helix comes to a rise of 0.404 (0.344 nm), a turn of 34.1° (10.54 pairs a turn) and a
radius of 0.599."""


def backbone_sites(centre: ArrayLike, a1: ArrayLike, a3: ArrayLike) -> Array:
    """Backbone sites of nucleotides.

    Parameters
    ----------
    centre, a1, a3 : (..., 3) array-like
        Centres and axes; oxDNA's units.

    Returns
    -------
    (..., 3) array

    Examples
    --------
    >>> backbone_sites([0, 0, 0], [1, 0, 0], [0, 0, 1]).tolist()
    [-0.34, 0.3408, 0.0]
    """
    return np.asarray(centre, dtype=np.float64) + _backbone(a1, a3)


def centre_of(backbone: ArrayLike, a1: ArrayLike, a3: ArrayLike) -> Array:
    """Centres of nucleotides with given backbone sites: the inverse of :func:`backbone_sites`.

    Parameters
    ----------
    backbone, a1, a3 : (..., 3) array-like
        Backbone sites and axes.

    Returns
    -------
    (..., 3) array

    Examples
    --------
    >>> centre_of([-0.34, 0.3408, 0], [1, 0, 0], [0, 0, 1]).tolist()
    [0.0, 0.0, 0.0]
    """
    return np.asarray(backbone, dtype=np.float64) - _backbone(a1, a3)


def stack_sites(centre: ArrayLike, a1: ArrayLike) -> Array:
    """Stacking sites (..., 3) of nucleotides with given centres and first axes (..., 3).

    Examples
    --------
    >>> stack_sites([0, 0, 0], [1, 0, 0]).tolist()
    [0.34, 0.0, 0.0]
    """
    return _along(centre, a1, STACK_A1)


def base_sites(centre: ArrayLike, a1: ArrayLike) -> Array:
    """Base sites (..., 3) of nucleotides with given centres and first axes (..., 3).

    Examples
    --------
    >>> base_sites([0, 0, 0], [1, 0, 0]).tolist()
    [0.4, 0.0, 0.0]
    """
    return _along(centre, a1, BASE_A1)


def _along(centre: ArrayLike, a1: ArrayLike, distance: float) -> Array:
    return np.asarray(centre, dtype=np.float64) + distance * np.asarray(a1, dtype=np.float64)


def _backbone(a1: ArrayLike, a3: ArrayLike) -> Array:
    first = np.asarray(a1, dtype=np.float64)
    return BACKBONE_A1 * first + BACKBONE_A2 * np.cross(np.asarray(a3, dtype=np.float64), first)


def duplex(
    n: int,
    rise: float = HELIX_RISE,
    twist: float = HELIX_TWIST,
    radius: float = HELIX_RADIUS,
) -> tuple[Array, Array, Array]:
    """A straight right-handed duplex on the z axis.

    Parameters
    ----------
    n : int
        Base pairs.
    rise, radius : float, optional
        Height of a pair and distance of the centres from the axis; oxDNA's units.
    twist : float, optional
        Turn of a pair, radians.

    Returns
    -------
    centre, a1, a3 : (2, n, 3) array
        Pair k is at height k · rise: its nucleotide of the strand that runs upwards from 5' to 3',
        and the partner of the other strand, which is antiparallel.

    Examples
    --------
    >>> centre, a1, a3 = duplex(2)
    >>> bond = np.diff(backbone_sites(centre, a1, a3)[0], axis=0)
    >>> round(float(np.linalg.norm(bond)), 4)
    0.7292
    """
    angle = twist * np.arange(n)
    out = np.stack([np.cos(angle), np.sin(angle), np.zeros(n)], axis=-1)
    height = rise * np.arange(n)[:, None] * np.array([0.0, 0.0, 1.0])
    a1 = np.stack([-out, out])
    a3 = np.zeros((2, n, 3))
    a3[:, :, 2] = [[-1.0], [1.0]]
    return height - radius * a1, a1, a3
