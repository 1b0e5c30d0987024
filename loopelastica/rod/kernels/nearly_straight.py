"""The rod that is bent by little: a twisted beam under tension, in closed form.

Seen along the chord the tangent is (θ, 1) but for θ²/2, θ = θx + iθy being small. With the tension
T and the transverse force N = T C along and across the chord, and m = M3, the balance of moments
is linear,

    θ'' − i m θ' − T θ = −N,      θ = C + A e^{λ1 s} + B e^{λ2 (s − 1)},      λ = i m/2 ∓ g,
    g² = T − m²/4.

The end tangents and ∫θ ds = 0, the ends being on the chord, give A, B and C for any T and m. Two
equations are left, for the shortening and for the end-to-end turn ψ:

    W(T, m) = ½ ∫ |θ|² ds = 1 − |r|,      m/K30 + ½ ∫ Im(θ* θ') ds = ψ + 2π n.

W falls from infinity at the tension T1(m) at which the rod buckles to 0 at infinite tension, so
each n has one rod with T > T1: the one of least energy. Where the end tangents are on the chord
nothing bends the rod until T = T1, and the direction that it buckles to is free; then a tilt too
small to matter chooses one.

All this is the leading order in θ². It serves as the start of multiple shooting where the boundary
layers reach each other; between 1 − |r| = 1e-9 and 1e-2 nothing else follows the bend that the
small tilts select.
"""

import cmath
import math
from typing import NamedTuple

import numpy as np

from loopelastica.rod.kernels.discrete_starts import graded_nodes
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.linalg import copy
from loopelastica.rod.kernels.rotations import (
    align,
    end_turn,
    matrix_from_quaternion,
    relative,
    spin,
    turn,
    zyz_angles,
)

# 1 − |r| and tilts (rad) up to which the linear theory is a good start
_SHORTENED, _TILTED = 0.01, 0.25
# √(T − m²/4) above which loads and nodes no longer hold the rod
_TENSE = 70.0
# tension that stands for none: there the three solutions are no longer independent
_SLACK = 1e-3
# distance from the buckling tension, relative to 1 + T1, that is still told from it, and the tilt,
# relative to √(1 − |r|), that chooses a direction there
_BUCKLED, _CHOICE = 1e-9, 1e-5


class Bend(NamedTuple):
    """A slightly bent rod: tension, twisting moment, and the parts of its tangent."""

    tension: float
    moment: float
    first: complex
    """λ1"""
    second: complex
    """λ2"""
    a: complex
    b: complex
    c: complex


class Partial(NamedTuple):
    """Integrals from 0 to s of the parts of the tangent and of their products."""

    a: complex
    b: complex
    a_squared: float
    b_squared: float
    a_conjugate_b: complex


@kernel
def _mean_exponential(z):
    """∫₀¹ e^{z s} ds = (e^z − 1)/z."""
    if abs(z) < 1e-5:
        return 1.0 + 0.5 * z
    return (cmath.exp(z) - 1.0) / z


@kernel
def _bend(tension, moment, tilt_0, tilt_1):
    """The `Bend` that two tilts (complex) give a rod under a tension with a twisting moment."""
    if abs(tension) < _SLACK:
        tension = math.copysign(_SLACK, tension)
    g = cmath.sqrt(complex(tension - 0.25 * moment * moment))
    if abs(g) < 1e-4:
        g = complex(1e-4)
    first, second = 0.5j * moment - g, 0.5j * moment + g
    # what each part is at the other end, and its mean
    end_a, end_b = cmath.exp(first), cmath.exp(-second)
    mean_a, mean_b = _mean_exponential(first), _mean_exponential(-second)
    # C = −A mean_a − B mean_b; the two tilts
    p, q = 1.0 - mean_a, end_b - mean_b
    r, t = end_a - mean_a, 1.0 - mean_b
    determinant = p * t - q * r
    if abs(determinant) < 1e-300:
        determinant = complex(1e-300)
    a = (tilt_0 * t - q * tilt_1) / determinant
    b = (p * tilt_1 - tilt_0 * r) / determinant
    return Bend(tension, moment, first, second, a, b, -a * mean_a - b * mean_b)


@kernel
def _partial(bend, s):
    """The `Partial` integrals of a bend up to ``s``."""
    first, second = bend.first, bend.second
    decay_a, decay_b = complex(2.0 * first.real * s), complex(-2.0 * second.real * s)
    at_b = cmath.exp(second * (s - 1.0))
    mixed = bend.a.conjugate() * bend.b * cmath.exp(-second)
    return Partial(
        bend.a * s * _mean_exponential(first * s),
        bend.b * at_b * s * _mean_exponential(-second * s),
        abs(bend.a) ** 2 * s * _mean_exponential(decay_a).real,
        abs(bend.b * at_b) ** 2 * s * _mean_exponential(decay_b).real,
        mixed * s * _mean_exponential((first.conjugate() + second) * s),
    )


@kernel
def _tangent(bend, s):
    """θ at ``s``."""
    return bend.c + bend.a * cmath.exp(bend.first * s) + bend.b * cmath.exp(bend.second * (s - 1.0))


@kernel
def _shortening(bend, s):
    """½ ∫ |θ|² from 0 to ``s``."""
    part = _partial(bend, s)
    squares = abs(bend.c) ** 2 * s + part.a_squared + part.b_squared
    return 0.5 * squares + part.a_conjugate_b.real + (bend.c.conjugate() * (part.a + part.b)).real


@kernel
def _area(bend, s):
    """½ ∫ Im(θ* θ') from 0 to ``s``, by which the frame turns beyond its twist."""
    part = _partial(bend, s)
    first, second, mixed = bend.first, bend.second, part.a_conjugate_b
    total = first * part.a_squared + second * part.b_squared
    total += second * mixed + first * mixed.conjugate()
    total += bend.c.conjugate() * (_tangent(bend, s) - _tangent(bend, 0.0))
    return 0.5 * total.imag


@kernel
def _energy(bend, torsion_ratio):
    """½ ∫ |θ'|² ds and that of the twist."""
    part = _partial(bend, 1.0)
    first, second = bend.first, bend.second
    squares = abs(first) ** 2 * part.a_squared + abs(second) ** 2 * part.b_squared
    bending = 0.5 * squares + (first.conjugate() * second * part.a_conjugate_b).real
    return bending + 0.5 * bend.moment**2 / torsion_ratio


@kernel
def _buckling(a, kappa):
    """Zero where a clamped rod of M3 = 2a buckles under the tension a² − κ².

    The determinant of the three conditions on θ at that load, without its zero at κ = a: there, at
    no tension, two of the three solutions are one.
    """
    if abs(kappa - a) < 1e-6:
        kappa = a + 1e-6
    c, s = math.cos(0.5 * kappa), math.sin(0.5 * kappa)
    near, far = 0.5 * (a - kappa), 0.5 * (a + kappa)
    sinc_near, sinc_far = math.sin(near) / near, math.sin(far) / far
    even, odd = 0.5 * (sinc_near + sinc_far), 0.5 * (sinc_near - sinc_far)
    determinant = c * s - odd * c * math.sin(0.5 * a) - even * s * math.cos(0.5 * a)
    return determinant / (kappa - a)


@kernel
def buckling_tension(moment):
    """T1: the largest tension under which the clamped straight rod of this M3 buckles."""
    a = 0.5 * abs(moment)
    # κ is between π and 2π, the least root
    low, step = 2.8, 0.1
    before = _buckling(a, low)
    high = low + step
    while high < 6.5 and before * _buckling(a, high) > 0.0:
        low, high = high, high + step
    for _ in range(60):
        middle = 0.5 * (low + high)
        if before * _buckling(a, middle) > 0.0:
            low = middle
        else:
            high = middle
    return a * a - 0.25 * (low + high) ** 2


@kernel
def _at_shortening(shortening, moment, tilt_0, tilt_1):
    """The `Bend` of this shortening whose tension is above that of buckling."""
    limit = buckling_tension(moment)
    unit = 1.0 + abs(limit)
    bend = _bend(limit + _BUCKLED * unit, moment, tilt_0, tilt_1)
    if not _shortening(bend, 1.0) > shortening:
        tilt_1 = tilt_1 + _CHOICE * math.sqrt(shortening)
    # the tension above the limit, by its logarithm
    low, high = math.log(_BUCKLED * unit), 46.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        bend = _bend(limit + math.exp(middle), moment, tilt_0, tilt_1)
        if _shortening(bend, 1.0) > shortening:
            low = middle
        else:
            high = middle
    return bend


@kernel
def _tilt(psi, theta):
    return complex(theta * math.cos(psi), theta * math.sin(psi))


@kernel
def _solve(problem, turns, q):
    """The `Bend` of a clamping, seen from the chord frame ``q`` (4,), which is filled.

    Its tension is infinite where the rod is not nearly straight.
    """
    position = problem.position
    length = 1.0 - problem.shortening
    align(position[0] / length, position[1] / length, position[2] / length, q)
    p = np.empty(4)
    relative(q, problem.quaternion, p)
    psi_0, theta_0, _ = zyz_angles(q[0], -q[1], -q[2], -q[3])
    psi_1, theta_1, _ = zyz_angles(p[0], p[1], p[2], p[3])
    tilt_0, tilt_1 = _tilt(psi_0, theta_0), _tilt(psi_1, theta_1)
    if not (problem.shortening < _SHORTENED and max(theta_0, theta_1) < _TILTED):
        zero = complex(0.0)
        return Bend(math.inf, 0.0, zero, zero, zero, zero, zero)
    if problem.free_spin:
        return _at_shortening(problem.shortening, 0.0, tilt_0, tilt_1)
    turned = end_turn(problem.quaternion, q) + 2.0 * math.pi * turns
    moment = problem.torsion_ratio * turned
    for _ in range(20):
        bend = _at_shortening(problem.shortening, moment, tilt_0, tilt_1)
        if moment == 0.0:
            break
        # the area grows with the moment
        before, area = moment, _area(bend, 1.0)
        moment = turned / (1.0 / problem.torsion_ratio + area / moment)
        if abs(moment - before) < 1e-6 * abs(moment):
            break
    return bend


@kernel
def bend_energy(problem, turns, load):
    """Energy of the nearly straight rod with whole ``turns`` more; ``load`` (6,) is F and M0.

    Infinite where the rod is not nearly straight, or so tense that its ends are boundary layers
    that nodes do not hold.
    """
    q = np.empty(4)
    bend = _solve(problem, turns, q)
    if not _growth(bend) < _TENSE:
        return math.inf
    _loads(bend, q, load)
    return _energy(bend, problem.torsion_ratio)


@kernel
def _growth(bend):
    """√(T − m²/4), at which a tense rod forgets its ends; 0 for one that oscillates."""
    return math.sqrt(max(bend.tension - 0.25 * bend.moment**2, 0.0))


@kernel
def bend_loads(problem, turns, load):
    """The ``load`` (6,) of the rod of `bend_energy`; returns √(T − m²/4), or 0."""
    q = np.empty(4)
    bend = _solve(problem, turns, q)
    _loads(bend, q, load)
    return _growth(bend)


@kernel
def _loads(bend, q, load):
    """F and M0 (6,) in the start frame: M = t × t' + m t, (t × t')x + i (t × t')y = iθ'."""
    axes = matrix_from_quaternion(q)
    force = bend.tension * bend.c
    theta = _tangent(bend, 0.0)
    slope = bend.a * bend.first + bend.b * bend.second * cmath.exp(-bend.second)
    moment = 1j * slope + bend.moment * theta
    along = bend.moment + (theta.conjugate() * slope).imag
    for c in range(3):
        load[c] = force.real * axes[c, 0] + force.imag * axes[c, 1] + bend.tension * axes[c, 2]
        load[3 + c] = moment.real * axes[c, 0] + moment.imag * axes[c, 1] + along * axes[c, 2]


@kernel
def bend_nodes(problem, turns, nodes):
    """Poses of the rod of `bend_energy` at graded nodes, as if K30 were 1."""
    q, p = np.empty(4), np.empty(4)
    bend = _solve(problem, turns, q)
    axes = matrix_from_quaternion(q)
    s, pose = nodes.s, nodes.pose
    graded_nodes(_growth(bend), s)
    psi, _, phi = zyz_angles(q[0], -q[1], -q[2], -q[3])
    last = s.shape[0] - 1
    for i in range(last + 1):
        part, theta = _partial(bend, s[i]), _tangent(bend, s[i])
        if i == last:
            # that of the clamping, which a tilt may have been added to
            relative(q, problem.quaternion, p)
            psi_1, theta_1, _ = zyz_angles(p[0], p[1], p[2], p[3])
            theta = _tilt(psi_1, theta_1)
        across = bend.c * s[i] + part.a + part.b
        z = s[i] - _shortening(bend, s[i])
        for c in range(3):
            pose[i, c] = across.real * axes[c, 0] + across.imag * axes[c, 1] + z * axes[c, 2]
        copy(q, p)
        turn(p, -theta.imag, theta.real, 0.0)
        spin(p, psi + phi + bend.moment * s[i] + _area(bend, s[i]))
        copy(p, pose[i, 3:])
    for c in range(3):
        pose[0, c], pose[last, c] = 0.0, problem.position[c]
    pose[0, 3] = 1.0
    for c in range(4, 7):
        pose[0, c] = 0.0
