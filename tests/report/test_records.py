"""Rows and JSON content of folded loops."""

import dataclasses
import json

import numpy as np
import pytest

import loopelastica as le
from loopelastica.report.records import candidate_row, line, ranking, rmsd_summary


@pytest.mark.parametrize(
    ("rmsd_A", "expected"),
    [
        ([1.0, 2.0, 6.0], (3.0, 7.0**0.5, 3)),
        ([1.0, np.inf, 2.0], (1.5, 0.5**0.5, 2)),
        ([2.5, np.inf], (2.5, None, 1)),
        ([np.inf], (None, None, 0)),
        ([], (None, None, 0)),
    ],
)
def test_the_spread_of_models_is_that_of_a_sample(fold, rmsd_A, expected):
    """Of 1, 2, 6 the squares of the deviations add up to 14, over n − 1 = 2."""
    candidate = dataclasses.replace(fold.candidates[0], rmsd_models_A=np.array(rmsd_A))
    assert rmsd_summary(candidate) == pytest.approx(expected)


def test_the_content_of_ranking_is_json_without_nan(fold, refused):
    content = json.loads(json.dumps(ranking("GGC(UUCG)GCC", fold), allow_nan=False))
    assert content["input"] == {"sequence": "GGC(UUCG)GCC"}
    assert content["parameters"] == fold.options.to_dict()
    with pytest.raises(ValueError, match="`fold` has no candidates"):
        ranking("GGC(UUCG)GCC", refused)


def test_the_dense_line_runs_from_end_to_end(fold):
    dense = line(fold.candidates[0], 7)
    np.testing.assert_allclose(
        dense["points"][[0, -1]], [fold.ends.start_origin_A, fold.ends.end_origin_A], atol=1e-6
    )
    assert dense["s"].tolist() == pytest.approx(np.linspace(0.0, 24.0, 7))
    assert {name: len(values) for name, values in dense.items()} == dict.fromkeys(dense, 7)


def test_the_twist_of_the_dense_line_is_the_twisting_moment_over_K3(koc):
    (loop,) = le.fold(koc, free_spin=False, torsion_ratio=0.5, all_models=False, shapes="rod")
    rod = loop.candidates[0].rod
    assert abs(rod.loads[5]) > 0.01
    expected = np.full(5, rod.loads[5] / 0.5 / loop.length_A)
    np.testing.assert_allclose(line(loop.candidates[0], 5)["twist"], expected)


@pytest.mark.parametrize("k", [0, 2])
def test_the_row_of_a_candidate_has_both_orders_its_shape_and_its_error(chains, k):
    candidate = chains.candidates[k]
    row = candidate_row(candidate)
    assert list(row)[:6] == [
        *("rank", "rank_energy", "shape"),
        *("expected_10_A", "expected_rmsd_A", "expected_90_A"),
    ]
    assert row["shape"] == candidate.shape
    assert (row["rank"], row["rank_energy"]) == (candidate.rank, candidate.rank_energy)
    errors = [row[name] for name in ("expected_10_A", "expected_rmsd_A", "expected_90_A")]
    assert errors == candidate.expected_rmsd_A.tolist()
    assert row["energy_dimensionless"] == candidate.line.energy


def test_chains_are_in_ranking_json_with_all_that_determines_them(chains):
    content = json.loads(json.dumps(ranking("GGC(UUCG)GCC", chains), allow_nan=False))
    first, *_, last = content["candidates"]
    assert first["shape"] == "like 2koc A.5-A.10"
    assert first["expected_rmsd_A"] == [0.5, 1.2, 2.0]
    assert len(first["chain"]["steps_A"]) == 5
    assert "rod" not in first
    assert "chain" not in last
    assert le.Equilibrium.from_dict(last["rod"]).converged


def test_the_dense_line_of_a_chain_runs_from_closing_to_closing_nucleotide(chains):
    first = chains.candidates[0]
    dense = line(first, 7)
    poses = first.line.poses
    np.testing.assert_allclose(
        dense["points"][[0, -1]], [poses.start_origin_A, poses.end_origin_A], atol=1e-6
    )
    assert dense["s"][-1] == first.line.curve_A
    assert all(np.isfinite(values).all() for values in dense.values())
