import numpy as np
import pytest

import loopelastica as le
from loopelastica.rod.kernels.discrete_rod import DiscreteRod
from loopelastica.rod.kernels.records import Status
from loopelastica.rod.kernels.second_variation import inertia, sign_changes

# kernels that Python does not call otherwise are compiled one by one
pytestmark = pytest.mark.slow


def bent(loads, n):
    """Arc lengths and poses along the rod that loads bend."""
    anywhere = le.Clamping([0, 0, 0.5], np.eye(3))
    rod = le.Equilibrium(anywhere, 1.0, loads, 0.0, 0.0, Status.CONVERGED)
    s = np.linspace(0, 1, n)
    return s, rod.poses_without_spin(s)


@pytest.mark.parametrize(
    ("push", "free_spin"), [(30.0, False), (60.0, False), (30.0, True), (60.0, True)]
)
def test_sign_changes_miss_conjugate_points_in_pairs(push, free_spin):
    # a straight clamped rod buckles in two planes at once, at the push 4π²
    loads = np.array([0, 0, -push, 0, 0, 0])
    s, poses = bent(loads, 301)
    assert sign_changes(loads, 1.0, free_spin, s[:-1], poses[:-1]) == 0


@pytest.mark.parametrize("free_spin", [False, True])
@pytest.mark.parametrize(
    ("push", "index"),
    [(30.0, 0), (38.5, 0), (40.5, 2), (79.0, 2), (83.0, 4), (155.0, 4), (161.0, 6)],
)
def test_the_inertia_counts_eulers_loads_in_both_planes(push, index, free_spin):
    # 4π² = 39.48, 4·4.4934² = 80.76, 16π² = 157.9
    n = 256
    frames = np.zeros((n + 2, 4))
    frames[:, 0] = 1
    rod = DiscreteRod(np.linspace(0, 1, n + 1), frames)
    loads, end = np.array([0, 0, -push, 0, 0, 0]), np.array([0, 0, 1.0])
    assert inertia(loads, end, 1.0, free_spin, rod, 0.0) == (index, index)


@pytest.mark.parametrize("torsion_ratio", [0.6, 1.0])
@pytest.mark.parametrize(("turns", "index"), [(0.9, 0), (1.1, 2)])
def test_a_straight_rod_buckles_under_greenhills_twist(torsion_ratio, turns, index):
    # clamped ends, no force: M3 = 8.9868 K0/L, the double of the first root of tan x = x
    # (A. G. Greenhill, Proc. Inst. Mech. Eng. 34 (1883) 182)
    n, m3 = 256, turns * 8.98682
    s = np.linspace(0, 1, n + 1)
    at = np.concatenate([[0.0], (s[1:] + s[:-1]) / 2, [1.0]])
    half = 0.5 * m3 / torsion_ratio * at
    frames = np.stack([np.cos(half), 0 * at, 0 * at, np.sin(half)], axis=1)
    loads, end = np.array([0, 0, 0, 0, 0, m3]), np.array([0, 0, 1.0])
    assert inertia(loads, end, torsion_ratio, False, DiscreteRod(s, frames), 0.0)[0] == index


def test_a_ring_has_no_conjugate_point_and_twice_around_it_has():
    counts = []
    for around in (1.0, 2.0):
        loads = np.array([0, 0, 0, 0, 2 * np.pi * around, 0])
        s, poses = bent(loads, 601)
        counts.append(sign_changes(loads, 1.0, False, s[:-1], poses[:-1]))
    assert counts[0] == 0
    assert counts[1] > 0
