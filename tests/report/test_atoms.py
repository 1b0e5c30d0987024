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
        # MDAnalysis puts short residue names at the left of their three columns
        return line[12:17], line[17:20].strip(), line[21:27], line[27:54]

    stem = [identity(line) for line in source if line[22:26].strip() not in loop]
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
    assert first["status"] == "converged"
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
    known = ("ATOM  ", "HEADER", "TITLE ", "REMARK", "CRYST1", "MODEL ", "ENDMDL", "CONECT", "END")
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
