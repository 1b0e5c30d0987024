"""Discrete rods to begin with, and what a discrete rod hands on: loads and nodes.

Nodes are crowded at the ends, where a tense rod has its boundary layers of width 1/√F.
"""

import math

import numpy as np

from loopelastica.rod.kernels.boundary_layers import planar_start
from loopelastica.rod.kernels.discrete_rod import hinge_length, hinge_vector
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.rotations import (
    about_axis,
    align,
    cross,
    matrix_from_quaternion,
    multiply,
    relative,
    tangent,
    turn,
    wrap,
)

# Newton steps for a node, and the error of its place that is none
_NODE_STEPS, _NODE_ERROR = 20, 1e-9


@kernel
def graded_nodes(root, s):
    """Arc lengths s (n + 1,) with density 1 + (q/2)(e^(−qs) + e^(−q(1−s))), q = √F/2."""
    n = s.shape[0] - 1
    q = 0.5 * root
    whole = math.exp(-q)
    total, at = 2.0 - whole, 0.0
    for i in range(1, n // 2 + 1):
        # the integral of the density is concave up to the middle: Newton's method from the node
        # before stays on its side
        share = total * i / n
        for _ in range(_NODE_STEPS):
            near, far = math.exp(-q * at), math.exp(-q * (1.0 - at))
            lack = share - at - 0.5 * (1.0 - near + far - whole)
            at += lack / (1.0 + 0.5 * q * (near + far))
            if lack < _NODE_ERROR:
                break
        s[i], s[n - i] = at, 1.0 - at
    s[0], s[n] = 0.0, 1.0


@kernel
def _layer(s, root, half_angle_tan):
    """Angle at distance ``s`` from an end: tan(θ/4) = tan(α/4) sinh(√f(1−s))/sinh √f."""
    if root < 1e-3:
        ratio = 1.0 - s
    else:
        ratio = math.exp(-root * s) * (
            (1.0 - math.exp(-2.0 * root * (1.0 - s))) / (1.0 - math.exp(-2.0 * root))
        )
    return 4.0 * math.atan(half_angle_tan * ratio)


@kernel
def start_frames(problem, start, rod, force):
    """Fill the nodes and frames of a discrete ``rod`` and its ``force`` (3,) from a start.

    The frames go from the start clamp through an axis under tension to the end clamp, with the
    start's number of turns spread evenly (see ``boundary_layers.solve_layers``).
    """
    quaternion, s, frames = problem.quaternion, rod.s, rod.frames
    n = s.shape[0] - 1
    root, ex, ey, ez = planar_start(problem, start.over_0, start.over_1)
    if root < 0.5:
        root = 0.5
    root = min(root, 200.0)
    graded_nodes(root, s)
    tx, ty, tz = tangent(quaternion)
    # B carries e3 to e the shortest way; the end frame is Rot(a1, α1) B Rz(twist)
    b, spun, turn0, turn1 = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    first, second = np.empty(4), np.empty(4)
    align(ex, ey, ez, b)
    alpha0 = 2.0 * math.atan2(
        math.sqrt(max(0.5 * (1.0 - ez), 0.0)), math.sqrt(max(0.5 * (1.0 + ez), 0.0))
    )
    # axis of B
    norm0 = math.sqrt(b[1] * b[1] + b[2] * b[2] + b[3] * b[3])
    if norm0 > 1e-12:
        ax, ay, az = b[1] / norm0, b[2] / norm0, b[3] / norm0
    else:
        ax, ay, az = 1.0, 0.0, 0.0
    cx, cy, cz = cross(ex, ey, ez, tx, ty, tz)
    norm1 = math.sqrt(cx * cx + cy * cy + cz * cz)
    dot = ex * tx + ey * ty + ez * tz
    alpha1 = math.atan2(norm1, dot)
    if norm1 > 1e-12:
        cx, cy, cz = cx / norm1, cy / norm1, cz / norm1
    else:
        # any axis across e
        m = matrix_from_quaternion(b)
        cx, cy, cz = m[0, 0], m[1, 0], m[2, 0]
    twist = 0.0
    if not problem.free_spin:
        # twist = angle of (Rot(a1, α1) B)ᵀ target about e3
        about_axis(cx, cy, cz, -alpha1, turn1)
        multiply(turn1, quaternion, first)
        relative(b, first, second)
        twist = wrap(2.0 * math.atan2(second[3], second[0])) + 2.0 * math.pi * start.turns
    if start.over_0:
        alpha0 -= 2.0 * math.pi
    if start.over_1:
        alpha1 -= 2.0 * math.pi
    tan0, tan1 = math.tan(0.25 * alpha0), math.tan(0.25 * alpha1)
    frames[0, 0], frames[0, 1], frames[0, 2], frames[0, 3] = 1.0, 0.0, 0.0, 0.0
    for i in range(n):
        at = 0.5 * (s[i] + s[i + 1])
        about_axis(0.0, 0.0, 1.0, twist * at, spun)
        multiply(b, spun, first)
        about_axis(cx, cy, cz, _layer(1.0 - at, root, tan1), turn1)
        multiply(turn1, first, second)
        about_axis(ax, ay, az, -_layer(at, root, tan0), turn0)
        multiply(turn0, second, frames[i + 1])
    for c in range(4):
        frames[n + 1, c] = quaternion[c]
    if problem.free_spin:
        # the end's spin starts where nothing twists the last hinge
        align_spin(frames[n], frames[n + 1])
    f = root * root if root > 3.0 else 0.0
    force[0], force[1], force[2] = f * ex, f * ey, f * ez


@kernel
def align_spin(reference, q):
    """Turn q about its own d3 so that it differs from ``reference`` by a turn without twist."""
    p = np.empty(4)
    relative(reference, q, p)
    turn(q, 0.0, 0.0, -2.0 * math.atan2(p[3], p[0]))


@kernel
def bow(rod, size, mode):
    """Bend the inner frames by smooth fixed rotations, to leave a symmetric start."""
    s, frames = rod.s, rod.frames
    for i in range(s.shape[0] - 1):
        at = 0.5 * (s[i] + s[i + 1])
        slope = size * math.sin(2.0 * math.pi * at)
        other = 0.37 * size * math.sin(math.pi * (1 + mode) * at)
        turn(frames[i + 1], other, slope, 0.0)


@kernel
def wave(rod, position, force, half_waves):
    """Bend the inner frames into half waves in the plane of d1, with their Euler load.

    The amplitude takes up the end shortening; such starts lead to buckled saddles that no
    minimizer finds.
    """
    s, frames = rod.s, rod.frames
    length = math.sqrt(position[0] ** 2 + position[1] ** 2 + position[2] ** 2)
    size = 2.0 * math.sqrt(max(1.0 - length, 0.0))
    for i in range(s.shape[0] - 1):
        at = 0.5 * (s[i] + s[i + 1])
        turn(frames[i + 1], 0.0, size * math.sin(math.pi * half_waves * at), 0.0)
    load = (math.pi * half_waves) ** 2
    for c in range(3):
        force[c] = -load * position[c] / max(length, 1e-9)


@kernel
def first_moment(omega, s, k3, moment):
    """M at s = 0: P m of the first hinge, whose left frame is the start frame."""
    x, y, z = omega[0, 0], omega[0, 1], omega[0, 2]
    h = hinge_length(s, 0)
    mx, my, mz = x / h, y / h, k3 * z / h
    # P = 1 + [ω]/2 to first order; the hinge is half a segment and small
    moment[0] = mx + 0.5 * (y * mz - z * my)
    moment[1] = my + 0.5 * (z * mx - x * mz)
    moment[2] = mz + 0.5 * (x * my - y * mx)


@kernel
def loads_as_it_stands(rod, k3, force, load):
    """Loads (6,) of a rod in no equilibrium: the force given, the first hinge's moment."""
    omega = np.empty((1, 3))
    hinge_vector(rod.frames[0], rod.frames[1], omega[0])
    first_moment(omega, rod.s, k3, load[3:])
    for c in range(3):
        load[c] = force[c]


@kernel
def hinge_poses(rod, position, torsion_ratio, m3, nodes):
    """Fill ``nodes`` from hinges at equal strides, without the extra spin of K30 ≠ 1."""
    s, frames, node_s, node_pose = rod.s, rod.frames, nodes.s, nodes.pose
    n = s.shape[0] - 1
    stride = n // (node_s.shape[0] - 1)
    omega = np.empty(3)
    x, y, z = 0.0, 0.0, 0.0
    excess = 1.0 / torsion_ratio - 1.0
    for j in range(n + 1):
        if j % stride == 0:
            k = j // stride
            node_s[k] = s[j]
            node_pose[k, 0], node_pose[k, 1], node_pose[k, 2] = x, y, z
            q = node_pose[k, 3:]
            # the clamps at the ends, the middle of the hinge between
            source = n + 1 if j == n else j
            for c in range(4):
                q[c] = frames[source, c]
            if 0 < j < n:
                hinge_vector(frames[j], frames[j + 1], omega)
                turn(q, 0.5 * omega[0], 0.5 * omega[1], 0.5 * omega[2])
            turn(q, 0.0, 0.0, -m3 * excess * s[j])
        if j < n:
            length = s[j + 1] - s[j]
            tx, ty, tz = tangent(frames[j + 1])
            x += length * tx
            y += length * ty
            z += length * tz
    for c in range(3):
        node_pose[n // stride, c] = position[c]
