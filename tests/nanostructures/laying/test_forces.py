"""Forces on strands and where they lead."""

import numpy as np
import pytest
from chained import crowd, line

from loopelastica.nanostructures.laying.forces import Forces, _solved
from loopelastica.nanostructures.laying.neighbours import Neighbours


def test_forces_along_a_strand_have_an_energy(rng):
    # the matrix of their derivatives is symmetric
    chains = crowd(rng, n=10)
    chains.sites[:] = np.cumsum(0.4 * rng.normal(size=(10, 3)), axis=0)
    chains.tangent[0] = [0, 0, 1]
    chains.strand[[0, 9]] = -1
    rows = np.arange(1, 9)
    forces, eps = Forces(chains, rows, Neighbours(chains, rows)), 1e-5
    n = 3 * len(rows)
    matrix = np.zeros((n, n))
    for at in range(n):
        i, k = rows[at // 3], at % 3
        for sign in (1, -1):
            chains.sites[i, k] += sign * eps
            matrix[at] += sign * forces(True)[0].reshape(-1) / (2 * eps)
            chains.sites[i, k] -= sign * eps
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-3)
    assert np.abs(matrix).max() > 10


def test_the_banded_solution_is_that_of_the_whole_matrix(rng):
    n = 7
    whole = np.zeros((n, 3, n, 3))
    blocks = rng.normal(size=(n, 3, 3))
    block = blocks @ blocks.transpose(0, 2, 1) + 20 * np.eye(3)
    beside, beyond = rng.normal(size=(n, 3, 3)), rng.normal(size=n)
    beside = beside + beside.transpose(0, 2, 1)
    for i in range(n):
        whole[i, :, i] = block[i]
        for far, part in ((1, beside[i]), (2, beyond[i] * np.eye(3))):
            if i + far < n:
                whole[i + far, :, i] = whole[i, :, i + far] = part
    right = rng.normal(size=(n, 3))
    expected = np.linalg.solve(whole.reshape(3 * n, 3 * n), right.reshape(-1)).reshape(n, 3)
    np.testing.assert_allclose(_solved(block, beside, beyond, right), expected, atol=1e-12)


def test_a_step_from_near_rest_comes_nearer_to_it():
    chains = line(12)
    rng = np.random.default_rng(3)
    chains.sites[1:-1] += 0.01 * rng.normal(size=(10, 3))
    rows = np.arange(1, 11)
    forces = Forces(chains, rows, Neighbours(chains, rows))
    before = forces(True)
    forces.shift(forces.downhill(before, np.full(10, 0.01), True))
    after = forces(True)
    assert np.abs(after[0]).max() < 0.1 * np.abs(before[0]).max()


def test_steps_are_downhill_and_strands_do_not_see_each_other_in_them(rng):
    chains = crowd(rng)
    rows = np.arange(10)
    forces = Forces(chains, rows, Neighbours(chains, rows))
    force = forces(True)
    step = forces.downhill(force, np.full(10, 0.5), True)
    assert (step * force).sum(axis=(1, 2)) == pytest.approx(np.abs((step * force).sum(axis=(1, 2))))
    still = forces.downhill(force, np.full(10, 0.5), False)
    assert not still[0].any()
    np.testing.assert_array_equal(still[1], step[1])
