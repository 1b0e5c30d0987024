"""The rod from its loads (q2 of the paper, eq. 22) with its exact Jacobian.

In the start frame, with L = K0 = 1, the loads f = (F, M0) at s = 0 (eq. 21) fix the rod: the
force F is constant (eq. 3a), the moment is M(s) = M0 + F × r(s) (eq. 3b), and

    r' = t = d3,      q' = ½ (0, M) q,                                     (eq. 1, 2, 4)

for the quaternion q of the frame when K30 = 1. Any other K30 only spins the frame about its own
tangent by M3 (1/K30 − 1) s, M3 = M·d3 being constant (eq. 10); so it is added at the end.

Variations of the loads move the rod by a small rotation δθ and displacement δr (space frame):

    δθ' = M × δθ + δM0 + δF × r + F × δr,      δr' = δθ × t.

They are integrated along with the rod, which makes the 6×6 Jacobian exact to the accuracy of the
integrator: Hairer's explicit Runge–Kutta method of order 8 (DOP853) with a fixed step. The number
of steps follows from the load: the Hamiltonian ½|M|² + F·t is constant, hence
|M(s)|² ≤ |M0|² + 2 F·t(0) + 2|F|, and the step is a fixed fraction of 1/max|M|. The quaternion is
normalized after each step.

State vector (43): r (0–2), q (3–6), then the rows δθx δθy δθz δrx δry δrz (7–42), six columns
each, one per component of f. Without the Jacobian only the first 7 are integrated.
"""

import math

import numpy as np

from loopelastica.rod.kernels import dop853 as d
from loopelastica.rod.kernels.dop853 import STAGES as _STAGES
from loopelastica.rod.kernels.dop853 import STRIDE, stage
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.rotations import spin, tangent

POSE = 7
WITH_JACOBIAN = STRIDE


@kernel
def moment_bound(f):
    """Largest |M(s)| any rod with these loads can have (from the constant Hamiltonian)."""
    force = math.sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2])
    return math.sqrt(max(f[3] * f[3] + f[4] * f[4] + f[5] * f[5] + 2.0 * f[2] + 2.0 * force, force))


@kernel
def step_count(f, density):
    """Steps for a unit length: ``density`` per radian of the fastest turning."""
    return 2 + int(density * min(moment_bound(f), 1e6))


@kernel
def rate(f, y):
    """Slope (7) of the pose ``y`` (7), both as floats."""
    rx, ry, rz, w, x, v, z = y
    mx = f[3] + f[1] * rz - f[2] * ry
    my = f[4] + f[2] * rx - f[0] * rz
    mz = f[5] + f[0] * ry - f[1] * rx
    return (
        2.0 * (x * z + w * v),
        2.0 * (v * z - w * x),
        w * w + z * z - x * x - v * v,
        -0.5 * (mx * x + my * v + mz * z),
        0.5 * (mx * w + my * z - mz * v),
        0.5 * (my * w + mz * x - mx * z),
        0.5 * (mz * w + mx * v - my * x),
    )


@kernel
def plus(y, a, k):
    """The sum y + a k of seven floats each."""
    return (
        y[0] + a * k[0],
        y[1] + a * k[1],
        y[2] + a * k[2],
        y[3] + a * k[3],
        y[4] + a * k[4],
        y[5] + a * k[5],
        y[6] + a * k[6],
    )


@kernel
def _pose_step(f, y, h):
    """One step of length ``h`` from the pose ``y``, seven floats.

    What a stage takes of the newest slope is added last: the sums of one stage then go on while
    the slope of the one before is still computed.
    """
    k0 = rate(f, y)
    k1 = rate(f, plus(y, h * d.A1_0, k0))
    k2 = rate(f, plus(plus(y, h * d.A2_0, k0), h * d.A2_1, k1))
    k3 = rate(f, plus(plus(y, h * d.A3_0, k0), h * d.A3_2, k2))
    z = plus(plus(y, h * d.A4_0, k0), h * d.A4_2, k2)
    k4 = rate(f, plus(z, h * d.A4_3, k3))
    z = plus(plus(y, h * d.A5_0, k0), h * d.A5_3, k3)
    k5 = rate(f, plus(z, h * d.A5_4, k4))
    z = plus(plus(y, h * d.A6_0, k0), h * d.A6_3, k3)
    k6 = rate(f, plus(plus(z, h * d.A6_4, k4), h * d.A6_5, k5))
    z = plus(plus(y, h * d.A7_0, k0), h * d.A7_3, k3)
    z = plus(plus(z, h * d.A7_4, k4), h * d.A7_5, k5)
    k7 = rate(f, plus(z, h * d.A7_6, k6))
    z = plus(plus(y, h * d.A8_0, k0), h * d.A8_3, k3)
    z = plus(plus(z, h * d.A8_4, k4), h * d.A8_5, k5)
    k8 = rate(f, plus(plus(z, h * d.A8_6, k6), h * d.A8_7, k7))
    z = plus(plus(y, h * d.A9_0, k0), h * d.A9_3, k3)
    z = plus(plus(z, h * d.A9_4, k4), h * d.A9_5, k5)
    z = plus(plus(z, h * d.A9_6, k6), h * d.A9_7, k7)
    k9 = rate(f, plus(z, h * d.A9_8, k8))
    z = plus(plus(y, h * d.A10_0, k0), h * d.A10_3, k3)
    z = plus(plus(z, h * d.A10_4, k4), h * d.A10_5, k5)
    z = plus(plus(z, h * d.A10_6, k6), h * d.A10_7, k7)
    k10 = rate(f, plus(plus(z, h * d.A10_8, k8), h * d.A10_9, k9))
    z = plus(plus(y, h * d.A11_0, k0), h * d.A11_3, k3)
    z = plus(plus(z, h * d.A11_4, k4), h * d.A11_5, k5)
    z = plus(plus(z, h * d.A11_6, k6), h * d.A11_7, k7)
    z = plus(plus(z, h * d.A11_8, k8), h * d.A11_9, k9)
    k11 = rate(f, plus(z, h * d.A11_10, k10))
    z = plus(plus(y, h * d.B_0, k0), h * d.B_5, k5)
    z = plus(plus(z, h * d.B_6, k6), h * d.B_7, k7)
    z = plus(plus(z, h * d.B_8, k8), h * d.B_9, k9)
    z = plus(plus(z, h * d.B_10, k10), h * d.B_11, k11)
    norm = 1.0 / math.sqrt(z[3] * z[3] + z[4] * z[4] + z[5] * z[5] + z[6] * z[6])
    return z[0], z[1], z[2], norm * z[3], norm * z[4], norm * z[5], norm * z[6]


@kernel
def _march_pose(f, y, length, n):
    """`march` for the pose alone, which stays in registers: a third of the time."""
    pose, h = (y[0], y[1], y[2], y[3], y[4], y[5], y[6]), length / n
    for _ in range(n):
        pose = _pose_step(f, pose, h)
    y[0], y[1], y[2], y[3], y[4], y[5], y[6] = pose


@kernel
def slope(f, y, k, o, size):
    """Slopes of the rod and, if ``size`` is 43, of its variations, into ``k[o:]``."""
    fx, fy, fz = f[0], f[1], f[2]
    rx, ry, rz = y[0], y[1], y[2]
    mx = f[3] + fy * rz - fz * ry
    my = f[4] + fz * rx - fx * rz
    mz = f[5] + fx * ry - fy * rx
    pose = rate(f, (rx, ry, rz, y[3], y[4], y[5], y[6]))
    tx, ty, tz = pose[0], pose[1], pose[2]
    for c in range(POSE):
        k[o + c] = pose[c]
    if size == POSE:
        return
    for j in range(6):
        ax, ay, az = y[7 + j], y[13 + j], y[19 + j]
        dx, dy, dz = y[25 + j], y[31 + j], y[37 + j]
        k[o + 7 + j] = my * az - mz * ay + fy * dz - fz * dy
        k[o + 13 + j] = mz * ax - mx * az + fz * dx - fx * dz
        k[o + 19 + j] = mx * ay - my * ax + fx * dy - fy * dx
        k[o + 25 + j] = ay * tz - az * ty
        k[o + 31 + j] = az * tx - ax * tz
        k[o + 37 + j] = ax * ty - ay * tx
    # the loads' own share: δF × r in the first three columns, δM0 in the others
    k[o + 13] -= rz
    k[o + 19] += ry
    k[o + 8] += rz
    k[o + 20] -= rx
    k[o + 9] -= ry
    k[o + 15] += rx
    k[o + 10] += 1.0
    k[o + 17] += 1.0
    k[o + 24] += 1.0


@kernel
def march(f, y, length, n, size, k, z):
    """Carry the state ``y`` over ``length`` in ``n`` equal steps, in place.

    With ``size`` = 7 the pose alone; ``k`` (12·43,) and ``z`` (43,) are scratch for the variations.
    K30 = 1 (see the module's head).
    """
    if size == POSE:
        _march_pose(f, y, length, n)
        return
    h = length / n
    for _ in range(n):
        slope(f, y, k, 0, size)
        for i in range(1, _STAGES):
            stage(y, z, k, i, h)
            slope(f, z, k, i * WITH_JACOBIAN, size)
        stage(y, y, k, _STAGES, h)
        norm = 1.0 / math.sqrt(y[3] * y[3] + y[4] * y[4] + y[5] * y[5] + y[6] * y[6])
        for c in range(3, POSE):
            y[c] *= norm


@kernel
def start(y):
    """Set ``y`` to the clamped start: origin, identity, no variation."""
    for c in range(WITH_JACOBIAN):
        y[c] = 0.0
    y[3] = 1.0


@kernel
def shoot(f, torsion_ratio, n, size, y, k, z):
    """The end s = 1 of the rod with loads ``f`` (6,), in ``n`` steps, into ``y``.

    With ``size`` = 43 the columns of ``y[7:]``.reshape(6, 6) are ∂(δθ, δr)/∂f at the end.
    """
    start(y)
    march(f, y, 1.0, n, size, k, z)
    excess = 1.0 / torsion_ratio - 1.0
    if excess != 0.0:
        spin(y[3:POSE], f[5] * excess)
        if size == WITH_JACOBIAN:
            # M3 = f[5] is constant and d3(L) is the axis of the extra spin
            tx, ty, tz = tangent(y[3:POSE])
            y[12] += tx * excess
            y[18] += ty * excess
            y[24] += tz * excess


@kernel
def ends(loads, torsion_ratio, density):
    """End poses of many rods: loads (n, 6) to positions (n, 3) and quaternions (n, 4)."""
    n = loads.shape[0]
    positions, quaternions = np.empty((n, 3)), np.empty((n, 4))
    y, z, k = np.empty(WITH_JACOBIAN), np.empty(WITH_JACOBIAN), np.empty(_STAGES * WITH_JACOBIAN)
    for i in range(n):
        shoot(loads[i], torsion_ratio, step_count(loads[i], density), POSE, y, k, z)
        for c in range(3):
            positions[i, c] = y[c]
        for c in range(4):
            quaternions[i, c] = y[3 + c]
    return positions, quaternions


@kernel
def sample(f, torsion_ratio, node_s, node_pose, s, density):
    """Poses (n, 7) at the sorted arc lengths ``s`` (n,), each from the node before it.

    ``node_s`` (m,) starts at 0; ``node_pose`` (m, 7) holds position and quaternion at K30 = 1, so
    that errors grow over one interval only, however stiff the rod.
    """
    out = np.empty((s.shape[0], POSE))
    y, z, k = np.empty(WITH_JACOBIAN), np.empty(WITH_JACOBIAN), np.empty(_STAGES * WITH_JACOBIAN)
    rate = density * min(moment_bound(f), 1e6)
    excess = 1.0 / torsion_ratio - 1.0
    node, at = 0, node_s[0]
    for c in range(POSE):
        y[c] = node_pose[0, c]
    for i in range(s.shape[0]):
        while node + 1 < node_s.shape[0] and node_s[node + 1] <= s[i]:
            node += 1
            at = node_s[node]
            for c in range(POSE):
                y[c] = node_pose[node, c]
        if s[i] > at:
            march(f, y, s[i] - at, 1 + int(rate * (s[i] - at)), POSE, k, z)
            at = s[i]
        for c in range(POSE):
            out[i, c] = y[c]
        if excess != 0.0:
            spin(out[i, 3:POSE], f[5] * excess * s[i])
    return out
