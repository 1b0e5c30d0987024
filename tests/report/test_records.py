"""Rows and JSON content of folded loops."""

import dataclasses
import json

import numpy as np
import pytest

import loopelastica as le
from loopelastica.report.records import line, ranking, rmsd_summary


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
