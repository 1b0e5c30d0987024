"""A constant is chosen without the family it is judged on."""

import numpy as np
import pytest

from loopelastica.studies.evaluation.loops import EXTENSIONS, TAPERS
from loopelastica.studies.evaluation.refit import interval, refitted_A


def loop(family, n, good, kind="RNA", elsewhere=5.0):
    """A loop whose RMSD is 1 at one (taper, extensions) and `elsewhere` at all others."""
    grid = [[elsewhere] * len(EXTENSIONS) for _ in TAPERS]
    grid[TAPERS.index(good[0])][EXTENSIONS.index(good[1])] = 1.0
    return {"kind": kind, "family": family, "nucleotides": n, "grid": grid}


def test_what_all_others_agree_on_is_found():
    rows = [loop(f"f{k}", 7, (0.1, (2, 1))) for k in range(5)]
    assert refitted_A(rows)["all"].tolist() == [1.0] * 5
    # the rule's own extensions (1, 2) are kept where the taper alone is refitted
    assert refitted_A(rows)["taper"].tolist() == [5.0] * 5


def test_a_familys_own_loops_do_not_help_it():
    rows = [loop("others", 7, (0.1, (2, 1)))] + [loop("odd", 7, (0.3, (0, 3)))] * 9
    found = refitted_A(rows)["all"]
    assert found.tolist() == [5.0] * 10


def test_a_large_family_has_one_vote():
    rows = [loop("large", 7, (0.3, (0, 3)))] * 9
    rows += [loop(f"f{k}", 7, (0.1, (2, 1))) for k in range(3)]
    assert refitted_A(rows)["all"][9:].tolist() == [1.0] * 3


def test_kinds_are_fitted_apart_and_an_unreachable_clamp_is_never_chosen():
    dna = [loop(f"d{k}", 4, (0.0, (0, 0)), "DNA", None) for k in range(3)]
    rna = [loop(f"r{k}", 4, (0.2, (0, 0))) for k in range(3)]
    assert refitted_A(dna + rna)["all"].tolist() == [1.0] * 6


def test_the_interval_is_over_families():
    difference = np.array([1.0] * 50 + [-1.0, -1.0, -1.0])
    mean, low, high = interval(difference, ["a"] * 50 + ["b", "c", "d"])
    assert mean == pytest.approx(-0.5)
    assert low < mean < high
    assert interval(np.array([2.0, 2.0]), ["a", "b"]) == (2.0, 2.0, 2.0)
