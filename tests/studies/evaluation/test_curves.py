"""Simple curves have the length, the ends and the tangents they are asked for."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from loopelastica.molecule.clamp_rule import plain_clamp
from loopelastica.molecule.ends import StemEnds
from loopelastica.studies.evaluation.curves import arc, chord, hermite, stem_axes

S = np.linspace(0.0, 1.0, 2001)


@pytest.fixture(params=range(4))
def ends(request):
    """Two clamps 5 to 18 Å apart, roughly antiparallel, and a line of 24 Å."""
    rng = np.random.default_rng(request.param)
    up = Rotation.from_rotvec(rng.normal(scale=0.3, size=3))
    down = Rotation.from_rotvec([np.pi, 0, 0]) * Rotation.from_rotvec(rng.normal(scale=0.3, size=3))
    return StemEnds(
        start_origin_A=rng.normal(size=3),
        start_frame=up.as_matrix(),
        end_origin_A=np.array([rng.uniform(5, 15), 0.0, 2.0]),
        end_frame=down.as_matrix(),
        length_A=24.0,
        clamp=plain_clamp(is_dna=False),
        continued_5_A=np.zeros((0, 3)),
        continued_3_A=np.zeros((0, 3)),
        fit_rms_A=np.zeros(2),
        stem_rms_A=None,
    )


@pytest.mark.parametrize("curve", [chord, arc, hermite])
def test_ends_length_and_even_spacing(ends, curve):
    line = curve(ends, S)
    np.testing.assert_allclose(line[0], ends.start_origin_A, atol=1e-6)
    np.testing.assert_allclose(line[-1], ends.end_origin_A, atol=1e-6)
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    length = ends.distance_A if curve is chord else 24.0
    assert steps.sum() == pytest.approx(length, rel=1e-4)
    assert steps.max() / steps.min() < 1.02


def test_the_cubic_leaves_and_comes_back_along_the_tangents(ends):
    line = hermite(ends, np.array([0.0, 0.002, 0.998, 1.0]))
    for a, b, frame in ((0, 1, ends.start_frame), (2, 3, ends.end_frame)):
        step = line[b] - line[a]
        assert step @ frame[:, 2] / np.linalg.norm(step) > 0.99


def test_the_arc_is_a_circle_on_the_side_of_the_loop(ends):
    line = arc(ends, S)
    turn = np.linalg.norm(np.diff(line, 2, axis=0), axis=1)
    assert np.ptp(turn) < 1e-3 * turn.mean()
    middle, axes = stem_axes(ends)
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-12)
    local = (line - middle) @ axes
    np.testing.assert_allclose(local[:, 1], 0.0, atol=1e-9)
    assert local[1000, 2] > 2.0
    assert local[1000, 0] == pytest.approx(0.0, abs=1e-6)
