"""From loads to the end of the rod."""

import pytest

from loopelastica.studies.bench import forward, reference


def test_forward_ways_converge(monkeypatch, rng):
    pytest.importorskip("mpmath")
    monkeypatch.setattr(reference, "DIGITS", 16)
    monkeypatch.setattr(reference.end_pose, "__defaults__", (16,))
    monkeypatch.setattr(forward, "_MORE_DIGITS", 18)
    monkeypatch.setattr(forward, "_STEPS", (4, 96))
    monkeypatch.setattr(forward, "_TOLERANCES", (1e-4, 1e-12))
    rows = forward.measure(1, rng, lambda: None)
    error = {(row["method"], row["setting"]): row["error_max"] for row in rows}
    assert error["reference", "16 digits"] < 1e-16
    assert error["closed form q1", ""] < 1e-12
    for method, coarse, fine in (
        ("own integrator", "4 steps", "96 steps"),
        ("Bulirsch–Stoer", "rtol 1e-04", "rtol 1e-12"),
        ("SciPy DOP853", "rtol 1e-04", "rtol 1e-12"),
    ):
        assert error[method, fine] < 1e-10 < error[method, coarse]
