"""Options are understood when they are given, not when they are used."""

import pytest

from loopelastica.filling.options import FillOptions


def test_the_defaults_are_those_of_the_contract():
    options = FillOptions()
    assert options.strands is None
    assert options.repair is False
    assert options.candidates == 1


@pytest.mark.parametrize(
    ("given", "kept"),
    [
        (None, None),
        ([], ()),
        ("A.6-9", ("A.6-9",)),
        ("A.6-9=UUCG", ("A.6-9=UUCG",)),
        (["A.6-9=UUCG", "B.-3=A"], ("A.6-9=UUCG", "B.-3=A")),
    ],
)
def test_strands_are_kept_as_they_were_written(given, kept):
    assert FillOptions(strands=given).strands == kept
    # what a table of a run keeps leads to the same options
    again = FillOptions(**FillOptions(strands=given).to_dict())
    assert again.to_dict() == FillOptions(strands=given).to_dict()


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("strands", value) for value in (5, [5], "", "hello", "A.6-9=", "A.6-9=UUXG")),
        *(("strands", value) for value in ("A.9-6", ["A.6-8", "A.8-9"])),
        *(("candidates", value) for value in (0, -1, 1.5, "2", True)),
        *(("repair", value) for value in (1, "yes", None)),
        ("max_atoms", 0),
        ("max_size_MB", -1.0),
    ],
)
def test_what_cannot_be_meant_is_refused_by_its_name(name, value):
    with pytest.raises(ValueError, match=f"`{name}`") as caught:
        FillOptions(**{name: value})
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "first", "last"),
    [("A.6-A.9", "A.6", "A.9"), ("A.6B-9", "A.6B", "A.9"), ("A.6B-8C=UU", "A.6B", "A.8C")],
)
def test_both_ends_may_have_a_chain_or_an_insertion_code(text, first, last):
    from loopelastica.molecule.requests import requests

    (request,) = requests(text)
    assert (str(request.first), str(request.last)) == (first, last)
