import dataclasses

import numpy as np
import pytest

from loopelastica.atoms.relax import STAGES, Restraints, Status, cost, relax

STRICT = STAGES[-1]


@pytest.fixture
def chain(rng):
    """Five atoms, four of them moving, with a term of every kind."""
    positions = rng.normal(scale=1.5, size=(6, 3))
    least = np.zeros((4, 6))
    for i, j in [(0, 5), (2, 5), (0, 3)]:
        least[i, j] = 9.0
    restraints = Restraints(
        n_moving=4,
        pairs=np.array([[0, 1], [1, 2], [2, 3], [3, 4]]),
        length_A=np.array([1.5, 1.4, 1.5, 1.6]),
        length_sd=np.full(4, 0.02),
        quads=np.array([[0, 1, 2, 3], [4, 1, 2, 3]]),
        volume=np.array([2.0, 0.0]),
        volume_sd=np.array([0.2, 0.3]),
        torsions=np.array([[0, 1, 2, 3], [1, 2, 3, 4]]),
        torsion_fold=np.array([3.0, 1.0]),
        torsion_at=np.array([np.pi / 3.0, 2.0]),
        torsion_sd=np.array([0.27, 0.5]),
        groups=np.array([[0, 1], [2, 3]]),
        center_A=np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]]),
        center_sd=0.5,
        tether_A=positions[:4] + 0.1,
        tether_sd=np.full(4, 3.0),
        least_A=least,
        floor_A=np.minimum(least, 4.0),
    )
    return restraints, positions


def value_and_gradient(restraints, positions, stage=STRICT):
    from loopelastica.atoms.kernels.terms import evaluate, near_pairs

    terms = restraints.terms(stage)
    listed = np.empty((50, 2), dtype=np.int64)
    count = near_pairs(positions, terms.least, listed)
    gradient = np.empty_like(positions)
    return evaluate(positions, terms, listed, count, gradient), gradient


def test_the_gradient_is_that_of_central_differences(chain):
    restraints, positions = chain
    _, gradient = value_and_gradient(restraints, positions)
    step = 1e-6
    for column in range(12):
        ahead, behind = positions.copy(), positions.copy()
        ahead[column // 3, column % 3] += step
        behind[column // 3, column % 3] -= step
        slope = value_and_gradient(restraints, ahead)[0] - value_and_gradient(restraints, behind)[0]
        expected = slope / (2 * step)
        assert gradient[column // 3, column % 3] == pytest.approx(expected, rel=1e-5, abs=1e-3)


def test_the_kernel_adds_up_what_numpy_finds_term_by_term(chain):
    restraints, positions = chain
    energy, _ = value_and_gradient(restraints, positions)
    assert energy == pytest.approx(0.5 * sum(cost(restraints, positions).values()))


def test_pairs_are_listed_until_they_are_a_skin_apart(chain):
    from loopelastica.atoms.kernels.terms import SKIN_A, near_pairs

    _, positions = chain
    listed = np.empty((1, 2), dtype=np.int64)
    apart = np.linalg.norm(positions[0] - positions[5])
    least = np.zeros((1, 6))
    for reach, count in ((apart - SKIN_A + 0.01, 1), (apart - SKIN_A - 0.01, 0), (0.0, 0)):
        least[0, 5] = reach
        assert near_pairs(positions, least, listed) == count
    # more pairs than there is room for
    least[0] = 99.0
    assert near_pairs(positions, least, listed) == -1


def test_fixed_atoms_stay_and_bonds_are_restored(chain):
    restraints, positions = chain
    none = np.zeros_like(restraints.least_A)
    apart = dataclasses.replace(restraints, least_A=none, floor_A=none)
    relaxed = relax(apart, positions)
    assert relaxed.status is Status.CONVERGED
    np.testing.assert_array_equal(relaxed.positions_A[4:], positions[4:])
    between = relaxed.positions_A[apart.pairs[:, 0]] - relaxed.positions_A[apart.pairs[:, 1]]
    np.testing.assert_allclose(np.linalg.norm(between, axis=1), apart.length_A, atol=0.05)
    assert set(relaxed.cost) >= {"lengths_and_angles", "overlaps", "line"}
    _, gradient = value_and_gradient(apart, np.array(relaxed.positions_A))
    assert np.abs(gradient[:4]).max() <= STRICT.tolerance


def test_atoms_pass_through_one_another_where_overlap_is_cheap_and_not_where_it_is_dear(chain):
    """An atom that a wall of one atom keeps from its place."""
    restraints, _ = chain
    nothing = np.zeros((0, 2), dtype=np.int64)
    four = np.zeros((0, 4), dtype=np.int64)
    wall = dataclasses.replace(
        restraints,
        n_moving=1,
        pairs=nothing,
        length_A=np.zeros(0),
        length_sd=np.zeros(0),
        quads=four,
        volume=np.zeros(0),
        volume_sd=np.zeros(0),
        torsions=four,
        torsion_fold=np.zeros(0),
        torsion_at=np.zeros(0),
        torsion_sd=np.zeros(0),
        groups=nothing,
        center_A=np.zeros((0, 3)),
        tether_A=np.array([[3.0, 0.0, 0.0]]),
        tether_sd=np.ones(1),
        least_A=np.array([[0.0, 3.0]]),
        floor_A=np.array([[0.0, 2.4]]),
    )
    start = np.array([[-3.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    loosest = dataclasses.replace(STAGES[0], tolerance=1e-3)
    loose, strict = (
        relax(wall, start, stages=[stage]).positions_A[0, 0] for stage in (loosest, STRICT)
    )
    assert loose > 2.0
    assert strict < -2.0


def test_limits_of_steps_and_time_are_kept_and_told(chain):
    restraints, positions = chain
    short = relax(restraints, positions, max_steps=2)
    assert short.status is Status.STEPS
    assert "steps" in short.message
    late = relax(restraints, positions, max_seconds=0.0)
    assert late.status is Status.TIME
    np.testing.assert_array_equal(late.positions_A, positions)
