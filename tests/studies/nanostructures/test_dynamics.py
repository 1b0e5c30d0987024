import pytest

from loopelastica.errors import MissingDependencyError
from loopelastica.studies.nanostructures import dynamics, lammps


@pytest.fixture(autouse=True)
def _program():
    pytest.importorskip("scadnano")
    try:
        lammps.program().close()
    except MissingDependencyError as error:
        pytest.skip(str(error))


def test_a_design_without_refused_strands_is_run_from_rods_and_from_chords(family, monkeypatch):
    monkeypatch.setattr(dynamics, "FAMILIES", [family("spacers")])
    rods, chords = dynamics.compared(2026, 50, progress=False)
    assert (rods["way"], chords["way"]) == ("rods", "straight chords")
    assert rods["design"] == chords["design"]
    assert rods["nucleotides"] == chords["nucleotides"] > 100
    assert rods["outcome"] == "ran"
    assert rods["energy_highest"] >= rods["energy_begin"]


def test_what_lammps_reports_is_the_outcome(family, monkeypatch):
    monkeypatch.setattr(dynamics, "FAMILIES", [family("hairpins")])
    _, chords = dynamics.compared(1, 50, progress=False)
    assert "ERROR" in chords["outcome"]
    assert "\n" not in chords["outcome"]
    assert "hottest_K" not in chords
