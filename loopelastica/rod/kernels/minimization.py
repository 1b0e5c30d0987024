"""The discrete rod of least energy: a start wherever no stored rod is near.

The Newton step of the constrained problem (``discrete_rod``) comes from a block tridiagonal LDLᵀ
with four right-hand sides and a 3×3 Schur complement S = C H⁻¹ Cᵀ. It goes downhill iff H and S
have equally many negative eigenvalues; otherwise, or if the step is long, H is shifted. A line
search on energy + μ |constraint|₁ with a second-order correction makes it robust: it starts from
anywhere. At the end the difference of the two counts is the Morse index of the discrete rod, and a
saddle is left by a bow.

With a free end spin the twist costs nothing in the end: M3 = 0.
"""

import math
from typing import NamedTuple

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.kernels.discrete_rod import (
    DiscreteRod,
    assemble,
    factor,
    measure,
    new_hessian,
)
from loopelastica.rod.kernels.discrete_starts import bow, first_moment
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.linalg import copy, copy_rows, inverse3, negative_eigenvalues
from loopelastica.rod.kernels.rotations import larger, turn

_ITERATIONS = 200
# largest turn of a frame in one step, and of a step that is cut to it rather than shifted
_STEP, _RADIUS = 1.0, 3.0
# shifts of H: always; the least that makes a difference
_FLOOR, _SHIFT = 1e-6, 4.0
# |constraint|₁ and imbalance of a rod that multiple shooting refines
_CLOSED, _BALANCED = 1e-4, 1e-3


class Step(NamedTuple):
    """Room for a Newton step of the constrained problem; chains take it too."""

    inverse: Array
    """(blocks, 3, 3): inverse pivots."""
    x: Array
    """(blocks, 3, 4): H⁻¹(−g, Cᵀ)."""
    schur_inverse: Array
    """(3, 3)."""
    multiplier: Array
    """(3,): F after a whole step."""
    b: Array
    """(blocks, 3): the step."""
    constraint: Array
    """(3,): Σ l_k R_k e3 − r."""


@kernel
def new_step(blocks):
    """Room for a step of so many blocks."""
    return Step(
        np.empty((blocks, 3, 3)),
        np.empty((blocks, 3, 4)),
        np.empty((3, 3)),
        np.empty(3),
        np.empty((blocks, 3)),
        np.empty(3),
    )


@kernel
def imbalance(hessian, force):
    """Largest component of the Lagrangian's gradient, relative to 1 + |F|."""
    gradient, sides = hessian.gradient, hessian.sides
    size = math.sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2)
    worst = 0.0
    for k in range(gradient.shape[0]):
        for i in range(3):
            r = gradient[k, i]
            for j in range(3):
                r -= sides[k, i, j] * force[j]
            worst = larger(worst, abs(r))
    return worst / (1.0 + size)


@kernel
def newton_step(hessian, s, once, shift, step):
    """Solve the constrained Newton equations, H shifted until the step is short and goes downhill.

    Fills ``step`` but for its constraint, which is read. With ``once`` H keeps the first shift.
    Returns neg(H) − neg(S), the shift, the slope g·b and the largest turn of b.
    """
    gradient, sides, x = hessian.gradient, hessian.sides, step.x
    blocks = gradient.shape[0]
    schur, target = np.empty((3, 3)), np.empty(3)
    index, downhill, largest = 0, 0.0, 0.0
    for _ in range(14):
        for k in range(blocks):
            for i in range(3):
                x[k, i, 0] = -gradient[k, i]
                for j in range(3):
                    x[k, i, 1 + j] = sides[k, i, j]
        negative = factor(hessian, s, shift, step.inverse, x)
        for i in range(3):
            target[i] = -step.constraint[i]
            for j in range(3):
                schur[i, j] = 0.0
        for k in range(s.shape[0] - 1):
            for i in range(3):
                for a in range(3):
                    side = sides[k, a, i]
                    target[i] -= side * x[k, a, 0]
                    for j in range(3):
                        schur[i, j] += side * x[k, a, 1 + j]
        count, _ = negative_eigenvalues(schur, 0.0)
        index = negative - count
        if index == 0 or once:
            inverse3(schur, step.schur_inverse)
            _solve_by(step.schur_inverse, schur, target, step.multiplier)
            downhill, largest = _combine(gradient, step)
            # barely convex: the step would be long, and no fraction of it any good
            if once or largest < _RADIUS:
                break
        shift = max(_SHIFT, 4.0 * shift)
    return index, shift, downhill, largest


@kernel
def _solve_by(inverse, a, y, x):
    """Solve a x = y (3,) by an ``inverse`` that has lost digits, and twice for what is left."""
    times(inverse, y, x)
    for _ in range(2):
        r0 = y[0] - a[0, 0] * x[0] - a[0, 1] * x[1] - a[0, 2] * x[2]
        r1 = y[1] - a[1, 0] * x[0] - a[1, 1] * x[1] - a[1, 2] * x[2]
        r2 = y[2] - a[2, 0] * x[0] - a[2, 1] * x[1] - a[2, 2] * x[2]
        for i in range(3):
            x[i] += inverse[i, 0] * r0 + inverse[i, 1] * r1 + inverse[i, 2] * r2


@kernel
def times(a, v, out):
    """Product a v of a (3, 3) and a (3,) array, into ``out``."""
    for i in range(3):
        out[i] = a[i, 0] * v[0] + a[i, 1] * v[1] + a[i, 2] * v[2]


@kernel
def _combine(gradient, step):
    """The step b = H⁻¹(−g + Cᵀ F): its slope g·b and its largest turn."""
    x, b = step.x, step.b
    downhill, largest = 0.0, 0.0
    for k in range(b.shape[0]):
        total = 0.0
        for i in range(3):
            b[k, i] = x[k, i, 0]
            for j in range(3):
                b[k, i] += x[k, i, 1 + j] * step.multiplier[j]
            total += b[k, i] * b[k, i]
            downhill += gradient[k, i] * b[k, i]
        largest = max(largest, total)
    return downhill, math.sqrt(largest)


@kernel
def line_search(rod, position, k3, step, energy, mu, downhill, t, omega, trial, trial_c):
    """Backtrack along b on energy + μ |c|₁; ``trial`` and ``trial_c`` are the accepted point.

    The first tries are helped by a second-order correction, b − H⁻¹ Cᵀ S⁻¹ c(trial), which brings
    the constraint's curvature back to zero. Returns the fraction taken (0 if none) and the energy.
    """
    shift, turned_back = np.empty(3), np.empty(3)
    merit = energy + mu * l1(step.constraint)
    for attempt in range(12):
        enough = merit + 1e-4 * t * downhill + 1e-13 * abs(merit)
        move(rod, step, t, False, shift, trial)
        value = measure(trial, position, k3, omega, trial_c)
        if value + mu * l1(trial_c) <= enough:
            return t, value
        if attempt < 3:
            times(step.schur_inverse, trial_c, turned_back)
            for i in range(3):
                shift[i] = -turned_back[i]
            move(rod, step, t, True, shift, trial)
            value = measure(trial, position, k3, omega, trial_c)
            if value + mu * l1(trial_c) <= enough:
                return t, value
        t *= 0.4
    return 0.0, energy


@kernel
def l1(c):
    """|c|₁ of (3,)."""
    return abs(c[0]) + abs(c[1]) + abs(c[2])


@kernel
def move(rod, step, t, corrected, extra, trial):
    """Fill ``trial`` with frames exp(t b), or frames exp(t b + W extra) with W = H⁻¹ Cᵀ."""
    frames, b, x = rod.frames, step.b, step.x
    last = frames.shape[0] - 1
    for c in range(4):
        trial.frames[0, c] = frames[0, c]
        trial.frames[last, c] = frames[last, c]
    for k in range(b.shape[0]):
        v0, v1, v2 = t * b[k, 0], t * b[k, 1], t * b[k, 2]
        if corrected:
            for j in range(3):
                v0 += x[k, 0, 1 + j] * extra[j]
                v1 += x[k, 1, 1 + j] * extra[j]
                v2 += x[k, 2, 1 + j] * extra[j]
        for c in range(4):
            trial.frames[k + 1, c] = frames[k + 1, c]
        turn(trial.frames[k + 1], v0, v1, v2)


@kernel
def minimize(problem, torsion_ratio, rod, force, moment):
    """Minimize the energy of a discrete ``rod``, its frames in place.

    ``torsion_ratio`` takes the place of the problem's. ``force`` (3,) starts and ends as the
    multiplier, ``moment`` (3,) is M at s = 0. Returns (found, energy, Morse index, iterations).
    """
    position, s, n = problem.position, rod.s, rod.s.shape[0] - 1
    k3 = 1.0 if problem.free_spin else torsion_ratio
    hessian = new_hessian(n, problem.free_spin)
    omega, step = hessian.omega, new_step(hessian.gradient.shape[0])
    c, multiplier = step.constraint, step.multiplier
    trial, trial_c = DiscreteRod(s, np.empty((n + 2, 4))), np.empty(3)
    mu, shift, bows = 0.0, _FLOOR, 0
    energy = measure(rod, position, k3, omega, c)
    for iteration in range(_ITERATIONS):
        assemble(rod, k3, force, hessian)
        norm_c = l1(c)
        done = norm_c < _CLOSED and imbalance(hessian, force) < _BALANCED
        index, shift, downhill, largest = newton_step(
            hessian, s, done, _FLOOR if done else shift, step
        )
        largest_force = max(abs(multiplier[0]), abs(multiplier[1]), abs(multiplier[2]))
        # a straight start: the constraint has no slope along the chord
        stuck = not largest_force < 1e12
        if done and (index <= 0 or bows >= 2):
            first_moment(omega, s, k3, moment)
            return True, energy, index, iteration
        if not done and not stuck:
            # a multiplier that was large once must not weigh the constraint for ever
            mu = max(0.5 * mu, 1.1 * largest_force)
            t = min(1.0, _STEP / max(largest, 1e-300))
            taken, value = line_search(
                rod, position, k3, step, energy, mu, downhill - mu * norm_c, t,
                omega, trial, trial_c,
            )  # fmt: skip
            stuck = taken == 0.0
        if done or stuck:
            # leave a saddle, or a place from which no direction leads down
            bows += 1
            if bows > 3:
                return False, math.inf, 0, iteration
            bow(rod, 0.07, bows)
            energy = measure(rod, position, k3, omega, c)
            mu, shift = 0.0, _FLOOR
            continue
        if taken == t:
            shift = 0.25 * shift if shift > 0.5 * _SHIFT else _FLOOR
        energy = value
        for i in range(3):
            force[i] += taken * (multiplier[i] - force[i])
        copy(trial_c, c)
        copy_rows(trial.frames, rod.frames)
    return False, math.inf, 0, _ITERATIONS
