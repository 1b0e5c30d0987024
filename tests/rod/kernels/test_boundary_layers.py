import numpy as np
import pytest
from draws import pose_drawn
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from loopelastica.rod.kernels.boundary_layers import (
    SIZE,
    check_tails,
    sample_tails,
    solve_tails,
    tail_energy,
    tail_loads,
    tails_apart,
)


def tails(rng, n, low, high, torsion_ratio, free_spin=False, turns=0):
    for position, rotation in zip(*pose_drawn(rng, n, low, high), strict=True):
        end = Rotation.from_matrix(rotation).as_quat(scalar_first=True)
        tail = np.zeros(SIZE)
        gap = 1 - np.linalg.norm(position)
        if solve_tails(
            position, end, gap, torsion_ratio, free_spin, turns, False, False, tail
        ) and tails_apart(tail):
            yield position, rotation, end, tail


@pytest.mark.parametrize("free_spin", [False, True])
@pytest.mark.parametrize("torsion_ratio", [0.5, 1.0, 3.0])
def test_nearly_straight_rods_are_two_tails(rng, torsion_ratio, free_spin):
    count = 0
    for position, rotation, end, tail in tails(rng, 40, 0.995, 0.9999, torsion_ratio, free_spin):
        count += 1
        assert check_tails(tail, end, torsion_ratio, free_spin) < 1e-10
        poses = sample_tails(tail, torsion_ratio, np.array([0.0, 1.0]))
        np.testing.assert_allclose(poses[0], [0, 0, 0, 1, 0, 0, 0], atol=1e-12)
        np.testing.assert_allclose(poses[1, :3], position, atol=1e-12)
        last = Rotation.from_quat(poses[1, 3:], scalar_first=True).as_matrix()
        if free_spin:
            last, rotation = last[:, 2], rotation[:, 2]
        np.testing.assert_allclose(last, rotation, atol=1e-10)
    assert count >= 38


def test_the_closed_form_follows_the_equations_of_the_rod(rng):
    # from the start, over as many decay lengths as the growth of errors allows
    for _, _, _, tail in tails(rng, 10, 0.99, 0.995, 1.0):
        f = np.empty(6)
        tail_loads(tail, f)
        far = 12.0 / np.sqrt(np.linalg.norm(f[:3]))

        def slope(_, y, f=f):
            t = y[3:]
            return np.concatenate([t, np.cross(f[3:] + np.cross(f[:3], y[:3]), t)])

        s = np.linspace(0, far, 9)
        exact = solve_ivp(slope, (0, far), [0, 0, 0, 0, 0, 1], "DOP853", s, rtol=1e-13, atol=1e-13)
        poses = sample_tails(tail, 1.0, s)
        np.testing.assert_allclose(poses[:, :3], exact.y[:3].T, atol=2e-8)


def test_energy_of_the_tails_is_the_integral(rng):
    for _, _, _, tail in tails(rng, 10, 0.99, 0.999, 0.7):
        f = np.empty(6)
        tail_loads(tail, f)
        decay = 1 / np.sqrt(np.linalg.norm(f[:3]))
        x, w = np.polynomial.legendre.leggauss(300)
        half = 0.5 * (x + 1)
        energy = 0.0
        for a, b in ((0, 12 * decay), (12 * decay, 1 - 12 * decay), (1 - 12 * decay, 1)):
            poses = sample_tails(tail, 0.7, a + (b - a) * half)
            t = Rotation.from_quat(poses[:, 3:], scalar_first=True).as_matrix()[:, :, 2]
            moment = f[3:] + np.cross(f[:3], poses[:, :3])
            bending = np.linalg.norm(np.cross(moment, t), axis=1) ** 2
            energy += (b - a) * (0.5 * w) @ (0.5 * bending)
        assert tail_energy(tail, 0.7) == pytest.approx(energy + 0.5 * f[5] ** 2 / 0.7, rel=1e-7)


def test_turns_wind_the_tense_rod(rng):
    twists = []
    for turns in (0, 3, -3):
        (found,) = list(tails(np.random.default_rng(4), 1, 0.999, 0.9999, 1.0, turns=turns))
        twists.append(2 * found[3][4] * np.sin(found[3][5]) / (2 * np.pi))
    np.testing.assert_allclose(np.diff(twists[:2]), 3, atol=0.1)
    np.testing.assert_allclose(twists[2] - twists[0], -3, atol=0.1)
