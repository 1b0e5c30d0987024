"""Rotations as unit quaternions (w, x, y, z) in compiled code.

Quaternions stand for the rotation matrix R whose columns are d1, d2, d3 seen from the start
frame. All functions take and return plain arrays or tuples of floats.
"""

import math

import numpy as np

from loopelastica.rod.kernels.jit import kernel


@kernel
def larger(a, b):
    """The larger of two numbers; NaN if either is, where max would hide it."""
    return a if a >= b or a != a else b


@kernel
def quaternion_from_matrix(r):
    """Unit quaternion of a rotation matrix (3, 3), by the largest of its four components."""
    q = np.empty(4)
    trace = r[0, 0] + r[1, 1] + r[2, 2]
    if trace >= max(r[0, 0], r[1, 1], r[2, 2]):
        q[0] = 1.0 + trace
        q[1] = r[2, 1] - r[1, 2]
        q[2] = r[0, 2] - r[2, 0]
        q[3] = r[1, 0] - r[0, 1]
    else:
        i = 0
        if r[1, 1] > r[0, 0]:
            i = 1
        if r[2, 2] > r[i, i]:
            i = 2
        j = (i + 1) % 3
        k = (i + 2) % 3
        q[0] = r[k, j] - r[j, k]
        q[1 + i] = 1.0 + r[i, i] - r[j, j] - r[k, k]
        q[1 + j] = r[j, i] + r[i, j]
        q[1 + k] = r[k, i] + r[i, k]
    norm = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    for i in range(4):
        q[i] /= norm
    return q


@kernel
def directors(q):
    """d1, d2 and d3 of a unit quaternion (4,), as nine floats."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    return (
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y),
        2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x),
        2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y),
    )  # fmt: skip


@kernel
def matrix_from_quaternion(q):
    """Rotation matrix (3, 3) of a unit quaternion (4,)."""
    r = np.empty((3, 3))
    (
        r[0, 0], r[1, 0], r[2, 0], r[0, 1], r[1, 1], r[2, 1], r[0, 2], r[1, 2], r[2, 2],
    ) = directors(q)  # fmt: skip
    return r


@kernel
def tangent(q):
    """Third column d3 of the rotation, as three floats."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    return 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)


@kernel
def spin(q, angle):
    """Turn the frame ``q`` about its own d3 by ``angle``, in place."""
    c, s = math.cos(0.5 * angle), math.sin(0.5 * angle)
    w, x, y, z = q[0], q[1], q[2], q[3]
    q[0] = w * c - z * s
    q[1] = x * c + y * s
    q[2] = y * c - x * s
    q[3] = z * c + w * s


@kernel
def rotation_vector(q, p):
    """Rotation vector (space frame) that carries the frame ``p`` to the frame ``q``.

    Returns the vector v with R_q = exp([v]) R_p, |v| ≤ π, and the quaternion's scalar part.
    """
    # q p* with the sign that makes the angle at most pi
    w = q[0] * p[0] + q[1] * p[1] + q[2] * p[2] + q[3] * p[3]
    x = -q[0] * p[1] + q[1] * p[0] - q[2] * p[3] + q[3] * p[2]
    y = -q[0] * p[2] + q[2] * p[0] - q[3] * p[1] + q[1] * p[3]
    z = -q[0] * p[3] + q[3] * p[0] - q[1] * p[2] + q[2] * p[1]
    if w < 0.0:
        w, x, y, z = -w, -x, -y, -z
    s = math.sqrt(x * x + y * y + z * z)
    # 2 atan2(s, w)/s -> 2 as s -> 0; its series is exact to rounding below 1e-5
    factor = 2.0 * math.atan2(s, w) / s if s > 1e-5 else 2.0 / w * (1.0 - s * s / (3.0 * w * w))
    return factor * x, factor * y, factor * z


@kernel
def log_jacobian_inverse(v):
    """Inverse left Jacobian of SO(3) at the rotation vector ``v``.

    If R = exp([v]) changes by exp([δ]) R, then v changes by the returned (3, 3) matrix times δ.
    """
    vx, vy, vz = v[0], v[1], v[2]
    a2 = vx * vx + vy * vy + vz * vz
    if a2 > 1e-4:
        a = math.sqrt(a2)
        c = (1.0 - 0.5 * a / math.tan(0.5 * a)) / a2
    else:
        c = 1.0 / 12.0 + a2 / 720.0 + a2 * a2 / 30240.0
    m = np.empty((3, 3))
    m[0, 0] = 1.0 - c * (vy * vy + vz * vz)
    m[1, 1] = 1.0 - c * (vx * vx + vz * vz)
    m[2, 2] = 1.0 - c * (vx * vx + vy * vy)
    m[0, 1] = 0.5 * vz + c * vx * vy
    m[1, 0] = -0.5 * vz + c * vx * vy
    m[0, 2] = -0.5 * vy + c * vx * vz
    m[2, 0] = 0.5 * vy + c * vx * vz
    m[1, 2] = 0.5 * vx + c * vy * vz
    m[2, 1] = -0.5 * vx + c * vy * vz
    return m
