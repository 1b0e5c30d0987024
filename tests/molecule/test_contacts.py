"""Contacts of a line with the stem and with itself."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from loopelastica.molecule.contacts import contacts, stem_atoms
from loopelastica.molecule.hairpins import find_hairpins


def hairpin_line(width_A):
    """Up and down again at a distance: phases 1 … 9 along the chain."""
    s = np.linspace(0.0, 1.0, 41)
    up = np.stack([0 * s, 0 * s, 24 * s], axis=1)
    line = np.concatenate([up, up[::-1] + [width_A, 0, 0]])
    return line, np.concatenate([1 + 4 * s, 5.1 + 4 * s])


@pytest.mark.parametrize("width", [0.5, 4.9, 5.1])
def test_a_line_that_comes_back_on_itself(width):
    line, phases = hairpin_line(width)
    near = contacts(line, phases, np.zeros((0, 3)), np.zeros(0))
    assert near.self_A == pytest.approx(width, rel=1e-6, abs=0.4)
    assert near.touching == (width < 5.0)
    assert near.stem_A == np.inf


def test_neighbours_along_the_chain_are_no_contact():
    line, phases = np.array([[0.0, 0, 0], [1.0, 0, 0]]), np.array([1.0, 2.5])
    near = contacts(line, phases, np.array([[0.0, 0.1, 0]]), np.array([0.0]))
    assert (near.stem_A, near.self_A) == (pytest.approx(np.hypot(1.0, 0.1)), np.inf)


def test_a_straight_line_through_the_stem_touches_it_wherever_both_are(koc, rng):
    (hairpin,) = find_hairpins(koc)
    atoms, phases = stem_atoms(koc.nucleotides, hairpin, koc.positions(0))
    assert set(phases) == {0, -1, -2, -3, -4, 5, 6, 7, 8, 9}
    line = np.linspace(atoms[phases == -4].mean(axis=0), atoms[phases == 5].mean(axis=0), 50)
    middle = np.full(50, 2.5)
    near = contacts(line, middle, atoms, phases)
    assert near.touching
    turn = Rotation.random(random_state=rng)
    moved = contacts(turn.apply(line) + 3, middle, turn.apply(atoms) + 3, phases)
    assert moved.stem_A == pytest.approx(near.stem_A)
    assert not contacts(line + 100, middle, atoms, phases).touching


@pytest.mark.parametrize(("distance_A", "touched"), [(3.39, "stem"), (3.41, "")])
def test_a_line_touches_the_stem_within_two_carbon_radii(distance_A, touched):
    line, phases = np.array([[0.0, 0, 0], [0.0, 0, 6.0]]), np.array([3.0, 4.0])
    near = contacts(line, phases, np.array([[distance_A, 0, 0]]), np.zeros(1))
    assert near.touched == touched


@pytest.mark.parametrize(("distance_A", "touched"), [(4.99, "self"), (5.01, "")])
def test_a_line_touches_itself_within_two_backbones(distance_A, touched):
    line, phases = np.array([[0.0, 0, 0], [distance_A, 0, 0]]), np.array([1.0, 3.0])
    assert contacts(line, phases, np.zeros((0, 3)), np.zeros(0)).touched == touched
