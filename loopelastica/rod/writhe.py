"""Twist, polar writhe and net winding of an open rod.

Net winding (eq. 43 of Ameline et al., J. Comput. Phys. 373 (2018) 736,
DOI 10.1016/j.jcp.2018.07.021; M. A. Berger & C. Prior, J. Phys. A 39 (2006) 8321,
DOI 10.1088/0305-4470/39/26/005) is the linking number of open ribbons between two parallel planes:
net winding = twist + polar writhe. Where the curve is cut at equal height along a direction e, and
σ = ±1 tells whether a piece rises or falls,

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

Legend: e direction, u edge directions of the polygon; all results are in turns.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from loopelastica._arrays import Array
from loopelastica.rod.kernels.jit import kernel

__all__ = ["net_winding", "polar_writhe", "twist", "writhe"]


@kernel
def _triangle(p: Array, q: Array, pole: float) -> float:
    """Signed area of the spherical triangle (pole·e3, p, q), seen from that pole."""
    volume = p[0] * q[1] - p[1] * q[0]
    cosine = p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
    return 2.0 * math.atan2(pole * volume, 1.0 + pole * (p[2] + q[2]) + cosine)


@kernel
def _local(directions: Array) -> tuple[float, float]:
    """Local polar writhe (times 2π), and Fuller's ∫(t × t')_z/(1 + t_z), along great arcs."""
    polar = 0.0
    north = 0.0
    level = np.zeros(3)
    for k in range(directions.shape[0] - 1):
        p = directions[k]
        q = directions[k + 1]
        north += _triangle(p, q, 1.0)
        if (p[2] >= 0.0) == (q[2] >= 0.0):
            polar += _triangle(p, q, 1.0 if p[2] >= 0.0 else -1.0)
            continue
        for i in range(2):  # the arc is cut where it is level
            level[i] = p[i] * abs(q[2]) + q[i] * abs(p[2])
        size = math.hypot(level[0], level[1])
        if size > 0.0:
            level[0] /= size
            level[1] /= size
            polar += _triangle(p, level, 1.0 if p[2] >= 0.0 else -1.0)
            polar += _triangle(level, q, 1.0 if q[2] >= 0.0 else -1.0)
    return polar, north


@kernel
def _nonlocal(points: Array) -> float:
    """Σ_{i≠j} σ_i σ_j ∫ dΘ_ij over the edges of a polygon, heights along its third coordinate."""
    total = 0.0
    n = points.shape[0] - 1
    for i in range(n):
        za, zb = points[i, 2], points[i + 1, 2]
        if za == zb:
            continue
        i_low, i_high = min(za, zb), max(za, zb)
        for j in range(i + 2, n):  # neighbors meet in a vertex: their azimuth is constant
            zc, zd = points[j, 2], points[j + 1, 2]
            low = max(i_low, min(zc, zd))
            high = min(i_high, max(zc, zd))
            if low >= high:
                continue
            f, g = (low - za) / (zb - za), (low - zc) / (zd - zc)
            x0 = (1 - g) * points[j, 0] + g * points[j + 1, 0]
            x0 -= (1 - f) * points[i, 0] + f * points[i + 1, 0]
            y0 = (1 - g) * points[j, 1] + g * points[j + 1, 1]
            y0 -= (1 - f) * points[i, 1] + f * points[i + 1, 1]
            f, g = (high - za) / (zb - za), (high - zc) / (zd - zc)
            x1 = (1 - g) * points[j, 0] + g * points[j + 1, 0]
            x1 -= (1 - f) * points[i, 0] + f * points[i + 1, 0]
            y1 = (1 - g) * points[j, 1] + g * points[j + 1, 1]
            y1 -= (1 - f) * points[i, 1] + f * points[i + 1, 1]
            angle = math.atan2(x0 * y1 - y0 * x1, x0 * x1 + y0 * y1)
            total += 2.0 * angle if (zb > za) == (zd > zc) else -2.0 * angle
    return total


@kernel
def _solid_angle(points: Array, i: int, j: int, k: int, m: int, n: int, o: int) -> float:
    """Solid angle of the triangle r_j − r_i, r_m − r_k, r_o − r_n seen from the origin."""
    ax, ay, az = (
        points[j, 0] - points[i, 0],
        points[j, 1] - points[i, 1],
        points[j, 2] - points[i, 2],
    )
    bx, by, bz = (
        points[m, 0] - points[k, 0],
        points[m, 1] - points[k, 1],
        points[m, 2] - points[k, 2],
    )
    cx, cy, cz = (
        points[o, 0] - points[n, 0],
        points[o, 1] - points[n, 1],
        points[o, 2] - points[n, 2],
    )
    volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    a = math.sqrt(ax * ax + ay * ay + az * az)
    b = math.sqrt(bx * bx + by * by + bz * bz)
    c = math.sqrt(cx * cx + cy * cy + cz * cz)
    ab = ax * bx + ay * by + az * bz
    bc = bx * cx + by * cy + bz * cz
    ca = cx * ax + cy * ay + cz * az
    return 2.0 * math.atan2(volume, a * b * c + ab * c + bc * a + ca * b)


@kernel
def _writhe(points: Array) -> float:
    """Gauss integral of a polygon with itself: the directions in which two edges cross."""
    total = 0.0
    n = points.shape[0] - 1
    for i in range(n):
        for j in range(i + 2, n):
            # corners of the quadrangle: from both ends of edge i to both ends of edge j
            total -= _solid_angle(points, i, j, i, j + 1, i + 1, j + 1)
            total -= _solid_angle(points, i, j, i + 1, j + 1, i + 1, j)
    return total / (2.0 * math.pi)


def _rows(values: ArrayLike, shape: tuple[int, ...], name: str) -> Array:
    array = np.array(values, dtype=np.float64, order="C")
    if array.shape[1:] != shape or array.shape[0] < 2 or not np.isfinite(array).all():
        raise ValueError(f"`{name}` must be finite, of shape (n,) + {shape} with n at least 2")
    return array


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
    polar, north = _local(np.ascontiguousarray(edges / lengths[:, None]))
    _, smooth_north = _local(np.ascontiguousarray(np.vstack([pole, t, pole])))
    # areas on the sphere are known modulo 4π
    change = math.remainder(smooth_north - north, 4.0 * math.pi)
    return float((polar + change + _nonlocal(r)) / (2.0 * math.pi))


def writhe(points: ArrayLike) -> float:
    """Writhe of an open polygon: its Gauss integral with itself, in turns.

    Parameters
    ----------
    points : (n, 3) array_like
        Vertices. No straight lines are added to the ends.

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
    return float(_writhe(_rows(points, (3,), "points")))


def net_winding(
    points: ArrayLike,
    frames: ArrayLike,
    turns: float | None = None,
    direction: ArrayLike | None = None,
) -> float:
    """Net winding of a rod: twist plus polar writhe (eq. 43), exact to rounding.

    Parameters
    ----------
    points : (n, 3) array_like
        Points of the center line; some hundred.
    frames : (n, 3, 3) array_like
        Frames at these points, columns d1, d2, d3. Only those at the two ends enter the fractional
        part of the result; the others choose the integer.
    turns : float, optional
        The rod's twist in turns where it is known, M3 L/(2π K3); else :func:`twist` of `frames`.
    direction : (3,) array_like, optional
        Normal of the two planes; by default the direction between the end tangents. The module's
        head tells how the rod is continued to the planes.

    Returns
    -------
    float
        In turns. Subtract the twist to have the polar writhe.

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
    r = _rows(frames, (3, 3), "frames")
    if direction is None:
        between = r[0, :, 2] + r[-1, :, 2]
        direction = between if np.linalg.norm(between) > 1e-6 else r[0, :, 0]
    axes = _axes(direction)
    estimate = twist(r) if turns is None else float(turns)
    estimate += polar_writhe(points, r[:, :, 2], direction)
    ends = []
    for frame in (axes @ r[0], axes @ r[-1]):
        # ψ + φ about the direction, from (1 + cos θ) e^{i(ψ+φ)}
        ends.append(math.atan2(frame[1, 0] - frame[0, 1], frame[0, 0] + frame[1, 1]))
    exact = (ends[1] - ends[0]) / (2.0 * math.pi)
    return exact + round(estimate - exact)
