import sys

import numpy as np
import pytest

import loopelastica as le
from loopelastica.errors import MissingDependencyError, StructureError
from loopelastica.molecule.nucleotides import BACKBONE

KT = 0.0083144626 * 300.0


@pytest.fixture
def topology(koc_lines, tmp_path):
    app = pytest.importorskip("openmm.app")
    path = tmp_path / "koc.pdb"
    path.write_text("\n".join([*koc_lines, "END", ""]))
    return app.PDBFile(str(path)).topology


def energy_kT(force, topology, places_A):
    openmm = pytest.importorskip("openmm")
    system = openmm.System()
    for row in range(topology.getNumAtoms()):
        system.addParticle(1.0 + row % 7)
    system.addForce(force)
    platform = openmm.Platform.getPlatformByName("Reference")
    context = openmm.Context(system, openmm.VerletIntegrator(0.001), platform)
    context.setPositions(0.1 * places_A)
    return context.getState(energy=True).getPotentialEnergy()._value / KT


def on_trace(fold, topology):
    """All atoms of each loop nucleotide at its point of the first candidate's trace."""
    numbers = [str(number) for number in fold.hairpin.resid]
    places = np.zeros((topology.getNumAtoms(), 3))
    for residue in topology.residues():
        if residue.id in numbers:
            for atom in residue.atoms():
                places[atom.index] = fold.candidates[0].trace[numbers.index(residue.id)]
    return places


def test_a_loop_on_its_trace_has_no_energy_and_an_expected_error_away_3_halves_kT(fold, topology):
    force = le.restraints(fold, topology)
    assert force.getNumBonds() == 4
    places = on_trace(fold, topology)
    assert energy_kT(le.restraints(fold, topology), topology, places) == pytest.approx(0, abs=1e-6)
    places[:, 0] += fold.candidates[0].expected_rmsd_A[1]
    assert energy_kT(force, topology, places) == pytest.approx(4 * 1.5, rel=1e-4)


def test_atoms_outside_the_backbone_are_free(fold, topology):
    places = on_trace(fold, topology)
    for atom in topology.atoms():
        if atom.name not in BACKBONE:
            places[atom.index] += 30.0
    force = le.restraints(fold, topology)
    assert energy_kT(force, topology, places) == pytest.approx(0, abs=1e-6)


def test_it_is_the_centroid_that_is_held_each_atom_counting_the_same(fold, topology):
    places = on_trace(fold, topology)
    for atom in topology.atoms():
        places[atom.index, 1] += {"P": 2.0, "O5'": 2.0, "O3'": -4.0}.get(atom.name, 0.0)
    force = le.restraints(fold, topology)
    assert energy_kT(force, topology, places) == pytest.approx(0, abs=1e-6)


def test_a_built_hairpin_is_restrained_by_its_own_numbers(tmp_path):
    app = pytest.importorskip("openmm.app")
    model = le.build("GGC(GAA)GCC", rna=False, hydrogens=True)
    model.write(tmp_path / "hairpin.pdb")
    pdb = app.PDBFile(str(tmp_path / "hairpin.pdb"))
    force = le.restraints(model, pdb.topology)
    assert force.getNumBonds() == 3
    places = 10.0 * np.array(pdb.getPositions(asNumpy=True)._value)
    second = le.build("GGC(GAA)GCC", rna=False, candidates=2).candidates[1]
    own, first = le.restraints(second, pdb.topology), le.restraints(second, pdb.topology, rank=1)
    assert own.getBondParameters(0) != first.getBondParameters(0)
    # a built model follows its line to a fraction of the error to expect
    assert 0.0 < energy_kT(force, pdb.topology, places) < 3 * 1.5


def test_what_is_missing_or_wrong_is_said(fold, topology, monkeypatch):
    app = pytest.importorskip("openmm.app")
    with pytest.raises(StructureError, match=r"A\.U6: no atom P of that chain and number"):
        le.restraints(fold, app.Topology())
    with pytest.raises(ValueError, match="`rank` is 99; the loop has"):
        le.restraints(fold, topology, rank=99)
    with pytest.raises(ValueError, match="`loop` is 3; it must be a folded loop"):
        le.restraints(3, topology)
    with pytest.raises(ValueError, match="`temperature_K`"):
        le.restraints(fold, topology, temperature_K=0.0)
    monkeypatch.setitem(sys.modules, "openmm", None)
    with pytest.raises(MissingDependencyError, match=r"need OpenMM; install it with"):
        le.restraints(fold, topology)
