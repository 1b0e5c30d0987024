import numpy as np
import pytest
from draws import directions
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

from loopelastica.rod.curves import equal_length_hermite, standard_guesses


def length(points):
    return np.linalg.norm(np.diff(points, axis=0), axis=1).sum()


def test_the_hermite_curve_is_as_long_as_it_should_be_and_a_cubic(rng):
    for t0, t1, ratio in zip(
        directions(rng, 20), directions(rng, 20), rng.uniform(0.1, 0.98, 20), strict=True
    ):
        end = np.array([10.0, 0, 0])
        points = equal_length_hermite([0, 0, 0], t0, end, 3 * t1, 10 / ratio, n=2001)
        assert length(points) == pytest.approx(10 / ratio, rel=1e-4)
        assert np.allclose(points[[0, -1]], [[0, 0, 0], end], atol=1e-9)

        # the same curve by scipy, whose magnitude another way of finding roots gives
        def cubic(m, end=end, t0=t0, t1=t1):
            curve = CubicHermiteSpline([0, 1], [[0, 0, 0], end], [m * t0, m * t1])
            return curve(np.linspace(0, 1, 2000))

        high = next(m for m in np.arange(1, 2000) if length(cubic(m)) > 10 / ratio)
        m = brentq(lambda m, goal=10 / ratio: length(cubic(m)) - goal, high - 1, high)
        gaps = np.linalg.norm(points[::100, None] - cubic(m), axis=2).min(axis=1)
        assert gaps.max() < 2e-3 * 10 / ratio


def test_the_points_of_a_hermite_curve_are_equally_far_apart():
    points = equal_length_hermite([0, 0, 0], [0, 0, 1], [10, 0, 0], [0, 1, -1], 20, n=50)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert steps.max() / steps.min() < 1.02


def test_bends_go_to_eight_sides_of_the_chord_and_are_as_long():
    free = np.zeros((5, 3)) + np.arange(5)[:, None]
    span = [1, 2, 3], [0, 0, 1], [11, 2, 3], [0, 0, -1], 24.0
    guesses = standard_guesses(*span, free_rod=free)
    assert len(guesses) == 10
    assert np.array_equal(guesses[0], free)
    assert all(length(guess) == pytest.approx(24, rel=1e-3) for guess in guesses[1:])
    tops = [guess[len(guess) // 2] - (6, 2, 3) for guess in guesses[2:]]
    angles = np.sort([np.arctan2(z, y) % (2 * np.pi) for _, y, z in tops])
    assert np.allclose(np.diff(angles), np.pi / 4, atol=1e-6)
    assert len(standard_guesses(*span, bends=False)) == 1


def test_impossible_curves_are_refused():
    with pytest.raises(ValueError, match="no curve reaches further than its length"):
        equal_length_hermite([0, 0, 0], [0, 0, 1], [10, 0, 0], [0, 0, 1], 9)
    with pytest.raises(ValueError, match="`n`"):
        equal_length_hermite([0, 0, 0], [0, 0, 1], [10, 0, 0], [0, 0, 1], 12, n=1)
    with pytest.raises(ValueError, match="`free_rod`"):
        standard_guesses([0, 0, 0], [0, 0, 1], [10, 0, 0], [0, 0, 1], 12, free_rod=[1, 2])
    with pytest.raises(ValueError, match="`bends`"):
        standard_guesses([0, 0, 0], [0, 0, 1], [10, 0, 0], [0, 0, 1], 12, bends="few")
