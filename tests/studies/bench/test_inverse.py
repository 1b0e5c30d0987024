"""From a clamping to a rod: targets, and what an answer is off."""

import numpy as np

import loopelastica as le
from loopelastica.studies.bench import inverse, peers


def test_the_judge_sees_a_wrong_answer(arch):
    rod = le.solve(arch)
    assert inverse.error_of(rod) < 1e-9
    assert inverse.error_of(peers.from_loads(arch, rod.loads)) < 1e-8
    wrong = peers.from_loads(arch, rod.loads + 1e-4)
    assert 1e-7 < inverse.error_of(wrong) < 1e-2
    assert inverse.error_of(peers.from_loads(arch, np.full(6, np.nan))) == np.inf
    assert inverse.error_of(None) == np.inf


def test_load_drawn_targets_stay_below_the_bound(rng):
    positions, rotations = inverse.SETS["load-drawn"](rng, 50)
    assert positions.shape == (50, 3)
    assert rotations.shape == (50, 3, 3)
    assert np.linalg.norm(positions, axis=1).max() < 0.95
