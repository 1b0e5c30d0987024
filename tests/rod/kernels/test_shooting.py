import numpy as np
import pytest
from draws import loads
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from loopelastica.rod.kernels.shooting import (
    POSE,
    WITH_JACOBIAN,
    ends,
    moment_bound,
    sample,
    shoot,
)


def matrix_ode(f, torsion_ratio, s):
    """The 12 equations r' = d3, R' = [Ω] R of the paper (eq. 1–4), by scipy."""

    def slope(_, y):
        r, frame = y[:3], y[3:].reshape(3, 3)
        moment = f[3:] + np.cross(f[:3], r)
        t = frame[:, 2]
        m3 = moment @ t
        omega = moment - m3 * t + m3 / torsion_ratio * t
        return np.concatenate([t, np.cross(omega, frame.T).T.ravel()])

    y0 = np.concatenate([np.zeros(3), np.eye(3).ravel()])
    return solve_ivp(slope, (0, 1), y0, "DOP853", t_eval=s, rtol=1e-12, atol=1e-13).y.T


@pytest.mark.parametrize("torsion_ratio", [1.0, 0.7, 2.5])
def test_center_line_and_frames_solve_the_equations_of_the_rod(rng, torsion_ratio):
    s = np.linspace(0, 1, 7)
    start = np.array([[0, 0, 0, 1.0, 0, 0, 0]])
    for f in loads(rng, 10):
        reference = matrix_ode(f, torsion_ratio, s)
        poses = sample(f, torsion_ratio, np.zeros(1), start, s, 4.0)
        np.testing.assert_allclose(poses[:, :3], reference[:, :3], atol=1e-10)
        frames = Rotation.from_quat(poses[:, 3:], scalar_first=True).as_matrix()
        np.testing.assert_allclose(frames.reshape(-1, 9), reference[:, 3:], atol=1e-9)


def test_invariants_of_the_paper_stay_constant(rng):
    # λ, t_P and a (eq. 9–11), and the norm of the quaternion
    start = np.array([[0, 0, 0, 1.0, 0, 0, 0]])
    for f in loads(rng, 20):
        poses = sample(f, 1.0, np.zeros(1), start, np.linspace(0, 1, 20), 4.0)
        assert np.abs(np.linalg.norm(poses[:, 3:], axis=1) - 1).max() < 1e-14
        t = Rotation.from_quat(poses[:, 3:], scalar_first=True).as_matrix()[:, :, 2]
        moment = f[3:] + np.cross(f[:3], poses[:, :3])
        for invariant in (
            moment @ f[:3],
            (moment * t).sum(1),
            0.5 * (moment**2).sum(1) + t @ f[:3],
        ):
            assert np.ptp(invariant) < 1e-10 * (1 + np.abs(invariant).max())
        assert np.linalg.norm(moment, axis=1).max() <= moment_bound(f) * (1 + 1e-12)


def test_a_finer_mesh_shrinks_the_error_at_order_eight(rng):
    f = loads(rng, 200)
    exact = ends(f, 1.0, 8.0)[0]
    coarse, fine = (np.median(np.abs(ends(f, 1.0, d)[0] - exact).max(1)) for d in (0.75, 1.5))
    assert coarse / fine > 2**6


def test_no_load_is_the_straight_rod_and_a_moment_is_a_circle():
    p, _ = ends(np.array([[0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 2 * np.pi, 0]]), 1.0, 4.0)
    np.testing.assert_allclose(p, [[0, 0, 1], [0, 0, 0]], atol=1e-11)


@pytest.mark.slow
def test_the_pose_alone_is_that_of_the_rod_with_its_variations(rng):
    y, alone, z = (np.empty(WITH_JACOBIAN) for _ in range(3))
    k = np.empty(12 * WITH_JACOBIAN)
    for f in loads(rng, 20):
        shoot(f, 0.7, 6, WITH_JACOBIAN, y, k, z)
        alone[POSE:] = np.nan
        shoot(f, 0.7, 6, POSE, alone, k, z)
        np.testing.assert_allclose(alone[:POSE], y[:POSE], rtol=0.0, atol=1e-13)
