"""Whole nucleotides of the ideal strands: what goes onto the line.

The six backbone atoms are those of :mod:`loopelastica.molecule.strands`; here are the others, in
the same cylindrical coordinates: radius (Å), angle (°), height (Å) of nucleotide 0.

B-DNA: Arnott & Hukins, Biochem. Biophys. Res. Commun. 47 (1972) 1504, read in the table of
``dnapositions.py`` of the public project fractaldna, whose O5' is the ring oxygen O4' of today.
A-RNA: from the same secondary source as the backbone (it names no origin), a table of the same
form. Which of the two free oxygens is OP1 is not in the tables; the chirality that the wwPDB names
mean decides it. What a table lacks (thymine on ribose, uracil on deoxyribose) comes from the base
of the other table laid on the common ring, modified bases from rdkit (:mod:`.chemistry`).
"""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.atoms.measures import rigid_fit
from loopelastica.molecule.nucleotides import BACKBONE
from loopelastica.molecule.strands import Strand, ideal_strand, line_frame

_Cylinder = dict[str, tuple[float, float, float]]

_A_SUGAR: Final[_Cylinder] = {
    "OP1": (9.59, 71.2, -4.94),
    "OP2": (7.50, 76.6, -3.80),
    "O4'": (9.15, 45.3, -1.77),
    "C2'": (8.82, 33.2, -3.17),
    "O2'": (10.15, 30.2, -3.14),
    "C1'": (8.55, 36.9, -1.77),
}
_B_SUGAR: Final[_Cylinder] = {
    "OP1": (10.20, 91.1, 1.86),
    "OP2": (8.82, 103.3, 1.29),
    "O4'": (6.22, 66.0, 1.83),
    "C2'": (7.04, 73.2, -0.24),
    "C1'": (5.86, 67.4, 0.47),
}
_A_BASES: Final[dict[str, _Cylinder]] = {
    "A": {
        "N9": (7.12, 37.2, -1.39),
        "C8": (6.39, 47.0, -1.33),
        "N7": (5.15, 46.2, -0.95),
        "C5": (5.14, 30.9, -0.75),
        "C6": (4.39, 17.4, -0.34),
        "N6": (3.08, 15.6, -0.05),
        "N1": (5.28, 5.5, -0.24),
        "C2": (6.54, 8.7, -0.54),
        "N3": (7.15, 18.0, -0.93),
        "C4": (6.44, 27.6, -1.01),
    },
    "G": {
        "N9": (7.12, 37.2, -1.39),
        "C8": (6.36, 47.0, -1.32),
        "N7": (5.11, 46.0, -0.94),
        "C5": (5.13, 30.5, -0.74),
        "C6": (4.34, 17.1, -0.33),
        "O6": (3.16, 13.9, -0.04),
        "N1": (5.35, 5.5, -0.26),
        "C2": (6.67, 8.5, -0.55),
        "N2": (7.58, 0.7, -0.42),
        "N3": (7.20, 18.0, -0.94),
        "C4": (6.44, 27.5, -1.01),
    },
    "C": {
        "N1": (7.12, 37.2, -1.39),
        "C2": (6.61, 26.8, -1.04),
        "O2": (7.51, 19.9, -1.06),
        "N3": (5.32, 24.4, -0.68),
        "C4": (4.50, 36.8, -0.67),
        "N4": (3.23, 36.1, -0.31),
        "C5": (5.26, 50.6, -1.03),
        "C6": (6.53, 47.6, -1.38),
    },
    "U": {
        "N1": (7.12, 37.2, -1.39),
        "C2": (6.63, 26.9, -1.04),
        "O2": (7.46, 19.6, -1.04),
        "N3": (5.31, 25.2, -0.69),
        "C4": (4.42, 37.8, -0.66),
        "O4": (3.24, 37.1, -0.32),
        "C5": (5.28, 50.8, -1.04),
        "C6": (6.54, 47.7, -1.38),
    },
}
_B_BASES: Final[dict[str, _Cylinder]] = {
    "A": {
        "N9": (4.63, 76.6, 0.42),
        "C8": (4.84, 93.0, 0.50),
        "N7": (3.95, 105.4, 0.43),
        "C5": (2.74, 94.0, 0.28),
        "C6": (1.41, 107.2, 0.15),
        "N6": (1.83, 154.0, 0.14),
        "N1": (0.86, 40.1, 0.03),
        "C2": (2.17, 30.6, 0.04),
        "N3": (3.24, 47.0, 0.16),
        "C4": (3.33, 70.5, 0.28),
    },
    "G": {
        "N9": (4.63, 76.6, 0.42),
        "C8": (4.82, 93.2, 0.50),
        "N7": (3.92, 105.7, 0.42),
        "C5": (2.70, 94.0, 0.28),
        "C6": (1.39, 109.3, 0.15),
        "O6": (1.71, 154.6, 0.13),
        "N1": (0.92, 37.9, 0.03),
        "C2": (2.28, 28.7, 0.03),
        "N2": (3.01, 4.2, -0.10),
        "N3": (3.29, 46.7, 0.16),
        "C4": (3.33, 70.3, 0.28),
    },
    "C": {
        "N1": (4.63, 76.6, 0.42),
        "C2": (3.40, 67.4, 0.27),
        "O2": (3.69, 47.9, 0.18),
        "N3": (2.31, 83.9, 0.22),
        "C4": (2.94, 110.0, 0.32),
        "N4": (2.76, 136.6, 0.27),
        "C5": (4.35, 107.0, 0.47),
        "C6": (4.99, 92.2, 0.52),
    },
    "T": {
        "N1": (4.63, 76.6, 0.42),
        "C2": (3.42, 67.3, 0.27),
        "O2": (3.64, 47.8, 0.18),
        "N3": (2.36, 85.2, 0.23),
        "C4": (2.98, 111.9, 0.32),
        "O4": (2.82, 136.3, 0.27),
        "C5": (4.38, 106.9, 0.47),
        "C7": (5.40, 119.8, 0.58),
        "C6": (5.01, 92.3, 0.52),
    },
}


@lru_cache
def fibre_nucleotide(letter: str, is_dna: bool, c2_endo: bool | None = None) -> dict[str, Array]:
    """Atoms of nucleotide 0 of an ideal strand, its axis along z.

    The strand of the other sugar gives the pucker that the own one does not have; what that sugar
    has more or less (O2') is laid on or left out.

    Parameters
    ----------
    letter : str
        A, C, G, U or T.
    is_dna : bool
        Deoxyribose, else ribose.
    c2_endo : bool, optional
        In the strand of B-DNA (C2'-endo), else of A-RNA (C3'-endo); default that of its own sugar.

    Returns
    -------
    dict of str to (3,) array
        Position of each heavy atom, Å, in the order of the wwPDB.

    Raises
    ------
    ValueError
        If `letter` is none of the five.

    Examples
    --------
    >>> atoms = fibre_nucleotide("G", False)
    >>> bond_A = np.linalg.norm(atoms["C1'"] - atoms["N9"])
    >>> print(len(atoms), f"{bond_A:.2f}")
    23 1.48
    """
    if letter not in "ACGUT" or len(letter) != 1:
        raise ValueError(f"`letter` is {letter!r}; it must be one of A, C, G, U, T")
    if c2_endo is not None and c2_endo != is_dna:
        return _other_pucker(letter, is_dna)
    strand = ideal_strand(is_dna)
    backbone = dict(zip(BACKBONE, strand.atoms, strict=True))
    sugar = _B_SUGAR if is_dna else _A_SUGAR
    own, other = (_B_BASES, _A_BASES) if is_dna else (_A_BASES, _B_BASES)
    base = own[letter] if letter in own else own["T" if letter == "U" else "U"]
    cylinder = backbone | sugar | base
    order = ["P", "OP1", "OP2", "O5'", "C5'", "C4'", "O4'", "C3'", "O3'", "C2'", "O2'", "C1'"]
    atoms = {name: _cartesian(cylinder[name]) for name in [*order, *base] if name in cylinder}
    if letter == "U" and is_dna:
        del atoms["C7"]
    elif letter == "T" and not is_dna:
        ring = [name for name in other["T"] if name != "C7"]
        methyl = {name: _cartesian(row) for name, row in other["T"].items()}
        shared = [name for name in ring if name in atoms]
        atoms["C7"] = _moved(
            np.array([methyl[name] for name in shared]),
            np.array([atoms[name] for name in shared]),
            methyl["C7"],
        )
    for position in atoms.values():
        position.setflags(write=False)
    return atoms


def _other_pucker(letter: str, is_dna: bool) -> dict[str, Array]:
    own, other = fibre_nucleotide(letter, is_dna), fibre_nucleotide(letter, not is_dna)
    beside = ("C1'", "C2'", "C3'")
    model, target = (np.array([atoms[name] for name in beside]) for atoms in (own, other))
    return {name: other[name] if name in other else _moved(model, target, own[name])
            for name in own}  # fmt: skip


def in_line_frame(strand: Strand, position: Array) -> Array:
    """Components (…, 3) along d1 d2 d3 of the strand's line at phase 0, Å; see `line_frame`.

    Parameters
    ----------
    strand : Strand
        Which ideal strand.
    position : (…, 3) array
        In the coordinates of its table, Å.

    Returns
    -------
    (…, 3) array
    """
    point, frame = line_frame(strand, 0.0)
    local: Array = (np.asarray(position) - point) @ frame
    return local


def _cartesian(row: tuple[float, float, float]) -> Array:
    radius, angle_deg, height = row
    angle = np.deg2rad(angle_deg)
    return np.array([radius * np.cos(angle), radius * np.sin(angle), height])


def _moved(model: Array, target: Array, point: Array) -> Array:
    """The point carried along when `model` is laid on `target` (least squares, no reflection)."""
    rotation, shift = rigid_fit(model, target)
    moved: Array = rotation @ point + shift
    return moved
