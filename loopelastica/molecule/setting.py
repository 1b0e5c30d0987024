"""What a loop is seen in: its stem, its own nucleotides and the chains near it, for pictures.

>>> from loopelastica._files import data_path
>>> from loopelastica.molecule.hairpins import find_hairpins
>>> from loopelastica.molecule.nucleotides import read_structure
>>> structure = read_structure(data_path("hairpins/2koc.pdb"))
>>> setting = Settings(structure).of(find_hairpins(structure)[0])
>>> setting.names_5, setting.names_3, len(setting.neighbours)
(('G1', 'G2', 'C3', 'A4', 'C5'), ('G10', 'U11', 'G12', 'C13', 'C14'), 0)
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from loopelastica._arrays import Array, Record, read_only
from loopelastica.molecule._recognition import chains_of, strings
from loopelastica.molecule.hairpins import Hairpin
from loopelastica.molecule.neighbours import solid
from loopelastica.molecule.nucleotides import Nucleotides, Structure, centroids_at

MAX_PAIRS: Final = 6
"""Pairs of the stem that are shown, from the closing one outwards."""

NEAR_A: Final = 12.0
"""How near to the loop a residue is shown."""

_BOND_A: Final = 2.0
"""Longest bond between heavy atoms of a nucleotide or of two joined ones; the longest has 1.9 Å."""

_STEP_A: Final = 9.0
"""Longest step along a chain: 7 Å between centroids of nucleotides, 4 Å between CA atoms."""


@dataclass(frozen=True, slots=True, eq=False)
class Chain(Record):
    """A stretch of a chain near the loop.

    Attributes
    ----------
    labels : tuple of str
        Its residues, such as "A.G12" or "B.LYS7".
    points_A : (n, 3) array
        Centroids of backbones of nucleotides, CA atoms of amino acids, Å.
    """

    labels: tuple[str, ...]
    points_A: Array


@dataclass(frozen=True, slots=True, eq=False)
class Setting(Record):
    """What a loop is seen in, in one model; coordinates of the file, Å.

    Attributes
    ----------
    names_5, names_3 : tuple of str
        Nucleotides of the two strands of the stem that are shown, such as "C5", in the order of the
        chain: the closing ones are ``names_5[-1]`` and ``names_3[0]``, and ``names_5[-1 - k]``
        pairs ``names_3[k]``.
    strand_5_A, strand_3_A : (k, 3) array
        Centroids of their backbones (P O5' C5' C4' C3' O3', as far as they are there).
    names : tuple of str
        Nucleotides of the loop, such as "U6".
    stem_bonds_A : (m, 2, 3) array
        Both ends of the bonds between heavy atoms of the stem.
    loop_bonds_A : (m, 2, 3) array
        The same of the file's own loop and where it joins the stem; empty where it has none.
    neighbours : tuple of Chain
        What else is near.
    """

    names_5: tuple[str, ...]
    names_3: tuple[str, ...]
    strand_5_A: Array
    strand_3_A: Array
    names: tuple[str, ...]
    stem_bonds_A: Array
    loop_bonds_A: Array
    neighbours: tuple[Chain, ...]


class Settings:
    """What all settings in one model of a structure share.

    Parameters
    ----------
    structure : Structure
        What was read.
    positions : (n_atoms, 3) array, optional
        All atoms of one model, Å; by default those of the first.
    """

    def __init__(self, structure: Structure, positions: Array | None = None) -> None:
        self._structure = structure
        self._given = positions

    def of(self, hairpin: Hairpin, near_A: Array | None = None) -> Setting:
        """The setting of one loop.

        Parameters
        ----------
        hairpin : Hairpin
            One of the structure's.
        near_A : (n, 3) array, optional
            Points whose neighbours are shown too, such as those of a candidate's line, Å.

        Returns
        -------
        Setting
        """
        nucleotides = self._structure.nucleotides
        stem_5 = hairpin.stem_5[:MAX_PAIRS][::-1]
        stem_3 = hairpin.stem_3[:MAX_PAIRS]
        loop = hairpin.loop[hairpin.loop >= 0]
        stem_bonds, loop_bonds = self._bonds(stem_5, loop, stem_3)
        shown = np.concatenate([stem_5, loop, stem_3])
        points = [self._centroids(shown)] if near_A is None else [self._centroids(shown), near_A]
        return Setting(
            names_5=_names(nucleotides, stem_5),
            names_3=_names(nucleotides, stem_3),
            strand_5_A=self._centroids(stem_5),
            strand_3_A=self._centroids(stem_3),
            names=tuple(
                f"{letter}{number}{code}"
                for letter, number, code in zip(
                    hairpin.sequence[1:-1], hairpin.resid, hairpin.icode, strict=True
                )
            ),
            stem_bonds_A=stem_bonds,
            loop_bonds_A=loop_bonds,
            neighbours=self._neighbours(
                np.concatenate([hairpin.stem_5, loop, hairpin.stem_3]), np.concatenate(points)
            ),
        )

    @cached_property
    def _positions(self) -> Array:
        # read for the first loop: a structure without loops needs none
        return self._structure.positions(0) if self._given is None else self._given

    def _centroids(self, rows: NDArray[np.int64]) -> Array:
        return _mean(self._structure.nucleotides, self._positions, rows)

    def _bonds(
        self, stem_5: NDArray[np.int64], loop: NDArray[np.int64], stem_3: NDArray[np.int64]
    ) -> tuple[Array, Array]:
        """Bonds of the stem, and of the loop with its junctions."""
        rows = np.concatenate([stem_5, loop, stem_3])
        index = self._structure.nucleotides.atom_index[rows]
        atoms = self._positions[index]
        known = (index >= 0) & np.isfinite(atoms).all(axis=2)
        atoms_A = atoms[known]
        place = np.repeat(np.arange(len(rows)), known.sum(axis=1))
        pairs = KDTree(atoms_A).query_pairs(_BOND_A, output_type="ndarray")
        # neighbours along the chain only: the strands of a stem are not bonded
        pairs = pairs[np.abs(np.diff(place[pairs], axis=1)).ravel() <= 1]
        inside = (place >= len(stem_5)) & (place < len(stem_5) + len(loop))
        of_loop = inside[pairs].any(axis=1)
        if not len(loop):
            # the closing nucleotides are no neighbours
            joint = (place[pairs] == [len(stem_5) - 1, len(stem_5)]).all(axis=1)
            pairs, of_loop = pairs[~joint], of_loop[~joint]
        return read_only(atoms_A[pairs[~of_loop]]), read_only(atoms_A[pairs[of_loop]])

    def _neighbours(self, own: NDArray[np.int64], points_A: Array) -> tuple[Chain, ...]:
        """Stretches of chains within `NEAR_A` of the points, without the nucleotides `own`."""
        atoms = self._structure.universe.atoms
        residues, centres = self._representatives
        mine = atoms.resindices[self._structure.nucleotides.atom_index[own].max(axis=1)]
        points_A = points_A[np.isfinite(points_A).all(axis=1)]
        distance, _ = KDTree(points_A).query(centres, distance_upper_bound=NEAR_A)
        taken = np.flatnonzero(np.isfinite(distance) & ~np.isin(residues, mine))
        if not len(taken):
            return ()
        step = np.linalg.norm(np.diff(centres[taken], axis=0), axis=1)
        breaks = np.flatnonzero((np.diff(taken) != 1) | (step > _STEP_A)) + 1
        return tuple(
            Chain(
                tuple(self._labels[r] for r in residues[run].tolist()),
                read_only(centres[run]),
            )
            for run in np.split(taken, breaks)
        )

    @cached_property
    def _representatives(self) -> tuple[NDArray[np.int64], Array]:
        """Residues of polymers by index in the Universe, a point of each, in the file's order."""
        structure, nucleotides = self._structure, self._structure.nucleotides
        atoms = structure.universe.atoms
        carbon = np.flatnonzero((strings(atoms, "names") == "CA") & solid(structure))
        first = nucleotides.atom_index.max(axis=1)
        residues = atoms.resindices[np.concatenate([first, carbon])].astype(np.int64)
        centres = np.concatenate(
            [self._centroids(np.arange(len(nucleotides))), self._positions[carbon]]
        )
        known = np.flatnonzero(np.isfinite(centres).all(axis=1))
        order = known[np.argsort(residues[known], kind="stable")]
        return residues[order], centres[order]

    @cached_property
    def _labels(self) -> list[str]:
        """Those of all residues, such as "A.LYS7"."""
        residues = self._structure.universe.residues
        chain = np.full(len(residues), "", dtype=object)
        atoms = self._structure.universe.atoms
        chain[atoms.resindices] = chains_of(atoms)
        parts = (chain, strings(residues, "resnames"), residues.resids, strings(residues, "icodes"))
        return [
            f"{c}.{name}{number}{code}" if c else f"{name}{number}{code}"
            for c, name, number, code in zip(*parts, strict=True)
        ]


def _names(nucleotides: Nucleotides, rows: NDArray[np.int64]) -> tuple[str, ...]:
    return tuple(f"{nucleotides.letter[i]}{nucleotides.number(i)}" for i in rows)


def _mean(nucleotides: Nucleotides, positions: Array, rows: NDArray[np.int64]) -> Array:
    """Centroids of backbones; where atoms are missing the mean of those that are there."""
    whole = centroids_at(nucleotides, positions, rows)
    for k in np.flatnonzero(~np.isfinite(whole).all(axis=1)):
        index = nucleotides.atom_index[rows[k]]
        atoms = positions[index[index >= 0]]
        atoms = atoms[np.isfinite(atoms).all(axis=1)]
        if len(atoms):
            whole[k] = atoms.mean(axis=0)
    return read_only(whole)
