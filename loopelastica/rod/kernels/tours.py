"""Tours: equilibria met while the end of a rod is turned all the way round.

Every equilibrium lies on a curve of rods whose end is turned about an axis ω fixed in its frame,

    r(L) = p,      R(L) = R exp(t [ω]),

and wherever t comes back to a multiple of 2π the clamping is the one that it was, though the rod
need not be. Curves are followed by pseudo-arclength in the loads and t, through their folds (see
``arclength``, which confirms every point; here only where a curve leads matters, so that one coarse
shot from the middle will do, ``middle``). What they meet is entered as a start for Newton's method.

K30 never changes the center line of given loads at the start. A turn about the tangent (ω = d3) is
therefore followed at K30 = 1, and what has to come back is t + M3 (1/K30 − 1); with a free end spin
it is M3 = 0. The middle's frame then lacks half of the extra spin, ½ M3 (1/K30 − 1).
"""

import math
from typing import NamedTuple

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.kernels.arclength import Motion, moving_clamp
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.linalg import solve_deficient
from loopelastica.rod.kernels.middle import (
    DENSITY,
    MAX_RATE,
    arrive,
    energy_of,
    find,
    load_scales,
    new_shot,
    shoot_middle,
)
from loopelastica.rod.kernels.newton import end_error, largest
from loopelastica.rod.kernels.records import Problem
from loopelastica.rod.kernels.rotations import spin_between
from loopelastica.rod.kernels.shooting import POSE, WITH_JACOBIAN, moment_bound

_DROP = 1e-9
# step of the difference quotient by t
_H = 1e-4
_FIRST, _LEAST = 0.15, 2e-4
_CORRECTIONS, _FEW, _MANY = 5, 2, 3
_NEAR, _SMALL = 2e-3, 0.02
# Newton steps from what is met; how near it is to a rod that is known, and to where it began
_PATIENCE, _MET, _BACK = 10, 3e-3, 0.03
# how a curve ended
USED_UP, LOST, LEFT, CLOSED = range(4)


class Tour(NamedTuple):
    """How a curve is followed."""

    axis: Array
    """ω (3,), of length 1."""
    about_tangent: bool
    shift: Array
    """What the position moves by per t, (3,); then the end is not turned, and t goes to 1."""
    energy_max: float
    """Where a curve is left."""
    most: int
    """Steps at most."""
    longest: float
    agree: float


@kernel
def _shifted(tour):
    """Whether the end is shifted, not turned."""
    return tour.shift[0] != 0.0 or tour.shift[1] != 0.0 or tour.shift[2] != 0.0


@kernel
def _evaluate(motion, path, u, shot, e, jacobian, by_t):
    """Error and derivatives at ``u`` (7,); returns the work. ``path`` is the problem there."""
    q, p = path.quaternion, path.position
    work = shoot_middle(u, path.torsion_ratio, DENSITY, WITH_JACOBIAN, shot)
    moving_clamp(motion, u[6] + _H, q, p)
    end_error(path, shot.y, u[5], by_t, jacobian, False)
    moving_clamp(motion, u[6] - _H, q, p)
    end_error(path, shot.y, u[5], e, jacobian, False)
    for c in range(6):
        by_t[c] = (by_t[c] - e[c]) / (2.0 * _H)
    moving_clamp(motion, u[6], q, p)
    end_error(path, shot.y, u[5], e, jacobian, True)
    return work


@kernel
def _event(problem, tour, u):
    """What is a whole number (or, with a free spin, zero) wherever the clamping is back."""
    if tour.about_tangent:
        if problem.free_spin:
            return u[5]
        return (u[6] + u[5] * (1.0 / problem.torsion_ratio - 1.0)) / (2.0 * math.pi)
    return u[6] if _shifted(tour) else u[6] / (2.0 * math.pi)


@kernel
def _own_spin(problem, g, shot):
    """Turn of a rod's end (K30 = 1) against the clamp about their common tangent."""
    shoot_middle(g, 1.0, DENSITY, POSE, shot)
    return spin_between(problem.quaternion, shot.y[3:7])


@kernel
def _turned(g, angle):
    """Turn loads in the middle about d3, in place."""
    c, s = math.cos(angle), math.sin(angle)
    for o in (0, 3):
        x, y = g[o], g[o + 1]
        g[o], g[o + 1] = c * x - s * y, s * x + c * y


@kernel
def follow(problem, tour, start, sign, met, counts):
    """Follow the curve through a rod one way, until it closes or leaves the energies of interest.

    Parameters
    ----------
    start : (6,)
        Loads in the middle.
    sign : float
        Which way t goes at first.
    met : (n, 6)
        Loads of rods met, near enough for Newton's method.
    counts : (3,)
        Shots, steps and how it ended (0 steps used up, 1 lost, 2 energy, 3 closed).

    Returns
    -------
    int
        How many were met.
    """
    shot = new_shot()
    e, jacobian, by_t = np.empty(6), np.empty((6, 6)), np.empty(6)
    u, trial, scale, n, first = np.empty(7), np.empty(7), np.empty(7), np.zeros(7), np.empty(7)
    new_scale = np.empty(7)
    a, x = np.empty((7, 9)), np.empty((2, 7))
    ratio = 1.0 if tour.about_tangent else problem.torsion_ratio
    free = problem.free_spin and not tour.about_tangent
    path = Problem(np.empty(3), np.empty(4), problem.shortening, ratio, free, problem.tolerance)
    motion = Motion(problem.position, problem.quaternion, tour.shift, tour.axis, ratio, free)
    for c in range(6):
        u[c] = start[c]
    u[6], excess = 0.0, 0.0
    if tour.about_tangent:
        if problem.free_spin:
            u[6] = _own_spin(problem, start, shot)
        else:
            excess = 1.0 / problem.torsion_ratio - 1.0
            u[6] = -excess * start[5]
            _turned(u, 0.5 * excess * u[5])
    for c in range(7):
        first[c] = u[c]
    load_scales(u, scale)
    scale[6] = 1.0
    n[6] = sign
    found, ds, event = 0, 0.0, _event(problem, tour, u)
    own, leaving = event, True
    counts[0] = counts[1] = 0
    counts[2] = USED_UP
    while counts[1] < tour.most:
        counts[1] += 1
        begin = counts[1] == 1
        for c in range(7):
            trial[c] = u[c] + ds * n[c] * scale[c]
        good, iterations, previous, work = False, 0, math.inf, 0.0
        while iterations < _CORRECTIONS and moment_bound(trial) < MAX_RATE:
            work = _evaluate(motion, path, trial, shot, e, jacobian, by_t)
            iterations += 1
            counts[0] += 1
            worst = largest(e)
            if not worst < 1.5 or worst > previous:
                break
            previous = worst
            for r in range(6):
                for c in range(6):
                    a[r, c] = jacobian[r, c] * scale[c]
                a[r, 6], a[r, 7], a[r, 8] = by_t[r], -e[r], 0.0
            for c in range(7):
                a[6, c] = n[c]
            a[6, 7], a[6, 8] = 0.0, 1.0
            solve_deficient(a, 7, 7, 2, _DROP, x)
            size = 0.0
            for c in range(7):
                trial[c] += x[0, c] * scale[c]
                size = max(size, abs(x[0, c]))
            if worst < _NEAR and size < _SMALL:
                good = True
                break
        norm, cosine = 0.0, 0.0
        if good:
            for c in range(7):
                norm += x[1, c] * x[1, c]
                cosine += x[1, c] * n[c]
            norm = math.sqrt(norm)
            cosine /= norm
        if not good or (not begin and cosine < tour.agree):
            ds *= 0.4
            if ds < _LEAST:
                counts[2] = LOST
                break
            continue
        before, closed = event, False
        event = _event(problem, tour, trial)
        if not begin:
            crossings = 0
            if tour.about_tangent and problem.free_spin:
                low, crossings = 0.0, 1 if before * event < 0.0 else 0
            else:
                low = math.floor(min(before, event)) + 1.0
                crossings = int(math.floor(max(before, event)) - low + 1.0)
            for i in range(crossings):
                # a soft twist comes by without end
                if found == met.shape[0]:
                    break
                # the first step leaves the start's own event behind
                if leaving and abs(low + i - own) < 0.5:
                    continue
                share = (low + i - before) / (event - before)
                apart = 0.0
                for c in range(6):
                    met[found, c] = u[c] + share * (trial[c] - u[c])
                    apart = max(apart, abs(met[found, c] - first[c]) / scale[c])
                _turned(met[found], -0.5 * excess * met[found, 5])
                found += 1
                closed = closed or apart < _BACK
            leaving = False
        for c in range(7):
            u[c] = trial[c]
        # the tangent in the units of the new point
        load_scales(u, new_scale)
        new_scale[6] = 1.0
        norm = 0.0
        for c in range(7):
            n[c] = x[1, c] * scale[c] / new_scale[c]
            norm += n[c] * n[c]
            scale[c] = new_scale[c]
        for c in range(7):
            n[c] /= math.sqrt(norm)
        if begin:
            ds = _FIRST
            continue
        if iterations <= _FEW:
            ds = min(1.6 * ds, tour.longest)
        elif iterations > _MANY:
            ds *= 0.6
        if closed or (_shifted(tour) and not 0.0 <= u[6] < 1.0):
            counts[2] = CLOSED
            break
        if energy_of(u, ratio, work) > tour.energy_max:
            counts[2] = LEFT
            break
    return found


@kernel
def visit(problem, tour, energy_max, catch, walked, most, ended):
    """Tours from rods of a catch that none has come through, those met on the way included.

    Parameters
    ----------
    energy_max : float
        Rods above it are not left from.
    walked : (m,) of bool
        Through which rods a tour about this axis has come.
    most : int
        How many rods are left from at most.
    ended : (4,)
        Counted up: curves whose steps were used up, that were lost, that left the energies of
        interest, that closed.

    Returns
    -------
    int
        From how many rods tours were made; fewer than ``most`` if none is left.
    """
    shot, met, counts, g = new_shot(), np.empty((64, 6)), np.zeros(3, np.int64), np.empty(6)
    i, left = 0, 0
    while i < catch.count[0] and left < most:
        if walked[i] or catch.energies[i] > energy_max:
            i += 1
            continue
        walked[i] = True
        left += 1
        for sign in (1.0, -1.0):
            n = follow(problem, tour, catch.loads[i], sign, met, counts)
            ended[counts[2]] += 1
            for k in range(n):
                for c in range(6):
                    g[c] = met[k, c]
                j = find(g, catch, _MET)
                if j < 0:
                    j = arrive(problem, g, _PATIENCE, catch, shot)
                if j >= 0:
                    walked[j] = True
            if counts[2] == CLOSED:
                break
    return left


@kernel
def pull(problem, tour, energy_max, catch, goal, caught, ended):
    """From the rods of a ``catch`` to those of a clamping that is shifted against theirs.

    ``goal`` is the problem there, ``caught`` its catch; ``ended`` (4,) counts as for `visit`.
    """
    shot, met, counts, g = new_shot(), np.empty((8, 6)), np.zeros(3, np.int64), np.empty(6)
    for i in range(catch.count[0]):
        if catch.energies[i] > energy_max:
            continue
        n = follow(problem, tour, catch.loads[i], 1.0, met, counts)
        ended[counts[2]] += 1
        for k in range(n):
            for c in range(6):
                g[c] = met[k, c]
            if find(g, caught, _MET) < 0:
                arrive(goal, g, _PATIENCE, caught, shot)
