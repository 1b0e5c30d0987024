import numpy as np
import pytest

import loopelastica as le
from loopelastica.rod._discrete import discrete_copy
from loopelastica.rod.kernels.descent import close, descend, displace, unstable_modes
from loopelastica.rod.kernels.discrete_rod import DiscreteRod, measure

FIGURE_6 = [-0.4, -0.1, 0.5, 4.8, 1.4, 2.2]


@pytest.fixture(scope="module", params=[False, True], ids=["fixed", "free"])
def saddle(request, problem):
    """A saddle, its discrete critical point, its modes and the least stabilizing shift."""
    clamping = le.Clamping.from_parameters(FIGURE_6, request.param)
    rod = next(rod for rod in le.equilibria(clamping) if rod.index == 1)
    posed = problem(clamping, 1.0)
    copy = discrete_copy(rod, 64)
    modes = np.empty((2, 65 if request.param else 64, 3))
    shift = unstable_modes(posed, 1.0, copy, rod.loads[:3].copy(), modes)
    return rod, posed, copy, modes, shift


def measured(posed, rod):
    """Energy, and how far the end is from its place."""
    off = np.empty(3)
    energy = measure(rod, posed.position, 1.0, np.empty((65, 3)), off)
    return energy, np.abs(off).sum()


def moved(copy, mode, amount):
    rod = DiscreteRod(copy.s, copy.frames.copy())
    displace(rod, mode, amount)
    return rod


def test_the_copy_of_a_saddle_is_critical_itself(saddle):
    rod, posed, copy, _, _ = saddle
    energy, off = measured(posed, copy)
    assert off < 1e-9
    assert energy == pytest.approx(rod.energy, rel=0.02)


def test_an_unstable_mode_keeps_the_end_and_lowers_the_energy(saddle):
    _, posed, copy, (mode, other), shift = saddle
    assert shift > 0
    assert np.linalg.norm(mode, axis=1).max() == pytest.approx(1.0)
    still, _ = measured(posed, copy)
    for sign in (1.0, -1.0):
        changes = []
        for turns in (mode, other):
            rod = moved(copy, turns, sign * 0.02)
            _, off = measured(posed, rod)
            # to first order
            assert off < 0.02**2
            close(posed, 1.0, rod, np.empty(3), 0.1)
            energy, off = measured(posed, rod)
            assert off < 1e-5
            changes.append(energy - still)
        assert changes[0] < 0 < changes[1]


def test_modes_are_orthogonal(saddle):
    _, _, copy, (one, other), _ = saddle
    n = len(copy.s) - 1
    lengths = np.append(np.diff(copy.s), 1.0 / n)[: len(one), None]
    product = np.sum(lengths * one * other)
    sizes = np.sum(lengths * one * one) * np.sum(lengths * other * other)
    assert abs(product) < 1e-6 * np.sqrt(sizes)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_descent_ends_in_balance_below_where_it_began(saddle, sign):
    rod, posed, copy, modes, shift = saddle
    start = moved(copy, modes[0], sign * 0.05)
    force, moment = np.empty(3), np.empty(3)
    close(posed, 1.0, start, force, 0.25)
    before, _ = measured(posed, start)
    arrived, energy = descend(posed, 1.0, start, force, moment, 2.0 * shift, 0.25)
    assert arrived
    after, off = measured(posed, start)
    assert off < 1e-4
    assert energy == pytest.approx(after)
    assert after < before < rod.energy * 1.02
    # it stays where it has come to
    again, energy = descend(posed, 1.0, start, force, moment, 1.0, 0.25)
    assert again
    assert energy == pytest.approx(after, rel=1e-9)
