"""Newton's method on the loads: the end pose of the rod is driven to the clamping.

Unknown f = (F, M0), residual e = (position error, rotation vector from the clamping's frame to
the rod's), Jacobian exact (``shooting``). With a free end spin only the direction of the end
tangent counts; its error is u_i = 2 t·d_i/(1 + t·d3), i = 1, 2 (stereographic: smooth, zero at
alignment only), and the sixth equation is M3 = 0.

Far from the solution the step is Levenberg's and Marquardt's, (JᵀJ + ν S) d = −Jᵀe, with S the
natural scales of force and moment and ν updated by Nielsen's rule from the ratio of actual to
predicted decrease; it stays defined where J is singular (folds; ends on one line, where every
solution belongs to a circle of solutions). Once the error is small, steps with the last Jacobian
follow on a finer mesh, by elimination with complete pivoting that leaves out null directions. The
loads are then judged by a mesh that the iteration did not use: only that residual is reported.
"""

import math

import numpy as np

from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.linalg import solve_deficient
from loopelastica.rod.kernels.records import Status
from loopelastica.rod.kernels.rotations import (
    directors,
    larger,
    log_jacobian_inverse,
    rotation_vector,
    tangent,
)
from loopelastica.rod.kernels.shooting import POSE, WITH_JACOBIAN, moment_bound, shoot, step_count

# plain numbers: compiling an enumeration's members takes longer
CONVERGED, STALLED = int(Status.CONVERGED), int(Status.STALLED)
TOO_MANY_ITERATIONS, TOO_STIFF = int(Status.TOO_MANY_ITERATIONS), int(Status.TOO_STIFF)
CHECK_FAILED = int(Status.CHECK_FAILED)

# steps per radian of turning: while searching and while refining; largest mesh errors over loads up
# to |F| = 60, |M| = 12 are 2e-4, 1e-7 and 1e-9, their medians 1e-5, 2e-9 and 3e-11
_COARSE, _MEDIUM, _FINE, _CHECK = 0.45, 1.4, 2.5, 4.0
# the coarse mesh is trusted down to here
_SWITCH = 1e-3
# steps with its last Jacobian, and the error from which one more is expected to be the last
_CHORDS, _NEAR = 8, 1e-7
# share of the tolerance above which another step is made
_SURE = 0.3
# relative size of a pivot that is rounding
_DROP = 1e-11
# growth exp(√F) of an error over the length: beyond, loads at one end do not fix the other end
_MAX_RATE = 80.0
# beyond this growth rounding alone exceeds a billionth of the length
_SHOT_RATE = 16.0


@kernel
def end_error(problem, y, m3, e, jacobian, with_jacobian):
    """Residual ``e`` (6,) of the end state ``y`` and, on request, its ``jacobian`` (6, 6)."""
    position, quaternion = problem.position, problem.quaternion
    for c in range(3):
        e[c] = y[c] - position[c]
    if with_jacobian:
        for c in range(3):
            for j in range(6):
                jacobian[c, j] = y[25 + 6 * c + j]
    q = y[3:POSE]
    if problem.free_spin:
        # tangent and target directors
        tx, ty, tz = tangent(q)
        ax, ay, az, bx, by, bz, cx, cy, cz = directors(quaternion)
        t1 = tx * ax + ty * ay + tz * az
        t2 = tx * bx + ty * by + tz * bz
        denominator = max(1.0 + tx * cx + ty * cy + tz * cz, 1e-12)
        e[3] = 2.0 * t1 / denominator
        e[4] = 2.0 * t2 / denominator
        e[5] = m3
        if with_jacobian:
            for j in range(6):
                px, py, pz = y[7 + j], y[13 + j], y[19 + j]
                # δt = δθ × t
                dx, dy, dz = py * tz - pz * ty, pz * tx - px * tz, px * ty - py * tx
                dd = dx * cx + dy * cy + dz * cz
                jacobian[3, j] = (2.0 * (dx * ax + dy * ay + dz * az) - e[3] * dd) / denominator
                jacobian[4, j] = (2.0 * (dx * bx + dy * by + dz * bz) - e[4] * dd) / denominator
                jacobian[5, j] = 0.0
            jacobian[5, 5] = 1.0
        return
    e[3], e[4], e[5] = rotation_vector(q, quaternion)
    if with_jacobian:
        m = log_jacobian_inverse(e[3:])
        for i in range(3):
            for j in range(6):
                jacobian[3 + i, j] = m[i, 0] * y[7 + j] + m[i, 1] * y[13 + j] + m[i, 2] * y[19 + j]


@kernel
def largest(e):
    """Largest component of an error (6,), inf if it is not a number."""
    worst = 0.0
    for c in range(6):
        worst = larger(worst, abs(e[c]))
    return worst if worst == worst else math.inf


@kernel
def squares(e):
    """Sum of the squares of an error (6,)."""
    total = 0.0
    for c in range(6):
        total += e[c] * e[c]
    return total


@kernel
def predicted_decrease(jacobian, e, d):
    """By how much the step ``d`` lowers the squares of the error ``e``, if it were linear."""
    predicted = 0.0
    for c in range(6):
        row = e[c]
        for j in range(6):
            row += jacobian[c, j] * d[j]
        predicted += e[c] * e[c] - row * row
    return predicted


@kernel
def marquardt_step(jacobian, e, scale, nu, a, d):
    """Solve (JᵀJ + ν S²) d = −Jᵀe by Cholesky; ``scale`` (6,) are 1/S. False if not definite."""
    for i in range(6):
        for j in range(i + 1):
            total = 0.0
            for c in range(6):
                total += jacobian[c, i] * jacobian[c, j]
            a[i, j] = total * scale[i] * scale[j]
        a[i, i] += nu
        total = 0.0
        for c in range(6):
            total += jacobian[c, i] * e[c]
        d[i] = -total * scale[i]
    for j in range(6):
        for c in range(j):
            a[j, j] -= a[j, c] * a[j, c]
        if not a[j, j] > 0.0:
            return False
        a[j, j] = math.sqrt(a[j, j])
        for i in range(j + 1, 6):
            for c in range(j):
                a[i, j] -= a[i, c] * a[j, c]
            a[i, j] /= a[j, j]
    for i in range(6):
        for c in range(i):
            d[i] -= a[i, c] * d[c]
        d[i] /= a[i, i]
    for i in range(5, -1, -1):
        for c in range(i + 1, 6):
            d[i] -= a[c, i] * d[c]
        d[i] /= a[i, i]
    for i in range(6):
        d[i] *= scale[i]
    return True


@kernel
def pivoted_step(jacobian, e, scale, drop, d):
    """Newton step d = −J⁻¹e; directions with pivots below ``drop`` stay put."""
    a, x = np.empty((6, 7)), np.empty((1, 6))
    for i in range(6):
        for j in range(6):
            a[i, j] = jacobian[i, j] * scale[j]
        a[i, 6] = -e[i]
    solve_deficient(a, 6, 6, 1, drop, x)
    for i in range(6):
        d[i] = x[0, i] * scale[i]


@kernel
def _scales(f, scale):
    force = max(10.0, math.sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]))
    moment = max(3.0, math.sqrt(f[3] * f[3] + f[4] * f[4] + f[5] * f[5]))
    for c in range(3):
        scale[c] = force
        scale[3 + c] = moment


@kernel
def _search(problem, f, most, y, k, z, e, jacobian):
    """Levenberg–Marquardt on the coarse mesh down to ``_SWITCH``; f, e and jacobian in place.

    Takes ``most`` steps, and more as long as each halves the error. Returns status and iterations.
    """
    a, d, scale = np.empty((6, 6)), np.empty(6), np.empty(6)
    trial, trial_e, trial_jacobian = np.empty(6), np.empty(6), np.empty((6, 6))
    nu, growth = 1e-3, 2.0
    shoot(f, problem.torsion_ratio, step_count(f, _COARSE), WITH_JACOBIAN, y, k, z)
    end_error(problem, y, f[5], e, jacobian, True)
    cost, before = squares(e), math.inf
    iteration = 0
    while iteration < most or cost < 0.25 * before:
        if largest(e) < _SWITCH:
            return CONVERGED, iteration
        iteration += 1
        before = cost
        _scales(f, scale)
        gain = -1.0
        if marquardt_step(jacobian, e, scale, nu, a, d):
            predicted = predicted_decrease(jacobian, e, d)
            for c in range(6):
                trial[c] = f[c] + d[c]
            if problem.free_spin:
                trial[5] = 0.0
            if moment_bound(trial) < _MAX_RATE:
                # most steps are accepted, so the Jacobian comes along
                shoot(
                    trial, problem.torsion_ratio, step_count(trial, _COARSE), WITH_JACOBIAN, y, k, z
                )
                end_error(problem, y, trial[5], trial_e, trial_jacobian, True)
                gain = (cost - squares(trial_e)) / max(predicted, 1e-300)
        if gain > 1e-4:
            slowed = cost - squares(trial_e) < 1e-3 * cost and largest(trial_e) > 100.0 * _SWITCH
            for c in range(6):
                f[c], e[c] = trial[c], trial_e[c]
                for j in range(6):
                    jacobian[c, j] = trial_jacobian[c, j]
            cost = squares(e)
            nu *= max(0.1, 1.0 - (2.0 * gain - 1.0) ** 3)
            growth = 2.0
            if slowed and nu > 1e-2:
                return STALLED, iteration
            continue
        nu *= growth
        growth *= 2.0
        if nu > 1e8:
            return STALLED, iteration
    return TOO_MANY_ITERATIONS, iteration


@kernel
def newton(problem, f, most):
    """Drive the loads ``f`` (6,) to the problem's clamping, in place; ``most`` as in `_search`.

    Returns (status, residual, iterations, y) with the residual of the check mesh and the end
    state (7,) there.
    """
    y, z, k = np.empty(WITH_JACOBIAN), np.empty(WITH_JACOBIAN), np.empty(12 * WITH_JACOBIAN)
    d, scale = np.empty(6), np.empty(6)
    e, jacobian = np.empty(6), np.empty((6, 6))
    if problem.free_spin:
        f[5] = 0.0
    if not moment_bound(f) < _MAX_RATE:
        return TOO_STIFF, math.inf, 0, y[:POSE]
    status, iterations = _search(problem, f, most, y, k, z, e, jacobian)
    if status != CONVERGED:
        return status, largest(e), iterations, y[:POSE]
    # the coarse Jacobian serves for all steps that are left: each gains three digits or more
    worst = largest(e)
    _scales(f, scale)
    for chord in range(_CHORDS):
        # from this near, one step is expected to end it; the mesh that judges it has nodes that the
        # iteration has not seen
        judged = worst < _NEAR
        steps = step_count(f, _FINE if judged or chord > 0 else _MEDIUM)
        if judged:
            steps += steps // 4 + 1 + chord
        pivoted_step(jacobian, e, scale, _DROP, d)
        for c in range(6):
            f[c] += d[c]
        if problem.free_spin:
            f[5] = 0.0
        shoot(f, problem.torsion_ratio, steps, POSE, y, k, z)
        end_error(problem, y, f[5], e, jacobian, False)
        iterations += 1
        previous, worst = worst, largest(e)
        if judged and worst < _SURE * problem.tolerance:
            break
        # the first is seen on another mesh than the search's
        if chord > 0 and not worst < 0.3 * previous:
            break
    status = CONVERGED if judged and worst < problem.tolerance else CHECK_FAILED
    return status, worst, iterations, y[:POSE]


@kernel
def shot_error(problem, f):
    """Largest end error of one shot with the loads ``f`` (6,); inf for too large loads."""
    y, z, k = np.empty(WITH_JACOBIAN), np.empty(WITH_JACOBIAN), np.empty(12 * WITH_JACOBIAN)
    e, jacobian = np.empty(6), np.empty((6, 6))
    if not moment_bound(f) < _SHOT_RATE:
        return math.inf
    shoot(f, problem.torsion_ratio, step_count(f, _CHECK), POSE, y, k, z)
    end_error(problem, y, f[5], e, jacobian, False)
    return largest(e)


@kernel
def elastic_energy(f, position, torsion_ratio):
    """∫ ½(κ² + K30 τ²) ds of the rod with loads ``f`` ending at ``position``.

    The Hamiltonian h = ½|M|² + F·t is constant and ∫ t ds is the end's position, so the integral
    is h − F·r(L), less the twist energy counted at K30 = 1.
    """
    squares = f[3] * f[3] + f[4] * f[4] + f[5] * f[5]
    work = f[0] * position[0] + f[1] * position[1] + f[2] * (position[2] - 1.0)
    return 0.5 * squares - work + 0.5 * f[5] * f[5] * (1.0 / torsion_ratio - 1.0)
