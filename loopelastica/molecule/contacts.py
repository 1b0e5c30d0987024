"""Whether a loop's line runs into its stem or into itself.

The line stands for a backbone whose atoms lie on and around it. In 100 hairpin loops of measured
structures, smoothed native lines come no nearer than 3.6 Å to an atom of the stem and no nearer
than 5.4 Å to themselves, `APART` nucleotides or more along the chain. The limits below are physical
and lie under both.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.molecule.hairpins import Hairpin
from loopelastica.molecule.nucleotides import Nucleotides

STEM_CONTACT_A: Final = 3.4
"""Two van der Waals radii of carbon (1.7 Å, Bondi, J. Phys. Chem. 68 (1964) 441): nearer to an atom
of the stem there is no room for an atom on the line."""

SELF_CONTACT_A: Final = 5.0
"""Two stretches of backbone: the same, and on either side the 0.8 Å by which the six backbone atoms
lie off their line (means over the ideal strands 0.87 and 0.83 Å)."""

APART: Final = 2.0
"""Nucleotides along the chain from which on a distance is a contact and not the chain itself."""


@dataclass(frozen=True, slots=True)
class Contacts:
    """Nearest approaches of a line, Å; inf where nothing is `APART` along the chain."""

    stem_A: float
    self_A: float

    @property
    def touching(self) -> bool:
        """Whether the line runs into the stem or itself."""
        return bool(self.touched)

    @property
    def touched(self) -> str:
        """What the line runs into: "stem", "self", "stem, self" or ""."""
        stem, itself = self.stem_A < STEM_CONTACT_A, self.self_A < SELF_CONTACT_A
        return ", ".join(name for name, yes in (("stem", stem), ("self", itself)) if yes)


def stem_atoms(nucleotides: Nucleotides, hairpin: Hairpin, positions: Array) -> tuple[Array, Array]:
    """Atoms (m, 3) of the stem, Å, and the phase (m,) of the nucleotide of each.

    Parameters
    ----------
    nucleotides, hairpin
        What was read, and which of its loops.
    positions : (n_atoms, 3) array
        All atoms of one model, Å.

    Returns
    -------
    atoms_A : (m, 3) array
        Å.
    phases : (m,) array
        Those of their nucleotides along the chain, 0 the 5' closing one.
    """
    n_pairs, n = len(hairpin.stem_5), len(hairpin)
    rows = np.concatenate([hairpin.stem_5, hairpin.stem_3])
    phases = np.concatenate([-np.arange(n_pairs), n + 1 + np.arange(n_pairs)])
    index = nucleotides.atom_index[rows]
    atoms = positions[index]
    known = (index >= 0) & np.isfinite(atoms).all(axis=2)
    return atoms[known], np.repeat(phases, known.sum(axis=1)).astype(np.float64)


def contacts(line_A: Array, phases: Array, atoms_A: Array, atom_phases: Array) -> Contacts:
    """Nearest approaches of a line to the stem and to itself.

    Parameters
    ----------
    line_A : (n, 3) array
        Points of the line, Å.
    phases : (n,) array
        Their places along the chain in nucleotides, 0 the 5' closing one.
    atoms_A, atom_phases : (m, 3), (m,) array
        The stem, as from :func:`stem_atoms`.

    Returns
    -------
    Contacts

    Examples
    --------
    >>> line = np.array([[0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [6.0, 4.0, 0.0]])
    >>> near = contacts(line, np.array([1.0, 2.0, 3.0]), np.array([[0.0, 9.0, 0.0]]), np.zeros(1))
    >>> print(f"{near.stem_A:.1f} {near.self_A:.1f} {near.touching}")
    7.8 7.2 False
    """
    return Contacts(
        _nearest(line_A, phases, atoms_A, atom_phases), _nearest(line_A, phases, line_A, phases)
    )


def _nearest(a: Array, phase_a: Array, b: Array, phase_b: Array) -> float:
    """Smallest distance between points at least `APART` along the chain."""
    squared = ((a[:, None] - b[None]) ** 2).sum(axis=2)
    squared[np.abs(phase_a[:, None] - phase_b[None]) < APART] = np.inf
    return float(np.sqrt(squared.min(initial=np.inf)))
