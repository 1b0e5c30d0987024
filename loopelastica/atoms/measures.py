"""Bond lengths, angles, torsions and puckers from positions."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array


def bond_lengths(positions: Array, bonds: NDArray[np.int64]) -> Array:
    """Lengths (b,) of bonds (b, 2), Å.

    Parameters
    ----------
    positions : (N, 3) array
        Å.
    bonds : (b, 2) array of int
        Rows.

    Returns
    -------
    (b,) array
    """
    between = positions[bonds[:, 0]] - positions[bonds[:, 1]]
    return np.asarray(np.linalg.norm(between, axis=1))


def angles_deg(positions: Array, angles: NDArray[np.int64]) -> Array:
    """Angles (a,) of triples (a, 3), degrees.

    Parameters
    ----------
    positions : (N, 3) array
        Å.
    angles : (a, 3) array of int
        Rows, the middle one the corner.

    Returns
    -------
    (a,) array
    """
    u = positions[angles[:, 0]] - positions[angles[:, 1]]
    v = positions[angles[:, 2]] - positions[angles[:, 1]]
    across = np.linalg.norm(np.cross(u, v), axis=1)
    return np.asarray(np.rad2deg(np.arctan2(across, (u * v).sum(axis=1))))


def torsion_deg(a: Array, b: Array, c: Array, d: Array) -> float:
    """Torsion about b–c by the IUPAC sign, degrees in (−180, 180].

    Parameters
    ----------
    a, b, c, d : (3,) array
        Four atoms in a row.

    Returns
    -------
    float

    Examples
    --------
    >>> torsion_deg(*np.array([[1.0, 0, 0], [0, 0, 0], [0, 0, 1], [0, 1, 1]]))
    90.0
    """
    axis = (c - b) / np.linalg.norm(c - b)
    u, v = a - b, d - c
    u, v = u - axis * (u @ axis), v - axis * (v @ axis)
    return math.degrees(math.atan2(float(np.cross(u, v) @ axis), float(u @ v)))


def chi_torsion(letter: str) -> tuple[str, str, str, str]:
    """The four atoms of χ.

    >>> chi_torsion("U")
    ("O4'", "C1'", 'N1', 'C2')
    """
    return ("O4'", "C1'", "N9", "C4") if letter in "AG" else ("O4'", "C1'", "N1", "C2")


def pseudorotation(c1: Array, c2: Array, c3: Array, c4: Array, o4: Array) -> tuple[float, float]:
    """Phase in [0, 360) and amplitude of a sugar ring, degrees.

    Altona & Sundaralingam, J. Am. Chem. Soc. 94 (1972) 8205, doi:10.1021/ja00778a043.

    Parameters
    ----------
    c1, c2, c3, c4, o4 : (3,) array
        Ring atoms, Å.

    Returns
    -------
    phase, amplitude : float
    """
    nu_2 = torsion_deg(c1, c2, c3, c4)
    nu_3 = torsion_deg(c2, c3, c4, o4)
    nu_4 = torsion_deg(c3, c4, o4, c1)
    nu_0 = torsion_deg(c4, o4, c1, c2)
    nu_1 = torsion_deg(o4, c1, c2, c3)
    sine = (nu_4 + nu_1) - (nu_3 + nu_0)
    cosine = 2.0 * nu_2 * (math.sin(math.radians(36.0)) + math.sin(math.radians(72.0)))
    phase = math.degrees(math.atan2(sine, cosine)) % 360.0
    return phase, math.hypot(sine, cosine) / (
        2.0 * (math.sin(math.radians(36.0)) + math.sin(math.radians(72.0)))
    )


def pucker_name(phase: float) -> str:
    """Name of the envelope nearest to a phase.

    >>> pucker_name(18.0), pucker_name(162.0), pucker_name(359.0)
    ("C3'-endo", "C2'-endo", "C2'-exo")
    """
    names = ("C3'-endo", "C4'-exo", "O4'-endo", "C1'-exo", "C2'-endo", "C3'-exo", "C4'-endo",
             "O4'-exo", "C1'-endo", "C2'-exo")  # fmt: skip
    return names[int(phase % 360.0 // 36.0)]


def rigid_fit(model: Array, target: Array) -> tuple[Array, Array]:
    """Rotation (3, 3) and shift (3,) that lay points on others by least squares, no reflection.

    Kabsch, Acta Cryst. A32 (1976) 922, doi:10.1107/S0567739476001873.

    Parameters
    ----------
    model, target : (m, 3) array
        Å.

    Returns
    -------
    rotation, shift : (3, 3), (3,) array
        The model's points are at ``model @ rotation.T + shift``.
    """
    here, there = model.mean(axis=0), target.mean(axis=0)
    u, _, vt = np.linalg.svd((target - there).T @ (model - here))
    hand = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    rotation = u @ hand @ vt
    return rotation, there - rotation @ here
