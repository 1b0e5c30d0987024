"""Curves of a given length between two clamped ends: guesses, and what a rod is compared with.

A span is two places, the tangents there and a length, all in one unit.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from loopelastica._arrays import Array
from loopelastica._checks import array, flag, positive, whole

# points on a curve whose length is measured
_FINE = 257
# ends nearer than this, in lengths, are one point; a longer chord than 1 minus this is the curve
_LEAST = 1e-9
_BENDS = 8


class Span(NamedTuple):
    """Two clamped ends and the length between them.

    Attributes
    ----------
    start, end : (3,) ndarray
        Places, in any unit.
    start_tangent, end_tangent : (3,) ndarray
        Unit vectors along the curve.
    length : float
        Of the curve, in the same unit.
    """

    start: Array
    start_tangent: Array
    end: Array
    end_tangent: Array
    length: float

    @property
    def chord(self) -> Array:
        """From start to end in units of the length, (3,)."""
        return np.asarray((self.end - self.start) / self.length)


def check_span(
    start: ArrayLike,
    start_tangent: ArrayLike,
    end: ArrayLike,
    end_tangent: ArrayLike,
    length: float,
) -> Span:
    """The span; ValueError if no curve can have it, or its ends are one point."""
    length = positive("length", length)
    places = [_three(name, value) for name, value in (("start", start), ("end", end))]
    tangents = []
    for name, value in (("start_tangent", start_tangent), ("end_tangent", end_tangent)):
        vector = _three(name, value)
        largest = float(np.abs(vector).max())
        if largest == 0.0:
            raise ValueError(f"`{name}` is zero; it must have a direction")
        vector = vector / largest
        tangents.append(vector / np.linalg.norm(vector))
    span = Span(places[0], tangents[0], places[1], tangents[1], length)
    with np.errstate(all="ignore"):
        distance = math.hypot(*span.chord)
    if not distance <= 1.0 + _LEAST:
        raise ValueError(
            f"`length` is {length:.9g} and the ends are {distance * length:.9g} apart; no curve"
            " reaches further than its length"
        )
    if distance < _LEAST:
        raise ValueError("`end` is the same point as `start`; a curve needs two ends")
    return span


def _three(name: str, value: ArrayLike) -> Array:
    vector = array(name, value)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise ValueError(f"`{name}` must be three finite numbers")
    return vector


def equal_length_hermite(
    start: ArrayLike,
    start_tangent: ArrayLike,
    end: ArrayLike,
    end_tangent: ArrayLike,
    length: float,
    n: int = 65,
) -> Array:
    """Points on the cubic Hermite curve that has a given length.

    Its tangents at both ends have one magnitude, the least that makes the curve as long.

    Parameters
    ----------
    start, end : (3,) array_like
        Where it begins and ends, in any unit.
    start_tangent, end_tangent : (3,) array_like
        Directions there, of any length.
    length : float
        Of the curve, in the same unit.
    n : int
        Number of points.

    Returns
    -------
    (n, 3) ndarray
        Equally spaced along the curve, both ends included.

    Raises
    ------
    ValueError
        If no such curve exists or an argument is out of range.

    Examples
    --------
    >>> points = equal_length_hermite([0, 0, 0], [0, 0, 1], [10, 0, 0], [0, 0, -1], 16.0)
    >>> print(points[32].round(2), round(np.linalg.norm(np.diff(points, axis=0), axis=1).sum(), 2))
    [5.   0.   5.09] 16.0
    """
    span = check_span(start, start_tangent, end, end_tangent, length)
    n = whole(2)("n", n)
    return np.asarray(span.start + span.length * _spaced(_hermite(span, _magnitude(span)), n))


def _hermite(span: Span, magnitude: float) -> Array:
    """Points of the cubic, in units of the length and relative to its start."""
    x = np.linspace(0.0, 1.0, _FINE)[:, None]
    sides = x * (1 - x) ** 2 * span.start_tangent - x**2 * (1 - x) * span.end_tangent
    return np.asarray(x**2 * (3 - 2 * x) * span.chord + magnitude * sides)


def _magnitude(span: Span) -> float:
    """The least magnitude of the tangents that makes the cubic as long as it should be."""
    low, high = 0.0, 0.25
    # a cubic of magnitude m is longer than m/10 or so
    while _length(_hermite(span, high)) < 1.0 and high < 1e3:
        low, high = high, high + 0.25
    for _ in range(60):
        middle = 0.5 * (low + high)
        if _length(_hermite(span, middle)) < 1.0:
            low = middle
        else:
            high = middle
    return high


def _length(points: Array) -> float:
    """Of the smooth curve through equally spaced points, by extrapolation of two polygons."""
    fine, coarse = (np.linalg.norm(np.diff(p, axis=0), axis=1).sum() for p in (points, points[::2]))
    return float(fine + (fine - coarse) / 3.0)


def _spaced(points: Array, n: int) -> Array:
    """``n`` points equally spaced along a polygon."""
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    s = np.linspace(0.0, along[-1], n)
    return np.stack([np.interp(s, along, points[:, i]) for i in range(3)], axis=1)


def _bent(span: Span, n: int) -> list[Array]:
    """Half waves of a sine to all sides of the chord, as long as the curve should be."""
    chord = span.chord
    # the first side is in the plane of the chord and the mean tangent, where there is one
    axis = chord / np.linalg.norm(chord)
    side = span.start_tangent - span.end_tangent
    side = side - (side @ axis) * axis
    if np.linalg.norm(side) < 1e-6:
        side = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    side = side / np.linalg.norm(side)
    other = np.cross(axis, side)
    x = np.linspace(0.0, 1.0, _FINE)[:, None]
    low, high = 0.0, 0.5
    for _ in range(60):
        middle = 0.5 * (low + high)
        if _length(x * chord + middle * np.sin(np.pi * x) * side) < 1.0:
            low = middle
        else:
            high = middle
    return [
        _spaced(x * chord + high * np.sin(np.pi * x) * direction, n)
        for direction in (
            math.cos(angle) * side + math.sin(angle) * other
            for angle in np.arange(_BENDS) * math.tau / _BENDS
        )
    ]


def standard_guesses(
    start: ArrayLike,
    start_tangent: ArrayLike,
    end: ArrayLike,
    end_tangent: ArrayLike,
    length: float,
    *,
    free_rod: ArrayLike | None = None,
    bends: bool = True,
) -> list[Array]:
    """Curves to begin with where a rod is sought among obstacles.

    Parameters
    ----------
    start, start_tangent, end, end_tangent, length
        As for :func:`equal_length_hermite`.
    free_rod : (k, 3) array_like, optional
        Points along the rod that the obstacles would bend, which come first.
    bends : bool
        Whether half waves of a sine follow, to eight sides of the chord.

    Returns
    -------
    list of (n, 3) ndarray
        Points along each: the free rod, the Hermite curve of equal length, the bends.

    Raises
    ------
    ValueError
        If no curve can have this span or an argument is out of range.
    """
    span = check_span(start, start_tangent, end, end_tangent, length)
    guesses = [] if free_rod is None else [check_points("free_rod", free_rod)]
    guesses.append(span.start + span.length * _spaced(_hermite(span, _magnitude(span)), _FINE))
    if flag("bends", bends):
        guesses += [span.start + span.length * points for points in _bent(span, _FINE)]
    return guesses


def check_points(name: str, points: ArrayLike) -> Array:
    """Points (k, 3) of a curve, two or more; ValueError otherwise."""
    found = array(name, points)
    if found.ndim != 2 or found.shape[1] != 3 or len(found) < 2 or not np.isfinite(found).all():
        raise ValueError(f"`{name}` must be two or more points, an array (k, 3) of finite numbers")
    return found
