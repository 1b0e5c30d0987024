"""The closed form of the rod against an independent integration of the equilibrium equations.

The oracle shares nothing with the closed form: roots of the cubic to 60 digits by mpmath for the
state at s = 0, then Taylor series of order 24 for r' = t, t' = M × t, d1' = M × d1.
"""

import math

import mpmath
import numpy as np
import pytest
from numba import njit

from loopelastica.rod.kernels import closed_form, cubic, finite_rod
from loopelastica.rod.kernels.rotations import zyz_angles

ORDER = 24


@njit(cache=True)
def taylor(y, lam, length):
    """State (r, t, d1) after `length` (of either sign); steps of 0.2 over the largest rate."""
    y = y.copy()
    c = np.zeros((ORDER + 1, 9))
    moment = np.zeros((ORDER + 1, 3))
    done = 0.0
    while done < abs(length):
        rate = math.sqrt(lam * lam + y[0] ** 2 + y[1] ** 2)
        h = min(0.2 / max(1.0, rate), abs(length) - done)
        if abs(length) - done - h < 1e-14 * abs(length):
            h = abs(length) - done
        c[0] = y
        for k in range(ORDER):
            moment[k, 0] = -c[k, 1]
            moment[k, 1] = c[k, 0]
            moment[k, 2] = lam if k == 0 else 0.0
            for i in range(3):
                c[k + 1, i] = c[k, 3 + i] / (k + 1)
            for v in (3, 6):
                for i in range(3):
                    p, q = (i + 1) % 3, (i + 2) % 3
                    total = 0.0
                    for j in range(k + 1):
                        total += moment[j, p] * c[k - j, v + q] - moment[j, q] * c[k - j, v + p]
                    c[k + 1, v + i] = total / (k + 1)
        y = c[ORDER].copy()
        step = math.copysign(h, length)
        for k in range(ORDER - 1, -1, -1):
            y = y * step + c[k]
        done += h
    return y


def exact_roots(lam, t_p, a):
    """z1 ≥ z2 ≥ z3 of (a − 2z)(1 − z²) − (t_P − λz)², to 60 digits."""
    with mpmath.workdps(60):
        lam, t_p, a = mpmath.mpf(lam), mpmath.mpf(t_p), mpmath.mpf(a)
        p, q, r = (a + lam**2) / 2, lam * t_p - 1, (t_p**2 - a) / 2  # z³ − p z² + q z − r
        spread = max((p**2 - 3 * q) / 9, mpmath.mpf(0))
        skew = (-2 * p**3 + 9 * p * q - 27 * r) / 54
        size = mpmath.sqrt(spread)
        angle = mpmath.acos(max(-1, min(1, skew / size**3))) if size > 0 else mpmath.mpf(0)
        third = 2 * mpmath.pi / 3
        return sorted(
            (p / 3 - 2 * size * mpmath.cos(angle / 3 + k * third) for k in (-1, 0, 1)), reverse=True
        )


def start_state(lam, t_p, a, phi0):
    """(r, t, d1) at s = 0 in Landau's frame (eq. 8), frame by standard ZYZ Euler angles."""
    with mpmath.workdps(60):
        z3 = max(exact_roots(lam, t_p, a)[2], mpmath.mpf(-1))
        rho = mpmath.sqrt(max(mpmath.mpf(a) - 2 * z3, 0))
        side = float(mpmath.sqrt(max(1 - z3**2, mpmath.mpf(0))))
        sign = 1.0 if lam + t_p >= 0 else -1.0
        rho, z3 = float(rho), float(z3)
    psi = 0.5 * math.pi * sign
    sp, cp = sign, 0.0
    assert math.isclose(math.sin(psi), sp)
    sf, cf = math.sin(phi0), math.cos(phi0)
    d1 = [cp * z3 * cf - sp * sf, sp * z3 * cf + cp * sf, -side * cf]
    return np.array([rho, 0.0, 0.0, 0.0, sign * side, z3, *d1])


def frame_of(y):
    return np.column_stack([y[6:9], np.cross(y[3:6], y[6:9]), y[3:6]])


def about_z(angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def integrated(lam, t_p, a, phi0, s_ini, length, torsion_ratio=1.0):
    """Relative end pose by integration: position over length, rotation."""
    start = taylor(start_state(lam, t_p, a, phi0), lam, s_ini)
    end = taylor(start, lam, length)
    spin = t_p * (1.0 / torsion_ratio - 1.0)
    first = frame_of(start) @ about_z(spin * s_ini)
    last = frame_of(end) @ about_z(spin * (s_ini + length))
    return first.T @ (end[:3] - start[:3]) / length, first.T @ last


def error(p, torsion_ratio=1.0):
    position, rotation = integrated(*p, torsion_ratio)
    line, frames = finite_rod.rod_along(*p, torsion_ratio, np.ones(1))
    return max(np.abs(line[0] - position).max(), np.abs(frames[0] - rotation).max())


def random_parameters(rng, lam=None, t_p=None, excess=None):
    """p over the whole domain: |λ|, |t_P| ≤ 10, a − a_Min from 1e-3 to 100, up to four periods."""
    lam = rng.uniform(-10, 10) * rng.choice([1.0, 0.2]) if lam is None else lam
    t_p = rng.uniform(-10, 10) * rng.choice([1.0, 0.2]) if t_p is None else t_p
    if excess is None:
        excess = rng.uniform(0, 100) if rng.random() < 0.5 else 10 ** rng.uniform(-3, 2)
    a = cubic.a_min(lam, t_p) + excess
    period = closed_form.period(lam, t_p, a)
    if not math.isfinite(period):
        period = 5.0
    return (
        lam, t_p, a, rng.uniform(0, 2 * math.pi), rng.uniform(0, period),
        rng.uniform(0.02, 4.0) * period,
    )  # fmt: skip


@pytest.mark.slow
def test_agrees_with_integration_on_random_rods_of_up_to_four_periods():
    rng = np.random.default_rng(11)
    assert max(error(random_parameters(rng)) for _ in range(400)) < 1e-10


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("distance", [0.0, 1e-14, -1e-10, 1e-8, -1e-6])
def test_nothing_happens_near_t_p_equal_to_plus_or_minus_lam(sign, distance):
    rng = np.random.default_rng(12)
    worst = 0.0
    for _ in range(25):
        lam = rng.uniform(-4, 4)
        worst = max(worst, error(random_parameters(rng, lam=lam, t_p=sign * lam + distance)))
    assert worst < 1e-8


@pytest.mark.parametrize("excess", [1e-13, 1e-10, 1e-8, 1e-6])
def test_nothing_happens_near_the_least_a(excess):
    rng = np.random.default_rng(13)
    assert max(error(random_parameters(rng, excess=excess)) for _ in range(40)) < 1e-8


@pytest.mark.parametrize("shift", [1e-3, 1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_nearly_homoclinic_rods(shift, side):
    rng = np.random.default_rng(14)
    for _ in range(10):
        lam = rng.uniform(-1.9, 1.9)
        p = (lam, lam, 2.0 + side * shift, rng.uniform(0, 6), rng.uniform(-4, 2), 6.0)
        assert error(p) < 1e-9


def test_the_homoclinic_rod_itself_and_its_neighbors_are_continuous():
    for lam in (0.3, 0.7, -1.6):  # λ + t_P keeps its sign
        p = (lam, lam, 2.0, 1.0, -3.0, 7.0)
        assert math.isinf(closed_form.period(*p[:3]))
        assert error(p) < 1e-11
        line, frames = finite_rod.rod_along(*p, 1.0, np.linspace(0, 1, 9))
        for da, dt in ((1e-9, 0.0), (-1e-9, 0.0), (1e-9, 1e-9), (0.0, -1e-9)):
            q = (lam, lam + dt, max(2.0 + da, cubic.a_min(lam, lam + dt)), *p[3:])
            near_line, near_frames = finite_rod.rod_along(*q, 1.0, np.linspace(0, 1, 9))
            assert np.abs(near_line - line).max() < 2e-6
            assert np.abs(near_frames - frames).max() < 2e-6


def test_planar_rods_stay_in_their_plane_and_agree():
    rng = np.random.default_rng(15)
    for _ in range(40):
        a = -2.0 + 10 ** rng.uniform(-3, 1.3)
        p = (0.0, 0.0, a, 0.0, rng.uniform(-3, 3), rng.uniform(0.1, 12.0))
        assert error(p) < 1e-11
        line, _ = finite_rod.rod_along(*p, 1.0, np.linspace(0, 1, 20))
        assert np.abs(line[:, 0]).max() < 1e-14  # the plane of d2, d3


def test_ends_where_the_distance_to_the_axis_vanishes():
    rng = np.random.default_rng(16)
    for _ in range(40):
        lam = rng.uniform(-3, 3)
        a = rng.uniform(3, 20)
        p = (lam, 0.5 * lam * a, a, 0.3, rng.uniform(0, 1), rng.uniform(0.5, 6.0))
        if a > cubic.a_min(p[0], p[1]) + 1e-3:
            assert error(p) < 1e-10


def test_torsion_ratio_only_spins_the_frame():
    rng = np.random.default_rng(17)
    assert max(error(random_parameters(rng), 0.7) for _ in range(50)) < 1e-10


def test_frame_and_moment_obey_their_first_integrals_over_many_periods():
    rng = np.random.default_rng(18)
    for _ in range(30):
        lam, t_p, a, phi0, _, _ = random_parameters(rng)
        c, scale = closed_form.constants(lam, t_p, a)
        for s in rng.uniform(-200, 200, 5):
            q0, q1, q2, q3, x, y, _ = closed_form.landau_pose(s, phi0, 0.0, c, scale)
            assert abs(q0**2 + q1**2 + q2**2 + q3**2 - 1) < 1e-14
            t = np.array([2 * (q1 * q3 + q0 * q2), 2 * (q2 * q3 - q0 * q1),
                          q0**2 + q3**2 - q1**2 - q2**2])  # fmt: skip
            moment = np.array(closed_form.landau_moment(x, y, lam))
            size = 1 + moment @ moment
            assert abs(moment @ t - t_p) < 3e-12 * size  # 100 periods: 1e-14 of phase each
            assert abs(2 * t[2] + x * x + y * y - a) < 1e-13 * size
            psi, theta, phi = zyz_angles(q0, q1, q2, q3)
            assert np.allclose(t[:2], np.sin(theta) * np.array([np.cos(psi), np.sin(psi)]))
            d1 = about_z(psi)[:, 0] * np.cos(theta) * np.cos(phi) + about_z(psi)[:, 1] * np.sin(phi)
            assert abs(d1[0] - (1 - 2 * (q2**2 + q3**2))) < 1e-12


def test_roots_keep_their_digits_next_to_every_double_root():
    rng = np.random.default_rng(19)
    for _ in range(200):
        gap = 10 ** rng.uniform(-12, 0)
        lam = rng.uniform(-3, 3)
        kind = rng.integers(3)
        if kind == 0:  # homoclinic
            lam, t_p, a = lam * 0.6, lam * 0.6 + gap * rng.normal(), 2.0 + gap
        elif kind == 1:
            t_p = rng.uniform(-3, 3)
            a = cubic.a_min(lam, t_p) + gap
        else:
            t_p, a = -lam + gap, -2.0 + 4 * gap**0.5
        if a <= cubic.a_min(lam, t_p):
            continue
        z1, z2, z3 = exact_roots(lam, t_p, a)
        with mpmath.workdps(60):
            exact = (
                1 + z1, 1 + z3, z1 - 1, 1 - z2, a - 2 * z1, a - 2 * z2, a - 2 * z3, z1 - z2,
                z1 - z3, z2 - z3,
            )  # fmt: skip
            found = cubic.roots(lam, t_p, a)
            for value, reference in zip(found, exact, strict=True):
                assert abs(value - reference) <= 1e-13 * abs(reference) + 1e-26


def test_least_a_is_where_the_two_largest_roots_meet():
    rng = np.random.default_rng(20)
    for _ in range(300):
        lam, t_p = rng.uniform(-10, 10, 2)
        if rng.random() < 0.3:
            t_p = rng.choice([-lam, lam]) + rng.choice([0.0, 1e-3, 1e-7, -1e-12])
        with mpmath.workdps(40):
            z = np.linspace(-1, 1, 20001)[1:-1]
            h = 2 * z + (t_p - lam * z) ** 2 / (1 - z * z)
        least = cubic.a_min(lam, t_p)
        assert least <= h.min() + 1e-12
        assert least > h.min() - 2e-3 * (1 + abs(lam))
        above = cubic.roots(lam, t_p, least + 1e-3)
        assert above[9] > 0.0
        assert cubic.roots(lam, t_p, least)[9] < 1e-5 * (1 + abs(lam))


@pytest.mark.parametrize(("lam", "t_p", "sign"), [(3.0, 3.0, 1), (2.0, 2.0, 1), (1.0, -1.0, -1),
                                                  (0.0, 0.0, -1)])  # fmt: skip
def test_straight_rods_are_helices_of_radius_zero(lam, t_p, sign):
    a = cubic.a_min(lam, t_p)
    assert a == 2.0 * sign
    line, frames = finite_rod.rod_along(lam, t_p, a, 0.4, 0.0, 2.0, 1.0, np.array([0.5, 1.0]))
    assert np.allclose(line, [[0, 0, 0.5], [0, 0, 1]], atol=1e-15)
    assert np.allclose(frames[1], about_z(2.0 * t_p), atol=1e-14)
