"""Arguments of wrong types are refused in one line that names them."""

import math
from fractions import Fraction

import numpy as np
import pytest

from loopelastica._checks import (
    array,
    between,
    file_name,
    flag,
    numbers,
    one_of,
    optional,
    positive,
    shown,
    text,
    texts,
    whole,
)

ODD = [
    None, "1", b"1", [1], (), {}, object, True, np.True_, math.nan, math.inf, -math.inf, 1j,
    10**400, -(10**400), np.array(1.0), np.arange(100.0), np.array([1j]), np.ma.masked,
    np.ma.masked_array([1.0], [True]), np.datetime64("2020"), np.float64("nan"),
]  # fmt: skip
CHECKS = [positive, between(0.0, 0.3), whole(0), whole(-1000), numbers(0.0, 0.3)]


@pytest.mark.parametrize("check", CHECKS)
@pytest.mark.parametrize("value", ODD, ids=lambda v: repr(v)[:20])
def test_what_is_no_number_in_range_is_refused_in_one_line(check, value):
    with pytest.raises(ValueError, match="`argument`") as caught:
        check("argument", value)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 200


@pytest.mark.parametrize("check", [text, texts, flag, file_name, one_of("a", "b")])
@pytest.mark.parametrize("value", [None, 1.5, np.arange(100.0), 10**400], ids=str)
def test_other_kinds_are_refused_in_one_line_too(check, value):
    with pytest.raises(ValueError, match="`argument`") as caught:
        check("argument", value)
    assert "\n" not in str(caught.value)


def test_numbers_of_any_library_are_taken():
    for value in (2, 2.0, np.int64(2), np.float32(2), Fraction(2)):
        assert whole(1)("n", value) == positive("x", value) == 2
        assert type(whole(1)("n", value)) is int
    assert optional(whole(1))("n", None) is None
    assert numbers(0.0, 1.0)("x", np.array([0.0, 0.5])) == (0.0, 0.5)


@pytest.mark.parametrize(
    "value",
    [
        *(None, "x", b"1", object, {}, [True], [[1.0], [1.0, 2.0]], [1j], [10**400], ["1"]),
        *(np.array([1.0 + 0j]), np.ma.masked_array([1.0, 2.0], [False, True]), np.ma.masked),
        np.ma.masked_array([1.0, 2.0]),
        np.array(["2020"], dtype="datetime64[Y]"),
    ],
    ids=lambda v: repr(v)[:20],
)
def test_what_is_no_array_of_real_numbers_is_refused(value):
    with pytest.raises(ValueError, match="`argument`") as caught:
        array("argument", value)
    assert "\n" not in str(caught.value)


def test_arrays_come_as_copies():
    given = np.arange(3)
    taken = array("x", given)
    taken[0] = 7.0
    assert (given[0], taken.dtype) == (0, np.float64)


class Unspeakable:
    def __repr__(self):
        raise RuntimeError


def test_values_are_shown_in_one_line():
    assert "\n" not in shown(np.zeros((50, 50)))
    assert shown("two\nlines") == r"'two\nlines'"
    assert "Unspeakable" in shown(Unspeakable())


def test_what_cannot_be_shown_is_refused_all_the_same():
    with pytest.raises(ValueError, match="`some`"):
        positive("some", Unspeakable())


def test_one_of_some_texts_is_itself_and_any_other_names_them():
    assert one_of("default", "energy")("rank", "energy") == "energy"
    with pytest.raises(ValueError, match=r"^`rank` is 'Energy'; it must be 'default' or 'energy'$"):
        one_of("default", "energy")("rank", "Energy")


def test_the_name_of_a_file_is_a_path_or_a_text(tmp_path):
    assert file_name("like", tmp_path / "a b.pdb") == str(tmp_path / "a b.pdb")
    assert file_name("like", "a.pdb:A.4-A.9") == "a.pdb:A.4-A.9"
    for nothing in ("", " ", "a\0b"):
        with pytest.raises(ValueError, match=r"^`like` is .*; it must be the name of a file$"):
            file_name("like", nothing)
