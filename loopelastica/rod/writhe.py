"""Twist, polar writhe and net winding of an open rod.

Net winding (eq. 43 of Ameline et al., J. Comput. Phys. 373 (2018) 736,
DOI 10.1016/j.jcp.2018.07.021; M. A. Berger & C. Prior, J. Phys. A 39 (2006) 8321,
DOI 10.1088/0305-4470/39/26/005) is the linking number of open ribbons between two parallel planes:
net winding = twist + polar writhe. Where the curve is cut at equal height along a direction e, and
σ = ±1 says whether a piece rises or falls,

    polar writhe = (1/2π) ∫ σ (t × t')·e/(1 + |t·e|) ds                           (local)
                 + Σ_{i≠j} σ_i σ_j/(2π) ∫ dΘ_ij                                   (nonlocal)

where in the second sum all integrals are taken upwards, and Θ_ij is the azimuth about e of the
vector from piece i to piece j at the same height.

The planes. The ends of a clamped rod need not lie on its bounding planes, nor its end tangents
along e. So the rod is continued by two straight lines along e, one coming from −∞ to its start, one
going from its end to +∞, joined by the shortest turn from e to the tangent. These lines depend on
the clamping only, hence the net winding of two rods of one clamping differs by an integer. Unless
given otherwise e = (t(0) + t(L))/|t(0) + t(L)|, the direction between the end tangents, and d1(0)
where they are opposite. The fractional part is then (ψ_R + φ_R)/2π, with the Euler angles of the
clamping (eq. 6), for any e on the shortest arc from t(0) to t(L): this is what gives 0.1 and 1.1 in
Figure 6 and 0.42 and −1.58 in Figure 7.

Why it is exact. Fuller's theorem: with θ, ψ, φ the ZYZ angles of the frame about e,
twist + (1/2π)∫(t × t')·e/(1 + t·e) ds = Δ(ψ + φ)/2π, and the integral equals the polar writhe up to
an integer. So the end frames give the net winding modulo 1 without any integration, and a polygon
through some hundred points of the rod is enough to choose the integer. A polygon has a polar writhe
in closed form: spherical triangles for the local part, one arc tangent for each pair of edges of
overlapping heights for the other.

Closed rods. Where both ends meet with one tangent there is no plane to come from, and the writhe is
Gauss's integral of the closed curve with itself. With the frames closed too, twist + writhe is the
linking number Lk of the ribbon (G. Călugăreanu 1961, J. H. White 1969); else it differs from an
integer by the angle between the two frames.

Undefined. A rod that passes through itself is between two integers: Gauss's integral jumps by 2
there. Nothing is returned then (None), nor where the ends meet in a corner, for which no line comes
in and none goes out.

Legend: e direction, u edge directions of the polygon; all results are in turns.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from loopelastica._arrays import Array
from loopelastica._checks import array
from loopelastica.rod.kernels import polygon

__all__ = ["net_winding", "polar_writhe", "twist", "writhe"]

# ends nearer than this are one point; tangents, one tangent
_ONE = 1e-9


def _rows(values: ArrayLike, shape: tuple[int, ...], name: str) -> Array:
    rows = array(name, values)
    if rows.ndim == 0 or rows.shape[1:] != shape or len(rows) < 2 or not np.isfinite(rows).all():
        raise ValueError(f"`{name}` must be finite, of shape (n,) + {shape} with n at least 2")
    return rows


def _axes(direction: ArrayLike) -> Array:
    """Rotation whose rows are two axes across `direction` and its unit vector."""
    e = np.array(direction, dtype=np.float64)
    size = float(np.linalg.norm(e)) if e.shape == (3,) else 0.0
    if not (math.isfinite(size) and size > 0.0):
        raise ValueError("`direction` must be three finite numbers, not all zero")
    e /= size
    helper = np.eye(3)[int(np.argmin(np.abs(e)))]
    x = np.cross(helper, e)
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(e, x), e])


def twist(frames: ArrayLike) -> float:
    """Turns of the frame about its tangent, relative to parallel transport.

    Parameters
    ----------
    frames : (n, 3, 3) array_like
        Rotations with columns d1, d2, d3 along the curve, less than half a turn apart.

    Returns
    -------
    float
        Exact for a curve whose tangents follow great arcs between those given; otherwise the error
        falls with 1/n². A rod's own twist is M3 L/(2π K3), without sampling.

    Raises
    ------
    ValueError
        If `frames` has a wrong shape or is not finite.

    Examples
    --------
    >>> c, s = np.cos(0.25 * np.pi), np.sin(0.25 * np.pi)
    >>> print(twist([np.eye(3), [[c, -s, 0], [s, c, 0], [0, 0, 1]]]))
    0.125
    """
    r = _rows(frames, (3, 3), "frames")
    step = np.einsum("nji,njk->nik", r[:-1], r[1:])
    # ψ + φ of the relative rotation: the shortest turn of the tangent has φ = −ψ
    angle = np.arctan2(step[:, 1, 0] - step[:, 0, 1], step[:, 0, 0] + step[:, 1, 1])
    return float(angle.sum() / (2.0 * math.pi))


def polar_writhe(points: ArrayLike, tangents: ArrayLike, direction: ArrayLike) -> float:
    """Polar writhe of an open curve, continued along ±`direction` to two parallel planes.

    Parameters
    ----------
    points : (n, 3) array_like
        Points of the curve; it should not come nearer to itself than the polygon does to the curve.
    tangents : (n, 3) array_like
        Unit tangents at the points.
    direction : (3,) array_like
        Normal e of the planes.

    Returns
    -------
    float
        In turns. The polygon is treated exactly; the correction from its edges to the tangents
        leaves an error that falls with 1/n².

    Raises
    ------
    ValueError
        If an argument has a wrong shape or is not finite.

    Examples
    --------
    One turn of a helix at 60° to its axis, 1 − cos 60°:

    >>> s = np.linspace(0, 2 * np.pi, 400)
    >>> tangents = np.array([-np.sin(s), np.cos(s), 0 * s + 3**-0.5]).T * 0.75**0.5
    >>> points = np.array([np.cos(s), np.sin(s), 3**-0.5 * s]).T
    >>> print(round(polar_writhe(points, tangents, [0, 0, 1]), 4))
    0.5
    """
    axes = _axes(direction)
    r = _rows(points, (3,), "points") @ axes.T
    t = _rows(tangents, (3,), "tangents") @ axes.T
    if len(r) != len(t):
        raise ValueError("`tangents` must have as many rows as `points`")
    t /= np.linalg.norm(t, axis=1)[:, None]
    margin = 1.0 + float(np.abs(np.diff(r, axis=0)).max())
    first, last = r[0].copy(), r[-1].copy()
    first[2] = r[:, 2].min() - margin
    last[2] = r[:, 2].max() + margin
    r = np.ascontiguousarray(np.vstack([first, r, last]))
    edges = np.diff(r, axis=0)
    lengths = np.linalg.norm(edges, axis=1)
    if not lengths.all():
        raise ValueError("`points` has two equal points in succession")
    pole = np.array([[0.0, 0.0, 1.0]])
    polar, north = polygon.local_polar_writhe(np.ascontiguousarray(edges / lengths[:, None]))
    _, smooth_north = polygon.local_polar_writhe(np.ascontiguousarray(np.vstack([pole, t, pole])))
    # areas on the sphere are determined modulo 4π
    change = math.remainder(smooth_north - north, 4.0 * math.pi)
    return float((polar + change + polygon.nonlocal_polar_writhe(r)) / (2.0 * math.pi))


def writhe(points: ArrayLike) -> float:
    """Writhe of a polygon: its Gauss integral with itself, in turns.

    Parameters
    ----------
    points : (n, 3) array_like
        Vertices. No straight lines are added to the ends. The polygon is closed where the last
        vertex is the first.

    Returns
    -------
    float
        Exact for the polygon.

    Raises
    ------
    ValueError
        If `points` has a wrong shape or is not finite.

    Examples
    --------
    >>> print(round(writhe([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0.5, 0.5, 1], [0.5, -1, 0.2]]), 4))
    0.4277
    """
    r = _rows(points, (3,), "points")
    if _meet(r):
        # the corner must be one, or the first and the last edge would wind about each other
        r[-1] = r[0]
    return float(polygon.gauss_integral(r))


def _meet(points: Array) -> bool:
    """Whether the last point is the first, within what a solver leaves."""
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    return bool(np.linalg.norm(points[-1] - points[0]) <= _ONE * length)


def net_winding(
    points: ArrayLike,
    frames: ArrayLike,
    turns: float | None = None,
    direction: ArrayLike | None = None,
) -> float:
    """Net winding of a rod: twist plus writhe (eq. 43), exact to rounding.

    The writhe is the polar one, and that of Gauss's integral for a rod that is closed with one
    tangent; with closed frames the result is then the linking number.

    Parameters
    ----------
    points : (n, 3) array_like
        Points of the center line; some hundred.
    frames : (n, 3, 3) array_like
        Frames at these points, columns d1, d2, d3. Only those at the two ends enter the fractional
        part of the result; the others choose the integer.
    turns : float, optional
        The rod's twist in turns where it is given, M3 L/(2π K3); else :func:`twist` of `frames`.
    direction : (3,) array_like, optional
        Normal of the two planes; by default the direction between the end tangents. The module's
        head says how the rod is continued to the planes. Of no effect for a closed rod.

    Returns
    -------
    float
        In turns. Subtract the twist to have the writhe.

    Raises
    ------
    ValueError
        If an argument has a wrong shape or is not finite.

    Examples
    --------
    >>> z = np.linspace(0, 1, 9)
    >>> line = np.array([0 * z, 0 * z, z]).T
    >>> frames = [[[np.cos(9 * a), -np.sin(9 * a), 0], [np.sin(9 * a), np.cos(9 * a), 0], [0, 0, 1]]
    ...           for a in z]
    >>> print(round(net_winding(line, frames) * 2 * np.pi, 12))
    9.0
    """
    r, line = _rows(frames, (3, 3), "frames"), _rows(points, (3,), "points")
    closed = _meet(line) and np.linalg.norm(r[-1, :, 2] - r[0, :, 2]) <= _ONE
    if closed or direction is None:
        between = r[0, :, 2] + r[-1, :, 2]
        direction = between if np.linalg.norm(between) > 1e-6 else r[0, :, 0]
    axes = _axes(direction)
    estimate = twist(r) if turns is None else float(turns)
    estimate += writhe(line) if closed else polar_writhe(line, r[:, :, 2], direction)
    ends = []
    for frame in (axes @ r[0], axes @ r[-1]):
        # ψ + φ about the direction, from (1 + cos θ) e^{i(ψ+φ)}
        ends.append(math.atan2(frame[1, 0] - frame[0, 1], frame[0, 0] + frame[1, 1]))
    exact = (ends[1] - ends[0]) / (2.0 * math.pi)
    return exact + round(estimate - exact)
