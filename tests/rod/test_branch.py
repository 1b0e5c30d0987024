import math

import numpy as np
import pytest

import loopelastica as le
from loopelastica.rod._branch import (
    ClampPath,
    agreement,
    by_layers,
    distance,
    equilibrium_of,
    first_point,
    mesh,
    point_at,
    remeshed,
    step_along,
)

FIGURE_6 = [-0.4, -0.1, 0.5, 4.8, 1.4, 2.2]


def twisting(rod):
    """The end turned about its tangent, t in turns."""
    axis = np.array([0, 0, 2 * math.pi])
    return ClampPath(rod.clamping, np.zeros(3), axis, rod.torsion_ratio, 1.0)


@pytest.mark.parametrize(
    ("root", "nodes"), [(0.0, 17), (13.9, 17), (14.1, 33), (39.9, 33), (40.1, 65), (149.0, 65)]
)
def test_tense_rods_have_more_nodes(root, nodes):
    node_s = mesh(np.array([0, 0, root**2, 0, 0, 0]))
    assert len(node_s) == nodes
    assert (node_s[0], node_s[-1]) == (0, 1)
    assert mesh(np.array([0, 0, 151.0**2, 0, 0, 0])) is None


@pytest.mark.parametrize("free_spin", [False, True])
def test_the_first_point_is_the_rod_and_so_is_its_equilibrium(free_spin):
    clamping = le.Clamping.from_parameters(FIGURE_6, free_spin)
    rod = le.solve(clamping, 0.7)
    path = ClampPath(clamping, np.array([0.1, 0, 0.2]), np.array([0.3, 0, 0.4]), 0.7, 1.0)
    point = first_point(path, rod)
    assert point.t == 0
    assert point.tangent[6] > 0
    again = equilibrium_of(path, point)
    np.testing.assert_allclose(again.loads, rod.loads, rtol=1e-8, atol=1e-8)
    assert again.energy == pytest.approx(rod.energy, rel=1e-10)
    assert again.clamping.free_spin == free_spin


def test_a_step_keeps_its_direction_and_its_length():
    rod = le.solve(le.Clamping.from_parameters(FIGURE_6))
    path = twisting(rod)
    first = first_point(path, rod)
    for ds in (0.05, 0.2):
        following = step_along(path, first, ds)
        assert agreement(path, first, following) > math.cos(math.pi / 9)
        assert distance(path, first, following) == pytest.approx(ds, rel=0.1)
    assert step_along(path, first, 30.0) is None
    there = point_at(path, following, first.t)
    np.testing.assert_allclose(there.values, first.values, atol=1e-7)
    assert remeshed(path, first) is first


def test_layers_do_not_lose_a_turn_on_a_long_step():
    # half a turn of the clamp and more could as well be the other way round
    direction = np.array([0.5, 0, 0.75**0.5])
    rod = le.solve(le.Clamping(0.9999 * direction, np.eye(3)), 0.7)
    path = twisting(rod)
    followed = by_layers(path, rod, 0.45)
    assert followed.loads[5] - rod.loads[5] == pytest.approx(0.7 * 0.9 * math.pi, rel=0.05)
    assert by_layers(path, rod, 0.49) is None


def test_layers_are_not_looked_for_where_the_ends_are_out_of_reach():
    rod = le.solve(le.Clamping([0.5, 0, 0.866 * 0.9999], np.eye(3)))
    path = ClampPath(rod.clamping, np.array([0.5, 0, 0.9]), np.zeros(3), 1.0, 1.0)
    assert by_layers(path, rod, 0.0).energy == pytest.approx(rod.energy, rel=1e-9)
    assert by_layers(path, rod, 1.0) is None


def test_layers_of_a_far_tenser_rod_are_not_taken_for_the_next():
    direction = np.array([0.5, 0, 0.75**0.5])
    rod = le.solve(le.Clamping(0.999 * direction, np.eye(3)))
    path = ClampPath(rod.clamping, 0.001 * direction, np.zeros(3), 1.0, 1.0)
    assert by_layers(path, rod, 0.2).energy == pytest.approx(rod.energy / 0.8, rel=1e-2)
    # two and a half times the energy
    assert by_layers(path, rod, 0.6) is None
