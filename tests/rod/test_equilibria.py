import numpy as np
import pytest
from draws import load_drawn

import loopelastica as le


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
