"""The curves against the constants that src/model.h of the program has written out, rounded."""

import numpy as np
import pytest

from loopelastica.nanostructures.oxdna import potentials as f


def parabola(curve, at, depth=1.0):
    """b and c of b (x − c)² through two points of a curve near `at`, on its smoothed side."""
    x = np.array(at)
    root = np.sqrt(np.abs(curve(x) / depth))
    slope = (root[1] - root[0]) / (x[1] - x[0])
    return np.sign(curve(x)[0]) * slope**2, x[0] - root[0] / slope


@pytest.mark.parametrize(
    ("curve", "low", "high", "b_low", "c_low", "b_high", "c_high", "depth"),
    [
        (f.HYDROGEN, (0.30, 0.32), (0.72, 0.75), -126.243, 0.276908, -7.87708, 0.783775, 1),
        (f.STACKING, (0.26, 0.30), (0.80, 0.90), -68.1857, 0.23239, -3.12992, 0.956, 1),
        (f.CROSS, (0.46, 0.48), (0.66, 0.68), -0.888889, 0.45, -0.888889, 0.7, 47.5),
        (f.COAXIAL, (0.19, 0.21), (0.59, 0.60), -2.13158, 0.177778, -2.13158, 0.6222222, 58.5),
    ],
)
def test_wells_are_smoothed_as_in_the_program(
    curve, low, high, b_low, c_low, b_high, c_high, depth
):
    np.testing.assert_allclose(parabola(curve, low, depth), (b_low, c_low), rtol=1e-5)
    np.testing.assert_allclose(parabola(curve, high, depth), (b_high, c_high), rtol=1e-5)
    assert curve.range == pytest.approx(c_high, rel=1e-5)


@pytest.mark.parametrize(
    ("curve", "b", "c"),
    [
        (f.BACKBONE_BACKBONE, 892.016223343, 0.711879214356),
        (f.BASE_BASE, 4119.70450017, 0.335388426126),
        (f.BACKBONE_BASE, 1707.30627298, 0.52329943261),
    ],
)
def test_repulsions_are_smoothed_as_in_the_program(curve, b, c):
    at = curve.high + (c - curve.high) * np.array([0.2, 0.6])
    np.testing.assert_allclose(parabola(curve, at, 2.0), (b, c), rtol=1e-9)


@pytest.mark.parametrize(
    ("curve", "b", "c"),
    [
        (f.HYDROGEN_1_2_3, 4.16038, 0.952381),
        (f.HYDROGEN_4, 0.133855, 3.10559),
        (f.HYDROGEN_7_8, 17.0526, 0.555556),
        (f.STACKING_4, 6.4381, 0.961538),
        (f.STACKING_5_6, 3.89361, 1.16959),
        (f.CROSS_1, 7.00545, 0.766284),
        (f.CROSS_2_3, 6.2469, 0.865052),
        (f.CROSS_4, 2.59556, 1.02564),
        (f.COAXIAL_1, 10.9032, 0.769231),
        (f.STACKING_SIDE, 10.9032, -0.769231),
    ],
)
def test_angles_are_smoothed_as_in_the_program(curve, b, c):
    if isinstance(curve, f.Side):
        found = parabola(curve, curve.plain + (c - curve.plain) * np.array([0.2, 0.6]))
    else:
        at = curve.plain + (c - curve.plain) * np.array([0.2, 0.6])
        found = parabola(lambda x: curve.at(curve.optimum + x), at)
    np.testing.assert_allclose(found, (b, c), rtol=2e-5)


@pytest.mark.parametrize(
    "curve",
    [f.HYDROGEN, f.STACKING, f.CROSS, f.COAXIAL, f.BACKBONE_BACKBONE, f.Screened.of(0.1, 0.5)],
)
def test_curves_and_their_slopes_have_no_jump(curve):
    x = np.linspace(0.3, 1.1 * curve.range, 20001)
    slope = np.gradient(curve(x), x)
    assert np.abs(np.diff(slope)).max() < 0.01 * np.abs(slope).max()
    assert (curve(x[x > curve.range]) == 0).all()


def test_a_screened_charge_reaches_further_in_less_salt():
    assert f.Screened.of(0.1, 0.1).range > 2 * f.Screened.of(0.1, 0.5).range


def test_two_sites_in_one_place_have_a_finite_energy():
    for curve in (f.BACKBONE_BACKBONE, f.Screened.of(0.1, 0.5)):
        assert np.isfinite(curve(np.zeros(1))).all()
