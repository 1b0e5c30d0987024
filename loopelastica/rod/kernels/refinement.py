"""From boundary layers or a discrete rod to a solution that an evaluation of its own confirms.

Every function here ends with a residual: of an integration between points that the closed form
gave, or of multiple shooting on a mesh with other steps. It is infinite where there is no solution.
"""

import math

import numpy as np

from loopelastica.rod.kernels.boundary_layers import layers_newton
from loopelastica.rod.kernels.discrete_starts import graded_nodes, hinge_poses
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.layer_poses import (
    check_layers,
    layers_apart,
    layers_energy,
    layers_loads,
    layers_pose,
)
from loopelastica.rod.kernels.linalg import copy, copy_rows
from loopelastica.rod.kernels.multiple_shooting import refine
from loopelastica.rod.kernels.nearly_straight import bend_loads, bend_nodes
from loopelastica.rod.kernels.newton import CONVERGED, elastic_energy, newton
from loopelastica.rod.kernels.records import SEGMENTS, Method, Nodes, Outcome, Problem
from loopelastica.rod.kernels.rotations import align, end_turn, larger, tangent
from loopelastica.rod.kernels.shooting import moment_bound

NONE, BOUNDARY_LAYERS = int(Method.NONE), int(Method.BOUNDARY_LAYERS)
REFINED_LAYERS, DISCRETE_ROD = int(Method.REFINED_LAYERS), int(Method.DISCRETE_ROD)
DISCRETE_ROD_LAYERS = int(Method.DISCRETE_ROD_LAYERS)
DISCRETE_ROD_SHOOTING = int(Method.DISCRETE_ROD_SHOOTING)
NEARLY_STRAIGHT = int(Method.NEARLY_STRAIGHT)

# √F cos β above which boundary layers are good nodes, and √F above which only layers hold
TENSE, _STIFF = 14.0, 45.0
# relative size of a pivot that is rounding, and of one along a circle of nearly equal solutions
_DROP, _CIRCLE_DROP = 1e-12, 1e-4
# places on such a circle
_DIRECTIONS = 12
# √F below which one shot from the start often arrives; Newton steps that a discrete rod is given;
# how far, relative to their size, its loads may go: further, it would be another rod
_LOOSE, _STEPS, _SAME = 7.5, 4, 0.1
# largest moment per segment of the nodes of a nearly straight rod
_RATE = 6.0


@kernel
def accept_layers(problem, layers, loads):
    """(residual, energy) of two boundary layers as they are, and their ``loads`` (6,)."""
    if not layers_apart(layers):
        return math.inf, math.inf
    residual = check_layers(problem, layers)
    if not residual < problem.tolerance:
        return math.inf, math.inf
    layers_loads(layers, loads)
    if problem.free_spin:
        loads[5] = 0.0
    return residual, layers_energy(layers, problem.torsion_ratio)


@kernel
def accept_nodes(problem, nodes, loads):
    """(residual, energy) of refined nodes; ``loads`` go in as the guess and out as F, M0.

    Where both ends are on one line, or nearly, the solutions lie on a circle of directions and
    Newton's step runs off along it. A second try keeps still along such directions, and others go
    on from there, turned to several places of the circle.
    """
    pose = nodes.pose
    first_pose, first_loads = np.empty(pose.shape), np.empty(6)
    copy_rows(pose, first_pose)
    copy(loads, first_loads)
    residual, energy, _ = refine(problem, nodes, loads, _DROP, 14)
    if not residual < problem.tolerance and near_one_line(problem):
        copy_rows(first_pose, pose)
        copy(first_loads, loads)
        residual, energy, _ = refine(problem, nodes, loads, _CIRCLE_DROP, 30)
        copy_rows(pose, first_pose)
        copy(loads, first_loads)
        for i in range(_DIRECTIONS):
            if residual < problem.tolerance:
                break
            copy_rows(first_pose, pose)
            copy(first_loads, loads)
            turn_about_start(pose, loads, 2.0 * math.pi * i / _DIRECTIONS)
            residual, energy, _ = refine(problem, nodes, loads, _DROP, 25)
    if problem.free_spin:
        loads[5] = 0.0
    if not residual < problem.tolerance:
        return math.inf, math.inf
    return residual, energy


@kernel
def turn_about_start(pose, loads, angle):
    """Turn the inner nodes and the loads about d3(0), ends fixed: Rz R Rzᵀ for the frames."""
    c, s = math.cos(angle), math.sin(angle)
    for o in (0, 3):
        x, y = loads[o], loads[o + 1]
        loads[o], loads[o + 1] = c * x - s * y, s * x + c * y
    for k in range(1, pose.shape[0] - 1):
        x, y = pose[k, 0], pose[k, 1]
        pose[k, 0], pose[k, 1] = c * x - s * y, s * x + c * y
        # conjugation turns the vector part of the quaternion
        x, y = pose[k, 4], pose[k, 5]
        pose[k, 4], pose[k, 5] = c * x - s * y, s * x + c * y


@kernel
def near_one_line(problem):
    """Whether both end tangents are parallel to the chord to within 0.01 rad, either way."""
    position = problem.position
    tx, ty, _ = tangent(problem.quaternion)
    across = math.sqrt(position[0] ** 2 + position[1] ** 2)
    size = math.sqrt(position[0] ** 2 + position[1] ** 2 + position[2] ** 2)
    return math.sqrt(tx * tx + ty * ty) < 0.01 and across <= 0.01 * size + 1e-4


@kernel
def with_end(problem, quaternion, torsion_ratio):
    """The problem with another end frame and torsion ratio."""
    end = np.empty(4)
    copy(quaternion, end)
    return Problem(
        problem.position,
        end,
        problem.shortening,
        torsion_ratio,
        problem.free_spin,
        problem.tolerance,
    )


@kernel
def _refine_layers(problem, solution):
    """(residual, energy, segments) of nodes at the poses of layers that reach each other."""
    layers, loads = solution.layers[0], solution.loads
    layers_loads(layers, loads)
    m = _segments(math.cos(layers.beta) * layers.root, loads)
    nodes = Nodes(solution.nodes.s[: m + 1], solution.nodes.pose[: m + 1])
    node_s, node_pose = nodes.s, nodes.pose
    graded_nodes(layers.root, node_s)
    moment = np.empty(3)
    for i in range(m + 1):
        from_end = node_s[i] > 0.5
        distance = 1.0 - node_s[i] if from_end else node_s[i]
        layers_pose(layers, distance, from_end, node_pose[i], moment)
    for c in range(7):
        node_pose[0, c] = 0.0
    node_pose[0, 3] = 1.0
    residual, energy = _accept_ended(problem, nodes, loads)
    return residual, energy, m


@kernel
def _accept_ended(problem, nodes, loads):
    """`accept_nodes`; a free end has the spin of the last node to begin with."""
    end = problem.quaternion
    if problem.free_spin:
        loads[5] = 0.0
        end = nodes.pose[nodes.s.shape[0] - 1, 3:]
        if not _tangents_apart(end, problem.quaternion) < 0.1 * problem.tolerance:
            return math.inf, math.inf
    return accept_nodes(with_end(problem, end, problem.torsion_ratio), nodes, loads)


@kernel
def _tangents_apart(p, q):
    """Largest component of the difference of two frames' tangents."""
    px, py, pz = tangent(p)
    qx, qy, qz = tangent(q)
    return larger(larger(abs(px - qx), abs(py - qy)), abs(pz - qz))


@kernel
def _segments(growth, loads):
    """How many segments hold a rod whose errors grow by exp(``growth``), as its moment turns it."""
    m = 16 if growth < 36.0 else 32
    while m < SEGMENTS and moment_bound(loads) > _RATE * m:
        m *= 2
    return m


@kernel
def refine_bend(problem, turns, solution):
    """(residual, energy, segments) of the rod that the linear theory bends, refined."""
    loads = solution.loads
    growth = bend_loads(problem, turns, loads)
    m = _segments(growth, loads)
    nodes = Nodes(solution.nodes.s[: m + 1], solution.nodes.pose[: m + 1])
    bend_nodes(problem, turns, nodes)
    residual, energy = _accept_ended(problem, nodes, loads)
    return residual, energy, m


@kernel
def settle_layers(problem, solution):
    """The layers themselves, or refined where they reach each other: (residual, energy, segments).

    Both are written into ``solution``.
    """
    layers = solution.layers[0]
    residual, energy = accept_layers(problem, layers, solution.loads)
    if residual < problem.tolerance:
        return residual, energy, 0
    if math.cos(layers.beta) * layers.root > TENSE:
        return _refine_layers(problem, solution)
    return math.inf, math.inf, 0


@kernel
def layers_from_loads(problem, loads, layers):
    """Boundary layers that carry given ``loads``; True if their equations are solved."""
    position, quaternion = problem.position, problem.quaternion
    f = math.sqrt(loads[0] ** 2 + loads[1] ** 2 + loads[2] ** 2)
    ex, ey, ez = loads[0] / f, loads[1] / f, loads[2] / f
    root = math.sqrt(f)
    m3 = 0.0 if problem.free_spin else loads[3] * ex + loads[4] * ey + loads[5] * ez
    q0, x = np.empty(4), np.zeros(6)
    align(ex, ey, ez, q0)
    beta = math.asin(min(max(0.5 * m3 / root, -0.999), 0.999))
    x[2], x[3] = math.log(root), beta
    # δ of an end from cos(α/2) sin δ = sin β and the side of its moment: M·(e × t) > 0 is direct
    tx, ty, tz = tangent(quaternion)
    for end in range(2):
        if end == 0:
            ax, ay, az = 0.0, 0.0, 1.0
            mx, my, mz = loads[3], loads[4], loads[5]
            sign = 1.0
        else:
            ax, ay, az = tx, ty, tz
            mx = loads[3] + loads[1] * position[2] - loads[2] * position[1]
            my = loads[4] + loads[2] * position[0] - loads[0] * position[2]
            mz = loads[5] + loads[0] * position[1] - loads[1] * position[0]
            sign = -1.0
        half_cos = math.sqrt(max(0.5 * (1.0 + ax * ex + ay * ey + az * ez), 1e-12))
        delta = math.asin(min(max(math.sin(beta) / half_cos, -1.0), 1.0))
        bending = sign * (
            mx * (ay * ez - az * ey) + my * (az * ex - ax * ez) + mz * (ax * ey - ay * ex)
        )
        if bending < 0.0:
            delta = math.pi - delta
        x[4 + end] = delta
    reference = end_turn(quaternion, q0)
    if not problem.free_spin:
        turn = 2.0 * root * math.sin(beta) / problem.torsion_ratio
        turn += 2.0 * (x[4] + x[5] - 2.0 * beta)
        reference += 2.0 * math.pi * round((turn - reference) / (2.0 * math.pi))
    return layers_newton(problem, problem.torsion_ratio, x, q0, reference, layers)


@kernel
def refine_discrete_rod(problem, minimized_ratio, minimized, rod, load, solution):
    """From a discrete ``rod`` and its ``load`` (6,) to a solution, as an `Outcome`.

    Under high tension its loads become boundary layers, under little they are shot from the start,
    otherwise its hinges become nodes of multiple shooting. ``minimized_ratio`` is the torsion ratio
    that the rod was minimized at.
    """
    loads, nodes = solution.loads, solution.nodes
    root = math.sqrt(math.sqrt(load[0] ** 2 + load[1] ** 2 + load[2] ** 2))
    if root > _STIFF and layers_from_loads(problem, load, solution.layers[0]):
        residual, energy, m = settle_layers(problem, solution)
        if residual < problem.tolerance:
            return Outcome(DISCRETE_ROD_LAYERS, residual, energy, m)
    same_ratio = problem.torsion_ratio == minimized_ratio
    if minimized and root < _LOOSE and same_ratio and not near_one_line(problem):
        copy(load, loads)
        status, residual, _, end = newton(problem, loads, _STEPS)
        if status == CONVERGED and relative_distance(loads, load) < _SAME:
            energy = elastic_energy(loads, end, problem.torsion_ratio)
            return Outcome(DISCRETE_ROD_SHOOTING, residual, energy, 0)
    n = rod.s.shape[0] - 1
    # with M3 = 0 the ratio is void
    ratio = 1.0 if problem.free_spin else problem.torsion_ratio
    end = rod.frames[n + 1] if problem.free_spin else problem.quaternion
    if not _tangents_apart(end, problem.quaternion) < 0.1 * problem.tolerance:
        return Outcome(NONE, math.inf, math.inf, 0)
    ended = with_end(problem, end, ratio)
    m = 16 if root < 40.0 else 32
    # more nodes help where the discrete rod is near, not where nothing was minimized
    most = n if minimized else m
    while m <= most:
        part = Nodes(nodes.s[: m + 1], nodes.pose[: m + 1])
        copy(load, loads)
        if problem.free_spin:
            loads[5] = 0.0
        hinge_poses(rod, problem.position, ratio, load[5], part)
        residual, energy = accept_nodes(ended, part, loads)
        if residual < problem.tolerance:
            return Outcome(DISCRETE_ROD, residual, energy, m)
        if ratio > minimized_ratio:
            # too far at once: let the ratio grow from where the discrete rod was
            copy(load, loads)
            hinge_poses(rod, problem.position, minimized_ratio, load[5], part)
            grown = minimized_ratio
            while True:
                residual, energy = accept_nodes(with_end(problem, end, grown), part, loads)
                if not residual < problem.tolerance or grown == ratio:
                    break
                grown = min(1.5 * grown, ratio)
            if residual < problem.tolerance:
                return Outcome(DISCRETE_ROD, residual, energy, m)
        m *= 2
    return Outcome(NONE, math.inf, math.inf, 0)


@kernel
def relative_distance(one, other):
    """Largest difference of two loads, relative to the largest component or to 1."""
    apart, size = 0.0, 1.0
    for c in range(6):
        apart = max(apart, abs(one[c] - other[c]))
        size = max(size, abs(one[c]))
    return apart / size
