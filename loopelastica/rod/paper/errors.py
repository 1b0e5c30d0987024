"""The end of the rod as the paper measures it: clamping parameters, errors, the mapping q2.

Ameline et al., J. Comput. Phys. 373 (2018) 736, DOI 10.1016/j.jcp.2018.07.021. A pose is an array
(7,): position (η1, η2, η3) and unit quaternion of the end frame in the start frame.

- Clamping parameters (eq. 6): ZYZ Euler angles with ψ, φ in [0, 2π) and θ in [0, π]. Turned about
  the start tangent until η1 ≥ 0 and η2 = 0 (eq. 16, 19), five are left (eq. 17).
- Errors of a pose against a target (eq. 30–32): ε1 is the plain difference of the clamping
  parameters, with the tears of the Euler angles, as printed; ε2 has the angles of the target's
  directors d_i projected across the directors d̄_j of the pose; ε3 has sin(γ/2) u, the vector
  part of the quaternion that takes the pose's frame to the target's, seen from the pose's.
- q2 (eq. 22): from loads through the physical parameters to the closed form, or by Bulirsch and
  Stoer's method where |t_P ± λ| < 1e-2 (end of section 2.4).

Legend: f loads (6,), y pose (7,), q clamping parameters (5,) or (6,), e error ε (6,).
"""

import math

import numpy as np

from loopelastica.rod.kernels.closed_form import (
    D23,
    QUARTER,
    RATE,
    U2,
    constants,
    landau_pose,
)
from loopelastica.rod.kernels.cubic import a_min
from loopelastica.rod.kernels.elliptic import incomplete
from loopelastica.rod.kernels.finite_rod import FAR, NO_FORCE, turned_back
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.rotations import product, quaternion_from_matrix, zyz_angles
from loopelastica.rod.kernels.shooting import POSE, WITH_JACOBIAN, moment_bound, shoot, step_count
from loopelastica.rod.paper import bulirsch_stoer

EPS1, EPS2, EPS3 = 1, 2, 3
PRINTED, ANALYTIC, NUMERICAL = 0, 1, 2

TURN = 2.0 * math.pi
# |t_P ± λ| below which q2 is integrated (end of section 2.4)
_SINGULAR = 1e-2
# error per step of the integration: finite differences of step 1e-5 |f| shall not see it
_RTOL = 1e-12
# steps per radian of the project's own integrator: 1e-11
_DENSITY = 4.0


@kernel
def wrapped(angle):
    """The angle in [0, 2π)."""
    angle = angle % TURN
    return angle if angle < TURN else 0.0


@kernel
def reduced_parameters(y, q):
    """Clamping parameters ``q`` (5,) of the pose ``y`` (7,), eq. 17; returns φ_a (eq. 19)."""
    psi, theta, phi = zyz_angles(y[3], y[4], y[5], y[6])
    angle = math.atan2(y[1], y[0]) if y[0] != 0.0 or y[1] != 0.0 else 0.0
    q[0], q[1] = math.hypot(y[0], y[1]), y[2]
    q[2], q[3], q[4] = wrapped(psi - angle), theta, wrapped(phi + angle)
    return angle


@kernel
def pose_of_parameters(q, y):
    """The pose ``y`` (7,) with η2 = 0 and clamping parameters ``q`` (5,)."""
    y[0], y[1], y[2] = q[0], 0.0, q[1]
    plus, minus, half = 0.5 * (q[2] + q[4]), 0.5 * (q[2] - q[4]), 0.5 * q[3]
    y[3] = math.cos(half) * math.cos(plus)
    y[4] = -math.sin(half) * math.sin(minus)
    y[5] = math.sin(half) * math.cos(minus)
    y[6] = math.cos(half) * math.sin(plus)


@kernel
def pose_of_frame(position, rotation, y):
    """The pose ``y`` (7,) of a position (3,) and a rotation matrix (3, 3)."""
    y[:3] = position
    y[3:POSE] = quaternion_from_matrix(rotation)


@kernel
def error(kind, y, target, e):
    """Error ``e`` (6,) of the pose ``y`` (7,) against ``target`` (7,), eq. 30, 31 or 32."""
    for c in range(3):
        e[c] = target[c] - y[c]
    if kind == EPS1:
        psi, theta, phi = zyz_angles(y[3], y[4], y[5], y[6])
        psi_t, theta_t, phi_t = zyz_angles(target[3], target[4], target[5], target[6])
        e[3] = wrapped(psi_t) - wrapped(psi)  # eq. 30
        e[4] = theta_t - theta
        e[5] = wrapped(phi_t) - wrapped(phi)
        return
    # the target's frame seen from the pose's
    w, a, b, c3 = product(y[3], -y[4], -y[5], -y[6], target[3], target[4], target[5], target[6])
    if kind == EPS3:  # eq. 32, γ in [0, π]
        sign = 1.0 if w >= 0.0 else -1.0
        e[3], e[4], e[5] = sign * a, sign * b, sign * c3
        return
    # eq. 31: d̄_i · d_j is the entry (i, j) of the relative rotation
    e[3] = math.atan2(2.0 * (b * c3 + w * a), 1.0 - 2.0 * (a * a + c3 * c3))
    e[4] = math.atan2(2.0 * (a * c3 + w * b), 1.0 - 2.0 * (a * a + b * b))
    e[5] = math.atan2(2.0 * (a * b + w * c3), 1.0 - 2.0 * (b * b + c3 * c3))


@kernel
def physical_pose(lam, t_p, a, s_ini, length, torsion_ratio, y):
    """Pose ``y`` (7,) of the rod with five physical parameters and φ0 = 0 (q1, eq. 20)."""
    c, scale = constants(lam, t_p, a)
    spin = t_p * (1.0 / torsion_ratio - 1.0)
    seen_from(
        landau_pose(s_ini, 0.0, spin, c, scale),
        landau_pose(s_ini + length, 0.0, spin, c, scale),
        length,
        y,
    )


@kernel
def seen_from(first, second, length, y):
    """Pose ``y`` (7,) of ``second`` seen from ``first``, poses in Landau's frame (seven floats).

    Positions there are in units of μ, ``length`` is L/μ, and η comes in units of L.
    """
    p0, p1, p2, p3, x0, y0, z0 = first
    q0, q1, q2, q3, x, v, z = second
    x, v, z = (x - x0) / length, (v - y0) / length, (z - z0) / length
    y[0], y[1], y[2] = turned_back(p0, p1, p2, p3, x, v, z)
    y[3], y[4], y[5], y[6] = product(p0, -p1, -p2, -p3, q0, q1, q2, q3)


@kernel
def turn(values, angle):
    """Turn a force and a moment (6,) about d3 by ``angle``, in place."""
    c, s = math.cos(angle), math.sin(angle)
    for i in (0, 3):
        first = values[i]
        values[i] = c * first - s * values[i + 1]
        values[i + 1] = s * first + c * values[i + 1]


@kernel
def end(f, torsion_ratio, forward, y):
    """The mapping q2 (eq. 22): end pose ``y`` (7,) of loads ``f`` (6,); False if it fails.

    ``forward`` selects PRINTED (the paper's automatic choice), ANALYTIC or NUMERICAL (Bulirsch and
    Stoer).
    """
    # not a number must fail as well
    if not moment_bound(f) < 1e4:
        return False
    force = math.sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2])
    moment2 = f[3] * f[3] + f[4] * f[4] + f[5] * f[5]
    numerical = forward == NUMERICAL or force <= NO_FORCE * max(1.0, moment2)
    if forward == PRINTED and not numerical:
        mu = 1.0 / math.sqrt(force)
        t_p = f[5] * mu  # eq. 10
        lam = (f[0] * f[3] + f[1] * f[4] + f[2] * f[5]) * mu / force  # eq. 9
        numerical = abs(t_p + lam) < _SINGULAR or abs(t_p - lam) < _SINGULAR
    if numerical:
        return bulirsch_stoer.end_pose(f, torsion_ratio, _RTOL, y) > 0
    analytic(f, force, torsion_ratio, y)
    return True


@kernel
def project_end(f, torsion_ratio, y):
    """`end` by the package's own integrator, which the printed method never uses."""
    if not moment_bound(f) < 1e4:
        return False
    state, z, k = np.empty(WITH_JACOBIAN), np.empty(WITH_JACOBIAN), np.empty(12 * WITH_JACOBIAN)
    shoot(f, torsion_ratio, step_count(f, _DENSITY), POSE, state, k, z)
    y[:] = state[:POSE]
    return True


@kernel
def analytic(f, force, torsion_ratio, y):
    """Closed form of q2: loads (6,) → p (eq. 8–11, 23–28) → q1, with the constants found once.

    The same formulas as ``physical_from_loads`` and q1 one after the other, at half the cost.
    """
    length = math.sqrt(force)
    e1, e2, e3 = f[0] / force, f[1] / force, f[2] / force
    M1, M2, t_p = f[3] / length, f[4] / length, f[5] / length  # eq. 10
    lam = M1 * e1 + M2 * e2 + t_p * e3  # eq. 9
    u = (M1 - lam * e1) ** 2 + (M2 - lam * e2) ** 2 + (t_p - lam * e3) ** 2  # eq. 23, squared
    du = 2.0 * (M1 * e2 - M2 * e1)  # eq. 24, times 2ρ
    c, scale = constants(lam, t_p, max(2.0 * e3 + u, a_min(lam, t_p)))  # eq. 11
    # eq. 25; u runs from u2 to u2 + 2 d23, and u − u1 = u − u2 + 2 d12
    m, m1 = scale[2, 0] * scale[2, 0], scale[1, 0] * scale[1, 0]
    u2, d23, w, K = c[U2], c[D23], c[RATE], c[QUARTER]
    d12 = 2.0 * w * w * m1
    s_ini = 0.0
    if d23 > 0.0:
        below, above = max(u2 + 2.0 * d23 - u, 0.0), max(u - u2, 0.0)
        if below >= above:
            product = below * (above + 2.0 * d12)
            above = du * du / product if product > 0.0 else 0.0
        else:
            below = du * du / (above * (above + 2.0 * d12))
        x, _ = incomplete(math.sqrt(below), math.sqrt(above), m, m1)
        x = min(x, K, FAR)
        s_ini = x / w if du <= 0.0 else -x / w
    # eq. 26–28: φ0 turns d1, d2 until both F and M have the components given
    spin = t_p * (1.0 / torsion_ratio - 1.0)
    first = landau_pose(s_ini, 0.0, spin, c, scale)
    q0, q1, q2, q3, x, v, _ = first
    f1, f2 = 2.0 * (q1 * q3 - q0 * q2), 2.0 * (q2 * q3 + q0 * q1)  # e_k seen from the frame
    m1, m2 = _turn_back_flat(q0, q1, q2, q3, -v, x, lam)
    sine = f2 * e1 - f1 * e2 + m2 * M1 - m1 * M2
    cosine = f1 * e1 + f2 * e2 + m1 * M1 + m2 * M2
    seen_from(first, landau_pose(s_ini + length, 0.0, spin, c, scale), length, y)
    turn_pose(y, -math.atan2(sine, cosine))


@kernel
def _turn_back_flat(q0, q1, q2, q3, x, y, z):
    """First two components of Rᵀ v, v = (x, y, z), for the rotation R of a unit quaternion."""
    return (
        (1.0 - 2.0 * (q2 * q2 + q3 * q3)) * x
        + 2.0 * (q1 * q2 + q0 * q3) * y
        + 2.0 * (q1 * q3 - q0 * q2) * z,
        2.0 * (q1 * q2 - q0 * q3) * x
        + (1.0 - 2.0 * (q1 * q1 + q3 * q3)) * y
        + 2.0 * (q2 * q3 + q0 * q1) * z,
    )


@kernel
def turn_pose(y, angle):
    """Turn a pose (7,) about the start tangent by ``angle`` (eq. 16), in place."""
    c, s = math.cos(angle), math.sin(angle)
    y[0], y[1] = c * y[0] - s * y[1], s * y[0] + c * y[1]
    # conjugation by the turn moves the quaternion's vector part
    y[4], y[5] = c * y[4] - s * y[5], s * y[4] + c * y[5]
