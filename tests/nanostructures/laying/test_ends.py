"""Ends of strands against the ideal helix of the model, differentiated by differences."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from strands import helix, moved

from loopelastica.nanostructures.laying.ends import across, helix_ends
from loopelastica.nanostructures.oxdna.model import HELIX_RISE, HELIX_TWIST, backbone_sites, duplex


@pytest.mark.parametrize("strand", [0, 1])
def test_the_tangent_is_that_of_the_line_through_the_backbone_sites(strand):
    eps = 1e-5
    sites = backbone_sites(*duplex(3, rise=eps * HELIX_RISE, twist=eps * HELIX_TWIST))[strand]
    expected = (sites[2] - sites[0]) * (1 if strand == 0 else -1)
    made = helix("ACGTACGT", pair=range(15, -1, -1))
    # the other strand is listed from its own 5' end: its last nucleotide is at the bottom
    first = 0 if strand == 0 else 15
    frame = helix_ends(made, np.array([first])).frame[0]
    # at height 0 here, one step above there
    turn = Rotation.from_rotvec([0, 0, -eps * HELIX_TWIST]).as_matrix()
    np.testing.assert_allclose(frame[:, 2], turn @ expected / np.linalg.norm(expected), atol=1e-8)


def test_the_ends_are_the_backbone_sites_with_frames_towards_the_axis():
    made = helix("ACGTACGT", pair=range(15, -1, -1))
    index = np.arange(16)
    ends = helix_ends(made, index)
    sites = backbone_sites(made.centre, made.a1, made.a3)
    np.testing.assert_allclose(ends.point, sites, atol=1e-14)
    frames = ends.frame
    np.testing.assert_allclose(
        frames.transpose(0, 2, 1) @ frames, np.tile(np.eye(3), (16, 1, 1)), atol=1e-14
    )
    assert np.linalg.det(frames) == pytest.approx(1.0)
    inward = -sites * [1, 1, 0]
    inward /= np.linalg.norm(inward, axis=1)[:, None]
    np.testing.assert_allclose(frames[:, :, 0], inward, atol=1e-12)


def test_ends_move_with_their_helix(rng):
    made = helix("ACGTACGT", pair=range(15, -1, -1))
    turn = Rotation.from_rotvec([0.3, -1.2, 2.0])
    before, after = (
        helix_ends(one, np.array([3, 12])) for one in (made, moved(made, turn, [4.0, -2, 1]))
    )
    np.testing.assert_allclose(after.frame, turn.as_matrix() @ before.frame, atol=1e-12)


def test_bases_that_look_one_way_still_have_a_frame():
    made = helix("ACGT", pair=range(7, -1, -1))
    a3 = made.a3.copy()
    a3[7] = a3[0]
    frame = helix_ends(replace(made, a3=a3), np.array([0])).frame[0]
    np.testing.assert_allclose(frame.T @ frame, np.eye(3), atol=1e-12)


def test_what_is_across_is_a_unit_vector_where_there_is_nothing_to_choose_from():
    normal = np.array([[0.0, 0.0, 1.0]] * 3)
    found = across(np.array([[0.0, 0, 2], [0, 0, 0], [1, 0, 1e9]]), normal)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1.0)
    np.testing.assert_allclose(found[:, 2], 0.0, atol=1e-15)
