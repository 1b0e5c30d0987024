"""The printed integrator against another one."""

import numpy as np
import pytest
from draws import loads as random_loads
from paper_rods import matrix
from scipy.integrate import solve_ivp

from loopelastica.rod.paper import bulirsch_stoer

# the printed method is compiled for its tests alone
pytestmark = pytest.mark.slow


def test_bulirsch_stoer_agrees_with_dop853(rng):
    def slope(_, y, f):
        frame = y[3:].reshape(3, 3)
        moment = f[3:] + np.cross(f[:3], y[:3])
        return np.concatenate([frame[:, 2], np.cross(moment, frame.T).T.ravel()])

    start = np.concatenate([np.zeros(3), np.eye(3).ravel()])
    for f in random_loads(rng, 12):
        oracle = solve_ivp(slope, (0, 1), start, "DOP853", args=(f,), rtol=1e-12, atol=1e-13)
        y = np.empty(7)
        assert bulirsch_stoer.end_pose(f, 1.0, 1e-12, y) > 0
        assert y[:3] == pytest.approx(oracle.y[:3, -1], abs=1e-9)
        assert matrix(y).ravel() == pytest.approx(oracle.y[3:, -1], abs=1e-9)


def test_bulirsch_stoer_keeps_to_its_tolerance_with_fewer_slopes(rng):
    exact, y = np.empty(7), np.empty(7)
    for f in random_loads(rng, 20):
        bulirsch_stoer.end_pose(f, 1.0, 1e-13, exact)
        counts, errors = [], []
        for tolerance in (1e-5, 1e-8, 1e-11):
            counts.append(bulirsch_stoer.end_pose(f, 1.0, tolerance, y))
            errors.append(np.abs(y - exact).max())
        assert counts == sorted(counts)
        assert errors[1] < 1e-5
        assert errors[2] < 1e-8


def test_bulirsch_stoer_gives_up_on_absurd_loads():
    assert bulirsch_stoer.end_pose(np.full(6, 1e12), 1.0, 1e-10, np.empty(7)) == -1
    assert bulirsch_stoer.end_pose(np.full(6, np.nan), 1.0, 1e-10, np.empty(7)) == -1
