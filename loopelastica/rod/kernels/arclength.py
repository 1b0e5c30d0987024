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

import numpy as np

from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.multiple_shooting import apply, backward, forward, gaps
from loopelastica.rod.kernels.rotations import tangent
from loopelastica.rod.kernels.shooting import WITH_JACOBIAN

# a predictor that moves a node further (in L or radian) is not worth correcting
_FURTHEST = 1.2
_DROP = 1e-11
# steps per radian: far from the solution, near it, and on the mesh that judges it
_COARSE, _FINE, _CHECK = 1.0, 3.0, 4.6


@kernel
def moving_clamp(origin, quaternion, shift, axis, t, q, p):
    """Clamp at ``t``: position p + t v into ``p`` (3,), rotation R exp(t ω) into ``q`` (4,)."""
    for c in range(3):
        p[c] = origin[c] + t * shift[c]
    a = math.sqrt(axis[0] ** 2 + axis[1] ** 2 + axis[2] ** 2)
    s = math.sin(0.5 * a * t) / a if a > 0.0 else 0.0
    cw, x, y, z = math.cos(0.5 * a * t), s * axis[0], s * axis[1], s * axis[2]
    w, u, v, n = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
    q[0] = w * cw - u * x - v * y - n * z
    q[1] = w * x + u * cw + v * z - n * y
    q[2] = w * y - u * z + v * cw + n * x
    q[3] = w * z + u * y - v * x + n * cw


@kernel
def _bordered(a, order, u, v):
    """Solve the consistent ``a`` (8, 9) for its last two columns, into ``u`` and ``v`` (7,).

    Complete pivoting after the rows are equilibrated; null directions stay put.
    """
    n, rows = 7, 8
    for i in range(rows):
        size = 1e-300
        for j in range(n):
            size = max(size, abs(a[i, j]))
        for j in range(n + 2):
            a[i, j] /= size
    for i in range(n):
        order[i] = i
        u[i] = v[i] = 0.0
    rank, first = n, 0.0
    for p in range(n):
        best, bi, bj = -1.0, p, p
        for i in range(p, rows):
            for j in range(p, n):
                if abs(a[i, j]) > best:
                    best, bi, bj = abs(a[i, j]), i, j
        if p == 0:
            first = best
        if not best > _DROP * first:
            rank = p
            break
        for j in range(n + 2):
            a[p, j], a[bi, j] = a[bi, j], a[p, j]
        for i in range(rows):
            a[i, p], a[i, bj] = a[i, bj], a[i, p]
        order[p], order[bj] = order[bj], order[p]
        for i in range(p + 1, rows):
            factor = a[i, p] / a[p, p]
            for j in range(p, n + 2):
                a[i, j] -= factor * a[p, j]
    for i in range(rank - 1, -1, -1):
        first, second = a[i, n], a[i, n + 1]
        for j in range(i + 1, rank):
            first -= a[i, j] * u[order[j]]
            second -= a[i, j] * v[order[j]]
        u[order[i]] = first / a[i, i]
        v[order[i]] = second / a[i, i]


@kernel
def _border(
    work, end_q, rate, quaternion, shift, axis, scale, row, remainder, g, phase, a, w
):  # fmt: skip
    """The system in (g, t) and its two right-hand sides, into ``a`` (8, 9).

    ``w`` (2, 6) becomes the last node's move per unit of g[5] and of t.
    """
    for c in range(6):
        w[0, c] = w[1, c] = 0.0
    w[0, 0], w[0, 1], w[0, 2] = tangent(end_q)
    # Rω, ω in the clamp's frame: 2 q × (q × ω + w ω) + ω
    qw, qx, qy, qz = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
    ox, oy, oz = axis[0], axis[1], axis[2]
    cx = qy * oz - qz * oy + qw * ox
    cy = qz * ox - qx * oz + qw * oy
    cz = qx * oy - qy * ox + qw * oz
    w[1, 0] = ox + 2.0 * (qy * cz - qz * cy)
    w[1, 1] = oy + 2.0 * (qz * cx - qx * cz)
    w[1, 2] = oz + 2.0 * (qx * cy - qy * cx)
    for c in range(3):
        w[0, c] *= rate * scale[5]
        w[1, c] *= scale[6]
        w[1, 3 + c] = shift[c] * scale[6]
    for r in range(6):
        for c in range(6):
            a[r, c] = work[r, 12 + c]
        a[r, 6] = 0.0
        for c in range(6):
            a[r, 5] += work[r, c] * w[0, c]
            a[r, 6] += work[r, c] * w[1, c]
        a[r, 7] = work[r, 18]
        a[r, 8] = 0.0
    for c in range(7):
        a[6, c] = row[c]
    a[6, 7] = remainder
    a[6, 8] = 1.0
    for c in range(9):
        a[7, c] = 0.0
    if phase:
        # no turn of all loads about d3(0)
        for c in (0, 3):
            a[7, c] = -g[c + 1] / scale[c]
            a[7, c + 1] = g[c] / scale[c]


@kernel
def corrected_step(
    origin, quaternion, shift, axis, torsion_ratio, free_spin, node_s, node_pose, g, scale,
    row, ds, most, phase, direction,
):  # fmt: skip
    """From a point of the branch to the one where row·(u − u_old) = ds, by Newton's method.

    Parameters
    ----------
    origin, quaternion, shift, axis
        The moving clamp p, R, v, ω; R as a quaternion, ω in the frame R.
    node_s, node_pose : (m + 1,), (m + 1, 7)
        Nodes as in ``multiple_shooting.polish``; poses in place.
    g : (7,)
        F, M0 (its last entry the end's free turn if ``free_spin``) and t; in place.
    scale, row : (7,)
        Units of ``g``, and the seventh row, in these units.
    ds : float
        Step in these units.
    most : int
        Newton steps allowed.
    phase : bool
        Both ends lie on one line: fix the rod's turn about it, an eighth row that makes up for the
        rank that the others lack.
    direction : (7,)
        Becomes the unit tangent of the branch, in these units, with row·direction > 0.

    Returns
    -------
    residual, energy, iterations
        The mismatch on another mesh, infinite if there is no convergence; Newton steps made.
    """
    m = node_s.shape[0] - 1
    work, kept, t, b = np.zeros((12, 19)), np.empty((m, 6, 19)), np.empty((6, 6)), np.empty((6, 6))
    y, z, k = np.empty(WITH_JACOBIAN), np.empty(WITH_JACOBIAN), np.empty(12 * WITH_JACOBIAN)
    a, w, order, f = np.empty((8, 9)), np.empty((2, 6)), np.empty(7, np.int64), np.empty(6)
    du, x, last, clamp, p = np.empty(7), np.empty((m + 1, 6)), np.empty(6), np.empty(4), np.empty(3)
    rate = 1.0 if free_spin else -(1.0 / torsion_ratio - 1.0)
    remainder, density, done = ds, _COARSE, False
    for iteration in range(most):
        worst = forward(
            g, free_spin, node_s, node_pose, density, scale, work, kept, f, y, k, z, t, b
        )
        if not worst < 10.0:
            return math.inf, math.inf, iteration
        end = node_pose[m, 3:]
        _border(work, end, rate, quaternion, shift, axis, scale, row, remainder, g, phase, a, w)
        _bordered(a, order, du, direction)
        remainder = 0.0
        for c in range(6):
            last[c] = w[0, c] * du[5] + w[1, c] * du[6]
        backward(kept, last, du, x)
        size = 0.0
        for i in range(m + 1):
            for c in range(6):
                size = max(size, abs(x[i, c]))
        if not size < _FURTHEST:
            return math.inf, math.inf, iteration
        for c in range(7):
            du[c] *= scale[c]
        g[6] += du[6]
        moving_clamp(origin, quaternion, shift, axis, g[6], clamp, p)
        apply(x, du, 1.0, g, node_pose, clamp, torsion_ratio, free_spin)
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
        total += direction[c] * direction[c]
    for c in range(7):
        direction[c] /= math.sqrt(total)
    residual, energy = gaps(g, torsion_ratio, free_spin, node_s, node_pose, _CHECK, f, y, k, z)
    return residual, energy, iteration + 1
