"""The elastic chain: a discrete rod with a rest shape, its energy and exact derivatives.

m rigid segments with vectors v_k at rest turn by R_k; at rest all R_k are 1. Hinge j between
R_j−1 and R_j turns by ω = log(R_j−1ᵀ R_j) and stores ω·K_j·ω/2, where K_j is ``torsion`` along an
axis of the hinge and ``bending`` across. The clamps stand for R_−1 = 1 and R_m = R E₀ᵀ: R is the
end frame, E₀ that of the rest shape. The constraint is Σ R_k v_k = r. A free end spin turns R
about its d3, R_m about E₀ e3.

Lengths are in units of Σ |v_k|. All derivatives are those of ``discrete_rod``, of which this is
the general case.
"""

import math
from typing import NamedTuple

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.kernels.discrete_rod import (
    add_hinge,
    add_segment,
    clear,
    hinge_length,
    keep_spin,
)
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.records import Status
from loopelastica.rod.kernels.rotations import (
    directors,
    exponential,
    logarithm,
    product,
    tangent,
)

# neighbours whose directions add to less than this point against each other
_OPPOSITE = 1e-6
# ends further apart than the chain is long by less than this are rounding
REACH = 1e-9
# turn whose moment in the stiffest hinge counts as a load, rad
_ROUNDED = 1e-5

_CONVERGED, _UNREACHABLE = int(Status.CONVERGED), int(Status.UNREACHABLE)
_BAD_INPUT = int(Status.BAD_INPUT)


class ElasticChain(NamedTuple):
    """A chain of m segments."""

    s: Array
    """(m + 1,): arc lengths of the hinges at rest, from 0 to 1."""
    frames: Array
    """(m + 2, 4): the start clamp, 1; R_k; the end frame R."""
    steps: Array
    """(m, 3): v_k."""
    end: Array
    """(4,): E₀."""
    axes: Array
    """(m + 1, 3): axis of torsion of each hinge, a unit vector."""
    bending: Array
    """(m + 1,)."""
    torsion: Array
    """(m + 1,)."""


@kernel
def new_chain(m):
    """Room for a chain of ``m`` segments."""
    return ElasticChain(
        np.zeros(m + 1),
        np.zeros((m + 2, 4)),
        np.zeros((m, 3)),
        np.zeros(4),
        np.zeros((m + 1, 3)),
        np.zeros(m + 1),
        np.zeros(m + 1),
    )


@kernel
def at_other_frames(chain):
    """The same chain with frames of its own."""
    return ElasticChain(
        chain.s, np.zeros(chain.frames.shape), chain.steps, chain.end, chain.axes, chain.bending,
        chain.torsion,
    )  # fmt: skip


@kernel
def set_shape(chain, steps, end, stiffness, torsion_ratio):
    """Fill all but the frames, from a rest shape in any unit.

    ``steps`` (m, 3) and the quaternion ``end`` (4,); ``stiffness`` (m + 1,) multiplies that of an
    ideal rod, 1 over half of either neighbouring segment. Returns the length in that unit and the
    geometric mean of ``stiffness``, which is the chain's unit of it.
    """
    m, length, unit = steps.shape[0], 0.0, 0.0
    for j in range(m + 1):
        unit += math.log(stiffness[j]) / (m + 1)
    unit = math.exp(unit)
    for k in range(m):
        length += _size(steps[k])
    for c in range(4):
        chain.end[c] = end[c]
    chain.s[0] = 0.0
    for k in range(m):
        for i in range(3):
            chain.steps[k, i] = steps[k, i] / length
        chain.s[k + 1] = chain.s[k] + _size(chain.steps[k])
    for j in range(m + 1):
        before, after = max(j - 1, 0), min(j, m - 1)
        a, b = _size(steps[before]), _size(steps[after])
        norm = 0.0
        for i in range(3):
            chain.axes[j, i] = steps[before, i] / a + steps[after, i] / b
            norm += chain.axes[j, i] ** 2
        for i in range(3):
            if norm > _OPPOSITE**2:
                chain.axes[j, i] /= math.sqrt(norm)
            else:
                chain.axes[j, i] = steps[before, i] / a
        chain.bending[j] = stiffness[j] / unit / hinge_length(chain.s, j)
        chain.torsion[j] = torsion_ratio * chain.bending[j]
    return length, unit


@kernel
def _size(v):
    return math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])


@kernel
def slack(chain):
    """How much larger moments may miss their balance: rounding of turns in stiff hinges."""
    stiffest = 0.0
    for j in range(chain.bending.shape[0]):
        stiffest = max(stiffest, chain.bending[j], chain.torsion[j])
    return 1.0 + _ROUNDED * stiffest


@kernel
def spread(chain, turns):
    """Set the segments' frames so that the end's turn is spread evenly along the chain.

    ``turns`` whole turns are added to it. Returns its angle without them, from 0 to π.
    """
    s, frames, e = chain.s, chain.frames, chain.end
    m = s.shape[0] - 1
    q = frames[m + 1]
    x, y, z = logarithm(*product(q[0], q[1], q[2], q[3], e[0], -e[1], -e[2], -e[3]))
    angle = math.sqrt(x * x + y * y + z * z)
    factor = 1.0 + 2.0 * math.pi * turns / angle if angle > 0.0 else 1.0
    for k in range(m):
        at = 0.5 * factor * (s[k] + s[k + 1])
        r = frames[k + 1]
        r[0], r[1], r[2], r[3] = exponential(at * x, at * y, at * z)
    return angle


@kernel
def measure_chain(chain, position, omega, c):
    """Energy of all hinges; ``omega`` (m + 1, 3) and the constraint ``c`` (3,) on the way."""
    frames, e, energy = chain.frames, chain.end, 0.0
    m = chain.s.shape[0] - 1
    c[0], c[1], c[2] = -position[0], -position[1], -position[2]
    for j in range(m + 1):
        p, q = frames[j], frames[j + 1]
        w, x, y, z = product(p[0], -p[1], -p[2], -p[3], q[0], q[1], q[2], q[3])
        if j == m:
            w, x, y, z = product(w, x, y, z, e[0], -e[1], -e[2], -e[3])
        x, y, z = logarithm(w, x, y, z)
        omega[j, 0], omega[j, 1], omega[j, 2] = x, y, z
        along = x * chain.axes[j, 0] + y * chain.axes[j, 1] + z * chain.axes[j, 2]
        across = x * x + y * y + z * z - along * along
        energy += 0.5 * (chain.bending[j] * across + chain.torsion[j] * along * along)
        if j < m:
            v = chain.steps[j]
            d1x, d1y, d1z, d2x, d2y, d2z, d3x, d3y, d3z = directors(q)
            c[0] += d1x * v[0] + d2x * v[1] + d3x * v[2]
            c[1] += d1y * v[0] + d2y * v[1] + d3y * v[2]
            c[2] += d1z * v[0] + d2z * v[1] + d3z * v[2]
    return energy


@kernel
def assemble_chain(chain, force, hessian):
    """Fill ``hessian`` at a chain whose ``omega`` are there already, with ``force`` (3,)."""
    axes, steps = chain.axes, chain.steps
    m = steps.shape[0]
    clear(hessian)
    for j in range(m + 1):
        add_hinge(
            hessian, j, chain.bending[j], chain.torsion[j], axes[j, 0], axes[j, 1], axes[j, 2]
        )
    if hessian.gradient.shape[0] > m:
        tx, ty, tz = tangent(chain.end)
        keep_spin(hessian, tx, ty, tz)
    for k in range(m):
        v = steps[k]
        add_segment(hessian, k, chain.frames[k + 1], v[0], v[1], v[2], force)


@kernel
def fault(steps, end, position, rotation, stiffness):
    """`BAD_INPUT` or `UNREACHABLE` if no chain can be so, else `CONVERGED`."""
    length, longest, distance, sound = 0.0, 0.0, 0.0, True
    for k in range(steps.shape[0]):
        size = math.sqrt(steps[k, 0] ** 2 + steps[k, 1] ** 2 + steps[k, 2] ** 2)
        # not finite is not between
        sound = sound and 1e-100 < size < 1e100
        length += size
        longest = max(longest, size)
        sound = sound and 1e-100 < stiffness[k] < 1e100
    sound = sound and 1e-100 < stiffness[steps.shape[0]] < 1e100
    for i in range(3):
        distance += position[i] ** 2
        for j in range(3):
            one, other = 1.0 if i == j else 0.0, 1.0 if i == j else 0.0
            for k in range(3):
                one -= end[k, i] * end[k, j]
                other -= rotation[k, i] * rotation[k, j]
            sound = sound and abs(one) < 1e-4 and abs(other) < 1e-4
    if not (sound and distance < math.inf and _right_handed(end) and _right_handed(rotation)):
        return _BAD_INPUT
    distance = math.sqrt(distance)
    # neither further than all steps reach, nor nearer than the longest lets come
    margin = REACH * length
    if distance > length + margin or distance < 2.0 * longest - length - margin:
        return _UNREACHABLE
    return _CONVERGED


@kernel
def _right_handed(r):
    minor_0 = r[1, 1] * r[2, 2] - r[1, 2] * r[2, 1]
    minor_1 = r[1, 0] * r[2, 2] - r[1, 2] * r[2, 0]
    minor_2 = r[1, 0] * r[2, 1] - r[1, 1] * r[2, 0]
    return r[0, 0] * minor_0 - r[0, 1] * minor_1 + r[0, 2] * minor_2 > 0.0
