"""mmCIF files of models."""

import gemmi
import numpy as np
import pytest
from atom_lines import is_hydrogen, line
from gemmi import cif

from loopelastica._version import __version__
from loopelastica.report.model_cif import cif_text
from loopelastica.report.model_pdb import pdb_text

FAR = np.array([60.0, 60.0, 60.0])


def block_of(atoms, **options):
    return cif.read_string(cif_text(atoms.held, atoms.written, None, **options)).sole_block()


def column(block, tag):
    return [cif.as_string(value) for value in block.find_values(tag)]


def test_the_categories_are_these_and_no_others(atoms):
    assert set(block_of(atoms).get_mmcif_category_names()) == {
        *("_entry.", "_entity.", "_entity_poly.", "_entity_poly_seq.", "_struct.", "_struct_asym."),
        *("_struct_keywords.", "_atom_type.", "_atom_site.", "_software.", "_database_PDB_remark."),
        "_loopelastica_model.",
    }


def test_the_polymer_has_its_type_and_sequence(atoms):
    block = block_of(atoms)
    assert column(block, "_entity_poly.type") == ["polyribonucleotide"]
    assert column(block, "_entity_poly.pdbx_seq_one_letter_code") == ["GGCACUUCGGUGCC"]
    assert column(block, "_entity_poly.pdbx_strand_id") == ["A"]
    assert column(block, "_entity_poly_seq.mon_id") == list("GGCACUUCGGUGCC")
    assert column(block, "_struct_asym.id") == ["A"]
    sequence = dict.fromkeys(zip(column(block, "_atom_site.label_seq_id"),
                                 column(block, "_atom_site.auth_seq_id"), strict=True))  # fmt: skip
    assert list(sequence) == [(str(k), str(k)) for k in range(1, 15)]


def test_the_program_is_in_the_software(atoms):
    block = block_of(atoms)
    assert column(block, "_software.name") == ["loopelastica"]
    assert column(block, "_software.version") == [__version__]


def test_each_model_has_its_figures(atoms):
    block = block_of(atoms)
    assert column(block, "_loopelastica_model.model_num") == ["1", "2"]
    assert column(block, "_loopelastica_model.rank") == [str(m.rank) for m in atoms.written]
    assert column(block, "_loopelastica_model.sound") == ["yes", "yes"]
    for name, values in {
        "energy_per_A": [c.energy_per_A for c in atoms.fold.candidates],
        "energy_kT": [c.energy_kT for c in atoms.fold.candidates],
        "worst_bond_A": [m.checks.worst_bond_A for m in atoms.models],
        "worst_angle_deg": [m.checks.worst_angle_deg for m in atoms.models],
        "closest_contact_A": [m.checks.closest_A for m in atoms.models],
        "expected_rmsd_A": [c.expected_rmsd_A[1] for c in atoms.fold.candidates],
        "rmsd_A": [m.rmsd_A for m in atoms.models],
    }.items():
        found = [float(value) for value in column(block, f"_loopelastica_model.{name}")]
        assert found == pytest.approx(values[: len(found)], rel=1e-3)


def test_every_atom_has_an_id_of_its_own_and_the_place_of_the_pdb_file(atoms):
    block = block_of(atoms)
    ids = column(block, "_atom_site.id")
    assert ids == [str(k) for k in range(1, len(ids) + 1)]
    assert column(block, "_atom_site.pdbx_PDB_model_num") == [
        str(k) for k in (1, 2) for _ in range(len(ids) // 2)
    ]
    mine = gemmi.make_structure_from_block(block)
    other = gemmi.read_pdb_string(pdb_text(atoms.held, atoms.written, None))
    for k in range(2):
        for one, same in zip(mine[k].all(), other[k].all(), strict=True):
            assert one.atom.pos.dist(same.atom.pos) < 1e-9
            assert one.atom.b_iso == pytest.approx(same.atom.b_iso, abs=0.006)


def test_a_real_unit_cell_is_kept_and_none_is_invented(of_lines, koc_lines):
    cell = "CRYST1   54.981   33.389   61.921  90.00  90.20  90.00 P 1 21 1      4"
    assert not block_of(of_lines(koc_lines)).find_mmcif_category("_cell.")
    block = block_of(of_lines([cell, *koc_lines], "cell.pdb"))
    assert column(block, "_cell.length_a") == ["54.981"]
    assert column(block, "_symmetry.space_group_name_H-M") == ["P 1 21 1"]


def test_each_molecule_that_is_no_polymer_has_a_label_of_its_own(of_lines, koc_lines):
    others = [
        line(900 + k, name, resname, "A", 101 + k, FAR + 5 * k, kind="HETATM", element=element)
        for k, (name, resname, element) in enumerate(
            [("MG", "MG", "MG"), ("O", "HOH", "O"), ("O", "HOH", "O"), ("MG", "MG", "MG")]
        )
    ]
    block = block_of(of_lines([*koc_lines, "TER", *others]))
    assert column(block, "_struct_asym.id") == list("ABCDE")
    assert column(block, "_struct_asym.entity_id") == list("12332")
    assert column(block, "_entity.type") == ["polymer", "non-polymer", "water"]


def test_two_strands_of_one_sequence_are_one_entity(of_lines, koc_lines):
    heavy = [one for one in koc_lines if not is_hydrogen(one)]
    copy = [f"{one[:21]}B{one[22:30]}{float(one[30:38]) + 60:8.3f}{one[38:]}" for one in heavy]
    block = block_of(of_lines([*heavy, *copy]))
    assert column(block, "_entity_poly.pdbx_strand_id") == ["A,B"]
    assert column(block, "_struct_asym.entity_id") == ["1", "1"]


def test_chains_without_a_name_get_one_each(of_lines, koc_lines):
    heavy = [f"{one[:21]} {one[22:]}" for one in koc_lines if not is_hydrogen(one)]
    copy = [f"{one[:30]}{float(one[30:38]) + 60:8.3f}{one[38:]}" for one in heavy]
    atoms = of_lines([*heavy, "TER", *copy, "TER"])
    assert dict.fromkeys(column(block_of(atoms), "_atom_site.auth_asym_id")) == {
        "A": None,
        "B": None,
    }
    # the PDB file has none, as the input
    assert {one[21] for one in pdb_text(atoms.held, atoms.written, None).splitlines()
            if one.startswith("ATOM")} == {" "}  # fmt: skip


def test_a_chain_of_several_letters_keeps_them(tmp_path, write_cif, atoms):
    from loopelastica.molecule.nucleotides import read_structure
    from loopelastica.report.atoms import LoopAtoms

    structure = read_structure(write_cif(tmp_path / "long.cif", "AB"))
    long = LoopAtoms(structure, atoms.fold, atoms.models, structure.positions(0))
    assert set(column(block_of(long), "_atom_site.auth_asym_id")) == {"AB"}
    text = pdb_text(long.held, long.written, None)
    assert "CHAIN AB IS WRITTEN AS A" in text
