"""The rod of circular arcs that has least energy among points that repel it.

The only constraint is where the rod ends: three equations, r_n = r. Every iterate fulfils them.

1. Newton's method in the space of steps that keep the end in place to first order. Three Householder
   reflections split it off; the multiplier λ, the force at the end, follows from them too. There
   the Hessian of E − λ·r_n, of order 2n − 5, is exact; where it is not positive definite, σ 1 is
   added. It is dense since places are integrals of tangents.
2. A line search on the energy. Each trial is brought back to r_n = r by the shortest way (`close`).
3. Where the gradient is small, the Hessian's factors LDLᵀ tell a minimum from a saddle. A saddle is
   left along a direction of negative curvature.
"""

import math
from typing import NamedTuple

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.kernels.arc_rod import (
    ArcRod,
    Slopes,
    add_arcs,
    find_gradient,
    find_slopes,
    largest_turn,
    move,
    trace,
)
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.linalg import copy_rows, inverse3
from loopelastica.rod.kernels.obstacles import repel_itself, repel_pair, repel_points
from loopelastica.rod.kernels.records import Status

CONVERGED, STALLED = int(Status.CONVERGED), int(Status.STALLED)
TOO_MANY_ITERATIONS = int(Status.TOO_MANY_ITERATIONS)

# largest turn of a tangent in one step, rad
_STEP = 0.5
# |r_n − r| of a closed rod: rounding
_CLOSED = 1e-13
# of the energy's slope in a step, the share that must be gained; rounding, relative to the energy
_GAIN, _ROUNDING = 1e-4, 1e-13
# curvature, K0/L per square of an L2 norm, that counts as none: a turn about the line of both ends
_FLAT = 1e-3
# turn of a step away from a saddle, rad, and how many are made
_LEAVE, _SADDLES = 0.2, 6


class _Room(NamedTuple):
    """Scratch for n arcs; m = 2n − 2 coordinates."""

    slopes: Slopes
    forces: Array
    """(n + 1, 3): gradients by places."""
    blocks: Array
    """(n + 1, 3, 3): second derivatives by a place."""
    chords: Array
    """(n, 3): forces on the chords."""
    gradient: Array
    """(m,)."""
    sides: Array
    """(3, m): slopes of the end's place; becomes the reflectors."""
    size: Array
    """(3,): 2/|v|² of each reflector."""
    upper: Array
    """(3, 3): R of the decomposition of the transposed slopes."""
    hessian: Array
    """(m, m)."""
    factors: Array
    """(m, m)."""
    step: Array
    """(m,)."""
    other: Array
    """(m,)."""


@kernel
def _new_room(n):
    m = 2 * n - 2
    return _Room(
        Slopes(np.zeros((n + 1, 3, 2)), np.zeros((n + 1, 3, 2)), np.zeros((n + 1, 3, 2))),
        np.zeros((n + 1, 3)),
        np.zeros((n + 1, 3, 3)),
        np.zeros((n, 3)),
        np.zeros(m),
        np.zeros((3, m)),
        np.zeros(3),
        np.zeros((3, 3)),
        np.zeros((m, m)),
        np.zeros((m, m)),
        np.zeros(m),
        np.zeros(m),
    )


@kernel
def _end_slopes(slopes, sides):
    """Slopes of r_n by the coordinates, into ``sides`` (3, m)."""
    for k in range(1, slopes.after.shape[0] - 1):
        for side in range(2):
            for i in range(3):
                sides[i, 2 * k - 2 + side] = slopes.after[k, i, side]


@kernel
def _miss(rod, goal):
    """|r_n − r|, infinite rather than not a number."""
    square = 0.0
    for i in range(3):
        square += (rod.points[-1, i] - goal[i]) ** 2
    return math.sqrt(square) if square < 1e300 else math.inf


@kernel
def close(rod, goal, trial, room, patience):
    """Bring the rod's end to ``goal`` (3,) by small turns of its tangents, the shortest way.

    Returns whether it is there and the bending energy. ``trial`` is a rod for scratch.
    """
    slopes, sides, x = room.slopes, room.sides, room.other
    normal, inverse = np.empty((3, 3)), np.empty((3, 3))
    energy = trace(rod)
    miss = _miss(rod, goal) if energy < math.inf else math.inf
    for _ in range(patience):
        if miss <= _CLOSED or not miss < math.inf:
            break
        find_slopes(rod, slopes)
        _end_slopes(slopes, sides)
        spread = 0.0
        for i in range(3):
            for j in range(3):
                normal[i, j] = 0.0
                for q in range(x.shape[0]):
                    normal[i, j] += sides[i, q] * sides[j, q]
            spread += normal[i, i]
        for i in range(3):
            normal[i, i] += 1e-13 * spread
        inverse3(normal, inverse)
        for q in range(x.shape[0]):
            x[q] = 0.0
        for i in range(3):
            y = 0.0
            for j in range(3):
                y += inverse[i, j] * (goal[j] - rod.points[-1, j])
            for q in range(x.shape[0]):
                x[q] += y * sides[i, q]
        t, nearer = min(1.0, _STEP / max(largest_turn(rod.s, x), 1e-300)), False
        for _ in range(12):
            move(rod, slopes.basis, x, t, trial)
            energy = trace(trial)
            trial_miss = _miss(trial, goal) if energy < math.inf else math.inf
            nearer = trial_miss < miss
            if nearer:
                break
            t *= 0.5
        if not nearer:
            break
        copy_rows(trial.tangents, rod.tangents)
        copy_rows(trial.points, rod.points)
        miss = trial_miss
    energy = trace(rod)
    # rounding may keep a long rod of small arcs from the last digit
    return miss < 10.0 * _CLOSED, energy


@kernel
def _reflect_all(sides, size, upper):
    """Householder reflectors of the columns of ``sides``ᵀ in its rows, and R in ``upper``."""
    m = sides.shape[1]
    for i in range(3):
        square = 0.0
        for q in range(i, m):
            square += sides[i, q] ** 2
        root = math.sqrt(square)
        if sides[i, i] > 0.0:
            root = -root
        for j in range(i):
            # R above the diagonal, from the reflections before
            upper[j, i] = sides[i, j]
            sides[i, j] = 0.0
        upper[i, i] = root
        sides[i, i] -= root
        square = 0.0
        for q in range(i, m):
            square += sides[i, q] ** 2
        size[i] = 2.0 / max(square, 1e-300)
        for j in range(i + 1, 3):
            dot = 0.0
            for q in range(i, m):
                dot += sides[i, q] * sides[j, q]
            for q in range(i, m):
                sides[j, q] -= size[i] * dot * sides[i, q]


@kernel
def _reflect(room, i, x):
    """Apply reflector ``i`` to ``x`` (m,)."""
    v = room.sides
    dot = 0.0
    for q in range(i, x.shape[0]):
        dot += v[i, q] * x[q]
    for q in range(i, x.shape[0]):
        x[q] -= room.size[i] * dot * v[i, q]


@kernel
def _project(room, rod, obstacles):
    """Gradient and multiplier: fills ``room`` but for the Hessian.

    Returns energy of contact and the gradient's size along the constraint, relative to that of the
    forces at work. ``gradient`` is split by the reflections, ``chords`` include −λ.
    """
    slopes, forces, chords, gradient = room.slopes, room.forces, room.chords, room.gradient
    n = rod.s.shape[0] - 1
    energy, effort = repel_points(obstacles, rod, forces, room.blocks)
    own, own_effort = repel_itself(obstacles, rod, forces)
    for i in range(3):
        total = 0.0
        for k in range(n - 1, -1, -1):
            # the end's own place is given: the force on it is no concern of the rod's
            if k < n - 1:
                total += forces[k + 1, i]
            chords[k, i] = total
    find_slopes(rod, slopes)
    find_gradient(rod, chords, slopes.basis, gradient)
    _end_slopes(slopes, room.sides)
    _reflect_all(room.sides, room.size, room.upper)
    for i in range(3):
        _reflect(room, i, gradient)
    size, along = 0.0, 0.0
    for q in range(gradient.shape[0]):
        size += gradient[q] ** 2
        if q > 2:
            along += gradient[q] ** 2
    # R λ = the first three components
    upper, f = room.upper, np.zeros(3)
    for i in range(2, -1, -1):
        f[i] = gradient[i]
        for j in range(i + 1, 3):
            f[i] -= upper[i, j] * f[j]
        f[i] = f[i] / upper[i, i] if abs(upper[i, i]) > 1e-300 else 0.0
    for k in range(n):
        for i in range(3):
            chords[k, i] -= f[i]
    scale = 1.0 + math.sqrt(size) + effort + own_effort
    return energy + own, math.sqrt(along) / scale


@kernel
def _add_places(room, rod, obstacles):
    """Add to the upper triangle of the Hessian what is due to the places of nodes."""
    own, after, hessian, blocks = room.slopes.own, room.slopes.after, room.hessian, room.blocks
    n = rod.s.shape[0] - 1
    total, column = np.zeros((3, 3)), np.empty((3, 2))
    for j in range(n - 1, 0, -1):
        # a place after j moves by ``after`` of both, the place j itself by ``own`` of j
        for side in range(2):
            for i in range(3):
                column[i, side] = 0.0
                for k in range(3):
                    column[i, side] += (
                        blocks[j, i, k] * own[j, k, side] + total[i, k] * after[j, k, side]
                    )
        for i in range(1, j):
            _add_block(hessian, after, i, column, j)
        for p in range(2):
            for q in range(p, 2):
                for i in range(3):
                    part = 0.0
                    for k in range(3):
                        part += total[i, k] * after[j, k, q]
                    hessian[2 * j - 2 + p, 2 * j - 2 + q] += (
                        after[j, i, p] * part + own[j, i, p] * (column[i, q] - part)
                    )
        for i in range(3):
            for k in range(3):
                total[i, k] += blocks[j, i, k]
    if obstacles.density > 0.0:
        _add_pairs(room, rod, obstacles)


@kernel
def _add_block(hessian, rows, i, column, j):
    """Add rowsᵀ column, of tangents ``i`` ≤ ``j``, to the Hessian."""
    for p in range(2):
        for q in range(2):
            hessian[2 * i - 2 + p, 2 * j - 2 + q] += (
                rows[i, 0, p] * column[0, q]
                + rows[i, 1, p] * column[1, q]
                + rows[i, 2, p] * column[2, q]
            )


@kernel
def _add_pairs(room, rod, obstacles):
    """The part of `_add_places` that is due to pairs of nodes."""
    own, after, nodes = room.slopes.own, room.slopes.after, rod.points
    n = rod.s.shape[0] - 1
    # how the gap between nodes k and m moves with each tangent from k to m
    slopes, column, gap = np.zeros((n + 1, 3, 2)), np.empty((3, 2)), np.empty(3)
    for k in range(n):
        for m in range(k + 2, n + 1):
            _, p, q = repel_pair(obstacles, rod, k, m)
            if p == 0.0:
                continue
            for i in range(3):
                gap[i] = nodes[m, i] - nodes[k, i]
            for j in range(k, m + 1):
                for side in range(2):
                    for i in range(3):
                        moved = own[j, i, side] if j == m else after[j, i, side]
                        slopes[j, i, side] = moved - own[j, i, side] if j == k else moved
            for j in range(max(k, 1), min(m, n - 1) + 1):
                for side in range(2):
                    dot = 0.0
                    for i in range(3):
                        dot += gap[i] * slopes[j, i, side]
                    for i in range(3):
                        column[i, side] = p * slopes[j, i, side] + q * dot * gap[i]
                for i in range(max(k, 1), j + 1):
                    _add_block(room.hessian, slopes, i, column, j)


@kernel
def _assemble(room, rod, obstacles):
    """The Hessian of E − λ·r_n, split by the reflections; its size."""
    hessian, w = room.hessian, room.other
    m = hessian.shape[0]
    for i in range(m):
        for j in range(m):
            hessian[i, j] = 0.0
    add_arcs(rod, room.chords, room.slopes.basis, hessian)
    _add_places(room, rod, obstacles)
    largest = 0.0
    for i in range(m):
        for j in range(i):
            hessian[i, j] = hessian[j, i]
        largest = max(largest, abs(hessian[i, i]))
    for r in range(3):
        # (1 − β v vᵀ) H (1 − β v vᵀ) = H − v wᵀ − w vᵀ
        v, beta, dot = room.sides[r], room.size[r], 0.0
        for i in range(m):
            w[i] = 0.0
        for j in range(m):
            if v[j] != 0.0:
                for i in range(m):
                    w[i] += beta * v[j] * hessian[j, i]
        for i in range(m):
            dot += v[i] * w[i]
        for i in range(m):
            w[i] -= 0.5 * beta * dot * v[i]
        for i in range(m):
            vi, wi = v[i], w[i]
            for j in range(m):
                hessian[i, j] -= vi * w[j] + wi * v[j]
    return largest


@kernel
def _factor(room, shift):
    """LDLᵀ of the Hessian + ``shift`` along the constraint, up to its first pivot not positive.

    Row i of ``factors`` holds D_i Lᵀ_i from the diagonal on. Returns that pivot, m if there is none.
    """
    a, hessian = room.factors, room.hessian
    m = a.shape[0]
    for i in range(3, m):
        for j in range(i, m):
            a[i, j] = hessian[i, j]
        a[i, i] += shift
    for p in range(3, m):
        if not a[p, p] > 0.0:
            return p
        inverse = 1.0 / a[p, p]
        for i in range(p + 1, m):
            f = a[p, i] * inverse
            if f != 0.0:
                for j in range(i, m):
                    a[i, j] -= f * a[p, j]
    return m


@kernel
def _newton_step(room, shift, least, size):
    """Fill ``step``; the Hessian is shifted until it is positive definite. Returns the shift."""
    a, x, m = room.factors, room.step, room.step.shape[0]
    for _ in range(60):
        if _factor(room, shift) == m:
            break
        shift = max(4.0 * shift, least, 1e-6 * size)
    for i in range(m):
        x[i] = 0.0 if i < 3 else -room.gradient[i]
    for i in range(3, m):
        f = x[i] / a[i, i]
        for j in range(i + 1, m):
            x[j] -= f * a[i, j]
    for i in range(m - 1, 2, -1):
        total = x[i]
        for j in range(i + 1, m):
            total -= a[i, j] * x[j]
        x[i] = total / a[i, i]
    return shift


@kernel
def _downwards(room, pivot):
    """Fill ``step`` with a direction of negative curvature, after `_factor` stopped there."""
    a, x = room.factors, room.step
    for i in range(x.shape[0]):
        x[i] = 1.0 if i == pivot else 0.0
    for i in range(pivot - 1, 2, -1):
        total = 0.0
        for j in range(i + 1, pivot + 1):
            total -= a[i, j] * x[j]
        x[i] = total / a[i, i]


@kernel
def _energy(rod, bending, obstacles, room):
    """The total energy of a rod whose bending energy is known."""
    contact, _ = repel_points(obstacles, rod, room.forces, room.blocks)
    own, _ = repel_itself(obstacles, rod, room.forces)
    return bending + contact + own


@kernel
def minimize_arcs(s, tangents, goal, obstacles, tolerance, iterations):
    """Minimize the energy of a rod among obstacles, from its ``tangents`` (n + 1, 3), in place.

    ``s`` (n + 1,) are the arc lengths of its nodes, ``goal`` (3,) its end. Returns a status, the
    energies of bending and of contact, whether it is a minimum, and the iterations made. The
    tangents of a rod that did not converge are those of the last step.
    """
    n = s.shape[0] - 1
    rod = ArcRod(s, tangents, np.zeros((n + 1, 3)))
    trial = ArcRod(s, tangents.copy(), np.zeros((n + 1, 3)))
    scratch = ArcRod(s, tangents.copy(), np.zeros((n + 1, 3)))
    room, basis = _new_room(n), np.zeros((n + 1, 3, 2))
    closed, bending = close(rod, goal, scratch, room, 200)
    if not closed:
        return STALLED, math.inf, math.inf, False, 0
    m, shift, saddles, hasty = 2 * n - 2, 0.0, 0, 0
    for iteration in range(iterations):
        contact, size = _project(room, rod, obstacles)
        energy = bending + contact
        largest = _assemble(room, rod, obstacles)
        if not largest < math.inf:
            return STALLED, math.inf, math.inf, False, iteration
        if size <= tolerance:
            pivot = _factor(room, _FLAT + 1e-13 * largest)
            if pivot == m or saddles >= _SADDLES:
                return CONVERGED, bending, contact, pivot == m, iteration
            saddles += 1
            _downwards(room, pivot)
            slope = 0.0
        else:
            shift = _newton_step(room, shift, 1.0, largest)
            slope = 0.0
            for i in range(3, m):
                slope += room.gradient[i] * room.step[i]
        for i in range(2, -1, -1):
            _reflect(room, i, room.step)
        turned = largest_turn(s, room.step)
        t = _LEAVE / turned if slope == 0.0 else min(1.0, _STEP / max(turned, 1e-300))
        for k in range(n + 1):
            copy_rows(room.slopes.basis[k], basis[k])
        # near the end the gain is below rounding: the step is taken for what it is
        blind = -slope < _ROUNDING * (1.0 + energy) and slope != 0.0
        hasty = hasty + 1 if blind else 0
        if hasty > 8:
            return STALLED, bending, contact, False, iteration
        taken = False
        for tries in range(30):
            move(rod, basis, room.step, t, trial)
            closed, bent = close(trial, goal, scratch, room, 12)
            if closed:
                total = _energy(trial, bent, obstacles, room)
                if total <= energy + _GAIN * t * slope - (0.0 if slope else 1e-12 * energy) or blind:
                    taken = True
                    break
            # a saddle is left on either side
            t = -t if slope == 0.0 and tries % 2 == 0 else 0.5 * t
        if not taken:
            if slope == 0.0:
                return CONVERGED, bending, contact, False, iteration
            if size <= 1e3 * tolerance or shift > 1e8 * largest:
                return STALLED, bending, contact, False, iteration
            shift = max(16.0 * shift, 1.0, 1e-4 * largest)
            continue
        # a whole step speaks for the Hessian as it is
        shift = 0.0 if shift < 1.0 or shift < 1e-6 * largest else (0.1 if tries == 0 else 0.5) * shift
        copy_rows(trial.tangents, rod.tangents)
        bending = trace(rod)
    return TOO_MANY_ITERATIONS, bending, contact, False, iterations
