import numpy as np
import pytest
from draws import closed_ring, drawn_rods, shot
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod.kernels.records import Status
from loopelastica.rod.morse import homotopy_class, morse_count

CLAMPING = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
FREE = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2], free_spin=True)


def rods(clamping, *indices):
    """Something that passes for equilibria of these indices, all in one component."""
    loads = np.array([1.0, 0, 0, 0, 0.1, 0])
    return [
        le.Equilibrium(clamping, 1.0, loads, 10.0 + i, 0.0, Status.CONVERGED, index=i)
        for i in indices
    ]


def test_a_free_spin_asks_for_as_many_passes_as_minima():
    count = morse_count(rods(FREE, 0, 1))
    assert (count.by_index, count.expected, count.excess) == ((1, 1), (1, 1), (0, 0))
    assert count.holds == (True, True)
    assert count.text.endswith("m = 1, 1 up to the energy 11: Morse's inequalities hold")
    count = morse_count(rods(FREE, 0, 0, 1))
    assert count.excess == (1, -1)
    assert count.missing == (0, 1)
    assert count.holds == (True, None)
    assert "one saddle of index 1 is missing below the bound, or lies above it" in str(count)


def test_fixed_frames_ask_for_one_pass_less_than_minima_in_each_component():
    # a component with nothing in it lacks its minimum, or has it above the bound
    count = morse_count(rods(CLAMPING, 0, 0, 0, 1))
    assert count.by_index == (3, 1)
    assert count.expected == (2, 0)
    assert sorted(count.by_component) == [(0, 0), (3, 1)]
    # 3 − 2 and (1 − 0) − 1: the sum holds, the component that has all of them does not
    assert count.excess == (1, 0)
    assert count.missing == (1, 1)
    assert count.holds == (None, None)
    assert morse_count(rods(CLAMPING, 0, 0, 0, 1, 1)).holds == (None, True)


def test_a_component_without_a_minimum_is_certainly_incomplete():
    count = morse_count(rods(FREE, 1, 2))
    assert count.holds[0] is False
    assert "at least one minimum is missing below the bound" in count.text
    assert "or lies above it" not in count.text.split(";")[0]


def test_the_bound_cuts_the_count():
    count = morse_count(rods(FREE, 0, 1, 2, 3), 11.5)
    assert count.by_index == (1, 1)
    assert count.energy_max == 11.5


def test_families_count_by_their_homology():
    ring = closed_ring(1, free_spin=True)
    eight = next(r for r in twice_bent(free_spin=True))
    assert (ring.family_dimension, eight.family_dimension) == (1, 2)
    # a circle of minima: 1 + t
    assert morse_count([ring]).by_index == (1, 1)
    # a torus of index k: t^k (1 + 2 t + t²)
    k = le.ways_down(eight)
    index = len(k) // 2
    counted = morse_count([eight]).by_index
    assert counted == (*(0,) * index, 1, 2, 1)
    arch = le.solve(le.Clamping([0, 0, 0.9], np.eye(3)))
    assert arch.family_dimension == 1
    assert morse_count([arch]).by_index == (1, 1)


def twice_bent(free_spin=False):
    """The closed planar elastica of figure-eight shape, E = 56.220."""
    from scipy.optimize import brentq
    from scipy.special import ellipe, ellipk

    # 2 E(m) = K(m); four quarter periods in unit length
    m = brentq(lambda m: 2 * ellipe(m) - ellipk(m), 0.5, 0.99)
    root = 4 * ellipk(m)
    curvature = 2 * np.sqrt(m) * root
    # at the point of largest curvature the force is along the tangent
    for sign in (1.0, -1.0):
        loads = np.array([0, 0, sign * root**2, 0, curvature, 0])
        rod = shot(le.Clamping(np.zeros(3), np.eye(3), free_spin), 1.0, loads)
        if np.abs(rod.centerline(2)[1]).max() < 1e-7:
            yield rod


def test_the_figure_eight_and_its_index():
    from dense import eigenvalues

    (eight,) = twice_bent()
    assert eight.energy == pytest.approx(56.220, abs=1e-3)
    assert eight.family_dimension == 2
    values = eigenvalues(eight, 64)
    # turns about its tangent and shifts along itself
    assert np.sum(np.abs(values) < 0.1) == 2
    assert le.rod.stability.morse_index(eight) == np.sum(values < -0.1)


@pytest.mark.parametrize("torsion_ratio", [0.7, 1.0])
def test_the_classes_of_two_rods_differ_as_their_turns_are_odd_apart(torsion_ratio):
    compared = 0
    for clamping in (CLAMPING, CLAMPING.mirrored(), CLAMPING.reversed()):
        found = le.equilibria(clamping, torsion_ratio, rounds=1)
        known = [rod for rod in found if rod.turns is not None]
        for rod in known:
            odd = (rod.turns - known[0].turns) % 2
            assert odd == (homotopy_class(rod) != homotopy_class(known[0]))
            compared += odd
    assert compared > 2


def test_a_full_turn_of_the_end_changes_the_class():
    rod = le.solve(CLAMPING)
    once = le.twist_end(rod, 1.0).end
    assert once.clamping.rotation == pytest.approx(CLAMPING.rotation, abs=1e-9)
    assert homotopy_class(once) != homotopy_class(rod)
    assert homotopy_class(le.twist_end(once, 1.0).end) == homotopy_class(rod)


def test_a_free_spin_has_one_class(rng):
    assert {homotopy_class(rod) for rod in drawn_rods(rng, 8, 1.0, True)} == {0}


def test_rods_of_several_clampings_and_none_are_refused():
    with pytest.raises(ValueError, match="different clampings"):
        morse_count([*rods(FREE, 0), *rods(CLAMPING, 0)])
    with pytest.raises(ValueError, match="`rods` has no equilibrium"):
        morse_count([])


@pytest.mark.parametrize("short", [1e-4, 1e-8])
def test_classes_of_rods_in_boundary_layers_go_with_their_turns(short):
    # beyond any number of frames at equal distances
    frame = Rotation.from_rotvec([0.4, 0.8, -0.3]).as_matrix()
    rods = le.equilibria(le.Clamping([0, 0, 1 - short], frame), rounds=1)
    assert all(len(rod.layers) for rod in rods)
    by_twist = sorted(rods, key=lambda rod: rod.twist)
    odd = [round(rod.twist - by_twist[0].twist) % 2 for rod in by_twist]
    differs = [int(homotopy_class(rod) != homotopy_class(by_twist[0])) for rod in by_twist]
    assert differs == odd
    assert sum(odd) > 0
