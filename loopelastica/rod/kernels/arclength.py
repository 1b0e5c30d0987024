"""Pseudo-arclength continuation of a clamped rod: one corrected step along its branch.

The last clamp moves with a path parameter t,

    r(L) = p + t v,      R(L) = R exp(t [ω]),      hence  δr = v δt,  δθ = Rω δt,

and t is one more unknown beside the nodes and the loads of ``multiple_shooting``. It enters at the
last node alone, so that the elimination over the segments stays as it is; at its end are 6 rows in
(g, t), and the seventh is the pseudo-arclength condition n·δu = ds, where u are loads and t divided
by their scales and n is the branch's unit tangent at the point before. The bordered 7×7 matrix is
regular where t turns back (a fold); its last column of the inverse is the new tangent (H. B.
Keller, in Applications of Bifurcation Theory, Academic Press 1977, p. 359). With n = e_t it is
Newton's method at a given t.
"""

import math
from typing import NamedTuple

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.linalg import solve_deficient
from loopelastica.rod.kernels.multiple_shooting import (
    apply,
    backward,
    forward,
    mismatch,
    new_elimination,
)
from loopelastica.rod.kernels.records import Problem
from loopelastica.rod.kernels.rotations import cross, exponential, product, tangent
from loopelastica.rod.kernels.segments import new_space

# a predictor that moves a node further (in L or radian) is not worth correcting
_FURTHEST = 1.2
_DROP = 1e-11
# steps per radian: far from the solution, near it, and on the mesh that judges it
_COARSE, _FINE, _CHECK = 1.0, 3.0, 4.6


class Motion(NamedTuple):
    """The moving clamp p + t v, R exp(t [ω])."""

    origin: Array
    """p (3,)."""
    quaternion: Array
    """R (4,)."""
    shift: Array
    """v (3,)."""
    axis: Array
    """ω (3,) in the frame R."""
    torsion_ratio: float
    free_spin: bool


class Condition(NamedTuple):
    """The seventh equation of a step: row·(u − u_old) = ds, in units of ``scale``."""

    scale: Array
    """(7,): units of F, M0 and t."""
    row: Array
    """(7,)."""
    ds: float
    on_one_line: bool
    """Both ends lie on one line: an eighth row fixes the rod's turn about it."""


@kernel
def moving_clamp(motion, t, q, p):
    """Clamp at ``t``: position into ``p`` (3,), quaternion into ``q`` (4,)."""
    for c in range(3):
        p[c] = motion.origin[c] + t * motion.shift[c]
    axis, r = motion.axis, motion.quaternion
    w, x, y, z = exponential(t * axis[0], t * axis[1], t * axis[2])
    q[0], q[1], q[2], q[3] = product(r[0], r[1], r[2], r[3], w, x, y, z)


@kernel
def _end_moves(motion, end, scale, w):
    """The last node's move ``w`` (2, 6) per unit of g[5] and of t."""
    rate = 1.0 if motion.free_spin else -(1.0 / motion.torsion_ratio - 1.0)
    q, axis = motion.quaternion, motion.axis
    for c in range(6):
        w[0, c] = w[1, c] = 0.0
    w[0, 0], w[0, 1], w[0, 2] = tangent(end)
    # Rω, ω in the clamp's frame: 2 q × (q × ω + w ω) + ω
    cx, cy, cz = cross(q[1], q[2], q[3], axis[0], axis[1], axis[2])
    cx, cy, cz = cx + q[0] * axis[0], cy + q[0] * axis[1], cz + q[0] * axis[2]
    dx, dy, dz = cross(q[1], q[2], q[3], cx, cy, cz)
    w[1, 0] = axis[0] + 2.0 * dx
    w[1, 1] = axis[1] + 2.0 * dy
    w[1, 2] = axis[2] + 2.0 * dz
    for c in range(3):
        w[0, c] *= rate * scale[5]
        w[1, c] *= scale[6]
        w[1, 3 + c] = motion.shift[c] * scale[6]


@kernel
def _bordered(rows, condition, remainder, g, w, a):
    """The system in (g, t) and its two right-hand sides, equilibrated, into ``a`` (8, 9)."""
    for r in range(6):
        for c in range(6):
            a[r, c] = rows[r, 12 + c]
        a[r, 6] = 0.0
        for c in range(6):
            a[r, 5] += rows[r, c] * w[0, c]
            a[r, 6] += rows[r, c] * w[1, c]
        a[r, 7] = rows[r, 18]
        a[r, 8] = 0.0
    for c in range(7):
        a[6, c] = condition.row[c]
    a[6, 7] = remainder
    a[6, 8] = 1.0
    for c in range(9):
        a[7, c] = 0.0
    if condition.on_one_line:
        # no turn of all loads about d3(0)
        for c in (0, 3):
            a[7, c] = -g[c + 1] / condition.scale[c]
            a[7, c + 1] = g[c] / condition.scale[c]
    for r in range(8):
        size = 1e-300
        for c in range(7):
            size = max(size, abs(a[r, c]))
        for c in range(9):
            a[r, c] /= size


@kernel
def corrected_step(motion, nodes, g, condition, most, direction):
    """From a point of the branch to the one that meets ``condition``, by Newton's method.

    Parameters
    ----------
    motion : Motion
        The moving clamp.
    nodes : Nodes
        As for ``multiple_shooting.refine``; poses in place.
    g : (7,)
        F, M0 (its last entry the end's free turn if ``free_spin``) and t; in place.
    condition : Condition
        Where the step leads.
    most : int
        Newton steps allowed.
    direction : (7,)
        Becomes the unit tangent of the branch, in units of the condition's scale, with
        row·direction > 0.

    Returns
    -------
    residual, energy, iterations
        The mismatch on another mesh, infinite if there is no convergence; Newton steps made.
    """
    m, scale, node_pose = nodes.s.shape[0] - 1, condition.scale, nodes.pose
    room, space = new_elimination(m, scale), new_space()
    a, w, steps = np.empty((8, 9)), np.empty((2, 6)), np.empty((2, 7))
    x, last, clamp, p = np.empty((m + 1, 6)), np.empty(6), np.empty(4), np.empty(3)
    # the clamp as a problem: its arrays are filled as it moves
    problem = Problem(p, clamp, 0.0, motion.torsion_ratio, motion.free_spin, 0.0)
    moving_clamp(motion, g[6], clamp, p)
    remainder, density, done = condition.ds, _COARSE, False
    for iteration in range(most):
        worst = forward(nodes, g, motion.free_spin, density, room, space)
        if not worst < 10.0:
            return math.inf, math.inf, iteration
        _end_moves(motion, node_pose[m, 3:], scale, w)
        _bordered(room.rows, condition, remainder, g, w, a)
        solve_deficient(a, 8, 7, 2, _DROP, steps)
        du = steps[0]
        remainder = 0.0
        for c in range(6):
            last[c] = w[0, c] * du[5] + w[1, c] * du[6]
        backward(room.kept, last, du, x)
        size = 0.0
        for i in range(m + 1):
            for c in range(6):
                size = max(size, abs(x[i, c]))
        if not size < _FURTHEST:
            return math.inf, math.inf, iteration
        for c in range(7):
            du[c] *= scale[c]
        g[6] += du[6]
        moving_clamp(motion, g[6], clamp, p)
        apply(problem, nodes, g, x, du, 1.0)
        for c in range(3):
            node_pose[m, c] = p[c]
        # quadratic: what is left after this step is below rounding
        done = density == _FINE and iteration > 0 and worst < 1e-7
        if done:
            break
        if worst < 1e-3 and iteration > 0:
            density = _FINE
    if not done:
        return math.inf, math.inf, most
    total = 0.0
    for c in range(7):
        direction[c] = steps[1, c]
        total += direction[c] * direction[c]
    for c in range(7):
        direction[c] /= math.sqrt(total)
    residual, energy = mismatch(problem, nodes, g, _CHECK, space)
    return residual, energy, iteration + 1
