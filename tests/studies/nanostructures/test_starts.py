import numpy as np
import pytest

from loopelastica.nanostructures.laying.ends import helix_ends
from loopelastica.nanostructures.oxdna.energies import bonds
from loopelastica.nanostructures.oxdna.model import BOND_LENGTH
from loopelastica.studies.nanostructures.starts import arc, chord, exported, on_curves


def perpendicular(first, second):
    np.testing.assert_allclose(np.einsum("ij,ij->i", first, second), 0, atol=1e-12)


def test_a_chord_is_straight_and_evenly_spaced():
    start, end = np.array([1.0, 2.0, 3.0]), np.array([4.0, 6.0, 3.0])
    sites, direction, tangent = chord(start, end, np.array([0.0, 0.0, 1.0]), 5)
    steps = np.diff([start, *sites, end], axis=0)
    np.testing.assert_allclose(steps, np.tile((end - start) / 5, (5, 1)), atol=1e-12)
    np.testing.assert_allclose(tangent, np.tile([0.6, 0.8, 0.0], (4, 1)), atol=1e-12)
    perpendicular(direction, tangent)


@pytest.mark.parametrize("distance", [0.01, 1.4, 3.0, 7 * BOND_LENGTH - 0.01])
def test_an_arc_is_a_circle_with_unstretched_bonds_bowed_outwards(distance, rng):
    start = rng.normal(size=3)
    along = rng.normal(size=3)
    end = start + distance * along / np.linalg.norm(along)
    outward = rng.normal(size=3)
    sites, direction, tangent = arc(start, end, outward, 7)
    points = np.array([start, *sites, end])
    np.testing.assert_allclose(np.linalg.norm(np.diff(points, axis=0), axis=1), BOND_LENGTH)
    # on one sphere and in one plane
    middle = points - points.mean(axis=0)
    assert np.linalg.svd(middle)[1][2] < 1e-9
    turns = np.diff(points, axis=0)
    cosines = np.einsum("ij,ij->i", turns[1:], turns[:-1])
    np.testing.assert_allclose(cosines, cosines[0], atol=1e-8)
    assert (sites.mean(axis=0) - (start + end) / 2) @ outward > 0
    perpendicular(direction, tangent)
    perpendicular(tangent[2:3], direction[2:3])
    assert tangent[3] @ (end - start) > 0


def test_an_arc_that_is_too_short_is_a_chord():
    start, end = np.zeros(3), np.array([9.0, 0.0, 0.0])
    line, straight = (curve(start, end, np.eye(3)[1], 5) for curve in (arc, chord))
    for one, other in zip(line, straight, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("curve", [chord, arc])
def test_curves_leave_helices_where_they_are_and_join_them(curve, laid):
    _, found = laid("linkers", 1, 6)
    start = on_curves(found.system, found.strands, curve)
    paired = found.system.pair >= 0
    np.testing.assert_array_equal(start.centre[paired], found.system.centre[paired])
    lengths = bonds(start)
    for one in found.strands:
        if one.status == "refused":
            assert not start.placed[one.nucleotides].any()
            continue
        own = np.isin(lengths.first, [one.before, *one.nucleotides])
        ends = helix_ends(start, np.array([one.before, one.after])).point
        apart = np.linalg.norm(ends[1] - ends[0])
        expected = apart / (len(one) + 1)
        if curve is arc:
            expected = max(expected, BOND_LENGTH)
        np.testing.assert_allclose(lengths.length[own], expected, rtol=1e-4)


def test_tails_go_straight_on(laid):
    _, found = laid("tails", 0, 8)
    start = on_curves(found.system, found.strands, chord)
    lengths = bonds(start)
    own = np.isin(lengths.first, np.flatnonzero(found.system.pair < 0))
    np.testing.assert_allclose(lengths.length[own], BOND_LENGTH)


def test_the_exporter_lists_nucleotides_in_the_same_order(laid):
    design, found = laid("linkers", 1, 6)
    start = exported(design, found.system, found.strands)
    paired = found.system.pair >= 0
    apart = np.linalg.norm(start.centre - found.system.centre, axis=1)[paired]
    # grooves differ by some degrees, and helices begin at a common origin
    assert apart.max() < 1.0


def test_the_exporter_divides_by_zero_at_hairpins(laid):
    design, found = laid("hairpins", 0, 3)
    with pytest.raises(ZeroDivisionError):
        exported(design, found.system, found.strands)
