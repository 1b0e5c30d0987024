"""Multiple shooting: the rod in m segments, refined by Newton's method.

Unknown are the loads g = (F, M0) and the poses of the inner nodes; both ends are the clamps. Each
segment is integrated from its node (``segments``).

Torsion ratios other than one enter at the last clamp alone: without its extra spin the last frame
is the clamp turned back by M3 (1/K30 − 1), M3 = M0·d3(0). With a free end spin that turn is itself
the sixth unknown, in place of M3, which is zero.

Elimination in O(m): six rows in (x_k, g) are carried along; with the six rows of segment k they
are pivoted over the columns of x_k, and six rows in (x_k+1, g) remain; at the end 6×6 rows in g,
solved with complete pivoting that leaves out null directions (ends on one line). Growth exp(√F)
over the whole rod becomes exp(√F/m) over a segment.

Newton's steps are made on a coarse mesh. Near the solution chords follow on a fine one: steps by
the factors of the last elimination, for which the poses alone are integrated. Where they gain
little, Newton's method goes on there.
"""

import math
from typing import NamedTuple

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.linalg import copy_rows
from loopelastica.rod.kernels.newton import pivoted_step
from loopelastica.rod.kernels.rotations import (
    larger,
    rotation_vector,
    spin,
    tangent,
    turn_in_space,
)
from loopelastica.rod.kernels.segments import (
    MAX_STEPS,
    integrate_segment,
    new_space,
    segment_rows,
)
from loopelastica.rod.kernels.shooting import POSE, WITH_JACOBIAN

_CAP = 0.4
# mismatch per step left above which none of 250 starts that were not minimized arrived
_BEHIND = 0.15
# steps per radian of turning, far from the solution and near it; the mismatch from which it is near
_COARSE, _FINE, _SWITCH = 1.0, 3.0, 1e-4
# what a chord must gain, and the mismatch from which one more is expected to be the last
_GAIN, _NEAR = 0.1, 1e-7
# mismatch on the check mesh below which another Newton step gains nothing
_SETTLED = 1e-10


class Elimination(NamedTuple):
    """Room for the elimination over the segments."""

    rows: Array
    """(12, 19): columns x_k (6), x_k+1 (6), g (6) and the right-hand side."""
    kept: Array
    """(m, 12, 19): the eliminated rows of each inner node, below the pivots their factors."""
    order: Array
    """(m, 6): which rows changed places with them."""
    scale: Array
    """(6,): units of g."""
    last: Array
    """(6, 6): the rows in g at the end, each divided by its size."""
    size: Array
    """(6,)."""


@kernel
def new_elimination(m, scale):
    """Room for ``m`` segments."""
    return Elimination(
        np.zeros((12, 19)),
        np.empty((m, 12, 19)),
        np.empty((m, 6), np.int64),
        scale,
        np.empty((6, 6)),
        np.empty(6),
    )


@kernel
def end_clamp(problem, g, q):
    """Last frame without the extra spin of K30 ≠ 1, into ``q``; g[5] is M3 or the free turn."""
    for c in range(4):
        q[c] = problem.quaternion[c]
    if problem.free_spin:
        spin(q, g[5])
    else:
        spin(q, -g[5] * (1.0 / problem.torsion_ratio - 1.0))


@kernel
def mismatch(problem, nodes, g, density, space):
    """Largest mismatch (position, rotation vector) between segments' ends and next nodes.

    Also returns the energy, from h − F·Δr of each segment: with the clamps' distance in place of
    the sum of Δr the mismatch, times F, would be an error of an energy that may be tiny.
    """
    free_spin, node_pose, f, y = problem.free_spin, nodes.pose, space.f, space.y
    m3 = 0.0 if free_spin else g[5]
    worst, energy = 0.0, 0.5 * m3 * m3 * (1.0 / problem.torsion_ratio - 1.0)
    for i in range(nodes.s.shape[0] - 1):
        h = nodes.s[i + 1] - nodes.s[i]
        if integrate_segment(g, free_spin, node_pose[i], h, density, POSE, space) > 4000:
            return math.inf, math.inf
        a, b, c = rotation_vector(y[3:POSE], node_pose[i + 1, 3:])
        worst = larger(larger(larger(worst, abs(a)), abs(b)), abs(c))
        for j in range(3):
            worst = larger(worst, abs(node_pose[i, j] + y[j] - node_pose[i + 1, j]))
        tx, ty, tz = tangent(node_pose[i, 3:])
        energy += 0.5 * h * (f[3] * f[3] + f[4] * f[4] + f[5] * f[5])
        # h t(0) − Δr is small where the segment is nearly straight
        energy += g[0] * (h * tx - y[0]) + g[1] * (h * ty - y[1]) + g[2] * (h * tz - y[2])
    if worst == worst:
        return worst, energy
    return math.inf, math.inf


@kernel
def _miss(node_pose, i, y, rest):
    """What the end ``y`` of segment ``i`` misses the next node by, into ``rest`` (6,)."""
    rest[0], rest[1], rest[2] = rotation_vector(y[3:POSE], node_pose[i + 1, 3:])
    for c in range(3):
        rest[3 + c] = node_pose[i, c] + y[c] - node_pose[i + 1, c]


@kernel
def _factor(rows, order, i):
    """Eliminate six columns of ``rows`` (12, 19) by partial pivoting, in place.

    Factors stay below the pivots, the rows that changed places in ``order[i]``. False if singular.
    """
    for p in range(6):
        best = p
        for r in range(p + 1, 12):
            if abs(rows[r, p]) > abs(rows[best, p]):
                best = r
        order[i, p] = best
        if best != p:
            for c in range(19):
                rows[p, c], rows[best, c] = rows[best, c], rows[p, c]
        if not abs(rows[p, p]) > 1e-300:
            return False
        for r in range(p + 1, 12):
            factor = rows[r, p] / rows[p, p]
            rows[r, p] = factor
            if factor != 0.0:
                for c in range(p + 1, 19):
                    rows[r, c] -= factor * rows[p, c]
    return True


@kernel
def forward(nodes, g, free_spin, density, room, space):
    """Eliminate the inner nodes; rows in (x_m, g) remain in ``room.rows[:6]``.

    Returns the mismatch, inf where a segment is too stiff or the rows are singular.
    """
    rows, kept, scale = room.rows, room.kept, room.scale
    node_pose, y, worst = nodes.pose, space.y, 0.0
    rest = np.empty(6)
    for i in range(nodes.s.shape[0] - 1):
        h = nodes.s[i + 1] - nodes.s[i]
        steps = integrate_segment(g, free_spin, node_pose[i], h, density, WITH_JACOBIAN, space)
        if steps > MAX_STEPS:
            return math.inf
        _miss(node_pose, i, y, rest)
        segment_rows(node_pose[i], space)
        # rows 0–5 are carried, 6–11 new
        for r in range(6):
            worst = larger(worst, abs(rest[r]))
            if free_spin:
                space.end_by_loads[r, 5] = 0.0
            for c in range(6):
                rows[6 + r, c] = space.end_by_node[r, c]
                rows[6 + r, 6 + c] = -1.0 if r == c else 0.0
                rows[6 + r, 12 + c] = space.end_by_loads[r, c] * scale[c]
            rows[6 + r, 18] = -rest[r]
        if i > 0:
            if not _factor(rows, room.order, i):
                return math.inf
            copy_rows(rows, kept[i])
        # what remains are rows in (x_k+1, g): carry them
        for r in range(6):
            for c in range(6):
                rows[r, c] = rows[6 + r, 6 + c]
                rows[r, 6 + c] = 0.0
                rows[r, 12 + c] = rows[6 + r, 12 + c]
            rows[r, 18] = rows[6 + r, 18]
    return worst if worst == worst else math.inf


@kernel
def forward_again(nodes, g, free_spin, density, room, space):
    """`forward` by the factors of the last one: of the segments only the poses are integrated."""
    rows, kept, order, worst = room.rows, room.kept, room.order, 0.0
    rest, b = np.empty(6), np.empty(12)
    for i in range(nodes.s.shape[0] - 1):
        h = nodes.s[i + 1] - nodes.s[i]
        steps = integrate_segment(g, free_spin, nodes.pose[i], h, density, POSE, space)
        if steps > MAX_STEPS:
            return math.inf
        _miss(nodes.pose, i, space.y, rest)
        for r in range(6):
            worst = larger(worst, abs(rest[r]))
            b[6 + r] = -rest[r]
        if i > 0:
            for p in range(6):
                b[p], b[order[i, p]] = b[order[i, p]], b[p]
            for p in range(6):
                kept[i, p, 18] = b[p]
                for r in range(p + 1, 12):
                    b[r] -= kept[i, r, p] * b[p]
        for r in range(6):
            b[r] = b[6 + r]
            rows[r, 18] = b[r]
    return worst if worst == worst else math.inf


@kernel
def backward(kept, last, du, x):
    """Node moves ``x`` (m + 1, 6) from the scaled load step ``du`` and the last node's ``last``."""
    m = x.shape[0] - 1
    for c in range(6):
        x[0, c] = 0.0
        x[m, c] = last[c]
    for i in range(m - 1, 0, -1):
        for p in range(5, -1, -1):
            value = kept[i, p, 18]
            for c in range(p + 1, 6):
                value -= kept[i, p, c] * x[i, c]
            for c in range(6):
                value -= kept[i, p, 6 + c] * x[i + 1, c] + kept[i, p, 12 + c] * du[c]
            x[i, p] = value / kept[i, p, p]


@kernel
def _end_rows(problem, nodes, room):
    """The rows in g that `forward` has left at the end, into ``room.last``."""
    rows, scale, last, size = room.rows, room.scale, room.last, room.size
    # the last node is the clamp: it turns about its tangent with g[5] alone
    tx, ty, tz = tangent(nodes.pose[nodes.s.shape[0] - 1, 3:])
    rate = _end_rate(problem) * scale[5]
    for r in range(6):
        for c in range(6):
            last[r, c] = rows[r, 12 + c]
        last[r, 5] += rate * (rows[r, 0] * tx + rows[r, 1] * ty + rows[r, 2] * tz)
        size[r] = 1e-300
        for c in range(6):
            size[r] = max(size[r], abs(last[r, c]))
        for c in range(6):
            last[r, c] /= size[r]


@kernel
def _end_rate(problem):
    """How fast the last node turns about its tangent with g[5]."""
    return 1.0 if problem.free_spin else -(1.0 / problem.torsion_ratio - 1.0)


@kernel
def _step(problem, nodes, drop, room, x, dg):
    """The step that the eliminated rows ask for: nodes ``x`` (m + 1, 6), loads ``dg`` (6,)."""
    rest, ones, end = np.empty(6), np.ones(6), np.empty(6)
    for r in range(6):
        rest[r] = -room.rows[r, 18] / room.size[r]
    pivoted_step(room.last, rest, ones, drop, dg)
    turn = _end_rate(problem) * room.scale[5] * dg[5]
    tx, ty, tz = tangent(nodes.pose[nodes.s.shape[0] - 1, 3:])
    end[0], end[1], end[2] = turn * tx, turn * ty, turn * tz
    end[3], end[4], end[5] = 0.0, 0.0, 0.0
    backward(room.kept, end, dg, x)
    for c in range(6):
        dg[c] *= room.scale[c]


@kernel
def apply(problem, nodes, g, x, dg, t):
    """Move nodes and loads by the fraction ``t`` of the step."""
    node_pose = nodes.pose
    m = node_pose.shape[0] - 1
    for c in range(6):
        g[c] += t * dg[c]
    for i in range(1, m):
        turn_in_space(node_pose[i, 3:], t * x[i, 0], t * x[i, 1], t * x[i, 2])
        for c in range(3):
            node_pose[i, c] += t * x[i, 3 + c]
    end_clamp(problem, g, node_pose[m, 3:])


@kernel
def refine(problem, nodes, g, drop, iterations):
    """Newton's method on nodes and loads, in place.

    ``nodes.pose`` (m + 1, 7) starts at the identity and ends at the clamp's position; ``g`` (6,) is
    F and M0, its last entry being the end's free turn if ``free_spin``. Load directions with pivots
    below ``drop`` stay put. Returns (residual, energy, iterations): the mismatch by a
    mesh with other steps, infinite if there is no convergence in ``iterations``.
    """
    m = nodes.s.shape[0] - 1
    room = new_elimination(m, np.empty(6))
    scale, space, dg, x = room.scale, new_space(), np.empty(6), np.empty((m + 1, 6))
    end_clamp(problem, g, nodes.pose[m, 3:])
    density, chords = _COARSE, False
    best = math.inf
    stalled = 0
    worst = math.inf
    for iteration in range(iterations):
        force = max(math.sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]), 10.0)
        previous = worst
        if chords:
            worst = forward_again(nodes, g, problem.free_spin, density, room, space)
            chords = worst < max(_GAIN * previous, _NEAR)
        if not chords:
            for c in range(3):
                scale[c] = force
                scale[3 + c] = math.sqrt(force)
            if problem.free_spin:
                scale[5] = 1.0
            worst = forward(nodes, g, problem.free_spin, density, room, space)
            if worst < math.inf:
                _end_rows(problem, nodes, room)
        if worst > _BEHIND * (iterations - iteration):
            return math.inf, math.inf, iteration
        _step(problem, nodes, drop, room, x, dg)
        size = 0.0
        for i in range(m + 1):
            for c in range(6):
                size = max(size, abs(x[i, c]))
        change = math.sqrt(dg[0] * dg[0] + dg[1] * dg[1] + dg[2] * dg[2]) / (2.0 * force)
        change = max(
            change,
            math.sqrt(dg[3] * dg[3] + dg[4] * dg[4] + dg[5] * dg[5]) / (4.0 * math.sqrt(force)),
        )
        size = max(size, change)
        if not size < 1e6:
            return math.inf, math.inf, iteration
        fine = density == _FINE
        if fine and (worst < 1e-13 or (worst < 1e-10 and worst > 0.1 * previous)):
            break
        apply(problem, nodes, g, x, dg, min(1.0, _CAP / max(size, 1e-300)))
        if worst < best:
            best, stalled = worst, 0
        else:
            stalled += 1
            if stalled > iterations // 4:
                return math.inf, math.inf, iteration
        if not fine and worst < _SWITCH:
            density, chords = _FINE, True
            best = math.inf
        elif fine and worst < _NEAR:
            # where convergence is fast, what is left is rounding; along a soft direction it
            # is not, and the loop goes on
            residual, energy = mismatch(problem, nodes, g, 4.6, space)
            if residual < _SETTLED:
                return residual, energy, iteration + 1
    residual, energy = mismatch(problem, nodes, g, 4.6, space)
    return residual, energy, iteration + 1
