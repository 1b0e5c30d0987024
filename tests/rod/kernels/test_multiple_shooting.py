import numpy as np
import pytest
from draws import load_drawn
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod.kernels.multiple_shooting import (
    _end_rows,
    _step,
    forward,
    forward_again,
    mismatch,
    new_elimination,
    refine,
)
from loopelastica.rod.kernels.records import Nodes
from loopelastica.rod.kernels.segments import new_space

# kernels that Python does not call otherwise are compiled one by one
pytestmark = pytest.mark.slow


@pytest.mark.parametrize("free_spin", [False, True])
def test_a_disturbed_solution_is_refined_back(rng, problem, free_spin):
    for position, rotation in zip(*load_drawn(rng, 8, 0.7, free_spin), strict=True):
        clamping = le.Clamping(position, rotation, free_spin)
        rod = le.solve(clamping, 0.7)
        s = np.linspace(0, 1, 17)
        nodes = Nodes(s, rod.poses_without_spin(s))
        nodes.pose[1:-1, :3] += 1e-3 * rng.normal(size=(15, 3))
        g = rod.loads + 0.01 * rng.normal(size=6)
        here = problem(clamping, 0.7)
        if free_spin:
            g[5] = 0.0
            here = here._replace(quaternion=nodes.pose[-1, 3:].copy())
        residual, energy, iterations = refine(here, nodes, g, 1e-12, 14)
        assert residual < 1e-10
        assert iterations <= 6
        assert energy == pytest.approx(rod.energy, rel=1e-9)
        np.testing.assert_allclose(g[:5], rod.loads[:5], rtol=1e-5, atol=1e-5)
        assert mismatch(here, nodes, g, 9.0, new_space())[0] < 1e-10


def test_a_start_too_far_off_ends_without_a_residual(rng, problem):
    position, rotation = (a[0] for a in load_drawn(rng, 1))
    clamping = le.Clamping(position, rotation)
    s = np.linspace(0, 1, 9)
    pose = np.hstack([3 * rng.normal(size=(9, 3)), Rotation.random(9, random_state=rng).as_quat()])
    pose[0], pose[-1, :3] = (0, 0, 0, 1, 0, 0, 0), position
    residual, energy, iterations = refine(
        problem(clamping, 1.0), Nodes(s, pose), np.zeros(6), 1e-12, 14
    )
    assert np.isinf([residual, energy]).all()
    assert iterations < 14


def test_a_chord_where_the_factors_are_of_is_the_newton_step(rng, problem):
    position, rotation = (a[0] for a in load_drawn(rng, 1))
    clamping = le.Clamping(position, rotation)
    rod = le.solve(clamping)
    s = np.linspace(0, 1, 9)
    nodes = Nodes(s, rod.poses_without_spin(s))
    nodes.pose[1:-1, :3] += 1e-3 * rng.normal(size=(7, 3))
    g, here = rod.loads.copy(), problem(clamping, 1.0)
    room, space = new_elimination(8, np.full(6, 10.0)), new_space()
    steps = []
    for eliminate in (forward, forward_again):
        x, dg = np.empty((9, 6)), np.empty(6)
        worst = eliminate(nodes, g, False, 3.0, room, space)
        if eliminate is forward:
            _end_rows(here, nodes, room)
        _step(here, nodes, 1e-12, room, x, dg)
        steps.append((worst, x, dg))
    for one, other in zip(*steps, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-8, atol=1e-11)
