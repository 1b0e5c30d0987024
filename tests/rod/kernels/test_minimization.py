import math

import numpy as np
import pytest
from draws import pose_drawn
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod.kernels.discrete_starts import start_frames
from loopelastica.rod.kernels.minimization import _CLOSED, minimize

# kernels that Python does not call otherwise are compiled one by one
pytestmark = pytest.mark.slow


@pytest.mark.parametrize("free_spin", [False, True])
@pytest.mark.parametrize("torsion_ratio", [0.05, 1.0, 8.0])
def test_the_discrete_rod_reaches_a_minimum_from_every_pose(
    rng, problem, start, discrete_rod, torsion_ratio, free_spin
):
    for position, rotation in zip(*pose_drawn(rng, 25, high=0.9), strict=True):
        here = problem(le.Clamping(position, rotation, free_spin), torsion_ratio)
        rod, force, moment = discrete_rod(64), np.zeros(3), np.zeros(3)
        start_frames(here, start(), rod, force)
        found, energy, index, iterations = minimize(here, torsion_ratio, rod, force, moment, np.inf)
        assert found
        assert index == 0
        assert 0 < energy < math.inf
        assert iterations < 200
        tangents = Rotation.from_quat(rod.frames[1:-1], scalar_first=True).as_matrix()[:, :, 2]
        np.testing.assert_allclose(np.diff(rod.s) @ tangents, position, atol=_CLOSED)


def test_energy_force_and_moment_are_nearly_those_of_the_rod(problem, start, discrete_rod):
    clamping = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
    exact = le.solve(clamping, 0.7)
    rod, force, moment = discrete_rod(64), np.zeros(3), np.zeros(3)
    here = problem(clamping, 0.7)
    start_frames(here, start(), rod, force)
    found, energy, _, _ = minimize(here, 0.7, rod, force, moment, np.inf)
    assert found
    # 64 segments: within a hundredth
    assert energy == pytest.approx(exact.energy, rel=1e-2)
    size = np.abs(exact.loads).max()
    np.testing.assert_allclose(np.concatenate([force, moment]), exact.loads, atol=2e-2 * size)


def test_a_rod_on_its_way_above_the_ceiling_is_given_up(rng, problem, start, discrete_rod):
    given_up = 0
    for position, rotation in zip(*pose_drawn(rng, 10, high=0.85), strict=True):
        here = problem(le.Clamping(position, rotation), 1.0)

        def minimized(ceiling, here=here):
            rod, force, moment = discrete_rod(16), np.zeros(3), np.zeros(3)
            start_frames(here, start(), rod, force)
            found, energy, _, iterations = minimize(here, 1.0, rod, force, moment, ceiling)
            return found, energy, iterations

        found, energy, iterations = minimized(np.inf)
        assert found
        # one below is found as if there were none
        assert minimized(1.01 * energy) == (found, energy, iterations)
        # one above is given up, unless it has arrived before
        outcome = minimized(0.5 * energy)
        if outcome != (found, energy, iterations):
            given_up += 1
            assert outcome[:2] == (False, math.inf)
            assert outcome[2] < iterations
    assert given_up > 3
