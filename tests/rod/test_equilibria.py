import itertools
from dataclasses import replace

import numpy as np
import pytest
from draws import load_drawn, pose_drawn
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod.equilibria import Equilibria, _Found, _merge
from loopelastica.rod.kernels.records import Method, Status

FIGURE_6 = [-0.4, -0.1, 0.5, 4.8, 1.4, 2.2]


def rod_of_energy(energy):
    """Something with an energy that passes for an equilibrium."""
    clamping = le.Clamping([0, 0, 0.5], np.eye(3))
    return le.Equilibrium(clamping, 1.0, np.full(6, energy), energy, 0.0, Status.CONVERGED)


def energies(rods):
    return [rod.energy for rod in rods]


def missing(rods, others):
    """Energies that ``others`` lack, as often as they do."""
    left = energies(others)
    lacking = []
    for energy in energies(rods):
        near = [e for e in left if abs(e - energy) < 1e-6 * (1 + energy)]
        if near:
            left.remove(near[0])
        else:
            lacking.append(energy)
    return lacking


def test_chain_reversal_gives_the_reversed_rod(rng):
    for position, rotation in zip(*load_drawn(rng, 10), strict=True):
        clamping = le.Clamping(position, rotation)
        forward = le.equilibria(clamping, rounds=1)
        backward = le.equilibria(clamping.reversed(), rounds=1)
        # the search starts differ, so the lists may; the lowest is found from both sides
        assert forward[0].energy == pytest.approx(backward[0].energy, rel=1e-8)
        line = forward[0].centerline(9)
        # the reversed start frame is ours at the end, with d2 and d3 turned round
        ours = rotation @ np.diag([1.0, -1, -1])
        again = backward[0].centerline(9)[::-1] @ ours.T + position
        np.testing.assert_allclose(again, line, atol=1e-6)


def test_known_planar_energies_at_aligned_ends():
    # planar elasticae over a chord of 0.9: two inflections, one loop (see the docstring's bound)
    rods = le.equilibria(le.Clamping([0, 0, 0.9], np.eye(3)))
    energies = np.array([rod.energy for rod in rods])
    for known in (4.1, 16.2, 36.5):
        assert np.abs(energies - known).min() < 0.06
    # a circle of solutions is listed once: energies repeat for mirror images only
    assert np.sum(np.abs(energies - energies[0]) < 1e-6) == 1


def test_equilibria_are_sorted_distinct_and_below_the_bound(rng):
    for position, rotation in zip(*load_drawn(rng, 10), strict=True):
        rods = le.equilibria(le.Clamping(position, rotation), energy_max=60.0)
        energies = [rod.energy for rod in rods]
        assert energies == sorted(energies)
        assert all(e <= 60 for e in energies)
        assert 0 <= rods.unseen <= 1
        for i, a in enumerate(rods):
            for b in rods[:i]:
                assert np.abs(a.frames(9) - b.frames(9)).max() > 1e-5


def test_turns_select_wound_rods_and_circles_are_labelled():
    tense = le.Clamping.from_parameters([0.0, 0.0, 0.97, 0.3, 0.1, 0.2])
    for turns in (0, -3):
        rods = le.equilibria(tense, turns=turns, rounds=1, energy_max=1e4)
        assert rods
        assert {rod.turns for rod in rods} == {turns}
        # under tension one of them carries the turns as twist, others as loops
        assert any(abs(rod.twist - turns) < 0.6 for rod in rods)
    assert not rods[0].family
    assert all(rod.family for rod in le.equilibria(le.Clamping([0, 0, 0.9], np.eye(3)), rounds=1))


def test_a_list_is_sorted_and_ends_at_its_bound():
    hits = {7.0: 1, 3.0: 5, 5.0: 1, 4.0: 0, 99.0: 1}
    rods = Equilibria([_Found(rod_of_energy(e), n) for e, n in hits.items()], 50.0, 17)
    assert [rod.energy for rod in rods] == [3.0, 4.0, 5.0, 7.0]
    assert rods.hits == (5, 0, 1, 1)
    assert (rods.energy_max, rods.starts, rods.out_of_time) == (50.0, 17, False)
    # the bound itself is listed
    assert len(Equilibria([_Found(rod_of_energy(3.0), 1)], 3.0, 4)) == 1
    empty = Equilibria([], 50.0, 4)
    assert (empty.unseen, empty.by_index, empty.morse) == (1, (), None)
    assert "0 equilibria up to the energy 50: none." in empty.evidence


def test_what_is_unseen_falls_with_each_round_and_rises_with_the_index():
    def unseen(rounds, *indices, bound=50.0):
        found = [_Found(replace(rod_of_energy(3.0 + i), index=i), 9) for i in indices]
        return Equilibria(found, bound, 17, rounds=rounds).unseen

    by_round = [unseen(n, 0, 1, 2) for n in (1, 2, 3, 4)]
    assert by_round == sorted(by_round, reverse=True)
    assert 0 < by_round[3] < by_round[0] < 1
    assert unseen(2, 0) < unseen(2, 0, 1) < unseen(2, 0, 1, 2)
    # far above the default bound the share of single hits counts as well
    once = [_Found(rod_of_energy(e), 1) for e in (3.0, 4.0)]
    assert Equilibria(once, 1e3, 17, rounds=2).unseen == 1


def test_hits_are_counted_and_the_best_copy_is_kept():
    rod = le.solve(le.Clamping.from_parameters(FIGURE_6))
    other = le.equilibria(rod.clamping, rounds=1)[1]
    worse, better = replace(rod, residual=1e-3), replace(rod, residual=1e-15)
    found = []
    for each in (worse, better, other, worse, replace(rod, status=Status.STALLED)):
        _merge(found, each)
    assert [f.hits for f in found] == [3, 1]
    assert found[0].rod is better
    assert found[1].rod is other
    # met on a tour, which is no hit
    _merge(found, other, 0)
    assert found[1].hits == 1


def test_the_list_counts_its_starts_and_its_hits():
    rods = le.equilibria(le.Clamping.from_parameters(FIGURE_6), rounds=1)
    assert len(rods.hits) == len(rods)
    assert min(rods.hits) >= 1
    assert sum(rods.hits) <= rods.starts
    assert rods.energy_max == pytest.approx(rods[0].energy + 8 * np.pi**2)
    assert not rods.out_of_time
    assert all(rod.index is not None for rod in rods)
    low = le.equilibria(rods[0].clamping, energy_max=20.0, rounds=1)
    assert [rod.energy for rod in low] == [rod.energy for rod in rods if rod.energy <= 20]
    assert sum(rods.found_by.values()) >= len(rods)
    assert "solve" in rods.found_by
    assert rods.by_index == tuple(
        sum(rod.index == k for rod in rods) for k in range(len(rods.by_index))
    )


@pytest.mark.parametrize("free_spin", [False, True])
def test_rounds_are_made_as_told_and_lose_nothing(free_spin):
    clamping = le.Clamping.from_parameters(FIGURE_6, free_spin)
    lists = [le.equilibria(clamping, rounds=n) for n in (1, 2, 3, 4)]
    assert [rods.rounds for rods in lists] == [1, 2, 3, 4]
    starts = [rods.starts for rods in lists]
    assert starts == sorted(set(starts))
    for less, more in itertools.pairwise(lists):
        assert missing(less, more) == []
        assert less.unseen >= more.unseen
    default = le.equilibria(clamping)
    assert energies(default) == energies(lists[1])
    assert (default.rounds, default.starts) == (2, lists[1].starts)


def test_a_search_again_gives_the_same_list():
    clamping = le.Clamping.from_parameters(FIGURE_6)
    one, two = le.equilibria(clamping, 0.7), le.equilibria(clamping, 0.7)
    assert energies(one) == energies(two)
    assert (one.hits, one.found_by, one.tours) == (two.hits, two.found_by, two.tours)


def test_the_evidence_is_in_words():
    rods = le.equilibria(le.Clamping.from_parameters(FIGURE_6))
    assert rods.evidence.startswith(f"{len(rods)} equilibria up to the energy 86.01: ")
    for index, count in enumerate(rods.by_index):
        assert f"{count} of index {index}" in rods.evidence
    assert f"{rods.starts} starts in 2 of 4 rounds; " in rods.evidence
    tours = rods.tours
    curves = tours.closed + tours.left + tours.lost + tours.unfinished
    assert curves > 0
    assert f"{curves} curves followed" in rods.evidence
    assert f"Estimated share not found: {rods.unseen:.3f}." in rods.evidence
    assert rods.evidence.endswith(f"{rods.morse.text}.")


# clamping parameters and printed energies of Fig. 7, K30 = 0.7: IG 6, 25, 51 and 175
FIGURE_7 = [0, 0, 0.7, 2 * np.pi * 0.42, 0, 0]
PRINTED = (14.0443, 28.3003, 37.3183, 58.5301)


@pytest.mark.parametrize("energy_max", [None, 400.0])
def test_the_four_rods_of_figure_7_are_listed(energy_max):
    rods = le.equilibria(le.Clamping.from_parameters(FIGURE_7), 0.7, energy_max)
    for known in PRINTED:
        assert np.abs(np.array(energies(rods)) - known).min() < 1e-4


def test_the_closed_ring_has_circles_and_figure_eights_once_each():
    ring = le.Clamping(np.zeros(3), np.eye(3))
    once = 2.0 * np.pi**2
    rods = le.equilibria(ring, energy_max=240.0)
    found, eight = np.array(energies(rods)), 56.219805
    # n-fold circles with m turns of torsion, figure eights run through once and twice
    circles = [(n * n + m * m) * once for n in (1, 2, 3) for m in (0, 1, -1) if n * n + m * m < 12]
    for known in (*circles, eight, 4 * eight):
        assert np.abs(found / known - 1).min() < 1e-6
    near = np.flatnonzero(np.abs(found - eight) < 1e-3)
    assert len(near) == 1
    assert rods[near[0]].family_dimension == 2
    assert np.sum(np.abs(found - once) < 1e-3) == 1
    assert rods[0].family_dimension == 1


def test_eulers_columns_are_listed_with_their_indices():
    # over a short chord the n-th costs F_n times what the ends come nearer, and has index 2(n − 1):
    # F L² = (2 π k)² or 4 x² with tan x = x
    loads = [(2 * np.pi) ** 2, 4 * 4.493409**2, (4 * np.pi) ** 2, 4 * 7.725252**2, (6 * np.pi) ** 2]
    short = 1e-3
    rods = le.equilibria(le.Clamping([0, 0, 1 - short], np.eye(3), free_spin=True))
    assert rods.by_index[::2] == (1,) * len(rods.by_index[::2])
    assert sum(rods.by_index[1::2]) == 0
    np.testing.assert_allclose(energies(rods)[:5], short * np.array(loads), rtol=5e-3)
    assert rods.morse.holds == (True,) * len(rods.morse.holds)
    assert all(rod.family_dimension == 1 for rod in rods)


@pytest.mark.parametrize("free_spin", [False, True])
@pytest.mark.parametrize("short", [0.03, 1e-3, 1e-6])
def test_tense_rods_are_told_apart_and_have_their_indices(rng, short, free_spin):
    # ends opposed, and two poses at random
    poses = zip(*pose_drawn(rng, 2, 1 - short, 1 - short), strict=True)
    opposed = np.array([0, 0, 1 - short]), np.diag([1.0, -1, -1])
    for place, frame in (opposed, *poses):
        clamping = le.Clamping(place, frame, free_spin)
        rods = le.equilibria(clamping)
        assert rods[0].energy <= le.solve(clamping).energy * (1 + 1e-9)
        assert all(rod.index >= 0 for rod in rods)
        assert rods[0].index == 0
        assert rods.evidence
        if clamping.on_one_line:
            # one circle, or a pair of mirror images
            assert len(rods) == (1 if free_spin else 2)


@pytest.mark.parametrize("torsion_ratio", [0.1, 0.5, 3.0, 10.0])
def test_the_list_begins_with_what_solve_finds(rng, torsion_ratio):
    for free_spin in (False, True):
        place, frame = (x[0] for x in pose_drawn(rng, 1))
        clamping = le.Clamping(place, frame, free_spin)
        rods = le.equilibria(clamping, torsion_ratio)
        assert rods[0].energy <= le.solve(clamping, torsion_ratio).energy * (1 + 1e-9)
        for rod in rods:
            assert rod.residual < 1e-9
            np.testing.assert_allclose(rod.centerline(2)[-1], place, atol=1e-8)
            if free_spin:
                assert abs(rod.loads[5]) < 1e-9
        if free_spin:
            # no torsion: its stiffness is void
            assert missing(rods, le.equilibria(clamping)) == []


def test_mirror_image_and_reversal_have_the_same_energies(rng):
    for free_spin in (False, True):
        place, frame = (x[0] for x in pose_drawn(rng, 1, 0.1, 0.6))
        clamping = le.Clamping(place, frame, free_spin)
        rods = le.equilibria(clamping, rounds=4)
        for other in (clamping.mirrored(), clamping.reversed()):
            again = le.equilibria(other, rounds=4, energy_max=rods.energy_max)
            assert missing(rods, again) == missing(again, rods) == []
            assert again.by_index == rods.by_index


def test_mirror_images_of_one_clamping_are_two():
    # the plane of d1 and d3 keeps both clamps
    frame = Rotation.from_rotvec([0, 1.0, 0]).as_matrix()
    rods = le.equilibria(le.Clamping([0.2, 0, 0.4], frame))
    bent = [rod for rod in rods if abs(rod.loads[5]) > 1e-3]
    assert bent
    for rod in bent:
        assert any(
            abs(rod.energy - other.energy) < 1e-6 and abs(rod.loads[5] + other.loads[5]) < 1e-6
            for other in bent
        )


def test_no_rod_lies_below_a_small_bound_and_more_do_below_a_large_one():
    clamping = le.Clamping.from_parameters(FIGURE_6)
    none = le.equilibria(clamping, energy_max=1e-3, rounds=1)
    assert (list(none), none.unseen) == ([], 1.0)
    default = le.equilibria(clamping)
    assert missing(default, le.equilibria(clamping, energy_max=200.0)) == []


def test_arguments_out_of_range_are_refused():
    clamping = le.Clamping.from_parameters(FIGURE_6)
    for rounds in (0, 5, -1, 1.5, "2"):
        with pytest.raises(ValueError, match="`rounds`"):
            le.equilibria(clamping, rounds=rounds)
    for energy_max in (0.0, -1.0, np.nan, "much"):
        with pytest.raises(ValueError, match="`energy_max`"):
            le.equilibria(clamping, energy_max=energy_max)
    with pytest.raises(ValueError, match="`turns`"):
        le.equilibria(le.Clamping.from_parameters(FIGURE_6, free_spin=True), turns=1)


def test_rods_that_differ_by_more_than_their_error_are_two():
    rod = le.solve(le.Clamping.from_parameters(FIGURE_6))
    size = 1 + np.abs(rod.loads).max()
    for apart, count in ((0.0, 1), (1e-8, 1), (1e-7, 1), (1e-4, 2), (1e-3, 2), (0.1, 2)):
        other = le.Equilibrium(
            rod.clamping, 1.0, rod.loads + apart * size, rod.energy, 0.0, Status.CONVERGED
        )
        found = []
        _merge(
            found, le.Equilibrium(rod.clamping, 1.0, rod.loads, rod.energy, 0.0, Status.CONVERGED)
        )
        _merge(found, other)
        assert len(found) == count, apart


def test_a_time_limit_ends_the_search_and_is_said():
    clamping = le.Clamping.from_parameters(FIGURE_6)
    rods = le.equilibria(clamping, time_limit_s=1e-9)
    assert rods.out_of_time
    assert rods.starts == 1
    assert not le.equilibria(clamping, rounds=1, time_limit_s=600.0).out_of_time


def test_a_straight_rod_is_its_only_equilibrium():
    (rod,) = rods = le.equilibria(le.Clamping([0, 0, 1], np.eye(3)))
    assert rod.method == Method.STRAIGHT
    assert rods.unseen == 0
    assert rods.starts == 1
