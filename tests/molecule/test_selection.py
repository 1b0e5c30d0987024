"""Pairs and loops named by the user: what is understood, what is found, what is refused."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from loopelastica._files import data_path
from loopelastica.errors import StructureError
from loopelastica.molecule.hairpins import find_hairpins
from loopelastica.molecule.nucleotides import read_structure
from loopelastica.molecule.pairs import dot_bracket
from loopelastica.molecule.selection import Like, bracket_pairs, likeness, two_places


def renumbered(lines: list[str], numbers: dict[int, str]) -> list[str]:
    """Records with other numbers: five characters, the last one the insertion code."""
    return [line[:22] + numbers[int(line[22:26])] + line[27:] for line in lines]


def without(lines: list[str], *numbers: int) -> list[str]:
    return [line for line in lines if int(line[22:26]) not in numbers]


@pytest.mark.parametrize(
    ("text", "first", "second"),
    [
        ("A.12-A.25", ("A", "", 12, ""), ("A", "", 25, "")),
        ("A.13-24", ("A", "", 13, ""), (None, "", 24, "")),
        ("6-9", (None, "", 6, ""), (None, "", 9, "")),
        ("A.DC7–A.DG3^B", ("A", "DC", 7, ""), ("A", "DG", 3, "B")),
        ("A.G30-A.5MC40", ("A", "G", 30, ""), ("A", "5MC", 40, "")),
        ("A.5MC40-A.G30", ("A", "5MC", 40, ""), ("A", "G", 30, "")),
        ("0.H2U16-17", ("0", "H2U", 16, ""), (None, "", 17, "")),
        ("A.-3--1", ("A", "", -3, ""), (None, "", -1, "")),
        ("AB-2.6B-AB-2.9", ("AB-2", "", 6, "B"), ("AB-2", "", 9, "")),
    ],
)
def test_two_places(text, first, second):
    assert two_places("pair", text) == (first, second)


@pytest.mark.parametrize("text", ["", "hello", "A.12", "A.12-", "-", "A.12-A.x", "12..14"])
def test_what_is_no_pair_names_the_argument(text):
    with pytest.raises(ValueError, match="`loop`"):
        two_places("loop", text)


@given(st.integers(0, 2**32 - 1))
def test_brackets_are_read_as_they_are_written(seed):
    rows = np.random.default_rng(seed).permutation(14)[:8].reshape(4, 2)
    pairs = np.array(sorted(np.sort(rows, axis=1).tolist()))
    text = dot_bracket(14, pairs)
    np.testing.assert_array_equal(bracket_pairs(range(14), text), pairs)
    np.testing.assert_array_equal(bracket_pairs(range(14), f"{text[:5]}& {text[5:]}\n"), pairs)


def test_brackets_that_do_not_fit(koc):
    with pytest.raises(ValueError, match=r"'\(' at place 1 is not closed"):
        find_hairpins(koc, dot_bracket="((..)")
    with pytest.raises(ValueError, match=r"'\]' at place 3 closes nothing"):
        find_hairpins(koc, dot_bracket="(.]..)")
    with pytest.raises(StructureError, match=r"2koc.*6 characters for 14 nucleotides"):
        find_hairpins(koc, dot_bracket="((..))")


def test_a_secondary_structure_in_place_of_the_coordinates(koc):
    (hairpin,) = found = find_hairpins(koc, dot_bracket="((((......))))")
    assert hairpin.closing_pair == ("A.A4", "A.U11")
    assert found.dot_bracket == "((((......))))"
    # the one found by the coordinates changes nothing
    (same,) = find_hairpins(koc, dot_bracket=find_hairpins(koc).dot_bracket)
    assert same.name == "A6-9"


def test_a_pair_moves_the_clamp_at_any_length(koc):
    for text in ("A.6-A.9", "A.U6–A.G9", "6-9", "A6-9"):
        (hairpin,) = find_hairpins(koc, pair=text)
        assert (hairpin.name, hairpin.n_pairs) == ("A7-8", 6)
    # one partner each: the pair of the coordinates gives way
    (hairpin,) = found = find_hairpins(koc, pair=["A.5-A.9"])
    assert found.dot_bracket == "(((((...).))))"
    assert hairpin.n_pairs == 1
    # no nucleotide between, no loop
    assert find_hairpins(koc, pair=["A.7-A.8", "A.6-A.9"]) == []


@pytest.mark.parametrize(
    ("pair", "fact"),
    [
        ("A.5-A.99", "no nucleotide A.99"),
        ("B.5-B.10", "no nucleotide B.5"),
        ("A.G5-A.G10", "no nucleotide A.G5"),
        ("A.5-A.5", "pairs with one other only"),
        (["A.5-A.9", "A.5-A.10"], "pairs with one other only"),
    ],
)
def test_a_pair_that_is_not_in_the_file(koc, pair, fact):
    with pytest.raises(StructureError, match=rf"^\S*2koc.pdb: .*{fact}"):
        find_hairpins(koc, pair=pair)


def test_a_loop_by_its_ends_is_the_loop_that_is_found(koc):
    (found,) = find_hairpins(koc)
    for text in ("A.6-9", "A.U6-A.G9", "6-9", "A6-9"):
        (named,) = find_hairpins(koc, loop=text)
        assert named.name == found.name
        np.testing.assert_array_equal(named.loop, found.loop)
        np.testing.assert_array_equal(named.stem_5, found.stem_5)
        assert named.sequence == found.sequence


def test_a_loop_on_what_is_no_pair_says_so(koc):
    (hairpin,) = found = find_hairpins(koc, loop="A.7-8")
    assert (hairpin.closing_pair, hairpin.n_pairs) == (("A.U6", "A.G9"), 6)
    assert "no pair by the coordinates" in found.remarks[0]


@pytest.mark.parametrize("gone", [(6, 7, 8, 9), (7, 8), (6,), (9,)])
def test_a_loop_absent_from_the_file_has_as_many_nucleotides_as_numbers(pdb, koc_lines, gone):
    path = pdb(without(koc_lines, *gone))
    found = find_hairpins(path)
    assert found == []
    assert f"{len(gone)} of its 4 loop nucleotides" in found.remarks[0]
    assert "`loop` A.6-9" in found.remarks[0]
    (hairpin,) = find_hairpins(path, loop="A.6-9")
    assert hairpin.name == "A6-9"
    assert hairpin.resid.tolist() == [6, 7, 8, 9]
    letters = dict(zip(range(6, 10), "UUCG", strict=True))
    assert hairpin.sequence == (
        "C" + "".join("N" if k in gone else letters[k] for k in range(6, 10)) + "G"
    )
    assert [k for k, row in zip(range(6, 10), hairpin.loop, strict=True) if row < 0] == list(gone)
    assert hairpin.stem_5.tolist() == [4, 3, 2, 1, 0]
    assert all((f"A.N{k}" in hairpin.residues) == (k in gone) for k in range(6, 10))


def test_insertion_codes_and_negative_numbers(pdb, koc_lines):
    numbers = {k: f"{k - 8:4d} " for k in range(1, 15)}
    (hairpin,) = find_hairpins(pdb(renumbered(koc_lines, numbers)), loop="A.-2-1")
    assert hairpin.sequence == "CUUCGG"
    numbers = {k: f"{k:4d} " for k in range(1, 15)} | {7: "   6A", 8: "   6B"}
    path = pdb(renumbered(koc_lines, numbers))
    (hairpin,) = find_hairpins(path, loop="A.6-9")
    assert hairpin.residues[1:3] == ("A.U6^A", "A.C6^B")
    (hairpin,) = find_hairpins(path, pair="A.6-A.6B")
    assert hairpin.residues == ("A.U6^A",)


def test_with_insertion_codes_the_numbers_give_no_length(pdb, koc_lines):
    numbers = {k: f"{k:4d} " for k in range(1, 15)} | {7: "   6A", 8: "   6B"}
    lines = [line for line in renumbered(koc_lines, numbers) if line[22:27] != "   6A"]
    with pytest.raises(StructureError, match="do not say how many"):
        find_hairpins(pdb(lines), loop="A.6-9")


@pytest.mark.parametrize(
    ("loop", "fact"),
    [
        ("A.60-90", "no nucleotide A.59"),
        ("B.6-9", "no nucleotide B.5"),
        ("A.6-B.9", "no nucleotide B.10"),
        ("A.1-4", "chain does not go on at A.1"),
        ("A.11-14", "chain does not go on at A.14"),
        ("A.9-6", "5' to 3'"),
        ("A.G6-9", "no nucleotide A.G6"),
    ],
)
def test_a_loop_without_a_stem_is_refused(koc, loop, fact):
    with pytest.raises(StructureError, match=rf"^\S*2koc.pdb: .*{fact}"):
        find_hairpins(koc, loop=loop)


def test_a_number_that_two_strands_share_is_refused(pdb, koc_lines):
    copy = [
        f"{line[:21]} {line[22:30]}{float(line[30:38]) + 40:8.3f}{line[38:]}" for line in koc_lines
    ]
    path = pdb([*[line[:21] + " " + line[22:] for line in koc_lines], "TER", *copy])
    assert [h.name for h in find_hairpins(path)] == ["_6-9", "_6-9"]
    with pytest.raises(StructureError, match="6 may be U6 and U6"):
        find_hairpins(path, loop="6-9")


def test_a_free_nucleotide_is_no_part_of_a_chain(pdb, koc_lines):
    ligand = [
        f"HETATM{line[6:17]}ATP A 101{line[26:30]}{float(line[30:38]) + 9:8.3f}{line[38:]}"
        for line in koc_lines
        if int(line[22:26]) == 6
    ]
    (hairpin,) = find_hairpins(pdb([*koc_lines, *ligand]))
    assert (hairpin.name, hairpin.sequence) == ("A6-9", "CUUCGG")


def test_a_loop_that_lost_a_sugar_is_named(pdb, koc_lines):
    lines = [line for line in koc_lines if line[12:26] != " C1'   U A   7"]
    found = find_hairpins(pdb(lines))
    assert found == []
    assert "A.C5–A.G10: 1 of its 4 loop nucleotides" in found.remarks[0]
    assert len(read_structure(pdb(lines)).nucleotides) == 13


def test_a_chain_that_is_not_there_is_answered_with_those_that_are(koc):
    for named in ({"pair": "X.5-X.10"}, {"loop": "X.6-9"}):
        with pytest.raises(StructureError, match=r"no nucleotide X\.5, the chains are A; "):
            find_hairpins(koc, **named)


@pytest.mark.parametrize(("text", "written"), [("A5-A10", "A.5-A.10"), ("A.5-A10", "A.5-A.10")])
def test_chains_written_like_bases_are_told_the_form(koc, text, written):
    with pytest.raises(ValueError, match=re.escape(f"with chains it is written {written}")):
        find_hairpins(koc, pair=text)


def test_the_name_of_a_hairpin_and_bases_as_they_are_printed_are_understood_still(koc):
    for text in ("A6-9", "U6-G9", "A.U6-A.G9", "A.6-9"):
        (loop,) = find_hairpins(koc, loop=text)
        assert loop.name == "A6-9"


@pytest.mark.parametrize(
    "named",
    [
        *({"pair": "A.5"}, {"loop": ["A.6-9", "x"]}, {"dot_bracket": "(("}, {"dot_bracket": ")"}),
        *({"pair": 5}, {"loop": None}, {"min_loop": 0}, {"max_loop": 2, "min_loop": 3}),
    ],
)
def test_what_cannot_be_understood_is_refused_before_the_file_is_read(named):
    with pytest.raises(ValueError, match=f"`{next(iter(named))}`"):
        find_hairpins("absent.pdb", **named)


def test_brackets_that_do_not_fit_are_told_the_form(koc):
    with pytest.raises(ValueError, match=r"is not closed; it must be like \(\(\(\("):
        find_hairpins(koc, dot_bracket="((((((....)))))")
    with pytest.raises(StructureError, match="3 characters for 14 nucleotides; it needs one for"):
        find_hairpins(koc, dot_bracket="...")


@pytest.mark.parametrize(
    "text",
    ["1" * 5000 + "-2", "A." * 20_000 + "1-2", "a1" * 50_000, "A.1-" + "9" * 40, "x" * 10_000],
)
def test_endless_names_are_refused_at_once_and_in_short(text):
    for argument in ("pair", "loop"):
        with pytest.raises(ValueError, match=f"`{argument}` is ") as caught:
            two_places(argument, text)
        assert len(str(caught.value)) < 200


def test_a_loop_of_a_million_nucleotides_that_are_not_in_the_file_is_refused(tmp_path):
    gemmi = pytest.importorskip("gemmi")
    structure = gemmi.read_pdb(str(data_path("hairpins/2koc.pdb")))
    for model in structure:
        for residue in list(model[0])[9:]:
            residue.seqid.num += 1_000_000_000
        del model[0][7]
    path = tmp_path / "far.cif"
    structure.make_mmcif_document().write_file(str(path))
    with pytest.raises(StructureError, match=r"far\.cif.*more than 1,000 nucleotides"):
        find_hairpins(path, loop="A.6-1000000009")


def test_brackets_by_the_million(koc):
    n = 500_000
    with pytest.raises(StructureError, match="1000000 characters for 14 nucleotides"):
        bracket_pairs(koc.nucleotides, "(" * n + ")" * n)


@pytest.mark.parametrize(
    ("text", "file", "pair"),
    [
        ("1zih.pdb", "1zih.pdb", None),
        ("1zih.pdb:A.4-A.9", "1zih.pdb", "A.4-A.9"),
        ("1zih.pdb:A.4-9", "1zih.pdb", "A.4-9"),
        ("1zih.pdb:4-9", "1zih.pdb", "4-9"),
        ("1zih.pdb:_4-9", "1zih.pdb", "4-9"),
        ("1zih.pdb:_.4-_.9", "1zih.pdb", "4-9"),
        ("1zih.pdb:A.-3-A.2B", "1zih.pdb", "A.-3-A.2B"),
        ("C:\\data\\1zih.pdb", "C:\\data\\1zih.pdb", None),
        ("C:\\data\\1zih.pdb:A.4-A.9", "C:\\data\\1zih.pdb", "A.4-A.9"),
        ("odd:name.pdb", "odd:name.pdb", None),
    ],
)
def test_a_template_is_a_file_and_perhaps_a_pair(text, file, pair):
    assert Like.of("like", text) == (text, file, pair)


def test_a_file_whose_name_ends_like_a_pair_is_that_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("a.pdb:4-9").touch()
    assert Like.of("like", "a.pdb:4-9").pair is None


def test_what_is_behind_the_colon_of_a_file_must_be_a_pair(tmp_path):
    path = tmp_path / "a.pdb"
    path.touch()
    with pytest.raises(ValueError, match=r"`like` .* closing pair"):
        likeness("like", f"{path}:loop")
    for wrong in ("", 3, None):
        with pytest.raises(ValueError, match="`like`"):
            likeness("like", wrong)
