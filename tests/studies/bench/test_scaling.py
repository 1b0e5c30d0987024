"""How time and memory grow: what is measured, and what a run writes."""

import csv

import numpy as np
import pytest
from typer.testing import CliRunner

from loopelastica.cli.app import app
from loopelastica.studies.bench import scaling as bench
from loopelastica.studies.bench import scaling_report


def test_any_chunking_solves_every_rod(monkeypatch):
    monkeypatch.setattr(bench, "CHUNK", 7)
    row = bench.stream(17, 1, 1)
    assert row["rods"] == row["solved"] == 17
    assert row["residual_max"] < 1e-9
    assert row["memory_MB"] > 10


@pytest.mark.slow
def test_a_row_of_its_own_process_has_memory_of_its_own():
    block = np.ones(40_000_000)
    row = bench._alone(3, 1, 1)
    assert row["solved"] == 3
    assert row["memory_MB"] < bench.peak_memory_MB()
    assert block[-1] == 1.0


def test_threads_change_no_answer():
    one, two = bench.stream(300, 1, 1), bench.stream(300, 2, 1)
    assert (two["threads"], two["solved"]) == (2, one["solved"])
    assert two["residual_max"] == one["residual_max"]


@pytest.mark.slow
def test_a_run_writes_tables_slopes_and_a_picture(tmp_path, monkeypatch):
    monkeypatch.setattr(bench, "_MOST", (100, 100))
    monkeypatch.setattr(scaling_report, "_MANY", 10)
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
