"""All energies of the oxDNA2 model of DNA: of bonds, and of nucleotides that are near each other.

The terms are those of DNAInteraction.cpp and DNA2Interaction.cpp of lorenzo-rovigatti/oxDNA with
parameters that are averages over sequences; angles have the numbers that they have there. They
serve to find base pairs and to check what is written; forces are not needed. Strands of RNA are
taken for DNA.

Neighbours come from a k-d tree over sites, so that a design of 10⁵ nucleotides takes seconds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record
from loopelastica._checks import positive
from loopelastica._vectors import dot
from loopelastica.nanostructures.oxdna import potentials as f
from loopelastica.nanostructures.oxdna.model import (
    BOND_DELTA,
    BOND_LENGTH,
    KELVIN,
    REFERENCE_A1,
    backbone_sites,
    base_sites,
    stack_sites,
)
from loopelastica.nanostructures.oxdna.periodic import nearest_image, tree_of
from loopelastica.nanostructures.system import System

Index = NDArray[np.int64]

ROOM_K: Final = 300.0
SALT_M: Final = 0.5
_LETTERS: Final = {"A": 0, "G": 1, "C": 2, "T": 3, "U": 3}
# the dummy base of the program: complementary to nothing
_DUMMY: Final = 1 << 40


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Bonds(Record):
    """Energies of the m bonds of a system; oxDNA's units.

    Attributes
    ----------
    first, second : (m,) array of int
        A nucleotide and its 3' neighbour.
    length : (m,) array
        Distance of their backbone sites.
    backbone : (m,) array
        FENE energy; infinite outside of the window of lengths.
    excluded_volume, stacking : (m,) array
        The other two terms.
    """

    first: Index
    second: Index
    length: Array
    backbone: Array
    excluded_volume: Array
    stacking: Array


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Contacts(Record):
    """One energy of pairs of nucleotides that are not bonded; those of zero are left out.

    Attributes
    ----------
    first, second : (m,) array of int
        Nucleotides; a pair has one row, but one for each two sites in `excluded_volume`.
    energy : (m,) array
        oxDNA's units.
    """

    first: Index
    second: Index
    energy: Array


def base_numbers(base: NDArray[np.str_]) -> Index:
    """The program's numbers of bases; two that add up to 3 can pair.

    Parameters
    ----------
    base : (n,) array of str
        As in :class:`System`.

    Returns
    -------
    (n,) array of int

    Examples
    --------
    >>> base_numbers(np.array(["A", "G", "C", "T", "U", "13", "-10"])).tolist()
    [0, 1, 2, 3, 3, 13, -10]
    """
    names, which = np.unique(base, return_inverse=True)
    numbers = [
        _DUMMY if name == "D" else _LETTERS[name] if name in _LETTERS else int(name)
        for name in names.tolist()
    ]
    return np.array(numbers, dtype=np.int64)[which]


def separation(system: System, start: Array, end: Array) -> Array:
    """Vectors (m, 3) from points to points (m, 3), of the nearest periodic images."""
    return nearest_image(end - start, system.box)


def bonds(system: System, temperature_K: float = ROOM_K) -> Bonds:
    """Energies of all bonds between nucleotides that have a place.

    Parameters
    ----------
    system : System
        The nucleotides.
    temperature_K : float, optional
        Of which the depth of stacking depends.

    Returns
    -------
    Bonds
    """
    temperature = positive("temperature_K", temperature_K) * KELVIN
    ends = system.placed & (system.n3 >= 0)
    ends[ends] = system.placed[system.n3[ends]]
    i = np.flatnonzero(ends)
    j = system.n3[i]
    near = _Near.of(system, i, j)
    back, base = near.vectors(backbone_sites(system.centre, system.a1, system.a3)), near.base
    a2, b2 = system.a2[i], system.a2[j]

    length = np.linalg.norm(back, axis=-1)
    strain = ((length - BOND_LENGTH) / BOND_DELTA) ** 2
    inside = strain < 1
    fene = np.full(len(i), np.inf)
    fene[inside] = -f.FENE_STRENGTH / 2 * np.log1p(-strain[inside])

    sites = backbone_sites(system.centre, system.a1, system.a3), near.base_site
    volume = f.BASE_BASE(np.linalg.norm(base, axis=-1))
    for start, end in ((sites[1][i], sites[0][j]), (sites[0][i], sites[1][j])):
        volume += f.BACKBONE_BASE(np.linalg.norm(separation(system, start, end), axis=-1))

    distance, direction = _polar(near.vectors(stack_sites(system.centre, system.a1)))
    _, reference = _polar(near.vectors(system.centre + REFERENCE_A1 * system.a1))
    depth = f.STACKING_DEPTH[0] + f.STACKING_DEPTH[1] * temperature
    stacking = (
        depth
        * f.STACKING(distance)
        * f.STACKING_4(dot(near.a3, near.b3))
        * f.STACKING_5_6(-dot(near.a3, direction))
        * f.STACKING_5_6(-dot(near.b3, direction))
        * f.STACKING_SIDE(dot(a2, reference))
        * f.STACKING_SIDE(dot(b2, reference))
    )
    return Bonds(i, j, length, fene, volume, stacking)


def hydrogen_bonds(system: System, any_bases: bool = False) -> Contacts:
    """Hydrogen bonds between complementary bases.

    Parameters
    ----------
    system : System
        The nucleotides; those without a place are left out.
    any_bases : bool, optional
        Take all bases for complementary: what is left is the geometry.

    Returns
    -------
    Contacts
    """
    i, j = close_sites(system, base_sites(system.centre, system.a1), f.HYDROGEN.range)
    number = base_numbers(system.base)
    fits = (number[i] + number[j] == 3) | any_bases
    return _contacts(system, i[fits], j[fits], _hydrogen)


def cross_stacking(system: System) -> Contacts:
    """Stacking across a helix, of a base on the neighbour of its partner; see hydrogen_bonds."""
    i, j = close_sites(system, base_sites(system.centre, system.a1), f.CROSS.range)
    return _contacts(system, i, j, _cross)


def coaxial_stacking(system: System) -> Contacts:
    """Stacking of nucleotides that are not bonded; see hydrogen_bonds."""
    i, j = close_sites(system, stack_sites(system.centre, system.a1), f.COAXIAL.range)
    return _contacts(system, i, j, _coaxial)


def excluded_volume(system: System) -> Contacts:
    """Repulsion of backbone and base sites; a row for each two sites; see hydrogen_bonds."""
    n = len(system)
    backbone = backbone_sites(system.centre, system.a1, system.a3)
    sites = np.concatenate([backbone, base_sites(system.centre, system.a1)])
    i, j = close_sites(system, sites, f.BACKBONE_BACKBONE.range)
    distance = np.linalg.norm(separation(system, sites[i], sites[j]), axis=-1)
    bases = (i >= n).astype(int) + (j >= n)
    energy = np.choose(
        bases, [f.BACKBONE_BACKBONE(distance), f.BACKBONE_BASE(distance), f.BASE_BASE(distance)]
    )
    return _kept(i % n, j % n, energy)


def electrostatics(
    system: System,
    temperature_K: float = ROOM_K,
    salt_M: float = SALT_M,
    half_charged_ends: bool = True,
) -> Contacts:
    """Debye–Hückel repulsion of backbone sites.

    Parameters
    ----------
    system : System
        The nucleotides; those without a place are left out.
    temperature_K, salt_M : float, optional
        Temperature, and concentration of a salt of single charges in mol/l.
    half_charged_ends : bool, optional
        Whether the first and the last nucleotide of a strand have half the charge; the program's
        default.

    Returns
    -------
    Contacts
    """
    screened = f.Screened.of(
        positive("temperature_K", temperature_K) * KELVIN, positive("salt_M", salt_M)
    )
    sites = backbone_sites(system.centre, system.a1, system.a3)
    i, j = close_sites(system, sites, screened.range)
    energy = screened(np.linalg.norm(separation(system, sites[i], sites[j]), axis=-1))
    if half_charged_ends:
        charge = np.where((system.n3 < 0) | (system.n5 < 0), 0.5, 1.0)
        energy = energy * charge[i] * charge[j]
    return _kept(i, j, energy)


def energies(
    system: System, temperature_K: float = ROOM_K, salt_M: float = SALT_M
) -> dict[str, float]:
    """Each energy of a system, summed; oxDNA's unit, 4.142e-20 J.

    Parameters
    ----------
    system : System
        The nucleotides; those without a place are left out.
    temperature_K, salt_M : float, optional
        Temperature, and concentration of salt in mol/l.

    Returns
    -------
    dict of str to float
        By the program's names of terms. ``backbone`` is infinite where a bond is out of the window.
    """
    bonded = bonds(system, temperature_K)
    others = {
        "nonbonded_excluded_volume": excluded_volume(system),
        "hydrogen_bonding": hydrogen_bonds(system),
        "cross_stacking": cross_stacking(system),
        "coaxial_stacking": coaxial_stacking(system),
        "debye_huckel": electrostatics(system, temperature_K, salt_M),
    }
    return {
        "backbone": float(bonded.backbone.sum()),
        "bonded_excluded_volume": float(bonded.excluded_volume.sum()),
        "stacking": float(bonded.stacking.sum()),
        **{name: float(contacts.energy.sum()) for name, contacts in others.items()},
    }


@dataclass(frozen=True, slots=True)
class _Near:
    """Pairs of nucleotides and their axes: a of the first, b of the second."""

    system: System
    i: Index
    j: Index
    base_site: Array
    a1: Array
    a3: Array
    b1: Array
    b3: Array

    @classmethod
    def of(cls, system: System, i: Index, j: Index) -> _Near:
        base = base_sites(system.centre, system.a1)
        return cls(system, i, j, base, system.a1[i], system.a3[i], system.a1[j], system.a3[j])

    def vectors(self, sites: Array) -> Array:
        """From the first nucleotide's site to the second's (m, 3)."""
        return separation(self.system, sites[self.i], sites[self.j])

    @property
    def base(self) -> Array:
        return self.vectors(self.base_site)


def _hydrogen(near: _Near) -> Array:
    distance, direction = _polar(near.base)
    return (
        f.HYDROGEN_DEPTH
        * f.HYDROGEN(distance)
        * f.HYDROGEN_1_2_3(-dot(near.a1, near.b1))
        * f.HYDROGEN_1_2_3(-dot(near.b1, direction))
        * f.HYDROGEN_1_2_3(dot(near.a1, direction))
        * f.HYDROGEN_4(dot(near.a3, near.b3))
        * f.HYDROGEN_7_8(-dot(near.b3, direction))
        * f.HYDROGEN_7_8(dot(near.a3, direction))
    )


def _cross(near: _Near) -> Array:
    distance, direction = _polar(near.base)
    return (
        f.CROSS(distance)
        * f.CROSS_1(-dot(near.a1, near.b1))
        * f.CROSS_2_3(-dot(near.b1, direction))
        * f.CROSS_2_3(dot(near.a1, direction))
        * f.CROSS_4.both(dot(near.a3, near.b3))
        * f.CROSS_7_8.both(-dot(near.b3, direction))
        * f.CROSS_7_8.both(dot(near.a3, direction))
    )


def _coaxial(near: _Near) -> Array:
    stack = near.vectors(stack_sites(near.system.centre, near.system.a1))
    distance, direction = _polar(stack)
    theta1 = np.arccos(np.clip(-dot(near.a1, near.b1), -1.0, 1.0))
    strength, from_angle = f.COAXIAL_TURNED
    turned = strength * np.maximum(theta1 - from_angle, 0.0) ** 2
    return (
        f.COAXIAL(distance)
        * (f.COAXIAL_1.at(theta1) + turned)
        * f.COAXIAL_4(dot(near.a3, near.b3))
        * f.COAXIAL_5_6.both(dot(near.a3, direction))
        * f.COAXIAL_5_6.both(dot(near.b3, direction))
    )


def _contacts(system: System, i: Index, j: Index, energy: Callable[[_Near], Array]) -> Contacts:
    return _kept(i, j, energy(_Near.of(system, i, j)))


def _kept(i: Index, j: Index, energy: Array) -> Contacts:
    some = energy != 0
    return Contacts(i[some], j[some], energy[some])


def close_sites(system: System, sites: Array, distance: float) -> tuple[Index, Index]:
    """Two sites each that are nearer than a distance and not of one nucleotide or of neighbours.

    Parameters
    ----------
    system : System
        n nucleotides; those without a place are left out.
    sites : (m, 3) array
        Sites of each nucleotide in order, once or several times.
    distance : float
        Between the nearest periodic images; oxDNA's units.

    Returns
    -------
    first, second : (k,) array of int
        Rows of `sites`.
    """
    n = len(system)
    placed = np.flatnonzero(np.tile(system.placed, len(sites) // max(n, 1)))
    near = tree_of(sites[placed], system.box).query_pairs(distance, output_type="ndarray")
    i, j = placed[near[:, 0]], placed[near[:, 1]]
    p, q = i % n, j % n
    apart = (p != q) & (system.n3[p] != q) & (system.n5[p] != q)
    return i[apart], j[apart]


def _polar(vector: Array) -> tuple[Array, Array]:
    """Length (m,) and direction (m, 3)."""
    length = np.linalg.norm(vector, axis=-1)
    return length, vector / np.maximum(length, 1e-12)[:, None]
