"""The discrete rod of least energy: a start wherever no stored rod is near.

The Newton step of the constrained problem (``discrete_rod``) comes from a block tridiagonal LDLᵀ
with four right-hand sides and a 3×3 Schur complement S = C H⁻¹ Cᵀ. It goes downhill iff H and S
have equally many negative eigenvalues; otherwise, or if the step is long, H is shifted. A line
search on energy + μ |constraint|₁ with a second-order correction makes it robust: it starts from
anywhere. At the end the difference of the two counts is the Morse index of the discrete rod, and a
saddle is left by a kick.

With a free end spin the twist costs nothing in the end: M3 = 0.

Nodes are crowded at the ends, where a tense rod has its boundary layers of width 1/√F.
"""

import math

import numpy as np

from loopelastica.rod.kernels.boundary_layers import align, multiply, planar_start, wrap
from loopelastica.rod.kernels.discrete_rod import (
    assemble,
    factor,
    hinge_length,
    hinge_vector,
    inverse3,
    measure,
    negative_eigenvalues,
    turn,
)
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.rotations import larger, matrix_from_quaternion, tangent

SEGMENTS = 64
_ITERATIONS = 200
# largest turn of a frame in one step, and of a step that is cut to it rather than shifted
_STEP, _RADIUS = 1.0, 3.0
# shifts of H: always; the least that makes a difference
_FLOOR, _SHIFT = 1e-6, 4.0
# |constraint|₁ and imbalance of a rod that the polish takes over from
_CLOSED, _BALANCED = 1e-4, 1e-3


@kernel
def graded_nodes(n, root, s):
    """Arc lengths s (n + 1,) with density 1 + (q/2)(e^(−qs) + e^(−q(1−s))), q = √F/2."""
    q = 0.5 * root
    total = 1.0 + (1.0 - math.exp(-q))
    low = 0.0
    for i in range(n + 1):
        wanted = total * i / n
        high = 1.0
        a = low
        for _ in range(26):
            middle = 0.5 * (a + high)
            value = middle + 0.5 * (
                1.0 - math.exp(-q * middle) + math.exp(-q * (1.0 - middle)) - math.exp(-q)
            )
            if value < wanted:
                a = middle
            else:
                high = middle
        s[i] = 0.5 * (a + high)
        low = a
    s[0], s[n] = 0.0, 1.0


@kernel
def _axis_angle(x, y, z, angle, out):
    """Quaternion of a turn by ``angle`` about the unit vector (x, y, z)."""
    s = math.sin(0.5 * angle)
    out[0], out[1], out[2], out[3] = math.cos(0.5 * angle), s * x, s * y, s * z


@kernel
def _layer(s, root, half_angle_tan):
    """Angle of a tail at distance ``s`` from its end: tan(θ/4) = tan(α/4) sinh(√f(1−s))/sinh √f."""
    if root < 1e-3:
        ratio = 1.0 - s
    else:
        ratio = math.exp(-root * s) * (
            (1.0 - math.exp(-2.0 * root * (1.0 - s))) / (1.0 - math.exp(-2.0 * root))
        )
    return 4.0 * math.atan(half_angle_tan * ratio)


@kernel
def start_frames(position, quaternion, gap, free_spin, turns, side0, side1, n, s, frames, force):
    """Fill nodes ``s`` (n + 1,), ``frames`` (n + 2, 4) and ``force`` (3,) of the analytic start.

    The frames go from the start clamp through an axis under tension to the end clamp, with the
    wanted number of turns spread evenly; see `solve_tails` for ``turns`` and the sides.
    """
    root, ex, ey, ez = planar_start(position, quaternion, gap, side0, side1)
    if root < 0.5:
        root = 0.5
    root = min(root, 200.0)
    graded_nodes(n, root, s)
    tx, ty, tz = tangent(quaternion)
    # B carries e3 to e the shortest way; the end frame is Rot(a1, α1) B Rz(twist)
    b, spun, turn0, turn1 = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    first, second = np.empty(4), np.empty(4)
    align(ex, ey, ez, b)
    alpha0 = 2.0 * math.atan2(
        math.sqrt(max(0.5 * (1.0 - ez), 0.0)), math.sqrt(max(0.5 * (1.0 + ez), 0.0))
    )
    # axis of B
    norm0 = math.sqrt(b[1] * b[1] + b[2] * b[2] + b[3] * b[3])
    if norm0 > 1e-12:
        ax, ay, az = b[1] / norm0, b[2] / norm0, b[3] / norm0
    else:
        ax, ay, az = 1.0, 0.0, 0.0
    cx, cy, cz = ey * tz - ez * ty, ez * tx - ex * tz, ex * ty - ey * tx
    norm1 = math.sqrt(cx * cx + cy * cy + cz * cz)
    dot = ex * tx + ey * ty + ez * tz
    alpha1 = math.atan2(norm1, dot)
    if norm1 > 1e-12:
        cx, cy, cz = cx / norm1, cy / norm1, cz / norm1
    else:
        # any axis across e
        m = matrix_from_quaternion(b)
        cx, cy, cz = m[0, 0], m[1, 0], m[2, 0]
    twist = 0.0
    if not free_spin:
        # twist = angle of (Rot(a1, α1) B)ᵀ target about e3
        _axis_angle(cx, cy, cz, -alpha1, turn1)
        multiply(turn1, quaternion, first)
        turn0[0], turn0[1], turn0[2], turn0[3] = b[0], -b[1], -b[2], -b[3]
        multiply(turn0, first, second)
        twist = wrap(2.0 * math.atan2(second[3], second[0])) + 2.0 * math.pi * turns
    if side0:
        alpha0 -= 2.0 * math.pi
    if side1:
        alpha1 -= 2.0 * math.pi
    tan0, tan1 = math.tan(0.25 * alpha0), math.tan(0.25 * alpha1)
    frames[0, 0], frames[0, 1], frames[0, 2], frames[0, 3] = 1.0, 0.0, 0.0, 0.0
    for i in range(n):
        at = 0.5 * (s[i] + s[i + 1])
        _axis_angle(0.0, 0.0, 1.0, twist * at, spun)
        multiply(b, spun, first)
        _axis_angle(cx, cy, cz, _layer(1.0 - at, root, tan1), turn1)
        multiply(turn1, first, second)
        _axis_angle(ax, ay, az, -_layer(at, root, tan0), turn0)
        multiply(turn0, second, frames[i + 1])
    for c in range(4):
        frames[n + 1, c] = quaternion[c]
    if free_spin:
        # the end's spin starts where nothing twists the last hinge
        align_spin(frames[n], frames[n + 1])
    f = root * root if root > 3.0 else 0.0
    force[0], force[1], force[2] = f * ex, f * ey, f * ez


@kernel
def align_spin(reference, q):
    """Turn q about its own d3 so that it differs from ``reference`` by a turn without twist."""
    p, conjugate = np.empty(4), np.empty(4)
    conjugate[0], conjugate[1] = reference[0], -reference[1]
    conjugate[2], conjugate[3] = -reference[2], -reference[3]
    multiply(conjugate, q, p)
    turn(q, 0.0, 0.0, -2.0 * math.atan2(p[3], p[0]))


@kernel
def bow(frames, s, n, size, mode):
    """Bend the inner frames by smooth fixed rotations, to leave a symmetric start."""
    for i in range(n):
        at = 0.5 * (s[i] + s[i + 1])
        slope = size * math.sin(2.0 * math.pi * at)
        other = 0.37 * size * math.sin(math.pi * (1 + mode) * at)
        turn(frames[i + 1], other, slope, 0.0)


@kernel
def wave(frames, s, n, position, force, modes):
    """Bend the inner frames into ``modes`` half waves in the plane of d1, with their Euler load.

    The amplitude takes up the slack; such starts lead to buckled saddles that no minimizer finds.
    """
    length = math.sqrt(position[0] ** 2 + position[1] ** 2 + position[2] ** 2)
    size = 2.0 * math.sqrt(max(1.0 - length, 0.0))
    for i in range(n):
        at = 0.5 * (s[i] + s[i + 1])
        turn(frames[i + 1], 0.0, size * math.sin(math.pi * modes * at), 0.0)
    load = (math.pi * modes) ** 2
    for c in range(3):
        force[c] = -load * position[c] / max(length, 1e-9)


@kernel
def _imbalance(gradient, sides, force):
    """Largest component of the Lagrangian's gradient, relative to 1 + |F|."""
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
def _newton_step(
    diagonal, upper, gradient, sides, c, s, n, once, shift, inverse, x, schur_inverse, wanted, b
):  # fmt: skip
    """Solve the constrained Newton equations, H shifted until the step is short and goes downhill.

    ``x`` (blocks, 3, 4) becomes H⁻¹(−g, Cᵀ), ``schur_inverse`` (3, 3) that of S, ``wanted`` (3,)
    the new multiplier and ``b`` (blocks, 3) the step. With ``once`` H keeps the first shift.
    Returns neg(H) − neg(S), the shift, the slope g·b and the largest turn of b.
    """
    blocks = gradient.shape[0]
    schur, target = np.empty((3, 3)), np.empty(3)
    index, downhill, largest = 0, 0.0, 0.0
    for _ in range(14):
        for k in range(blocks):
            for i in range(3):
                x[k, i, 0] = -gradient[k, i]
                for j in range(3):
                    x[k, i, 1 + j] = sides[k, i, j]
        negative = factor(diagonal, upper, s, n, blocks, shift, inverse, x)
        for i in range(3):
            target[i] = -c[i]
            for j in range(3):
                schur[i, j] = 0.0
        for k in range(n):
            for i in range(3):
                for a in range(2):
                    side = sides[k, a, i]
                    target[i] -= side * x[k, a, 0]
                    for j in range(3):
                        schur[i, j] += side * x[k, a, 1 + j]
        count, _ = negative_eigenvalues(schur, 0.0)
        index = negative - count
        if index == 0 or once:
            inverse3(schur, schur_inverse)
            _times(schur_inverse, target, wanted)
            downhill, largest = _combine(x, wanted, gradient, b)
            # barely convex: the step would be long, and no fraction of it any good
            if once or largest < _RADIUS:
                break
        shift = max(_SHIFT, 4.0 * shift)
    return index, shift, downhill, largest


@kernel
def _times(a, v, out):
    """Product a v of a (3, 3) and a (3,) array, into ``out``."""
    for i in range(3):
        out[i] = a[i, 0] * v[0] + a[i, 1] * v[1] + a[i, 2] * v[2]


@kernel
def _combine(x, wanted, gradient, b):
    """The step b = H⁻¹(−g + Cᵀ F): its slope g·b and its largest turn."""
    downhill, largest = 0.0, 0.0
    for k in range(b.shape[0]):
        total = 0.0
        for i in range(3):
            b[k, i] = x[k, i, 0]
            for j in range(3):
                b[k, i] += x[k, i, 1 + j] * wanted[j]
            total += b[k, i] * b[k, i]
            downhill += gradient[k, i] * b[k, i]
        largest = max(largest, total)
    return downhill, math.sqrt(largest)


@kernel
def _line_search(
    frames, b, x, schur_inverse, s, n, blocks, position, k3, omega, energy, norm_c, mu, downhill, t,
    trial, trial_c,
):  # fmt: skip
    """Backtrack along b on energy + μ |c|₁; ``trial`` and ``trial_c`` are the accepted point.

    The first tries are helped by a second-order correction, b − H⁻¹ Cᵀ S⁻¹ c(trial), which brings
    the constraint's curvature back to zero. Returns the fraction taken (0 if none) and the energy.
    """
    shift, turned_back = np.empty(3), np.empty(3)
    merit = energy + mu * norm_c
    for attempt in range(12):
        enough = merit + 1e-4 * t * downhill + 1e-13 * abs(merit)
        _move(frames, b, x, t, False, shift, n, blocks, trial)
        value = measure(trial, s, n, position, k3, omega, trial_c)
        if value + mu * (abs(trial_c[0]) + abs(trial_c[1]) + abs(trial_c[2])) <= enough:
            return t, value
        if attempt < 3:
            _times(schur_inverse, trial_c, turned_back)
            for i in range(3):
                shift[i] = -turned_back[i]
            _move(frames, b, x, t, True, shift, n, blocks, trial)
            value = measure(trial, s, n, position, k3, omega, trial_c)
            if value + mu * (abs(trial_c[0]) + abs(trial_c[1]) + abs(trial_c[2])) <= enough:
                return t, value
        t *= 0.4
    return 0.0, energy


@kernel
def _move(frames, b, x, t, corrected, extra, n, blocks, trial):
    """Fill ``trial`` with frames exp(t b), or frames exp(t b + W extra) with W = H⁻¹ Cᵀ."""
    for c in range(4):
        trial[0, c] = frames[0, c]
        trial[n + 1, c] = frames[n + 1, c]
    for k in range(blocks):
        v0, v1, v2 = t * b[k, 0], t * b[k, 1], t * b[k, 2]
        if corrected:
            for j in range(3):
                v0 += x[k, 0, 1 + j] * extra[j]
                v1 += x[k, 1, 1 + j] * extra[j]
                v2 += x[k, 2, 1 + j] * extra[j]
        for c in range(4):
            trial[k + 1, c] = frames[k + 1, c]
        turn(trial[k + 1], v0, v1, v2)


@kernel
def relax(position, quaternion, torsion_ratio, free_spin, n, s, frames, force, moment):
    """Minimize the energy of the discrete rod from ``frames`` (n + 2, 4), in place.

    ``force`` (3,) starts and ends as the multiplier, ``moment`` (3,) is M at s = 0. Returns
    (found, energy, Morse index, iterations).
    """
    k3 = 1.0 if free_spin else torsion_ratio
    blocks = n + 1 if free_spin else n
    omega, c, trial_c = np.empty((n + 1, 3)), np.empty(3), np.empty(3)
    diagonal, upper = np.empty((blocks, 3, 3)), np.empty((blocks, 3, 3))
    gradient, sides = np.empty((blocks, 3)), np.empty((blocks, 3, 3))
    inverse, x = np.empty((blocks, 3, 3)), np.empty((blocks, 3, 4))
    schur_inverse, wanted = np.empty((3, 3)), np.empty(3)
    b, trial = np.empty((blocks, 3)), np.empty((n + 2, 4))
    mu, shift, kicks = 0.0, _FLOOR, 0
    energy = measure(frames, s, n, position, k3, omega, c)
    for iteration in range(_ITERATIONS):
        assemble(frames, s, n, blocks, k3, omega, force, diagonal, upper, gradient, sides)
        norm_c = abs(c[0]) + abs(c[1]) + abs(c[2])
        done = norm_c < _CLOSED and _imbalance(gradient, sides, force) < _BALANCED
        index, shift, downhill, largest = _newton_step(
            diagonal, upper, gradient, sides, c, s, n, done, _FLOOR if done else shift,
            inverse, x, schur_inverse, wanted, b,
        )  # fmt: skip
        largest_force = max(abs(wanted[0]), abs(wanted[1]), abs(wanted[2]))
        # a straight start: the constraint has no slope along the chord
        stuck = not largest_force < 1e12
        if done and (index <= 0 or kicks >= 2):
            _first_moment(omega, s, n, k3, moment)
            return True, energy, index, iteration
        if not done and not stuck:
            # a multiplier that was large once must not weigh the constraint for ever
            mu = max(0.5 * mu, 1.1 * largest_force)
            t = min(1.0, _STEP / max(largest, 1e-300))
            taken, value = _line_search(
                frames, b, x, schur_inverse, s, n, blocks, position, k3, omega, energy, norm_c, mu,
                downhill - mu * norm_c, t, trial, trial_c,
            )  # fmt: skip
            stuck = taken == 0.0
        if done or stuck:
            # leave a saddle, or a place from which no direction leads down
            kicks += 1
            if kicks > 3:
                return False, math.inf, 0, iteration
            bow(frames, s, n, 0.07, kicks)
            energy = measure(frames, s, n, position, k3, omega, c)
            mu, shift = 0.0, _FLOOR
            continue
        if taken == t:
            shift = 0.25 * shift if shift > 0.5 * _SHIFT else _FLOOR
        energy = value
        for i in range(3):
            c[i] = trial_c[i]
            force[i] += taken * (wanted[i] - force[i])
        for k in range(n + 2):
            for i in range(4):
                frames[k, i] = trial[k, i]
    return False, math.inf, 0, _ITERATIONS


@kernel
def _first_moment(omega, s, n, k3, moment):
    """M at s = 0: P m of the first hinge, whose left frame is the start frame."""
    x, y, z = omega[0, 0], omega[0, 1], omega[0, 2]
    h = hinge_length(s, n, 0)
    mx, my, mz = x / h, y / h, k3 * z / h
    # P = 1 + [ω]/2 to first order; the hinge is half a segment and small
    moment[0] = mx + 0.5 * (y * mz - z * my)
    moment[1] = my + 0.5 * (z * mx - x * mz)
    moment[2] = mz + 0.5 * (x * my - y * mx)


@kernel
def unrelaxed_loads(frames, s, n, k3, force, load):
    """Loads (6,) of frames in no equilibrium: the force given, the first hinge's moment."""
    omega = np.empty((1, 3))
    hinge_vector(frames[0], frames[1], omega[0])
    _first_moment(omega, s, n, k3, load[3:])
    for c in range(3):
        load[c] = force[c]


@kernel
def hinge_poses(position, frames, s, n, torsion_ratio, m3, stride, node_s, node_pose):
    """Poses at every ``stride``-th hinge, without the extra spin of K30 ≠ 1, as start nodes.

    ``node_s`` (m + 1,), ``node_pose`` (m + 1, 7) with m = n/stride.
    """
    omega = np.empty(3)
    x, y, z = 0.0, 0.0, 0.0
    excess = 1.0 / torsion_ratio - 1.0
    for j in range(n + 1):
        if j % stride == 0:
            k = j // stride
            node_s[k] = s[j]
            node_pose[k, 0], node_pose[k, 1], node_pose[k, 2] = x, y, z
            q = node_pose[k, 3:]
            # the clamps at the ends, the middle of the hinge between
            source = n + 1 if j == n else j
            for c in range(4):
                q[c] = frames[source, c]
            if 0 < j < n:
                hinge_vector(frames[j], frames[j + 1], omega)
                turn(q, 0.5 * omega[0], 0.5 * omega[1], 0.5 * omega[2])
            turn(q, 0.0, 0.0, -m3 * excess * s[j])
        if j < n:
            length = s[j + 1] - s[j]
            tx, ty, tz = tangent(frames[j + 1])
            x += length * tx
            y += length * ty
            z += length * tz
    for c in range(3):
        node_pose[n // stride, c] = position[c]
