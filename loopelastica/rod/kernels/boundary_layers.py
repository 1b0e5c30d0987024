"""The stiff limit: a rod under high tension is two homoclinic boundary layers, in closed form.

With e = F/|F|, f = |F|, γ = k√f large, the rod is straight along e but for a boundary layer of
width 1/√f at each end. There the angle θ between tangent and e obeys
½θ'² + ½M3² tan²(θ/2) = f (1 − cos θ), the motion homoclinic to the straight twisted rod, so that
with sin β = M3/(2√f) and k = cos β

    sin(θ/2) = k sech X,     X = γ s + x0,     φ' = M3/(1 + cos θ),     χ' = φ' + M3 (1/K30 − 1)

in the ZYZ angles (φ, θ, χ) about e. What is left out is the meeting of the layers, of order
exp(−γ/2); it is computed and must be below 2e-12.

End i has the angle α_i to e. Its layer is given by δ_i, cos(α_i/2) sin δ_i = sin β: |δ_i| < π/2
goes straight to the axis, δ_i near π first over the other side. Then sinh x0_i =
cot(α_i/2) cos δ_i and all that the end pose needs is elementary: the layer shortens the rod by
(2/√f)(cos β − cos(α_i/2) cos δ_i), gains the azimuth δ_i − β and leaves the clamp
(2/√f) sin(α_i/2) off the axis. Six equations for (two tilts of e, ln √f, β, δ0, δ1) follow and are
solved by Newton's method; no differential equation is left.

With a free end spin M3 = 0, and β = 0 takes the place of the twist equation.

A solution is a record of `records.LAYERS`; it determines the rod where loads alone no longer do,
errors of which grow like exp √f. What it says of the rod is in ``layer_poses``.
"""

import math

import numpy as np

from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.linalg import eliminate
from loopelastica.rod.kernels.rotations import (
    align,
    end_turn,
    matrix_from_quaternion,
    multiply,
    relative,
    tangent,
    zyz_angles,
)

_TOLERANCE = 2e-12
_TINY = 1e-300
# largest torsion ratio that is solved at once
MAX_RATIO = 8.0
# √F below which no layer ends before the middle
_LEAST_ROOT = 10.0


@kernel
def _tilted(q0, u, v, out):
    """Q0 turned by the rotation vector (u, v, 0) of its own frame."""
    a = math.sqrt(u * u + v * v)
    s = math.sin(0.5 * a) / a if a > 1e-8 else 0.5
    step = np.empty(4)
    step[0], step[1], step[2], step[3] = math.cos(0.5 * a), s * u, s * v, 0.0
    multiply(q0, step, out)


@kernel
def _equations(problem, torsion_ratio, x, q0, reference, e, q, p):
    """The six residuals ``e`` at x = (tilts, ln √f, β, δ0, δ1); Q goes into ``q``.

    ``reference`` is the end-to-end turn φ + χ that this solution is meant to have (2π n included);
    ``torsion_ratio`` takes the place of the problem's; p (4,) is scratch. Returns √f.
    """
    position, shortening = problem.position, problem.shortening
    _tilted(q0, x[0], x[1], q)
    root = math.exp(x[2])
    beta = x[3]
    phi0, alpha0, chi0 = zyz_angles(q[0], -q[1], -q[2], -q[3])
    relative(q, problem.quaternion, p)
    phi1, alpha1, chi1 = zyz_angles(p[0], p[1], p[2], p[3])
    c0, s0 = math.cos(0.5 * alpha0), math.sin(0.5 * alpha0)
    c1, s1 = math.cos(0.5 * alpha1), math.sin(0.5 * alpha1)
    m = matrix_from_quaternion(q)
    rx = m[0, 0] * position[0] + m[1, 0] * position[1] + m[2, 0] * position[2]
    ry = m[0, 1] * position[0] + m[1, 1] * position[1] + m[2, 1] * position[2]
    a0, a1 = phi0 + x[4], phi1 - x[5]
    scale = 2.0 / root
    e[0] = scale * (s0 * math.cos(a0) + s1 * math.cos(a1)) - rx
    e[1] = scale * (s0 * math.sin(a0) + s1 * math.sin(a1)) - ry
    shortened = scale * (_shortens(beta, c0, s0, x[4]) + _shortens(beta, c1, s1, x[5]))
    # |r| − r_z without cancellation, r_x and r_y being small
    length = 1.0 - shortening
    lean = (rx * rx + ry * ry) / (
        length + m[0, 2] * position[0] + m[1, 2] * position[1] + m[2, 2] * position[2]
    )
    e[2] = shortening + lean - shortened
    if problem.free_spin:
        e[3] = beta
    else:
        turn = phi1 + chi1 - phi0 - chi0
        turn += 2.0 * math.pi * round((reference - turn) / (2.0 * math.pi))
        twist = 2.0 * root * math.sin(beta) / torsion_ratio
        e[3] = twist + 2.0 * (x[4] + x[5] - 2.0 * beta) - turn
    e[4] = c0 * math.sin(x[4]) - math.sin(beta)
    e[5] = c1 * math.sin(x[5]) - math.sin(beta)
    # layers that are thin compared with the length hide in an absolute position error
    return root


@kernel
def _shortens(beta, half_cos, half_sine, delta):
    """The difference cos β − cos(α/2) cos δ, by which an end shortens the rod, in units of 2/√f.

    For a layer that goes straight to the axis it is small, and the same as sin²(α/2) over the sum,
    by cos(α/2) sin δ = sin β; the difference would be lost before Newton's method has that equation
    right.
    """
    total = math.cos(beta) + half_cos * math.cos(delta)
    if math.cos(delta) > 0.0 and total > 0.5:
        return half_sine * half_sine / total
    return math.cos(beta) - half_cos * math.cos(delta)


@kernel
def _weight(root):
    """Position errors count in units of the layers' width, as far as rounding lets them."""
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
def planar_start(problem, over_0, over_1):
    """First guess of the axis and of √f: planar layers (β = 0), by fixed-point rounds.

    Returns (√f, ex, ey, ez), √f = 0 where no tension pulls the ends this far apart.
    """
    position, quaternion, shortening = problem.position, problem.quaternion, problem.shortening
    length = 1.0 - shortening
    norm = max(math.sqrt(position[0] ** 2 + position[1] ** 2 + position[2] ** 2), _TINY)
    ex, ey, ez = position[0] / norm, position[1] / norm, position[2] / norm
    tx, ty, tz = tangent(quaternion)
    root = 0.0
    sign0 = -1.0 if over_0 else 1.0
    sign1 = -1.0 if over_1 else 1.0
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
        constant = -shortening * (1.0 + length)
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
def _fill(problem, x, q, layers):
    """The solution x about the axis of ``q``, into ``layers``."""
    root, beta = math.exp(x[2]), x[3]
    k = math.cos(beta)
    p = np.empty(4)
    relative(q, problem.quaternion, p)
    phi0, alpha0, chi0 = zyz_angles(q[0], -q[1], -q[2], -q[3])
    phi1, alpha1, _ = zyz_angles(p[0], p[1], p[2], p[3])
    layers.axis_w, layers.axis_x, layers.axis_y, layers.axis_z = q[0], q[1], q[2], q[3]
    layers.root, layers.beta = root, beta
    s0, s1 = math.sin(0.5 * alpha0), math.sin(0.5 * alpha1)
    x0 = math.asinh(math.cos(0.5 * alpha0) * math.cos(x[4]) / max(s0, 1e-30))
    x1 = math.asinh(math.cos(0.5 * alpha1) * math.cos(x[5]) / max(s1, 1e-30))
    layers.phi_0, layers.x_0, layers.delta_0, layers.half_sine_0 = phi0, x0, x[4], s0
    layers.phi_1, layers.x_1, layers.delta_1, layers.half_sine_1 = phi1, x1, x[5], s1
    position = problem.position
    layers.end_x, layers.end_y, layers.end_z = position[0], position[1], position[2]
    half = 0.5 * k * root
    meeting = 1.0
    if k > 0.0 and half + x0 > 0.0 and half + x1 > 0.0:
        meeting = k / math.cosh(min(half + x0, 700.0)) + k / math.cosh(min(half + x1, 700.0))
    layers.meeting = meeting
    layers.chi_0 = chi0
    m3 = 2.0 * root * math.sin(beta)
    layers.chi_1 = phi0 + chi0 + m3 + 2.0 * (x[4] + x[5] - 2.0 * beta) - phi1


@kernel
def layers_newton(problem, torsion_ratio, x, q0, reference, layers):
    """Newton from x = (0, 0, ln √f, β, δ0, δ1) about the axis frame ``q0``.

    ``torsion_ratio`` takes the place of the problem's. True if the equations are solved; ``layers``
    is then the solution (see `layer_poses.layers_apart`).
    """
    e, trial_e, weighted = np.empty(6), np.empty(6), np.empty(6)
    system, trial = np.empty((6, 7)), np.empty(6)
    q, p = np.empty(4), np.empty(4)
    caps = (0.3, 0.3, 0.5, 0.3, 0.5, 0.5)
    root = _equations(problem, torsion_ratio, x, q0, reference, e, q, p)
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
            _equations(problem, torsion_ratio, trial, q0, reference, trial_e, q, p)
            for c in range(6):
                system[c, j] = (trial_e[c] - e[c]) / h * (_weight(root) if c < 3 else 1.0)
        for c in range(6):
            system[c, 6] = -weighted[c]
        if eliminate(system, 6, 6, 7, 1e-14) == 0.0:
            return False
        d = system[:, 6]
        for i in range(5, -1, -1):
            for j in range(i + 1, 6):
                d[i] -= system[i, j] * d[j]
            d[i] /= system[i, i]
        shrink = 1.0
        for c in range(6):
            shrink = min(shrink, caps[c] / max(abs(d[c]), _TINY))
        improved = False
        for _ in range(8):
            for c in range(6):
                trial[c] = x[c] + shrink * d[c]
            trial_root = _equations(problem, torsion_ratio, trial, q0, reference, trial_e, q, p)
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
    _equations(problem, torsion_ratio, x, q0, reference, e, q, p)
    _weighted(e, root, weighted)
    if not cost < 1e-10 or not x[2] < 50.0:
        return False
    _fill(problem, x, q, layers)
    return True


@kernel
def solve_layers(problem, start, layers):
    """Two boundary layers from the planar start; True if ``layers`` is a solution.

    The start's turns are added to the end-to-end turn in [−π, π); an end that goes ``over`` takes
    its layer over the other side first.
    """
    root, ex, ey, ez = planar_start(problem, start.over_0, start.over_1)
    if root < _LEAST_ROOT:
        return False
    q0, x = np.empty(4), np.zeros(6)
    align(ex, ey, ez, q0)
    reference = end_turn(problem.quaternion, q0) + 2.0 * math.pi * start.turns
    x[2] = math.log(root)
    # a large ratio is approached from one that lets the twist in
    ratio = min(problem.torsion_ratio, MAX_RATIO)
    if not problem.free_spin:
        # a layer over the other side brings half a turn of its own on either side
        turn = reference
        if start.over_0:
            turn -= 2.0 * math.pi
        if start.over_1:
            turn -= 2.0 * math.pi
        x[3] = math.asin(min(max(0.5 * ratio * turn / root, -0.64), 0.64))
    # where the angles at the ends are small so are their sines
    x[4] = math.pi - x[3] if start.over_0 else x[3]
    x[5] = math.pi - x[3] if start.over_1 else x[3]
    while True:
        if not layers_newton(problem, ratio, x, q0, reference, layers):
            return False
        if ratio == problem.torsion_ratio:
            return True
        ratio = min(1.5 * ratio, problem.torsion_ratio)
