"""Simple curves between two clamps: what a rod has to beat.

Each gives points at fractions of its own arc length, Å, and is given positions, tangents and length
of the ends, nothing else.
"""

import numpy as np
from scipy.optimize import brentq

from loopelastica._arrays import Array
from loopelastica.molecule.ends import StemEnds

_DENSE = 400


def chord(ends: StemEnds, s: Array) -> Array:
    """Points of the straight line between the ends.

    Parameters
    ----------
    ends : StemEnds
        Positions and tangents of the ends, and the length, Å.
    s : (n,) ndarray
        Fractions of the arc length, in [0, 1].

    Returns
    -------
    (n, 3) ndarray
        Å.
    """
    start, end = np.asarray(ends.start_origin_A), np.asarray(ends.end_origin_A)
    return np.asarray(start + s[:, None] * (end - start))


def arc(ends: StemEnds, s: Array) -> Array:
    """Points of the circular arc of the rod's length.

    It lies in the plane of the chord and of the difference of the two tangents, on the side to
    which the start points more than the end does.

    Parameters
    ----------
    ends, s
        As for `chord`.

    Returns
    -------
    (n, 3) ndarray
        Å.
    """
    start, step, up = _plane(ends)
    distance = float(np.linalg.norm(step))
    # half the angle of an arc of this length over this chord
    half = brentq(
        lambda a: ends.length_A * np.sin(a) - distance * a, 1e-9, np.pi * (1 - 1e-12), xtol=1e-14
    )
    radius = ends.length_A / (2.0 * half)
    angle = half * (2.0 * s - 1.0)
    along = 0.5 * distance + radius * np.sin(angle)
    height = radius * (np.cos(angle) - np.cos(half))
    return np.asarray(start + along[:, None] * step / max(distance, 1e-12) + height[:, None] * up)


def hermite(ends: StemEnds, s: Array) -> Array:
    """Points of the cubic with the ends' tangents, scaled to the rod's length.

    Parameters
    ----------
    ends, s
        As for `chord`.

    Returns
    -------
    (n, 3) ndarray
        Å.
    """
    start, end = np.asarray(ends.start_origin_A), np.asarray(ends.end_origin_A)
    t0, t1 = np.asarray(ends.start_frame)[:, 2], np.asarray(ends.end_frame)[:, 2]
    u = np.linspace(0.0, 1.0, _DENSE + 1)[:, None]

    def points(scale: float) -> Array:
        return np.asarray(
            (2 * u**3 - 3 * u**2 + 1) * start
            + (3 * u**2 - 2 * u**3) * end
            + scale * ((u**3 - 2 * u**2 + u) * t0 + (u**3 - u**2) * t1)
        )

    def excess(scale: float) -> float:
        return float(_arc_lengths(points(scale))[-1]) - ends.length_A

    # the curve grows without bound; the first scale that is long enough is taken
    high = ends.length_A
    while excess(high) < 0:
        high *= 2.0
    line = points(brentq(excess, 0.0, high))
    along = _arc_lengths(line)
    return np.stack([np.interp(s * along[-1], along, line[:, i]) for i in range(3)], axis=1)


def stem_axes(ends: StemEnds) -> tuple[Array, Array]:
    """Middle (3,) of the ends and axes (3, 3), in columns: along the chord, across, to the loop."""
    start, step, up = _plane(ends)
    x = step / np.linalg.norm(step)
    return start + 0.5 * step, np.stack([x, np.cross(up, x), up], axis=1)


def _plane(ends: StemEnds) -> tuple[Array, Array, Array]:
    start, end = np.asarray(ends.start_origin_A), np.asarray(ends.end_origin_A)
    step = end - start
    up = np.asarray(ends.start_frame)[:, 2] - np.asarray(ends.end_frame)[:, 2]
    up = up - step * (up @ step) / (step @ step)
    return start, step, up / np.linalg.norm(up)


def _arc_lengths(line: Array) -> Array:
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])
