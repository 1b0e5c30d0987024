"""Clampings drawn at random."""

import loopelastica as le
from loopelastica.studies.bench import poses


def test_rods_have_the_length_asked_for(rng):
    rods = poses.of_length(rng, 20, 8.0, 16.0)
    lengths = [rod.length for rod in rods]
    assert 8.0 <= min(lengths) < max(lengths) <= 16.0
    positions, rotations = poses.ends_of(rods)
    assert le.solve_batch(positions, rotations).converged.all()
