import numpy as np
import pytest
from chains import energy_by_scipy, shape_drawn
from scipy.spatial.transform import Rotation

from loopelastica.rod.kernels.chain import (
    assemble_chain,
    at_other_frames,
    measure_chain,
    new_chain,
    set_shape,
    spread,
)
from loopelastica.rod.kernels.discrete_rod import new_hessian
from loopelastica.rod.kernels.rotations import quaternion_from_matrix, turn

# kernels that Python does not call otherwise are compiled one by one
pytestmark = pytest.mark.slow


def unit_of(shape):
    return np.exp(np.log(shape.stiffness).mean())


def chain_of(shape, torsion_ratio):
    chain = new_chain(len(shape.steps))
    end = quaternion_from_matrix(shape.end_frame.copy())
    length, unit = set_shape(chain, shape.steps.copy(), end, shape.stiffness.copy(), torsion_ratio)
    assert length == pytest.approx(shape.length, rel=1e-14)
    assert unit == pytest.approx(unit_of(shape), rel=1e-14)
    return chain


def bent(rng, shape, torsion_ratio):
    """A chain whose hinges turn by angles of order one."""
    chain = chain_of(shape, torsion_ratio)
    chain.frames[0] = (1, 0, 0, 0)
    for k in range(1, len(chain.frames)):
        chain.frames[k] = chain.frames[k - 1]
        turn(chain.frames[k], *(0.7 * rng.normal(size=3)))
    chain.frames[-1] = quaternion_from_matrix(matrices(chain)[-1] @ shape.end_frame)
    return chain


def matrices(chain):
    return Rotation.from_quat(chain.frames, scalar_first=True).as_matrix()


def test_energy_and_closure_are_those_of_scipys_rotations(rng):
    shape = shape_drawn(rng, 6)
    chain, omega, c = bent(rng, shape, 0.3), np.empty((7, 3)), np.empty(3)
    energy = measure_chain(chain, np.array([0.1, 0.2, 0.3]), omega, c)
    turns = matrices(chain)
    nodes = np.einsum("kij,kj->i", turns[1:-1], shape.steps / shape.length)
    np.testing.assert_allclose(c, nodes - [0.1, 0.2, 0.3], atol=1e-14)
    turns[-1] = turns[-1] @ shape.end_frame.T
    expected = energy_by_scipy(shape, 0.3, turns) / unit_of(shape)
    assert energy == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("free_spin", [False, True])
def test_gradient_and_hessian_are_exact_far_from_rest(rng, free_spin):
    m = 6
    shape = shape_drawn(rng, m)
    chain, force = bent(rng, shape, 0.3), 10 * rng.normal(size=3)
    blocks, position = m + free_spin, np.array([0.1, 0.2, 0.3])
    hessian, c, moved = new_hessian(m, free_spin), np.empty(3), at_other_frames(chain)

    def lagrangian(b):
        moved.frames[:] = chain.frames
        for k, v in enumerate(b.reshape(blocks, 3)):
            # the free clamp turns about its own d3 only
            turn(moved.frames[k + 1], *(v if k < m else (0, 0, v[2])))
        return measure_chain(moved, position, np.empty((m + 1, 3)), c) - force @ c

    measure_chain(chain, position, hessian.omega, c)
    assert np.linalg.norm(hessian.omega, axis=1).max() > 1
    assemble_chain(chain, force, hessian)
    size = 3 * blocks
    exact_hessian = np.zeros((size, size))
    for k in range(blocks):
        here, following = slice(3 * k, 3 * k + 3), slice(3 * k + 3, 3 * k + 6)
        exact_hessian[here, here] = hessian.diagonal[k]
        if k + 1 < blocks:
            exact_hessian[here, following] = hessian.upper[k]
            exact_hessian[following, here] = hessian.upper[k].T
    if free_spin:
        exact_hessian[size - 3, size - 3] = exact_hessian[size - 2, size - 2] = 0
    h, one = 1e-4, np.eye(size)
    slope = [(lagrangian(h * e) - lagrangian(-h * e)) / (2 * h) for e in one]
    exact = (hessian.gradient - np.einsum("kij,j->ki", hessian.sides, force)).ravel()
    np.testing.assert_allclose(slope, exact, atol=2e-6)
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
    np.testing.assert_allclose(np.array(differences) / (4 * h * h), exact_hessian, atol=2e-5)


def test_a_hinge_between_opposite_segments_keeps_an_axis(rng):
    shape = shape_drawn(rng, 2)
    steps = np.array([[0, 0, 1.0], [0, 0, -1.0]])
    chain = new_chain(2)
    set_shape(chain, steps, quaternion_from_matrix(shape.end_frame.copy()), np.ones(3), 0.5)
    np.testing.assert_allclose(np.linalg.norm(chain.axes, axis=1), 1)


def test_the_ends_turn_is_spread_evenly(rng):
    chain = chain_of(shape_drawn(rng, 4), 1.0)
    chain.frames[-1] = chain.end
    turn(chain.frames[-1], 0.3, 0.2, -0.4)
    whole = Rotation.from_quat(chain.end, scalar_first=True).apply([0.3, 0.2, -0.4])
    middles, angle = (chain.s[1:] + chain.s[:-1]) / 2, np.linalg.norm(whole)
    assert spread(chain, 0.0) == pytest.approx(angle)
    turns = Rotation.from_quat(chain.frames[1:-1], scalar_first=True).as_rotvec()
    np.testing.assert_allclose(turns, np.outer(middles, whole), atol=1e-12)
    spread(chain, -1.0)
    other_way = Rotation.from_rotvec(np.outer(middles, whole * (1 - 2 * np.pi / angle)))
    turns = Rotation.from_quat(chain.frames[1:-1], scalar_first=True)
    assert (turns * other_way.inv()).magnitude().max() < 1e-7
