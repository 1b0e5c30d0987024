"""One start of the cascade: tails, tails into multiple shooting, discrete rod, polish.

A start is told by whole turns added to the end-to-end twist and by a side for each end (see
``boundary_layers``). Cheap steps come first, and each result is judged by an evaluation that the
step did not use:

1. two tails in closed form, where they do not feel each other;
2. else, at still high tension, their poses as nodes of multiple shooting;
3. the discrete rod of least energy, which always has somewhere to go; under high tension its loads
   are turned into tails, under little they are shot from the start, otherwise its hinges become
   nodes of multiple shooting.

A solution is written into a record: loads, nodes (arc length and pose) or the 20 floats of the
tails. All arrays are the caller's.
"""

import math

import numpy as np

from loopelastica.rod.kernels.boundary_layers import (
    SIZE,
    align,
    check_tails,
    end_turn,
    solve_tails,
    tail_energy,
    tail_loads,
    tail_newton,
    tail_pose,
    tails_apart,
)
from loopelastica.rod.kernels.jit import driver, kernel
from loopelastica.rod.kernels.minimization import (
    SEGMENTS,
    bow,
    graded_nodes,
    hinge_poses,
    relax,
    start_frames,
    unrelaxed_loads,
    wave,
)
from loopelastica.rod.kernels.multiple_shooting import polish
from loopelastica.rod.kernels.newton import CONVERGED, elastic_energy, newton
from loopelastica.rod.kernels.rotations import tangent

NODES = SEGMENTS + 1

# how a solution was found; the names are in `equilibrium`
NONE, SHOOTING, TAILS, TAILS_POLISHED, RELAXED, RELAXED_TAILS, RELAXED_SHOT = 0, 1, 2, 3, 4, 5, 7

# √F cos β above which the tails are good nodes, and above which only tails hold
_TENSE, _STIFF = 14.0, 45.0
_MAX_RATIO = 8.0
# relative size of a pivot that is rounding
_DROP = 1e-12
# places on a circle of nearly equal solutions
_DIRECTIONS = 12

# Newton steps that a stored rod is given to come near: one that needs more seldom does
_HASTE = 4
# √F below which one shot from the start is accurate; Newton steps that a discrete rod is given, and
# how far, relative to their size, its loads may go: further, it would be another rod
_LOOSE, _STEPS, _SAME = 6.0, 4, 0.1

# 1 − |r| above which half the segments do; what hinge energies may be off by
_SLACK, _MARGIN = 0.15, 0.05

# turns, side 0, side 1 and kick of what is tried where nothing else has led anywhere
_RETRIES = np.array(
    (
        (0.0, 0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0, -1.0),
        (0.0, 0.0, 0.0, 0.2),
        (1.0, 0.0, 0.0, 0.0),
        (-1.0, 0.0, 0.0, 0.0),
        (0.0, 1.0, 0.0, 0.0),
        (0.0, 0.0, 1.0, 0.0),
        (0.0, 0.0, 0.0, 0.5),
        (1.0, 0.0, 0.0, 0.4),
        (-1.0, 0.0, 0.0, 0.4),
        (2.0, 0.0, 0.0, 0.2),
        (-2.0, 0.0, 0.0, 0.2),
        (0.0, 1.0, 1.0, 0.1),
        (-1.0, 1.0, 0.0, 0.3),
        (1.0, 1.0, 0.0, 0.3),
        (0.0, 0.0, 0.0, 0.9),
    )
)

# 1 − |r| below which starts can be told useless beforehand; cosine of an end tangent that opposes
# the chord
_STRAIGHTISH, _OPPOSED = 0.05, -0.8


@driver
def _accept_tails(tail, quaternion, torsion_ratio, free_spin, tolerance, loads):
    """(residual, energy) of a tail solution and its loads; residual inf if it is none."""
    if not tails_apart(tail):
        return math.inf, math.inf
    residual = check_tails(tail, quaternion, torsion_ratio, free_spin)
    if not residual < tolerance:
        return math.inf, math.inf
    tail_loads(tail, loads)
    if free_spin:
        loads[5] = 0.0
    return residual, tail_energy(tail, torsion_ratio)


@driver
def _accept_nodes(
    quaternion, position, torsion_ratio, free_spin, node_s, node_pose, m, tolerance, loads
):
    """(residual, energy) of polished nodes; ``loads`` go in as the guess and out as F, M0.

    Where both ends are on one line, or nearly, the solutions lie on a circle of directions and
    Newton's step runs off along it. A second try keeps still along such directions, and others go
    on from there, turned to several places of the circle.
    """
    s, pose = node_s[: m + 1], node_pose[: m + 1]
    first_pose, first_loads = pose.copy(), loads.copy()
    residual, energy, _ = polish(quaternion, torsion_ratio, free_spin, s, pose, loads, _DROP, 14)
    if not residual < tolerance and _near_one_line(position, quaternion):
        pose[:, :] = first_pose
        loads[:] = first_loads
        residual, energy, _ = polish(quaternion, torsion_ratio, free_spin, s, pose, loads, 1e-4, 30)
        first_pose[:, :] = pose
        first_loads[:] = loads
        for i in range(_DIRECTIONS):
            if residual < tolerance:
                break
            pose[:, :] = first_pose
            loads[:] = first_loads
            _turn_about_start(pose, loads, 2.0 * math.pi * i / _DIRECTIONS)
            residual, energy, _ = polish(
                quaternion, torsion_ratio, free_spin, s, pose, loads, _DROP, 25
            )
    if free_spin:
        loads[5] = 0.0
    if not residual < tolerance:
        return math.inf, math.inf
    return residual, energy


@kernel
def _turn_about_start(pose, loads, angle):
    """Turn the inner nodes and the loads about d3(0), ends fixed: Rz R Rzᵀ for the frames."""
    c, s = math.cos(angle), math.sin(angle)
    for o in (0, 3):
        x, y = loads[o], loads[o + 1]
        loads[o], loads[o + 1] = c * x - s * y, s * x + c * y
    for k in range(1, pose.shape[0] - 1):
        x, y = pose[k, 0], pose[k, 1]
        pose[k, 0], pose[k, 1] = c * x - s * y, s * x + c * y
        # conjugation turns the vector part of the quaternion
        x, y = pose[k, 4], pose[k, 5]
        pose[k, 4], pose[k, 5] = c * x - s * y, s * x + c * y


@kernel
def _near_one_line(position, quaternion):
    """Whether both end tangents are parallel to the chord to within 0.01 rad, either way."""
    tx, ty, _ = tangent(quaternion)
    across = math.sqrt(position[0] ** 2 + position[1] ** 2)
    size = math.sqrt(position[0] ** 2 + position[1] ** 2 + position[2] ** 2)
    return math.sqrt(tx * tx + ty * ty) < 0.01 and across <= 0.01 * size + 1e-4


@driver
def _from_tails(
    tail, position, quaternion, torsion_ratio, free_spin, tolerance, loads, node_s, node_pose
):
    """Polish the poses of tails that feel each other; returns (residual, energy, segments)."""
    gamma = math.cos(tail[5]) * tail[4]
    m = 16 if gamma < 36.0 else 32
    graded_nodes(m, tail[4], node_s[: m + 1])
    moment = np.empty(3)
    for i in range(m + 1):
        from_end = node_s[i] > 0.5
        distance = 1.0 - node_s[i] if from_end else node_s[i]
        tail_pose(tail, distance, from_end, node_pose[i], moment)
    tail_loads(tail, loads)
    target = quaternion
    if free_spin:
        # the free end's spin is where the tail leaves it
        loads[5] = 0.0
        target = node_pose[m, 3:].copy()
    node_pose[0, :] = 0.0
    node_pose[0, 3] = 1.0
    residual, energy = _accept_nodes(
        target, position, torsion_ratio, free_spin, node_s, node_pose, m, tolerance, loads
    )
    return residual, energy, m


@driver
def _settle_tails(
    tail, position, quaternion, torsion_ratio, free_spin, tolerance, loads, node_s, node_pose
):  # fmt: skip
    """The tails themselves, or polished where they feel each other: (residual, energy, segments).

    Residual inf if neither is a solution.
    """
    residual, energy = _accept_tails(tail, quaternion, torsion_ratio, free_spin, tolerance, loads)
    if residual < tolerance:
        return residual, energy, 0
    if math.cos(tail[5]) * tail[4] > _TENSE:
        return _from_tails(
            tail, position, quaternion, torsion_ratio, free_spin, tolerance,
            loads, node_s, node_pose,
        )  # fmt: skip
    return math.inf, math.inf, 0


@kernel
def _tails_from_loads(loads, position, quaternion, gap, torsion_ratio, free_spin, tail):
    """Tails that carry the loads found by the discrete rod; True if their equations are solved."""
    f = math.sqrt(loads[0] ** 2 + loads[1] ** 2 + loads[2] ** 2)
    ex, ey, ez = loads[0] / f, loads[1] / f, loads[2] / f
    root = math.sqrt(f)
    m3 = 0.0 if free_spin else loads[3] * ex + loads[4] * ey + loads[5] * ez
    q0, x = np.empty(4), np.zeros(6)
    align(ex, ey, ez, q0)
    beta = math.asin(min(max(0.5 * m3 / root, -0.999), 0.999))
    x[2], x[3] = math.log(root), beta
    # δ of an end from cos(α/2) sin δ = sin β and the side its moment tells: M·(e × t) > 0 is direct
    tx, ty, tz = tangent(quaternion)
    for end in range(2):
        if end == 0:
            ax, ay, az = 0.0, 0.0, 1.0
            mx, my, mz = loads[3], loads[4], loads[5]
            sign = 1.0
        else:
            ax, ay, az = tx, ty, tz
            mx = loads[3] + loads[1] * position[2] - loads[2] * position[1]
            my = loads[4] + loads[2] * position[0] - loads[0] * position[2]
            mz = loads[5] + loads[0] * position[1] - loads[1] * position[0]
            sign = -1.0
        half_cos = math.sqrt(max(0.5 * (1.0 + ax * ex + ay * ey + az * ez), 1e-12))
        delta = math.asin(min(max(math.sin(beta) / half_cos, -1.0), 1.0))
        bending = sign * (
            mx * (ay * ez - az * ey) + my * (az * ex - ax * ez) + mz * (ax * ey - ay * ex)
        )
        if bending < 0.0:
            delta = math.pi - delta
        x[4 + end] = delta
    reference = end_turn(quaternion, q0)
    if not free_spin:
        wanted = 2.0 * root * math.sin(beta) / torsion_ratio + 2.0 * (x[4] + x[5] - 2.0 * beta)
        reference += 2.0 * math.pi * round((wanted - reference) / (2.0 * math.pi))
    return tail_newton(x, q0, position, quaternion, gap, torsion_ratio, free_spin, reference, tail)


@driver
def _relax_start(position, quaternion, gap, ratio, free_spin, start, n, s, frames, load):
    """The discrete rod of one start: its energy, or inf; ``load`` (6,) is F and M at s = 0."""
    force, moment = np.empty(3), np.empty(3)
    start_frames(
        position, quaternion, gap, free_spin, start[0], start[1] != 0.0, start[2] != 0.0,
        n, s, frames, force,
    )  # fmt: skip
    if start[3] < 0.0:
        # unrelaxed: multiple shooting then goes to a saddle as readily as to a minimum
        if start[3] < -1.0:
            wave(frames, s, n, position, force, -start[3])
        unrelaxed_loads(frames, s, n, ratio, force, load)
        return 0.0
    if start[3] > 0.0:
        bow(frames, s, n, start[3], 1)
    found, energy, _, _ = relax(position, quaternion, ratio, free_spin, n, s, frames, force, moment)
    for c in range(3):
        load[c], load[3 + c] = force[c], moment[c]
    return energy if found else math.inf


@driver
def _finish(
    position, quaternion, gap, torsion_ratio, relaxed_ratio, free_spin, relaxed, n, s, frames, load,
    tolerance, loads, node_s, node_pose, tail,
):  # fmt: skip
    """From the discrete rod to a solution, see `run_starts`."""
    size = math.sqrt(math.sqrt(load[0] ** 2 + load[1] ** 2 + load[2] ** 2))
    if size > _STIFF and _tails_from_loads(
        load, position, quaternion, gap, torsion_ratio, free_spin, tail
    ):
        residual, energy, m = _settle_tails(
            tail, position, quaternion, torsion_ratio, free_spin, tolerance,
            loads, node_s, node_pose,
        )  # fmt: skip
        if residual < tolerance:
            return RELAXED_TAILS, residual, energy, m
    if (
        relaxed
        and size < _LOOSE
        and torsion_ratio == relaxed_ratio
        and not _near_one_line(position, quaternion)
    ):
        loads[:] = load
        status, residual, _, end = newton(
            loads, position, quaternion, torsion_ratio, free_spin, tolerance, _STEPS
        )
        if status == CONVERGED and _apart(loads, load) < _SAME:
            return RELAXED_SHOT, residual, elastic_energy(loads, end, torsion_ratio), 0
    target = frames[n + 1].copy() if free_spin else quaternion
    # with M3 = 0 the ratio is void
    ratio = 1.0 if free_spin else torsion_ratio
    m = 16 if size < 40.0 else 32
    # more nodes help where the discrete rod is near, not where nothing was relaxed
    most = n if relaxed else m
    while m <= most:
        loads[:] = load
        if free_spin:
            loads[5] = 0.0
        hinge_poses(
            position, frames, s, n, ratio, load[5], n // m, node_s[: m + 1], node_pose[: m + 1]
        )
        residual, energy = _accept_nodes(
            target, position, ratio, free_spin, node_s, node_pose, m, tolerance, loads
        )
        if residual < tolerance:
            return RELAXED, residual, energy, m
        if ratio > relaxed_ratio:
            # too far at once: let the ratio grow from where the discrete rod was
            loads[:] = load
            hinge_poses(
                position, frames, s, n, relaxed_ratio, load[5], n // m,
                node_s[: m + 1], node_pose[: m + 1],
            )  # fmt: skip
            grown = relaxed_ratio
            while True:
                residual, energy = _accept_nodes(
                    target, position, grown, free_spin, node_s, node_pose, m, tolerance, loads
                )
                if not residual < tolerance or grown == ratio:
                    break
                grown = min(1.5 * grown, ratio)
            if residual < tolerance:
                return RELAXED, residual, energy, m
        m *= 2
    return NONE, math.inf, math.inf, 0


@driver
def _worthwhile(start, position, quaternion, gap, free_spin):
    """Whether a start can lead to the lowest rod of a nearly straight clamping.

    There a kick is in vain, and the energy is that of the tails plus K30 (twist + 2πn)²/2, least
    for the twist within half a turn; a tail over the other side pays only where the tangent nearly
    opposes the chord.
    """
    if gap > _STRAIGHTISH:
        return True
    if start[3] != 0.0:
        return False
    length = 1.0 - gap
    ex, ey, ez = position[0] / length, position[1] / length, position[2] / length
    tx, ty, tz = tangent(quaternion)
    if (start[1] != 0.0 and ez > _OPPOSED) or (
        start[2] != 0.0 and tx * ex + ty * ey + tz * ez > _OPPOSED
    ):
        return False
    if free_spin or start[0] == 0.0:
        return True
    q = np.empty(4)
    align(ex, ey, ez, q)
    return abs(end_turn(quaternion, q) + 2.0 * math.pi * start[0]) < math.pi + 1.0


@driver
def _begin(
    position, quaternion, gap, torsion_ratio, relaxed_ratio, free_spin, start, n, s, frames, load,
    tail,
):  # fmt: skip
    """Half way from a start: (TAILS or RELAXED or NONE, its energy to about a hundredth).

    ``load`` becomes F and M0 of two tails, or of the discrete rod.
    """
    tense = start[3] == 0.0 and solve_tails(
        position, quaternion, gap, torsion_ratio, free_spin, start[0], start[1] != 0.0,
        start[2] != 0.0, tail,
    )  # fmt: skip
    if tense and (tails_apart(tail) or math.cos(tail[5]) * tail[4] > _TENSE):
        tail_loads(tail, load)
        return TAILS, tail_energy(tail, torsion_ratio)
    energy = _relax_start(
        position, quaternion, gap, relaxed_ratio, free_spin, start, n, s, frames, load
    )
    return (RELAXED if energy < math.inf else NONE), energy


@driver
def _end(
    kind, position, quaternion, gap, torsion_ratio, relaxed_ratio, free_spin, start, n, s, frames,
    load, start_tail, tolerance, loads, node_s, node_pose, tail,
):  # fmt: skip
    """The other half, to a solution (method, residual, energy, segments), see `run_starts`."""
    if kind == TAILS:
        tail[:] = start_tail
        residual, energy, m = _settle_tails(
            tail, position, quaternion, torsion_ratio, free_spin, tolerance,
            loads, node_s, node_pose,
        )  # fmt: skip
        if residual < tolerance:
            return (TAILS if m == 0 else TAILS_POLISHED), residual, energy, m
        if (
            not _relax_start(
                position, quaternion, gap, relaxed_ratio, free_spin, start, n, s, frames, load
            )
            < math.inf
        ):
            return NONE, math.inf, math.inf, 0
    return _finish(
        position, quaternion, gap, torsion_ratio, relaxed_ratio, free_spin, start[3] >= 0.0, n, s,
        frames, load, tolerance, loads, node_s, node_pose, tail,
    )  # fmt: skip


@driver
def run_start(
    position, quaternion, torsion_ratio, free_spin, start, tolerance,
    loads, node_s, node_pose, tail,
):  # fmt: skip
    """One start (turns, side 0, side 1, kick) to its own solution, with no other try.

    A negative kick leaves out the relaxation; −k with k > 1 adds k half waves.
    """
    gap, ratio = _gap(position), min(torsion_ratio, _MAX_RATIO)
    # all segments: half of them lose minima that are about to vanish in a fold
    n = SEGMENTS
    s, frames, load, start_tail = np.empty(n + 1), np.empty((n + 2, 4)), np.empty(6), np.zeros(SIZE)
    kind, _ = _begin(
        position, quaternion, gap, torsion_ratio, ratio, free_spin, start, n, s, frames, load,
        start_tail,
    )  # fmt: skip
    if kind == NONE:
        return NONE, math.inf, math.inf, 0
    return _end(
        kind, position, quaternion, gap, torsion_ratio, ratio, free_spin, start, n, s, frames, load,
        start_tail, tolerance, loads, node_s, node_pose, tail,
    )  # fmt: skip


@kernel
def _gap(position):
    """1 − |r|."""
    squares = position[0] ** 2 + position[1] ** 2 + position[2] ** 2
    return (1.0 - squares) / (1.0 + math.sqrt(squares))


@driver
def run_starts(
    position, quaternion, torsion_ratio, free_spin, starts, lowest, tolerance,
    loads, node_s, node_pose, tail,
):  # fmt: skip
    """Run starts (n, 4: turns, side 0, side 1, kick) and keep the first or the lowest solution.

    For the lowest, all starts go half way first and are finished in the order of their energies,
    down to where none of those left can be lower. A last round of kicked starts follows where
    nothing has led to a solution.

    Returns (method, residual, energy, segments). With 0 segments the solution is ``tail`` (20,),
    else the first segments + 1 of ``node_s`` (65,) and ``node_pose`` (65, 7); ``loads`` (6,) are
    written in either case.
    """
    gap = _gap(position)
    n = SEGMENTS // 2 if gap > _SLACK else SEGMENTS
    count = starts.shape[0]
    scratch = (np.empty(6), np.empty(NODES), np.empty((NODES, 7)), np.zeros(SIZE))
    s, frames = np.empty((count, n + 1)), np.empty((count, n + 2, 4))
    load, energies = np.empty((count, 6)), np.full(count, math.inf)
    tails, kinds = np.zeros((count, SIZE)), np.zeros(count, np.int64)
    ended = np.zeros(count, np.bool_)
    best = (NONE, math.inf, math.inf, 0)
    # a large ratio makes the energy a narrow valley; the rod depends on 1/K30 only, and the polish
    # goes the rest of the way
    ratio = min(torsion_ratio, _MAX_RATIO)
    for i in range(count):
        if not _worthwhile(starts[i], position, quaternion, gap, free_spin):
            continue
        kinds[i], energies[i] = _begin(
            position, quaternion, gap, torsion_ratio, ratio, free_spin, starts[i], n, s[i],
            frames[i], load[i], tails[i],
        )  # fmt: skip
        if lowest or kinds[i] == NONE:
            continue
        result = _end(
            kinds[i], position, quaternion, gap, torsion_ratio, ratio, free_spin, starts[i], n,
            s[i], frames[i], load[i], tails[i], tolerance, *scratch,
        )  # fmt: skip
        best = _keep(result, best, scratch, loads, node_s, node_pose, tail)
        if best[0] != NONE:
            return best
    while lowest:
        i = 0
        for j in range(1, count):
            if energies[j] < energies[i]:
                i = j
        # they are off by about a hundredth
        if not energies[i] < best[2] * (1.0 + _MARGIN) + _MARGIN:
            break
        energies[i] = math.inf
        if _seen(load, ended, i):
            continue
        ended[i] = True
        result = _end(
            kinds[i], position, quaternion, gap, torsion_ratio, ratio, free_spin, starts[i], n,
            s[i], frames[i], load[i], tails[i], tolerance, *scratch,
        )  # fmt: skip
        best = _keep(result, best, scratch, loads, node_s, node_pose, tail)
    for i in range(_RETRIES.shape[0]):
        if best[0] != NONE:
            break
        # first the narrow valley itself, where the ratio is large
        for trial_ratio in (torsion_ratio, ratio):
            energy = _relax_start(
                position, quaternion, gap, trial_ratio, free_spin, _RETRIES[i], n,
                s[0], frames[0], load[0],
            )  # fmt: skip
            if energy < math.inf:
                result = _finish(
                    position, quaternion, gap, torsion_ratio, trial_ratio, free_spin, True, n, s[0],
                    frames[0], load[0], tolerance, *scratch,
                )  # fmt: skip
                best = _keep(result, best, scratch, loads, node_s, node_pose, tail)
            if best[0] != NONE or torsion_ratio == ratio:
                break
    return best


@driver
def _keep(result, best, scratch, loads, node_s, node_pose, tail):
    """The better of two results; the record of a new one is copied from the scratch arrays."""
    if not result[2] < best[2]:
        return best
    m = result[3]
    loads[:] = scratch[0]
    node_s[: m + 1] = scratch[1][: m + 1]
    node_pose[: m + 1] = scratch[2][: m + 1]
    tail[:] = scratch[3]
    return result


@kernel
def _seen(load, ended, i):
    """Whether a start that has come to its end was at the same rod half way as start ``i``."""
    for j in range(load.shape[0]):  # noqa: SIM110 (numba compiles no generators)
        if ended[j] and _apart(load[i], load[j]) < 1e-3:
            return True
    return False


@kernel
def _apart(one, other):
    """Largest difference of two loads, relative to the largest component or to 1."""
    apart, size = 0.0, 1.0
    for c in range(6):
        apart = max(apart, abs(one[c] - other[c]))
        size = max(size, abs(one[c]))
    return apart / size


@kernel
def run_batch(
    positions, quaternions, torsion_ratio, free_spin, guesses, known, starts, lowest, tolerance,
    loads, energies, residuals, methods,
):  # fmt: skip
    """Many poses: Newton's method from ``known`` (n,) of ``guesses`` (n, g, 6), or `run_starts`."""
    tail, node_s, node_pose = np.zeros(SIZE), np.empty(NODES), np.empty((NODES, 7))
    for i in range(positions.shape[0]):
        # no stored rod is that nearly straight
        near = known[i] if _gap(positions[i]) > _STRAIGHTISH else 0
        for j in range(near):
            loads[i] = guesses[i, j]
            status, residual, _, end = newton(
                loads[i], positions[i], quaternions[i], torsion_ratio, free_spin, tolerance, _HASTE
            )
            if status == CONVERGED:
                energies[i] = elastic_energy(loads[i], end, torsion_ratio)
                residuals[i], methods[i] = residual, SHOOTING
                break
        if methods[i] == NONE:
            methods[i], residuals[i], energies[i], _ = run_starts(
                positions[i], quaternions[i], torsion_ratio, free_spin, starts, lowest, tolerance,
                loads[i], node_s, node_pose, tail,
            )  # fmt: skip
