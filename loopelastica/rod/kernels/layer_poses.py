"""What two boundary layers say of a rod: loads, poses, energy, and how far they are off.

Formulas are those of ``boundary_layers``; ``layers`` is a record of `records.LAYERS`.
"""

import math

import numpy as np

from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.rotations import (
    larger,
    matrix_from_quaternion,
    product,
    rotation_vector,
    spin,
    tangent,
)
from loopelastica.rod.kernels.shooting import POSE, WITH_JACOBIAN, march

_MEETING = 2e-12
_TINY = 1e-300


@kernel
def axis_matrix(layers):
    """Rotation (3, 3) whose third column is the axis of tension."""
    q = np.empty(4)
    q[0], q[1], q[2], q[3] = layers.axis_w, layers.axis_x, layers.axis_y, layers.axis_z
    return matrix_from_quaternion(q)


@kernel
def layers_apart(layers):
    """Whether the two layers are exact in closed form: they do not reach each other."""
    return layers.meeting < _MEETING


@kernel
def layers_loads(layers, f):
    """Loads (6,) at s = 0 in the start frame."""
    root, beta = layers.root, layers.beta
    m = axis_matrix(layers)
    m3 = 2.0 * root * math.sin(beta)
    # M0 = M3 e + F × ρ0, ρ0 = −(2/√f) sin(α0/2) (cos, sin)(φ0 + δ0)
    a = layers.phi_0 + layers.delta_0
    size = 2.0 * root * layers.half_sine_0
    mx, my = size * math.sin(a), -size * math.cos(a)
    for c in range(3):
        f[c] = root * root * m[c, 2]
        f[3 + c] = mx * m[c, 0] + my * m[c, 1] + m3 * m[c, 2]
    # M·d3(0) is M3; the sum above would lose its digits to the bending moments' size √F
    f[5] = m3


@kernel
def _azimuth(x, beta):
    """The part of φ that the layer turns quickly: atan(cot β tanh X), continuous in X."""
    k, c = math.cos(beta), math.sin(beta)
    if c < 0.0:
        return -math.atan2(k * math.tanh(x), -c)
    return math.atan2(k * math.tanh(x), c)


@kernel
def layers_pose(layers, distance, from_end, pose, moment):
    """Pose (7,) and moment (3,), K30 = 1, at ``distance`` from the start or from the end.

    Everything is seen from the start frame; the frame is the one without the extra spin of
    K30 ≠ 1, counted from s = 0.
    """
    root, beta = layers.root, layers.beta
    f = root * root
    k = math.cos(beta)
    m3 = 2.0 * root * math.sin(beta)
    gamma = k * root
    phi_clamp, x0, delta, half_sine = layers.phi_0, layers.x_0, layers.delta_0, layers.half_sine_0
    base_x, base_y, base_z = 0.0, 0.0, 0.0
    if from_end:
        phi_clamp, x0 = layers.phi_1, layers.x_1
        delta, half_sine = layers.delta_1, layers.half_sine_1
        base_x, base_y, base_z = layers.end_x, layers.end_y, layers.end_z
    x = gamma * distance + x0
    sech = 1.0 / math.cosh(min(abs(x), 700.0))
    tanh, tanh0 = math.tanh(x), math.tanh(x0)
    half_sin = k * sech
    # 1 − k² sech² without cancellation at the top of a loop
    half_cos = math.sqrt(math.sin(beta) ** 2 + (k * tanh) ** 2)
    gained = 0.5 * m3 * distance + _azimuth(x, beta) - _azimuth(x0, beta)
    z = distance - 2.0 * k / root * (tanh - tanh0)
    slope = half_sin / max(half_cos, _TINY)
    sign = 1.0 if from_end else -1.0
    phi = phi_clamp - gained if from_end else phi_clamp + gained
    cn, sn = math.cos(phi), math.sin(phi)
    # offset from the axis: along n and along b = e × n
    along = sign / f * slope * 2.0 * gamma * tanh
    across = -1.0 / f * slope * m3
    ox, oy = along * cn - across * sn, along * sn + across * cn
    # the clamp's own offset, the same formula at X = x0 simplified
    a = phi_clamp - delta if from_end else phi_clamp + delta
    size = sign * 2.0 / root * half_sine
    dx, dy = ox - size * math.cos(a), oy - size * math.sin(a)
    dz = -z if from_end else z
    m = axis_matrix(layers)
    pose[0], pose[1], pose[2] = base_x, base_y, base_z
    for c in range(3):
        pose[c] = pose[c] + m[c, 0] * dx + m[c, 1] * dy + m[c, 2] * dz
        # M = M3 e + F × ρ
        moment[c] = -f * oy * m[c, 0] + f * ox * m[c, 1] + m3 * m[c, 2]
    # frame = Q Rz(φ) Ry(θ) Rz(χ); χ gains what φ gains, K30 being 1
    chi = layers.chi_1 - gained if from_end else layers.chi_0 + gained
    total, difference = 0.5 * (phi + chi), 0.5 * (phi - chi)
    pose[3], pose[4], pose[5], pose[6] = product(
        layers.axis_w,
        layers.axis_x,
        layers.axis_y,
        layers.axis_z,
        half_cos * math.cos(total),
        -half_sin * math.sin(difference),
        half_sin * math.cos(difference),
        half_cos * math.sin(total),
    )


@kernel
def layers_energy(layers, torsion_ratio):
    """∫ ½(κ² + K30 τ²) ds: f times the shortening, and the twist."""
    root, beta = layers.root, layers.beta
    shortening = (
        2.0
        * root
        * (
            2.0 * math.cos(beta)
            - math.sqrt(max(1.0 - layers.half_sine_0**2, 0.0)) * math.cos(layers.delta_0)
            - math.sqrt(max(1.0 - layers.half_sine_1**2, 0.0)) * math.cos(layers.delta_1)
        )
    )
    m3 = 2.0 * root * math.sin(beta)
    return shortening + 0.5 * m3 * m3 / torsion_ratio


@kernel
def _pose_distance(a, b):
    """Largest component of position difference and rotation vector between two poses."""
    vx, vy, vz = rotation_vector(a[3:POSE], b[3:POSE])
    worst = larger(larger(abs(vx), abs(vy)), abs(vz))
    for c in range(3):
        worst = larger(worst, abs(a[c] - b[c]))
    return worst if worst == worst else math.inf


@kernel
def check_layers(problem, layers):
    """Largest error of a solution, by integration between points crowded into the layers.

    The closed form is evaluated at the points; the integrator of ``shooting`` is carried from
    each to the next. The layers must also agree where they meet, start at the identity and end at
    the clamping.
    """
    f, pose, ahead = np.empty(6), np.empty(POSE), np.empty(POSE)
    moment, moment_ahead = np.empty(3), np.empty(3)
    y, z, k = np.empty(WITH_JACOBIAN), np.empty(WITH_JACOBIAN), np.empty(12 * WITH_JACOBIAN)
    m = axis_matrix(layers)
    root = layers.root
    gamma = math.cos(layers.beta) * root
    for c in range(3):
        f[c] = root * root * m[c, 2]
    identity = np.zeros(POSE)
    identity[3] = 1.0
    layers_pose(layers, 0.0, False, pose, moment)
    worst = _pose_distance(pose, identity)
    for from_end in (False, True):
        x0 = layers.x_1 if from_end else layers.x_0
        depth = min(0.5, max(38.0 - x0, 1.0) / gamma)
        count = 1 + int(depth * gamma / 0.8)
        step = depth / count
        layers_pose(layers, 0.0, from_end, pose, moment)
        for i in range(count):
            layers_pose(layers, (i + 1) * step, from_end, ahead, moment_ahead)
            # march goes along the chain: start from whichever comes first
            first, second, at_first = pose, ahead, moment
            if from_end:
                first, second, at_first = ahead, pose, moment_ahead
            for c in range(3):
                f[3 + c] = at_first[c]
                y[c] = 0.0
            for c in range(4):
                y[3 + c] = first[3 + c]
            march(f, y, step, 1 + int(2.2 * 2.0 * root * step), POSE, k, z)
            for c in range(3):
                y[c] += first[c]
            worst = larger(worst, _pose_distance(y, second))
            for c in range(POSE):
                pose[c] = ahead[c]
            for c in range(3):
                moment[c] = moment_ahead[c]
    layers_pose(layers, 0.5, False, pose, moment)
    layers_pose(layers, 0.5, True, ahead, moment)
    worst = larger(worst, _pose_distance(pose, ahead))
    layers_pose(layers, 0.0, True, pose, moment)
    spin(pose[3:POSE], 2.0 * root * math.sin(layers.beta) * (1.0 / problem.torsion_ratio - 1.0))
    if problem.free_spin:
        tx, ty, tz = tangent(pose[3:POSE])
        cx, cy, cz = tangent(problem.quaternion)
        return larger(worst, max(abs(tx - cx), abs(ty - cy), abs(tz - cz)))
    for c in range(4):
        ahead[3 + c] = problem.quaternion[c]
    for c in range(3):
        ahead[c] = pose[c]
    return larger(worst, _pose_distance(pose, ahead))


@kernel
def sample_layers(layers, torsion_ratio, s):
    """Poses (n, 7) at arc lengths ``s`` (n,), with the extra spin of K30 ≠ 1."""
    out, moment = np.empty((s.shape[0], POSE)), np.empty(3)
    excess = 2.0 * layers.root * math.sin(layers.beta) * (1.0 / torsion_ratio - 1.0)
    for i in range(s.shape[0]):
        from_end = s[i] > 0.5
        layers_pose(layers, 1.0 - s[i] if from_end else s[i], from_end, out[i], moment)
        spin(out[i, 3:], excess * s[i])
    return out
