import numpy as np
import pytest
from draws import directions
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod._search import _in_the_middle
from loopelastica.rod.kernels.middle import (
    MAX_RATE,
    Catch,
    drive,
    ends_from_middle,
    enter,
    find,
    harvest,
    new_shot,
    shoot_middle,
)
from loopelastica.rod.kernels.newton import end_error
from loopelastica.rod.kernels.shooting import POSE, WITH_JACOBIAN

FIGURE_6 = [-0.4, -0.1, 0.5, 4.8, 1.4, 2.2]


def catch_of(symmetry=0, room=50):
    return Catch(
        np.empty((room, 6)), np.empty((room, 6)), np.empty(room), np.zeros(room, np.int64),
        np.zeros(1, np.int64), symmetry,
    )  # fmt: skip


def middle_loads(rng, n, force=100.0):
    return np.hstack([force * directions(rng, n), rng.normal(0, 6, (n, 3))])


@pytest.mark.parametrize("torsion_ratio", [0.3, 1.0, 4.0])
@pytest.mark.parametrize("free_spin", [False, True])
def test_ends_and_energies_from_the_middle_are_those_of_the_rod(torsion_ratio, free_spin):
    rods = le.equilibria(le.Clamping.from_parameters(FIGURE_6, free_spin), torsion_ratio, rounds=1)
    for rod in rods:
        loads = _in_the_middle(rod)
        p, q, energy = np.empty((1, 3)), np.empty((1, 4)), np.empty(1)
        ends_from_middle(loads[None].copy(), torsion_ratio, 6.0, p, q, energy)
        np.testing.assert_allclose(p[0], rod.clamping.position, atol=1e-8)
        frame = Rotation.from_quat(q[0], scalar_first=True).as_matrix()
        compared = [2] if free_spin else [0, 1, 2]
        np.testing.assert_allclose(
            frame[:, compared], rod.clamping.rotation[:, compared], atol=1e-7
        )
        # the integral of the curvature's energy, by Gauss and Legendre
        x, w = np.polynomial.legendre.leggauss(80)
        local = np.einsum("sji,sj->si", rod.frames((x + 1) / 2), rod.moment((x + 1) / 2))
        integral = 0.25 * w @ (local**2 / [1, 1, torsion_ratio]).sum(axis=1)
        assert energy[0] == pytest.approx(integral, rel=1e-7)


@pytest.mark.parametrize("free_spin", [False, True])
def test_guesses_nearby_arrive_at_the_rod(rng, problem, free_spin):
    clamping = le.Clamping.from_parameters(FIGURE_6, free_spin)
    rod, catch = le.solve(clamping, 0.7), catch_of()
    loads = _in_the_middle(rod)
    guesses = loads + 1e-3 * rng.normal(size=(20, 6))
    assert harvest(problem(clamping, 0.7, 1e-9), guesses, 25, catch) == 20
    assert catch.count[0] == 1
    assert catch.hits[0] == 20
    np.testing.assert_allclose(catch.loads[0], loads, atol=1e-2)
    assert catch.energies[0] == pytest.approx(rod.energy, rel=1e-3)


def test_loads_beyond_what_is_followed_are_given_up(problem):
    clamping, catch = le.Clamping.from_parameters(FIGURE_6), catch_of()
    absurd = np.array([[1e300] * 6, [np.nan] * 6, [np.inf] * 6, [0, 0, MAX_RATE**2, 0, 0, 0.0]])
    assert harvest(problem(clamping, 1.0, 1e-9), absurd, 25, catch) == 0
    assert catch.count[0] == 0


def test_a_full_catch_takes_no_more_but_counts_hits(rng):
    catch = catch_of(room=2)
    loads = middle_loads(rng, 3)
    assert [enter(g, 1.0, catch) for g in loads] == [0, 1, -1]
    assert enter(loads[1], 1.0, catch) == 1
    assert catch.hits.tolist() == [1, 2]


def test_turns_about_the_line_of_the_ends_are_one_rod_and_mirror_images_two(rng):
    catch = catch_of(1)
    turn = Rotation.from_rotvec([0, 0, 1.1])
    for i, g in enumerate(middle_loads(rng, 6)):
        assert enter(g, 1.0, catch) == 2 * i
        turned = np.concatenate([turn.apply(g[:3]), turn.apply(g[3:])])
        assert enter(turned, 1.0, catch) == 2 * i
        # in the plane of d1 and d3: the force as a vector, the moment as an axial one
        assert enter(g * [1, -1, 1, -1, 1, -1], 1.0, catch) == 2 * i + 1
    plain = catch_of(0)
    assert enter(g, 1.0, plain) == 0
    assert enter(turned, 1.0, plain) == 1


def test_equal_waves_are_not_one_wave():
    # k waves of one rod: F grows with k², M with k
    for symmetry in (0, 1, 2):
        catch = catch_of(symmetry)
        for k in (1, 2, 3):
            g = np.array([0, 0, -160.0 * k * k, 0, 6.0 * k, 0])
            assert enter(g, 1.0, catch) == k - 1


def test_a_closed_rod_shifted_along_itself_is_one():
    ring = le.Clamping(np.zeros(3), np.eye(3))
    rods = le.equilibria(ring, energy_max=60.0)
    eight = next(rod for rod in rods if rod.family_dimension == 2)
    catch = catch_of(2)
    for s in (0.1, 0.37, 0.5, 0.8):
        frame = eight.frames([s])[0]
        g = np.concatenate([frame.T @ eight.loads[:3], frame.T @ eight.moment([s])[0]])
        assert enter(g, eight.energy, catch) == 0
    # turned about M3 the other way it is another
    spun = g + [0, 0, 0, 0, 0, 1.0]
    assert enter(spun, eight.energy, catch) == 1
    assert enter(spun * [1, -1, 1, -1, 1, -1], eight.energy, catch) == 2


@pytest.mark.slow
@pytest.mark.parametrize("free_spin", [False, True])
@pytest.mark.parametrize("torsion_ratio", [1.0, 0.4])
def test_derivatives_are_central_differences(rng, problem, torsion_ratio, free_spin):
    shot, unused = new_shot(), np.empty((6, 6))
    frame = Rotation.random(random_state=rng).as_matrix()
    target = problem(le.Clamping([0.1, 0.2, 0.3], frame, free_spin), torsion_ratio)

    def error(g, jacobian=None):
        size = POSE if jacobian is None else WITH_JACOBIAN
        shoot_middle(g, torsion_ratio, 6.0, size, shot)
        e = np.empty(6)
        out = unused if jacobian is None else jacobian
        end_error(target, shot.y, g[5], e, out, jacobian is not None)
        return e

    for g in middle_loads(rng, 10, 30.0):
        jacobian, h = np.empty((6, 6)), 2e-4
        error(g, jacobian)
        differences = np.stack(
            [
                (8 * (error(g + d) - error(g - d)) - (error(g + 2 * d) - error(g - 2 * d))) / 12 / h
                for d in h * np.eye(6)
            ],
            axis=1,
        )
        assert np.abs(jacobian - differences).max() < 1e-6 * np.abs(jacobian).max()


@pytest.mark.slow
def test_steps_end_near_a_rod_that_is_known_and_never_in_nan(problem):
    clamping = le.Clamping.from_parameters(FIGURE_6)
    loads, catch, shot = _in_the_middle(le.solve(clamping)), catch_of(), new_shot()
    target = problem(clamping, 1.0, 1e-9)
    g = loads + 0.05
    error, energy, known = drive(target, g, 25, catch, shot)
    assert error < 1e-6
    assert known == -1
    place = enter(g, energy, catch)
    assert drive(target, loads + 0.05, 25, catch, shot)[2] == place == find(g, catch, 1e-4)
    error, energy, known = drive(target, np.full(6, 1e6), 25, catch, shot)
    assert (error, energy, known) == (np.inf, np.inf, -1)
