"""The whole structure with the trace in place."""

import dataclasses
import gzip
import json
import math
import warnings

import numpy as np
import pytest

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.molecule.nucleotides import read_structure
from loopelastica.report.folder import write_fold
from loopelastica.report.pdb import (
    B_MAX_A2,
    WholeStructure,
    b_factor,
    bond_records,
    expected_records,
    one_letter_chains,
    point_records,
    renamed,
)

HAIRPIN = data_path("hairpins/2koc.pdb")


def atoms(text):
    return [s for s in text.splitlines() if s.startswith(("ATOM", "HETATM"))]


def points_and_rest(whole):
    records = atoms(whole.read_text())
    points = [s for s in records if s[12:16] == " CEN"]
    return points, [s for s in records if s[12:16] != " CEN"]


def test_all_but_the_loop_is_bit_identical(shipped, koc_lines):
    folder, fold = shipped
    points, rest = points_and_rest(folder / "whole.pdb")
    assert rest == [s for s in koc_lines if int(s[22:26]) not in (6, 7, 8, 9)]
    assert [int(s[22:26]) for s in points] == [6, 7, 8, 9]
    assert [s[17:22] for s in points] == ["  U A", "  U A", "  C A", "  G A"]
    places = [[float(s[30 + 8 * k : 38 + 8 * k]) for k in range(3)] for s in points]
    np.testing.assert_allclose(places, fold.candidates[0].trace, atol=5.01e-4)


def test_the_points_stand_where_the_loop_stood_and_no_serial_number_comes_twice(shipped):
    records = atoms((shipped[0] / "whole.pdb").read_text())
    numbers = [int(s[22:26]) for s in records]
    assert numbers == sorted(numbers)
    assert len({s[6:11] for s in records}) == len(records)


def test_mdanalysis_reads_the_whole_structure(shipped):
    import MDAnalysis as mda

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        universe = mda.Universe(shipped[0] / "whole.pdb")
    assert universe.residues.resids.tolist() == list(range(1, 15))
    assert len(universe.select_atoms("name CEN").bonds) == 3


def test_a_loop_that_is_absent_gets_its_points(tmp_path, written, koc_lines):
    kept = [s for s in koc_lines if int(s[22:26]) not in (6, 7, 8, 9)]
    path = tmp_path / "absent.pdb"
    path.write_text("\n".join([*kept, "END", ""]))
    folder, fold = written(path, tmp_path, loop="A.6-9", shapes="rod")
    points, rest = points_and_rest(folder / "whole.pdb")
    assert rest == kept
    assert [(int(s[22:26]), s[17:20]) for s in points] == [(k, "  N") for k in range(6, 10)]
    # blind: with the loop in the file the trace of a rod, which knows no letters, is the same
    (present,) = le.fold(HAIRPIN, all_models=False, shapes="rod")
    np.testing.assert_array_equal(fold.candidates[0].trace, present.candidates[0].trace)
    assert fold.candidates[0].rmsd_A is None
    assert "compared with nothing" in fold.remarks[0]
    content = json.loads((folder / "ranking.json").read_text())
    assert content["parameters"]["loop"] == ["A.6-9"]
    assert content["hairpin"]["residues"] == ["A.N6", "A.N7", "A.N8", "A.N9"]


def test_both_halves_of_a_loop_residue_with_two_names_give_way(tmp_path, written, koc_lines):
    lines = koc_lines
    sixth = [s for s in lines if s[22:26] == "   6"]
    k = lines.index(sixth[0])
    both = [f"{s[:16]}A  U{s[20:54]}  0.30{s[60:]}" for s in sixth]
    both += [f"{s[:16]}B5BU{s[20:54]}  0.70{s[60:]}" for s in sixth]
    path = tmp_path / "two.pdb"
    path.write_text("\n".join([*lines[:k], *both, *lines[k + len(sixth) :], "END", ""]))
    folder, _ = written(path, tmp_path)
    points, rest = points_and_rest(folder / "whole.pdb")
    assert rest == [s for s in lines if int(s[22:26]) not in (6, 7, 8, 9)]
    assert points[0][17:26] == "5BU A   6"
    remarks = json.loads((folder / "ranking.json").read_text())["remarks"]
    assert remarks == [
        "alternative locations in 1 nucleotide(s), the one of highest occupancy is used: A.5BU6 B"
    ]


def test_a_compressed_file_with_other_records(tmp_path, written, koc_lines):
    lines = koc_lines
    fifth = max(k for k, s in enumerate(lines) if s[22:26] == "   5")
    sixth = fifth + 1
    odd = [
        "HEADER    RNA",
        "CRYST1   50.000   50.000   50.000  90.00  90.00  90.00 P 1",
        *lines[: fifth + 1],
        "ANISOU" + lines[fifth][6:],
        lines[sixth],
        "ANISOU" + lines[sixth][6:],
        *lines[sixth + 1 :],
        "TER",
        "END",
        "",
    ]
    path = tmp_path / "odd.pdb.gz"
    path.write_bytes(gzip.compress("\n".join(odd).encode()))
    folder, _ = written(path, tmp_path)
    text = (folder / "whole.pdb").read_text().splitlines()
    assert [s for s in text if s.startswith("ANISOU")] == ["ANISOU" + lines[fifth][6:]]
    assert text[text.index("ANISOU" + lines[fifth][6:]) + 1][12:16] == " CEN"
    assert odd[1] in text
    assert "TER" in text


@pytest.fixture
def long_chain(tmp_path):
    gemmi = pytest.importorskip("gemmi")
    structure = gemmi.read_pdb(str(HAIRPIN))
    for model in structure:
        model[0].name = "RNA2"
    path = tmp_path / "long.cif"
    structure.make_mmcif_document().write_file(str(path))
    return path


def test_a_long_chain_name_is_kept_where_it_can_be(long_chain, tmp_path, written, koc_lines):
    folder, fold = written(long_chain, tmp_path)
    assert fold.hairpin.name == "RNA26-9"
    assert json.loads((folder / "ranking.json").read_text())["hairpin"]["chain"] == "RNA2"
    assert (folder / "ranking.csv").read_text().splitlines()[1].startswith("RNA2,RNA26-9,")
    for name in ("traces.pdb", "whole.pdb"):
        text = (folder / name).read_text()
        assert "REMARK  99 CHAIN RNA2 IS WRITTEN AS A\n" in text
        assert {s[21] for s in atoms(text)} == {"A"}
    _, rest = points_and_rest(folder / "whole.pdb")
    expected = [s for s in koc_lines if int(s[22:26]) not in (6, 7, 8, 9)]
    assert [s[12:54] for s in rest] == [s[12:54] for s in expected]
    assert "chain RNA2 and resi" in (folder / "view.pml").read_text()


def test_letters_of_chains():
    assert one_letter_chains(["AA", "A", "AA", "", "B"]) == {"AA": "C", "A": "A", "": "", "B": "B"}
    many = one_letter_chains(f"X{k}" for k in range(70))
    assert len(set(many.values())) == 62
    assert all(len(letter) == 1 for letter in many.values())


def test_a_protein_with_the_same_numbers_stays(hairpin_folder, tmp_path, written):
    path = hairpin_folder / "boxb_nochain.pdb.gz"
    folder, fold = written(path, tmp_path)
    lines = atoms(gzip.decompress(path.read_bytes()).decode())
    _, rest = points_and_rest(folder / "whole.pdb")
    numbers = {f"{number:4d}" for number in fold.hairpin.resid}
    gone = [s for s in lines if s[17:20].strip() in set("ACGU") and s[22:26] in numbers]
    assert len(gone) == 167
    assert rest == [s for s in lines if s not in gone]
    assert sum(s[17:20].strip() not in set("ACGU") for s in rest) > 300


def test_a_universe_is_written_at_its_frame(tmp_path, koc_lines):
    import MDAnalysis as mda

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        universe = mda.Universe(HAIRPIN)
    structure = read_structure(universe)
    (fold,) = le.fold(structure, all_models=False)
    WholeStructure(structure).write(tmp_path / "whole.pdb", fold)
    points, rest = points_and_rest(tmp_path / "whole.pdb")
    assert len(points) == 4
    expected = [s for s in koc_lines if int(s[22:26]) not in (6, 7, 8, 9)]
    assert [s[12:54] for s in rest] == [s[12:54] for s in expected]


def test_points_are_joined_up_to_the_last_serial_number_of_the_format():
    assert bond_records(99_997, 3) == ["CONECT9999799998", "CONECT9999899999"]
    assert bond_records(99_998, 3) == []


@pytest.mark.parametrize("chain", ["a\nb", "/../../", "a b", "=1+1", "x" * 7, "ab\tcd"])
def test_no_name_of_a_chain_breaks_a_record(tmp_path, written, write_cif, chain):
    pytest.importorskip("gemmi")
    folder, fold = written(write_cif(tmp_path / "odd.cif", chain), tmp_path)
    assert fold.hairpin.chain == chain
    for name in ("traces.pdb", "whole.pdb"):
        text = (folder / name).read_text(encoding="utf-8")
        known = ("ATOM  ", "REMARK", "MODEL ", "ENDMDL", "CONECT", "TER", "END", "CRYST1")
        assert all(line.startswith(known) for line in text.splitlines())
        assert {len(line) for line in atoms(text)} <= {78, 80}
        assert {line[21] for line in atoms(text)} == {"A"}


@pytest.mark.parametrize("letter", ["\n", "é", "\t"])
def test_a_letter_that_the_pdb_format_cannot_hold_is_another_one(letter):
    assert one_letter_chains([letter, "A"]) == {letter: "B", "A": "A"}


def test_names_of_residues_and_insertion_codes_keep_their_columns(koc, fold):
    names = koc.nucleotides.resname.astype("<U8")
    names[fold.hairpin.loop] = ["a\nb", "U C", "é", "ABCD"]
    table = dataclasses.replace(koc.nucleotides, resname=names)
    icode = fold.hairpin.icode.astype("<U8")
    icode[:2] = ["\n", "AB"]
    loop = dataclasses.replace(fold, hairpin=dataclasses.replace(fold.hairpin, icode=icode))
    structure = dataclasses.replace(koc, nucleotides=table)
    records = point_records(loop, structure, fold.candidates[0], "A", 1)
    assert [s[17:20] for s in records] == ["a_b", "U_C", "  _", "ABC"]
    assert [s[26] for s in records] == ["_", "A", " ", " "]
    np.testing.assert_allclose(
        [float(s[30:38]) for s in records], fold.candidates[0].trace[:, 0], atol=1e-3
    )


def test_the_b_factor_is_that_of_an_error():
    # mean square displacement along one axis is B over 8π², and an error has three axes
    for error in (0.5, 1.0, 2.0):
        assert b_factor(error) / (8 * math.pi**2) == pytest.approx(error**2 / 3)
    assert b_factor(0.0) == 0.0
    assert b_factor(50.0) == B_MAX_A2
    assert len(f"{b_factor(50.0):6.2f}") == 6


@pytest.mark.parametrize(
    "shape", ["like a\nATOM", "like " + "x" * 200, "like é\x1b[2J", "like 環", "motif GNRA"]
)
def test_remarks_on_candidates_are_records_of_the_format(fold, shape):
    odd = dataclasses.replace(fold.candidates[0], shape=shape)
    for record in expected_records([odd]):
        assert record.startswith("REMARK  99 ")
        assert len(record) <= 80
        assert record.isascii()
        assert record.isprintable()
    assert expected_records([odd])[1].startswith(f"REMARK  99 CANDIDATE 1: {shape[:4]}")


def test_the_whole_structure_says_what_its_loop_is(shipped):
    folder, fold = shipped
    text = (folder / "whole.pdb").read_text()
    assert f"REMARK  99 CANDIDATE 1: {fold.candidates[0].shape}" in text
    points, _ = points_and_rest(folder / "whole.pdb")
    expected = b_factor(float(fold.candidates[0].expected_rmsd_A[1]))
    (written,) = {float(s[60:66]) for s in points}
    assert written == pytest.approx(expected, abs=0.006)


def test_no_unit_cell_is_invented_where_records_are_made_anew(tmp_path, write_cif):
    path = write_cif(tmp_path / "made.cif", "A")
    structure = read_structure(path)
    (fold,) = le.fold(structure, all_models=False, max_candidates=1, shapes="rod")
    WholeStructure(structure).write(tmp_path / "whole.pdb", fold)
    assert "CRYST1" not in (tmp_path / "whole.pdb").read_text()
    cell = ("length_a 40.0", "length_b 50.0", "length_c 60.0", "angle_alpha 90.0",
            "angle_beta 90.0", "angle_gamma 90.0")  # fmt: skip
    path.write_text("\n".join([path.read_text(), *(f"_cell.{one}" for one in cell), ""]))
    WholeStructure(read_structure(path)).write(tmp_path / "whole.pdb", fold)
    assert "CRYST1   40.000   50.000   60.000" in (tmp_path / "whole.pdb").read_text()


def test_a_chain_has_one_letter_in_all_files(tmp_path, write_cif):
    path = write_cif(tmp_path / "two.cif", "RNA")
    # another chain has the letter that is first
    other = "ATOM 9000 C CA . GLY B 2 1 ? 60.0 60.0 60.0 1.0 0.0 1 GLY A CA 1"
    path.write_text(f"{path.read_text().rstrip()}\n{other}\n")
    structure = read_structure(path)
    assert renamed(structure) == {"RNA": "B"}
    (fold,) = le.fold(structure, all_models=False, max_candidates=1, shapes="rod")
    out = tmp_path / "out"
    write_fold(out, path, fold, structure, plot=False, whole=WholeStructure(structure))
    for name in ("traces.pdb", "whole.pdb"):
        points = [r for r in (out / name).read_text().splitlines() if r[12:16] == " CEN"]
        assert {r[21] for r in points} == {"B"}
