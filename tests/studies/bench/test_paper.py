"""The paper's studies run again: what is written, and that an interruption costs nothing."""

import csv
import shutil

import numpy as np
import pytest

from loopelastica.studies.bench import paper as bench

TIMES = ("time_ms",)


@pytest.fixture(scope="module", autouse=True)
def small():
    """A few cells of little work."""
    cells = bench.cells_of

    def few(figures):
        return [
            cell for cell in cells(figures) if cell.delta == 0.5 and cell.l + cell.figure in (5, 7)
        ]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bench, "_CHUNK", 4)
        patch.setattr(bench, "cells_of", few)
        yield


def without_times(rows):
    return [{k: v for k, v in row.items() if k not in TIMES} for row in rows]


@pytest.mark.slow
def test_a_run_writes_tables_and_pictures(tmp_path):
    rows = bench.run(tmp_path / "out", sample=12, progress=False)
    assert len(rows) == 3 + 2
    for row in rows:
        assert row["tested"] == 12
        assert row["success_percent"] >= 90
        assert row["time_ms"] > 0
    with (tmp_path / "out" / "paper.csv").open(newline="") as file:
        written = list(csv.DictReader(file))
    assert [int(row["tested"]) for row in written] == [12] * 5
    with (tmp_path / "out" / "own.csv").open(newline="") as file:
        own = list(csv.DictReader(file))
    # once for each set of rods, whatever the printed method's error and symmetry
    assert [(row["tested"], float(row["success_percent"])) for row in own] == [("12", 100.0)] * 2
    assert all(float(row["residual_max"]) < 1e-9 for row in own)
    text = (tmp_path / "out" / "paper.md").read_text(encoding="utf-8")
    assert "57,740" in text
    assert "53,170" in text
    assert "| 99.9 |" in text
    for number in (3, 4, 5):
        picture = (tmp_path / "out" / f"fig{number}.png").read_bytes()
        assert picture.startswith(b"\x89PNG")


@pytest.mark.slow
def test_an_interrupted_run_goes_on_to_the_same_table(tmp_path, monkeypatch):
    expected = bench.run(tmp_path / "whole", sample=13, figures=(3,), progress=False)
    measure, calls = bench._measure, []

    def interrupted(rods, solver):
        calls.append(len(rods))
        if len(calls) == 8:
            raise KeyboardInterrupt
        return measure(rods, solver)

    out = tmp_path / "halves"
    monkeypatch.setattr(bench, "_measure", interrupted)
    with pytest.raises(KeyboardInterrupt):
        bench.run(out, sample=13, figures=(3,), progress=False)
    assert not list(out.glob("**/.*"))
    kept = sorted((out / "partial").glob("*.npz"))
    assert kept
    assert not (out / "paper.csv").exists()
    monkeypatch.setattr(bench, "_measure", measure)
    rows = bench.run(out, sample=13, figures=(3,), progress=False)
    assert without_times(rows) == without_times(expected)
    # nothing is measured again
    monkeypatch.setattr(bench, "_measure", lambda *_: pytest.fail("measured again"))
    assert bench.run(out, sample=13, figures=(3,), progress=False) == rows


@pytest.fixture(scope="module")
def five(tmp_path_factory):
    """Rows of five rods, and their folder."""
    out = tmp_path_factory.mktemp("five") / "out"
    return bench.run(out, sample=5, figures=(3,), seed=1, progress=False), out


@pytest.mark.slow
def test_a_larger_sample_continues_a_smaller_one(five, tmp_path):
    small, out = five
    shutil.copytree(out, tmp_path / "out")
    larger = bench.run(tmp_path / "out", sample=9, figures=(3,), seed=1, progress=False)
    at_once = bench.run(tmp_path / "other", sample=9, figures=(3,), seed=1, progress=False)
    assert [row["tested"] for row in small] == [5] * 3
    assert without_times(larger) == without_times(at_once)


@pytest.mark.slow
def test_damaged_partial_results_are_measured_again(five, tmp_path):
    expected, out = five
    shutil.copytree(out, tmp_path / "out")
    partial = sorted((tmp_path / "out" / "partial").glob("*.npz"))
    assert len(partial) > 1
    for k, path in enumerate(partial):
        path.write_bytes((b"", b"PK\x03\x04 not an archive")[k % 2])
    again = bench.run(tmp_path / "out", sample=5, figures=(3,), seed=1, progress=False)
    assert without_times(again) == without_times(expected)


@pytest.mark.slow
def test_another_seed_does_not_take_over_results(five, tmp_path):
    first, out = five
    shutil.copytree(out, tmp_path / "out")
    second = bench.run(tmp_path / "out", sample=5, figures=(3,), seed=2, progress=False)
    assert without_times(first) != without_times(second)


def test_bad_arguments_are_named(tmp_path):
    with pytest.raises(ValueError, match="`sample`"):
        bench.run(tmp_path, sample=0)
    with pytest.raises(ValueError, match="`figures`"):
        bench.run(tmp_path, figures=(6,))


@pytest.mark.slow
def test_every_row_has_its_iterations(five):
    rows, _ = five
    assert np.isfinite([row["iterations"] for row in rows]).all()
