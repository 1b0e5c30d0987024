"""The Morse index of a rod from a spectral second variation.

With Θ(s) the rotation of the frames in space, to second order (K0 = 1, t the tangent)

    δ²E = ∫ |Θ'|² + (K30 − 1)(t·Θ')² + M·(Θ' × Θ) − (F·Θ)(t·Θ) + (F·t)|Θ|²  ds

where Θ vanishes at both ends, but for its part along t(1) with a free end spin, and ∫ Θ × t ds = 0,
since the end's position is fixed. The index is the number of negative eigenvalues with sines for
functions; Ritz's method counts no more than there are, and more functions never fewer. Neither
conjugate points nor discrete rods, by which ``rod.stability`` counts, are used.
"""

import math

import numpy as np

from loopelastica._arrays import Array
from loopelastica.studies.completeness import shots

# functions per component; two counts must agree
_FUNCTIONS = (24, 36, 54, 81)
# the level ways of a family come out above zero, but for rounding: the largest values are about 1
_ZERO = 1e-7
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(8)


def index(middle: Array, torsion_ratio: float, free_spin: bool) -> int:
    """Morse index of an equilibrium.

    Parameters
    ----------
    middle : (6,) ndarray
        F and M at s = ½ in the frame there.
    torsion_ratio : float
        K30 = K3/K0.
    free_spin : bool
        The end may turn about its tangent.

    Returns
    -------
    int
        How many ways lead downhill.
    """
    counts = [_count(middle, torsion_ratio, free_spin, n) for n in _FUNCTIONS[:2]]
    for n in _FUNCTIONS[2:]:
        if counts[-1] == counts[-2]:
            break
        counts.append(_count(middle, torsion_ratio, free_spin, n))
    return counts[-1]


def _count(middle: Array, torsion_ratio: float, free_spin: bool, n: int) -> int:
    values = np.linalg.eigvalsh(_second_variation(middle, torsion_ratio, free_spin, n))
    return int((values < -_ZERO).sum())


def _second_variation(middle: Array, torsion_ratio: float, free_spin: bool, n: int) -> Array:
    """Symmetric matrix of δ²E on what keeps the end's position, ``n`` sines per component."""
    cells = max(8, n // 3)
    s = ((np.arange(cells)[:, None] + 0.5 * (1.0 + _POINTS)) / cells).ravel()
    weights = np.tile(0.5 * _WEIGHTS / cells, cells)
    tangents, moments, force, last = _along(middle, s)
    waves = math.pi * np.arange(1, n + 1)
    values, slopes = np.sin(np.outer(s, waves)) / waves, np.cos(np.outer(s, waves))
    basis = np.eye(3)
    # Θ and Θ' at the nodes: (nodes, 3, functions)
    theta = np.einsum("sn,ij->sinj", values, basis).reshape(len(s), 3, -1)
    slope = np.einsum("sn,ij->sinj", slopes, basis).reshape(len(s), 3, -1)
    if free_spin:
        # a straight line on top of sines that vanish at the end
        theta = np.concatenate([theta, (s[:, None] * last)[:, :, None]], axis=2)
        slope = np.concatenate([slope, np.broadcast_to(last, (len(s), 3))[:, :, None]], axis=2)
    torsion = np.einsum("si,sij->sj", tangents, slope)
    along, pulled = np.einsum("si,sij->sj", tangents, theta), np.einsum("i,sij->sj", force, theta)
    # M·(Θ' × Θ) = Θ'·(Θ × M)
    turned = np.cross(theta, moments[:, :, None], axis=1)
    w = weights[:, None, None]
    form = np.einsum("sij,sik->jk", w * slope, slope + turned)
    form += (torsion_ratio - 1.0) * np.einsum("sj,sk->jk", weights[:, None] * torsion, torsion)
    form -= np.einsum("sj,sk->jk", weights[:, None] * pulled, along)
    tension = (tangents @ force) * weights
    form += np.einsum("sij,sik->jk", tension[:, None, None] * theta, theta)
    moved = np.einsum("sij->ij", w * np.cross(theta, tangents[:, :, None], axis=1))
    kept = np.linalg.svd(moved)[2][_rank(moved) :].T
    return np.asarray(kept.T @ (form + form.T) @ kept)


def _rank(moved: Array) -> int:
    """How many components of the end's position the rotations move: 2 for a straight rod."""
    return int((np.linalg.svd(moved, compute_uv=False) > 1e-9).sum())


def _along(middle: Array, s: Array) -> tuple[Array, Array, Array, Array]:
    """Tangents and moments (n, 3) at ``s``, the force, and the tangent at the end."""
    from scipy.interpolate import CubicHermiteSpline

    force = middle[:3]
    parts = 8 * int(1.0 + shots.turning_rate(middle))
    poses = shots.trace(middle.copy(), 0.1, parts)
    line, (w, a, b, c) = poses[:, :3], poses[:, 3:].T
    tangents = np.column_stack([2 * (a * c + w * b), 2 * (b * c - w * a), 1 - 2 * (a * a + b * b)])
    moments = middle[3:] + np.cross(force, line)
    grid = np.linspace(0.0, 1.0, len(poses))
    at = CubicHermiteSpline(grid, tangents, np.cross(moments, tangents))(s)
    there = CubicHermiteSpline(grid, moments, np.cross(force, tangents))(s)
    return at, there, force, tangents[-1]
