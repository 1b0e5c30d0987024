"""Gaps by the sequence of record: 2KOC with nucleotides taken out, as PDB and as mmCIF."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np
import pytest
from chain_files import SEQUENCE, mmcif_loop, mmcif_sites, numbered, remark_465, seqres

from loopelastica._files import data_path
from loopelastica.errors import StructureError
from loopelastica.molecule.entry import read_entry
from loopelastica.molecule.gaps import find_gaps
from loopelastica.molecule.polymer import Gap
from loopelastica.molecule.refusals import MOST_NUCLEOTIDES, check_span

REAL = Path(__file__).parents[2] / ".." / "shared" / "gaps"
LOOP = remark_465([("U", "A", "6"), ("U", "A", "7"), ("C", "A", "8"), ("G", "A", "9")])


def only(found) -> Gap:
    """The one gap, with nothing refused."""
    assert [one.reason for one in found.refused] == []
    (gap,) = found.gaps
    return gap


def summary(found) -> list[tuple[str, str]]:
    return [(gap.name, gap.sequence) for gap in found.gaps]


# --- PDB ------------------------------------------------------------------------------------------


def test_a_whole_chain_has_no_gap():
    found = find_gaps(read_entry(data_path("hairpins/2koc.pdb")), model=7)
    assert (found.gaps, found.refused, found.tails, found.incomplete) == ((), (), (), ())


@pytest.mark.parametrize("remark", [LOOP, []], ids=["REMARK 465", "SEQRES only"])
def test_a_gap_of_a_pdb_file(entry, lines, remark):
    gap = only(find_gaps(entry(remark, seqres(SEQUENCE), lines())))
    assert (gap.name, gap.sequence, gap.given) == ("A.6-9", "UUCG", False)
    assert (gap.before.label, gap.after.label) == ("A.C5", "A.G10")
    assert (gap.beyond_5.label, gap.beyond_3.label) == ("A.A4", "A.U11")
    assert [one.record for one in gap.monomers] == [6, 7, 8, 9]
    assert all(not one.atoms_A and not one.is_dna for one in gap.monomers)
    assert gap.remarks == gap.replaces == ()


def test_remark_465_alone_is_a_record(entry, lines):
    assert summary(find_gaps(entry(LOOP, lines()))) == [("A.6-9", "UUCG")]


def test_two_gaps_and_both_tails(entry, lines):
    found = find_gaps(entry(seqres(SEQUENCE), lines([1, 2, 5, 6, 9, 14])))
    assert summary(found) == [("A.5-6", "CU"), ("A.9", "G")]
    assert [(t.end, t.first, t.last, t.sequence) for t in found.tails] == [
        ("5'", "1", "2", "GG"),
        ("3'", "14", "14", "C"),
    ]
    assert "3' end is left" in str(found.tails[1])
    assert "5' end are left" in str(found.tails[0])


def test_only_tails_are_no_gap(entry, lines):
    found = find_gaps(entry(seqres(SEQUENCE), lines([1, 2, 13, 14])))
    assert found.gaps == found.refused == ()
    assert len(found.tails) == 2


def test_a_break_decides_where_a_repeated_letter_is_missing(entry, lines):
    # U U C G without the U and C in the middle, and the numbers run on: 1-12
    found = find_gaps(
        entry(seqres(SEQUENCE), lines([7, 8], number=lambda n: f"{n - 2 * (n > 8):4d} "))
    )
    gap = only(found)
    assert (gap.sequence, [one.record for one in gap.monomers]) == ("UC", [7, 8])
    assert len({one.place for one in (*gap.monomers, gap.before, gap.after)}) == 4


def test_numbers_decide_where_letters_and_breaks_leave_a_choice(entry, lines):
    # one U alone between two gaps of U: which one it is only its number tells
    sequence = "GGCAC" + "U" * 7 + "GUGCC"

    def number(n):
        return f"{n if n < 6 else 9 if n == 7 else n + 3:4d} "

    found = find_gaps(entry(seqres(sequence), lines([6, 8, 9], number=number)))
    assert summary(found) == [("A.6-8", "UUU"), ("A.10-12", "UUU")]


def test_numbering_that_jumps_without_anything_missing(entry, lines):
    found = find_gaps(
        entry(seqres(SEQUENCE), lines([], number=lambda n: f"{n + 20 * (n > 7):4d} "))
    )
    assert (found.gaps, found.refused, found.remarks) == ((), (), ())


def test_negative_numbers(entry, lines):
    found = find_gaps(entry(seqres(SEQUENCE), lines(number=lambda n: f"{n - 8:4d} ")))
    assert summary(found) == [("A.-2-1", "UUCG")]


def test_insertion_codes_of_the_record(entry, lines):
    def number(n):
        return f"{n:4d} " if n < 6 else f"{5:4d}{'ABCD'[n - 6]}" if n < 10 else f"{n - 4:4d} "

    rows = [("U", "A", "5A"), ("U", "A", "5B"), ("C", "A", "5C"), ("G", "A", "5D")]
    gap = only(find_gaps(entry(remark_465(rows), seqres(SEQUENCE), lines(number=number))))
    assert gap.name == "A.5A-5D"
    assert gap.after.place == "6"


def test_numbers_are_found_where_the_record_has_none(entry, lines):
    # the numbers leave no room: insertions to the one before; and a remark says so
    found = find_gaps(entry(seqres(SEQUENCE), lines(number=lambda n: f"{n - 3 * (n > 5):4d} ")))
    assert only(found).name == "A.6-6C"
    assert "called 6–6C" in found.remarks[0]


def test_insertions_come_after_those_that_are_there(entry, lines):
    def number(n):
        return f"{n:4d} " if n < 5 else f"{4:4d}A" if n == 5 else f"{n - 5:4d} "

    assert only(find_gaps(entry(seqres(SEQUENCE), lines(number=number)))).name == "A.4B-4E"


def test_dna_and_its_old_names(entry, lines):
    names = {"G": "DG", "C": "DC", "A": "DA", "U": "DU"}

    def without_o2(n, atom):
        return atom != "O2'"

    dna = [f"{x[:17]} {names[x[19]]}{x[20:]}" for x in lines(keep=without_o2)]
    gap = only(find_gaps(entry(seqres(names[x] for x in SEQUENCE), dna)))
    assert [one.resname for one in gap.monomers] == ["DU", "DU", "DC", "DG"]
    assert all(one.is_dna for one in gap.monomers)
    old = only(find_gaps(entry(seqres(SEQUENCE), lines(keep=without_o2))))
    # U is deoxyuridine by no old name: A C G are of the kind that is there
    assert [one.is_dna for one in old.monomers][2:] == [True, True]


def test_a_chain_of_dna_and_rna(cif, lines):
    names = [*SEQUENCE]
    names[4:7] = ["DC", "DT", "DU"]
    there = [
        f"{x[:17]} DC{x[20:]}" if numbered(x) == 5 else x
        for x in lines(keep=lambda n, atom: n != 5 or atom != "O2'")
    ]
    gap = only(find_gaps(cif(poly_seq(names), mmcif_sites(there))))
    assert [(one.letter, one.is_dna) for one in gap.monomers] == [
        *(("T", True), ("U", True), ("C", False), ("G", False))
    ]


def test_a_modified_nucleotide_that_is_missing_is_built_as_its_parent(entry, lines):
    names = [*SEQUENCE]
    names[5:8] = ["PSU", "5MU", "OMC"]
    gap = only(find_gaps(entry(seqres(names), lines())))
    assert gap.sequence == "UUCG"
    assert [one.resname for one in gap.monomers] == ["PSU", "5MU", "OMC", "G"]
    assert gap.remarks == ("A.PSU6 is built as its parent base, U",)


def test_modres_names_the_parent(entry, lines):
    names = [*SEQUENCE]
    names[6] = "X1Y"
    modres = ["MODRES 1ABC X1Y A    7    U  A MODIFIED"]
    assert only(find_gaps(entry(modres, seqres(names), lines()))).sequence == "UUCG"


@pytest.mark.parametrize("name", ["N", "X1Y"])
def test_an_unknown_base_is_refused(entry, lines, name):
    names = [*SEQUENCE]
    names[6] = name
    found = find_gaps(entry(seqres(names), lines()))
    (refusal,) = found.refused
    assert found.gaps == ()
    assert refusal.sequence == "UNCG"
    assert f"A.{name}7 is not known" in refusal.reason


def test_a_modified_nucleotide_that_is_there_matches_its_parent(entry, lines):
    # PSU by name, its record by its parent; HETATM as modified residues are
    there = [f"HETATM{x[6:17]}PSU{x[20:]}" if numbered(x) == 11 else x for x in lines()]
    assert only(find_gaps(entry(seqres(SEQUENCE), there))).name == "A.6-9"


def test_a_modified_nucleotide_listed_behind_the_chain_is_put_in_its_place(entry, lines):
    there = lines()
    behind = [f"HETATM{x[6:17]}PSU{x[20:]}" for x in there if numbered(x) == 11]
    chain = [x for x in there if numbered(x) != 11]
    for record in (seqres(SEQUENCE), LOOP):
        assert summary(find_gaps(entry(record, chain, ["TER"], behind))) == [("A.6-9", "UUCG")]


def test_hetatm_alone_between_two_gaps_is_part_of_the_chain(entry, lines):
    names = [*SEQUENCE]
    names[6] = "PSU"
    there = [f"HETATM{x[6:17]}PSU{x[20:]}" if numbered(x) == 7 else x for x in lines([6, 8, 9])]
    assert summary(find_gaps(entry(seqres(names), there))) == [("A.6", "U"), ("A.8-9", "CG")]


def test_waters_and_ligands_of_the_chain_do_not_count(entry, lines):
    ligand = [
        f"HETATM{x[6:17]}AMP A 101 {x[27:30]}{100.0:8.3f}{x[38:]}"
        for x in lines()
        if numbered(x) == 4
    ]
    water = ["HETATM 9999  O   HOH A 207      30.000  30.000  30.000  1.00 10.00           O"]
    for record in (seqres(SEQUENCE), LOOP):
        found = find_gaps(entry(record, lines(), ["TER"], ligand, water))
        assert summary(found) == [("A.6-9", "UUCG")]


def test_a_number_in_use_by_a_ligand_is_not_given_again(entry, lines):
    water = ["HETATM 9999  O   HOH A   7      30.000  30.000  30.000  1.00 10.00           O"]
    gap = only(find_gaps(entry(seqres(SEQUENCE), lines(), water)))
    assert [one.place for one in gap.monomers] == ["6", "8", "9", "9A"]


def test_a_ter_in_the_gap_does_not_end_the_chain(entry, lines):
    there = lines()
    first = [x for x in there if numbered(x) < 6]
    second = [x for x in there if numbered(x) > 9]
    assert only(find_gaps(entry(seqres(SEQUENCE), first, ["TER"], second))).name == "A.6-9"


def test_protein_chains_are_ignored_and_protein_only_is_refused(entry, lines):
    protein = [
        f"ATOM   9{k:3d}  CA  ALA B{k:4d}    {50.0 + 4 * k:8.3f}   0.000   0.000  1.00 10.00"
        for k in (1, 2, 5, 6)
    ]
    record = seqres(["ALA"] * 6, chain="B")
    found = find_gaps(entry(seqres(SEQUENCE), record, lines(), ["TER"], protein))
    assert summary(found) == [("A.6-9", "UUCG")]
    with pytest.raises(StructureError, match="no nucleotide found among 4 residues"):
        find_gaps(entry(record, protein))


def test_chains_are_each_by_themselves(entry, lines):
    other = [f"{x[:30]}{float(x[30:38]) + 60:8.3f}{x[38:]}" for x in lines([3], chain="B")]
    found = find_gaps(
        entry(seqres(SEQUENCE), seqres(SEQUENCE, "B"), lines(), ["TER"], other, ["TER"])
    )
    assert summary(found) == [("A.6-9", "UUCG"), ("B.3", "C")]


def test_a_chain_without_a_name(entry, lines):
    gap = only(find_gaps(entry(seqres(SEQUENCE, " "), lines(chain=" "))))
    assert (gap.name, gap.before.label) == ("6-9", "C5")


@pytest.mark.parametrize("ter", [["TER"], []])
def test_two_chains_of_one_name_are_refused(entry, lines, ter):
    other = [f"{x[:30]}{float(x[30:38]) + 60:8.3f}{x[38:]}" for x in lines()]
    found = find_gaps(entry(seqres(SEQUENCE), lines(), ter, other, ter))
    assert found.gaps == ()
    sentences = [one.reason for one in found.refused] + list(found.remarks)
    assert any("two chains are named A" in sentence for sentence in sentences)


# --- no record, and one that contradicts ----------------------------------------------------------


def test_without_a_record_a_gap_is_named_and_refused(entry, lines):
    found = find_gaps(entry(lines()))
    (refusal,) = found.refused
    assert found.gaps == ()
    assert (refusal.chain, refusal.first, refusal.last, refusal.sequence) == ("A", "6", "9", "NNNN")
    assert "4 nt are missing" in refusal.reason
    assert "A.6-9=NNNN" in refusal.reason


def test_without_a_record_a_scrap_of_a_flank_does_not_hide_the_gap(entry, lines):
    found = find_gaps(entry(lines(keep=lambda n, atom: n != 10 or atom == "P")))
    (refusal,) = found.refused
    assert found.gaps == ()
    assert (refusal.first, refusal.last) == ("6", "9")


def test_a_broken_bond_with_nothing_missing_is_named_and_left(entry, lines):
    moved = [
        f"{x[:30]}{float(x[30:38]) + 8:8.3f}{x[38:]}" if numbered(x) > 7 else x for x in lines([])
    ]
    for record in ([], seqres(SEQUENCE)):
        found = find_gaps(entry(record, moved))
        assert (found.gaps, found.refused) == ((), ())
        (remark,) = found.broken
        assert remark.startswith("A.U7–A.C8: the bond is broken")


@pytest.mark.parametrize(
    "sequence",
    [
        "GGCACUUCGGUGCA",  # the last one is C
        "GGCAC",  # too short
        "GGCACUUCGGUG",  # shorter than the numbers say
        "AAAAAUUCGAAAAA",
    ],
)
def test_a_sequence_that_contradicts_the_file_fills_nothing(entry, lines, sequence):
    found = find_gaps(entry(seqres(sequence), lines()))
    assert found.gaps == ()
    sentences = [one.reason for one in found.refused] + list(found.remarks)
    assert any("contradict" in sentence for sentence in sentences)
    # and the user's word wins
    assert only(find_gaps(entry(seqres(sequence), lines()), strands="A.6-9=UUCG")).given


def test_bonded_neighbours_have_nothing_between_them(cif, lines):
    # the record lists a nucleotide between 5 and 6, which are bonded
    names = [*"GGCAC", "A", *SEQUENCE[5:]]
    sites = mmcif_sites(lines([]), seq=lambda n: n + (n > 5))
    poly = mmcif_loop(
        "entity_poly_seq", "entity_id num mon_id", [(1, k, x) for k, x in enumerate(names, 1)]
    )
    found = find_gaps(cif(poly, sites))
    (refusal,) = found.refused
    assert "are bonded" in refusal.reason


# --- flanks ---------------------------------------------------------------------------------------


def test_a_flank_that_lacks_too_much_is_part_of_the_gap(entry, lines):
    def keep(n, atom):
        return n != 5 or atom in ("P", "O5'")

    gap = only(find_gaps(entry(seqres(SEQUENCE), lines(keep=keep))))
    assert (gap.name, gap.sequence, gap.before.label) == ("A.5-9", "CUUCG", "A.A4")
    assert sorted(gap.monomers[0].atoms_A) == ["O5'", "P"]
    assert gap.remarks == ("A.C5 has only P and O5'; it is part of the gap",)


def test_an_incomplete_flank_that_is_usable_stays(entry, lines):
    def keep(n, atom):
        return n != 10 or atom not in ("P", "OP1", "OP2", "N2")

    found = find_gaps(entry(seqres(SEQUENCE), lines(keep=keep)))
    gap = only(found)
    assert (gap.name, gap.after.label) == ("A.6-9", "A.G10")
    assert gap.remarks == ("A.G10 beside the gap lacks P, OP1, OP2, N2; they are added",)
    assert found.incomplete == ()


def test_gaps_that_only_unusable_nucleotides_part_are_one(entry, lines):
    found = find_gaps(
        entry(seqres(SEQUENCE), lines([6, 8], keep=lambda n, atom: n != 7 or atom == "P"))
    )
    assert only(found).name == "A.6-8"


def test_incomplete_nucleotides_away_from_gaps_are_listed(entry, lines):
    def keep(n, atom):
        return n != 12 or atom not in ("N2", "O6")

    found = find_gaps(entry(seqres(SEQUENCE), lines(keep=keep)))
    (one,) = found.incomplete
    assert (one.monomer.label, one.missing) == ("A.G12", ("O6", "N2"))


def test_a_5_end_without_phosphate_is_complete(entry, lines):
    def keep(n, atom):
        return n != 1 or atom not in ("P", "OP1", "OP2", "OP3")

    assert find_gaps(entry(seqres(SEQUENCE), lines(keep=keep))).incomplete == ()


def test_no_usable_nucleotide_on_a_side_is_refused(entry, lines):
    def keep(n, atom):
        return n > 5 or atom == "P"

    found = find_gaps(entry(seqres(SEQUENCE), lines(keep=keep)))
    (refusal,) = found.refused
    assert found.gaps == ()
    assert "A.6-9: no nucleotide on its 5' side" in refusal.reason


def test_a_model_of_phosphates_has_no_ends(entry, lines):
    found = find_gaps(entry(seqres(SEQUENCE), lines(keep=lambda n, atom: atom == "P")))
    assert found.gaps == ()
    assert [one.sequence for one in found.refused] == ["UUCG"]
    assert "has no nucleotide with C4'" in found.remarks[-1]


# --- what cannot be spanned -----------------------------------------------------------------------


def test_a_gap_that_cannot_be_spanned_names_both_distances(entry, lines):
    moved = [
        f"{x[:30]}{float(x[30:38]) + 70:8.3f}{x[38:]}" if numbered(x) > 9 else x for x in lines()
    ]
    (refusal,) = find_gaps(entry(seqres(SEQUENCE), moved)).refused
    assert re.fullmatch(r"A\.6-9: 4 nt cannot span \d+\.\d Å: they reach 32 Å", refusal.reason)


def test_the_span_is_judged_by_any_distance(entry, lines):
    gap = only(find_gaps(entry(seqres(SEQUENCE), lines())))
    assert check_span(gap, 28.0) is None
    assert check_span(gap, 60.04) == "A.6-9: 4 nt cannot span 60.0 Å: they reach 32 Å"


@pytest.mark.parametrize("n", [MOST_NUCLEOTIDES + 1, 40])
def test_a_long_gap_is_refused(entry, lines, n):
    sequence = SEQUENCE[:5] + "A" * n + SEQUENCE[9:]
    (refusal,) = find_gaps(
        entry(seqres(sequence), lines(number=lambda k: f"{k + (n - 4) * (k > 5):4d} "))
    ).refused
    assert refusal.sequence == "A" * n
    assert f"{n} nt are missing, and no more than" in refusal.reason


# --- alternatives ---------------------------------------------------------------------------------


def test_of_alternative_locations_the_highest_occupancy_is_taken_on_both_sides(entry, lines):
    def twice(x):
        if numbered(x) not in (5, 10):
            return [x]
        # B is the higher one in all, though not in 10
        a, b = (0.6, 0.4) if numbered(x) == 10 else (0.1, 0.9)
        moved = f"{float(x[30:38]) + 1:8.3f}"
        return [
            f"{x[:16]}A{x[17:54]}{a:6.2f}{x[60:]}",
            f"{x[:16]}B{x[17:30]}{moved}{x[38:54]}{b:6.2f}{x[60:]}",
        ]

    plain = only(find_gaps(entry(seqres(SEQUENCE), lines())))
    found = find_gaps(entry(seqres(SEQUENCE), [y for x in lines() for y in twice(x)]))
    gap = only(found)
    for mine, other in ((gap.before, plain.before), (gap.after, plain.after)):
        np.testing.assert_allclose(mine.backbone_A - other.backbone_A, [[1.0, 0, 0]] * 6)
    assert "alternative locations in 2 nucleotide(s)" in found.remarks[0]


def test_of_two_residues_at_one_place_one_is_taken(entry, lines):
    def both(x):
        if numbered(x) != 12:
            return [x]
        return [f"{x[:16]}A{x[17:54]}{0.3:6.2f}{x[60:]}"]

    there = [y for x in lines() for y in both(x)]
    rival = [
        f"{x[:16]}B  A{x[20:54]}{0.7:6.2f}{x[60:]}"
        for x in lines(keep=lambda n, atom: n == 12 and atom not in ("N2", "O6"))
    ]
    index = max(k for k, x in enumerate(there) if numbered(x) == 12) + 1
    found = find_gaps(entry(LOOP, [*there[:index], *rival, *there[index:]]))
    assert summary(found) == [("A.6-9", "UUCG")]
    assert any("A.12 is A or G" in remark for remark in found.remarks)


# --- mmCIF ----------------------------------------------------------------------------------------


def scheme(numbers=range(1, 15), codes=None, names=SEQUENCE):
    codes = codes or ["."] * len(names)
    return mmcif_loop(
        "pdbx_poly_seq_scheme",
        "asym_id entity_id seq_id mon_id pdb_seq_num pdb_ins_code",
        [
            ("A", 1, k, x, n, c)
            for k, (x, n, c) in enumerate(zip(names, numbers, codes, strict=True), 1)
        ],
    )


def poly_seq(names=SEQUENCE):
    rows = [(1, k, name) for k, name in enumerate(names, 1)]
    return mmcif_loop("entity_poly_seq", "entity_id num mon_id", rows)


def poly(code, kind="polyribonucleotide", canonical="?"):
    return [
        "_entity_poly.entity_id 1",
        f"_entity_poly.type {kind}",
        f"_entity_poly.pdbx_seq_one_letter_code '{code}'",
        f"_entity_poly.pdbx_seq_one_letter_code_can {canonical}",
        "_entity_poly.pdbx_strand_id A",
    ]


@pytest.mark.parametrize(
    "record",
    [scheme(), poly_seq(), poly(SEQUENCE), poly("GGCAC(U)UCGGUGCC"), [*scheme(), *poly_seq()]],
    ids=["scheme", "poly_seq", "one letter", "parentheses", "both"],
)
def test_a_gap_of_an_mmcif_file(cif, lines, record):
    gap = only(find_gaps(cif(record, mmcif_sites(lines()))))
    assert (gap.name, gap.sequence, gap.after.label) == ("A.6-9", "UUCG", "A.G10")


@pytest.mark.parametrize("record", [scheme(), poly_seq()], ids=["scheme", "poly_seq"])
def test_label_seq_id_that_is_absent_is_found_by_alignment(cif, lines, record):
    found = find_gaps(cif(record, mmcif_sites(lines(), seq=lambda n: ".")))
    assert summary(found) == [("A.6-9", "UUCG")]


def test_numbers_of_the_scheme_with_insertion_codes(cif, lines):
    numbers = [1, 2, 3, 4, 5, 5, 5, 6, 6, 6, 7, 8, 9, 10]
    codes = [*".....AB.AB...."]
    numbered_as = dict(zip(range(1, 15), zip(numbers, codes, strict=True), strict=True))
    back = {}

    def number(n):
        value, code = numbered_as[n]
        back[value, code] = n
        return f"{value:4d}{code if code != '.' else ' '}"

    records = lines(number=number)
    sites = mmcif_sites(records)
    # label_seq_id by number and insertion code
    fixed = [
        re.sub(
            r" A 1 \d+ (\S) ",
            lambda m, x=x: f" A 1 {back[numbered(x), x[26].strip() or '.']} {m[1]} ",
            row,
        )
        for row, x in zip(sites[-len(records) :], records, strict=True)
    ]
    found = find_gaps(cif(scheme(numbers, codes), sites[: -len(records)], fixed))
    assert summary(found) == [("A.5A-6A", "UUCG")]


def test_numbers_of_a_scheme_that_the_atoms_do_not_have_are_not_used(cif, lines):
    sites = mmcif_sites(lines(number=lambda n: f"{n + 100:4d} "), seq=lambda n: n - 100)
    assert summary(find_gaps(cif(scheme(), sites))) == [("A.106-109", "UUCG")]


def test_a_chain_with_two_names(cif, lines):
    asym = mmcif_loop("struct_asym", "id entity_id", [("A", 1)])
    gap = only(find_gaps(cif(asym, scheme(), mmcif_sites(lines(), chain="R7"))))
    assert (gap.name, gap.before.label) == ("R7.6-9", "R7.C5")


def test_label_seq_id_settles_what_numbers_do_not(cif, lines):
    # author numbers count only what is there
    sites = mmcif_sites(
        lines(number=lambda n: f"{n - 4 * (n > 9):4d} "), seq=lambda n: n + 4 * (n > 5)
    )
    gap = only(find_gaps(cif(poly_seq(), sites)))
    assert [one.record for one in gap.monomers] == [6, 7, 8, 9]
    assert [one.place for one in gap.monomers] == ["5A", "5B", "5C", "5D"]


def test_the_canonical_sequence_names_the_parent_of_a_modified_base(cif, lines):
    names = [*SEQUENCE]
    names[6] = "X1Y"
    record = [*poly_seq(names), *poly("GGCACU(X1Y)CGGUGCC", canonical=SEQUENCE)]
    gap = only(find_gaps(cif(record, mmcif_sites(lines()))))
    assert gap.sequence == "UUCG"


def test_a_residue_of_the_record_with_foreign_atom_names_is_not_missing(cif, lines):
    names = [*SEQUENCE]
    names[6] = "X1Y"
    foreign = [
        f"{x[:12]} X{k % 99:<2d}{x[16:17]}X1Y{x[20:]}" if numbered(x) == 7 else x
        for k, x in enumerate(lines([]))
    ]
    found = find_gaps(cif(poly_seq(names), mmcif_sites(foreign)))
    assert (found.gaps, found.refused) == ((), ())
    assert "A.X1Y7: the backbone has atoms of other names" in found.remarks[-1]


def test_alternatives_of_the_record_are_no_contradiction(cif, lines):
    rows = [(1, k, name) for k, name in enumerate(SEQUENCE, 1)]
    rows.insert(12, (1, 12, "A"))
    record = mmcif_loop("entity_poly_seq", "entity_id num mon_id", rows)
    assert summary(find_gaps(cif(record, mmcif_sites(lines())))) == [("A.6-9", "UUCG")]


def test_two_chains_of_one_name_in_mmcif(cif, lines):
    both = [*mmcif_sites(lines()), *mmcif_sites(lines(), label="B")[-len(lines()) :]]
    asym = mmcif_loop("struct_asym", "id entity_id", [("A", 1), ("B", 1)])
    found = find_gaps(cif(asym, poly_seq(), both))
    assert found.gaps == ()
    sentences = [one.reason for one in found.refused] + list(found.remarks)
    assert any("two chains are named A" in sentence for sentence in sentences)


# --- models, and real entries ---------------------------------------------------------------------


def test_models_each_by_itself(entry, lines):
    first, second = lines(), lines([3])
    found = entry(
        seqres(SEQUENCE),
        ["MODEL        1"],
        first,
        ["ENDMDL", "MODEL        2"],
        second,
        ["ENDMDL"],
    )
    assert summary(find_gaps(found, 0)) == [("A.6-9", "UUCG")]
    assert summary(find_gaps(found, 1)) == [("A.3", "C")]
    with pytest.raises(ValueError, match="`model` is 2"):
        find_gaps(found, 2)


def test_every_gap_of_real_entries_is_seen_with_its_sequence():
    if not REAL.is_dir():
        pytest.skip("the folder of real gaps, ../shared/gaps, is not here")
    rows: dict[str, list[dict[str, str]]] = {}
    with (REAL / "gaps.csv").open() as table:
        for row in csv.DictReader(table):
            rows.setdefault(row["file"], []).append(row)
    unseen = []
    for file, listed in rows.items():
        found = find_gaps(read_entry(REAL / file))
        seen = [(gap.chain, gap.sequence) for gap in found.gaps]
        seen += [(one.chain, one.sequence) for one in (*found.refused, *found.tails)]
        for row in listed:
            if not any(
                row["chain"] == chain and row["sequence"] in letters for chain, letters in seen
            ):
                unseen.append(row)
    assert unseen == []
