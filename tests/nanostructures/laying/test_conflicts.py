"""Overlaps of laid nucleotides."""

import numpy as np
import pytest
from strands import system_of

from loopelastica.nanostructures.laying.conflicts import (
    conflicts_of,
    crossed,
    nearest_others,
    overlaps,
    strands_of,
    worst,
)
from loopelastica.nanostructures.oxdna.energies import energies


def two(distance):
    """Two straight strands that lie side by side, bases to the outside."""
    z = 0.75 * np.arange(5)[:, None] * [0.0, 0.0, 1.0]
    down = np.tile([0.0, 0.0, -1.0], (5, 1))
    out = np.tile([-1.0, 0.0, 0.0], (5, 1))
    return system_of([("TTTTT", z, out, down), ("TTTTT", z + [distance, 0.0, 0.0], out, down)])


def test_overlaps_are_the_excluded_volume_of_the_system():
    made = two(0.72)
    laid = np.arange(10) < 5
    found = overlaps(made, laid)
    assert np.isfinite(found.energy).all()
    energy = energies(made)
    expected = energy["nonbonded_excluded_volume"] + energy["bonded_excluded_volume"]
    assert found.energy.sum() == pytest.approx(expected)
    assert expected > 1
    strand = np.where(laid, 0, -1)
    assert worst(found, strand, 1)[0] == pytest.approx(expected)


def test_far_nucleotides_do_not_overlap():
    found = overlaps(two(3.0), np.ones(10, dtype=bool))
    assert len(found.energy) == 0


def test_centres_that_are_too_near_are_named_by_both_strands():
    made = two(0.3)
    strand = np.repeat([0, 1], 5)
    found = overlaps(made, strand >= 0)
    assert np.isinf(found.energy).sum() == 5
    assert strands_of(found, strand, 1.0).tolist() == [0, 1]
    assert crossed(made, strand).tolist() == [0, 1]
    named = conflicts_of(made, found, strand, ["one", "other"])
    first = named[0][0]
    assert (first.first, first.second) == (0, 5)
    assert first.distance == pytest.approx(0.3)
    assert "one: nucleotide 0 is too near to nucleotide 5 of other" in first.sentence
    assert any(one.first == 5 and one.second == 0 for one in named[1])


def test_a_bond_out_of_the_window_is_a_conflict():
    made = two(3.0)
    made = system_of(
        [
            (
                "TTTTT",
                made.centre[:5] + np.outer([0, 0, 0, 1, 1], [0, 0, 0.5]),
                made.a1[:5],
                made.a3[:5],
            )
        ]
    )
    found = overlaps(made, np.ones(5, dtype=bool))
    assert (found.first.tolist(), found.second.tolist()) == ([2], [3])
    (conflict,) = conflicts_of(made, found, np.zeros(5, dtype=int), ["one"])[0]
    assert "neighbours whose centres are 1.250 apart" in conflict.sentence


def test_the_nearest_is_no_neighbour():
    near = nearest_others(two(1.2), np.arange(10) < 5)
    np.testing.assert_allclose(near[:5], 1.2)
    assert np.isinf(near[5:]).all()
