"""The sequence of record as files have it."""

from __future__ import annotations

import pytest
from chain_files import SEQUENCE, mmcif_loop, mmcif_sites, remark_465, seqres

from loopelastica.molecule.record import Absent, records_of


def letters(record):
    return "".join(one.letter for one in record.residues)


def test_seqres_and_remark_465(entry, lines):
    rows = [("U", "A", "6"), ("G", "A", "-17"), ("DT", "B", "3B"), ("U", "A", "1006")]
    records = records_of(entry(remark_465(rows), seqres(SEQUENCE), lines()))
    record = records.by_author["A"]
    assert (letters(record), record.source) == (SEQUENCE, "SEQRES")
    assert records.absent == {
        "A": [Absent("U", 6, ""), Absent("G", -17, ""), Absent("U", 1006, "")],
        "B": [Absent("DT", 3, "B")],
    }


def test_remark_465_of_a_chain_without_a_name(entry, lines):
    rows = ["REMARK 465   M RES C SSSEQI", "REMARK 465       U      16"]
    assert records_of(entry(rows, lines(chain=" "))).absent == {"": [Absent("U", 16, "")]}


def test_remark_465_of_one_model(entry, lines):
    rows = ["REMARK 465   1   U A    16", "REMARK 465   2   C A    17"]
    found = entry(rows, lines())
    assert records_of(found, 0).absent == {"A": [Absent("U", 16, "")]}


def test_proteins_have_no_record_here(entry, cif, lines):
    protein = seqres(["ALA", "GLY", "CYS", "THR"] * 4, chain="B")
    assert set(records_of(entry(protein, seqres(SEQUENCE), lines())).by_author) == {"A"}
    poly = mmcif_loop(
        "entity_poly", "entity_id type pdbx_seq_one_letter_code", [(1, "'polypeptide(L)'", "ACGT")]
    )
    assert records_of(cif(poly, mmcif_sites(lines()))).by_label == {}


@pytest.mark.parametrize(
    ("kind", "code", "names"),
    [
        ("polyribonucleotide", "GG(5MU)A", ["G", "G", "5MU", "A"]),
        ("polydeoxyribonucleotide", "(DG)(DT)", ["DG", "DT"]),
        ("polydeoxyribonucleotide", "GTU", ["DG", "DT", "DU"]),
        ("'polydeoxyribonucleotide/polyribonucleotide hybrid'", "G(DT)U", ["G", "DT", "U"]),
    ],
)
def test_the_one_letter_code(cif, lines, kind, code, names):
    poly = mmcif_loop("entity_poly", "entity_id type pdbx_seq_one_letter_code", [(1, kind, code)])
    record = records_of(cif(poly, mmcif_sites(lines()))).by_label["A"]
    assert [one.names for one in record.residues] == [(name,) for name in names]


def test_chains_of_an_entity_by_the_authors_names(cif, lines):
    poly = mmcif_loop(
        "entity_poly",
        "entity_id type pdbx_seq_one_letter_code pdbx_strand_id",
        [(7, "polyribonucleotide", SEQUENCE, "'A, B'")],
    )
    assert set(records_of(cif(poly, mmcif_sites(lines()))).by_author) == {"A", "B"}


def test_the_scheme_has_numbers_and_the_canonical_code_letters(cif, lines):
    scheme = mmcif_loop(
        "pdbx_poly_seq_scheme",
        "asym_id entity_id seq_id mon_id pdb_seq_num pdb_ins_code hetero",
        [
            *[("A", 1, 1, "G", -3, ".", "n"), ("A", 1, 2, "X1Y", 3, "B", "n")],
            *[("A", 1, 3, "A", "?", ".", "y"), ("A", 1, 3, "G", "?", ".", "y")],
        ],
    )
    poly = mmcif_loop("entity_poly", "entity_id pdbx_seq_one_letter_code_can", [(1, "GUA")])
    record = records_of(cif(scheme, poly, mmcif_sites(lines()))).by_label["A"]
    assert letters(record) == "GUA"
    assert [(one.number, one.icode) for one in record.residues] == [(-3, ""), (3, "B"), (None, "")]
    assert record.residues[2].names == ("A", "G")


def test_unobserved_residues_but_not_those_of_no_occupancy(cif, lines):
    rows = [("A", "U", 6, "?", 1, 1), ("A", "U", 7, "B", 0, 1), ("A", "C", 8, "?", 1, 2)]
    unobserved = mmcif_loop(
        "pdbx_unobs_or_zero_occ_residues",
        "auth_asym_id auth_comp_id auth_seq_id PDB_ins_code occupancy_flag PDB_model_num",
        rows,
    )
    found = records_of(cif(unobserved, mmcif_sites(lines())))
    assert found.absent == {"A": [Absent("U", 6, "")]}


def test_parents_of_modified_components(cif, lines):
    parents = mmcif_loop(
        "chem_comp", "id mon_nstd_parent_comp_id", [("X1Y", "U"), ("G", "?"), ("MSE", "MET")]
    )
    assert records_of(cif(parents, mmcif_sites(lines()))).parents == {"X1Y": "U"}


def test_a_category_that_is_mixed_up_is_no_record(cif, lines):
    mixed = ["loop_", "_pdbx_poly_seq_scheme.asym_id", "_pdbx_pol.seq_id", "A 1"]
    assert records_of(cif(mixed, mmcif_sites(lines()))).by_label == {}


def test_polymers_of_no_entity_are_no_record(cif, lines):
    poly = mmcif_loop("entity_poly", "type pdbx_seq_one_letter_code", [("x", SEQUENCE)])
    assert records_of(cif(poly, mmcif_sites(lines()))).by_label == {}
