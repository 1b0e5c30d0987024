"""The loop by itself."""

from rdkit import Chem

from loopelastica.report.sdf import write_sdf


def test_there_is_a_record_for_each_model(atoms, tmp_path):
    write_sdf(tmp_path / "loop.sdf", atoms.written)
    found = list(Chem.SDMolSupplier(str(tmp_path / "loop.sdf")))
    assert [mol.GetProp("_Name") for mol in found] == ["candidate 1", "candidate 2"]
    assert {mol.GetProp("sequence") for mol in found} == {"UUCG"}
