"""Hydrogens that are bent aside."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from loopelastica.atoms.easing import eased


def facing(distance_A):
    """Two carriers whose hydrogens point at each other, a little aside."""
    to = np.array([[1.0, 0.1, 0.0], [-1.0, 0.1, 0.0]])
    to *= 1.09 / np.linalg.norm(to, axis=1, keepdims=True)
    reach = to[0, 0] - to[1, 0] + distance_A
    carriers = np.array([[0.0, 0, 0], [reach, 0, 0]])
    return carriers + to, carriers


@pytest.mark.parametrize("distance_A", [0.5, 0.9, 1.3])
def test_hydrogens_that_come_too_near_are_bent_apart_at_their_lengths(distance_A):
    hydrogens, carriers = facing(distance_A)
    found = eased(hydrogens, carriers, np.zeros(2, bool), carriers)
    before, after = (np.linalg.norm(x[0] - x[1]) for x in (hydrogens, found))
    assert before == pytest.approx(distance_A, abs=1e-9)
    assert after > distance_A + 0.2
    if distance_A > 0.8:
        assert after > 1.2
    np.testing.assert_allclose(np.linalg.norm(found - carriers, axis=1), 1.09)


def test_what_has_room_stays_to_the_last_digit():
    hydrogens, carriers = facing(1.8)
    found = eased(hydrogens, carriers, np.zeros(2, bool), carriers)
    np.testing.assert_array_equal(found, hydrogens)


def test_others_stay_where_one_pair_is_bent():
    near, far = facing(0.9), facing(1.9)
    hydrogens = np.concatenate([near[0], far[0] + 20.0])
    carriers = np.concatenate([near[1], far[1] + 20.0])
    found = eased(hydrogens, carriers, np.zeros(4, bool), carriers)
    np.testing.assert_array_equal(found[2:], hydrogens[2:])
    assert np.abs(found[:2] - hydrogens[:2]).max() > 0.1


def test_a_hydrogen_bond_is_no_contact():
    hydrogens, carriers = np.array([[1.0, 0, 0]]), np.zeros((1, 3))
    acceptor = np.array([[2.75, 0.1, 0]])
    heavy = np.concatenate([carriers, acceptor])
    of_nitrogen, of_carbon = (
        eased(hydrogens, carriers, np.array([polar]), heavy)[0] for polar in (True, False)
    )
    np.testing.assert_array_equal(of_nitrogen, hydrogens[0])
    assert np.linalg.norm(of_carbon - acceptor) > np.linalg.norm(hydrogens - acceptor) + 0.02


def test_a_rigid_motion_moves_them_along(rng):
    hydrogens, carriers = facing(0.9)
    turn, shift = Rotation.random(random_state=rng).as_matrix(), rng.normal(size=3)
    found = eased(hydrogens, carriers, np.zeros(2, bool), carriers) @ turn.T + shift
    moved = [x @ turn.T + shift for x in (hydrogens, carriers)]
    np.testing.assert_allclose(eased(*moved, np.zeros(2, bool), moved[1]), found, atol=1e-9)


def test_nothing_is_nothing():
    nothing = np.zeros((0, 3))
    assert eased(nothing, nothing, np.zeros(0, bool), nothing).shape == (0, 3)
