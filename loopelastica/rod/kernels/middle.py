"""The rod from its loads in the middle, shot both ways.

Unknown are g = (F, M) at s = ½ in the frame there. An error of the loads grows by exp(½√F) to
either end instead of exp(√F) from one to the other: rods under tension with loops between their
ends, which no shot from the start comes near, are found from here.

With both ends' poses (r₀, R₀), (r₁, R₁) in the middle's frame and their variations (``shooting``),
the end in the start frame is p = R₀ᵀ(r₁ − r₀), R = R₀ᵀR₁, and

    δp = R₀ᵀ(δr₁ − δr₀ − δθ₀ × (r₁ − r₀)),      δθ = R₀ᵀ(δθ₁ − δθ₀).

The extra spin of K30 ≠ 1 is none in the middle, half of it at either end.

What is found on a coarse mesh is entered into a `Catch`; ``settle`` makes solutions of it.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.newton import end_error, marquardt_step, predicted_decrease, squares
from loopelastica.rod.kernels.rotations import (
    matrix_from_quaternion,
    product,
    spin,
    tangent,
)
from loopelastica.rod.kernels.shooting import (
    POSE,
    WITH_JACOBIAN,
    march,
    moment_bound,
    start,
)

# steps per radian of the fastest turning
DENSITY = 0.6
# largest rate of turning that is followed
MAX_RATE = 45.0
# end error of an arrival on the coarse mesh, and how far loads of one rod may then be apart
_ARRIVED, _SAME = 1e-6, 1e-4
# squared error, and distance of loads, at which a step is on its way to a rod that is known
_CLOSE, _SURE = 1e-5, 2e-3
_MOST = 60


class Shot(NamedTuple):
    """Room for a shot from the middle."""

    y: Array
    """(43,): the end's pose in the start frame and its variations by the loads."""
    begun: Array
    """(43,): the start in the middle's frame."""
    k: Array
    z: Array


@kernel
def new_shot():
    """Room for a shot."""
    return Shot(
        np.empty(WITH_JACOBIAN),
        np.empty(WITH_JACOBIAN),
        np.empty(12 * WITH_JACOBIAN),
        np.empty(WITH_JACOBIAN),
    )


@kernel
def _spun(y, excess):
    """Turn the frame of a state about its tangent by ``excess``·M3, the variations too."""
    spin(y[3:POSE], excess[0])
    tx, ty, tz = tangent(y[3:POSE])
    y[12] += tx * excess[1]
    y[18] += ty * excess[1]
    y[24] += tz * excess[1]


@kernel
def shoot_middle(g, torsion_ratio, density, size, shot):
    """The end in the start frame into ``shot.y``, with its variations by ``g`` (6,) if ``size``.

    ``size`` is that of ``shooting.march``. Returns F·(r₁ − r₀).
    """
    y, begun = shot.y, shot.begun
    n = 1 + int(0.5 * density * moment_bound(g))
    start(begun)
    march(g, begun, -0.5, n, size, shot.k, shot.z)
    start(y)
    march(g, y, 0.5, n, size, shot.k, shot.z)
    excess = 0.5 * (1.0 / torsion_ratio - 1.0)
    if excess != 0.0:
        rates = np.empty(2)
        rates[0], rates[1] = excess * g[5], excess
        _spun(y, rates)
        rates[0], rates[1] = -excess * g[5], -excess
        _spun(begun, rates)
    m = matrix_from_quaternion(begun[3:POSE])
    dx, dy, dz = y[0] - begun[0], y[1] - begun[1], y[2] - begun[2]
    for j in range(6 if size == WITH_JACOBIAN else 0):
        ax, ay, az = begun[7 + j], begun[13 + j], begun[19 + j]
        tx, ty, tz = y[7 + j] - ax, y[13 + j] - ay, y[19 + j] - az
        rx = y[25 + j] - begun[25 + j] - (ay * dz - az * dy)
        ry = y[31 + j] - begun[31 + j] - (az * dx - ax * dz)
        rz = y[37 + j] - begun[37 + j] - (ax * dy - ay * dx)
        for r in range(3):
            y[7 + 6 * r + j] = m[0, r] * tx + m[1, r] * ty + m[2, r] * tz
            y[25 + 6 * r + j] = m[0, r] * rx + m[1, r] * ry + m[2, r] * rz
    for r in range(3):
        y[r] = m[0, r] * dx + m[1, r] * dy + m[2, r] * dz
    y[3], y[4], y[5], y[6] = product(
        begun[3], -begun[4], -begun[5], -begun[6], y[3], y[4], y[5], y[6]
    )
    return g[0] * dx + g[1] * dy + g[2] * dz


@kernel
def energy_of(g, torsion_ratio, work):
    """Energy of the rod with loads ``g`` whose ends' distance does the ``work`` F·(r₁ − r₀)."""
    squares = g[3] * g[3] + g[4] * g[4] + g[5] * g[5]
    return 0.5 * squares + g[2] - work + 0.5 * g[5] * g[5] * (1.0 / torsion_ratio - 1.0)


@kernel
def load_scales(g, scale):
    """Natural units of force and moment, (6,)."""
    force = max(20.0, math.sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]))
    moment = 2.0 * math.sqrt(force)
    for c in range(3):
        scale[c] = force
        scale[3 + c] = moment


class Catch(NamedTuple):
    """Rods found, by their loads in the middle."""

    loads: Array
    """(m, 6): room for m."""
    keys: Array
    """(m, 6): what tells them apart."""
    energies: Array
    """(m,)."""
    hits: Any
    """(m,): how many starts arrived at each."""
    count: Any
    """(1,): how many there are."""
    symmetry: int
    """Motions that keep both clamps: 0 none, 1 turns about a line, 2 the rod's shift as well."""


@kernel
def _key(g, symmetry, key):
    """What tells rods apart, into ``key`` (6,), in units of 1: their loads.

    |F| is told by its logarithm: k equal waves are one wave shrunk, with the same ratios of loads.
    Turns about the line of the ends turn the loads about the middle's tangent. A rod that is also
    shifted along itself is told by |F|, F·M, M3 and h = ½|M|² + F·d3.
    """
    force = max(20.0, math.sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]))
    moment = 2.0 * math.sqrt(force)
    growth = 1.0 + math.log(force / 20.0)
    if symmetry == 2:
        size = g[0] * g[0] + g[1] * g[1] + g[2] * g[2]
        key[0] = math.sqrt(size) / force * growth
        key[1] = (g[0] * g[3] + g[1] * g[4] + g[2] * g[5]) / (force * moment)
        key[2] = g[5] / moment
        key[3] = (0.5 * (g[3] * g[3] + g[4] * g[4] + g[5] * g[5]) + g[2]) / force
        key[4] = key[5] = 0.0
        return
    for c in range(3):
        key[c] = g[c] / force * growth
        key[3 + c] = g[3 + c] / moment
    if symmetry == 1:
        # turned to where the larger of both is along d1
        i = 0 if key[0] * key[0] + key[1] * key[1] > key[3] * key[3] + key[4] * key[4] else 3
        size = max(math.sqrt(key[i] * key[i] + key[i + 1] * key[i + 1]), 1e-300)
        c, s = key[i] / size, key[i + 1] / size
        for o in (0, 3):
            x, y = key[o], key[o + 1]
            key[o], key[o + 1] = c * x + s * y, c * y - s * x


@kernel
def find(g, catch, within):
    """Which rod of the catch has the loads ``g``, or −1."""
    key = np.empty(6)
    _key(g, catch.symmetry, key)
    for j in range(catch.count[0]):
        apart = 0.0
        for c in range(6):
            apart = max(apart, abs(key[c] - catch.keys[j, c]))
        if apart < within:
            return j
    return -1


@kernel
def enter(g, energy, catch):
    """Enter a rod, or count it as a hit. Returns its place, −1 where there is no room."""
    j = find(g, catch, _SAME)
    if j >= 0:
        catch.hits[j] += 1
        return j
    j = catch.count[0]
    if j == catch.loads.shape[0]:
        return -1
    for c in range(6):
        catch.loads[j, c] = g[c]
    _key(g, catch.symmetry, catch.keys[j])
    catch.energies[j], catch.hits[j] = energy, 1
    catch.count[0] = j + 1
    return j


@kernel
def drive(problem, g, most, catch, shot):
    """Drive the loads ``g`` in the middle to the problem's clamping, in place.

    Levenberg's and Marquardt's steps: ``most`` of them, and more as long as each halves the error.
    They end where they come near to a rod of the ``catch``. Returns the end error on this coarse
    mesh, the energy, and the place of the rod that was come to, or −1.
    """
    e, jacobian, scale = np.empty(6), np.empty((6, 6)), np.empty(6)
    trial, trial_e, trial_jacobian = np.empty(6), np.empty(6), np.empty((6, 6))
    a, d = np.empty((6, 6)), np.empty(6)
    ratio = problem.torsion_ratio
    if problem.free_spin:
        g[5] = 0.0
    if not moment_bound(g) < MAX_RATE:
        return math.inf, math.inf, -1
    work = shoot_middle(g, ratio, DENSITY, WITH_JACOBIAN, shot)
    end_error(problem, shot.y, g[5], e, jacobian, True)
    nu, growth = 1e-3, 2.0
    cost, before = squares(e), math.inf
    iteration = 0
    while (iteration < most or cost < 0.25 * before) and iteration < _MOST:
        if cost < 1e-14:
            break
        if cost < _CLOSE:
            known = find(g, catch, _SURE)
            if known >= 0:
                return math.sqrt(cost), math.inf, known
        iteration += 1
        before = cost
        load_scales(g, scale)
        gain, new_cost, new_work = -1.0, math.inf, 0.0
        if marquardt_step(jacobian, e, scale, nu, a, d):
            predicted = predicted_decrease(jacobian, e, d)
            for c in range(6):
                trial[c] = g[c] + d[c]
            if problem.free_spin:
                trial[5] = 0.0
            if moment_bound(trial) < MAX_RATE:
                new_work = shoot_middle(trial, ratio, DENSITY, WITH_JACOBIAN, shot)
                end_error(problem, shot.y, trial[5], trial_e, trial_jacobian, True)
                new_cost = squares(trial_e)
                gain = (cost - new_cost) / max(predicted, 1e-300)
        if gain > 1e-4:
            slowed = cost - new_cost < 1e-3 * cost and new_cost > 1e-4
            for c in range(6):
                g[c], e[c] = trial[c], trial_e[c]
                for j in range(6):
                    jacobian[c, j] = trial_jacobian[c, j]
            cost, work = new_cost, new_work
            nu *= max(0.1, 1.0 - (2.0 * gain - 1.0) ** 3)
            growth = 2.0
            if slowed and nu > 1e-2:
                break
            continue
        nu *= growth
        growth *= 2.0
        if nu > 1e6:
            break
    return math.sqrt(cost), energy_of(g, ratio, work), -1


@kernel
def arrive(problem, g, most, catch, shot):
    """Newton's method from the loads ``g``, in place, to a place in the catch, or −1."""
    error, energy, known = drive(problem, g, most, catch, shot)
    if known >= 0:
        catch.hits[known] += 1
        return known
    return enter(g, energy, catch) if error < _ARRIVED else -1


@kernel
def harvest(problem, guesses, most, catch):
    """Newton's method from each of ``guesses`` (n, 6). Returns how many arrived."""
    shot, g, arrived = new_shot(), np.empty(6), 0
    for i in range(guesses.shape[0]):
        for c in range(6):
            g[c] = guesses[i, c]
        if arrive(problem, g, most, catch, shot) >= 0:
            arrived += 1
    return arrived


@kernel
def ends_from_middle(loads, torsion_ratio, density, positions, quaternions, energies):
    """End poses (n, 3), (n, 4) and energies (n,) of rods with ``loads`` (n, 6) in the middle."""
    shot = new_shot()
    for i in range(loads.shape[0]):
        work = shoot_middle(loads[i], torsion_ratio, density, POSE, shot)
        energies[i] = energy_of(loads[i], torsion_ratio, work)
        for c in range(3):
            positions[i, c] = shot.y[c]
        for c in range(4):
            quaternions[i, c] = shot.y[3 + c]
