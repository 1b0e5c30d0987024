"""Coverage and sharpness of expected errors."""

import numpy as np
import pytest

from loopelastica.studies.coverage import coverage, weighted_quantiles


def test_shares_are_counted_by_weight():
    error = np.array([0.5, 1.5, 2.5, 9.0])
    expected = np.tile([1.0, 2.0, 4.0], (4, 1))
    one = coverage(error, expected, np.array([1.0, 1.0, 1.0, 2.0]))
    assert one.cases == 5.0
    assert (one.inside, one.below_10, one.below_50, one.below_90) == (0.4, 0.2, 0.4, 0.6)
    assert one.ratio == 4.0
    assert one.quarters_A == ()


def test_quarters_are_by_what_was_expected_the_most_certain_first(rng):
    middle = np.arange(1.0, 101.0)
    order = rng.permutation(100)
    expected = np.stack([0.5 * middle, middle, 2.0 * middle], axis=1)[order]
    one = coverage(3.0 * middle[order], expected, np.ones(100))
    np.testing.assert_allclose(one.quarters_A, [39.0, 114.0, 189.0, 264.0], atol=2.0)


def test_errors_drawn_from_what_is_expected_are_covered_as_said(rng):
    """80 % of log-normal errors lie within their own 10 and 90 %."""
    middle = np.exp(rng.normal(size=20_000))
    expected = middle[:, None] * np.exp(0.7 * np.array([-1.2816, 0.0, 1.2816]))
    error = middle * np.exp(0.7 * rng.normal(size=20_000))
    one = coverage(error, expected, rng.random(20_000))
    assert one.inside == pytest.approx(0.8, abs=0.015)
    assert one.below_50 == pytest.approx(0.5, abs=0.015)
    assert one.ratio == pytest.approx(np.exp(2 * 0.7 * 1.2816), rel=1e-6)


def test_an_interval_that_begins_at_zero_has_a_ratio():
    one = coverage(np.array([0.1]), np.array([[0.0, 0.1, 0.5]]), np.ones(1))
    assert np.isfinite(one.ratio)
    assert one.inside == 1.0


def test_weighted_quantiles_are_those_of_repeated_values(rng):
    values, times = rng.normal(size=40), rng.integers(1, 9, 40)
    found = weighted_quantiles(values, times.astype(float), [0.1, 0.5, 0.9])
    many = np.quantile(np.repeat(values, 50 * times), [0.1, 0.5, 0.9])
    np.testing.assert_allclose(found, many, atol=0.15)
    assert weighted_quantiles(np.array([3.0]), np.ones(1), [0.1, 0.9]).tolist() == [3.0, 3.0]
