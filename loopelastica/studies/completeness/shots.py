"""Rods shot from their middle, and Levenberg–Marquardt on their loads there.

Nothing of the product's integrator, starts or corrector is used. The unknowns are force F and
moment M at s = ½ in the frame of that point; both halves are integrated outwards by Butcher's
method of sixth order, so that errors grow over half the length only. With t the tangent, ρ and Θ
the variations of position and rotation in space (K30 = 1):

    r' = t,  M(s) = M + F × r,  q' = ½ (0, M) q,  ρ' = Θ × t,  Θ' = M(s) × Θ + δM + δF × r + F × ρ

Any other K30 turns both ends about their tangents by M3 (1/K30 − 1) s.
What is to vanish are differences of positions and of frame vectors, free of angles: 12 numbers, or
6 with a free end spin, which has no torsion and takes no notice of d1 and d2.
"""

import math

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.kernels.jit import kernel

# a state: r, q (w, x, y, z), and for each load the variations ρ and Θ
_SIZE = 43
# Butcher's seven stages of order 6 (J. Austral. Math. Soc. 4 (1964) 179)
_A = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [1 / 3, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 2 / 3, 0.0, 0.0, 0.0, 0.0],
        [1 / 12, 1 / 3, -1 / 12, 0.0, 0.0, 0.0],
        [-1 / 16, 9 / 8, -3 / 16, -3 / 8, 0.0, 0.0],
        [0.0, 9 / 8, -3 / 8, -3 / 4, 1 / 2, 0.0],
        [9 / 44, -9 / 11, 63 / 44, 18 / 11, 0.0, -16 / 11],
    ]
)
_B = np.array([11 / 120, 0.0, 27 / 40, 27 / 40, -4 / 15, -4 / 15, 11 / 120])
# loads that turn the rod faster than this (radians per length) are no rod of interest
_FASTEST = 200.0
# after so many iterations a misfit above this will hardly ever vanish, falling with their square
_LATE, _HOPELESS = 24, 0.25


@kernel
def _slope(y: Array, x: Array, size: int, out: Array) -> None:
    """Derivative of a state: with its variations if ``size`` is `_SIZE`, without if it is 7."""
    f0, f1, f2 = x[0], x[1], x[2]
    r0, r1, r2 = y[0], y[1], y[2]
    w, a, b, c = y[3], y[4], y[5], y[6]
    m0 = x[3] + f1 * r2 - f2 * r1
    m1 = x[4] + f2 * r0 - f0 * r2
    m2 = x[5] + f0 * r1 - f1 * r0
    t0, t1, t2 = 2.0 * (a * c + w * b), 2.0 * (b * c - w * a), w * w - a * a - b * b + c * c
    out[0], out[1], out[2] = t0, t1, t2
    out[3] = -0.5 * (m0 * a + m1 * b + m2 * c)
    out[4] = 0.5 * (m0 * w + m1 * c - m2 * b)
    out[5] = 0.5 * (m1 * w + m2 * a - m0 * c)
    out[6] = 0.5 * (m2 * w + m0 * b - m1 * a)
    for j in range(7, size, 6):
        p0, p1, p2 = y[j], y[j + 1], y[j + 2]
        h0, h1, h2 = y[j + 3], y[j + 4], y[j + 5]
        out[j] = h1 * t2 - h2 * t1
        out[j + 1] = h2 * t0 - h0 * t2
        out[j + 2] = h0 * t1 - h1 * t0
        out[j + 3] = m1 * h2 - m2 * h1 + f1 * p2 - f2 * p1
        out[j + 4] = m2 * h0 - m0 * h2 + f2 * p0 - f0 * p2
        out[j + 5] = m0 * h1 - m1 * h0 + f0 * p1 - f1 * p0
    if size > 7:
        # δF × r and δM of the load that each variation belongs to
        out[11] -= r2
        out[12] += r1
        out[16] += r2
        out[18] -= r0
        out[22] -= r1
        out[23] += r0
        out[28] += 1.0
        out[35] += 1.0
        out[42] += 1.0


@kernel
def _half(x: Array, length: float, steps: int, size: int, y: Array, k: Array, at: Array) -> None:
    """Integrate ``y`` from the middle over ``length``, negative towards the start.

    ``at`` (n, 7) becomes the poses at n equal parts of the way; n divides ``steps``.
    """
    h = length / steps
    z = np.empty(size)
    for j in range(size):
        y[j] = 0.0
    y[3] = 1.0
    parts = at.shape[0]
    for step in range(steps):
        for stage in range(7):
            for j in range(size):
                z[j] = y[j]
            for past in range(stage):
                weight = h * _A[stage, past]
                if weight != 0.0:
                    for j in range(size):
                        z[j] += weight * k[past, j]
            _slope(z, x, size, k[stage])
        for stage in range(7):
            weight = h * _B[stage]
            if weight != 0.0:
                for j in range(size):
                    y[j] += weight * k[stage, j]
        norm = 1.0 / math.sqrt(y[3] ** 2 + y[4] ** 2 + y[5] ** 2 + y[6] ** 2)
        for j in range(3, 7):
            y[j] *= norm
        if (step + 1) * parts % steps == 0:
            row = (step + 1) * parts // steps - 1
            for j in range(7):
                at[row, j] = y[j]


@kernel
def turning_rate(x: Array) -> float:
    """A bound of |M(s)| over the whole rod, from the constant ½|M|² + F·t."""
    force = math.sqrt(x[0] ** 2 + x[1] ** 2 + x[2] ** 2)
    square = x[3] ** 2 + x[4] ** 2 + x[5] ** 2
    return math.sqrt(square + 2.0 * (force + x[2])) + math.sqrt(force)


@kernel
def _matrix(y: Array, spin: float, out: Array) -> None:
    """Frame (3, 3) of a state, turned about its tangent by ``spin``."""
    w, a, b, c = y[3], y[4], y[5], y[6]
    cos, sin = math.cos(0.5 * spin), math.sin(0.5 * spin)
    w, a, b, c = w * cos - c * sin, a * cos + b * sin, b * cos - a * sin, c * cos + w * sin
    out[0, 0], out[0, 1], out[0, 2] = (
        1 - 2 * (b * b + c * c),
        2 * (a * b - w * c),
        2 * (a * c + w * b),
    )
    out[1, 0], out[1, 1], out[1, 2] = (
        2 * (a * b + w * c),
        1 - 2 * (a * a + c * c),
        2 * (b * c - w * a),
    )
    out[2, 0], out[2, 1], out[2, 2] = (
        2 * (a * c - w * b),
        2 * (b * c + w * a),
        1 - 2 * (a * a + b * b),
    )


@kernel
def misfit(
    x: Array,
    torsion_ratio: float,
    position: Array,
    rotation: Array,
    free: bool,
    radians: float,
    res: Array,
    jac: Array,
    work: Array,
) -> float:
    """What a rod misses its clamping by, ``res`` (12,), with derivatives ``jac`` (12, 6).

    Steps are ``radians`` long in the fastest turning. ``work`` is (11, 43). Returns the largest
    component, infinite where the loads are too large.
    """
    rate = turning_rate(x)
    if not rate < _FASTEST:
        return math.inf
    steps = 4 + int(0.5 * rate / radians)
    size = _SIZE
    y0, y1, k = work[0], work[1], work[2:9]
    none = np.empty((1, 7))
    _half(x, -0.5, steps, size, y0, k, none)
    _half(x, 0.5, steps, size, y1, k, none)
    a, b, target = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    spin = 0.0 if free else 0.5 * (1.0 / torsion_ratio - 1.0)
    _matrix(y0, -spin * x[5], a)
    _matrix(y1, spin * x[5], b)
    for i in range(3):
        for j in range(3):
            target[i, j] = (
                a[i, 0] * rotation[0, j] + a[i, 1] * rotation[1, j] + a[i, 2] * rotation[2, j]
            )
    p = np.empty(3)
    for i in range(3):
        p[i] = a[i, 0] * position[0] + a[i, 1] * position[1] + a[i, 2] * position[2]
        res[i] = y1[i] - y0[i] - p[i]
    for i in range(12):
        for j in range(6):
            jac[i, j] = 0.0
    first = 2 if free else 0
    for i in range(3, 12):
        res[i] = 0.0
    for j in range(3):
        for i in range(3):
            if j >= first:
                res[3 + 3 * j + i] = b[i, j] - target[i, j]
    turn0, turn1 = np.empty(3), np.empty(3)
    for load in range(5 if free else 6):
        at = 7 + 6 * load
        for i in range(3):
            turn0[i], turn1[i] = y0[at + 3 + i], y1[at + 3 + i]
            if load == 5:
                turn0[i] -= spin * a[i, 2]
                turn1[i] += spin * b[i, 2]
        for i in range(3):
            u, v = (i + 1) % 3, (i + 2) % 3
            jac[i, load] = y1[at + i] - y0[at + i] - (turn0[u] * p[v] - turn0[v] * p[u])
            for j in range(first, 3):
                jac[3 + 3 * j + i, load] = (
                    turn1[u] * b[v, j]
                    - turn1[v] * b[u, j]
                    - turn0[u] * target[v, j]
                    + turn0[v] * target[u, j]
                )
    worst = 0.0
    for i in range(12):
        worst = max(worst, abs(res[i]))
    return worst


@kernel
def _damped_step(jac: Array, res: Array, scale: Array, damping: float, step: Array) -> bool:
    """The step of (JᵀJ + damping · scale²) step = −Jᵀres, by Cholesky."""
    n = 6
    a, g = np.empty((n, n)), np.empty(n)
    for i in range(n):
        for j in range(i + 1):
            total = 0.0
            for row in range(12):
                total += jac[row, i] * jac[row, j]
            a[i, j] = total / (scale[i] * scale[j])
        a[i, i] += damping
        total = 0.0
        for row in range(12):
            total += jac[row, i] * res[row]
        g[i] = -total / scale[i]
    for i in range(n):
        for j in range(i + 1):
            total = a[i, j]
            for m in range(j):
                total -= a[i, m] * a[j, m]
            if i == j:
                if not total > 0.0:
                    return False
                a[i, i] = math.sqrt(total)
            else:
                a[i, j] = total / a[j, j]
    for i in range(n):
        for m in range(i):
            g[i] -= a[i, m] * g[m]
        g[i] /= a[i, i]
    for i in range(n - 1, -1, -1):
        for m in range(i + 1, n):
            g[i] -= a[m, i] * g[m]
        g[i] /= a[i, i]
        step[i] = g[i] / scale[i]
    return True


@kernel
def descend(
    x: Array,
    torsion_ratio: float,
    position: Array,
    rotation: Array,
    free: bool,
    radians: float,
    goal: float,
    iterations: int,
) -> float:
    """Levenberg–Marquardt from the loads ``x`` (6,), in place; returns the misfit that is left."""
    res, trial = np.empty(12), np.empty(12)
    jac, jac_trial = np.empty((12, 6)), np.empty((12, 6))
    work, scale, step, there = np.empty((9, _SIZE)), np.full(6, 1e-30), np.empty(6), np.empty(6)
    if free:
        x[5] = 0.0
    worst = misfit(x, torsion_ratio, position, rotation, free, radians, res, jac, work)
    damping, growth = 1e-2, 2.0
    for iteration in range(iterations):
        if not worst > goal or worst == math.inf:
            break
        if iteration >= _LATE and worst * iteration**2 > _HOPELESS * _LATE**2:
            break
        square = 0.0
        for i in range(12):
            square += res[i] ** 2
        for j in range(6):
            total = 0.0
            for i in range(12):
                total += jac[i, j] ** 2
            scale[j] = max(scale[j], math.sqrt(total))
            if free and j == 5:
                scale[j] = 1.0
        if not _damped_step(jac, res, scale, damping, step):
            damping *= 4.0
            continue
        for j in range(6):
            there[j] = x[j] + step[j]
        far = misfit(
            there, torsion_ratio, position, rotation, free, radians, trial, jac_trial, work
        )
        # what the linear model says is left
        predicted = square
        for i in range(12):
            total = res[i]
            for j in range(6):
                total += jac[i, j] * step[j]
            predicted -= total**2
        left = math.inf
        if far < math.inf:
            left = 0.0
            for i in range(12):
                left += trial[i] ** 2
        ratio = (square - left) / predicted if predicted > 0.0 else -1.0
        if ratio > 1e-3:
            for j in range(6):
                x[j] = there[j]
            for i in range(12):
                res[i] = trial[i]
                for j in range(6):
                    jac[i, j] = jac_trial[i, j]
            worst = far
            damping = max(damping * max(1.0 / 3.0, 1.0 - (2.0 * ratio - 1.0) ** 3), 1e-15)
            growth = 2.0
        else:
            damping *= growth
            growth *= 2.0
            if damping > 1e8:
                break
    return float(worst)


@kernel
def descend_all(
    loads: Array,
    torsion_ratio: float,
    position: Array,
    rotation: Array,
    free: bool,
    radians: float,
    goal: float,
    iterations: int,
    left: Array,
) -> None:
    """`descend` from each of ``loads`` (n, 6), in place; ``left`` (n,) becomes the misfits."""
    for i in range(loads.shape[0]):
        left[i] = descend(
            loads[i], torsion_ratio, position, rotation, free, radians, goal, iterations
        )


@kernel
def trace(x: Array, radians: float, parts: int) -> Array:
    """Poses (2·parts + 1, 7) from start to end as seen from the middle, without extra spin."""
    steps = parts * (1 + int(0.5 * turning_rate(x) / (radians * parts)))
    out, y, k = np.empty((2 * parts + 1, 7)), np.empty(7), np.empty((7, 7))
    before = np.empty((parts, 7))
    _half(x, -0.5, steps, 7, y, k, before)
    for i in range(parts):
        out[parts - 1 - i] = before[i]
    for j in range(7):
        out[parts, j] = 1.0 if j == 3 else 0.0
    _half(x, 0.5, steps, 7, y, k, out[parts + 1 :])
    return out
