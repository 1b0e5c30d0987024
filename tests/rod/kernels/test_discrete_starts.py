import numpy as np
import pytest
from draws import pose_drawn
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod.kernels.discrete_rod import hinge_vector
from loopelastica.rod.kernels.discrete_starts import (
    align_spin,
    bow,
    graded_nodes,
    hinge_poses,
    loads_as_it_stands,
    start_frames,
    wave,
)
from loopelastica.rod.kernels.records import Nodes

# kernels that Python does not call otherwise are compiled one by one
pytestmark = pytest.mark.slow


def test_graded_nodes_crowd_where_the_boundary_layers_are():
    s = np.empty(65)
    for root in (0.5, 10.0, 100.0):
        graded_nodes(root, s)
        assert s[0] == 0
        assert s[-1] == 1
        assert (np.diff(s) > 0).all()
        np.testing.assert_allclose(s + s[::-1], 1, atol=1e-15)
        q = 0.5 * root
        # equal shares of the integral of the density
        share = s + 0.5 * (1 - np.exp(-q * s) + np.exp(-q * (1 - s)) - np.exp(-q))
        np.testing.assert_allclose(np.diff(share), share[-1] / 64, atol=1e-8)
        ends, middle = 1 + 0.5 * q * (1 + np.exp(-q)), 1 + q * np.exp(-0.5 * q)
        assert np.diff(s)[0] / np.diff(s)[32] == pytest.approx(middle / ends, rel=0.25)


@pytest.mark.parametrize("over", [(False, False), (True, False), (False, True)])
def test_a_start_begins_and_ends_at_the_clamps_with_its_turns_in_between(
    rng, problem, start, discrete_rod, over
):
    for position, rotation in zip(*pose_drawn(rng, 5, 0.97, 0.99), strict=True):
        twists = []
        for turns in (0.0, 2.0):
            rod, force = discrete_rod(64), np.zeros(3)
            row = start(turns, over_0=over[0], over_1=over[1])
            start_frames(problem(le.Clamping(position, rotation), 1.0), row, rod, force)
            np.testing.assert_array_equal(rod.frames[0], [1, 0, 0, 0])
            last = Rotation.from_quat(rod.frames[-1], scalar_first=True).as_matrix()
            np.testing.assert_allclose(last, rotation, atol=1e-12)
            omega = np.empty((65, 3))
            for k in range(65):
                hinge_vector(rod.frames[k], rod.frames[k + 1], omega[k])
            twists.append(omega[:, 2].sum())
        assert twists[1] - twists[0] == pytest.approx(4 * np.pi, rel=0.15)


def test_a_free_end_takes_the_spin_that_twists_nothing(rng):
    for p, q in Rotation.random(20, random_state=rng).as_quat().reshape(10, 2, 4):
        before = Rotation.from_quat(q, scalar_first=True).as_matrix()
        align_spin(p, q)
        after = Rotation.from_quat(q, scalar_first=True).as_matrix()
        np.testing.assert_allclose(after[:, 2], before[:, 2], atol=1e-14)
        turned = np.empty(3)
        hinge_vector(p, q, turned)
        assert abs(turned[2]) < 1e-14


def test_bows_and_waves_leave_the_clamps_alone(rng, problem, start, discrete_rod):
    here = problem(le.Clamping([0, 0, 0.9], np.eye(3)), 1.0)
    for bend in (
        lambda rod, force: bow(rod, 0.5, 1),
        lambda rod, force: wave(rod, here.position, force, 2.0),
    ):
        rod, force = discrete_rod(32), np.zeros(3)
        start_frames(here, start(), rod, force)
        before = rod.frames.copy()
        bend(rod, force)
        np.testing.assert_array_equal(rod.frames[[0, -1]], before[[0, -1]])
        assert np.abs(rod.frames - before).max() > 0.05
    # Euler's load of two half waves, pushing
    np.testing.assert_allclose(force, [0, 0, -((2 * np.pi) ** 2)], atol=1e-9)


def test_hinges_of_a_bent_rod_lie_on_it_and_its_first_moment_is_the_curvature(discrete_rod):
    # a quarter circle in the plane of d1 and d3, unit length; M = κ about d2
    n, angle = 32, 0.5 * np.pi
    rod = discrete_rod(n)
    middles = np.concatenate([[0.0], (rod.s[1:] + rod.s[:-1]) / 2, [1.0]])
    rod.frames[:] = Rotation.from_euler("y", middles[:, None] * angle).as_quat(scalar_first=True)
    end = np.array([1 - np.cos(angle), 0, np.sin(angle)]) / angle
    nodes = Nodes(np.empty(9), np.empty((9, 7)))
    hinge_poses(rod, end, 1.0, 0.0, nodes)
    np.testing.assert_array_equal(nodes.s, rod.s[::4])
    line = np.stack([1 - np.cos(angle * nodes.s), 0 * nodes.s, np.sin(angle * nodes.s)], 1) / angle
    np.testing.assert_allclose(nodes.pose[:, :3], line, atol=(angle / n) ** 2)
    turned = Rotation.from_quat(nodes.pose[:, 3:], scalar_first=True).as_rotvec()
    np.testing.assert_allclose(turned[:, 1], angle * nodes.s, atol=1e-12)
    load = np.empty(6)
    loads_as_it_stands(rod, 1.0, np.array([1.0, 2.0, 3.0]), load)
    np.testing.assert_allclose(load, [1, 2, 3, 0, angle, 0], atol=1e-9)
