import csv
import dataclasses
import json

import pytest

from loopelastica._files import data_path
from loopelastica.studies.simulation import study
from loopelastica.studies.simulation.acceptance import FORCE_FIELDS

pytest.importorskip("openmm")


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "in"
    folder.mkdir()
    text = data_path("hairpins/2koc.pdb").read_text().split("ENDMDL")[0]
    (folder / "a.pdb").write_text(text + "ENDMDL\nEND\n")
    (folder / "b.pdb").write_text("nothing\n")
    return folder


def results(out):
    with (out / "simulation.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    return rows, json.loads((out / "simulation.json").read_text())


def test_the_study_of_one_hairpin_says_who_is_accepted_and_who_is_no_model(
    folder, tmp_path, monkeypatch
):
    quick = tuple(dataclasses.replace(field, minimized=False) for field in FORCE_FIELDS[:2])
    monkeypatch.setattr(study, "FORCE_FIELDS", quick)
    monkeypatch.setattr(study, "BUILT", {"RNA": ("GGC(GCAA)GCC",), "DNA": ("GGC(GAA)GCC",)})
    text = study.run(folder, tmp_path / "out")
    rows, summary = results(tmp_path / "out")
    assert {row["source"] for row in rows} == {"built", "folded", "native"}
    failed = [row for row in rows if row["failure"]]
    assert [row["name"] for row in failed] == ["b.pdb"]
    assert len(summary["no model"]) == 1
    # 2KOC has a phosphate at its 5' end
    assert len(summary["refused"]) == 4
    for group in summary["groups"]:
        as_it_is = group["source"] == "built"
        assert (group["accepted"], group["accepted_bare"]) == (as_it_is, not as_it_is)
        assert group["models"] == 1
        assert group["force"]["median"] == group["force"]["most"]
        assert group["shift_A"] is None
    assert "no model:" in text
    assert "| built |" in text


def test_a_refused_file_is_named_with_the_reason_and_tried_without_its_phosphate(
    folder, tmp_path, monkeypatch
):
    quick = (dataclasses.replace(FORCE_FIELDS[1], minimized=False),)
    monkeypatch.setattr(study, "FORCE_FIELDS", quick)
    monkeypatch.setattr(study, "BUILT", {})
    study.run(folder, tmp_path / "out")
    rows, summary = results(tmp_path / "out")
    assert [row["option"] for row in rows if not row["failure"]] == ["", "without 5' phosphate"] * 2
    assert len(summary["refused"]) == 2
    assert "residue 0 (G)" in summary["refused"][0]
    assert summary["refused"][0].startswith("folded a.pdb A6-9")


@pytest.mark.slow
def test_minimized_models_keep_hands_and_chain(folder, tmp_path, monkeypatch):
    monkeypatch.setattr(study, "FORCE_FIELDS", FORCE_FIELDS[:1])
    monkeypatch.setattr(study, "BUILT", {"RNA": ("GGC(GCAA)GCC",), "DNA": ("GGC(GAA)GCC",)})
    study.run(folder, tmp_path / "out")
    _, summary = results(tmp_path / "out")
    minimized = [group for group in summary["groups"] if group["minimized"]]
    assert len(minimized) == 4
    for group in minimized:
        assert group["sound"] == 1
        assert 0.0 < group["shift_A"]["median"] < 2.0
