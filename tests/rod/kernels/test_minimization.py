import math

import numpy as np
import pytest
from draws import pose_drawn
from scipy.spatial.transform import Rotation

from loopelastica.rod.kernels.discrete_rod import assemble, measure, turn
from loopelastica.rod.kernels.minimization import _CLOSED, graded_nodes, relax, start_frames


def quaternion(rotation):
    return Rotation.from_matrix(rotation).as_quat(scalar_first=True)


def zigzag(rng, n):
    """Frames whose hinges turn by angles of order one."""
    frames = np.zeros((n + 2, 4))
    frames[0] = (1, 0, 0, 0)
    for k in range(1, n + 2):
        frames[k] = frames[k - 1]
        turn(frames[k], *(0.7 * rng.normal(size=3)))
    return frames


@pytest.mark.parametrize("free_spin", [False, True])
def test_gradient_and_hessian_are_exact_far_from_straight(rng, free_spin):
    n, k3 = 6, 0.3
    s, frames, force = np.linspace(0, 1, n + 1), zigzag(rng, n), 10 * rng.normal(size=3)
    blocks, position = n + free_spin, np.array([0.1, 0.2, 0.3])
    omega, c = np.empty((n + 1, 3)), np.empty(3)

    def lagrangian(b):
        moved = frames.copy()
        for k, v in enumerate(b.reshape(blocks, 3)):
            # the free clamp turns about its tangent only
            turn(moved[k + 1], *(v if k < n else (0, 0, v[2])))
        return measure(moved, s, n, position, k3, omega, c) - force @ c

    diagonal, upper, sides = (np.empty((blocks, 3, 3)) for _ in range(3))
    gradient = np.empty((blocks, 3))
    measure(frames, s, n, position, k3, omega, c)
    assert np.linalg.norm(omega, axis=1).max() > 1
    assemble(frames, s, n, blocks, k3, omega, force, diagonal, upper, gradient, sides)
    size = 3 * blocks
    hessian = np.zeros((size, size))
    for k in range(blocks):
        here, following = slice(3 * k, 3 * k + 3), slice(3 * k + 3, 3 * k + 6)
        hessian[here, here] = diagonal[k]
        if k + 1 < blocks:
            hessian[here, following] = upper[k]
            hessian[following, here] = upper[k].T
    if free_spin:
        hessian[size - 3, size - 3] = hessian[size - 2, size - 2] = 0
    h, one = 1e-4, np.eye(size)
    slope = [(lagrangian(h * e) - lagrangian(-h * e)) / (2 * h) for e in one]
    exact = (gradient - np.einsum("kij,j->ki", sides, force)).ravel()
    np.testing.assert_allclose(slope, exact, atol=1e-6)
    differences = [
        [
            lagrangian(h * (a + b))
            - lagrangian(h * (a - b))
            - lagrangian(h * (b - a))
            + lagrangian(-h * (a + b))
            for b in one
        ]
        for a in one
    ]
    np.testing.assert_allclose(np.array(differences) / (4 * h * h), hessian, atol=5e-6)


@pytest.mark.parametrize("free_spin", [False, True])
@pytest.mark.parametrize("torsion_ratio", [0.05, 1.0, 8.0])
def test_the_discrete_rod_reaches_a_minimum_from_every_pose(rng, torsion_ratio, free_spin):
    n = 64
    for position, rotation in zip(*pose_drawn(rng, 25, high=0.9), strict=True):
        s, frames = np.empty(n + 1), np.empty((n + 2, 4))
        force, moment = np.zeros(3), np.zeros(3)
        gap = 1 - np.linalg.norm(position)
        end = quaternion(rotation)
        start_frames(position, end, gap, free_spin, 0, False, False, n, s, frames, force)
        found, energy, index, iterations = relax(
            position, end, torsion_ratio, free_spin, n, s, frames, force, moment
        )
        assert found
        assert index == 0
        assert 0 < energy < math.inf
        assert iterations < 200
        tangents = Rotation.from_quat(frames[1:-1], scalar_first=True).as_matrix()[:, :, 2]
        np.testing.assert_allclose(np.diff(s) @ tangents, position, atol=_CLOSED)


def test_graded_nodes_crowd_where_the_boundary_layers_are():
    s = np.empty(65)
    for root in (0.5, 10.0, 100.0):
        graded_nodes(64, root, s)
        assert s[0] == 0
        assert s[-1] == 1
        assert (np.diff(s) > 0).all()
        np.testing.assert_allclose(s + s[::-1], 1, atol=1e-6)
        q = 0.5 * root
        ends, middle = 1 + 0.5 * q * (1 + np.exp(-q)), 1 + q * np.exp(-0.5 * q)
        assert np.diff(s)[0] / np.diff(s)[32] == pytest.approx(middle / ends, rel=0.25)
