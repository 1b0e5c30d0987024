"""The rod put back into the molecule, and the native line to compare it with.

Phases count nucleotides from the 5' closing one (phase 0); the rod runs from phase 0.5 to
n + 0.5, so that loop nucleotide k = 1 … n lies at the arc position (k − ½)/n.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from loopelastica._arrays import Array, read_only
from loopelastica.molecule.hairpins import Hairpin
from loopelastica.molecule.nucleotides import Nucleotides, centroids_at


def loop_arc_positions(n: int) -> Array:
    """Arc positions (n,) of the loop nucleotides along the rod, as fractions of its length.

    >>> print(loop_arc_positions(4))
    [0.125 0.375 0.625 0.875]

    Raises
    ------
    ValueError
        If `n` is less than 1.
    """
    if n < 1:
        raise ValueError(f"`n` is {n}; a loop has at least one nucleotide")
    return (np.arange(1, n + 1) - 0.5) / n


def to_file_coordinates(
    centerline: Array, start_origin_A: Array, start_frame: Array, length_A: float
) -> Array:
    """Line of unit length in its start frame → Å in the coordinates of the file.

    Parameters
    ----------
    centerline : (..., 3) array
        Positions divided by the length of the rod, components along d1 d2 d3 of its start.
    start_origin_A : (3,) array
        Start of the rod, Å.
    start_frame : (3, 3) array
        Columns d1 d2 d3 of the start.
    length_A : float
        Length of the rod.

    Returns
    -------
    (..., 3) array
        Å.

    Examples
    --------
    >>> to_file_coordinates(np.array([0.0, 0.0, 0.5]), np.ones(3), np.eye(3), 24.0).tolist()
    [1.0, 1.0, 13.0]
    """
    centerline = np.asarray(centerline, dtype=np.float64)
    return np.asarray(start_origin_A + length_A * (centerline @ np.asarray(start_frame).T))


def smoothed_line(centroids_A: Array, n_points: int) -> Array:
    """Smooth line through the native backbone, for drawing and comparing.

    Parameters
    ----------
    centroids_A : (n + 2, 3) array
        Centroids from the 5' closing nucleotide to the 3' closing one, Å.
    n_points : int
        Number of points, evenly spaced in phase.

    Returns
    -------
    (n_points, 3) array
        Natural cubic spline over the phase through the centroids, from phase 0.5 to n + 0.5 like
        the rod. All smoothing is in the centroids, each a mean of six atoms.

    Raises
    ------
    ValueError
        If there are fewer than three centroids, one is not finite, or fewer than two points.
    """
    spline = _spline(centroids_A)
    return np.asarray(spline(smoothed_phases(len(centroids_A) - 2, n_points)), dtype=np.float64)


def smoothed_curvature(centroids_A: Array, n_points: int) -> Array:
    """Curvature (n_points,) of the smooth line at its points, 1/Å; as :func:`smoothed_line`."""
    spline, phases = _spline(centroids_A), smoothed_phases(len(centroids_A) - 2, n_points)
    first, second = spline(phases, 1), spline(phases, 2)
    speed = np.maximum(np.linalg.norm(first, axis=1), 1e-6)
    return np.asarray(np.linalg.norm(np.cross(first, second), axis=1) / speed**3)


def smoothed_phases(n: int, n_points: int) -> Array:
    """Phases (n_points,) of the smooth line's points for n loop nucleotides.

    >>> print(smoothed_phases(4, 3))
    [0.5 2.5 4.5]

    Raises
    ------
    ValueError
        If there are fewer than two points.
    """
    if n_points < 2:
        raise ValueError(f"`n_points` is {n_points}; a line has at least two")
    return np.linspace(0.5, n + 0.5, n_points)


def _spline(centroids_A: Array) -> Any:
    from scipy.interpolate import CubicSpline

    centroids_A = np.asarray(centroids_A, dtype=np.float64)
    if centroids_A.ndim != 2 or len(centroids_A) < 3 or centroids_A.shape[1] != 3:
        raise ValueError("`centroids_A` needs the shape (n + 2, 3) with n at least 1")
    if not np.isfinite(centroids_A).all():
        raise ValueError("`centroids_A` is not finite everywhere")
    return CubicSpline(np.arange(len(centroids_A)), centroids_A, bc_type="natural")


def native_backbone(nucleotides: Nucleotides, hairpin: Hairpin, positions: Array) -> Array | None:
    """The file's own loop, for comparison only.

    Parameters
    ----------
    nucleotides, hairpin
        What was read, and which of its loops.
    positions : (n_atoms, 3) array
        All atoms of one model, Å.

    Returns
    -------
    (n + 2, 3) array or None
        Centroids from closing to closing nucleotide, Å; None if one is not in the file.
    """
    rows = np.concatenate([hairpin.stem_5[:1], hairpin.loop, hairpin.stem_3[:1]])
    backbone = centroids_at(nucleotides, positions, rows)
    return read_only(backbone) if np.isfinite(backbone).all() else None


def rmsd_A(a: Array, b: Array) -> float:
    """Root mean square distance of two (n, 3) sets of points where they are, not superposed.

    Parameters
    ----------
    a, b : (n, 3) array
        Å.

    Returns
    -------
    float
        Å.

    Raises
    ------
    ValueError
        If the shapes differ or there is no point.

    Examples
    --------
    >>> rmsd_A(np.zeros((2, 3)), np.array([[3.0, 0.0, 0.0], [0.0, 4.0, 0.0]]))
    3.5355339059327378
    """
    a, b = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    if a.shape != b.shape or a.size == 0:
        raise ValueError(f"`a` and `b` have shapes {a.shape} and {b.shape}")
    return float(np.sqrt(((a - b) ** 2).sum(axis=-1).mean()))
