import numpy as np
import pytest
from draws import pose_drawn
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod.kernels.boundary_layers import solve_layers
from loopelastica.rod.kernels.layer_poses import layers_loads
from loopelastica.rod.kernels.records import Nodes
from loopelastica.rod.kernels.refinement import (
    accept_layers,
    accept_nodes,
    layers_from_loads,
    near_one_line,
    relative_distance,
    turn_about_start,
)

# kernels that Python does not call otherwise are compiled one by one
pytestmark = pytest.mark.slow


@pytest.mark.parametrize("free_spin", [False, True])
@pytest.mark.parametrize("over", [(False, False), (True, False), (False, True)])
def test_loads_lead_back_to_their_boundary_layers(rng, problem, start, room, over, free_spin):
    count = 0
    for position, rotation in zip(*pose_drawn(rng, 10, 0.999, 0.9999), strict=True):
        here = problem(le.Clamping(position, rotation, free_spin), 0.7)
        layers, again, f = room().layers[0], room().layers[0], np.empty(6)
        if not solve_layers(here, start(over_0=over[0], over_1=over[1]), layers):
            continue
        layers_loads(layers, f)
        assert layers_from_loads(here, f * (1 + 1e-6 * rng.normal(size=6)), again)
        found = np.empty(6)
        residual, energy = accept_layers(here, again, found)
        assert residual < 1e-9
        assert energy > 0
        np.testing.assert_allclose(found, f, rtol=1e-8, atol=1e-8 * np.abs(f).max())
        count += 1
    assert count >= 8


def test_layers_that_meet_or_miss_the_end_are_not_accepted(rng, problem, start, room):
    position, rotation = (a[0] for a in pose_drawn(rng, 1, 0.999, 0.9999))
    here, layers, f = problem(le.Clamping(position, rotation), 1.0), room().layers[0], np.empty(6)
    assert solve_layers(here, start(), layers)
    assert accept_layers(here, layers, f)[0] < 1e-9
    layers.beta += 1e-5
    assert accept_layers(here, layers, f) == (np.inf, np.inf)
    layers.beta -= 1e-5
    layers.meeting = 1e-9
    assert accept_layers(here, layers, f) == (np.inf, np.inf)


def test_a_turn_about_the_start_keeps_the_ends_and_turns_the_rest(rng):
    pose = np.hstack([rng.normal(size=(5, 3)), Rotation.random(5, random_state=rng).as_quat()])
    loads, before = rng.normal(size=6), pose.copy()
    force, moment = loads.reshape(2, 3).copy()
    turn_about_start(pose, loads, 0.7)
    z = Rotation.from_euler("z", 0.7)
    np.testing.assert_array_equal(pose[[0, -1]], before[[0, -1]])
    np.testing.assert_allclose(pose[1:-1, :3], z.apply(before[1:-1, :3]))
    np.testing.assert_allclose(loads, np.concatenate([z.apply(force), z.apply(moment)]))
    turned, old = (Rotation.from_quat(p[1:-1, 3:], scalar_first=True) for p in (pose, before))
    assert (z * old * z.inv() * turned.inv()).magnitude().max() < 1e-12


def test_nodes_of_a_circle_of_solutions_are_refined_somewhere_on_it(problem):
    # both ends on one line: any turn of the arch about it is a solution
    clamping = le.Clamping([0, 0, 0.9], np.eye(3))
    rod = le.solve(clamping)
    s = np.linspace(0, 1, 17)
    nodes, loads = Nodes(s, rod.poses_without_spin(s)), rod.loads.copy()
    turn_about_start(nodes.pose, loads, 1.0)
    nodes.pose[1:-1, :3] += 1e-3
    residual, energy = accept_nodes(problem(clamping, 1.0), nodes, loads)
    assert residual < 1e-9
    assert energy == pytest.approx(rod.energy, rel=1e-9)


def test_ends_near_one_line_are_told_from_others(problem):
    for parameters, near in (
        ([0, 0, 0.9, 1.0, 0, 0], True),
        ([0, 0, -0.9, 1.0, np.pi, 0], True),
        ([0, 0, 0.9, 1.0, 0.009, 0], True),
        ([0, 0, 0.9, 1.0, 0.011, 0], False),
        ([0.0089, 0, 0.9, 1.0, 0, 0], True),
        ([0.0092, 0, 0.9, 1.0, 0, 0], False),
    ):
        assert near_one_line(problem(le.Clamping.from_parameters(parameters), 1.0)) == near


def test_loads_are_compared_by_their_largest_component():
    one = np.array([100.0, 0, 0, 0, 1, 0])
    assert relative_distance(one, one) == 0
    assert relative_distance(one, one + [0, 0, 0, 2, 0, 0]) == pytest.approx(0.02)
    assert relative_distance(np.zeros(6), np.full(6, 0.5)) == 0.5
