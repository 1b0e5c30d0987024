"""Names that others chose."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from loopelastica._names import printable, safe_name, safe_stem


@pytest.mark.parametrize(
    "name", ["A6-9", "_6-9", "AA12-15B", "B-5--2", "é7-9", "A-26-9", "2KOC_v2"]
)
def test_usual_names_stay_as_they_are(name):
    assert safe_name(name) == name


@pytest.mark.parametrize(
    "name", ["/../../", "..", ".", "", "-rf", "a b", "a\nb", "=1+1", "~", "a\0b"]
)
def test_no_name_leads_out_of_its_folder_or_hides_or_is_an_option(name):
    safe = safe_name(name)
    assert safe
    assert not safe.startswith((".", "-"))
    assert ".." not in safe
    assert not set(safe) & set("/\\ \n\0=;'\"$~")


@given(st.text(max_size=400), st.integers(10, 80))
def test_every_text_has_a_safe_name_of_bounded_length_that_is_its_own(text, most):
    safe = safe_name(text, most)
    assert 0 < len(safe.encode()) <= most
    assert safe_name(safe, most) == safe


def test_of_a_long_name_both_ends_stay():
    assert safe_name("A" * 300 + "6-9").endswith("A6-9")


@pytest.mark.parametrize(
    ("name", "stem"),
    [("2koc.pdb", "2koc"), ("2koc.cif.gz", "2koc"), ("a;b.pdb", "a_b"), (".pdb", "_pdb")],
)
def test_stems_of_files(tmp_path, name, stem):
    assert safe_stem(tmp_path / name) == stem


@given(st.text(st.characters(), max_size=40))
def test_whatever_is_printed_is_one_line_that_any_utf8_file_can_hold(text):
    shown = printable(text)
    assert shown.isprintable()
    assert len(shown.encode().splitlines()) <= 1


def test_what_cannot_be_seen_is_an_escape():
    assert printable("a\nb\x1b[2J \u202e \udcff é") == r"a\nb\x1b[2J \u202e \udcff é"
