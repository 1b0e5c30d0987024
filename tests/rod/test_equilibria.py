import numpy as np
import pytest
from draws import load_drawn

import loopelastica as le
from loopelastica.rod import equilibria as searching
from loopelastica.rod.equilibria import Equilibria, _Found, _merge
from loopelastica.rod.kernels.records import Method, Status

FIGURE_6 = [-0.4, -0.1, 0.5, 4.8, 1.4, 2.2]


def rod_of_energy(energy):
    """Something with an energy that passes for an equilibrium."""
    clamping = le.Clamping([0, 0, 0.5], np.eye(3))
    return le.Equilibrium(clamping, 1.0, np.full(6, energy), energy, 0.0, Status.CONVERGED)


def test_chain_reversal_gives_the_reversed_rod(rng):
    for position, rotation in zip(*load_drawn(rng, 10), strict=True):
        clamping = le.Clamping(position, rotation)
        forward = le.equilibria(clamping)
        backward = le.equilibria(clamping.reversed())
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
    for turns in (0, 2, -3):
        rods = le.equilibria(tense, turns=turns, rounds=1, energy_max=1e4)
        assert rods
        assert {rod.turns for rod in rods} == {turns}
        # under tension one of them carries the turns as twist, others as loops
        assert any(abs(rod.twist - turns) < 0.6 for rod in rods)
    assert not rods[0].family
    assert all(rod.family for rod in le.equilibria(le.Clamping([0, 0, 0.9], np.eye(3)), rounds=1))


def test_what_is_unseen_is_the_share_of_hits_that_were_single():
    # hits below the bound: 1, 5, 1, 3: two of ten were single; the one above does not count
    hits = {7.0: 1, 3.0: 5, 5.0: 1, 4.0: 3, 99.0: 1}
    rods = Equilibria([_Found(rod_of_energy(e), n) for e, n in hits.items()], 50.0, 17)
    assert [rod.energy for rod in rods] == [3.0, 4.0, 5.0, 7.0]
    assert rods.hits == (5, 3, 1, 1)
    assert rods.unseen == 0.2
    assert (rods.energy_max, rods.starts, rods.out_of_time) == (50.0, 17, False)
    assert Equilibria([_Found(rod_of_energy(3.0), 4)], 50.0, 4).unseen == 0
    # the bound itself is listed
    at_bound = Equilibria([_Found(rod_of_energy(3.0), 1)], 3.0, 4)
    assert (len(at_bound), at_bound.unseen) == (1, 1)
    assert Equilibria([], 50.0, 4).unseen == 1


def test_hits_are_counted_and_the_best_copy_is_kept():
    rod = le.solve(le.Clamping.from_parameters(FIGURE_6))
    other = le.equilibria(rod.clamping, rounds=1)[1]
    from dataclasses import replace

    worse, better = replace(rod, residual=1e-3), replace(rod, residual=1e-15)
    found = []
    for each in (worse, better, other, worse, replace(rod, status=Status.STALLED)):
        _merge(found, each)
    assert [f.hits for f in found] == [3, 1]
    assert found[0].rod is better
    assert found[1].rod is other


def test_the_list_counts_its_starts_and_its_hits():
    rods = le.equilibria(le.Clamping.from_parameters(FIGURE_6), rounds=1)
    assert len(rods.hits) == len(rods)
    assert min(rods.hits) >= 1
    assert sum(rods.hits) <= rods.starts
    assert rods.energy_max == pytest.approx(rods[0].energy + 8 * np.pi**2)
    assert rods.unseen == pytest.approx(rods.hits.count(1) / sum(rods.hits))
    assert not rods.out_of_time
    assert all(rod.index is not None for rod in rods)
    low = le.equilibria(rods[0].clamping, energy_max=20.0, rounds=1)
    assert [rod.energy for rod in low] == [rod.energy for rod in rods if rod.energy <= 20]
    # a solve, a round of 24 structured starts (5 more in half waves on a line), 16 stored rods
    assert rods.starts == 41
    assert le.equilibria(le.Clamping([0, 0, 0.9], np.eye(3)), rounds=1).starts == 46


def test_more_rounds_are_made_until_little_is_unseen(monkeypatch):
    clamping = le.Clamping.from_parameters(FIGURE_6)
    monkeypatch.setattr(searching, "UNSEEN", -1.0)
    one, two, four = (le.equilibria(clamping, rounds=n).starts for n in (1, 2, 4))
    assert one < two < four
    assert le.equilibria(clamping).starts == four
    # two rounds at least, however little seems to be unseen
    monkeypatch.setattr(searching, "UNSEEN", 2.0)
    assert le.equilibria(clamping).starts == two


def test_rods_that_differ_by_more_than_their_error_are_two():
    rod = le.solve(le.Clamping.from_parameters(FIGURE_6))
    size = 1 + np.abs(rod.loads).max()
    for apart, count in ((0.0, 1), (1e-8, 1), (1e-7, 1), (1e-4, 2), (1e-3, 2), (0.1, 2)):
        other = le.Equilibrium(
            rod.clamping, 1.0, rod.loads + apart * size, rod.energy, 0.0, Status.CONVERGED
        )
        found = []
        _merge(found, le.Equilibrium(rod.clamping, 1.0, rod.loads, 1.0, 0.0, Status.CONVERGED))
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
