"""Cells against distances."""

import numpy as np

from loopelastica.nanostructures.laying.cells import beside


def test_all_that_is_near_is_found_and_nothing_that_is_far(rng):
    points, others = rng.uniform(-20, 20, (400, 3)), rng.uniform(-15, 15, (20, 3))
    nearest = np.linalg.norm(points[:, None] - others, axis=2).min(axis=1)
    found = beside(points, others, 3.0)
    assert found[nearest <= 3.0].all()
    assert not found[nearest > 2 * 3.0 * np.sqrt(3)].any()
    assert 0 < found.sum() < 400


def test_nothing_is_beside_nothing(rng):
    assert not beside(rng.normal(size=(4, 3)), np.zeros((0, 3)), 1.0).any()
    assert beside(np.zeros((0, 3)), rng.normal(size=(4, 3)), 1.0).shape == (0,)
