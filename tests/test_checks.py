"""Arguments of any kind become their own type, or a sentence of one line that names them."""

import decimal
import math
from pathlib import Path

import numpy as np
import pytest

from loopelastica._checks import array, between, positive, shown, whole

JUNK = (None, "1", "a\nb", b"1", 1j, True, (), [1], np.zeros((9, 9)), math.nan, math.inf, 10**400,
        decimal.Decimal(1), object(), "x" * 10_000, Path("a"), float, lambda: 0)  # fmt: skip


class Unspeakable:
    def __repr__(self):
        raise RuntimeError


@pytest.mark.parametrize("check", [positive, between(0.0, 1.0), whole(1)])
@pytest.mark.parametrize("value", [*JUNK, Unspeakable(), -1])
def test_what_is_no_number_is_named_in_one_short_line(check, value):
    with pytest.raises(ValueError, match="`some`") as caught:
        check("some", value)
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 200


def test_values_are_shown_in_one_line():
    assert "\n" not in shown(np.zeros((50, 50)))
    assert shown("two\nlines") == r"'two\nlines'"
    assert "Unspeakable" in shown(Unspeakable())


@pytest.mark.parametrize(
    "value",
    [
        *([1j], ["a"], [[1], [1, 2]], object(), [10**400], {}),
        np.ma.masked_array([1.0, 2.0], [True, False]),
    ],
)
def test_arrays_of_anything_but_real_numbers_are_refused(value):
    with pytest.raises(ValueError, match=r"`some` is .*array of numbers") as caught:
        array("some", value)
    assert "\n" not in str(caught.value)


def test_an_array_is_a_copy_of_doubles():
    given = np.arange(6, dtype=np.float32).reshape(2, 3).T
    made = array("some", given)
    made[0, 0] = 7
    assert made.dtype == np.float64
    assert made.flags.c_contiguous
    assert given[0, 0] == 0
    assert array("some", np.ma.masked_array([1.0], [False])).tolist() == [1.0]
