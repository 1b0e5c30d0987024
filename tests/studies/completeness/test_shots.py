import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from loopelastica.studies.completeness import shots

MIDDLE = np.array([20.0, -9.0, 14.0, 3.0, -5.0, 4.0])
POSITION = np.array([0.3, -0.2, 0.5])
ROTATION = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()


def missed(middle, torsion_ratio=1.0, free=False, radians=0.02):
    res, jac = np.empty(12), np.empty((12, 6))
    work = np.empty((9, 43))
    shots.misfit(middle, torsion_ratio, POSITION, ROTATION, free, radians, res, jac, work)
    return res, jac


@pytest.mark.parametrize(("torsion_ratio", "free"), [(1.0, False), (0.3, False), (1.0, True)])
def test_the_jacobian_is_that_of_central_differences(torsion_ratio, free):
    _, jac = missed(MIDDLE, torsion_ratio, free)
    step = 1e-5 * np.eye(6)
    numeric = [
        (missed(MIDDLE + h, torsion_ratio, free)[0] - missed(MIDDLE - h, torsion_ratio, free)[0])
        / 2e-5
        for h in step
    ]
    unknowns = 5 if free else 6
    np.testing.assert_allclose(jac[:, :unknowns], np.transpose(numeric)[:, :unknowns], atol=2e-9)


def test_the_error_falls_with_the_sixth_power_of_the_step():
    exact = missed(MIDDLE, radians=0.01)[0]
    coarse, fine = (np.abs(missed(MIDDLE, radians=r)[0] - exact).max() for r in (0.4, 0.1))
    # the number of steps is rounded: 4⁶ is 4096
    assert 1000 < coarse / fine < 16000


def test_poses_are_those_of_scipy():
    force, moment = MIDDLE[:3], MIDDLE[3:]

    def slope(s, y):
        frame = y[3:].reshape(3, 3)
        return [*frame[:, 2], *np.cross(moment + np.cross(force, y[:3]), frame.T).T.ravel()]

    start = [0.0, 0.0, 0.0, *np.eye(3).ravel()]
    traced = shots.trace(MIDDLE, 0.05, 2)
    for row, s in ((0, -0.5), (1, -0.25), (3, 0.25), (4, 0.5)):
        end = solve_ivp(slope, (0.0, s), start, "LSODA", rtol=1e-11, atol=1e-12).y[:, -1]
        frame = Rotation.from_quat(traced[row, 3:], scalar_first=True).as_matrix()
        np.testing.assert_allclose(traced[row, :3], end[:3], atol=1e-8)
        np.testing.assert_allclose(frame.ravel(), end[3:], atol=1e-8)


def test_loads_beyond_any_rod_of_interest_miss_by_infinity():
    work, res, jac = np.empty((9, 43)), np.empty(12), np.empty((12, 6))
    far = np.full(6, 1e5)
    assert shots.misfit(far, 1.0, POSITION, ROTATION, False, 0.5, res, jac, work) == np.inf
    assert shots.descend(far.copy(), 1.0, POSITION, ROTATION, False, 0.5, 1e-6, 50) == np.inf
