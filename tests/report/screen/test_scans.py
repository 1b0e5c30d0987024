"""Scans on the screen."""

import pytest

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.report.screen.scans import scan_screen


@pytest.fixture(scope="module")
def scanned():
    (loop,) = le.scan(data_path("hairpins/2koc.pdb"), extend_5_max=1, extend_3_max=1)
    return loop


def test_a_scan_shows_as_many_shapes_as_are_wanted(shown, scanned):
    text = shown(*scan_screen(scanned, 3))
    ranks = [line.split()[0] for line in text.splitlines() if line[:4].strip(" *").isdecimal()]
    assert ranks[:3] == ["1", "2", "3*"]
    assert f"3 of {len(scanned.candidates)} shapes" in text
    assert f"{scanned.candidates[0].candidate.rmsd_A:.2f}" in text
    assert text.startswith("A.C5–A.G10  CUUCGG  4 nt")


def test_the_file_is_named_where_there_are_several(shown, scanned):
    assert shown(*scan_screen(scanned, 1, "a.pdb")).startswith("a.pdb  A.C5–A.G10")
