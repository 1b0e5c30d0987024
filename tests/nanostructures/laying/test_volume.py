"""Strands that move downhill."""

import numpy as np
import pytest
from chained import line

from loopelastica.nanostructures.laying.volume import bending, clear, into_window


def test_a_straight_strand_stays_where_it_is():
    chains = line(8)
    before = chains.sites.copy()
    clear(chains, np.array([0]), move=True)
    np.testing.assert_array_equal(chains.sites, before)
    np.testing.assert_allclose(bending(chains), 0.0, atol=1e-12)


def test_bases_turn_away_without_their_backbones():
    chains = line(8)
    chains.direction[3] = [-0.6, 0.0, -0.8]
    before = chains.sites.copy()
    clear(chains, np.array([0]), move=False)
    np.testing.assert_array_equal(chains.sites, before)
    assert chains.direction[3, 2] > -0.5
    np.testing.assert_allclose(np.linalg.norm(chains.direction, axis=1), 1.0)


def test_bonds_that_are_too_long_come_into_the_window():
    chains = line(8, gap=0.9)
    chains.sites[4, 2] += 0.5
    into_window(chains, np.array([0]))
    bonds = np.linalg.norm(np.diff(chains.sites, axis=0), axis=1)
    assert bonds.max() < 1.0
    assert bonds.min() > 0.55
    np.testing.assert_array_equal(chains.sites[[0, -1]], 0.9 * np.array([[0, 0, 0], [0, 0, 7]]))


def test_a_right_angle_has_the_energy_of_its_hinge():
    chains = line(5)
    chains.sites[3:] = chains.sites[2] + 0.7564 * np.array([[1.0, 0, 0], [2.0, 0, 0]])
    chains.tangent[4] = [1.0, 0.0, 0.0]
    assert bending(chains).sum() == pytest.approx(1 / 0.7564)
    # the clamp of the end stands at a right angle too, half a bond away
    chains.tangent[4] = [0.0, 0.0, 1.0]
    assert bending(chains).sum() == pytest.approx(3 / 0.7564)
