"""The stress report: every case is run, and what is written can be read."""

import csv
import dataclasses
import json

import numpy as np
import pytest

import loopelastica as le
from loopelastica.studies.bench import stability as bench

# near-aligned ends: the plane of the small bow is decided by 1e-6 terms, not each is solved
HARD = "tangent at 1e-6 to the chord, both"


@pytest.fixture(autouse=True)
def tiny(monkeypatch):
    monkeypatch.setattr(bench, "_LEAST", 4)
    monkeypatch.setattr(bench, "_SHARE", 10**6)
    monkeypatch.setattr(bench, "_TIMED", (2, 2))
    monkeypatch.setattr(bench, "_CHECKED", (1, 1))


@pytest.mark.slow
def test_a_run_writes_every_case_and_no_nan(tmp_path):
    rows = bench.run(tmp_path / "out", progress=False)
    assert [row["case"] for row in rows] == [case.name for case in bench.all_cases()]
    for row in rows:
        if row["case"] == HARD:
            continue
        assert row["right"] == row["sample"] == 4, row
        if row["expected"] == "converged":
            assert row["residual_max"] < 1e-9
            assert row["checked"] == 1
    for name in ("stability.csv", "stability.md", "failures.json"):
        text = (tmp_path / "out" / name).read_text(encoding="utf-8").lower()
        assert "nan" not in text.replace("tangent", "")
    with (tmp_path / "out" / "stability.csv").open(newline="", encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == len(rows)
    table = (tmp_path / "out" / "stability.md").read_text(encoding="utf-8").splitlines()[4:]
    assert len(table) == len(rows) + 2
    assert len({line.count("|") for line in table}) == 1
    assert (tmp_path / "out" / "stability.png").read_bytes().startswith(b"\x89PNG")


def test_a_second_run_takes_what_the_first_one_measured(tmp_path, monkeypatch):
    few = bench.all_cases()[:2]
    monkeypatch.setattr(bench, "all_cases", lambda: few)
    rows = bench.run(tmp_path, progress=False)
    monkeypatch.setattr(bench, "_measure", lambda *_: pytest.fail("measured again"))
    assert bench.run(tmp_path, progress=False) == rows


def test_failures_are_kept_as_clampings(tmp_path, monkeypatch):
    (straight,) = (case for case in bench.all_cases() if case.name == "straight")
    beyond = bench.Case("beyond", straight.draw, 4, expected=le.Status.UNREACHABLE)
    monkeypatch.setattr(bench, "all_cases", lambda: [beyond])
    (row,) = bench.run(tmp_path, progress=False)
    assert row["right"] == 0
    assert row["others"] == "4 converged"
    kept = json.loads((tmp_path / "failures.json").read_text())
    assert le.Clamping(kept[0]["position"], kept[0]["rotation"]).position[2] == 1.0


def test_a_pose_that_is_no_number_is_null_in_the_file(tmp_path, monkeypatch):
    (broken,) = (case for case in bench.all_cases() if case.name == "no pose")
    hoped = bench.Case("hoped", broken.draw, 4)
    monkeypatch.setattr(bench, "all_cases", lambda: [hoped])
    (row,) = bench.run(tmp_path, progress=False)
    assert row["right"] == 0
    kept = json.loads((tmp_path / "failures.json").read_text(), parse_constant=pytest.fail)
    assert kept[0]["position"][1] is None
    assert bench.run(tmp_path, progress=False) == [row]


@pytest.mark.parametrize(("residual", "right"), [(1e-10, 4), (1e-8, 0)])
def test_a_rod_that_misses_its_end_is_not_right(tmp_path, monkeypatch, residual, right):
    case = next(case for case in bench.all_cases() if case.name == "straight")
    solved = bench.solve_batch

    def with_residual(*args, **options):
        batch = solved(*args, **options)
        return dataclasses.replace(batch, residual=np.full(len(batch), residual))

    monkeypatch.setattr(bench, "all_cases", lambda: [case])
    monkeypatch.setattr(bench, "solve_batch", with_residual)
    (row,) = bench.run(tmp_path, progress=False)
    assert row["right"] == right
