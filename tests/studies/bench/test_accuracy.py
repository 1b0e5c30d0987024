"""Error against run time: the reference, the peers, the judge, and what a run writes."""

import csv
import sys

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

import loopelastica as le
from loopelastica.cli.app import app
from loopelastica.studies.bench import (
    _cold,
    _forward,
    _inverse,
    _omissions,
    _peers,
    _poses,
    _reference,
)
from loopelastica.studies.bench import accuracy as bench
from loopelastica.studies.bench._processes import seconds_of

NONE = np.zeros((0, 6))


@pytest.fixture(scope="module")
def arch():
    """A clamping that every method should solve."""
    rod = le.solve(le.Clamping([0.0, 0.0, 0.9], np.eye(3)))
    turn = Rotation.from_rotvec([0.2, 0.5, 0.3]).as_matrix()
    return le.Clamping(rod.centerline(2)[1] + [0.1, 0.2, -0.3], turn)


def test_the_reference_is_the_circle_to_fifty_digits():
    mpmath = pytest.importorskip("mpmath")
    with mpmath.workdps(60):
        end = _reference.end_pose([0, 0, 0, 0, 2, 0])
        half = mpmath.mpf(1)
        # curvature 2 about y, one unit long: the frame turns by 2
        expected = ((1 - mpmath.cos(2)) / 2, 0, mpmath.sin(2) / 2)
        expected += (mpmath.cos(half), 0, mpmath.sin(half), 0)
        assert max(abs(a - b) for a, b in zip(end, expected, strict=True)) < mpmath.mpf(10) ** -50


def test_the_reference_and_dop853_agree(rng):
    pytest.importorskip("mpmath")
    (loads,) = _poses.random_loads(rng, 1)
    reference = _reference.end_pose(loads, 25)
    assert _reference.difference(_peers.end_by_dop853(loads, 1e-13), reference) < 1e-11
    assert _reference.difference(_peers.end_by_dop853(loads, 1e-5), reference) > 1e-11


def test_forward_ways_converge(monkeypatch, rng):
    pytest.importorskip("mpmath")
    monkeypatch.setattr(_reference, "DIGITS", 20)
    monkeypatch.setattr(_reference.end_pose, "__defaults__", (20,))
    monkeypatch.setattr(_forward, "_MORE_DIGITS", 25)
    monkeypatch.setattr(_forward, "_STEPS", (4, 96))
    monkeypatch.setattr(_forward, "_TOLERANCES", (1e-4, 1e-12))
    rows = _forward.measure(1, rng, lambda: None)
    error = {(row["method"], row["setting"]): row["error_max"] for row in rows}
    assert error["reference", "20 digits"] < 1e-20
    assert error["closed form q1", ""] < 1e-12
    for method, coarse, fine in (
        ("own integrator", "4 steps", "96 steps"),
        ("Bulirsch–Stoer", "rtol 1e-04", "rtol 1e-12"),
        ("SciPy DOP853", "rtol 1e-04", "rtol 1e-12"),
    ):
        assert error[method, fine] < 1e-10 < error[method, coarse]


@pytest.mark.parametrize(
    "method", [_peers.by_collocation(NONE), _peers.by_shooting(NONE)], ids=["bvp", "shooting"]
)
def test_peers_solve_an_easy_clamping(method, arch):
    rod = method(arch)
    assert rod is not None
    assert _inverse.error_of(rod) < 1e-6


def test_a_peer_that_has_no_guess_left_has_no_answer(arch, monkeypatch):
    monkeypatch.setattr(_peers, "_MAX_NODES", 22)
    monkeypatch.setattr(_peers, "_FEWER_NODES", 22)
    guesses = _peers.random_guesses(np.random.default_rng(0), 1)
    assert _peers.by_collocation(guesses, 1e-12)(arch) is None
    monkeypatch.setattr(_peers, "_EVALUATIONS", 1)
    assert _peers.by_shooting(guesses)(arch) is None


def test_the_judge_sees_a_wrong_answer(arch):
    rod = le.solve(arch)
    assert _inverse.error_of(rod) < 1e-9
    assert _inverse.error_of(_peers.from_loads(arch, rod.loads)) < 1e-8
    wrong = _peers.from_loads(arch, rod.loads + 1e-4)
    assert 1e-7 < _inverse.error_of(wrong) < 1e-2
    assert _inverse.error_of(_peers.from_loads(arch, np.full(6, np.nan))) == np.inf
    assert _inverse.error_of(None) == np.inf


def test_the_hermite_guess_meets_both_clamps(arch):
    poses, _ = _peers._hermite(arch, np.linspace(0.0, 1.0, 101))
    assert np.abs(poses[:3, -1] - arch.position).max() < 1e-12
    frames = Rotation.from_quat(poses[3:].T, scalar_first=True).as_matrix()
    assert np.abs(frames[0] - np.eye(3)).max() < 1e-12
    assert np.abs(frames[-1] - arch.rotation).max() < 1e-9
    # the frames' tangents are the line's
    slope = np.gradient(poses[:3], axis=1)[:, 1:-1]
    slope /= np.linalg.norm(slope, axis=0)
    assert np.abs(slope.T - frames[1:-1, :, 2]).max() < 0.02


def test_load_drawn_targets_stay_below_the_bound(rng):
    positions, rotations = _inverse.SETS["load-drawn"](rng, 50)
    assert positions.shape == (50, 3)
    assert rotations.shape == (50, 3, 3)
    assert np.linalg.norm(positions, axis=1).max() < 0.95


def test_a_process_that_fails_says_why():
    with pytest.raises(RuntimeError, match="no_such_module"):
        seconds_of("import no_such_module")


@pytest.fixture
def tiny(monkeypatch):
    """One target of the easy set, few methods, nothing in other processes."""
    monkeypatch.setattr(_reference.end_pose, "__defaults__", (20,))
    monkeypatch.setattr(_forward, "_STEPS", (16,))
    monkeypatch.setattr(_forward, "_TOLERANCES", (1e-6,))
    monkeypatch.setattr(bench, "_RODS", (1, 1))
    monkeypatch.setattr(bench, "_LARGE", (10, 10))
    monkeypatch.setattr(bench, "_TARGETS", dict.fromkeys(_inverse.SETS, (1, 1)))
    monkeypatch.setattr(_inverse, "_BATCH_ROWS", 2)
    monkeypatch.setattr(_omissions, "_POSES", (2, 2))
    monkeypatch.setattr(_omissions, "_LISTED", (1, 1))
    monkeypatch.setattr(_omissions, "_process_rows", lambda full: [])
    kept = (
        "ours, solve, first", "ours, solve, lowest", "ours, first, tolerance 1e-06", _inverse.PEER,
        "least_squares",
    )  # fmt: skip
    methods = _inverse._methods

    def few(rng):
        return {name: method for name, method in methods(rng).items() if name in kept}

    monkeypatch.setattr(_inverse, "_methods", few)


def test_a_run_writes_tables_and_a_picture(tmp_path, tiny, monkeypatch):
    pytest.importorskip("mpmath")
    monkeypatch.setattr(_cold, "measure", lambda: [_cold._row("solve", "fresh", 0.1, 0.2, 0.3)])
    rows = bench.run(tmp_path / "out", cold=True, progress=False)
    assert len(rows) == 3 * (5 + 2 + 2)
    for row in rows:
        if row["method"].startswith("ours"):
            assert row["success_1e-9_percent"] == 100.0, row
    names = ("forward.csv", "inverse.csv", "omissions.csv", "cold.csv", "accuracy.md")
    for name in names:
        text = (tmp_path / "out" / name).read_text(encoding="utf-8").lower()
        assert "nan" not in text
        assert "inf" not in text
    with (tmp_path / "out" / "inverse.csv").open(newline="", encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == len(rows)
    with (tmp_path / "out" / "omissions.csv").open(newline="", encoding="utf-8") as file:
        omitted = list(csv.DictReader(file))
    # any equilibrium may be another one than the lowest
    assert all(row["same"] == row["sample"] for row in omitted if "any" not in row["omitted"])
    assert (tmp_path / "out" / "accuracy.png").read_bytes().startswith(b"\x89PNG")


def test_without_mpmath_one_sentence_says_so(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "mpmath", None)
    result = CliRunner().invoke(app, ["bench", "accuracy", "-o", str(tmp_path / "out")])
    assert result.exit_code == 1
    assert "`mpmath` is not installed" in result.output
    assert not (tmp_path / "out").exists()
