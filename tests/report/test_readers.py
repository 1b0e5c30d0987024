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


REAL = ("1ac7.pdb.gz", "1idx.pdb.gz", "1zih_rosetta.pdb.gz", "1kr8.pdb.gz", "boxb_nochain.pdb.gz",
        "1ehz.cif.gz", "430d.pdb.gz", "1k5i_c36.pdb.gz", "4gxy.pdb.gz")  # fmt: skip
# with other molecules, or nucleotides that the force field does not know
NOT_IN_OL = REAL[1:2] + REAL[4:]


@pytest.mark.slow
@pytest.mark.parametrize("name", REAL)
def test_files_of_real_structures_are_read_with_every_atom_where_it_was(
    hairpin_folder, tmp_path, name
):
    gemmi = pytest.importorskip("gemmi")
    import loopelastica as le
    from loopelastica.molecule.nucleotides import read_structure
    from loopelastica.report.atoms import LoopAtoms

    structure = read_structure(hairpin_folder / name)
    folds = le.fold(structure, all_models=False, max_candidates=1, surroundings=False)
    loop = next(one for one in folds if one.failure is None)
    models = tuple(le.build_atoms(structure, loop))
    atoms = LoopAtoms(structure, loop, models, structure.positions(0), hydrogens=True,
                      no_5_phosphate=True)  # fmt: skip
    write_atoms(tmp_path, atoms)
    wanted = expected(atoms, models[0])
    for kind in ("pdb", "cif"):
        read = gemmi.read_structure(str(tmp_path / f"atoms.{kind}"))
        # gemmi brings the parts of a chain together
        found = [(c.residue.seqid.num, c.atom.name, c.atom.pos.tolist()) for c in read[0].all()]
        assert sorted(found) == sorted(wanted)
    lines = (tmp_path / "atoms.pdb").read_text().splitlines()
    assert all(len(one) <= 80 and one.isascii() for one in lines)
    nucleotides = [r for r in atoms.assembly.residues if r.nucleotide is not None]
    assert all(r.hydrogens for r in nucleotides)
    if name not in NOT_IN_OL:
        app = pytest.importorskip("openmm.app")
        read = app.PDBFile(str(tmp_path / "atoms.pdb"))
        field = app.ForceField("amber14/RNA.OL3.xml", "amber14/DNA.OL15.xml")
        assert field.createSystem(read.topology).getNumParticles() == len(wanted)


@pytest.mark.slow
def test_a_whole_ribosome_is_written(hairpin_folder, tmp_path):
    gemmi = pytest.importorskip("gemmi")
    from loopelastica.atoms.model import build_atoms
    from loopelastica.folding.fold import fold_hairpins
    from loopelastica.folding.options import FoldOptions
    from loopelastica.molecule.hairpins import find_hairpins
    from loopelastica.molecule.nucleotides import read_structure
    from loopelastica.report.atoms import LoopAtoms

    structure = read_structure(hairpin_folder / "1s72.pdb.gz")
    hairpin = next(h for h in find_hairpins(structure) if len(h) == 4)
    options = FoldOptions(all_models=False, max_candidates=2, surroundings=False)
    (loop,) = fold_hairpins(structure, [hairpin], options)
    models = tuple(build_atoms(structure, loop))
    atoms = LoopAtoms(structure, loop, models, structure.positions(0))
    write_atoms(tmp_path, atoms)
    n = len(atoms.held.rows)
    for kind in ("pdb", "cif"):
        read = gemmi.read_structure(str(tmp_path / f"atoms.{kind}"))
        assert [model.count_atom_sites() for model in read] == [n] * len(atoms.written)
    # with hydrogens there are more atoms than serial numbers
    atoms = LoopAtoms(structure, loop, models, structure.positions(0), hydrogens=True)
    assert any("serial numbers" in remark for remark in atoms.remarks)


def test_it_is_read_by_this_program_again(rich):
    from loopelastica.molecule.hairpins import find_hairpins
    from loopelastica.molecule.nucleotides import read_structure

    out, atoms = rich
    for kind in ("pdb", "cif"):
        structure = read_structure(out / f"atoms.{kind}")
        assert structure.n_models == len(atoms.written)
        (hairpin,) = find_hairpins(structure)
        assert hairpin.closing_pair == atoms.fold.hairpin.closing_pair
