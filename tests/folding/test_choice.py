"""Weights of loop shapes, their mean, and shapes that cover what is likely."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from loopelastica.folding.choice import (
    CONTACT_A,
    Weighted,
    atoms_per_point,
    covering,
    sequence_distance,
    smooth_lines,
    weigh,
)
from loopelastica.folding.shape_table import letters_of, rms_A


@pytest.fixture
def shapes(rng):
    """Twelve shapes of five nucleotides in three heaps, and their weights."""
    middles = rng.normal(scale=4.0, size=(3, 5, 3))
    nodes = np.repeat(middles, 4, axis=0) + rng.normal(scale=0.3, size=(12, 5, 3))
    weights = rng.random(12)
    return Weighted(nodes, weights / weights.sum())


def plain(k, **changes):
    """Arguments of `weigh` for k shapes between which there is nothing to choose."""
    given = {
        "energies": np.ones(k),
        "distances": np.zeros(k),
        "copies": np.ones(k, dtype=np.int64),
        "contacts": np.zeros(k),
        "n": 5,
    }
    return given | changes


@pytest.mark.parametrize(
    ("other", "distance"),
    [
        ("CGAAAG", 0.0),
        ("UGAAAG", 0.25 * 0.6),  # closing pair, a pyrimidine as before
        ("CGAAAC", 0.25),
        ("CAAAAG", 1.5 * 0.6),  # beside it
        ("CGAAUG", 1.5),
        ("CGGAAG", 0.6),
        ("CGUAAG", 1.0),
        ("CUUCGG", 1.5 + 1.0 + 1.0 + 1.5 * 0.6),
    ],
)
def test_a_substitution_counts_by_its_place_and_class(other, distance):
    (found,) = sequence_distance(letters_of(other)[None], letters_of("CGAAAG"))
    assert found == pytest.approx(distance)


@pytest.mark.parametrize("n", [1, 3, 5, 9, 12])
def test_weights_are_shares(n, rng):
    energies, distances = rng.random(30), 3.0 * rng.random(30)
    weights = weigh(**plain(30, energies=energies, distances=distances, n=n))
    assert weights.sum() == pytest.approx(1.0)
    assert (weights > 0.0).all()


@pytest.mark.parametrize("name", ["energies", "distances", "contacts"])
@pytest.mark.parametrize("n", [3, 5, 9])
def test_energy_another_sequence_and_atoms_in_the_way_cost_weight(name, n):
    dear = np.array([1.0, 1.0, 1.0, 1.5])
    weights = weigh(**plain(4, **{name: dear, "n": n}))
    assert weights[3] < weights[0] == weights[1] == weights[2]


def test_many_copies_weigh_as_much_as_one():
    weights = weigh(**plain(4, copies=np.array([1, 3, 3, 3])))
    assert weights[0] == pytest.approx(weights[1:].sum())


def test_the_unit_of_the_energy_is_that_of_the_others(rng):
    energies = 1.0 + rng.random(9)
    first, second = (weigh(**plain(9, energies=scale * energies)) for scale in (1.0, 1e6))
    np.testing.assert_allclose(first, second, rtol=1e-9)


def test_what_cannot_be_deformed_weighs_nothing():
    weights = weigh(**plain(3, energies=np.array([1.0, np.inf, 1.0])))
    assert weights.tolist() == [0.5, 0.0, 0.5]
    assert weigh(**plain(2, energies=np.full(2, np.inf))).tolist() == [0.0, 0.0]
    # no energy at all is no division by zero
    assert weigh(**plain(2, energies=np.zeros(2))).tolist() == [0.5, 0.5]


def test_mean_and_expected_distance_are_those_of_the_weights():
    nodes = np.zeros((2, 3, 3))
    nodes[1, :, 0] = 4.0
    weighted = Weighted(nodes, np.array([0.75, 0.25]))
    np.testing.assert_allclose(weighted.mean_A[:, 0], 1.0)
    assert weighted.distance_A(weighted.mean_A) == pytest.approx(0.75 * 1.0 + 0.25 * 3.0)


def test_some_of_the_shapes_share_all_the_weight(shapes):
    rows = np.arange(12) < 5
    some = shapes.among(rows)
    assert some.weights.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(
        some.weights / some.weights[0], shapes.weights[:5] / shapes.weights[0]
    )
    nothing = Weighted(shapes.nodes_A, np.zeros(12)).among(rows)
    np.testing.assert_allclose(nothing.weights, 0.2)


def test_the_first_shape_covers_most_and_each_further_one_what_is_left(shapes):
    """Against all that could be taken, one after the other."""
    likely = np.sqrt(shapes.weights)
    gaps = np.array([rms_A(shapes.nodes_A, one) for one in shapes.nodes_A])
    chosen = covering(shapes, None, 4)
    for k in range(4):
        left = [np.min(gaps[[*chosen[:k], j]], axis=0) @ likely for j in range(12)]
        assert chosen[k] == int(np.argmin(left))
    assert len(set(chosen)) == 4
    # one of each heap before two of any
    assert {row // 4 for row in chosen[:3]} == {0, 1, 2}


def test_what_is_covered_already_is_not_covered_again(shapes):
    covered = rms_A(shapes.nodes_A, shapes.nodes_A[:4].mean(axis=0))
    assert {row // 4 for row in covering(shapes, covered, 2)} == {1, 2}


def test_no_more_shapes_are_chosen_than_there_are(shapes):
    weights = np.where(np.arange(12) < 3, 1 / 3, 0.0)
    few = Weighted(shapes.nodes_A, weights)
    assert sorted(covering(few, None, 5)) == [0, 1, 2]
    assert covering(few, None, 0) == []
    assert covering(Weighted(shapes.nodes_A, np.zeros(12)), None, 5) == []


def test_another_place_changes_no_choice(shapes, rng):
    turn, shift = Rotation.random(random_state=rng).as_matrix(), rng.normal(size=3)
    moved = Weighted(shapes.nodes_A @ turn.T + shift, shapes.weights)
    assert covering(moved, None, 5) == covering(shapes, None, 5)


def test_atoms_near_a_line_are_counted_per_point(rng):
    lines, atoms = rng.normal(scale=4.0, size=(3, 7, 3)), rng.normal(scale=4.0, size=(40, 3))
    near = np.linalg.norm(lines[:, :, None] - atoms, axis=-1) <= CONTACT_A
    np.testing.assert_allclose(atoms_per_point(lines, atoms), near.sum(axis=2).mean(axis=1))
    assert atoms_per_point(lines, np.empty((0, 3))).tolist() == [0.0, 0.0, 0.0]
    assert atoms_per_point(lines[:0], atoms).tolist() == []


@pytest.mark.parametrize("n", [1, 3, 8])
def test_smooth_lines_run_through_the_loop_and_no_further(rng, n):
    nodes = np.cumsum(rng.normal(scale=3.0, size=(2, n + 2, 3)), axis=1)
    lines = smooth_lines(nodes)
    np.testing.assert_allclose(lines[:, 0], nodes[:, 1], atol=1e-9)
    np.testing.assert_allclose(lines[:, -1], nodes[:, n], atol=1e-9)
