"""The elastic chain of least energy: Newton's method with a line search, one chain or many.

Each step solves the constrained Newton equations as for the discrete rod (``minimization``), H
shifted until they lead downhill; a line search on energy + μ |constraint|₁ with a second-order
correction makes it robust. Near a solution steps are whole, H is not shifted and exact: errors are
squared from step to step.

A chain is first tried from frames given, or with the end's turn spread evenly, a large one both
ways round; where that fails from its rest shape, and bowed; then the end clamp is moved from that
of the rest shape to the one given, in steps that adapt. What arrives is judged by other formulas
(``chain_check``).
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.rod.kernels.chain import (
    ElasticChain,
    assemble_chain,
    at_other_frames,
    fault,
    measure_chain,
    new_chain,
    set_shape,
    slack,
    spread,
)
from loopelastica.rod.kernels.chain_check import judge
from loopelastica.rod.kernels.discrete_rod import Hessian, new_hessian
from loopelastica.rod.kernels.discrete_starts import bow
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.linalg import copy, copy_rows
from loopelastica.rod.kernels.minimization import (
    Step,
    imbalance,
    l1,
    move,
    new_step,
    newton_step,
    times,
)
from loopelastica.rod.kernels.records import Status
from loopelastica.rod.kernels.rotations import (
    directors,
    exponential,
    logarithm,
    multiply,
    product,
    quaternion_from_matrix,
)

_CONVERGED, _STALLED = int(Status.CONVERGED), int(Status.STALLED)
_TOO_MANY, _CHECK_FAILED = int(Status.TOO_MANY_ITERATIONS), int(Status.CHECK_FAILED)
_BAD_INPUT = int(Status.BAD_INPUT)

_ITERATIONS = 150
# largest turn of a segment in one step; turns so small that a step is Newton's own
_STEP, _SMALL = 1.0, 1e-3
# shifts of H: the least; the least that makes a difference
_FLOOR, _SHIFT = 1e-9, 4.0
# curvature that counts as none, as that of a turn about the line of both ends
_FLAT = 1e-6
# |constraint|₁ and imbalance of a solution; what the check lets pass
_CLOSED, _BALANCED, _CONFIRMED = 1e-11, 1e-10, 1e-8
# bend that leaves a saddle, and how many times
_BOW, _BOWS = 0.07, 3
# turn of the end beyond which both ways round are tried, rad
_FAR = 2.0
# attempts where the first fails: the rest shape, bowed by so many rad, the end clamp moved, bowed
_ATTEMPTS, _BY_MOVING, _BEND = 12, 5, 0.8
# first and least part of the way that the end clamp is moved at once; how many moves
_PART, _LEAST, _MOVES = 0.25, 1e-3, 200


class ChainRoom(NamedTuple):
    """Scratch for chains of m segments."""

    chain: ElasticChain
    trial: ElasticChain
    hessian: Hessian
    step: Step
    force: Array
    """(3,): the multiplier, F."""
    trial_c: Array
    """(3,)."""
    correction: Array
    """(3,)."""
    kept: Array
    """(m + 2, 4): frames to go back to."""
    kept_force: Array
    """(3,)."""
    nodes: Array
    """(m + 1, 3): a solution to be judged, as ``rotations`` (m + 1, 3, 3)."""
    rotations: Array
    moment: Array
    """(3,)."""


class ChainRows(NamedTuple):
    """Results of k chains."""

    nodes: Array
    """(k, m + 1, 3) in the unit of the steps."""
    rotations: Array
    """(k, m + 1, 3, 3): turns of the segments, and the end frame."""
    force: Array
    """(k, 3) in K0/L²."""
    moment: Array
    """(k, 3): at the start, in K0/L."""
    energy: Array
    """(k,) in K0/L, as ``residual``; inf where a row failed."""
    residual: Array
    morse_index: NDArray[np.int64]
    """(k,); -1 where a row failed."""
    status: NDArray[np.int64]
    """(k,) of `Status`."""


def new_rows(k: int, m: int) -> ChainRows:
    """Room for the results of ``k`` chains of ``m`` segments."""
    rotations = np.zeros((k, m + 1, 3, 3))
    rotations[:] = np.eye(3)
    return ChainRows(
        np.zeros((k, m + 1, 3)),
        rotations,
        np.zeros((k, 3)),
        np.zeros((k, 3)),
        np.full(k, np.inf),
        np.full(k, np.inf),
        np.full(k, -1, np.int64),
        np.full(k, _BAD_INPUT, np.int64),
    )


@kernel
def new_room(m, free_spin):
    """Scratch for chains of ``m`` segments."""
    chain, hessian = new_chain(m), new_hessian(m, free_spin)
    return ChainRoom(
        chain, at_other_frames(chain), hessian, new_step(hessian.gradient.shape[0]), np.zeros(3),
        np.zeros(3), np.zeros(3), np.zeros((m + 2, 4)), np.zeros(3),
        np.zeros((m + 1, 3)), np.zeros((m + 1, 3, 3)), np.zeros(3),
    )  # fmt: skip


@kernel
def _line_search(room, position, energy, mu, downhill, t):
    """Backtrack along the step on energy + μ |c|₁ (see ``minimization``); the point is ``trial``.

    Returns the fraction taken (0 if none) and the energy.
    """
    chain, trial, step, correction = room.chain, room.trial, room.step, room.correction
    omega, c = room.hessian.omega, room.trial_c
    merit = energy + mu * l1(step.constraint)
    for attempt in range(12):
        enough = merit + 1e-4 * t * downhill + 1e-13 * abs(merit)
        for corrected in range(2 if attempt < 3 else 1):
            if corrected:
                times(step.schur_inverse, c, correction)
                for i in range(3):
                    correction[i] = -correction[i]
            move(chain, step, t, corrected == 1, correction, trial)
            value = measure_chain(trial, position, omega, c)
            if value + mu * l1(c) <= enough:
                return t, value
        t *= 0.4
    return 0.0, energy


@kernel
def minimize_chain(room, position, minimized):
    """Bring ``room.chain`` from its frames and ``room.force`` to an equilibrium.

    With ``minimized`` downhill, and away from saddles; else by Newton's method to any equilibrium.
    Returns (status, energy, Morse index).
    """
    chain, trial, hessian, step, force = room.chain, room.trial, room.hessian, room.step, room.force
    omega, c, multiplier = hessian.omega, step.constraint, step.multiplier
    mu, shift, bows, balanced = 0.0, _FLOOR, 0, _BALANCED * slack(chain)
    energy = measure_chain(chain, position, omega, c)
    for _ in range(_ITERATIONS):
        assemble_chain(chain, force, hessian)
        norm_c = l1(c)
        done = norm_c < _CLOSED and imbalance(hessian, force) < balanced
        once = done or not minimized
        first = _FLAT if done else 0.0 if once else shift
        index, shift, downhill, largest = newton_step(hessian, chain.s, once, first, step)
        if done and (index <= 0 or bows == _BOWS or not minimized):
            return _CONVERGED, energy, max(index, 0)
        largest_force = max(abs(multiplier[0]), abs(multiplier[1]), abs(multiplier[2]))
        # a straight start: the constraint has no slope along the chord
        stuck = not (largest_force < 1e12 and largest < 1e6)
        taken, value = 0.0, energy
        if not done and not stuck:
            t = min(1.0, _STEP / max(largest, 1e-300))
            if not minimized or (largest < _SMALL and index == 0 and shift <= _FLOOR):
                move(chain, step, t, False, room.correction, trial)
                taken, value = t, measure_chain(trial, position, omega, room.trial_c)
            else:
                # a multiplier that was large once must not weigh the constraint for ever
                mu = max(0.5 * mu, 1.1 * largest_force)
                taken, value = _line_search(room, position, energy, mu, downhill - mu * norm_c, t)
            stuck = taken == 0.0
            if taken == t:
                shift = 0.25 * shift if shift > 0.5 * _SHIFT else _FLOOR
        if done or stuck:
            # leave a saddle, or a place from which no direction leads down
            bows += 1
            if bows > _BOWS:
                return _STALLED, math.inf, 0
            bow(chain, _BOW, bows)
            energy = measure_chain(chain, position, omega, c)
            mu, shift = 0.0, _FLOOR
            continue
        energy = value
        for i in range(3):
            force[i] += taken * (multiplier[i] - force[i])
        copy(room.trial_c, c)
        copy_rows(trial.frames, chain.frames)
    return _TOO_MANY, math.inf, 0


@kernel
def _reset(room, q):
    """The rest shape with its end frame at the quaternion ``q``, without a force."""
    frames = room.chain.frames
    m = frames.shape[0] - 2
    for k in range(m + 1):
        frames[k, 0], frames[k, 1], frames[k, 2], frames[k, 3] = 1.0, 0.0, 0.0, 0.0
    copy(q, frames[m + 1])
    for i in range(3):
        room.force[i] = 0.0


@kernel
def _by_moving_the_end(room, position, q):
    """Move the end clamp from where it is at rest to ``position`` and ``q``, step by step.

    Returns (status, energy, Morse index).
    """
    chain, e = room.chain, room.chain.end
    m = chain.steps.shape[0]
    first, here, there = np.zeros(3), np.empty(3), np.empty(4)
    for k in range(m):
        for i in range(3):
            first[i] += chain.steps[k, i]
    # q = E₀ exp(v)
    x, y, z = logarithm(*product(e[0], -e[1], -e[2], -e[3], q[0], q[1], q[2], q[3]))
    _reset(room, e)
    at, part = 0.0, _PART
    for _ in range(_MOVES):
        copy_rows(chain.frames, room.kept)
        copy(room.force, room.kept_force)
        to = min(at + part, 1.0)
        for i in range(3):
            here[i] = first[i] + to * (position[i] - first[i])
        there[0], there[1], there[2], there[3] = exponential(to * x, to * y, to * z)
        multiply(e, there, chain.frames[m + 1])
        status, energy, index = minimize_chain(room, here, True)
        if status == _CONVERGED:
            at, part = to, 1.5 * part
            if at == 1.0:
                return status, energy, index
        else:
            part *= 0.4
            if part < _LEAST:
                break
            copy_rows(room.kept, chain.frames)
            copy(room.kept_force, room.force)
    return _STALLED, math.inf, 0


@kernel
def _deform(room, position, q, guess, minimized):
    """From starts to a solution: (status, energy, Morse index). No guess is one of no rows."""
    frames, angle = room.chain.frames, 0.0
    m = frames.shape[0] - 2
    _reset(room, q)
    if guess.shape[0] == m:
        for k in range(m):
            copy(guess[k], frames[k + 1])
    else:
        angle = spread(room.chain, 0.0)
    status, energy, index = minimize_chain(room, position, minimized)
    if status == _CONVERGED and angle > _FAR:
        # the other way round may be the shorter one
        copy_rows(frames, room.kept)
        copy(room.force, room.kept_force)
        _reset(room, q)
        spread(room.chain, -1.0)
        other, other_energy, other_index = minimize_chain(room, position, minimized)
        if other == _CONVERGED and other_energy < energy:
            return other, other_energy, other_index
        copy_rows(room.kept, frames)
        copy(room.kept_force, room.force)
    if status == _CONVERGED or not minimized:
        return status, energy, index
    for attempt in range(_ATTEMPTS):
        if attempt == _BY_MOVING:
            status, energy, index = _by_moving_the_end(room, position, q)
        else:
            _reset(room, q)
            if attempt > 0:
                spread(room.chain, 0.0)
                bow(room.chain, _BEND if attempt % 2 else -_BEND, attempt)
            status, energy, index = minimize_chain(room, position, True)
        if status == _CONVERGED:
            break
    return status, energy, index


@kernel
def deform_rows(
    steps, ends, stiffness, positions, rotations, torsion_ratio, free_spin, guesses, minimized, rows
):
    """Deform shapes to clamped ends, row by row; one shape or one end goes with all rows.

    ``steps`` (., m, 3), ``ends`` (., 3, 3) and ``stiffness`` (., m + 1) are the shapes,
    ``positions`` (., 3) in the unit of the steps and ``rotations`` (., 3, 3) the ends, ``guesses``
    (., m or 0, 4) quaternions of the segments to begin with. The results go into ``rows``.
    """
    m = steps.shape[1]
    room, position = new_room(m, free_spin), np.empty(3)
    chain = room.chain
    for row in range(rows.status.shape[0]):
        shape, factors = _one_of(steps, row), _one_of(stiffness, row)
        end, place, frame = _one_of(ends, row), _one_of(positions, row), _one_of(rotations, row)
        rows.status[row] = fault(shape, end, place, frame, factors)
        if rows.status[row] != _CONVERGED:
            continue
        rest, q = quaternion_from_matrix(end), quaternion_from_matrix(frame)
        length, unit = set_shape(chain, shape, rest, factors, torsion_ratio)
        for i in range(3):
            position[i] = place[i] / length
        guess = _one_of(guesses, row)
        status, energy, index = _deform(room, position, q, guess, minimized)
        if status == _CONVERGED:
            _give_back(chain, length, room.nodes, room.rotations)
            residual = judge(
                chain, room.force, position, free_spin, energy, length, end,
                room.nodes, room.rotations, room.moment,
            )  # fmt: skip
            if residual < _CONFIRMED:
                rows.energy[row], rows.residual[row] = unit * energy, residual
                rows.morse_index[row] = index
                for i in range(3):
                    rows.force[row, i] = unit * room.force[i]
                    rows.moment[row, i] = unit * room.moment[i]
                copy_rows(room.nodes, rows.nodes[row])
                for k in range(m + 1):
                    copy_rows(room.rotations[k], rows.rotations[row, k])
            else:
                status = _CHECK_FAILED
        rows.status[row] = status


@kernel
def _one_of(values, row):
    """A row, or the only one."""
    return values[row if values.shape[0] > 1 else 0]


@kernel
def _give_back(chain, length, nodes, rotations):
    """Nodes (m + 1, 3) in units of 1/``length``, and rotations (m + 1, 3, 3), of a chain."""
    m = chain.steps.shape[0]
    for i in range(3):
        nodes[0, i] = 0.0
    for k in range(m + 1):
        r = rotations[k]
        (
            r[0, 0], r[1, 0], r[2, 0], r[0, 1], r[1, 1], r[2, 1], r[0, 2], r[1, 2], r[2, 2],
        ) = directors(chain.frames[k + 1])  # fmt: skip
        if k < m:
            for i in range(3):
                nodes[k + 1, i] = nodes[k, i]
                for j in range(3):
                    nodes[k + 1, i] += length * r[i, j] * chain.steps[k, j]
