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
def slope(f, y, k, o, size):
    """Slopes of the rod and, if ``size`` is 43, of its variations, into ``k[o:]``."""
    fx, fy, fz = f[0], f[1], f[2]
    rx, ry, rz = y[0], y[1], y[2]
    w, x, v, z = y[3], y[4], y[5], y[6]
    mx = f[3] + fy * rz - fz * ry
    my = f[4] + fz * rx - fx * rz
    mz = f[5] + fx * ry - fy * rx
    tx = 2.0 * (x * z + w * v)
    ty = 2.0 * (v * z - w * x)
    tz = w * w + z * z - x * x - v * v
    k[o], k[o + 1], k[o + 2] = tx, ty, tz
    k[o + 3] = -0.5 * (mx * x + my * v + mz * z)
    k[o + 4] = 0.5 * (mx * w + my * z - mz * v)
    k[o + 5] = 0.5 * (my * w + mz * x - mx * z)
    k[o + 6] = 0.5 * (mz * w + mx * v - my * x)
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

    ``k`` (12·43,) and ``z`` (43,) are scratch. K30 = 1 (see the module's head).
    """
    h = length / n
    for _ in range(n):
        slope(f, y, k, 0, size)
        for i in range(1, _STAGES):
            stage(y, z, k, i, h, size)
            slope(f, z, k, i * WITH_JACOBIAN, size)
        stage(y, y, k, _STAGES, h, size)
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
