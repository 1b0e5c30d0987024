"""The finite rod: in its start frame, from its loads to its physical parameters, and back.

Source: Ameline, Haliyo, Huang, Cognet, J. Comput. Phys. 373 (2018) 736,
DOI 10.1016/j.jcp.2018.07.021, eq. 8–28. ``closed_form`` evaluates the infinite rod in Landau's
frame and in units of μ = √(K0/F); here a piece of it is seen from its own start, in units L = K0 =
1.

Legend: p, q unit quaternions (four floats, scalar part first) of the frames at the start and
further on; lam, t_p, a, phi0, s_ini, length the physical parameters (eq. 14), lengths in units of
μ.
"""

import math

import numpy as np

from loopelastica.rod.kernels.closed_form import constants, landau_moment, landau_pose
from loopelastica.rod.kernels.cubic import a_min, roots
from loopelastica.rod.kernels.elliptic import agm_scale, complete_from_scale, incomplete
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.rotations import product

# w s of a homoclinic rod where ρ has fallen below the last digit: e⁻⁴⁰ = 4e-18
FAR = 40.0
# Below this ratio of F to M², or to 1 (L = K0 = 1), the force is no longer felt: Landau's frame
# lies so far away from the rod (ρ ~ M/F) that the closed form would lose half of its digits.
NO_FORCE = 1e-9


@kernel
def turned_back(q0, q1, q2, q3, x, y, z):
    """Rᵀ v, three floats, for the rotation R of the quaternion q and v = (x, y, z)."""
    a = 2.0 * (q3 * y - q2 * z)  # t = −2 q × v, then v + q0 t − q × t
    b = 2.0 * (q1 * z - q3 * x)
    c = 2.0 * (q2 * x - q1 * y)
    return (
        x + q0 * a - (q2 * c - q3 * b),
        y + q0 * b - (q3 * a - q1 * c),
        z + q0 * c - (q1 * b - q2 * a),
    )


@kernel
def _write_rotation(q0, q1, q2, q3, out):
    """Rotation matrix of a quaternion, unit but for rounding, into ``out`` (3, 3)."""
    f = 2.0 / (q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3)
    out[0, 0] = 1.0 - f * (q2 * q2 + q3 * q3)
    out[0, 1] = f * (q1 * q2 - q0 * q3)
    out[0, 2] = f * (q1 * q3 + q0 * q2)
    out[1, 0] = f * (q1 * q2 + q0 * q3)
    out[1, 1] = 1.0 - f * (q1 * q1 + q3 * q3)
    out[1, 2] = f * (q2 * q3 - q0 * q1)
    out[2, 0] = f * (q1 * q3 - q0 * q2)
    out[2, 1] = f * (q2 * q3 + q0 * q1)
    out[2, 2] = 1.0 - f * (q1 * q1 + q2 * q2)


@kernel
def rod_along(lam, t_p, a, phi0, s_ini, length, torsion_ratio, arc):
    """The rod in its start frame (q1 of eq. 20, at any point): positions (n, 3), frames (n, 3, 3).

    ``arc`` (n,) are arc lengths S/L, positions are in units of L, the columns of frames d1, d2, d3.
    """
    n = arc.shape[0]
    position = np.empty((n, 3))
    frame = np.empty((n, 3, 3))
    spin = t_p * (1.0 / torsion_ratio - 1.0)
    c, scale = constants(lam, t_p, a)
    p0, p1, p2, p3, x0, y0, z0 = landau_pose(s_ini, phi0, spin, c, scale)
    for i in range(n):
        q0, q1, q2, q3, x, y, z = landau_pose(s_ini + length * arc[i], phi0, spin, c, scale)
        x, y, z = turned_back(p0, p1, p2, p3, x - x0, y - y0, z - z0)
        position[i, 0], position[i, 1], position[i, 2] = x / length, y / length, z / length
        h0, h1, h2, h3 = product(p0, -p1, -p2, -p3, q0, q1, q2, q3)  # conj(p) q
        _write_rotation(h0, h1, h2, h3, frame[i])
    return position, frame


@kernel
def forceless_along(moment, torsion_ratio, arc):
    """The rod without force, a helix, circle or straight line, as `rod_along`.

    It turns by exp of the constant ``moment`` (3,), given in the start frame in units of K0/L.
    """
    n = arc.shape[0]
    position = np.empty((n, 3))
    frame = np.empty((n, 3, 3))
    size = math.sqrt(moment[0] ** 2 + moment[1] ** 2 + moment[2] ** 2)
    n1, n2, n3 = 0.0, 0.0, 0.0
    if size > 0.0:
        n1, n2, n3 = moment[0] / size, moment[1] / size, moment[2] / size
    spin = moment[2] * (1.0 / torsion_ratio - 1.0)
    for i in range(n):
        s = arc[i]
        angle = size * s
        h = 0.5 * angle
        along = 1.0  # sin(angle)/angle
        across = h  # (1 − cos(angle))/angle
        if abs(h) > 1e-9:
            along = math.sin(angle) / angle
            across = math.sin(h) ** 2 / h
        # ∫ exp(σ [M]×) e3 dσ = n (n·e3) + along (e3 − n (n·e3)) + across n × e3, times s
        rest = (1.0 - along) * n3
        position[i, 0] = s * (rest * n1 + across * n2)
        position[i, 1] = s * (rest * n2 - across * n1)
        position[i, 2] = s * (rest * n3 + along)
        q0, q1, q2, q3 = math.cos(h), math.sin(h) * n1, math.sin(h) * n2, math.sin(h) * n3
        e0, e3 = math.cos(0.5 * spin * s), math.sin(0.5 * spin * s)
        _write_rotation(
            q0 * e0 - q3 * e3, q1 * e0 + q2 * e3, q2 * e0 - q1 * e3, q0 * e3 + q3 * e0, frame[i]
        )
    return position, frame


@kernel
def _loads_at(s, phi0, spin, lam, c, scale):
    """Force and moment, six floats, seen from the frame at s; units of Landau's frame (eq. 12c)."""
    q0, q1, q2, q3, x, y, _ = landau_pose(s, phi0, spin, c, scale)
    f1, f2, f3 = turned_back(q0, q1, q2, q3, 0.0, 0.0, 1.0)
    m1, m2, m3 = landau_moment(x, y, lam)
    m1, m2, m3 = turned_back(q0, q1, q2, q3, m1, m2, m3)
    return f1, f2, f3, m1, m2, m3


@kernel
def loads_from_physical(lam, t_p, a, phi0, s_ini, length, torsion_ratio):
    """F and M at S = 0 in the start frame (eq. 12c and 21), six floats in units L = K0 = 1."""
    c, scale = constants(lam, t_p, a)
    spin = t_p * (1.0 / torsion_ratio - 1.0)
    f1, f2, f3, m1, m2, m3 = _loads_at(s_ini, phi0, spin, lam, c, scale)
    square = length * length
    return square * f1, square * f2, square * f3, length * m1, length * m2, length * m3


@kernel
def physical_from_loads(F1, F2, F3, M1, M2, M3, torsion_ratio):
    """Physical parameters, six floats, from loads in units L = K0 = 1 (eq. 8–11 and 23–28).

    The force is not zero. φ0 lies in [0, 2π) and s_ini in [0, period), or s_ini has any sign where
    the period is infinite. A straight rod that shares (λ, t_P, a) with a homoclinic one is put far
    out on that one's boundary layer.
    """
    force = math.sqrt(F1 * F1 + F2 * F2 + F3 * F3)
    length = math.sqrt(force)
    e1, e2, e3 = F1 / force, F2 / force, F3 / force
    M1, M2, t_p = M1 / length, M2 / length, M3 / length  # eq. 10
    lam = M1 * e1 + M2 * e2 + t_p * e3  # eq. 9
    u = (M1 - lam * e1) ** 2 + (M2 - lam * e2) ** 2 + (t_p - lam * e3) ** 2  # eq. 23, squared
    du = 2.0 * (M1 * e2 - M2 * e1)  # eq. 24, times 2ρ
    a = max(2.0 * e3 + u, a_min(lam, t_p))  # eq. 11

    # eq. 25: u = u3 − (u3 − u2) sn². Of u3 − u and u − u2 the smaller one is taken from
    # u'² = (u3 − u)(u − u2)(u − u1), where it keeps its digits.
    _, _, _, _, u1, u2, u3, d12, d13, d23 = roots(lam, t_p, a)
    s_ini = 0.0
    if d23 > 0.0:
        below, above = max(u3 - u, 0.0), max(u - u2, 0.0)
        if below >= above:
            product = below * (u - u1)
            above = du * du / product if product > 0.0 else 0.0
        else:
            below = du * du / (above * (u - u1))
        m, m1 = d23 / d13, d12 / d13
        x, _ = incomplete(math.sqrt(below), math.sqrt(above), m, m1)
        w = math.sqrt(0.5 * d13)
        K, _ = complete_from_scale(*agm_scale(m, m1))
        if math.isinf(K):
            x = min(x, FAR)
            s_ini = x / w if du <= 0.0 else -x / w
        else:
            x = min(x, K)
            s_ini = x / w if du <= 0.0 or x == 0.0 else (2.0 * K - x) / w

    # eq. 26–28: φ0 turns d1, d2 until both F and M have the components given
    c, scale = constants(lam, t_p, a)
    spin = t_p * (1.0 / torsion_ratio - 1.0)
    f1, f2, _, m1, m2, _ = _loads_at(s_ini, 0.0, spin, lam, c, scale)
    sine = f2 * e1 - f1 * e2 + m2 * M1 - m1 * M2
    cosine = f1 * e1 + f2 * e2 + m1 * M1 + m2 * M2
    phi0 = math.atan2(sine, cosine)
    if phi0 < 0.0:
        phi0 += 2.0 * math.pi
    return lam, t_p, a, phi0, s_ini, length
