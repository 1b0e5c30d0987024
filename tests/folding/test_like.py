"""The structure that a user names as a template, and why it may be none."""

import os

import gapped
import numpy as np
import pytest

import loopelastica as le
from loopelastica.errors import StructureError
from loopelastica.folding.like import check_loops, file_of, loop_templates, strand_templates
from loopelastica.molecule.entry import read_entry
from loopelastica.molecule.gaps import find_gaps
from loopelastica.molecule.nucleotides import Limits

LIMITS = Limits()


@pytest.fixture
def other(tmp_path):
    """The eighth model of 2KOC."""
    return gapped.pdb(tmp_path / "other.pdb", gapped.chain(model=8))


def the_gap(path, strand):
    (gap,) = find_gaps(read_entry(path), strands=strand).gaps
    return gap


def names(templates):
    return [template.name for template in templates]


@pytest.mark.parametrize("pair", ["", ":A.5-A.10", ":A.5-10", ":5-10", ":A.10-A.5", ":A.C5-A.G10"])
def test_a_loop_by_its_closing_pair_or_any(other, pair):
    assert names(loop_templates(f"{other}{pair}", 4, LIMITS)) == ["like other A.5-A.10"]


def test_where_the_numbers_differ_by_one_the_line_is_respaced(other):
    for n in (3, 5):
        (one,) = loop_templates(str(other), n, LIMITS)
        assert one.name == f"like other A.5-A.10, 4 → {n} nucleotides"
        assert (len(one), one.nucleotides) == (n, ())
    assert loop_templates(str(other), 6, LIMITS) == ()


@pytest.mark.parametrize("text", ["{}:5-10", "{}:_5-10", "{}:_.5-_.10", "{}"])
def test_a_chain_without_a_name(tmp_path, text):
    path = gapped.pdb(tmp_path / "bare.pdb", gapped.chain(name=""))
    assert names(loop_templates(text.format(path), 4, LIMITS)) == ["like bare 5-10"]


def test_insertion_codes(tmp_path):
    places = [*((k, "") for k in range(1, 5)), *((5, code) for code in "ABCDEF"),
              *((k, "") for k in range(6, 10))]  # fmt: skip
    path = gapped.pdb(tmp_path / "codes.pdb", gapped.chain(places=places))
    (one,) = loop_templates(f"{path}:A.5A-A.5F", 4, LIMITS)
    assert one.name == "like codes A.5A-A.5F"


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("{}:A.5-A.44", r"other\.pdb: there is no nucleotide A\.44; no loop A\.5-A\.44"),
        ("{}:B.5-B.10", r"other\.pdb: there is no nucleotide B\.5, the chains are A"),
        ("{}:A.6-A.9", r"other\.pdb: A\.6-A\.9 closes no hairpin loop; .* are A\.5-A\.10"),
        ("nowhere.pdb", r"nowhere\.pdb: there is no such file"),
        ("nowhere.pdb:A.5-A.10", r"nowhere\.pdb: there is no such file"),
    ],
)
def test_what_is_no_template_is_said(other, text, sentence):
    with pytest.raises(StructureError, match=sentence):
        loop_templates(text.format(other), 4, LIMITS)


def test_a_file_without_a_hairpin(tmp_path):
    path = gapped.pdb(tmp_path / "half.pdb", gapped.chain(gone=range(7, 15)))
    with pytest.raises(StructureError, match=r"half\.pdb: no hairpin loop"):
        loop_templates(str(path), 4, LIMITS)


def test_a_loop_that_lacks_atoms(tmp_path):
    path = gapped.pdb(tmp_path / "lacking.pdb", gapped.chain(gone={(7, "O5'")}))
    with pytest.raises(StructureError, match=r"lacking\.pdb: A\.C5–A\.G10: backbone atoms"):
        loop_templates(str(path), 4, LIMITS)


def test_a_file_that_changes_is_read_again(other):
    before = loop_templates(str(other), 4, LIMITS)[0].shape
    gapped.pdb(other, gapped.chain(model=3))
    os.utime(other, ns=(1, 1))
    after = loop_templates(str(other), 4, LIMITS)[0].shape
    assert not np.allclose(before.steps_A, after.steps_A, atol=0.01)


def test_no_loop_fits_says_both_lengths(other, koc):
    (hairpin,) = le.find_hairpins(koc)
    check_loops(str(other), [hairpin], LIMITS)
    check_loops(str(other), [], LIMITS)
    with pytest.raises(StructureError, match=r"its loop has 4 nucleotides, .* like it 6, 9"):
        check_loops(str(other), [range(9), range(6)], LIMITS)


def test_a_named_strand_need_be_no_hairpin(other, tmp_path):
    here = gapped.pdb(tmp_path / "here.pdb", gapped.chain())
    gap = the_gap(here, "A.2-4")
    assert names(strand_templates(f"{other}:A.1-A.5", gap, LIMITS)) == ["like other A.1-A.5"]
    assert names(strand_templates(f"{other}:A.1-A.4", gap, LIMITS)) == [
        "like other A.1-A.4, 2 → 3 nucleotides"
    ]
    assert strand_templates(f"{other}:A.5-A.10", the_gap(here, "A.2-3"), LIMITS) == ()


def test_without_a_pair_the_same_letters_are_found_wherever_they_are(other, tmp_path):
    here = gapped.pdb(tmp_path / "here.pdb", gapped.chain())
    assert names(strand_templates(str(other), the_gap(here, "A.2-4"), LIMITS)) == [
        "like other A.1-A.5"
    ]
    # G9 and G10, and the two at the beginning that have nothing before them
    twice = strand_templates(str(other), the_gap(here, "A.9-10"), LIMITS)
    assert names(twice) == ["like other A.8-A.11"]


def test_other_letters_are_those_of_hairpin_loops_that_fit_the_ends(other, tmp_path):
    here = gapped.pdb(tmp_path / "here.pdb", gapped.chain())
    loop = strand_templates(str(other), the_gap(here, "A.6-9=GAAA"), LIMITS)
    assert names(loop) == ["like other A.5-A.10"]
    assert strand_templates(str(other), the_gap(here, "A.2-5=AAAA"), LIMITS) == ()


def test_the_file_of_a_template(other):
    assert file_of(None) is None
    assert file_of(f"{other}:A.5-A.10") == str(other)
