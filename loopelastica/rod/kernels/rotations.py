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
def product(p0, p1, p2, p3, q0, q1, q2, q3):
    """Quaternion product p q, as four floats."""
    return (
        p0 * q0 - p1 * q1 - p2 * q2 - p3 * q3,
        p0 * q1 + p1 * q0 + p2 * q3 - p3 * q2,
        p0 * q2 - p1 * q3 + p2 * q0 + p3 * q1,
        p0 * q3 + p1 * q2 - p2 * q1 + p3 * q0,
    )


@kernel
def multiply(p, q, out):
    """Quaternion product p q of arrays (4,) into ``out``."""
    out[0], out[1], out[2], out[3] = product(p[0], p[1], p[2], p[3], q[0], q[1], q[2], q[3])


@kernel
def relative(p, q, out):
    """Quaternion product p* q into ``out``: q as seen from p."""
    out[0], out[1], out[2], out[3] = product(p[0], -p[1], -p[2], -p[3], q[0], q[1], q[2], q[3])


@kernel
def exponential(x, y, z):
    """Quaternion (w, x, y, z) of the turn by a rotation vector."""
    a2 = x * x + y * y + z * z
    a = math.sqrt(a2)
    s = math.sin(0.5 * a) / a if a > 1e-8 else 0.5 - a2 / 48.0
    return math.cos(0.5 * a), s * x, s * y, s * z


@kernel
def logarithm(w, x, y, z):
    """Rotation vector (3 floats), |v| ≤ π, of a unit quaternion of either sign."""
    if w < 0.0:
        w, x, y, z = -w, -x, -y, -z
    s = math.sqrt(x * x + y * y + z * z)
    # 2 atan2(s, w)/s -> 2 as s -> 0; its series is exact to rounding below 1e-5
    factor = 2.0 * math.atan2(s, w) / s if s > 1e-5 else 2.0 / w * (1.0 - s * s / (3.0 * w * w))
    return factor * x, factor * y, factor * z


@kernel
def turn(q, x, y, z):
    """Turn the frame ``q`` by the rotation vector (x, y, z) of its own frame, in place."""
    c, px, py, pz = exponential(x, y, z)
    w, x, y, z = product(q[0], q[1], q[2], q[3], c, px, py, pz)
    norm = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    q[0], q[1], q[2], q[3] = norm * w, norm * x, norm * y, norm * z


@kernel
def turn_in_space(q, x, y, z):
    """Turn the frame ``q`` by the rotation vector (x, y, z) of space, in place."""
    c, px, py, pz = exponential(x, y, z)
    w, x, y, z = product(c, px, py, pz, q[0], q[1], q[2], q[3])
    norm = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    q[0], q[1], q[2], q[3] = norm * w, norm * x, norm * y, norm * z


@kernel
def about_axis(x, y, z, angle, out):
    """Quaternion of a turn by ``angle`` about the unit vector (x, y, z), into ``out``."""
    s = math.sin(0.5 * angle)
    out[0], out[1], out[2], out[3] = math.cos(0.5 * angle), s * x, s * y, s * z


@kernel
def align(ex, ey, ez, out):
    """Shortest rotation that carries e3 to the unit vector e, as a quaternion into ``out``."""
    if ez > -0.999999:
        norm = math.sqrt(2.0 * (1.0 + ez))
        out[0], out[1], out[2], out[3] = 0.5 * norm, -ey / norm, ex / norm, 0.0
    else:
        # e is opposite: turn about an axis across, here d1, first
        norm = math.sqrt(2.0 * (1.0 - ez))
        out[0], out[1], out[2], out[3] = -ey / norm, 0.5 * norm, 0.0, ex / norm


@kernel
def zyz_angles(w, x, y, z):
    """ZYZ Euler angles (ψ, θ, φ) of a quaternion; ψ and φ in (−2π, 2π), θ in [0, π].

    Accurate at θ = 0 and π too, where only ψ ± φ is defined.
    """
    half_sum, half_difference = math.atan2(z, w), math.atan2(-x, y)
    theta = 2.0 * math.atan2(math.hypot(x, y), math.hypot(w, z))
    return half_sum + half_difference, theta, half_sum - half_difference


@kernel
def wrap(angle):
    """The angle modulo 2π in [−π, π)."""
    return angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))


@kernel
def end_turn(quaternion, q):
    """φ + χ gained from the start to the end frame about the axis of ``q``, in [−π, π)."""
    phi0, _, chi0 = zyz_angles(q[0], -q[1], -q[2], -q[3])
    p = np.empty(4)
    relative(q, quaternion, p)
    phi1, _, chi1 = zyz_angles(p[0], p[1], p[2], p[3])
    return wrap(phi1 + chi1 - phi0 - chi0)


@kernel
def spin_between(p, q):
    """Turn in (−2π, 2π] about the tangent from the frame ``p`` to ``q``, which has the same one."""
    w = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3]
    z = p[0] * q[3] - p[3] * q[0] - p[1] * q[2] + p[2] * q[1]
    return 2.0 * math.atan2(z, w)


@kernel
def cross(ax, ay, az, bx, by, bz):
    """Cross product a × b, as three floats."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


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

    Returns the vector v with R_q = exp([v]) R_p, |v| ≤ π, as three floats.
    """
    # the product q p*
    return logarithm(*product(q[0], q[1], q[2], q[3], p[0], -p[1], -p[2], -p[3]))


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
