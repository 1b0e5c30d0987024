"""Writhe of polygons: areas of spherical triangles, azimuths of pairs of edges, solid angles.

``loopelastica.rod.writhe`` has the theory. Polygons are arrays (n, 3) of vertices, heights are
along the third coordinate.
"""

import math

import numpy as np

from loopelastica.rod.kernels.jit import kernel


@kernel
def _triangle(p, q, pole):
    """Signed area on the sphere of the triangle of pole·e3 and unit vectors ``p``, ``q`` (3,)."""
    volume = p[0] * q[1] - p[1] * q[0]
    cosine = p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
    return 2.0 * math.atan2(pole * volume, 1.0 + pole * (p[2] + q[2]) + cosine)


@kernel
def local_polar_writhe(directions):
    """Local polar writhe (times 2π), and Fuller's ∫(t × t')_z/(1 + t_z), along great arcs.

    The arcs join ``directions`` (n, 3), unit vectors.
    """
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
def _across(points, i, j, height):
    """Two floats: the vector across the height from edge i to edge j of ``points`` (n, 3)."""
    za, zc = points[i, 2], points[j, 2]
    f, g = (height - za) / (points[i + 1, 2] - za), (height - zc) / (points[j + 1, 2] - zc)
    x = (1 - g) * points[j, 0] + g * points[j + 1, 0]
    x -= (1 - f) * points[i, 0] + f * points[i + 1, 0]
    y = (1 - g) * points[j, 1] + g * points[j + 1, 1]
    y -= (1 - f) * points[i, 1] + f * points[i + 1, 1]
    return x, y


@kernel
def nonlocal_polar_writhe(points):
    """Σ_{i≠j} σ_i σ_j ∫ dΘ_ij over the edges of a polygon ``points`` (n, 3)."""
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
            x0, y0 = _across(points, i, j, low)
            x1, y1 = _across(points, i, j, high)
            angle = math.atan2(x0 * y1 - y0 * x1, x0 * x1 + y0 * y1)
            total += 2.0 * angle if (zb > za) == (zd > zc) else -2.0 * angle
    return total


@kernel
def _between(points, i, j):
    """r_j − r_i of ``points`` (n, 3), as three floats."""
    return (
        points[j, 0] - points[i, 0],
        points[j, 1] - points[i, 1],
        points[j, 2] - points[i, 2],
    )


@kernel
def _solid_angle(points, i, j, k, m, n, o):
    """Solid angle of the triangle r_j − r_i, r_m − r_k, r_o − r_n seen from the origin."""
    ax, ay, az = _between(points, i, j)
    bx, by, bz = _between(points, k, m)
    cx, cy, cz = _between(points, n, o)
    volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    a = math.sqrt(ax * ax + ay * ay + az * az)
    b = math.sqrt(bx * bx + by * by + bz * bz)
    c = math.sqrt(cx * cx + cy * cy + cz * cz)
    ab = ax * bx + ay * by + az * bz
    bc = bx * cx + by * cy + bz * cz
    ca = cx * ax + cy * ay + cz * az
    return 2.0 * math.atan2(volume, a * b * c + ab * c + bc * a + ca * b)


@kernel
def gauss_integral(points):
    """Gauss integral, in turns, of a polygon ``points`` (n, 3) with itself.

    It is the number of signed crossings of its edges, averaged over all directions of view.
    """
    total = 0.0
    n = points.shape[0] - 1
    for i in range(n):
        for j in range(i + 2, n):
            # corners of the quadrangle: from both ends of edge i to both ends of edge j
            total -= _solid_angle(points, i, j, i, j + 1, i + 1, j + 1)
            total -= _solid_angle(points, i, j, i + 1, j + 1, i + 1, j)
    return total / (2.0 * math.pi)
