"""The end of a rod to fifty digits."""

import pytest

from loopelastica.studies.bench import peers, poses, reference


def test_the_reference_is_the_circle_to_fifty_digits():
    mpmath = pytest.importorskip("mpmath")
    with mpmath.workdps(60):
        end = reference.end_pose([0, 0, 0, 0, 2, 0])
        half = mpmath.mpf(1)
        # curvature 2 about y, one unit long: the frame turns by 2
        expected = ((1 - mpmath.cos(2)) / 2, 0, mpmath.sin(2) / 2)
        expected += (mpmath.cos(half), 0, mpmath.sin(half), 0)
        assert max(abs(a - b) for a, b in zip(end, expected, strict=True)) < mpmath.mpf(10) ** -50


def test_the_reference_and_dop853_agree(rng):
    pytest.importorskip("mpmath")
    (loads,) = poses.random_loads(rng, 1)
    exact = reference.end_pose(loads, 16)
    assert reference.difference(peers.end_by_dop853(loads, 1e-13), exact) < 1e-11
    assert reference.difference(peers.end_by_dop853(loads, 1e-5), exact) > 1e-11
