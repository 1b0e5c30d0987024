"""How time and memory grow: what is measured, and what a run writes."""

import csv

import numpy as np
import pytest
from typer.testing import CliRunner

import loopelastica as le
from loopelastica.cli.app import app
from loopelastica.studies.bench import _poses as poses
from loopelastica.studies.bench import scaling as bench


def test_slope_is_the_power():
    x = [1.0, 10.0, 100.0]
    assert bench.slope(x, [3.0 * v**1.5 for v in x]) == pytest.approx(1.5)
    assert bench.slope([4.0, 4.0], [1.0, 2.0]) is None
    assert bench.slope([], []) is None


def test_any_chunking_solves_every_rod(monkeypatch):
    monkeypatch.setattr(bench, "_CHUNK", 7)
    row = bench.stream(17, 1, 1)
    assert row["rods"] == row["solved"] == 17
    assert row["residual_max"] < 1e-9
    assert row["memory_MB"] > 10


def test_a_row_of_its_own_process_has_memory_of_its_own():
    block = np.ones(40_000_000)
    row = bench._alone(3, 1, 1)
    assert row["solved"] == 3
    assert row["memory_MB"] < bench.peak_memory_MB()
    assert block[-1] == 1.0


def test_threads_are_asked_for_where_the_solver_has_them(monkeypatch):
    asked = []

    def with_threads(positions, rotations, threads=1):
        asked.append(threads)
        return le.solve_batch(positions, rotations)

    monkeypatch.setattr(bench, "solve_batch", with_threads)
    assert bench._thread_counts() == (1, 2)
    assert bench.stream(3, 2, 1)["solved"] == 3
    assert set(asked) == {2}
    monkeypatch.setattr(bench, "solve_batch", lambda positions, rotations: None)
    assert bench._thread_counts() == (1,)


def test_rods_have_the_length_asked_for(rng):
    rods = poses.of_length(rng, 20, 8.0, 16.0)
    lengths = [rod.length for rod in rods]
    assert 8.0 <= min(lengths) < max(lengths) <= 16.0
    positions, rotations = poses.ends_of(rods)
    assert le.solve_batch(positions, rotations).converged.all()


def test_a_run_writes_tables_slopes_and_a_picture(tmp_path, monkeypatch):
    monkeypatch.setattr(bench, "_MOST", (100, 100))
    monkeypatch.setattr(bench, "_MANY", 10)
    monkeypatch.setattr(bench, "_PER_LENGTH", (2, 2))
    monkeypatch.setattr(bench, "_LISTED", (2, 2))
    monkeypatch.setattr(bench, "_alone", bench.stream)
    result = CliRunner().invoke(app, ["bench", "scaling", "-o", str(tmp_path), "--seed", "5"])
    assert result.exit_code == 0, result.output
    for name, least in (("rods", 3), ("lengths", 8), ("equilibria", 2), ("slopes", 7)):
        with (tmp_path / f"{name}.csv").open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        assert len(rows) >= least
        assert "nan" not in str(rows)
        if name == "rods":
            assert all(row["solved"] == row["rods"] for row in rows)
    assert "## Slopes" in (tmp_path / "scaling.md").read_text(encoding="utf-8")
    assert (tmp_path / "scaling.png").read_bytes().startswith(b"\x89PNG")
