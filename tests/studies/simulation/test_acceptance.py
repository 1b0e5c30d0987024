import dataclasses
import sys

import pytest

from loopelastica.atoms.terminals import without_phosphate
from loopelastica.errors import MissingDependencyError
from loopelastica.studies.simulation.acceptance import FORCE_FIELDS, accepted
from loopelastica.studies.simulation.cases import nucleotides, write_nucleotides

pytest.importorskip("openmm")

GBN2, AMBER, CHARMM = FORCE_FIELDS
LOOP = {("A", str(number)) for number in range(6, 10)}


@pytest.fixture
def native(koc_lines, tmp_path):
    """2KOC's nucleotides with hydrogens of ours, without its 5' phosphate."""
    (tmp_path / "koc.pdb").write_text("\n".join([*koc_lines, "END", ""]))
    first, *others = nucleotides(tmp_path / "koc.pdb")
    path = tmp_path / "native.pdb"
    write_nucleotides(path, [without_phosphate(first), *others])
    return path


@pytest.mark.parametrize(
    "field",
    [GBN2, AMBER, pytest.param(CHARMM, marks=pytest.mark.slow)],
    ids=lambda field: field.name,
)
def test_a_native_hairpin_is_accepted_by_each_force_field_for_RNA(native, field):
    row = accepted(native, dataclasses.replace(field, minimized=False), LOOP)
    assert row["refused"] is None
    assert row["force_heavy"] <= row["force"] < 150.0
    assert 0.0 < row["force_loop"] <= row["force"]
    assert row["atoms"] == 447


def test_the_minimum_is_lower_and_shifts_of_the_loop_are_told_from_the_stem(native):
    row = accepted(native, dataclasses.replace(AMBER, minimized=True), LOOP)
    assert row["energy_after"] < row["energy_before"]
    assert 0.0 < row["shift_on_stem_A"] <= row["shift_A"] + 0.5
    assert row["wrong_hands"] == 0
    assert row["chain_kept"]


def test_a_file_without_hydrogens_is_refused_with_a_sentence(native):
    lines = [line for line in native.read_text().splitlines() if line[76:78].strip() != "H"]
    native.write_text("\n".join(lines))
    row = accepted(native, AMBER, LOOP)
    assert "missing" in row["refused"]
    assert "http" not in row["refused"]


def test_what_is_no_structure_is_refused_and_does_not_raise(tmp_path):
    path = tmp_path / "empty.pdb"
    path.write_text("ATOM      1  P     G A   1      here     there   nowhere\n")
    assert accepted(path, AMBER, LOOP)["refused"]


def test_atoms_on_one_another_are_refused_for_their_infinite_energy(native):
    lines = native.read_text().splitlines()
    where = next(line[30:54] for line in lines if line[12:26] == " N1    G A   2")
    native.write_text(
        "\n".join(
            line[:30] + where + line[54:] if line[12:26] == " N1    C A  13" else line
            for line in lines
        )
    )
    assert "infinite" in accepted(native, AMBER, LOOP)["refused"]


def test_without_openmm_the_extra_is_named(native, monkeypatch):
    monkeypatch.setitem(sys.modules, "openmm", None)
    with pytest.raises(MissingDependencyError, match=r"loopelastica\[md\]"):
        accepted(native, AMBER, LOOP)
