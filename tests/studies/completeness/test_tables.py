import numpy as np
import pytest

from loopelastica.studies.completeness.tables import coverage, reliability

INDICES = ("minima", "index 1")


def row(unseen, rods=10, missed=0, effort="default", kind="fixed", seconds=0.1):
    return {
        "effort": effort, "kind": kind, "unseen": unseen, "seconds": seconds, "listed": rods,
        "listed_hit": rods,
        "rods": rods, "rods_listed": rods - missed, "hits": 10 * rods,
        "hits_listed": 10 * rods - missed, "minima": 1, "minima listed": 1,
        "index 1": 0, "index 1 listed": 0,
    }  # fmt: skip


def test_shares_are_of_all_poses_together_and_of_each_kind():
    rows = [row(0.0, 10, 0), row(0.0, 30, 10, kind="free spin", seconds=0.3)]
    total, fixed, free = coverage(rows, INDICES)
    assert (total["kind"], fixed["kind"], free["kind"]) == ("all", "fixed", "free spin")
    assert total["rods %"] == 75.0
    assert fixed["rods %"] == 100.0
    assert free["hits %"] == pytest.approx(100.0 * 290 / 300)
    assert total["seconds_median"] == pytest.approx(0.2)
    assert total["minima %"] == 100.0


def test_there_is_no_share_of_nothing():
    (total, _) = coverage([row(0.0)], INDICES)
    assert total["index 1 %"] is None


def test_bins_hold_thirty_poses_and_split_no_value():
    said = [0.0] * 40 + [0.01] * 10 + [0.02] * 25 + [0.3] * 29
    bins = reliability([row(u, 10, 1 if u else 0) for u in said])
    assert [b["poses"] for b in bins] == [40, 64]
    assert [(b["said_least"], b["said_most"]) for b in bins] == [(0.0, 0.0), (0.01, 0.3)]
    assert [b["rods_missed"] for b in bins] == [0.0, pytest.approx(0.1)]
    assert [b["hits_missed"] for b in bins] == [0.0, pytest.approx(0.01)]


def test_few_poses_are_one_bin_and_each_effort_has_its_own():
    rows = [row(0.1, effort=e) for e in ("default", "deepest") for _ in range(5)]
    assert [(b["effort"], b["poses"]) for b in reliability(rows)] == [
        ("default", 5),
        ("deepest", 5),
    ]


def test_the_measured_share_is_that_of_all_rods_and_lies_in_its_interval(rng):
    rows = [row(0.05, int(n), int(rng.binomial(n, 0.05))) for n in rng.integers(1, 60, 100)]
    bins = reliability(rows)
    missed = sum(r["rods"] - r["rods_listed"] for r in rows)
    rods = sum(r["rods"] for r in rows)
    assert sum(b["rods"] * b["rods_missed"] for b in bins) == pytest.approx(missed)
    assert sum(b["rods"] for b in bins) == rods
    for b in bins:
        assert b["rods_missed_low"] <= b["rods_missed"] <= b["rods_missed_high"]
        assert np.isclose(b["said"], 0.05)


def test_poses_where_nothing_was_hit_are_left_out():
    assert reliability([row(0.5, rods=0)]) == []
