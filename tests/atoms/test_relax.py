import dataclasses

import numpy as np
import pytest

from loopelastica.atoms.relax import Restraints, Status, _evaluate, _listed, relax


@pytest.fixture
def chain(rng):
    """Five atoms, four of them moving, with a term of every kind."""
    positions = rng.normal(scale=1.5, size=(6, 3))
    restraints = Restraints(
        n_moving=4,
        pairs=np.array([[0, 1], [1, 2], [2, 3], [3, 4]]),
        length_A=np.array([1.5, 1.4, 1.5, 1.6]),
        length_sd=np.full(4, 0.02),
        quads=np.array([[0, 1, 2, 3], [4, 1, 2, 3]]),
        volume=np.array([2.0, 0.0]),
        volume_sd=np.array([0.2, 0.3]),
        torsions=np.array([[0, 1, 2, 3], [1, 2, 3, 4]]),
        torsion_sd=0.5,
        groups=np.array([[0, 1], [2, 3]]),
        center_A=np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]]),
        center_sd=0.5,
        tether_A=positions[:4] + 0.1,
        tether_sd=3.0,
        near=np.array([[0, 5], [2, 5], [0, 3]]),
        near_A=np.array([9.0, 9.0, 9.0]),
    )
    return restraints, positions


def test_the_jacobian_is_that_of_central_differences(chain):
    restraints, positions = chain
    listed = _listed(restraints, positions)
    _, jacobian = _evaluate(restraints, positions, listed)
    step = 1e-6
    for column in range(12):
        ahead, behind = positions.copy(), positions.copy()
        ahead[column // 3, column % 3] += step
        behind[column // 3, column % 3] -= step
        slope = _evaluate(restraints, ahead, listed)[0] - _evaluate(restraints, behind, listed)[0]
        expected = slope / (2 * step)
        np.testing.assert_allclose(jacobian.toarray()[:, column], expected, rtol=1e-5, atol=1e-4)


def test_fixed_atoms_stay_and_bonds_are_restored(chain):
    restraints, positions = chain
    apart = dataclasses.replace(restraints, near=restraints.near[:0], near_A=restraints.near_A[:0])
    relaxed = relax(apart, positions)
    assert relaxed.status is Status.CONVERGED
    np.testing.assert_array_equal(relaxed.positions_A[4:], positions[4:])
    between = relaxed.positions_A[apart.pairs[:, 0]] - relaxed.positions_A[apart.pairs[:, 1]]
    np.testing.assert_allclose(np.linalg.norm(between, axis=1), apart.length_A, atol=0.05)
    assert set(relaxed.cost) >= {"lengths_and_angles", "overlaps", "line"}


def test_limits_of_steps_and_time_are_kept_and_told(chain):
    restraints, positions = chain
    short = relax(restraints, positions, max_steps=2)
    assert short.status is Status.STEPS
    assert "steps" in short.message
    late = relax(restraints, positions, max_seconds=0.0)
    assert late.status is Status.TIME
    np.testing.assert_array_equal(late.positions_A, positions)
