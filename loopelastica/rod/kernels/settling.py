"""From loads in the middle of a rod, found on a coarse mesh, to solutions that a check confirms."""

import math

import numpy as np

from loopelastica.rod.kernels.discrete_starts import graded_nodes
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.middle import new_shot
from loopelastica.rod.kernels.records import SEGMENTS, Method, Nodes
from loopelastica.rod.kernels.refinement import accept_nodes
from loopelastica.rod.kernels.rotations import (
    cross,
    matrix_from_quaternion,
    product,
    spin,
    spin_between,
)
from loopelastica.rod.kernels.shooting import POSE, march, moment_bound

_MIDDLE = int(Method.MIDDLE)
# √F up to which 16 and 32 segments serve: growth is exp(√F h) over a segment
_LOOSE, _FIRM = 14.0, 40.0
_RATE = 1.5


@kernel
def unfold(problem, g, nodes, loads, shot):
    """Poses of ``nodes`` in the start frame, without the extra spin of K30 ≠ 1, and start loads.

    ``g`` (6,) are the loads in the middle. ``loads`` (6,) are those of multiple shooting: the last
    one is the end's turn if its spin is free.
    """
    s, pose, y = nodes.s, nodes.pose, shot.y
    m = s.shape[0] - 1
    rate = _RATE * min(moment_bound(g), 1e4)
    # back from the middle, then on from it
    for way in range(2):
        for c in range(POSE):
            y[c] = 1.0 if c == 3 else 0.0
        at = 0.5
        for k in range(m + 1):
            i = k if way == 1 else m - k
            if (s[i] > 0.5) != (way == 1):
                continue
            length = s[i] - at
            if length != 0.0:
                march(g, y, length, 1 + int(rate * abs(length)), POSE, shot.k, shot.z)
            at = s[i]
            for c in range(POSE):
                pose[i, c] = y[c]
    half = 0.0 if problem.free_spin else 0.5 * g[5] * (1.0 / problem.torsion_ratio - 1.0)
    first, origin = np.empty(4), np.empty(3)
    for c in range(4):
        first[c] = pose[0, 3 + c]
    for c in range(3):
        origin[c] = pose[0, c]
    spin(first, -half)
    r = matrix_from_quaternion(first)
    for i in range(m + 1):
        x, v, z = pose[i, 0] - origin[0], pose[i, 1] - origin[1], pose[i, 2] - origin[2]
        for c in range(3):
            pose[i, c] = r[0, c] * x + r[1, c] * v + r[2, c] * z
        q = pose[i, 3:]
        q[0], q[1], q[2], q[3] = product(
            first[0], -first[1], -first[2], -first[3], q[0], q[1], q[2], q[3]
        )
        spin(q, -half)
    mx, my, mz = cross(g[0], g[1], g[2], origin[0], origin[1], origin[2])
    mx, my, mz = mx + g[3], my + g[4], mz + g[5]
    for c in range(3):
        loads[c] = r[0, c] * g[0] + r[1, c] * g[1] + r[2, c] * g[2]
        loads[3 + c] = r[0, c] * mx + r[1, c] * my + r[2, c] * mz
    for c in range(3):
        pose[m, c] = problem.position[c]
    if problem.free_spin:
        loads[5] = spin_between(problem.quaternion, pose[m, 3:])


@kernel
def settle(problem, middles, rows):
    """Solutions from loads in the middle ``middles`` (n, 6), into ``multistart.Rows``."""
    shot = new_shot()
    for i in range(middles.shape[0]):
        g = middles[i]
        root = math.sqrt(math.sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]))
        m = 16 if root < _LOOSE else 32 if root < _FIRM else SEGMENTS
        while m <= SEGMENTS:
            nodes = Nodes(rows.node_s[i, : m + 1], rows.node_pose[i, : m + 1])
            graded_nodes(root, nodes.s)
            unfold(problem, g, nodes, rows.loads[i], shot)
            residual, energy = accept_nodes(problem, nodes, rows.loads[i])
            if residual < problem.tolerance:
                rows.method[i], rows.segments[i] = _MIDDLE, m
                rows.residual[i], rows.energy[i] = residual, energy
                break
            m *= 2
