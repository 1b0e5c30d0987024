"""Arguments that several public functions of the rod take."""

import math

import numpy as np
import pytest

from loopelastica.rod._arguments import arc_lengths, check_loads, check_torsion_ratio


@pytest.mark.parametrize("value", [0.0, -1.0, math.inf, math.nan])
def test_a_torsion_ratio_is_positive_and_finite(value):
    with pytest.raises(ValueError, match="`torsion_ratio` is"):
        check_torsion_ratio(value)
    assert check_torsion_ratio(np.float32(0.5)) == 0.5


@pytest.mark.parametrize("loads", [np.ones(5), np.ones((6, 1)), [0, 0, 0, 0, 0, math.nan]])
def test_loads_are_six_finite_numbers(loads):
    with pytest.raises(ValueError, match="`loads` must be six"):
        check_loads(loads)


@pytest.mark.parametrize(
    "odd",
    [["x"] * 6, [1j] * 6, None, [True] * 6, np.ma.masked_array(np.ones(6), [True, *[False] * 5])],
)
def test_what_are_no_real_numbers_are_neither_loads_nor_arc_lengths(odd):
    with pytest.raises(ValueError, match="`loads`"):
        check_loads(odd)
    with pytest.raises(ValueError, match="`n`"):
        arc_lengths(odd)


def test_truth_is_no_number_of_points():
    with pytest.raises(ValueError, match="`n` is True"):
        arc_lengths(True)


def test_checked_loads_are_a_copy():
    given = np.arange(6.0)
    check_loads(given)[0] = 7.0
    assert given[0] == 0.0


def test_points_are_equally_spaced_with_both_ends():
    assert arc_lengths(5).tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert arc_lengths(np.int64(2)).tolist() == [0.0, 1.0]
    assert arc_lengths(1).tolist() == [0.0]


def test_given_arc_lengths_keep_their_order_and_are_copied():
    given = np.array([1.0, 0.0, 0.3, 0.9])[::2]
    found = arc_lengths(given)
    assert found.tolist() == [1.0, 0.3]
    assert found.flags.c_contiguous
    found[0] = 0.5
    assert given[0] == 1.0


@pytest.mark.parametrize(
    ("n", "why"),
    [
        (0, "at least 1"),
        (0.5, "one-dimensional"),
        ([[0.1]], "one-dimensional"),
        ([0.0, 1.5], "outside"),
        ([-1e-9], "outside"),
        ([math.nan], "outside"),
    ],
)
def test_what_are_no_arc_lengths_is_refused(n, why):
    with pytest.raises(ValueError, match=f"`n` .*{why}"):
        arc_lengths(n)


def test_a_caller_may_need_both_ends():
    with pytest.raises(ValueError, match="`n` is 1; it must be at least 2"):
        arc_lengths(1, least=2)
