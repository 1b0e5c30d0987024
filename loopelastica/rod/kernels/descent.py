"""Ways down from a saddle: the unstable modes of a discrete rod, and its energy's gradient flow.

The modes are the eigenvectors v of the constrained Hessian, H v = λ l v + Cᵀ y, C v = 0 (l: the
segments' lengths), with the lowest λ. They come from orthogonal iteration with (H + σ l)⁻¹ on the
directions that keep the end in place, σ just above −λ of the lowest.

The flow b' = −∇E/l, with the end kept in place, is followed by implicit steps linear in b: a step
of the time 1/σ is the Newton step of the Hessian shifted by σ (``minimization.newton_step``). σ is
as large as it must be for no frame to turn by more than `reach` in a step, so that soft motions
are resolved while stiff ones have long come to rest, and at least so large that the step goes
downhill. Where the energy has become convex and the step short, σ falls to zero and Newton's
method ends the descent.
"""

import math

import numpy as np

from loopelastica.rod.kernels.discrete_rod import DiscreteRod, assemble, measure, new_hessian
from loopelastica.rod.kernels.discrete_starts import first_moment
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.linalg import copy, copy_rows, inverse3
from loopelastica.rod.kernels.minimization import (
    imbalance,
    l1,
    line_search,
    move,
    new_step,
    newton_step,
    times,
)
from loopelastica.rod.kernels.rotations import turn

# shifts: none, and the least that makes a difference
_FLOOR, _SHIFT = 1e-6, 1.0
# Newton steps from the poses of a rod to its discrete copy, and their largest turn
_SETTLING, _NEAR = 20, 0.2
# orthogonal iterations; halvings of the interval that holds −λ
_ITERATIONS, _HALVINGS = 12, 5
# steps that bring an end into place
_CLOSINGS = 30
# steps of a descent; the last Newton step of one; |constraint|₁ of a closed rod; an imbalance that
# only an equilibrium has
_STEPS, _SHORT, _CLOSED, _BALANCED = 2000, 1e-2, 1e-4, 1e-6


@kernel
def unstable_modes(problem, k3, rod, force, modes):
    """The lowest modes of the discrete copy of an equilibrium, which ``rod`` becomes.

    ``rod`` has the frames of the equilibrium in its segments' middles and ``force`` (3,) is its
    force; both move to the critical point of the discrete energy next to them. ``modes``
    (count, blocks, 3) become turns of the frames, the largest of one radian. Returns the least
    shift found that leaves no unstable mode.
    """
    s, n = rod.s, rod.s.shape[0] - 1
    hessian = new_hessian(n, problem.free_spin)
    blocks = hessian.gradient.shape[0]
    step = new_step(blocks)
    _settle(problem, k3, rod, force, hessian, step)
    low, high = 0.0, _SHIFT
    index, _, _, _ = newton_step(hessian, s, True, high, step)
    while index != 0 and high < 1e9:
        low, high = high, 4.0 * high
        index, _, _, _ = newton_step(hessian, s, True, high, step)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        index, _, _, _ = newton_step(hessian, s, True, middle, step)
        if index == 0:
            high = middle
        else:
            low = middle
    newton_step(hessian, s, True, high, step)
    count = modes.shape[0]
    # numbers without order: none is orthogonal to a mode
    for i in range(count):
        for k in range(blocks):
            for a in range(3):
                modes[i, k, a] = math.sin(1.3 + (i + 1.7) * (1.1 * k + 2.3 * a + 0.01 * k * k))
        if problem.free_spin:
            modes[i, n, 0], modes[i, n, 1] = 0.0, 0.0
    for _ in range(_ITERATIONS):
        for i in range(count):
            _weigh(s, modes[i])
            _solve(hessian, step.inverse, modes[i])
            _keep_end(hessian, step, modes[i])
            for j in range(i):
                part = _product(s, modes[i], modes[j])
                for k in range(blocks):
                    for a in range(3):
                        modes[i, k, a] -= part * modes[j, k, a]
            size = 1.0 / math.sqrt(max(_product(s, modes[i], modes[i]), 1e-300))
            for k in range(blocks):
                for a in range(3):
                    modes[i, k, a] *= size
    for i in range(count):
        largest = 0.0
        for k in range(blocks):
            squares = modes[i, k, 0] ** 2 + modes[i, k, 1] ** 2 + modes[i, k, 2] ** 2
            largest = max(largest, squares)
        size = 1.0 / math.sqrt(max(largest, 1e-300))
        for k in range(blocks):
            for a in range(3):
                modes[i, k, a] *= size
    return high


@kernel
def _settle(problem, k3, rod, force, hessian, step):
    """Newton's method, without a shift, to the next critical point; H at its end."""
    trial = DiscreteRod(rod.s, np.empty(rod.frames.shape))
    nothing, before = np.zeros(3), math.inf
    for _ in range(_SETTLING):
        measure(rod, problem.position, k3, hessian.omega, step.constraint)
        assemble(rod, k3, force, hessian)
        now = imbalance(hessian, force) + l1(step.constraint)
        if not now < 2.0 * before or now < 1e-10:
            break
        before = min(now, before)
        _, _, _, largest = newton_step(hessian, rod.s, True, _FLOOR, step)
        t = min(1.0, _NEAR / max(largest, 1e-300))
        move(rod, step, t, False, nothing, trial)
        copy_rows(trial.frames, rod.frames)
        for i in range(3):
            force[i] += t * (step.multiplier[i] - force[i])
    measure(rod, problem.position, k3, hessian.omega, step.constraint)
    assemble(rod, k3, force, hessian)


@kernel
def _weigh(s, v):
    """Multiply a mode (blocks, 3) by the segments' lengths."""
    n = s.shape[0] - 1
    for k in range(v.shape[0]):
        length = s[k + 1] - s[k] if k < n else 1.0 / n
        for a in range(3):
            v[k, a] *= length


@kernel
def _product(s, v, w):
    """Σ l v·w of two modes."""
    n, total = s.shape[0] - 1, 0.0
    for k in range(v.shape[0]):
        length = s[k + 1] - s[k] if k < n else 1.0 / n
        total += length * (v[k, 0] * w[k, 0] + v[k, 1] * w[k, 1] + v[k, 2] * w[k, 2])
    return total


@kernel
def _solve(hessian, inverse, v):
    """Solve H z = v by the pivots of ``factor``, in place."""
    upper, blocks = hessian.upper, v.shape[0]
    y = np.empty(3)
    for k in range(1, blocks):
        times(inverse[k - 1], v[k - 1], y)
        for i in range(3):
            for j in range(3):
                v[k, i] -= upper[k - 1, j, i] * y[j]
    for k in range(blocks - 1, -1, -1):
        for i in range(3):
            y[i] = v[k, i]
            if k + 1 < blocks:
                for j in range(3):
                    y[i] -= upper[k, i, j] * v[k + 1, j]
        times(inverse[k], y, v[k])


@kernel
def _keep_end(hessian, step, v):
    """Take from a mode what moves the end: v − W S⁻¹ C v, W = H⁻¹ Cᵀ."""
    sides, x = hessian.sides, step.x
    moved, force = np.zeros(3), np.empty(3)
    for k in range(v.shape[0]):
        for a in range(3):
            for i in range(3):
                moved[i] += sides[k, a, i] * v[k, a]
    times(step.schur_inverse, moved, force)
    for k in range(v.shape[0]):
        for a in range(3):
            for i in range(3):
                v[k, a] -= x[k, a, 1 + i] * force[i]


@kernel
def displace(rod, mode, amount):
    """Turn the frames of a discrete rod by a mode (blocks, 3), in place."""
    for k in range(mode.shape[0]):
        turn(
            rod.frames[k + 1],
            amount * mode[k, 0],
            amount * mode[k, 1],
            amount * mode[k, 2],
        )


@kernel
def close(problem, k3, rod, force, reach):
    """Bring the end of a discrete rod to the clamp by the smallest turns, frames in place.

    ``force`` (3,) becomes the multiplier that balances the rod best. Returns |constraint|₁.
    """
    position, s, n = problem.position, rod.s, rod.s.shape[0] - 1
    hessian, c = new_hessian(n, problem.free_spin), np.empty(3)
    sides, gradient, nothing = hessian.sides, hessian.gradient, np.zeros(3)
    lever, inverse, pull, b = np.empty((3, 3)), np.empty((3, 3)), np.empty(3), np.empty(3)
    norm = math.inf
    for _ in range(_CLOSINGS):
        measure(rod, position, k3, hessian.omega, c)
        assemble(rod, k3, nothing, hessian)
        norm = l1(c)
        # the least-squares problem of Cᵀ, weighed with the segments' lengths
        for i in range(3):
            force[i] = 0.0
            for j in range(3):
                lever[i, j] = 0.0
        for k in range(n):
            weight = 1.0 / (s[k + 1] - s[k])
            for a in range(3):
                for i in range(3):
                    force[i] += weight * sides[k, a, i] * gradient[k, a]
                    for j in range(3):
                        lever[i, j] += weight * sides[k, a, i] * sides[k, a, j]
        inverse3(lever, inverse)
        if norm < 0.01 * _CLOSED:
            break
        times(inverse, c, pull)
        largest = 0.0
        for k in range(n):
            _turned_by(sides[k], pull, s[k + 1] - s[k], b)
            largest = max(largest, b[0] ** 2 + b[1] ** 2 + b[2] ** 2)
        share = min(1.0, reach / max(math.sqrt(largest), 1e-300))
        for k in range(n):
            _turned_by(sides[k], pull, s[k + 1] - s[k], b)
            turn(rod.frames[k + 1], -share * b[0], -share * b[1], -share * b[2])
    times(inverse, force, pull)
    copy(pull, force)
    return norm


@kernel
def _turned_by(side, pull, length, b):
    """Cᵀ pull of one segment over its length, into ``b`` (3,)."""
    for a in range(3):
        b[a] = (side[a, 0] * pull[0] + side[a, 1] * pull[1] + side[a, 2] * pull[2]) / length


@kernel
def descend(problem, k3, rod, force, moment, shift, reach):
    """Follow the gradient flow from a discrete rod, its frames in place, to where it ends.

    ``force`` (3,) is a multiplier near the rod's and becomes that of the end, ``moment`` (3,)
    becomes M at s = 0 there. ``shift`` is one over the first step's time, ``reach`` the largest
    turn of a frame in a step. Returns (arrived, energy).
    """
    position, s = problem.position, rod.s
    hessian = new_hessian(s.shape[0] - 1, problem.free_spin)
    omega, step = hessian.omega, new_step(hessian.gradient.shape[0])
    c, multiplier = step.constraint, step.multiplier
    trial, trial_c = DiscreteRod(s, np.empty(rod.frames.shape)), np.empty(3)
    mu = 0.0
    energy = measure(rod, position, k3, omega, c)
    for _ in range(_STEPS):
        assemble(rod, k3, force, hessian)
        norm_c, rest = l1(c), imbalance(hessian, force)
        if norm_c < _CLOSED and rest < _BALANCED:
            first_moment(omega, s, k3, moment)
            return True, energy
        if shift < _SHIFT:
            shift = _FLOOR
        _, shift, downhill, largest = newton_step(hessian, s, False, shift, step)
        for _ in range(12):
            if largest <= reach:
                break
            shift = max(_SHIFT, shift * min(max(largest / reach, 1.5), 4.0))
            _, shift, downhill, largest = newton_step(hessian, s, False, shift, step)
        mu = max(0.5 * mu, 1.1 * max(abs(multiplier[0]), abs(multiplier[1]), abs(multiplier[2])))
        t = min(1.0, reach / max(largest, 1e-300))
        taken, value = line_search(
            rod, position, k3, step, energy, mu, downhill - mu * norm_c, t,
            omega, trial, trial_c,
        )  # fmt: skip
        if not taken > 0.0:
            measure(rod, position, k3, omega, c)
            if shift < _SHIFT and largest < _SHORT and norm_c < _CLOSED:
                # rounding hides what is left
                first_moment(omega, s, k3, moment)
                return True, energy
            shift = 4.0 * max(_SHIFT, shift)
            if not shift < 1e12:
                break
            continue
        if taken < t:
            shift = 2.0 * max(_SHIFT, shift)
        elif largest < 0.6 * reach:
            shift = 0.4 * shift
        energy = value
        for i in range(3):
            force[i] += taken * (multiplier[i] - force[i])
        copy(trial_c, c)
        copy_rows(trial.frames, rod.frames)
    return False, math.inf
