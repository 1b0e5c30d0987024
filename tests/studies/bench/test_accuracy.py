"""Error against run time: what a run writes."""

import csv
import sys

import pytest
from typer.testing import CliRunner

from loopelastica.cli.app import app
from loopelastica.studies.bench import accuracy as bench
from loopelastica.studies.bench import forward, inverse, reference


@pytest.fixture
def tiny(monkeypatch):
    """One target of the easy set, few methods."""
    monkeypatch.setattr(reference.end_pose, "__defaults__", (20,))
    monkeypatch.setattr(forward, "_STEPS", (16,))
    monkeypatch.setattr(forward, "_TOLERANCES", (1e-6,))
    monkeypatch.setattr(bench, "_RODS", (1, 1))
    monkeypatch.setattr(bench, "_LARGE", (10, 10))
    monkeypatch.setattr(bench, "_TARGETS", dict.fromkeys(inverse.SETS, (1, 1)))
    monkeypatch.setattr(inverse, "_BATCH_ROWS", 2)
    kept = (
        "ours, solve, first", "ours, solve, lowest", "ours, first, tolerance 1e-06", inverse.PEER,
        "least_squares",
    )  # fmt: skip
    methods = inverse._methods

    def few(rng):
        return {name: method for name, method in methods(rng).items() if name in kept}

    monkeypatch.setattr(inverse, "_methods", few)


@pytest.mark.slow
def test_a_run_writes_tables_and_a_picture(tmp_path, tiny):
    pytest.importorskip("mpmath")
    rows = bench.run(tmp_path / "out", progress=False)
    assert len(rows) == 3 * (5 + 2 + 2)
    for row in rows:
        if row["method"].startswith("ours"):
            # what a looser tolerance was asked for need not be better than it
            loose = any(f"tolerance {t}" in row["method"] for t in ("1e-03", "1e-06"))
            assert row["claimed_percent" if loose else "success_1e-9_percent"] == 100.0, row
    for name in ("forward.csv", "inverse.csv", "accuracy.md"):
        text = (tmp_path / "out" / name).read_text(encoding="utf-8").lower()
        assert "nan" not in text
        assert "inf" not in text
    with (tmp_path / "out" / "inverse.csv").open(newline="", encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == len(rows)
    assert (tmp_path / "out" / "accuracy.png").read_bytes().startswith(b"\x89PNG")


def test_without_mpmath_one_sentence_says_so(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "mpmath", None)
    result = CliRunner().invoke(app, ["bench", "accuracy", "-o", str(tmp_path / "out")])
    assert result.exit_code == 1
    assert "`mpmath` is not installed" in result.output
    assert not (tmp_path / "out").exists()
