import math

import numpy as np
import pytest
from dense import eigenvalues
from draws import closed_ring, drawn_rods
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod.stability import STIFF, assess, conjugate_points, morse_index


@pytest.mark.parametrize("free_spin", [False, True])
@pytest.mark.parametrize(
    "torsion_ratio",
    [0.7, *(pytest.param(ratio, marks=pytest.mark.slow) for ratio in (0.1, 1.0, 10.0))],
)
def test_the_index_is_that_of_a_second_variation_in_sines(rng, torsion_ratio, free_spin):
    seen = set()
    for rod in drawn_rods(rng, 12, torsion_ratio, free_spin):
        values = eigenvalues(rod, 64)
        # a mode that 64 sines cannot tell from none is left out
        if np.abs(values).min() < 0.02:
            continue
        index = int(np.sum(values < 0))
        assert morse_index(rod) == index
        # close ones are missed in pairs
        assert (index - conjugate_points(rod)) in (0, 2, 4)
        seen.add(index)
    assert len(seen) > 2


@pytest.mark.slow
@pytest.mark.parametrize("free_spin", [False, True])
@pytest.mark.parametrize("torsion_ratio", [0.1, 0.3, 1.0, 3.0, 10.0])
def test_the_index_of_hundreds_of_rods(torsion_ratio, free_spin):
    rng = np.random.default_rng(int(1000 * torsion_ratio) + free_spin)
    for rod in drawn_rods(rng, 30, torsion_ratio, free_spin):
        values = eigenvalues(rod, 32)
        if np.sum(values < 0) != morse_index(rod) or np.abs(values).min() < 0.1:
            values = eigenvalues(rod, 96)
        assert morse_index(rod) == np.sum(values < 0)
        assert (morse_index(rod) - conjugate_points(rod)) % 2 == 0


def test_a_tense_rod_has_the_index_of_two_meshes():
    for free_spin in (False, True):
        clamping = le.Clamping.from_parameters([0.2, 0.1, 0.974, 0.3, 0.8, 0.4], free_spin)
        rod = assess(le.solve(clamping))
        assert math.sqrt(np.linalg.norm(rod.loads[:3])) > STIFF
        assert rod.index == 0


def test_planar_arch_s_and_loop_over_a_chord():
    rods = le.equilibria(le.Clamping([0, 0, 0.9], np.eye(3)))
    # the arch is the only minimum without twist; higher planar modes have more ways down
    arch = next(rod for rod in rods if abs(rod.energy - 4.0504) < 1e-3)
    wave = next(rod for rod in rods if abs(rod.energy - 16.2016) < 1e-3)
    assert arch.stable
    assert wave.index >= 2


@pytest.mark.parametrize("torsion_ratio", [0.5, 1.0, 1.5])
def test_a_twisted_ring_buckles_at_zajacs_twists(torsion_ratio):
    # K30 Tw = √(n² − 1): E. E. Zajac, J. Appl. Mech. 29 (1962) 136 for n = 2, higher modes beyond
    for mode, index in ((2, 0), (3, 2), (4, 4)):
        at = math.sqrt(mode**2 - 1) / torsion_ratio
        assert morse_index(closed_ring(1, torsion_ratio, 0.99 * at)) == index
        assert morse_index(closed_ring(1, torsion_ratio, 1.01 * at)) == index + 2


@pytest.mark.parametrize("free_spin", [False, True])
def test_a_circle_run_through_n_times_has_the_index_of_the_sines(free_spin):
    for times, index in ((1, 0), (2, 2), (3, 4)):
        ring = closed_ring(times, free_spin=free_spin)
        assert np.sum(eigenvalues(ring, 64) < -0.1) == morse_index(ring) == index


def test_euler_columns_buckled_between_clamps():
    # just above the load of mode n of a clamped column the rod has 2 (n − 1) ways down: two planes
    # for each lower mode; its own has a circle of places and costs nothing
    for push, index in ((4 * math.pi**2, 0), (4 * 4.493409**2, 2), (16 * math.pi**2, 4)):
        clamping = le.Clamping([0, 0, 0.999], np.eye(3), free_spin=True)
        rods = le.equilibria(clamping, energy_max=1.05 * push * 0.001)
        loads = np.array([-rod.loads[2] for rod in rods])
        nearest = rods[int(np.abs(loads - push).argmin())]
        assert -nearest.loads[2] == pytest.approx(push, rel=5e-3)
        assert nearest.family_dimension == 1
        assert morse_index(nearest) == index


def test_the_index_is_computed_when_asked_and_kept():
    rod = le.solve(le.Clamping([0, 0, 0.5], np.eye(3)))
    assert rod.index is None
    assert rod.stable is None
    judged = assess(rod)
    assert judged.stable is True
    assert le.Equilibrium.from_dict(judged.to_dict()).index == 0
    assert assess(judged) is judged
    straight = le.solve(le.Clamping.from_parameters([0, 0, 1, 2.0, 0, 0]))
    assert assess(straight).stable


@pytest.mark.parametrize("free_spin", [False, True])
def test_the_index_of_tense_rods_does_not_change_with_the_tension(free_spin):
    # their layers only shrink
    frame = Rotation.from_rotvec([1.2, 0.8, -0.3]).as_matrix()
    direction = np.array([0.3, -0.2, 0.9]) / np.linalg.norm([0.3, -0.2, 0.9])
    seen = []
    for short in (1e-3, 1e-4, 1e-5, 1e-6, 1e-8):
        clamping = le.Clamping((1 - short) * direction, frame, free_spin)
        rods = le.equilibria(clamping, rounds=1, energy_max=1e18)
        assert rods[0].index == 0
        seen.append([rods.by_index[0] > 0, len(rods.by_index)])
    assert seen == [seen[0]] * len(seen)
