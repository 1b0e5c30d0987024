import copy
import json
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from loopelastica.rod.clamping import Clamping

angle = st.floats(0.01, 6.2)
length = st.floats(-0.5, 0.5)
q_strategy = st.tuples(length, length, length, angle, st.floats(0.01, 3.1), angle)


@given(q_strategy)
def test_the_six_parameters_come_back(q):
    np.testing.assert_allclose(Clamping.from_parameters(q).parameters, q, atol=1e-12)


@given(q_strategy)
def test_euler_angles_are_zyz_as_in_scipy(q):
    rotation = Rotation.from_euler("ZYZ", q[3:]).as_matrix()
    np.testing.assert_allclose(Clamping.from_parameters(q).rotation, rotation, atol=1e-14)


@pytest.mark.parametrize("theta", [0.0, np.pi])
def test_parameters_at_gimbal_lock_give_the_same_rotation(theta):
    c = Clamping.from_parameters([0.1, 0.2, 0.3, 1.0, theta, 2.0])
    again = Clamping.from_parameters(c.parameters)
    np.testing.assert_allclose(again.rotation, c.rotation, atol=1e-12)


@given(q_strategy)
def test_reduction_leaves_five_parameters_and_turns_back(q):
    c = Clamping.from_parameters(q)
    reduced, phi_a = c.reduced()
    assert reduced.position[0] >= 0
    assert reduced.position[1] == 0
    back = reduced.turned(phi_a)
    np.testing.assert_allclose(back.position, c.position, atol=1e-12)
    np.testing.assert_allclose(back.rotation, c.rotation, atol=1e-12)
    # eq. 16: psi grows by the angle that phi loses
    shift = (c.parameters - reduced.parameters)[3:]
    difference = np.exp(1j * shift) - np.exp(1j * np.array([phi_a, 0, -phi_a]))
    assert np.abs(difference).max() < 1e-9


@given(q_strategy)
def test_reversal_and_mirror_are_their_own_inverses(q):
    c = Clamping.from_parameters(q)
    for twice in (c.reversed().reversed(), c.mirrored().mirrored()):
        np.testing.assert_allclose(twice.position, c.position, atol=1e-14)
        np.testing.assert_allclose(twice.rotation, c.rotation, atol=1e-14)


def test_mirror_is_eq_35():
    q = Clamping.from_parameters([0.3, 0.0, 0.2, 1.1, 0.7, 2.3]).mirrored().parameters
    np.testing.assert_allclose(q, [0.3, 0, 0.2, 2 * np.pi - 1.1, 0.7, 2 * np.pi - 2.3], atol=1e-14)


def test_two_frames_in_space_give_the_same_clamping_wherever_they_are(rng):
    moves = Rotation.random(2, random_state=rng).as_matrix()
    start, end = Rotation.random(2, random_state=rng).as_matrix()
    origin, tip = rng.normal(size=(2, 3))
    reference = Clamping.from_frames(origin, start, tip, end, 7.0)
    for move in moves:
        shift = rng.normal(size=3) * 100
        moved = Clamping.from_frames(
            move @ origin + shift, move @ start, move @ tip + shift, move @ end, 7.0
        )
        np.testing.assert_allclose(moved.position, reference.position, atol=1e-12)
        np.testing.assert_allclose(moved.rotation, reference.rotation, atol=1e-12)


@pytest.mark.parametrize(
    ("position", "rotation", "word"),
    [
        ([0, 0], np.eye(3), "position"),
        ([0, 0, np.nan], np.eye(3), "position"),
        ([0, 0, 0.5], np.eye(2), "rotation"),
        ([0, 0, 0.5], 2 * np.eye(3), "rotation"),
        ([0, 0, 0.5], np.diag([1, 1, -1]), "reflection"),
        ([0, 0, 0.5], np.full((3, 3), np.inf), "rotation"),
    ],
)
def test_bad_arguments_are_named(position, rotation, word):
    with pytest.raises(ValueError, match=word):
        Clamping(position, rotation)


def test_integers_and_lists_are_cast_and_arrays_cannot_be_written():
    c = Clamping([0, 0, 0], [[1, 0, 0], [0, 1, 0], [0, 0, 1]])
    assert c.position.dtype == np.float64
    with pytest.raises(ValueError, match="read-only"):
        c.position[0] = 1
    assert Clamping.from_dict(c.to_dict()) == c


def test_what_is_read_back_is_equal_to_the_last_bit_and_cannot_be_written(rng):
    for rotation in Rotation.random(30, random_state=rng).as_matrix():
        c = Clamping(rng.uniform(-0.5, 0.5, 3), rotation + 1e-6 * rng.normal(size=(3, 3)))
        for again in (
            Clamping.from_dict(json.loads(json.dumps(c.to_dict()))),
            pickle.loads(pickle.dumps(c)),
            copy.deepcopy(c),
            copy.copy(c),
        ):
            assert again == c
            for array in (again.position, again.rotation):
                with pytest.raises(ValueError, match="read-only"):
                    array[0] = 1


def test_clampings_differ_in_any_of_their_parts():
    c = Clamping([0, 0, 0.5], np.eye(3))
    assert c != Clamping([0, 0, 0.5], np.eye(3), free_spin=True)
    assert c != Clamping([0, 0, np.nextafter(0.5, 1)], np.eye(3))
    assert c != Clamping.from_parameters([0, 0, 0.5, 1e-12, 0, 0])
    assert c != "a clamping"


def test_nearly_orthonormal_matrices_are_taken_for_the_nearest_rotation(rng):
    rotation = Rotation.random(random_state=rng).as_matrix()
    rounded = Clamping([0, 0, 0.5], rotation.round(5)).rotation
    np.testing.assert_allclose(rounded, rotation, atol=1e-5)
    np.testing.assert_allclose(rounded.T @ rounded, np.eye(3), atol=1e-15)
    with pytest.raises(ValueError, match="`rotation`"):
        Clamping([0, 0, 0.5], rotation.round(3))


def test_an_end_on_the_line_of_both_tangents_is_seen():
    line = Clamping.from_parameters([0, 0, -0.5, 2.0, 0, 0])
    assert line.on_one_line
    assert not Clamping.from_parameters([0, 0, 0.5, 2.0, np.pi, 0]).on_one_line
    assert not Clamping.from_parameters([1e-8, 0, 0.5, 2.0, 0, 0]).on_one_line
    assert not Clamping.from_parameters([0, 0, 0.5, 2.0, 1e-8, 0]).on_one_line


def test_a_clamping_shows_itself_as_it_can_be_written():
    clamping = Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2], free_spin=True)
    assert repr(clamping) == (
        "Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2], free_spin=True)"
    )
