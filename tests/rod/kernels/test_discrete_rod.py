import numpy as np
import pytest

from loopelastica.rod.kernels.discrete_rod import (
    DiscreteRod,
    assemble,
    factor,
    measure,
    new_hessian,
)
from loopelastica.rod.kernels.rotations import turn

# kernels that Python does not call otherwise are compiled one by one
pytestmark = pytest.mark.slow


def zigzag(rng, n):
    """Frames whose hinges turn by angles of order one."""
    frames = np.zeros((n + 2, 4))
    frames[0] = (1, 0, 0, 0)
    for k in range(1, n + 2):
        frames[k] = frames[k - 1]
        turn(frames[k], *(0.7 * rng.normal(size=3)))
    return frames


def dense(hessian):
    """The block tridiagonal Hessian as a square array."""
    blocks = len(hessian.diagonal)
    full = np.zeros((3 * blocks, 3 * blocks))
    for k in range(blocks):
        here, following = slice(3 * k, 3 * k + 3), slice(3 * k + 3, 3 * k + 6)
        full[here, here] = hessian.diagonal[k]
        if k + 1 < blocks:
            full[here, following] = hessian.upper[k]
            full[following, here] = hessian.upper[k].T
    return full


@pytest.mark.parametrize("free_spin", [False, True])
def test_gradient_and_hessian_are_exact_far_from_straight(rng, discrete_rod, free_spin):
    n, k3 = 6, 0.3
    s, frames, force = np.linspace(0, 1, n + 1), zigzag(rng, n), 10 * rng.normal(size=3)
    blocks, position = n + free_spin, np.array([0.1, 0.2, 0.3])
    rod, hessian, c = DiscreteRod(s, frames), new_hessian(n, free_spin), np.empty(3)

    def lagrangian(b):
        moved = frames.copy()
        for k, v in enumerate(b.reshape(blocks, 3)):
            # the free clamp turns about its tangent only
            turn(moved[k + 1], *(v if k < n else (0, 0, v[2])))
        return measure(DiscreteRod(s, moved), position, k3, np.empty((n + 1, 3)), c) - force @ c

    measure(rod, position, k3, hessian.omega, c)
    assert np.linalg.norm(hessian.omega, axis=1).max() > 1
    assemble(rod, k3, force, hessian)
    size = 3 * blocks
    exact_hessian = dense(hessian)
    if free_spin:
        exact_hessian[size - 3, size - 3] = exact_hessian[size - 2, size - 2] = 0
    h, one = 1e-4, np.eye(size)
    slope = [(lagrangian(h * e) - lagrangian(-h * e)) / (2 * h) for e in one]
    exact = (hessian.gradient - np.einsum("kij,j->ki", hessian.sides, force)).ravel()
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
    np.testing.assert_allclose(np.array(differences) / (4 * h * h), exact_hessian, atol=5e-6)


@pytest.mark.parametrize("free_spin", [False, True])
def test_the_block_solver_is_a_dense_one_and_counts_negative_eigenvalues(rng, free_spin):
    n, shift, seen = 6, 0.3, set()
    for force in (0.0, 30.0, 300.0):
        rod, hessian = (
            DiscreteRod(np.linspace(0, 1, n + 1), zigzag(rng, n)),
            new_hessian(n, free_spin),
        )
        measure(rod, np.zeros(3), 0.3, hessian.omega, np.empty(3))
        assemble(rod, 0.3, force * rng.normal(size=3), hessian)
        blocks = n + free_spin
        right = rng.normal(size=(blocks, 3, 4))
        x = right.copy()
        negative = factor(hessian, rod.s, shift, np.empty((blocks, 3, 3)), x)
        matrix = dense(hessian) + shift / n * np.eye(3 * blocks)
        assert negative == np.count_nonzero(np.linalg.eigvalsh(matrix) < 0)
        expected = np.linalg.solve(matrix, right.reshape(-1, 4))
        np.testing.assert_allclose(x.reshape(-1, 4), expected, rtol=1e-7, atol=1e-9)
        seen.add(negative)
    assert len(seen) > 1
