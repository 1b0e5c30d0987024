import csv
import shutil

import numpy as np
import pytest

import loopelastica as le
from loopelastica.studies.completeness import study

FILES = ("poses.csv", "missed.csv", "reliability.csv", "report.md", "completeness.png")


def rows_of(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def small(patch, poses=2):
    """Few poses, and few starts for each."""
    patch.setattr(study, "_POSES", (poses, poses))
    patch.setattr(study, "_STARTS", 60)


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """The rows of a run of two poses, and its folder."""
    out = tmp_path_factory.mktemp("study") / "out"
    with pytest.MonkeyPatch.context() as patch:
        small(patch)
        return study.run(out, progress=False), out


def test_two_poses_write_all_files(first):
    rows, out = first
    assert [(row["pose"], row["effort"]) for row in rows] == [
        (pose, effort) for pose in (0, 1) for effort in study.EFFORTS
    ]
    for name in FILES:
        assert (out / name).stat().st_size > 0, name
    written = rows_of(out / "poses.csv")
    assert [row["listed"] for row in written] == [str(row["listed"]) for row in rows]
    lost = sum(row["rods"] - row["rods_listed"] for row in rows)
    assert len(rows_of(out / "missed.csv")) == lost
    assert len(rows_of(out / "reliability.csv")) == len(study.EFFORTS)
    for name in FILES[:-1]:
        text = (out / name).read_text(encoding="utf-8").lower()
        assert "nan" not in text
    clamping, torsion_ratio, kind = study.pose(2026, 1)
    again = le.Clamping.from_parameters(
        [float(written[-1][name]) for name in ("eta1", "eta2", "eta3", "psi", "theta", "phi")],
        kind == "free spin",
    )
    np.testing.assert_allclose(again.rotation, clamping.rotation, atol=1e-12)
    assert float(written[-1]["torsion_ratio"]) == torsion_ratio


def test_a_second_run_takes_the_hits_of_the_first_and_makes_lists_anew(
    first, tmp_path, monkeypatch
):
    rows, out = first
    shutil.copytree(out, tmp_path / "out")
    small(monkeypatch)
    monkeypatch.setattr(study, "search", lambda *_: pytest.fail("searched again"))
    again = study.run(tmp_path / "out", progress=False)
    for before, after in zip(rows, again, strict=True):
        assert {**before, "seconds": 0} == {**after, "seconds": 0}
    # other starts are another search
    searched = []
    small(monkeypatch, poses=1)
    monkeypatch.setattr(study, "search", lambda *arguments: searched.append(arguments[2]) or [])
    monkeypatch.setattr(study, "_STARTS", 50)
    rows = study.run(tmp_path / "out", progress=False)
    assert [row["hits"] for row in rows] == [0] * len(rows)
    assert searched == [50]


def test_poses_are_those_of_seed_and_number_and_of_every_kind():
    kinds = []
    for number in range(16):
        clamping, torsion_ratio, kind = study.pose(5, number)
        assert clamping == study.pose(5, number)[0]
        assert np.linalg.norm(clamping.position) < 0.95
        assert clamping.free_spin == (kind == "free spin")
        assert 0.1 <= torsion_ratio <= 10.0
        kinds.append(kind)
    assert [kinds.count(kind) for kind in ("fixed", "free spin", "torsion")] == [8, 4, 4]
    assert study.pose(5, 0)[0] != study.pose(6, 0)[0]


@pytest.mark.slow
def test_lists_have_the_share_of_hits_that_is_promised(tmp_path, monkeypatch):
    monkeypatch.setattr(study, "_POSES", (10, 10))
    rows = study.run(tmp_path, seed=15, progress=False)
    # hits, minima and saddles of index 1 that are listed
    for effort, least in (("default", (0.90, 1.0, 0.95)), ("deepest", (0.97, 1.0, 0.99))):
        chosen = [row for row in rows if row["effort"] == effort]
        for (whole, part), share in zip(
            (("hits", "hits_listed"), ("minima", "minima listed"), ("index 1", "index 1 listed")),
            least,
            strict=True,
        ):
            total, there = (sum(row[key] for row in chosen) for key in (whole, part))
            assert there >= share * total, (effort, whole, there, total)
