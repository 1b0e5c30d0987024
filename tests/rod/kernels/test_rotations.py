import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from loopelastica.rod.kernels.rotations import (
    about_axis,
    align,
    directors,
    exponential,
    larger,
    log_jacobian_inverse,
    logarithm,
    matrix_from_quaternion,
    multiply,
    quaternion_from_matrix,
    relative,
    rotation_vector,
    spin,
    tangent,
    turn,
    turn_in_space,
    wrap,
    zyz_angles,
)


def quaternions(rng, n=20):
    return Rotation.random(n, random_state=rng).as_quat(scalar_first=True)


def scipys(q):
    return Rotation.from_quat(q, scalar_first=True)


def same(q, rotation):
    assert abs(np.linalg.norm(q) - 1) < 1e-14
    assert (scipys(q) * rotation.inv()).magnitude() < 1e-14


def test_products_and_turns_are_scipys(rng):
    out = np.empty(4)
    for p, q, v in zip(quaternions(rng), quaternions(rng), rng.normal(size=(20, 3)), strict=True):
        multiply(p, q, out)
        same(out, scipys(p) * scipys(q))
        relative(p, q, out)
        same(out, scipys(p).inv() * scipys(q))
        by = Rotation.from_rotvec(v)
        for change, result in ((turn, scipys(q) * by), (turn_in_space, by * scipys(q))):
            turned = q.copy()
            change(turned, *v)
            same(turned, result)
        turned = q.copy()
        spin(turned, v[0])
        same(turned, scipys(q) * Rotation.from_rotvec([0, 0, v[0]]))
        about_axis(*(v / np.linalg.norm(v)), np.linalg.norm(v), out)
        same(out, by)


@pytest.mark.parametrize("size", [0.0, 1e-12, 1e-7, 1e-5, 1e-3, 1.0, np.pi - 1e-7])
def test_exponential_and_logarithm_are_inverse_at_every_size(rng, size):
    v = rng.normal(size=3)
    v *= size / np.linalg.norm(v)
    q = np.array(exponential(*v))
    assert np.linalg.norm(q) == pytest.approx(1, abs=1e-15)
    np.testing.assert_allclose(q, Rotation.from_rotvec(v).as_quat(scalar_first=True), atol=1e-15)
    for sign in (1, -1):
        np.testing.assert_allclose(logarithm(*(sign * q)), v, rtol=1e-9, atol=1e-16)


def test_matrices_are_scipys_and_come_back(rng):
    half_turns = np.vstack([np.eye(4), [[0, 0.6, 0.8, 0], [1e-9, 0, 0, 1]]])
    for q in np.vstack([quaternions(rng), half_turns]):
        matrix = matrix_from_quaternion(q)
        np.testing.assert_allclose(matrix, scipys(q).as_matrix(), atol=1e-15)
        np.testing.assert_allclose(np.array(directors(q)).reshape(3, 3).T, matrix, atol=1e-15)
        np.testing.assert_allclose(tangent(q), matrix[:, 2], atol=1e-15)
        same(quaternion_from_matrix(matrix), scipys(q))


def test_the_rotation_vector_carries_one_frame_to_the_other(rng):
    for p, q in zip(quaternions(rng), quaternions(rng), strict=True):
        v = rotation_vector(q, p)
        same(q, Rotation.from_rotvec(v) * scipys(p))
        assert np.linalg.norm(v) <= np.pi + 1e-15


@pytest.mark.parametrize("size", [1e-3, 0.009, 0.011, 1.0, 3.0])
def test_the_inverse_jacobian_of_the_logarithm_is_its_derivative(rng, size):
    v, h = rng.normal(size=3), 1e-5
    v *= size / np.linalg.norm(v)
    differences = np.empty((3, 3))
    for j in range(3):
        step = h * np.eye(3)[j]
        after, before = (
            (Rotation.from_rotvec(sign * step) * Rotation.from_rotvec(v)).as_rotvec()
            for sign in (1, -1)
        )
        differences[:, j] = (after - before) / (2 * h)
    np.testing.assert_allclose(log_jacobian_inverse(v), differences, atol=1e-8)


def test_alignment_is_the_shortest_rotation_to_any_direction(rng):
    q = np.empty(4)
    near_opposite = np.array([[0, 0, -1.0], [1e-4, 0, -1], [0, 3e-3, -1], [1e-9, 1e-9, -1]])
    near_opposite /= np.linalg.norm(near_opposite, axis=1)[:, None]
    random = rng.normal(size=(20, 3))
    for e in np.vstack([random / np.linalg.norm(random, axis=1)[:, None], near_opposite]):
        align(*e, q)
        # near the opposite direction 1 + e3 has lost digits
        assert np.linalg.norm(q) == pytest.approx(1, abs=1e-10)
        np.testing.assert_allclose(tangent(q), e, atol=1e-9)
        if e[2] > -0.999:
            assert scipys(q).magnitude() == pytest.approx(np.arccos(e[2]), abs=1e-7)


def test_zyz_angles_rebuild_the_rotation_at_the_poles_too(rng):
    poles = np.array([[1.0, 0, 0, 0], [0.6, 0, 0, 0.8], [0, 1, 0, 0], [0, 0.6, 0.8, 0]])
    for q in np.vstack([quaternions(rng), poles]):
        phi, alpha, chi = zyz_angles(*q)
        assert 0 <= alpha <= np.pi
        same(Rotation.from_euler("ZYZ", [phi, alpha, chi]).as_quat(scalar_first=True), scipys(q))


def test_angles_are_wrapped_to_half_a_turn_either_way():
    np.testing.assert_allclose(
        [wrap(a) for a in (0.3, np.pi, -np.pi, 4.0, -4.0, 20.0)],
        [0.3, -np.pi, -np.pi, 4 - 2 * np.pi, 2 * np.pi - 4, 20 - 6 * np.pi],
        atol=1e-14,
    )


def test_the_larger_of_two_numbers_does_not_hide_nan():
    assert larger(1.0, 2.0) == larger(2.0, 1.0) == 2.0
    assert np.isnan([larger(np.nan, 1.0), larger(1.0, np.nan)]).all()
