import dataclasses
import json
import warnings

import numpy as np
import pytest
from rdkit import Chem

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.molecule.nucleotides import read_structure
from loopelastica.report.atoms import LoopAtoms, write_atoms, write_pdb


@pytest.fixture(scope="module")
def folder(atoms, tmp_path_factory):
    out = tmp_path_factory.mktemp("atoms")
    write_atoms(out, atoms)
    return out


def records(path, model=1):
    text = path.read_text().split("ENDMDL")[model - 1]
    return [line for line in text.splitlines() if line.startswith(("ATOM", "HETATM"))]


def test_stem_atoms_keep_number_name_and_every_digit_of_their_place(folder):
    source = records(data_path("hairpins/2koc.pdb"))
    written = records(folder / "atoms.pdb")
    loop = {"6", "7", "8", "9"}

    def identity(line):
        return line[12:27], line[27:54], line[54:66]

    stem = [
        identity(line)
        for line in source
        if line[22:26].strip() not in loop and line[76:78].strip() != "H"
    ]
    assert [identity(line) for line in written if line[22:26].strip() not in loop] == stem
    assert len(written) > len(stem)


def test_mdanalysis_reads_the_models_with_sequence_and_bonds(folder, atoms):
    import MDAnalysis as mda

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        universe = mda.Universe(folder / "atoms.pdb")
    assert "".join(universe.residues.resnames) == "GGCACUUCGGUGCC"
    assert universe.residues.resids.tolist() == list(range(1, 15))
    assert len(universe.trajectory) == len(atoms.written)
    loop = universe.select_atoms("resid 6:9")
    model = atoms.written[0]
    np.testing.assert_allclose(
        loop.positions, model.positions_A[model.molecule.loop_atoms], atol=6e-4
    )
    mine = set(loop.indices)
    found = {tuple(b.indices) for b in universe.bonds if mine & set(b.indices)}
    inside = set(model.molecule.loop_atoms)
    assert len(found) == sum(bool(inside & set(bond)) for bond in model.molecule.bonds)
    lengths = [b.length() for b in universe.bonds if mine & set(b.indices)]
    assert min(lengths) > 1.15
    assert max(lengths) < 1.7


def test_gemmi_reads_pdb_and_mmcif_alike(folder):
    gemmi = pytest.importorskip("gemmi")
    pdb, cif = (gemmi.read_structure(str(folder / f"atoms.{kind}")) for kind in ("pdb", "cif"))
    assert len(pdb) == len(cif)
    sequence = gemmi.one_letter_code([r.name for r in cif[0][0]])
    assert sequence.upper() == "GGCACUUCGGUGCC"
    for one, other in zip(pdb[0].all(), cif[0].all(), strict=True):
        assert (one.residue.seqid, one.atom.name) == (other.residue.seqid, other.atom.name)
        assert one.atom.pos.dist(other.atom.pos) < 1e-6


def test_rdkit_reads_the_loop_with_bonds_charges_and_hands(folder, atoms):
    found = list(Chem.SDMolSupplier(str(folder / "loop.sdf")))
    assert len(found) == len(atoms.written)
    for mol, model in zip(found, atoms.written, strict=True):
        assert mol.GetProp("sequence") == "UUCG"
        want = Chem.Mol(model.molecule.mol)
        # the phosphorus has four different neighbours only because names are given to its oxygens
        assert mol.GetNumBonds() == want.GetNumBonds()
        assert Chem.GetFormalCharge(mol) == Chem.GetFormalCharge(want)
        assert mol.HasSubstructMatch(want, useChirality=True)


def test_rdkit_reads_the_structure_too(folder):
    mol = Chem.MolFromPDBFile(str(folder / "atoms.pdb"), sanitize=False, proximityBonding=True)
    names = {(a.GetPDBResidueInfo().GetResidueNumber(), a.GetPDBResidueInfo().GetName().strip())
             for a in mol.GetAtoms()}  # fmt: skip
    assert {(6, "P"), (9, "O3'"), (9, "N9")} <= names
    bonds = {
        tuple(
            (end.GetPDBResidueInfo().GetResidueNumber(), end.GetPDBResidueInfo().GetName().strip())
            for end in (bond.GetBeginAtom(), bond.GetEndAtom())
        )
        for bond in mol.GetBonds()
    }
    for k in range(5, 10):
        assert ((k, "O3'"), (k + 1, "P")) in bonds or ((k + 1, "P"), (k, "O3'")) in bonds


def test_the_report_is_json_with_every_check(folder, atoms):
    content = json.loads((folder / "atoms.json").read_text())
    assert content["models"] == [m.rank for m in atoms.written]
    assert content["nucleotides"][0] == {"file": "A.U6", "built": "U"}
    first = content["candidates"][0]
    checks = atoms.models[0].checks
    assert first["status"] == "converged"
    assert first["sound"] is True
    assert first["not_sound_because"] == []
    assert first["worst_bond_A"] == checks.worst_bond_A
    assert first["worst_angle_deg"] == checks.worst_angle_deg
    assert first["closest_contact_A"] == checks.closest_A
    assert first["checks"]["sound"] is True
    assert len(first["checks"]["pucker"]) == 4
    assert len(first["alternatives"]) == 2
    assert first["rmsd_A"] == pytest.approx(atoms.models[0].rmsd_A)


def test_two_runs_write_the_same_bytes(folder, atoms, tmp_path):
    write_atoms(tmp_path, atoms)
    names = sorted(path.name for path in folder.iterdir())
    assert names == sorted(path.name for path in tmp_path.iterdir())
    for name in names:
        assert (folder / name).read_bytes() == (tmp_path / name).read_bytes()


@pytest.mark.parametrize(("distance_A", "stays"), [(2.9, False), (3.1, True)])
def test_water_within_3_A_of_the_loop_gives_way(atoms, koc_lines, tmp_path, distance_A, stays):
    (model,) = atoms.written[:1]
    loop = model.positions_A[model.molecule.loop_atoms]
    away = loop - loop.mean(axis=0)
    out = int(np.argmax(np.linalg.norm(away, axis=1)))
    place = loop[out] + distance_A * away[out] / np.linalg.norm(away[out])
    x, y, z = place
    path = tmp_path / "wet.pdb"
    water = f"HETATM  900  O   HOH A 101    {x:8.3f}{y:8.3f}{z:8.3f}  1.00  0.00           O"
    path.write_text("\n".join([*koc_lines, water, "END", ""]))
    wet = read_structure(path)
    write_pdb(tmp_path / "atoms.pdb", LoopAtoms(wet, atoms.fold, (model,), wet.positions(0)))
    assert ("HOH" in (tmp_path / "atoms.pdb").read_text()) == stays


def test_no_name_of_a_chain_or_a_residue_breaks_a_record(tmp_path, write_cif):
    gemmi = pytest.importorskip("gemmi")
    structure = read_structure(write_cif(tmp_path / "odd.cif", "a\nb"))
    residues = structure.universe.residues
    residues[0].resname = "G\nX"
    (fold,) = le.fold(structure, all_models=False, max_candidates=1)
    (model,) = le.build_atoms(structure, fold)
    write_atoms(tmp_path, LoopAtoms(structure, fold, (model,), structure.positions(0)))
    known = ("ATOM  ", "HEADER", "TITLE ", "REMARK", "MODEL ", "ENDMDL", "CONECT", "END")
    lines = (tmp_path / "atoms.pdb").read_text(encoding="ascii").splitlines()
    assert all(line.startswith((*known, "TER")) for line in lines)
    assert {line[17:21].strip() for line in records(tmp_path / "atoms.pdb")} == {"G_X", *"ACGU"}
    text = (tmp_path / "atoms.cif").read_text()
    assert [s for s in text.splitlines() if s.startswith("data_")] == ["data_atoms"]
    assert len(gemmi.cif.read_string(text)) == 1
    assert (tmp_path / "loop.sdf").read_text().count("$$$$") == 1


def test_the_b_factors_of_the_loop_are_the_error_to_expect(folder, atoms):
    for k, model in enumerate(atoms.written, start=1):
        (candidate,) = (c for c in atoms.fold.candidates if c.rank == model.rank)
        lines = records(folder / "atoms.pdb", k)
        (of_loop,) = {float(s[60:66]) for s in lines if int(s[22:26]) in (6, 7, 8, 9)}
        expected = min(8 * np.pi**2 / 3 * candidate.expected_rmsd_A[1] ** 2, 999.0)
        assert of_loop == pytest.approx(expected, abs=0.006)
        assert {float(s[60:66]) for s in lines if int(s[22:26]) not in (6, 7, 8, 9)} == {10.0}
    remarks = [s for s in (folder / "atoms.pdb").read_text().splitlines() if "REMARK" in s]
    low, middle, high = atoms.fold.candidates[0].expected_rmsd_A
    expected = f"EXPECTED ERROR {middle:.1f} A (80 % BETWEEN {low:.1f} AND {high:.1f})"
    for text in ("CANDIDATE 1: straight rod", expected):
        assert any(text in s for s in remarks)


def unsound(model):
    checks = dataclasses.replace(
        model.checks, worst_angle_deg=12.3, worst_angle="1:C4'–1:O4'–1:C1'"
    )
    return dataclasses.replace(model, checks=checks)


def test_what_is_not_sound_is_left_out_with_the_reason(of_lines, koc_lines, atoms, tmp_path):
    first, second = atoms.models
    one = of_lines(koc_lines, models=(unsound(first), second), separate=True)
    write_atoms(tmp_path, one)
    content = json.loads((tmp_path / "atoms.json").read_text())
    assert content["models"] == [2]
    assert content["candidates"][0]["sound"] is False
    assert content["candidates"][0]["not_sound_because"] == ["angle 1:C4'–1:O4'–1:C1' off by 12°"]
    assert content["candidates"][0]["worst_angle_deg"] == 12.3
    text = (tmp_path / "atoms.pdb").read_text()
    assert "MODEL 1: CANDIDATE 2" in text
    assert "CANDIDATE 1 IS NOT SOUND AND LEFT OUT" in text
    assert text.count("\nMODEL  ") == 1
    assert not (tmp_path / "atoms_1.pdb").exists()
    assert one.columns(1)["atoms_not_sound_because"] == "angle 1:C4'–1:O4'–1:C1' off by 12°"


def test_where_nothing_is_sound_only_the_report_is_written(of_lines, koc_lines, atoms, tmp_path):
    none = of_lines(koc_lines, models=tuple(map(unsound, atoms.models)), hydrogens=True)
    out = tmp_path / "out"
    out.mkdir()
    write_atoms(out, none)
    assert [path.name for path in out.iterdir()] == ["atoms.json"]
    assert (
        "no candidate has sound atoms" in json.loads((out / "atoms.json").read_text())["remarks"][0]
    )
    with pytest.raises(ValueError, match="no sound one"):
        write_pdb(out / "atoms.pdb", none)
    assert [path.name for path in out.iterdir()] == ["atoms.json"]


def test_each_candidate_has_files_of_its_own_on_request(of_lines, koc_lines, tmp_path):
    gemmi = pytest.importorskip("gemmi")
    atoms = of_lines(koc_lines, separate=True)
    out = tmp_path / "out"
    out.mkdir()
    write_atoms(out, atoms)
    whole = gemmi.read_structure(str(out / "atoms.pdb"))
    for number, model in enumerate(atoms.written):
        for kind in ("pdb", "cif"):
            (one,) = gemmi.read_structure(str(out / f"atoms_{model.rank}.{kind}"))
            for mine, same in zip(one.all(), whole[number].all(), strict=True):
                assert mine.atom.name == same.atom.name
                assert mine.atom.pos.dist(same.atom.pos) < 1e-6
                assert mine.atom.b_iso == pytest.approx(same.atom.b_iso, abs=0.006)


def test_what_the_pdb_format_cannot_hold_is_mmcif_alone(of_lines, koc_lines, tmp_path, monkeypatch):
    monkeypatch.setattr("loopelastica.report.model_pdb.LAST_SERIAL", 100)
    atoms = of_lines(koc_lines, separate=True)
    out = tmp_path / "out"
    out.mkdir()
    write_atoms(out, atoms)
    names = {path.name for path in out.iterdir()}
    assert names == {"atoms.json", "atoms.cif", "loop.sdf", "atoms_1.cif", "atoms_2.cif"}
    assert "atoms.pdb is not written" in json.loads((out / "atoms.json").read_text())["remarks"][-1]


@pytest.mark.parametrize(
    ("convention", "names", "atom"),
    [
        ("amber", {"G5", "G", "C", "A", "U", "C3"}, "HO5'"),
        ("charmm", {"GUA", "CYT", "ADE", "URA"}, "H5T"),
    ],
)
def test_names_are_those_of_a_force_field_on_request(
    of_lines, koc_lines, convention, names, atom, tmp_path
):
    atoms = of_lines(koc_lines, hydrogens=True, no_5_phosphate=True, names=convention)
    write_pdb(tmp_path / "named.pdb", atoms)
    lines = records(tmp_path / "named.pdb")
    assert {line[17:20].strip() for line in lines} == names
    assert atom in {line[12:16].strip() for line in lines if int(line[22:26]) == 1}
    with pytest.raises(ValueError, match="`names` is 'gromos'"):
        of_lines(koc_lines, names="gromos")


def test_a_contact_that_was_not_reached_is_said(of_lines, koc_lines, atoms):
    (one, *_) = atoms.models
    far = dataclasses.replace(one, checks=dataclasses.replace(one.checks, contact_A=3.9))
    remarks = of_lines(koc_lines, models=(far,), contact="sheared").remarks
    assert any("candidate 1 did not reach the sheared pair" in one for one in remarks)
    assert any("up to 3.9 Å long, not 3.2 Å" in one for one in remarks)
    assert not any("sheared" in one for one in of_lines(koc_lines, models=(far,)).remarks)
    remarks = of_lines(koc_lines, models=(one,), contact="sheared").remarks
    assert any("U and G at the ends of the loop make no sheared pair" in one for one in remarks)


def test_the_figures_of_a_run_are_among_the_columns(atoms):
    figures = atoms.figures(1)
    assert figures["atoms_sound"] is True
    assert figures["atoms_worst_bond_A"] == atoms.models[0].checks.worst_bond_A
    assert figures.items() <= atoms.columns(1).items()
    assert set(atoms.figures(99).values()) == {None}


def test_a_nucleotide_that_becomes_its_parent_is_named(hairpin_folder):
    path = hairpin_folder / "1ehz.cif.gz"
    (loop,) = (x for x in le.fold(path, all_models=False, max_candidates=1) if len(x.hairpin) == 9)
    structure = read_structure(path)
    models = tuple(le.build_atoms(structure, loop))
    remarks = LoopAtoms(structure, loop, models, structure.positions(0)).remarks
    assert "A.YYG37 cannot be built and is written as G" in remarks
    assert "A.PSU39 cannot be built and is written as U" in remarks
    assert not any("OMC32" in one for one in remarks)
