"""Numbers for nucleotides that a file gives none."""

from __future__ import annotations

import pytest

from loopelastica.molecule.numbering import NO_CODE, free_places
from loopelastica.molecule.polymer import Monomer


def at(number, icode=""):
    return Monomer("A", number, icode, "G", "G", False)


@pytest.mark.parametrize(
    ("before", "after", "n", "used", "expected"),
    [
        (at(5), at(10), 4, (), "6 7 8 9"),
        (at(-3), at(1), 3, (), "-2 -1 0"),
        (at(5), at(10), 2, (), "6 7"),
        (at(5), at(7), 3, (), "6 6A 6B"),
        (at(5), at(6), 2, (), "5A 5B"),
        (at(5, "B"), at(6), 2, (), "5C 5D"),
        (at(5), at(10), 4, [(7, "")], "6 8 9 9A"),
        (at(5), at(6), 2, [(5, "A")], "5B 5C"),
        (at(9), at(3), 2, (), "9A 9B"),
        (None, at(3), 3, (), "0 1 2"),
        (at(3), None, 2, (), "4 5"),
        (None, None, 2, (), "1 2"),
    ],
)
def test_numbers_are_where_they_have_room(before, after, n, used, expected):
    places, sentence = free_places("A", before, after, n, set(used))
    assert " ".join(f"{number}{icode}" for number, icode in places) == expected
    agree = None in (before, after) or after.number - before.number - 1 == n
    assert (sentence == "") == (agree and not used)
    assert len(set(places)) == n
    assert not set(places) & set(used)


def test_where_no_insertion_codes_are_left():
    places, _ = free_places("A", at(5), at(6), 28, set())
    assert [icode for _, icode in places[-3:]] == ["Z", NO_CODE, NO_CODE]
