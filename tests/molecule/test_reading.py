"""Files good and bad: what is read, and the one sentence that a fault becomes."""

from __future__ import annotations

import gzip
import warnings
from pathlib import Path

import gemmi
import numpy as np
import pytest

from loopelastica.errors import StructureError
from loopelastica.molecule.hairpins import find_hairpins
from loopelastica.molecule.nucleotides import read_structure

KOC = Path(__file__).parents[2] / "data" / "hairpins" / "2koc.pdb"


def fault_of(path) -> str:
    """Return the sentence, after checking that it is one and names the file."""
    with pytest.raises(StructureError) as caught:
        list(read_structure(path).models())
    sentence = str(caught.value)
    assert "\n" not in sentence
    assert sentence.startswith(str(path))
    return sentence


def number_fields(line: str, x: float, y: float, z: float) -> str:
    return f"{line[:30]}{x:8.3f}{y:8.3f}{z:8.3f}{line[54:]}"


@pytest.mark.parametrize(
    ("name", "content", "cause"),
    [
        ("empty.pdb", b"", "empty"),
        ("blank.pdb", b" \n\n", "empty"),
        ("empty.cif", b"", "empty"),
        ("noise.pdb", bytes(range(256)) * 8, "no ATOM"),
        ("noise.cif", bytes(range(256)) * 8, "gemmi cannot read"),
        ("noise.pdb.gz", b"this is not gzip", "cannot be read"),
        ("page.pdb", b"<html><body>404</body></html>", "no ATOM"),
        ("nothing.cif", b"data_x\n_a.b 1\n", "no atoms"),
        ("word.xyz", b"hello", "MDAnalysis cannot read"),
        ("nosuffix", b"hello", "MDAnalysis cannot read"),
    ],
)
def test_a_bad_file_is_one_sentence(tmp_path, name, content, cause):
    path = tmp_path / name
    path.write_bytes(content)
    assert cause in fault_of(path)


def test_absent_file_and_folder(tmp_path):
    assert "no such file" in fault_of(tmp_path / "absent.pdb")
    (tmp_path / "folder.pdb").mkdir()
    assert "this is a folder, not a structure file, and holds none" in fault_of(
        tmp_path / "folder.pdb"
    )
    (tmp_path / "folder.pdb" / "a.cif").write_text("")
    assert "give the files in it, such as a.cif" in fault_of(tmp_path / "folder.pdb")


@pytest.mark.parametrize(
    ("name", "entry"),
    [("2KOC", "2KOC"), ("1zih", "1ZIH"), ("pdb_00001ehz", "pdb_00001ehz")],
)
def test_an_entry_of_the_pdb_is_not_downloaded_and_the_way_is_shown(
    tmp_path, monkeypatch, name, entry
):
    monkeypatch.chdir(tmp_path)
    said = fault_of(Path(name))
    assert said.startswith(f"{name}: there is no such file, and nothing is downloaded")
    assert f"https://files.rcsb.org/download/{entry}.cif" in said


@pytest.mark.parametrize("name", ["loop", "0abc", "2koc.pdb", "folder/2koc.cif", "12345"])
def test_other_files_that_are_not_there_are_no_entries(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    assert fault_of(Path(name)) == f"{name}: there is no such file"


def test_unreadable_file(tmp_path, monkeypatch):
    path = tmp_path / "locked.pdb"
    path.write_text("x")

    def refuse(*args, **kwargs):
        raise PermissionError("Permission denied")

    monkeypatch.setattr("builtins.open", refuse)
    assert "permission" in fault_of(path)


@pytest.mark.parametrize("kept", [31, 40, 53])
def test_a_pdb_cut_inside_a_line_is_not_read_with_a_shorter_number(pdb, koc_lines, kept):
    path = pdb(koc_lines)
    path.write_text("\n".join([*koc_lines[:300], koc_lines[300][:kept]]))
    assert "line 301 is cut short" in fault_of(path)


def test_a_pdb_cut_inside_its_last_model(pdb, koc_lines):
    path = pdb(koc_lines, koc_lines)
    path.write_text("\n".join(path.read_text().splitlines()[:-100]))
    assert "cut short, model 2" in fault_of(path)


def test_a_compressed_file_cut_short(tmp_path):
    path = tmp_path / "cut.pdb.gz"
    path.write_bytes(gzip.compress(KOC.read_bytes())[:20_000])
    assert "compressed file is cut short" in fault_of(path)


def test_words_in_place_of_coordinates(pdb, koc_lines):
    lines = list(koc_lines)
    lines[7] = lines[7][:30] + " ******* " + lines[7][39:]
    assert "line 9 has no readable coordinates" in fault_of(pdb(lines))


@pytest.mark.parametrize("number", ["****", "    ", "1A 2", "A000"])
def test_a_residue_number_that_cannot_be_read(pdb, koc_lines, number):
    lines = list(koc_lines)
    lines[10] = lines[10][:22] + number + lines[10][26:]
    sentence = fault_of(pdb(lines))
    assert f"line 12 has no readable residue number ({number.strip()!r})" in sentence


def test_water_needs_no_residue_number(pdb, koc_lines):
    water = [
        f"HETATM{k:5d}  O   HOH A****    {k:8.3f}   0.000   0.000  1.00  0.00           O"
        for k in range(9)
    ]
    assert len(read_structure(pdb([*koc_lines, *water])).nucleotides) == 14


@pytest.mark.parametrize("serial", ["*****", "A00*1", "A0000", "a1", "", "99999", "1.5"])
def test_serials_are_not_needed(pdb, koc_lines, koc, serial):
    lines = [f"{line[:6]}{serial:>5s}{line[11:]}" for line in koc_lines]
    np.testing.assert_array_equal(read_structure(pdb(lines)).positions(0), koc.positions(0))


def test_serials_of_six_digits_are_atoms(pdb, koc_lines, koc):
    lines = [f"ATOM {100000 + k:6d}{line[11:]}" for k, line in enumerate(koc_lines)]
    np.testing.assert_array_equal(read_structure(pdb(lines)).positions(0), koc.positions(0))


def test_models_without_model_records(tmp_path, koc_lines, koc):
    for end in ("ENDMDL", "END"):
        path = tmp_path / f"{end}.pdb"
        path.write_text(("\n".join([*koc_lines, end]) + "\n") * 3)
        structure = read_structure(path)
        assert structure.n_models == 3
        np.testing.assert_array_equal(structure.positions(2), koc.positions(0))


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_any_line_end_will_do(tmp_path, koc_lines, koc, end):
    path = tmp_path / "some.pdb"
    path.write_bytes(end.join(koc_lines).encode())
    np.testing.assert_array_equal(read_structure(path).positions(0), koc.positions(0))
    damaged = [*koc_lines[:8], koc_lines[8][:30], *koc_lines[9:]]
    path.write_bytes(end.join(damaged).encode())
    assert "line 9 " in fault_of(path)


@pytest.mark.parametrize("size", [100, 1000, 1023, 4096])
def test_records_across_pieces_of_a_file_are_whole(pdb, koc_lines, koc, size, monkeypatch):
    monkeypatch.setattr("loopelastica.molecule._source._PIECE", size)
    path = pdb(koc_lines)
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    np.testing.assert_array_equal(read_structure(path).positions(0), koc.positions(0))


def test_characters_that_end_lines_elsewhere_do_not_end_a_record(pdb, koc_lines, koc):
    lines = [f"{line[:66]}\x0b\x0c\x1c\x85\u2028{line[71:]}" for line in koc_lines]
    np.testing.assert_array_equal(read_structure(pdb(lines)).positions(0), koc.positions(0))


def test_a_giant_line_is_passed_over(pdb, koc_lines, koc):
    giant = "REMARK " + "x" * 5_000_000
    path = pdb([giant, *koc_lines, giant, koc_lines[0][:54] + " " * 3_000_000])
    structure = read_structure(path)
    np.testing.assert_array_equal(structure.positions(0)[:-1], koc.positions(0))


def test_numbers_beyond_single_precision(pdb, koc_lines):
    for far in ("   1e308", "     inf", "   -1e99", "     2e6"):
        lines = [f"{x[:30]}{far}{x[38:]}" for x in koc_lines]
        assert "coordinates of A.G1 are beyond" in fault_of(pdb(lines))


def test_a_protein_has_no_nucleotide(pdb, koc_lines):
    names = (" N  ", " CA ", " C  ", " O  ", " CB ")
    lines = [
        koc_lines[k][:12] + names[k % 5] + " ALA" + koc_lines[k][20:22] + f"{k // 5:4d}    "
        f"{koc_lines[k][30:]}"
        for k in range(50)
    ]
    assert "no nucleotide found" in fault_of(pdb(lines))


def test_placeholder_coordinates(pdb, koc_lines):
    zeros = [number_fields(line, 0, 0, 0) for line in koc_lines]
    assert "every nucleotide lies at the origin" in fault_of(pdb(zeros))
    assert "model 2: every nucleotide lies at the origin" in fault_of(pdb(koc_lines, zeros))
    some = [z if line[22:26] == "   6" else line for z, line in zip(zeros, koc_lines, strict=True)]
    assert "A.U6 lies at the origin" in fault_of(pdb(some))


def test_coordinates_that_are_no_numbers(pdb, koc_lines):
    lines = [
        number_fields(line, np.nan, 0, 0) if line[12:16] == " P  " else line for line in koc_lines
    ]
    assert "A.G1 are no numbers" in fault_of(pdb(lines))


def test_models_of_unequal_size_are_matched_atom_by_atom(pdb, koc_lines, koc):
    shifted = [number_fields(line, k, 1.0, 2.0) for k, line in enumerate(koc_lines)]
    lacking = [line for line in shifted if not line[12:16].strip().startswith("H")]
    structure = read_structure(pdb(koc_lines, lacking))
    assert structure.n_models == 2
    assert structure.remarks == ("its 2 models differ in their atoms and are read one by one",)
    np.testing.assert_allclose(structure.positions(0), koc.positions(0), atol=1e-4)
    second = structure.positions(1)
    hydrogen = [line[12:16].strip().startswith("H") for line in koc_lines]
    np.testing.assert_array_equal(np.isnan(second).any(axis=1), hydrogen)
    known = ~np.array(hydrogen)
    np.testing.assert_array_equal(second[known, 0], np.arange(len(koc_lines))[known])


def test_models_in_another_order_are_matched_atom_by_atom(pdb, koc_lines, koc):
    structure = read_structure(pdb(koc_lines, koc_lines[::-1]))
    np.testing.assert_allclose(structure.positions(1), koc.positions(0), atol=1e-4)
    assert "read one by one" in structure.remarks[0]


def test_atoms_of_one_name_are_told_apart_by_their_order(pdb, koc_lines):
    far = [number_fields(line, 99.0, k, 0.0) for k, line in enumerate(koc_lines)]
    nameless = [line[:21] + " " + line[22:] for line in [*koc_lines, *far]]
    structure = read_structure(pdb(nameless, nameless[:-1]))
    first, second = structure.models()
    np.testing.assert_array_equal(first[:-1], second[:-1])
    assert np.isnan(second[-1]).all()


def test_an_indented_record_is_an_atom_too(pdb, koc_lines):
    structure = read_structure(pdb(["   " + koc_lines[0], *koc_lines[1:]]))
    assert len(structure.nucleotides) == 14
    assert structure.positions(0)[0, 0] == float(koc_lines[0][30:38])


def test_gzip_changes_nothing(tmp_path, koc):
    path = tmp_path / "2koc.pdb.gz"
    path.write_bytes(gzip.compress(KOC.read_bytes(), 1))
    packed = read_structure(path)
    assert packed.n_models == 20
    assert packed.name == "2koc.pdb.gz"
    np.testing.assert_array_equal(packed.positions(13), koc.positions(13))


def test_mmcif_gives_every_model(tmp_path, koc):
    path = tmp_path / "2koc.cif"
    gemmi.read_pdb(str(KOC)).make_mmcif_document().write_file(str(path))
    structure = read_structure(path)
    assert structure.n_models == 20
    np.testing.assert_allclose(structure.positions(19), koc.positions(19), atol=1e-4)
    assert [h.name for h in find_hairpins(structure)] == ["A6-9"]
    (tmp_path / "cut.cif").write_text(path.read_text()[:60_000])
    assert "gemmi cannot read" in fault_of(tmp_path / "cut.cif")


def test_mmcif_and_pdb_agree_on_names_numbers_and_every_model(tmp_path, hairpins_folder):
    for entry in ("1idx", "2g1g", "1msy"):
        source = hairpins_folder / f"{entry}.pdb.gz"
        path = tmp_path / f"{entry}.cif"
        gemmi.read_pdb(str(source)).make_mmcif_document().write_file(str(path))
        ours, theirs = read_structure(path), read_structure(source)
        a, b = ours.nucleotides, theirs.nucleotides
        assert [a.label(i) for i in range(len(a))] == [b.label(i) for i in range(len(b))]
        np.testing.assert_array_equal(a.letter, b.letter)
        np.testing.assert_array_equal(a.altloc, b.altloc)
        assert ours.remarks == theirs.remarks
        assert ours.n_models == theirs.n_models
        for p, q in zip(ours.models(), theirs.models(), strict=True):
            known = a.atom_index >= 0
            np.testing.assert_allclose(p[a.atom_index[known]], q[b.atom_index[known]], atol=1e-4)


def test_mmcif_models_of_unequal_size(tmp_path, koc):
    structure = gemmi.read_pdb(str(KOC))
    del structure[1][0][5]
    path = tmp_path / "unequal.cif"
    structure.make_mmcif_document().write_file(str(path))
    unequal = read_structure(path)
    assert unequal.remarks == ("its 20 models differ in their atoms and are read one by one",)
    sixth = unequal.nucleotides.atom_index[5]
    assert np.isnan(unequal.positions(1)[sixth[sixth >= 0]]).all()
    np.testing.assert_allclose(unequal.positions(2), koc.positions(2), atol=1e-4)


@pytest.fixture
def mmcif(tmp_path):
    """Write 2KOC as mmCIF with one value of the fifth atom changed, or a column left out."""

    def write(column: str, value: str | None, row: int = 4) -> Path:
        block = gemmi.read_pdb(str(KOC)).make_mmcif_block()
        loop = block.find_loop("_atom_site.id").get_loop()
        if value is None:
            loop.remove_column(f"_atom_site.{column}")
        else:
            block.find_loop(f"_atom_site.{column}")[row] = value
        path = tmp_path / "some.cif"
        path.write_text(block.as_string())
        return path

    return write


@pytest.mark.parametrize(
    ("column", "value", "what"),
    [
        ("Cartn_x", "****", "coordinates"),
        ("Cartn_y", "?", "coordinates"),
        ("Cartn_z", "nan", "coordinates"),
        ("auth_seq_id", "****", "residue number"),
        ("auth_seq_id", "?", "residue number"),
        ("auth_seq_id", "1.5", "residue number"),
        ("pdbx_PDB_model_num", "x", "model number"),
        ("label_alt_id", "AB", "alternative location"),
        ("pdbx_PDB_ins_code", "AB", "insertion code"),
        ("pdbx_formal_charge", "zz", "charge"),
        ("label_atom_id", "ATOMNAME", "atom name of fewer than 8 characters"),
    ],
)
def test_a_value_of_an_mmcif_file_that_cannot_be_read(mmcif, column, value, what):
    sentence = fault_of(mmcif(column, value))
    assert f"row 5 of _atom_site has no readable {what} ({value!r})" in sentence


def test_the_second_residue_number_of_an_mmcif_file(mmcif):
    sentence = fault_of(mmcif("label_seq_id", "****", row=0))
    assert "row 1 of _atom_site has no readable residue number ('****')" in sentence


@pytest.mark.parametrize("column", ["Cartn_x", "label_atom_id", "label_comp_id", "label_asym_id"])
def test_a_column_of_an_mmcif_file_that_is_absent(mmcif, column):
    assert column in fault_of(mmcif(column, None))


def test_columns_of_an_mmcif_file_that_are_not_needed(mmcif, koc):
    for column in ("group_PDB", "occupancy", "B_iso_or_equiv", "pdbx_formal_charge"):
        structure = read_structure(mmcif(column, None))
        np.testing.assert_allclose(structure.positions(3), koc.positions(3), atol=1e-4)


def test_the_line_of_an_error_in_mmcif(tmp_path):
    path = tmp_path / "some.cif"
    path.write_text("data_x\nloop_\n_a.b\n_a.c\n1 2\n3\n")
    assert "line 6 has 1 values in place of 2" in fault_of(path)
    path.write_text("data_x\n_a.b 1\n_a.b 2\n")
    assert "line 3 in data_x" in fault_of(path)


def test_a_universe_is_read_in_its_current_frame_and_left_there(koc):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import MDAnalysis

        universe = MDAnalysis.Universe(str(KOC))
    universe.trajectory[7]
    structure = read_structure(universe)
    assert (structure.name, structure.source, structure.n_models) == ("universe", None, 1)
    assert universe.trajectory.frame == 7
    universe.trajectory[2]
    (positions,) = structure.models()
    np.testing.assert_array_equal(positions, koc.positions(7))
    with pytest.raises(ValueError, match="`model` is 1"):
        structure.positions(1)


def test_of_a_group_of_atoms_only_those_are_read(koc):
    group = koc.universe.select_atoms("resid 4:11 and not (resid 6 and name P)")
    part = read_structure(group)
    assert "".join(part.nucleotides.letter) == "ACUUCGGU"
    whole = koc.nucleotides.atom_index[3:11]
    changed = part.nucleotides.atom_index != whole
    assert changed.sum() == 1
    assert part.nucleotides.atom_index[changed] == -1
    np.testing.assert_array_equal(part.positions(0).shape, koc.positions(0).shape)


def test_positions_set_by_the_user_are_the_ones_read(koc):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import MDAnalysis

        universe = MDAnalysis.Universe(str(KOC))
    universe.atoms.positions = universe.atoms.positions + 5.0
    moved = read_structure(universe).positions(0)
    np.testing.assert_allclose(moved, koc.positions(0) + 5.0, atol=1e-4)


def test_positions_are_read_only_doubles(koc):
    positions = koc.positions(0)
    assert positions.dtype == np.float64
    with pytest.raises(ValueError, match="read-only"):
        positions[0] = 0.0


def test_what_is_no_structure_at_all(koc):
    for thing in (42, None, koc.nucleotides):
        with pytest.raises(ValueError, match="`source`"):
            read_structure(thing)


def test_a_universe_without_coordinates_or_names():
    import MDAnalysis

    with pytest.raises(StructureError, match="universe: it has no coordinates"):
        read_structure(MDAnalysis.Universe.empty(3))
    with pytest.raises(StructureError, match="universe: the atoms have no names"):
        read_structure(MDAnalysis.Universe.empty(3, trajectory=True))


def test_the_file_whose_first_record_mdanalysis_cannot_place(hairpins_folder):
    structure = read_structure(hairpins_folder / "1wts_unequal_models.pdb.gz")
    assert "".join(structure.nucleotides.letter) == "GGACC"
    assert np.isfinite(structure.positions(0)).all()


def test_a_name_in_an_mmcif_file_that_is_no_ascii_is_told_with_its_line(tmp_path, write_cif):
    path = write_cif(tmp_path / "x.cif", "é")
    lines = path.read_text(encoding="utf-8").splitlines()
    first = next(n for n, line in enumerate(lines, 1) if "é" in line)
    assert fault_of(path) == (
        f"{path}: line {first} has a name with a sign that is no ASCII; mmCIF allows no other"
    )
