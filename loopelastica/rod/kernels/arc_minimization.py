"""The rod of circular arcs that has least energy among points that repel it.

The only constraint is where the rod ends: three equations, r_n = r. Every iterate fulfils them.

1. Newton's method in the space of steps that keep the end in place to first order. Three
   reflections of Householder split it off; the multiplier λ, the force at the end, follows from
   them too. There the Hessian of E − λ·r_n, of order 2n − 5, is exact; where it is not positive
   definite, σ 1 is added. It is dense since places are integrals of tangents.
2. A line search on the energy. Each trial is brought back to r_n = r by the shortest way (`close`).
3. Where the gradient is small, the Hessian's factors LDLᵀ tell a minimum from a saddle. A saddle is
   left along a direction of negative curvature.

The loop evaluates one trial each time, so that every part is called from one place and compiled
once.
"""

import math
from typing import NamedTuple

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.kernels.arc_hessian import assemble
from loopelastica.rod.kernels.arc_rod import (
    ArcRod,
    Slopes,
    find_slopes,
    largest_turn,
    move,
    trace,
)
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.linalg import copy_rows
from loopelastica.rod.kernels.obstacles import repel
from loopelastica.rod.kernels.records import Status

CONVERGED, STALLED = int(Status.CONVERGED), int(Status.STALLED)
TOO_MANY_ITERATIONS = int(Status.TOO_MANY_ITERATIONS)

# largest turn of a tangent in one step, rad
_STEP = 0.5
# |r_n − r| of a closed rod; what rounding may leave of it
_CLOSED, _NEARLY_CLOSED = 1e-13, 1e-12
# trials of `close`, at first and within a line search
_FIRST, _PATIENCE = 300, 16
# of the energy's slope in a step, the share that must be gained; rounding, relative to the energy;
# steps whose gain is below it
_GAIN, _ROUNDING, _BLIND = 1e-4, 1e-13, 8
# curvature, K0/L per square of an L2 norm, that counts as none: a turn about the line of both ends
_FLAT = 1e-3
# turn of a step away from a saddle, rad, and how many are made
_LEAVE, _SADDLES = 0.2, 6
# trials along one step; shifts of one Hessian
_TRIALS, _SHIFTS = 14, 60
# by how much the gradient may miss the tolerance where rounding allows no better
_ENOUGH = 10.0


class Constraint(NamedTuple):
    """Slopes of the end's place, transposed, as reflectors times R; m = 2n − 2 coordinates."""

    vectors: Array
    """(3, m): v of the reflections 1 − size v vᵀ."""
    size: Array
    """(3,)."""
    upper: Array
    """(3, 3): R."""


class Room(NamedTuple):
    """Scratch for rods of n arcs; m = 2n − 2 coordinates."""

    trial: ArcRod
    closer: ArcRod
    slopes: Slopes
    closing: Slopes
    """As ``slopes``, of trials on their way to the end."""
    constraint: Constraint
    closing_constraint: Constraint
    forces: Array
    """(n + 1, 3): gradients of the repulsion by places."""
    blocks: Array
    """(n + 1, 3, 3): second derivatives by one place each."""
    chords: Array
    """(n, 3): forces on the chords."""
    moved: Array
    """(n + 1, 3, 2)."""
    gradient: Array
    """(m,), as ``step`` and ``other``."""
    step: Array
    other: Array
    hessian: Array
    """(m, m), as ``factors``."""
    factors: Array


def new_rod(s: Array) -> ArcRod:
    """Room for a rod with nodes at the arc lengths ``s`` (n + 1,)."""
    return ArcRod(s, np.zeros((len(s), 3)), np.zeros((len(s), 3)))


def new_room(s: Array) -> Room:
    """Scratch for rods with nodes at the arc lengths ``s`` (n + 1,)."""
    n = len(s) - 1
    m = 2 * n - 2
    nodes, coordinates, square = (n + 1, 3, 2), np.zeros((3, m)), np.zeros((2, m, m))
    slopes, closing = (
        Slopes(np.zeros(nodes), np.zeros(nodes), np.zeros(nodes), np.zeros(m)) for _ in range(2)
    )
    constraint, closing_constraint = (
        Constraint(np.zeros((3, m)), np.zeros(3), np.zeros((3, 3))) for _ in range(2)
    )
    return Room(
        new_rod(s), new_rod(s), slopes, closing, constraint, closing_constraint,
        np.zeros((n + 1, 3)), np.zeros((n + 1, 3, 3)), np.zeros((n, 3)), np.zeros(nodes),
        coordinates[0], coordinates[1], coordinates[2], square[0], square[1],
    )  # fmt: skip


@kernel
def _constrain(slopes, constraint):
    """Fill ``constraint`` by Householder's reflections."""
    v, size, upper = constraint.vectors, constraint.size, constraint.upper
    m = v.shape[1]
    for q in range(m):
        for i in range(3):
            v[i, q] = slopes.after[q // 2 + 1, i, q % 2]
    for i in range(3):
        square = 0.0
        for q in range(i, m):
            square += v[i, q] ** 2
        root = math.sqrt(square)
        if v[i, i] > 0.0:
            root = -root
        for j in range(i):
            # R above the diagonal, from the reflections before
            upper[j, i] = v[i, j]
            v[i, j] = 0.0
        upper[i, i] = root
        # v·v/2 once v has lost R's diagonal
        half = square - root * v[i, i]
        v[i, i] -= root
        size[i] = 1.0 / half if half > 1e-290 else 0.0
        for j in range(i + 1, 3):
            _reflect(constraint, i, v[j])


@kernel
def _reflect(constraint, i, x):
    """Apply reflection ``i`` to ``x`` (m,)."""
    v, dot = constraint.vectors[i], 0.0
    for q in range(i, x.shape[0]):
        dot += v[q] * x[q]
    dot *= constraint.size[i]
    for q in range(i, x.shape[0]):
        x[q] -= dot * v[q]


@kernel
def close(rod, closer, slopes, constraint, x, goal, patience):
    """Bring the rod's end to ``goal`` (3,) by the shortest way, all its tangents turning.

    ``closer``, ``slopes``, ``constraint`` and ``x`` (m,) are scratch. Returns whether it is there,
    and the bending energy.
    """
    upper = constraint.upper
    miss, energy, t, tries = math.inf, math.inf, 1.0, 0
    copy_rows(rod.tangents, closer.tangents)
    for _ in range(patience):
        here = trace(closer)
        square = 0.0
        for i in range(3):
            square += (closer.points[-1, i] - goal[i]) ** 2
        if here < math.inf and square < miss * miss:
            copy_rows(closer.tangents, rod.tangents)
            copy_rows(closer.points, rod.points)
            miss, energy, tries = math.sqrt(square), here, 0
            if miss <= _CLOSED:
                break
            find_slopes(rod, slopes)
            _constrain(slopes, constraint)
            # the least x with (slopes) x = goal − r_n: Rᵀ y = that, x = Q y
            for q in range(x.shape[0]):
                x[q] = 0.0
            for i in range(3):
                rest = goal[i] - rod.points[-1, i]
                for j in range(i):
                    rest -= upper[j, i] * x[j]
                x[i] = rest / upper[i, i] if upper[i, i] ** 2 > 1e-24 else 0.0
            for i in range(2, -1, -1):
                _reflect(constraint, i, x)
            turn = largest_turn(rod.s, x)
            t = 1.0 if turn < _STEP else _STEP / turn
        else:
            tries += 1
            t *= 0.5
            if tries > 12 or miss == math.inf:
                break
        move(rod, slopes.basis, x, t, closer)
    return miss < _NEARLY_CLOSED, energy


@kernel
def _project(rod, slopes, constraint, forces, effort, chords, gradient):
    """The ``gradient`` (m,), split by the reflections, and the forces on the ``chords`` (n, 3).

    The first three of the gradient become λ, −λ is among the forces. Returns the gradient's size
    along the constraint, relative to all forces at work.
    """
    n, upper = rod.s.shape[0] - 1, constraint.upper
    find_slopes(rod, slopes)
    for i in range(3):
        # the end's place is given: the force on it is no concern of the rod's
        chords[n - 1, i] = 0.0
    for k in range(n - 1, 0, -1):
        for side in range(2):
            at = 2 * k - 2 + side
            gradient[at] = slopes.bending[at]
            for i in range(3):
                gradient[at] += (
                    slopes.own[k, i, side] * forces[k, i] + slopes.after[k, i, side] * chords[k, i]
                )
        for i in range(3):
            chords[k - 1, i] = chords[k, i] + forces[k, i]
    _constrain(slopes, constraint)
    size, along = 0.0, 0.0
    for i in range(3):
        _reflect(constraint, i, gradient)
    for q in range(gradient.shape[0]):
        size += gradient[q] ** 2
        if q > 2:
            along += gradient[q] ** 2
    # R λ = the first three components
    for i in range(2, -1, -1):
        force = gradient[i]
        for j in range(i + 1, 3):
            force -= upper[i, j] * gradient[j]
        gradient[i] = force / upper[i, i] if upper[i, i] ** 2 > 1e-24 else 0.0
    for k in range(n):
        for i in range(3):
            chords[k, i] -= gradient[i]
    return math.sqrt(along) / (1.0 + math.sqrt(size) + effort)


@kernel
def _factor(hessian, shift, a):
    """LDLᵀ of the Hessian + ``shift`` along the constraint, up to its first pivot not positive.

    Row i of ``a`` (m, m) holds D_i Lᵀ_i from the diagonal on. Returns that pivot, or m.
    """
    m = a.shape[0]
    for i in range(3, m):
        for j in range(i, m):
            a[i, j] = hessian[i, j]
        a[i, i] += shift
    for p in range(3, m):
        if not a[p, p] > 0.0:
            return p
        for i in range(p + 1, m):
            f = a[p, i] / a[p, p]
            for j in range(i, m):
                a[i, j] -= f * a[p, j]
    return m


@kernel
def _solve(a, pivot, gradient, x):
    """Fill the step ``x`` (m,) after `_factor` came to ``pivot``; the energy's slope along it.

    Newton's step if all pivots were positive, otherwise a direction of negative curvature and 0.
    """
    m, slope = x.shape[0], 0.0
    for i in range(m):
        x[i] = 0.0
        if i > 2 and pivot == m:
            x[i] = -gradient[i]
    if pivot < m:
        x[pivot] = a[pivot, pivot] = 1.0
    for i in range(3, pivot):
        for j in range(i + 1, m):
            x[j] -= x[i] / a[i, i] * a[i, j]
    last = m - 1 if pivot == m else pivot
    for i in range(last, 2, -1):
        for j in range(i + 1, last + 1):
            x[i] -= x[j] * a[i, j]
        x[i] /= a[i, i]
        slope += x[i] * gradient[i]
    return slope if pivot == m else 0.0


@kernel
def minimize_arcs(rod, room, goal, obstacles, tolerance, iterations):
    """Minimize the energy of a rod among obstacles, from its tangents, in place.

    ``goal`` (3,) is its end. Returns a status, the energies of bending and of repulsion, and
    whether it is a minimum. A rod that did not converge is that of the last step.
    """
    trial, slopes, constraint, forces = room.trial, room.slopes, room.constraint, room.forces
    blocks, chords, gradient, step = room.blocks, room.chords, room.gradient, room.step
    other, hessian, factors, m = room.other, room.hessian, room.factors, room.step.shape[0]
    bending, contact, energy, slope, t = math.inf, math.inf, math.inf, 0.0, 1.0
    shift, largest, size, saddles, blind, tries, steps = 0.0, 0.0, math.inf, 0, 0, 0, 0
    copy_rows(rod.tangents, trial.tangents)
    status = CONVERGED
    for _ in range(_TRIALS * iterations):
        closed, bent = close(
            trial, room.closer, room.closing, room.closing_constraint, other, goal,
            _FIRST if steps == 0 else _PATIENCE,
        )  # fmt: skip
        pushed, effort = repel(obstacles, trial, forces, blocks)
        # near a minimum the gain is below rounding: the step is taken for what it is
        hasty = 0.0 < -slope < _ROUNDING * energy
        least = _GAIN * t * slope if slope != 0.0 else -_ROUNDING * energy
        if closed and (hasty or steps == 0 or bent + pushed <= energy + least):
            copy_rows(trial.tangents, rod.tangents)
            copy_rows(trial.points, rod.points)
            bending, contact, energy = bent, pushed, bent + pushed
            size = _project(rod, slopes, constraint, forces, effort, chords, gradient)
            largest = assemble(
                rod, slopes, constraint, blocks, chords, obstacles, room.moved, other, hessian
            )
            blind = blind + 1 if hasty else 0
            # a whole step speaks for the Hessian as it is
            shift = (0.1 if tries == 0 else 0.5) * shift
            if shift < 1e-2 or shift < 1e-8 * largest:
                shift = 0.0
            tries, steps = 0, steps + 1
            if steps > iterations:
                status = TOO_MANY_ITERATIONS
            if blind > _BLIND or not (energy < math.inf and largest < math.inf):
                status = STALLED
        else:
            tries += 1
            # a saddle is left on either side
            t = -t if slope == 0.0 and tries % 2 == 1 else 0.5 * t
            if steps > 0 and tries < _TRIALS:
                move(rod, slopes.basis, step, t, trial)
                continue
            shift = 16.0 * shift + 1.0 + 1e-4 * largest
            if shift > 1e6 * (1.0 + largest):
                status = STALLED
        # what cannot be improved is good enough a little above the tolerance
        flat = size <= (tolerance if status == CONVERGED else _ENOUGH * tolerance)
        if not (flat or status == CONVERGED) or steps == 0:
            break
        pivot = 0
        for _ in range(_SHIFTS):
            pivot = _factor(hessian, _FLAT + 1e-13 * largest if flat else shift, factors)
            if flat or pivot == m:
                break
            shift = 4.0 * shift + 0.1 + 1e-7 * largest
        if flat and (pivot == m or tries > 0 or saddles == _SADDLES or status != CONVERGED):
            return CONVERGED, bending, contact, pivot == m
        tries, saddles = 0, saddles + 1 if flat else saddles
        if not (flat or pivot == m):
            break
        slope = _solve(factors, pivot, gradient, step)
        for i in range(2, -1, -1):
            _reflect(constraint, i, step)
        turn = largest_turn(rod.s, step)
        t = _LEAVE / turn if flat else 1.0 if turn < _STEP else _STEP / turn
        move(rod, slopes.basis, step, t, trial)
    return status if status != CONVERGED else STALLED, bending, contact, False
