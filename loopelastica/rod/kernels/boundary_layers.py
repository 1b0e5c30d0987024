"""The stiff limit: a rod under high tension is two homoclinic tails, in closed form.

With e = F/|F|, f = |F|, γ = k√f large, the rod is straight along e but for a boundary layer of
width 1/√f at each end. There the angle θ between tangent and e obeys
½θ'² + ½M3² tan²(θ/2) = f (1 − cos θ), the motion homoclinic to the straight twisted rod, so that
with sin β = M3/(2√f) and k = cos β

    sin(θ/2) = k sech X,     X = γ s + x0,     φ' = M3/(1 + cos θ),     χ' = φ' + M3 (1/K30 − 1)

in the ZYZ angles (φ, θ, χ) about e. What is left out is the meeting of the tails, of order
exp(−γ/2); it is computed and must be below 2e-12.

End i has the angle α_i to e. Its tail is told by δ_i, cos(α_i/2) sin δ_i = sin β: |δ_i| < π/2 goes
straight to the axis, δ_i near π first over the other side. Then sinh x0_i = cot(α_i/2) cos δ_i and
all that the end pose needs is elementary: the tail shortens the rod by
(2/√f)(cos β − cos(α_i/2) cos δ_i), gains the azimuth δ_i − β and leaves the clamp
(2/√f) sin(α_i/2) off the axis. Six equations for (two tilts of e, ln √f, β, δ0, δ1) follow and are
solved by Newton's method; no differential equation is left.

With a free end spin M3 = 0, and β = 0 takes the place of the twist equation.

A tail solution is an array of 20 floats (see `_pack`); it determines the rod where loads alone no
longer do, errors of which grow like exp √f.
"""

import math

import numpy as np

from loopelastica.rod.kernels.jit import driver, kernel
from loopelastica.rod.kernels.rotations import (
    larger,
    matrix_from_quaternion,
    rotation_vector,
    spin,
    tangent,
)
from loopelastica.rod.kernels.shooting import POSE, WITH_JACOBIAN, march

SIZE = 20
_MEETING = 2e-12
_TOLERANCE = 2e-12
_TINY = 1e-300
# largest torsion ratio that is solved at once
_MAX_RATIO = 8.0
# √F below which no tail reaches the middle
_SLACK = 10.0


@kernel
def wrap(angle):
    """The angle modulo 2π in [−π, π)."""
    return angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))


@kernel
def multiply(p, q, out):
    """Quaternion product p q into ``out``, which may be neither."""
    out[0] = p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3]
    out[1] = p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2]
    out[2] = p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1]
    out[3] = p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]


@kernel
def align(ex, ey, ez, out):
    """Shortest rotation that carries e3 to the unit vector e, as a quaternion into ``out``."""
    if ez > -0.999999:
        norm = math.sqrt(2.0 * (1.0 + ez))
        out[0], out[1], out[2], out[3] = 0.5 * norm, -ey / norm, ex / norm, 0.0
    else:
        # e is opposite: turn about an axis across, here d1, first
        norm = math.sqrt(2.0 * (1.0 - ez))
        out[0], out[1], out[2], out[3] = -ey / norm, 0.5 * norm, 0.0, ex / norm


@kernel
def end_angles(w, x, y, z):
    """ZYZ angles (φ, α, χ) of a quaternion, accurate at α = 0 and π too."""
    alpha = 2.0 * math.atan2(math.sqrt(x * x + y * y), math.sqrt(w * w + z * z))
    total = 2.0 * math.atan2(z, w)
    difference = 2.0 * math.atan2(-x, y)
    return 0.5 * (total + difference), alpha, 0.5 * (total - difference)


@kernel
def _tilted(q0, u, v, out):
    """Q0 turned by the rotation vector (u, v, 0) of its own frame."""
    a = math.sqrt(u * u + v * v)
    s = math.sin(0.5 * a) / a if a > 1e-8 else 0.5
    step = np.empty(4)
    step[0], step[1], step[2], step[3] = math.cos(0.5 * a), s * u, s * v, 0.0
    multiply(q0, step, out)


@kernel
def _equations(x, q0, position, quaternion, torsion_ratio, free_spin, reference, gap, e, q, p):
    """The six residuals ``e`` at x = (tilts, ln √f, β, δ0, δ1); Q goes into ``q``.

    ``reference`` is the end-to-end turn φ + χ that this solution is meant to have (2π n included),
    ``gap`` the chord's defect 1 − |r|, known better than 1 minus its rounded length.
    """
    _tilted(q0, x[0], x[1], q)
    root = math.exp(x[2])
    beta = x[3]
    phi0, alpha0, chi0 = end_angles(q[0], -q[1], -q[2], -q[3])
    # p = Q* target
    p[4], p[5], p[6], p[7] = q[0], -q[1], -q[2], -q[3]
    multiply(p[4:], quaternion, p)
    phi1, alpha1, chi1 = end_angles(p[0], p[1], p[2], p[3])
    c0, s0 = math.cos(0.5 * alpha0), math.sin(0.5 * alpha0)
    c1, s1 = math.cos(0.5 * alpha1), math.sin(0.5 * alpha1)
    m = matrix_from_quaternion(q)
    rx = m[0, 0] * position[0] + m[1, 0] * position[1] + m[2, 0] * position[2]
    ry = m[0, 1] * position[0] + m[1, 1] * position[1] + m[2, 1] * position[2]
    a0, a1 = phi0 + x[4], phi1 - x[5]
    scale = 2.0 / root
    e[0] = scale * (s0 * math.cos(a0) + s1 * math.cos(a1)) - rx
    e[1] = scale * (s0 * math.sin(a0) + s1 * math.sin(a1)) - ry
    shortening = scale * (2.0 * math.cos(beta) - c0 * math.cos(x[4]) - c1 * math.cos(x[5]))
    # |r| − r_z without cancellation, r_x and r_y being small
    length = 1.0 - gap
    lean = (rx * rx + ry * ry) / (
        length + m[0, 2] * position[0] + m[1, 2] * position[1] + m[2, 2] * position[2]
    )
    e[2] = gap + lean - shortening
    if free_spin:
        e[3] = beta
    else:
        turn = phi1 + chi1 - phi0 - chi0
        turn += 2.0 * math.pi * round((reference - turn) / (2.0 * math.pi))
        twist = 2.0 * root * math.sin(beta) / torsion_ratio
        e[3] = twist + 2.0 * (x[4] + x[5] - 2.0 * beta) - turn
    e[4] = c0 * math.sin(x[4]) - math.sin(beta)
    e[5] = c1 * math.sin(x[5]) - math.sin(beta)
    # tails that are thin compared with the length hide in an absolute position error
    return root


@kernel
def _solve6(a, b):
    """Gaussian elimination with partial pivoting, in place; b becomes the solution."""
    n = 6
    for p in range(n):
        best = p
        for i in range(p + 1, n):
            if abs(a[i, p]) > abs(a[best, p]):
                best = i
        if not abs(a[best, p]) > 1e-14:
            return False
        if best != p:
            for j in range(p, n):
                a[p, j], a[best, j] = a[best, j], a[p, j]
            b[p], b[best] = b[best], b[p]
        for i in range(p + 1, n):
            factor = a[i, p] / a[p, p]
            for j in range(p + 1, n):
                a[i, j] -= factor * a[p, j]
            b[i] -= factor * b[p]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            b[i] -= a[i, j] * b[j]
        b[i] /= a[i, i]
    return True


@kernel
def _weight(root):
    """Position errors count in units of the tails' width, as far as rounding lets them."""
    return 0.5 * min(root, 1e4)


@kernel
def _weighted(e, root, out):
    """Residuals with weighted position; returns their l1 norm."""
    total = 0.0
    for c in range(6):
        out[c] = e[c] * (_weight(root) if c < 3 else 1.0)
        total += abs(out[c])
    return total if total == total else math.inf


@kernel
def planar_start(position, quaternion, gap, side0, side1):
    """First guess of the axis and of √f: planar tails (β = 0), by fixed-point rounds.

    Returns (√f, ex, ey, ez), √f = 0 where no tension pulls the ends this far apart.
    """
    length = 1.0 - gap
    norm = max(math.sqrt(position[0] ** 2 + position[1] ** 2 + position[2] ** 2), _TINY)
    ex, ey, ez = position[0] / norm, position[1] / norm, position[2] / norm
    tx, ty, tz = tangent(quaternion)
    root = 0.0
    sign0 = -1.0 if side0 else 1.0
    sign1 = -1.0 if side1 else 1.0
    for _ in range(8):
        cos0 = math.sqrt(max(0.5 * (1.0 + ez), 0.0))
        cos1 = math.sqrt(max(0.5 * (1.0 + tx * ex + ty * ey + tz * ez), 0.0))
        sin0 = math.sqrt(max(0.5 * (1.0 - ez), 0.0))
        sin1 = math.sqrt(max(0.5 * (1.0 - tx * ex - ty * ey - tz * ez), 0.0))
        short = 2.0 * (2.0 - sign0 * cos0 - sign1 * cos1)
        # transverse directions of the tangents
        ax, ay, az = -ez * ex, -ez * ey, 1.0 - ez * ez
        d = tx * ex + ty * ey + tz * ez
        bx, by, bz = tx - d * ex, ty - d * ey, tz - d * ez
        na = max(math.sqrt(ax * ax + ay * ay + az * az), _TINY)
        nb = max(math.sqrt(bx * bx + by * by + bz * bz), _TINY)
        w0, w1 = 2.0 * sign0 * sin0 / na, 2.0 * sign1 * sin1 / nb
        ox, oy, oz = w0 * ax + w1 * bx, w0 * ay + w1 * by, w0 * az + w1 * bz
        # |r − w o|² = (1 − w S)²
        quadratic = ox * ox + oy * oy + oz * oz - short * short
        linear = short - (position[0] * ox + position[1] * oy + position[2] * oz)
        constant = -gap * (1.0 + length)
        discriminant = linear * linear - quadratic * constant
        if discriminant < 0.0:
            return 0.0, ex, ey, ez
        s = math.sqrt(discriminant)
        # the smaller positive root, in the form that does not cancel
        w = 0.0
        if linear > 0.0:
            w = -constant / (linear + s)
        elif quadratic > 0.0:
            w = (s - linear) / quadratic
        if not w > 0.0 or w > 1.0:
            return 0.0, ex, ey, ez
        root = 1.0 / w
        gx, gy, gz = position[0] - w * ox, position[1] - w * oy, position[2] - w * oz
        norm = max(math.sqrt(gx * gx + gy * gy + gz * gz), _TINY)
        ex, ey, ez = gx / norm, gy / norm, gz / norm
    return root, ex, ey, ez


@kernel
def end_turn(quaternion, q):
    """φ + χ gained from the start to the end frame about the axis of ``q``, in [−π, π)."""
    phi0, _, chi0 = end_angles(q[0], -q[1], -q[2], -q[3])
    p, conjugate = np.empty(4), np.empty(4)
    conjugate[0], conjugate[1], conjugate[2], conjugate[3] = q[0], -q[1], -q[2], -q[3]
    multiply(conjugate, quaternion, p)
    phi1, _, chi1 = end_angles(p[0], p[1], p[2], p[3])
    return wrap(phi1 + chi1 - phi0 - chi0)


@kernel
def tail_newton(x, q0, position, quaternion, gap, torsion_ratio, free_spin, reference, out):
    """Newton from x = (0, 0, ln √f, β, δ0, δ1) about the axis frame ``q0``.

    True if the equations are solved; ``out`` (20,) is then the solution (see `tails_apart`).
    """
    e, trial_e, weighted = np.empty(6), np.empty(6), np.empty(6)
    jacobian, d, trial = np.empty((6, 6)), np.empty(6), np.empty(6)
    q, p = np.empty(4), np.empty(8)
    caps = (0.3, 0.3, 0.5, 0.3, 0.5, 0.5)
    root = _equations(
        x, q0, position, quaternion, torsion_ratio, free_spin, reference, gap, e, q, p
    )
    cost = _weighted(e, root, weighted)
    for _ in range(30):
        if cost < _TOLERANCE:
            break
        for j in range(6):
            h = 1e-7
            for c in range(6):
                trial[c] = x[c]
            trial[j] += h
            # the same weights as at x: the derivative of the residual alone
            _equations(
                trial, q0, position, quaternion, torsion_ratio, free_spin, reference, gap,
                trial_e, q, p,
            )  # fmt: skip
            for c in range(6):
                jacobian[c, j] = (trial_e[c] - e[c]) / h * (_weight(root) if c < 3 else 1.0)
        for c in range(6):
            d[c] = -weighted[c]
        if not _solve6(jacobian, d):
            return False
        shrink = 1.0
        for c in range(6):
            shrink = min(shrink, caps[c] / max(abs(d[c]), _TINY))
        improved = False
        for _ in range(8):
            for c in range(6):
                trial[c] = x[c] + shrink * d[c]
            trial_root = _equations(
                trial, q0, position, quaternion, torsion_ratio, free_spin, reference, gap,
                trial_e, q, p,
            )  # fmt: skip
            trial_cost = _weighted(trial_e, trial_root, weighted)
            if trial_cost < cost:
                improved = True
                break
            shrink *= 0.5
        if not improved:
            break
        for c in range(6):
            x[c], e[c] = trial[c], trial_e[c]
        root, cost = trial_root, trial_cost
    _equations(x, q0, position, quaternion, torsion_ratio, free_spin, reference, gap, e, q, p)
    _weighted(e, root, weighted)
    if not cost < 1e-10 or not x[2] < 50.0:
        return False
    _pack(x, q, quaternion, position, out)
    return True


@kernel
def _pack(x, q, quaternion, position, out):
    """The solution as 20 floats.

    0–3 Q, 4 √f, 5 β, 6–8 (φ, x0, δ) of end 0, 9–11 of end 1, 12–14 r(L), 15–16 sin(α_i/2),
    17 the meeting, 18–19 χ of either end (K30 = 1, counted on from the start).
    """
    root, beta = math.exp(x[2]), x[3]
    k = math.cos(beta)
    conjugate, p = np.empty(4), np.empty(4)
    conjugate[0], conjugate[1], conjugate[2], conjugate[3] = q[0], -q[1], -q[2], -q[3]
    multiply(conjugate, quaternion, p)
    phi0, alpha0, chi0 = end_angles(conjugate[0], conjugate[1], conjugate[2], conjugate[3])
    phi1, alpha1, _ = end_angles(p[0], p[1], p[2], p[3])
    for c in range(4):
        out[c] = q[c]
    out[4], out[5] = root, beta
    s0, s1 = math.sin(0.5 * alpha0), math.sin(0.5 * alpha1)
    out[6] = phi0
    out[7] = math.asinh(math.cos(0.5 * alpha0) * math.cos(x[4]) / max(s0, 1e-30))
    out[8] = x[4]
    out[9] = phi1
    out[10] = math.asinh(math.cos(0.5 * alpha1) * math.cos(x[5]) / max(s1, 1e-30))
    out[11] = x[5]
    out[12], out[13], out[14] = position[0], position[1], position[2]
    out[15], out[16] = s0, s1
    half = 0.5 * k * root
    meeting = 1.0
    if k > 0.0 and half + out[7] > 0.0 and half + out[10] > 0.0:
        meeting = k / math.cosh(min(half + out[7], 700.0)) + k / math.cosh(
            min(half + out[10], 700.0)
        )
    out[17] = meeting
    out[18] = chi0
    m3 = 2.0 * root * math.sin(beta)
    out[19] = phi0 + chi0 + m3 + 2.0 * (x[4] + x[5] - 2.0 * beta) - phi1


@kernel
def tails_apart(tail):
    """Whether the two tails are closed-form exact: they do not feel each other."""
    return tail[17] < _MEETING


@kernel
def tail_loads(tail, f):
    """Loads (6,) at s = 0 in the start frame."""
    root, beta = tail[4], tail[5]
    m = matrix_from_quaternion(tail[:4])
    m3 = 2.0 * root * math.sin(beta)
    # M0 = M3 e + F × ρ0, ρ0 = −(2/√f) sin(α0/2) (cos, sin)(φ0 + δ0)
    a = tail[6] + tail[8]
    size = 2.0 * root * tail[15]
    mx, my = size * math.sin(a), -size * math.cos(a)
    for c in range(3):
        f[c] = root * root * m[c, 2]
        f[3 + c] = mx * m[c, 0] + my * m[c, 1] + m3 * m[c, 2]
    # M·d3(0) is M3; the sum above would lose its digits to the bending moments' size √F
    f[5] = m3


@kernel
def _azimuth(x, beta):
    """The part of φ that the tail turns quickly: atan(cot β tanh X), continuous in X."""
    k, c = math.cos(beta), math.sin(beta)
    if c < 0.0:
        return -math.atan2(k * math.tanh(x), -c)
    return math.atan2(k * math.tanh(x), c)


@kernel
def tail_pose(tail, distance, from_end, pose, moment):
    """Pose (7,) and moment (3,), K30 = 1, at ``distance`` from the start or from the end.

    Everything is seen from the start frame; the frame is the one without the extra spin of
    K30 ≠ 1, counted from s = 0.
    """
    root, beta = tail[4], tail[5]
    f = root * root
    k = math.cos(beta)
    m3 = 2.0 * root * math.sin(beta)
    gamma = k * root
    o = 9 if from_end else 6
    phi_clamp, x0 = tail[o], tail[o + 1]
    x = gamma * distance + x0
    sech = 1.0 / math.cosh(min(abs(x), 700.0))
    tanh, tanh0 = math.tanh(x), math.tanh(x0)
    half_sin = k * sech
    # 1 − k² sech² without cancellation at the top of a loop
    half_cos = math.sqrt(math.sin(beta) ** 2 + (k * tanh) ** 2)
    gained = 0.5 * m3 * distance + _azimuth(x, beta) - _azimuth(x0, beta)
    z = distance - 2.0 * k / root * (tanh - tanh0)
    slope = half_sin / max(half_cos, _TINY)
    sign = 1.0 if from_end else -1.0
    phi = phi_clamp - gained if from_end else phi_clamp + gained
    cn, sn = math.cos(phi), math.sin(phi)
    # offset from the axis: along n and along b = e × n
    along = sign / f * slope * 2.0 * gamma * tanh
    across = -1.0 / f * slope * m3
    ox, oy = along * cn - across * sn, along * sn + across * cn
    # the clamp's own offset, the same formula at X = x0 simplified
    delta = tail[o + 2]
    a = phi_clamp - delta if from_end else phi_clamp + delta
    size = sign * 2.0 / root * tail[16 if from_end else 15]
    dx, dy = ox - size * math.cos(a), oy - size * math.sin(a)
    dz = -z if from_end else z
    m = matrix_from_quaternion(tail[:4])
    for c in range(3):
        base = tail[12 + c] if from_end else 0.0
        pose[c] = base + m[c, 0] * dx + m[c, 1] * dy + m[c, 2] * dz
        # M = M3 e + F × ρ
        moment[c] = -f * oy * m[c, 0] + f * ox * m[c, 1] + m3 * m[c, 2]
    # frame = Q Rz(φ) Ry(θ) Rz(χ); χ gains what φ gains, K30 being 1
    chi = tail[19] - gained if from_end else tail[18] + gained
    total, difference = 0.5 * (phi + chi), 0.5 * (phi - chi)
    q0, q1, q2, q3 = tail[0], tail[1], tail[2], tail[3]
    w, x_, y, z_ = (
        half_cos * math.cos(total),
        -half_sin * math.sin(difference),
        half_sin * math.cos(difference),
        half_cos * math.sin(total),
    )
    pose[3] = q0 * w - q1 * x_ - q2 * y - q3 * z_
    pose[4] = q0 * x_ + q1 * w + q2 * z_ - q3 * y
    pose[5] = q0 * y - q1 * z_ + q2 * w + q3 * x_
    pose[6] = q0 * z_ + q1 * y - q2 * x_ + q3 * w


@kernel
def tail_energy(tail, torsion_ratio):
    """∫ ½(κ² + K30 τ²) ds: f times the shortening, and the twist."""
    root, beta = tail[4], tail[5]
    shortening = (
        2.0
        * root
        * (
            2.0 * math.cos(beta)
            - math.sqrt(max(1.0 - tail[15] ** 2, 0.0)) * math.cos(tail[8])
            - math.sqrt(max(1.0 - tail[16] ** 2, 0.0)) * math.cos(tail[11])
        )
    )
    m3 = 2.0 * root * math.sin(beta)
    return shortening + 0.5 * m3 * m3 / torsion_ratio


@kernel
def _pose_distance(a, b):
    """Largest component of position difference and rotation vector between two poses."""
    vx, vy, vz = rotation_vector(a[3:POSE], b[3:POSE])
    worst = larger(larger(abs(vx), abs(vy)), abs(vz))
    for c in range(3):
        worst = larger(worst, abs(a[c] - b[c]))
    return worst if worst == worst else math.inf


@kernel
def check_tails(tail, quaternion, torsion_ratio, free_spin):
    """Largest error of a tail solution, by integration between points crowded into the layers.

    The closed form is evaluated at the points; the integrator of ``shooting`` is carried from
    each to the next. The tails must also agree where they meet, start at the identity and end at
    the clamping.
    """
    f, pose, ahead = np.empty(6), np.empty(POSE), np.empty(POSE)
    moment, moment_ahead = np.empty(3), np.empty(3)
    y, z, k = np.empty(WITH_JACOBIAN), np.empty(WITH_JACOBIAN), np.empty(12 * WITH_JACOBIAN)
    m = matrix_from_quaternion(tail[:4])
    root = tail[4]
    gamma = math.cos(tail[5]) * root
    for c in range(3):
        f[c] = root * root * m[c, 2]
    identity = np.zeros(POSE)
    identity[3] = 1.0
    tail_pose(tail, 0.0, False, pose, moment)
    worst = _pose_distance(pose, identity)
    for from_end in (False, True):
        x0 = tail[10] if from_end else tail[7]
        depth = min(0.5, max(38.0 - x0, 1.0) / gamma)
        count = 1 + int(depth * gamma / 0.8)
        step = depth / count
        tail_pose(tail, 0.0, from_end, pose, moment)
        for i in range(count):
            tail_pose(tail, (i + 1) * step, from_end, ahead, moment_ahead)
            # march goes along the chain: start from whichever comes first
            first, second, at_first = pose, ahead, moment
            if from_end:
                first, second, at_first = ahead, pose, moment_ahead
            for c in range(3):
                f[3 + c] = at_first[c]
                y[c] = 0.0
            for c in range(4):
                y[3 + c] = first[3 + c]
            march(f, y, step, 1 + int(2.2 * 2.0 * root * step), POSE, k, z)
            for c in range(3):
                y[c] += first[c]
            worst = larger(worst, _pose_distance(y, second))
            for c in range(POSE):
                pose[c] = ahead[c]
            for c in range(3):
                moment[c] = moment_ahead[c]
    tail_pose(tail, 0.5, False, pose, moment)
    tail_pose(tail, 0.5, True, ahead, moment)
    worst = larger(worst, _pose_distance(pose, ahead))
    tail_pose(tail, 0.0, True, pose, moment)
    spin(pose[3:POSE], 2.0 * root * math.sin(tail[5]) * (1.0 / torsion_ratio - 1.0))
    if free_spin:
        tx, ty, tz = tangent(pose[3:POSE])
        cx, cy, cz = tangent(quaternion)
        return larger(worst, max(abs(tx - cx), abs(ty - cy), abs(tz - cz)))
    for c in range(4):
        ahead[3 + c] = quaternion[c]
    for c in range(3):
        ahead[c] = pose[c]
    return larger(worst, _pose_distance(pose, ahead))


@driver
def solve_tails(
    position, quaternion, gap, torsion_ratio, free_spin, turns, side0, side1, tail
):  # fmt: skip
    """Two tails from the planar start; ``tail`` (20,) is the solution if True is returned.

    ``turns`` are added to the end-to-end turn in [−π, π); a ``side`` takes that end's tail over
    the other side first.
    """
    root, ex, ey, ez = planar_start(position, quaternion, gap, side0, side1)
    if root < _SLACK:
        return False
    q0, x = np.empty(4), np.zeros(6)
    align(ex, ey, ez, q0)
    reference = end_turn(quaternion, q0) + 2.0 * math.pi * turns
    x[2] = math.log(root)
    # a large ratio is approached from one that lets the twist in
    ratio = min(torsion_ratio, _MAX_RATIO)
    if not free_spin:
        # a tail over the other side brings half a turn of its own on either side
        asked = reference - (2.0 * math.pi if side0 else 0.0) - (2.0 * math.pi if side1 else 0.0)
        sine = 0.5 * ratio * asked / root
        x[3] = math.asin(min(max(sine, -0.64), 0.64))
    x[4] = math.pi if side0 else 0.0
    x[5] = math.pi if side1 else 0.0
    while True:
        if not tail_newton(x, q0, position, quaternion, gap, ratio, free_spin, reference, tail):
            return False
        if ratio == torsion_ratio:
            return True
        ratio = min(1.5 * ratio, torsion_ratio)


@kernel
def sample_tails(tail, torsion_ratio, s):
    """Poses (n, 7) at arc lengths ``s`` (n,), with the extra spin of K30 ≠ 1."""
    out, moment = np.empty((s.shape[0], POSE)), np.empty(3)
    excess = 2.0 * tail[4] * math.sin(tail[5]) * (1.0 / torsion_ratio - 1.0)
    for i in range(s.shape[0]):
        from_end = s[i] > 0.5
        tail_pose(tail, 1.0 - s[i] if from_end else s[i], from_end, out[i], moment)
        spin(out[i, 3:], excess * s[i])
    return out
