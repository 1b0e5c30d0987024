"""Worm-like samples of strands: chains of bonds of fixed length that bend as heat makes them.

The energy of a chain is −κ Σ cos θ over its hinges, in units of kT; κ is such that a free chain has
⟨cos θ⟩ = coth κ − 1/κ = exp(−b/lp) for bonds b and a persistence length lp. A clamp counts as one
more bond along its tangent. Free chains are drawn exactly, hinge by hinge. Chains whose both ends
are held move by crankshafts: what lies between two nucleotides turns about the line through them,
and the turn is kept with the probability of Metropolis.

Each chain has random numbers of its own, so that it does not depend on the others.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica._vectors import dot

# crankshafts per bond, and at least; half of them turn by less than this
_PER_BOND: Final = 40
_LEAST: Final = 200
_SMALL: Final = 0.6
_NEXT: Final = [1, 2, 0]
_BEFORE: Final = [2, 0, 1]


def stiffness(ratio: float) -> float:
    """κ of hinges between bonds that are `ratio` persistence lengths long.

    Examples
    --------
    >>> kappa = stiffness(0.5)
    >>> print(f"{1 / np.tanh(kappa) - 1 / kappa:.6f} {np.exp(-0.5):.6f}")
    0.606531 0.606531
    """
    from scipy.optimize import brentq

    cosine = np.exp(-ratio)
    if cosine < 1e-4:
        return float(3 * cosine)
    if cosine > 1 - 1e-6:
        return float(1 / (1 - cosine))
    return float(brentq(lambda k: 1 / np.tanh(k) - 1 / k - cosine, 1e-5, 1e7, xtol=1e-14))


def free_chain(
    start: Array, tangent: Array, bond: float, kappa: float, count: int, rng: np.random.Generator
) -> Array:
    """Draw a chain that is held at its start only.

    Parameters
    ----------
    start, tangent : (3,) array
        Where it begins, and the direction of its clamp there.
    bond : float
        Length of bonds.
    kappa : float
        Stiffness of hinges, :func:`stiffness`.
    count : int
        Bonds.
    rng : numpy.random.Generator
        What it is drawn from.

    Returns
    -------
    (count, 3) array
        Ends of the bonds.
    """
    chance, azimuth = rng.random(count), 2 * np.pi * rng.random(count)
    cosine = np.clip(1 + np.log(chance + (1 - chance) * np.exp(-2 * kappa)) / kappa, -1, 1)
    sine = np.sqrt(1 - cosine**2)
    # turns of a frame whose third axis is the bond: about the bond, then away from it
    c, s = np.cos(azimuth), np.sin(azimuth)
    zero = np.zeros(count)
    turns = np.array(
        [
            [c * cosine, -s, c * sine],
            [s * cosine, c, s * sine],
            [-sine, zero, cosine],
        ]
    ).transpose(2, 0, 1)
    frame = _frame(tangent)
    directions = np.empty((count, 3))
    for k in range(count):
        frame = frame @ turns[k]
        directions[k] = frame[:, 2]
    return np.asarray(start + bond * np.cumsum(directions, axis=0))


def _frame(tangent: Array) -> Array:
    first = np.cross(tangent, np.eye(3)[np.argmin(np.abs(tangent))])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(tangent, first), tangent], axis=1)


def held_chains(
    chains: list[Array],
    clamps: Array,
    kappa: Array,
    generators: list[np.random.Generator],
    per_bond: int = _PER_BOND,
) -> list[Array]:
    """Draw chains that are held at both ends, by crankshafts from those given.

    Parameters
    ----------
    chains : list of (k, 3) array
        Points of each, both ends included; three or more.
    clamps : (m, 2, 3) array
        Directions of the clamps before the start and after the end.
    kappa : (m,) array
        Stiffness of hinges of each.
    generators : list of numpy.random.Generator
        One for each.
    per_bond : int, optional
        Crankshafts per bond.

    Returns
    -------
    list of (k, 3) array
        The bonds are as long as they were.
    """
    bonds = np.array([len(points) - 1 for points in chains])
    moves = np.maximum(per_bond * bonds, _LEAST)
    order = np.argsort(-moves, kind="stable")
    found: list[Array] = [np.empty(0)] * len(chains)
    draws = [generators[k].random((moves[k], 5)) for k in range(len(chains))]
    points = np.zeros((len(chains), int(bonds.max(initial=0)) + 1, 3))
    for row, k in enumerate(order.tolist()):
        points[row, : bonds[k] + 1] = chains[k]
    left, clamps, kappa, bonds = len(order), clamps[order], kappa[order], bonds[order]
    drawn = np.zeros((len(order), int(moves.max(initial=0)), 5))
    for row, k in enumerate(order.tolist()):
        drawn[row, : moves[k]] = draws[k]
    ends = moves[order]
    for move in range(int(moves.max(initial=0))):
        # the longest come first and go on the longest
        left = int(np.searchsorted(-ends, -move, side="left"))
        _crankshaft(points[:left], bonds[:left], clamps[:left], kappa[:left], drawn[:left, move])
    for row, k in enumerate(order.tolist()):
        found[k] = points[row, : bonds[row] + 1].copy()
    return found


def _crankshaft(points: Array, bonds: Array, clamps: Array, kappa: Array, chance: Array) -> None:
    """One move of each chain (m, k, 3), by five random numbers (m, 5) of each; in place."""
    row = np.arange(len(points))
    last = bonds.astype(int)
    span = 2 + (chance[:, 0] * (last - 1)).astype(int)
    i = (chance[:, 1] * (last - span + 1)).astype(int)
    j = i + span
    angle = np.where(chance[:, 2] < 0.5, _SMALL, np.pi) * (2 * chance[:, 3] - 1)
    start, end = points[row, i], points[row, j]
    axis = end - start
    size = np.linalg.norm(axis, axis=1)
    # a closed chain has no line: it turns about any
    closed = size < 1e-9
    axis[closed], size[closed] = [0.0, 0.0, 1.0], 1.0
    axis /= size[:, None]
    old = points[row, i + 1] - start, end - points[row, j - 1]
    both = (np.concatenate(pair) for pair in (old, (axis, axis), (angle, angle)))
    new = np.split(_turned(*both), 2)
    before = np.where((i > 0)[:, None], start - points[row, np.maximum(i - 1, 0)], clamps[:, 0])
    inside = np.minimum(j + 1, last)
    after = np.where((j < last)[:, None], points[row, inside] - end, clamps[:, 1])
    gain = kappa * sum(
        dot(to - of, beside)
        / np.maximum(np.linalg.norm(of, axis=1) * np.linalg.norm(beside, axis=1), 1e-12)
        for to, of, beside in zip(new, old, (before, after), strict=True)
    )
    keep = np.log(np.maximum(chance[:, 4], 1e-300)) < gain
    width = np.arange(points.shape[1])
    moving = keep[:, None] & (width > i[:, None]) & (width < j[:, None])
    which, where = np.nonzero(moving)
    arm = points[which, where] - start[which]
    points[which, where] = start[which] + _turned(arm, axis[which], angle[which])


def _turned(vector: Array, axis: Array, angle: Array) -> Array:
    """Vectors (m, 3) turned about unit axes (m, 3) (Rodrigues)."""
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    along = dot(vector, axis)[:, None] * axis
    # the cross product: np.cross takes longer than all else where vectors are few
    across = axis[:, _NEXT] * vector[:, _BEFORE] - axis[:, _BEFORE] * vector[:, _NEXT]
    return np.asarray(c * (vector - along) + s * across + along)
