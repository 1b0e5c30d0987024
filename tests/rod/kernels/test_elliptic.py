"""Elliptic functions against scipy.special and mpmath."""

import math

import mpmath
import numpy as np
import pytest
from scipy import special

from loopelastica.rod.kernels import elliptic

# (m, 1 − m), the smaller one exact
NEAR_ENDS = [1e-200, 1e-30, 1e-16, 1e-12, 1e-8, 1e-4, 0.1, 0.3]
PARAMETERS = [(0.5, 0.5)] + [(e, 1 - e) for e in NEAR_ENDS] + [(1 - e, e) for e in NEAR_ENDS]


def exact(m, m1):
    return 1 - mpmath.mpf(m1) if m1 < m else mpmath.mpf(m)


def digits(m, m1):
    return mpmath.workdps(230 if min(m, m1) < 1e-50 else 60)


def complete(m, m1):
    """K and 1 − E/K."""
    return elliptic.complete_from_scale(*elliptic.agm_scale(m, m1))


def test_complete_integrals_agree_with_scipy():
    for m in np.random.default_rng(0).random(200):
        K, missing = complete(m, 1 - m)
        assert abs(K / special.ellipk(m) - 1) < 1e-13
        assert abs(K * (1 - missing) / special.ellipe(m) - 1) < 1e-13


@pytest.mark.parametrize(("m", "m1"), PARAMETERS)
def test_complete_integrals_agree_with_mpmath_near_both_ends(m, m1):
    with digits(m, m1):
        K, missing = complete(m, m1)
        k, e = mpmath.ellipk(exact(m, m1)), mpmath.ellipe(exact(m, m1))
        assert abs(K / k - 1) < 1e-14
        assert abs(missing / (1 - e / k) - 1) < 1e-13


@pytest.mark.parametrize(("m", "m1"), PARAMETERS)
def test_jacobi_functions_agree_with_mpmath(m, m1):
    scale, levels = elliptic.agm_scale(m, m1)
    with digits(m, m1):
        parameter = exact(m, m1)
        k, e = mpmath.ellipk(parameter), mpmath.ellipe(parameter)
        for fraction in (1e-9, 0.2, 0.7, 1 - 1e-6, 1.0, -0.4):
            x = fraction * float(k)
            sn, cn = (mpmath.ellipfun(f, x, m=parameter) for f in ("sn", "cn"))
            zeta = mpmath.ellipe(mpmath.atan2(sn, cn), parameter) - x * e / k
            found = elliptic.jacobi_from_scale(x, scale, levels)
            for value, true in zip(found, (sn, cn, zeta), strict=True):
                assert abs(value - true) < 1e-15 * (8 + abs(x))


def test_at_m_one_they_are_hyperbolic_and_at_m_zero_trigonometric():
    for x in (-3.0, 0.0, 0.5, 20.0, 900.0):
        sn, cn, zeta = elliptic.jacobi_from_scale(x, *elliptic.agm_scale(1.0, 0.0))
        assert sn == zeta == math.tanh(x)
        assert cn == pytest.approx(2 / (math.exp(abs(x)) + math.exp(-abs(x))) if x < 700 else 0)
    for x in (-1.5, 0.0, 0.5):
        found = elliptic.jacobi_from_scale(x, *elliptic.agm_scale(0.0, 1.0))
        assert found == pytest.approx((math.sin(x), math.cos(x), 0.0), abs=1e-15)
    assert complete(1.0, 0.0) == (math.inf, 1.0)


@pytest.mark.parametrize(("m", "m1"), PARAMETERS)
def test_incomplete_integrals_agree_with_mpmath(m, m1):
    with digits(m, m1):
        parameter = exact(m, m1)
        ratio = mpmath.ellipe(parameter) / mpmath.ellipk(parameter)
        for sine, cosine in ((1, 1), (1, 0.1), (1, 1e-7), (1e-9, 1), (1, 1e-14), (-1, 0.2), (1, 0)):
            F, zeta = elliptic.incomplete(float(sine), float(cosine), m, m1)
            phi = mpmath.atan2(mpmath.mpf(sine), mpmath.mpf(cosine))
            f = mpmath.ellipf(phi, parameter)
            assert abs(F / f - 1) < 1e-13
            assert abs(zeta - (mpmath.ellipe(phi, parameter) - ratio * f)) < 1e-14


def test_incomplete_integrals_at_the_ends():
    assert elliptic.incomplete(0.6, 0.8, 0.0, 1.0) == pytest.approx((math.atan(0.75), 0.0))
    assert elliptic.incomplete(3.0, 4.0, 1.0, 0.0) == pytest.approx((math.asinh(0.75), 0.6))
    assert elliptic.incomplete(1.0, 0.0, 1.0, 0.0) == (math.inf, 1.0)
    assert elliptic.incomplete(0.0, 0.0, 0.3, 0.7) == (0.0, 0.0)


@pytest.mark.parametrize("shifted", [False, True])
@pytest.mark.parametrize(("m", "m1"), [p for p in PARAMETERS if p[1] > 1e-9 and p[0] > 1e-17])
def test_phase_of_theta_agrees_with_mpmath(m, m1, shifted):
    K, Kc = complete(m, m1)[0], complete(m1, m)[0]
    with mpmath.workdps(40):
        k, kc = mpmath.ellipk(exact(m, m1)), mpmath.ellipk(1 - exact(m, m1))
        nome = mpmath.exp(-mpmath.pi * kc / k)
        for fraction in (-1, -0.7, -1e-3, 0, 1e-6, 0.3, 1):
            for part in (0, 0.2, 0.7, 1 - 1e-9, 1):
                if part == 1 and abs(fraction) == (1 if shifted else 0):
                    continue  # the zero itself
                x, b = fraction * K, part * Kc
                theta = mpmath.jtheta(3 if shifted else 4, mpmath.mpc(x, b) * mpmath.pi / 2 / k,
                                      nome)  # fmt: skip
                theta *= mpmath.expjpi(x * b / (2 * k * kc))
                found = mpmath.mpc(*elliptic.theta_phase(x, b, K, Kc, shifted))
                miss = abs(found / abs(found) - theta / abs(theta))
                # near the zero the phase is as uncertain as b is; there the modulus is small
                assert miss * min(1, abs(x) / K + 1 - part if not shifted else
                                  abs(K - abs(x)) / K + 1 - part) < 1e-13  # fmt: skip


def test_theta_series_and_its_transform_meet_at_m_one_half():
    K = complete(0.5, 0.5)[0]
    for x in np.linspace(-K, K, 7):
        for b in np.linspace(0, K, 6):
            for shifted in (False, True):
                one = complex(*elliptic.theta_phase(x, b, K, K * (1 + 1e-15), shifted))
                two = complex(*elliptic.theta_phase(x, b, K, K, shifted))
                if abs(one) > 1e-8:
                    assert abs(one / abs(one) - two / abs(two)) < 1e-13


def test_theta_of_a_homoclinic_rod_is_elementary():
    for x in (-2.0, 0.5, 30.0):
        real, imaginary = elliptic.theta_phase(x, 0.8, math.inf, math.pi / 2, False)
        assert imaginary / real == pytest.approx(math.tan(0.8) * math.tanh(x), rel=1e-14)
        assert elliptic.theta_phase(x, 0.8, math.inf, math.pi / 2, True) == (1.0, 0.0)
