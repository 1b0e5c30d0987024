import numpy as np
import pytest
from draws import load_drawn, loads
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod.kernels.newton import (
    elastic_energy,
    end_error,
    marquardt_step,
    newton,
    pivoted_step,
    shot_error,
)
from loopelastica.rod.kernels.records import Status
from loopelastica.rod.kernels.shooting import POSE, WITH_JACOBIAN, sample, shoot

# kernels that Python does not call otherwise are compiled one by one
pytestmark = pytest.mark.slow


def scratch():
    return np.empty(WITH_JACOBIAN), np.empty(12 * WITH_JACOBIAN), np.empty(WITH_JACOBIAN)


@pytest.mark.parametrize("free_spin", [False, True])
@pytest.mark.parametrize("torsion_ratio", [1.0, 0.7])
def test_jacobian_agrees_with_central_differences_to_1e_7(rng, problem, torsion_ratio, free_spin):
    y, k, z = scratch()
    e, jacobian, unused = np.empty(6), np.empty((6, 6)), np.zeros((6, 6))
    for f in loads(rng, 20):
        rotation = Rotation.random(random_state=rng).as_matrix()
        target = problem(le.Clamping(rng.normal(size=3), rotation, free_spin), torsion_ratio)

        def error(g, target=target):
            shoot(g, torsion_ratio, 80, POSE, y, k, z)
            out = np.empty(6)
            end_error(target, y, g[5], out, unused, False)
            return out

        shoot(f, torsion_ratio, 80, WITH_JACOBIAN, y, k, z)
        end_error(target, y, f[5], e, jacobian, True)
        h = 2e-4
        differences = np.empty((6, 6))
        for j in range(6):
            d = np.zeros(6)
            d[j] = h
            # fourth order: truncation and rounding both stay below 1e-9
            differences[:, j] = (
                8 * (error(f + d) - error(f - d)) - (error(f + 2 * d) - error(f - 2 * d))
            ) / (12 * h)
        assert np.abs(jacobian - differences).max() < 1e-7 * np.abs(jacobian).max()


def test_energy_from_the_hamiltonian_is_the_integral(rng):
    from numpy.polynomial.legendre import leggauss

    x, w = leggauss(60)
    s = np.append((x + 1) / 2, 1.0)
    start = np.array([[0, 0, 0, 1.0, 0, 0, 0]])
    for f in loads(rng, 20):
        poses = sample(f, 0.7, np.zeros(1), start, s, 4.0)
        t = Rotation.from_quat(poses[:, 3:], scalar_first=True).as_matrix()[:, :, 2]
        moment = f[3:] + np.cross(f[:3], poses[:, :3])
        twist = f[5] / 0.7
        density = 0.5 * (np.linalg.norm(np.cross(moment, t), axis=1) ** 2 + 0.7 * twist**2)
        assert elastic_energy(f, poses[-1, :3], 0.7) == pytest.approx(
            (w / 2) @ density[:-1], rel=1e-9
        )


def test_a_marquardt_step_is_that_of_the_normal_equations(rng):
    d = np.empty(6)
    for nu in (1e-3, 1.0):
        jacobian, e, scale = rng.normal(size=(6, 6)), rng.normal(size=6), rng.uniform(1, 9, 6)
        assert marquardt_step(jacobian, e, scale, nu, np.empty((6, 6)), d)
        damped = jacobian.T @ jacobian + nu * np.diag(scale**-2.0)
        np.testing.assert_allclose(d, np.linalg.solve(damped, -jacobian.T @ e), rtol=1e-8)
    assert not marquardt_step(np.zeros((6, 6)), e, scale, 0.0, np.empty((6, 6)), d)


def test_a_pivoted_step_is_newtons_and_keeps_still_along_null_directions(rng):
    jacobian, scale, d = rng.normal(size=(6, 6)), rng.uniform(1, 9, 6), np.empty(6)
    e = rng.normal(size=6)
    pivoted_step(jacobian, e, scale, 1e-11, d)
    np.testing.assert_allclose(d, np.linalg.solve(jacobian, -e), rtol=1e-8)
    jacobian[:, 5] = jacobian[:, 0]
    e = jacobian @ rng.normal(size=6)
    pivoted_step(jacobian, e, scale, 1e-11, d)
    np.testing.assert_allclose(jacobian @ d, -e, atol=1e-10)
    assert np.count_nonzero(d) == 5


@pytest.mark.parametrize("free_spin", [False, True])
def test_newton_comes_back_to_loads_that_were_changed_a_little(rng, problem, free_spin):
    for position, rotation in zip(*load_drawn(rng, 6, 0.7, free_spin, 0.8), strict=True):
        clamping = le.Clamping(position, rotation, free_spin)
        here, rod = problem(clamping, 0.7), le.solve(clamping, 0.7)
        f = rod.loads + 0.02 * rng.normal(size=6)
        status, residual, iterations, end = newton(here, f, 20)
        assert status == Status.CONVERGED
        assert residual < 1e-9
        assert 0 < iterations < 20
        np.testing.assert_allclose(end[:3], position, atol=1e-9)
        np.testing.assert_allclose(f, rod.loads, rtol=1e-6, atol=1e-5)
        assert shot_error(here, f) < 1e-9
        assert shot_error(here, f + 0.01) > 1e-5
        assert f[5] == 0 or not free_spin


def test_newton_gives_loads_up_that_do_not_determine_the_rod(problem):
    here = problem(le.Clamping([0, 0, 0.5], np.eye(3)), 1.0)
    stiff = np.array([0, 0, 1e4, 0, 0, 0])
    status, residual, iterations, _ = newton(here, stiff, 20)
    assert (status, residual, iterations) == (Status.TOO_STIFF, np.inf, 0)
    assert shot_error(here, stiff) == np.inf
    status, residual, _, _ = newton(here, np.full(6, np.nan), 20)
    assert (status, residual) == (Status.TOO_STIFF, np.inf)
