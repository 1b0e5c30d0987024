"""What other programs make of the files; their warnings are errors here."""

import warnings

import numpy as np
import pytest
from atom_lines import line

from loopelastica.report.atoms import write_atoms

CELL = "CRYST1   64.981   63.389   61.921  90.00  90.20  90.00 P 1 21 1      4"
FAR = np.array([40.0, 40.0, 40.0])


@pytest.fixture
def rich(of_lines, koc_lines, tmp_path):
    """Files with hydrogens, without the phosphate, with ions, waters and a unit cell."""
    others = [
        line(900 + k, name, resname, "A", 101 + k, FAR + 5 * k, kind="HETATM", element=element)
        for k, (name, resname, element) in enumerate(
            [("MG", "MG", "MG"), ("O", "HOH", "O"), ("O", "HOH", "O")]
        )
    ]
    lines = [CELL, *koc_lines, "TER", *others]
    atoms = of_lines(lines, hydrogens=True, no_5_phosphate=True, separate=True)
    out = tmp_path / "out"
    out.mkdir()
    write_atoms(out, atoms)
    return out, atoms


def expected(atoms, model):
    """Name, number and place of every atom of a model."""
    held = atoms.held
    held.place(model)
    return [
        (r.number, a.name, one.pos.tolist())
        for (r, a), one in zip(held.rows, (c.atom for c in held.gemmi[0].all()), strict=True)
    ]


@pytest.mark.parametrize("kind", ["pdb", "cif"])
def test_gemmi(rich, kind):
    gemmi = pytest.importorskip("gemmi")
    out, atoms = rich
    structure = gemmi.read_structure(str(out / f"atoms.{kind}"))
    assert len(structure) == len(atoms.written)
    assert structure.cell.parameters == pytest.approx((64.981, 63.389, 61.921, 90.0, 90.2, 90.0))
    for found, model in zip(structure, atoms.written, strict=True):
        assert [
            (c.residue.seqid.num, c.atom.name, c.atom.pos.tolist()) for c in found.all()
        ] == expected(atoms, model)


@pytest.mark.parametrize("name", ["atoms.pdb", "atoms_1.pdb", "atoms_2.cif"])
def test_mdanalysis(rich, name):
    import MDAnalysis as mda

    out, atoms = rich
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # of its own reader
        warnings.simplefilter("ignore", DeprecationWarning)
        universe = mda.Universe(out / name)
    models = {"atoms.pdb": atoms.written, "atoms_1.pdb": atoms.written[:1]}
    models = models.get(name, atoms.written[1:])
    assert len(universe.trajectory) == len(models)
    for _, model in zip(universe.trajectory, models, strict=True):
        numbers, names, places = zip(*expected(atoms, model), strict=True)
        assert universe.atoms.resids.tolist() == list(numbers)
        assert universe.atoms.names.tolist() == list(names)
        np.testing.assert_allclose(universe.atoms.positions, places, atol=1e-5)
    if len(models) == 1:
        # of several models MDAnalysis reads no unit cell
        np.testing.assert_allclose(universe.dimensions[:3], [64.981, 63.389, 61.921], atol=1e-3)


@pytest.mark.parametrize("kind", ["pdb", "cif"])
def test_openmm_reads_all_models_and_accepts_them_as_they_are(rich, kind):
    pytest.importorskip("openmm")
    from openmm import app, unit

    out, atoms = rich
    read = {"pdb": app.PDBFile, "cif": app.PDBxFile}[kind](str(out / f"atoms.{kind}"))
    assert read.getNumFrames() == len(atoms.written)
    for frame, model in enumerate(atoms.written):
        places = read.getPositions(asNumpy=True, frame=frame).value_in_unit(unit.angstrom)
        np.testing.assert_allclose(places, [at for *_, at in expected(atoms, model)], atol=1e-6)
    modeller = app.Modeller(read.topology, read.positions)
    modeller.delete([r for r in read.topology.residues() if r.name in ("HOH", "MG")])
    field = app.ForceField("amber14/RNA.OL3.xml")
    assert field.createSystem(modeller.topology).getNumParticles() == len(atoms.held.rows) - 3


def test_rdkit_reads_one_molecule_of_each_strand(rich, capfd):
    from rdkit import Chem

    out, atoms = rich
    mol = Chem.MolFromPDBFile(str(out / "atoms_1.pdb"), removeHs=False)
    assert mol.GetNumAtoms() == len(atoms.held.rows)
    assert "WARNING" not in capfd.readouterr().err
    sizes = sorted(len(part) for part in Chem.GetMolFrags(mol))
    # HO5' is no atom of the wwPDB's nucleotide with a phosphate, which RDKit goes by
    assert sizes[-1] >= len(atoms.held.rows) - 4


@pytest.mark.parametrize("kind", ["pdb", "cif"])
def test_biotite(rich, kind):
    structure_io = pytest.importorskip("biotite.structure.io")
    assert structure_io is not None
    from biotite.structure.io import pdb, pdbx

    out, atoms = rich
    path = out / f"atoms.{kind}"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        stack = (
            pdb.PDBFile.read(path).get_structure()
            if kind == "pdb"
            else pdbx.get_structure(pdbx.CIFFile.read(path))
        )
    assert stack.shape == (len(atoms.written), len(atoms.held.rows))
    for found, model in zip(stack, atoms.written, strict=True):
        numbers, names, places = zip(*expected(atoms, model), strict=True)
        assert found.res_id.tolist() == list(numbers)
        assert found.atom_name.tolist() == list(names)
        np.testing.assert_allclose(found.coord, places, atol=1e-4)


def test_it_is_read_by_this_program_again(rich):
    from loopelastica.molecule.hairpins import find_hairpins
    from loopelastica.molecule.nucleotides import read_structure

    out, atoms = rich
    for kind in ("pdb", "cif"):
        structure = read_structure(out / f"atoms.{kind}")
        assert structure.n_models == len(atoms.written)
        (hairpin,) = find_hairpins(structure)
        assert hairpin.closing_pair == atoms.fold.hairpin.closing_pair
