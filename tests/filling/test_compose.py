"""What the filled file says of itself."""

import gapped
import pytest

import loopelastica as le
from loopelastica.filling.compose import changes_of

pytest.importorskip("rdkit")


def remarks(text):
    return " ".join(
        line[11:].strip() for line in text.splitlines() if line.startswith("REMARK  99")
    )


def test_the_file_says_what_was_modelled_from_what_and_how_well(tmp_path):
    path = gapped.gapped(tmp_path / "a.pdb", {6, 7, (11, "N3")})
    filling = le.fill(path)
    said = remarks(filling.text())
    assert f"loopelastica {le.__version__} modelled" in said
    assert "a.pdb" in said
    assert filling.sha256 in said.replace(" ", "")
    assert "A.6-7 UU" in said
    assert "expected error" in said
    assert "A.U11" in said


def test_a_strand_that_was_not_filled_is_named_in_a_file_with_others(tmp_path):
    atoms = [*gapped.chain({6, 7}), "TER", *gapped.chain({9}, name="B", moved=40.0)]
    filling = le.fill(gapped.pdb(tmp_path / "a.pdb", atoms, head=gapped.seqres()))
    assert "B.9 N: not filled" in remarks(filling.text())


def test_a_file_of_which_nothing_was_filled_stays_as_it_is(tmp_path):
    path = gapped.pdb(tmp_path / "a.pdb", gapped.chain({6, 7}))
    filling = le.fill(path)
    assert not changes_of(filling)
    assert filling.text() == path.read_text()
    assert filling.write(tmp_path / "b.pdb").read_text() == path.read_text()


def test_a_modified_nucleotide_gets_the_name_of_what_was_built(tmp_path):
    head = gapped.seqres()
    head = [head[0][:39] + "PSU" + head[0][42:], *head[1:]]
    filling = le.fill(gapped.pdb(tmp_path / "a.pdb", gapped.chain({6, 7}), head=head))
    (strand,) = filling.strands
    assert strand.sequence == "UU"
    assert any("A.PSU6 is built as its parent base, U" in one for one in strand.remarks)
    structure = gapped.read(filling.write(tmp_path / "filled.pdb"))
    assert [r.name for r in gapped.neighbours(structure)[5:7]] == ["U", "U"]


def test_atoms_are_added_in_the_right_model(tmp_path):
    models = [gapped.chain(), gapped.chain({6, 7}, model=2)]
    path = gapped.pdb(tmp_path / "a.pdb", *models, head=gapped.seqres())
    changes = changes_of(le.fill(path))
    assert {one.model for one in changes.added} == {1}
    assert [one.after for one in changes.added] == [("A", 5, ""), ("A", 6, "")]


def test_the_categories_of_an_mmcif_file_follow(tmp_path):
    from gemmi import cif

    filling = le.fill(gapped.gapped_cif(tmp_path / "a.cif", {6, 7}))
    block = cif.read_string(filling.text()).sole_block()
    assert len(block.find("_pdbx_unobs_or_zero_occ_residues.", ["auth_seq_id"])) == 0
    scheme = block.find("_pdbx_poly_seq_scheme.", ["seq_id", "auth_seq_num", "pdb_mon_id"])
    rows = {row[0]: (row[1], row[2]) for row in scheme}
    assert rows["6"] == ("6", "U")
    assert rows["7"] == ("7", "U")
    assert "loopelastica" in list(block.find_values("_software.name"))
    remarks = [cif.as_string(text) for text in block.find_values("_database_PDB_remark.text")]
    assert any("A.6-7 UU" in text for text in remarks)
    table = block.find("_atom_site.", ["label_seq_id", "auth_seq_id", "label_comp_id"])
    built = {tuple(row) for row in table if row[0] in ("6", "7")}
    assert built == {("6", "6", "U"), ("7", "7", "U")}
