"""Strands that a user names, with and without a sequence."""

from __future__ import annotations

import pytest
from chain_files import SEQUENCE, mmcif_loop, mmcif_sites, numbered, seqres

from loopelastica._files import data_path
from loopelastica.errors import StructureError
from loopelastica.molecule.entry import read_entry
from loopelastica.molecule.gaps import find_gaps
from loopelastica.molecule.requests import requests


def only(found):
    assert found.refused == ()
    (gap,) = found.gaps
    return gap


@pytest.mark.parametrize(
    ("text", "first", "last", "sequence"),
    [
        ("A.6-9", "A.6", "A.9", ""),
        ("A.6-9=UUCG", "A.6", "A.9", "UUCG"),
        ("A.6-A.9 = uu cg", "A.6", "A.9", "UUCG"),
        ("A.6B-9", "A.6B", "A.9", ""),
        ("A.-3-2", "A.-3", "A.2", ""),
        ("N.-17--12=TTATTT", "N.-17", "N.-12", "TTATTT"),
        ("6-9", "6", "9", ""),
        ("RNA1.6-9", "RNA1.6", "RNA1.9", ""),
        ("A.6=U", "A.6", "A.6", "U"),
        ("A.-3", "A.-3", "A.-3", ""),
    ],
)
def test_how_a_strand_is_written(text, first, last, sequence):
    (one,) = requests(text)
    assert (str(one.first), str(one.last), one.sequence) == (first, last, sequence)


@pytest.mark.parametrize(
    "strands",
    [
        *("", "A", "A.", "A.6-9=", "=UUCG", "A.6-9=UU=CG", 7, ["A.6-9", 3], {"A.6-9": 1}),
        *("A.6-9=UXCG", "A.6-9=NNNN", "A.6-9=U-CG", "A.9-6", "A.6-B.9", "A.9-6=UUCG", "x" * 200),
    ],
)
def test_what_is_no_strand_is_one_sentence(strands):
    with pytest.raises(ValueError, match="`strands`") as caught:
        requests(strands)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "strands", [["A.6-9", "A.9-12"], ["A.6-9=UUCG", "A.6-9"], ["A.6-9", "7-8"], ["A.6", "A.6"]]
)
def test_strands_that_overlap(strands):
    with pytest.raises(ValueError, match="overlap"):
        requests(strands)


def test_no_strands_are_all_gaps(entry, lines):
    for strands in (None, (), []):
        assert len(find_gaps(entry(seqres(SEQUENCE), lines()), strands=strands).gaps) == 1


@pytest.mark.parametrize("strand", ["A.6-9", "6-9", "A6-9", "A.U6-G9", "A.6-9=UUCG"])
def test_the_strand_of_a_gap(entry, lines, strand):
    gap = only(find_gaps(entry(seqres(SEQUENCE), lines()), strands=strand))
    assert (gap.name, gap.sequence, gap.given) == ("A.6-9", "UUCG", "=" in strand)
    assert gap.replaces == ()


def test_a_sequence_given_where_the_file_has_none(entry, lines):
    gap = only(find_gaps(entry(lines()), strands="A.6-9=uucg"))
    assert (gap.sequence, gap.given) == ("UUCG", True)
    assert [(one.place, one.resname) for one in gap.monomers] == [
        *(("6", "U"), ("7", "U"), ("8", "C"), ("9", "G"))
    ]
    assert (gap.before.label, gap.after.label) == ("A.C5", "A.G10")


def test_the_users_word_wins_over_the_file(entry, lines):
    gap = only(find_gaps(entry(seqres(SEQUENCE), lines()), strands="A.6-9=GAAA"))
    assert gap.sequence == "GAAA"
    assert "the file has UUCG there; the given sequence is taken" in gap.remarks[0]


def test_only_what_is_named_is_filled(entry, lines):
    found = find_gaps(entry(seqres(SEQUENCE), lines([3, 8])), strands="A.8")
    assert [gap.name for gap in found.gaps] == ["A.8"]


def test_several_strands(entry, lines):
    found = find_gaps(entry(lines([3, 8, 9])), strands=["A.3=C", "A.8-9=CG"])
    assert [(gap.name, gap.sequence) for gap in found.gaps] == [("A.3", "C"), ("A.8-9", "CG")]


def test_a_strand_that_is_there_is_replaced():
    entry = read_entry(data_path("hairpins/2koc.pdb"))
    gap = only(find_gaps(entry, strands="A.6-9"))
    assert (gap.sequence, gap.given) == ("UUCG", False)
    assert [one.label for one in gap.replaces] == ["A.U6", "A.U7", "A.C8", "A.G9"]
    assert all(not one.atoms_A for one in gap.monomers)
    assert all(one.usable for one in gap.replaces)
    changed = only(find_gaps(entry, strands="A.7-8=GA"))
    assert (changed.sequence, len(changed.replaces)) == ("GA", 2)


def test_partial_nucleotides_beside_a_strand_are_part_of_it(entry, lines):
    records = lines(keep=lambda n, atom: n != 10 or atom == "O3'")
    gap = only(find_gaps(entry(records), strands="A.6-9=UUCG"))
    assert (gap.name, gap.sequence) == ("A.6-10", "UUCGG")
    assert gap.remarks[0] == "A.G10 has only O3'; it is part of the gap"


def test_insertion_codes(entry, lines):
    def number(n):
        return f"{n:4d} " if n < 6 else f"{n - 4:4d} "

    gap = only(find_gaps(entry(lines(number=number)), strands="A.5A-5D=UUCG"))
    assert [one.place for one in gap.monomers] == ["5A", "5B", "5C", "5D"]


def test_negative_numbers(entry, lines):
    gap = only(find_gaps(entry(lines(number=lambda n: f"{n - 20:4d} ")), strands="A.-14--11=UUCG"))
    assert (gap.name, gap.before.place, gap.after.place) == ("A.-14--11", "-15", "-10")


def test_a_chain_name_of_several_letters(cif, lines):
    gap = only(find_gaps(cif(mmcif_sites(lines(), chain="RNA1")), strands="RNA1.6-9=UUCG"))
    assert gap.name == "RNA1.6-9"


def test_the_chain_may_be_left_out_where_one_has_the_numbers(entry, lines):
    other = [
        f"{x[:30]}{float(x[30:38]) + 60:8.3f}{x[38:]}"
        for x in lines([], chain="B", number=lambda n: f"{n + 100:4d} ")
    ]
    assert only(find_gaps(entry(lines(), ["TER"], other), strands="6-9=UUCG")).chain == "A"
    same = [f"{x[:21]}B{numbered(x) - 100:4d}{x[26:]}" for x in other]
    with pytest.raises(StructureError, match="name the chain too"):
        find_gaps(entry(lines(), ["TER"], same), strands="6-9=UUCG")


@pytest.mark.parametrize(
    ("strand", "cause"),
    [
        ("B.6-9=UUCG", "there is no chain B"),
        ("A.6-9", "does not say what its nucleotides are"),
        ("A.6-9=UUCGA", "the numbers say 4 nt, and the sequence has 5"),
        ("A.6-9=UUC", "the numbers say 4 nt, and the sequence has 3"),
        ("A.7-8=UC", "A.6 beside it is not in the file"),
        ("A.6-8=UUC", "A.9 beside it is not in the file"),
        ("A.1-3=GGC", "nothing stands on its 5' side"),
        ("A.-3--1=GGC", "no nucleotide on one of its sides"),
        ("A.13-14=CC", "nothing stands on its 3' side"),
        ("A.15-18=CCCC", "no nucleotide on one of its sides"),
        ("A.6-9=TTCG", "T is a base of DNA"),
        ("A.6-9B=UUCGA", "with insertion codes"),
    ],
)
def test_a_strand_that_does_not_fit_the_file(entry, lines, strand, cause):
    with pytest.raises(StructureError) as caught:
        find_gaps(entry(lines()), strands=strand)
    sentence = str(caught.value)
    assert cause in sentence
    assert "\n" not in sentence
    assert strand in sentence


def test_a_strand_of_dna(entry, lines):
    names = {"G": "DG", "C": "DC", "A": "DA", "U": "DU"}
    dna = [f"{x[:17]} {names[x[19]]}{x[20:]}" for x in lines(keep=lambda n, atom: atom != "O2'")]
    gap = only(find_gaps(entry(dna), strands="A.6-9=TTUG"))
    assert [one.resname for one in gap.monomers] == ["DT", "DT", "DU", "DG"]


def test_part_of_a_missing_stretch_is_no_strand(entry, lines):
    with pytest.raises(StructureError, match="is missing too; name the strand"):
        find_gaps(entry(seqres(SEQUENCE), lines()), strands="A.7-8")


def test_strands_side_by_side_have_no_ends(entry, lines):
    with pytest.raises((ValueError, StructureError), match=r"as a whole|beside"):
        find_gaps(entry(lines()), strands=["A.6-7=UU", "A.8-9=CG"])


def test_strands_that_are_each_others_flanks():
    entry = read_entry(data_path("hairpins/2koc.pdb"))
    with pytest.raises(StructureError, match=r"A\.6-7 and A\.8-9 have no nucleotide between"):
        find_gaps(entry, strands=["A.6-7", "A.8-9"])
    assert len(find_gaps(entry, strands=["A.6-7", "A.9-10"]).gaps) == 2


def test_a_strand_that_cannot_be_spanned_is_refused(entry, lines):
    moved = [
        f"{x[:30]}{float(x[30:38]) + 70:8.3f}{x[38:]}" if numbered(x) > 9 else x for x in lines()
    ]
    (refusal,) = find_gaps(entry(moved), strands="A.6-9=UUCG").refused
    assert "4 nt cannot span" in refusal.reason


def test_numbering_that_the_record_explains(cif, lines):
    # 9 is followed by 20, and nothing is missing between: the record says so
    sites = mmcif_sites(
        lines(number=lambda n: f"{n + 10 * (n > 9):4d} "), seq=lambda n: n - 10 * (n > 15)
    )
    poly = mmcif_loop(
        "entity_poly_seq", "entity_id num mon_id", [(1, k, x) for k, x in enumerate(SEQUENCE, 1)]
    )
    assert only(find_gaps(cif(poly, sites), strands="A.6-9=UUCG")).after.place == "20"


def test_two_chains_of_one_name(entry, lines):
    other = [f"{x[:30]}{float(x[30:38]) + 60:8.3f}{x[38:]}" for x in lines()]
    with pytest.raises(StructureError, match="two chains are named A"):
        find_gaps(entry(lines(), ["TER"], other), strands="A.6-9=UUCG")
