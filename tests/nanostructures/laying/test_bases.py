"""Directions of bases and the axes that follow."""

import numpy as np
from scipy.spatial.transform import Rotation

from loopelastica.nanostructures.laying.bases import (
    MIDDLE,
    REACH,
    axes_of,
    base_directions,
    turned_apart,
)
from loopelastica.nanostructures.oxdna.model import backbone_sites, base_sites, centre_of


def test_directions_point_from_backbone_sites_to_base_sites(rng):
    turns = Rotation.random(20, random_state=1).as_matrix()
    a1, a3 = turns[:, :, 0], turns[:, :, 2]
    centre = rng.normal(size=(20, 3))
    arm = base_sites(centre, a1) - backbone_sites(centre, a1, a3)
    np.testing.assert_allclose(REACH * base_directions(a1, a3), arm, atol=1e-14)
    # the centre is beside that share of the arm
    share = np.einsum("ij,ij->i", centre - backbone_sites(centre, a1, a3), arm) / REACH**2
    np.testing.assert_allclose(share, MIDDLE, atol=1e-14)


def test_axes_give_the_direction_back_and_their_normal_is_against_the_tangent(rng):
    direction, tangent = rng.normal(size=(2, 200, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    a1, a3 = axes_of(direction, tangent)
    np.testing.assert_allclose(base_directions(a1, a3), direction, atol=1e-14)
    assert (np.einsum("ij,ij->i", a3, tangent) < 0).all()
    gram = np.einsum("kij,lij->kli", np.stack([a1, a3]), np.stack([a1, a3]))
    np.testing.assert_allclose(gram, np.eye(2)[:, :, None] * np.ones(200), atol=1e-14)


def test_a_base_along_the_strand_has_axes_too():
    a1, a3 = axes_of(np.array([[0.0, 0, 1]]), np.array([[0.0, 0, 5]]))
    assert abs(float(a1[0] @ a3[0])) < 1e-15
    np.testing.assert_allclose(np.linalg.norm([a1, a3], axis=2), 1.0)


def test_a_base_turns_away_from_a_centre_that_its_own_is_on():
    site, tangent = np.zeros(3), np.array([0.0, 0, 0.7])
    direction = np.array([1.0, 0, 0])

    def centre(towards):
        return centre_of(site[None], *axes_of(towards[None], tangent[None]))

    for box in (np.zeros(3), np.full(3, 10.0)):
        met = centre(direction) + box
        found = turned_apart(site, direction, tangent, met, box)
        assert np.linalg.norm(centre(found) + box - met) > 0.8
        assert abs(found @ tangent) < 1e-12
