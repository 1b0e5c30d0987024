"""The finite rod in its start frame; `test_closed_form` has the rod under force."""

import mpmath
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from loopelastica.rod.kernels import finite_rod


def test_a_vector_is_seen_from_a_frame(rng):
    for turn in Rotation.random(20, rng):
        v = rng.normal(size=3)
        found = finite_rod.turned_back(*turn.as_quat(scalar_first=True), *v)
        assert found == pytest.approx(turn.inv().apply(v), abs=1e-14)


@pytest.mark.parametrize("torsion_ratio", [1.0, 0.7])
def test_loads_balance_the_closed_form_all_along(rng, torsion_ratio):
    """The moment from the loads, M0 + F × r, has the constants λ and t_P at every point."""
    for _ in range(20):
        p = (*rng.uniform(-2, 2, 2), 6.0, *rng.uniform(0, 3, 2), rng.uniform(0.5, 6))
        f = np.array(finite_rod.loads_from_physical(*p, torsion_ratio))
        line, frames = finite_rod.rod_along(*p, torsion_ratio, np.linspace(0, 1, 5))
        moment = f[3:] + np.cross(f[:3], line)
        root = np.sqrt(np.linalg.norm(f[:3]))
        assert root == pytest.approx(p[5])
        assert moment @ f[:3] / root**3 == pytest.approx(p[0], abs=1e-11)
        assert (moment * frames[:, :, 2]).sum(1) / root == pytest.approx(p[1], abs=1e-11)


def test_forceless_rod_turns_by_the_exponential_of_its_moment():
    rng = np.random.default_rng(21)
    for size in (0.0, 1e-12, 1e-5, 1.0, 30.0):
        moment = size * rng.normal(size=3)
        line, frames = finite_rod.forceless_along(moment, 0.7, np.array([0.3, 1.0]))
        # integrate with Gauss points of the exact exponential from mpmath
        with mpmath.workdps(30):
            cross = mpmath.matrix(
                [[0, -moment[2], moment[1]], [moment[2], 0, -moment[0]], [-moment[1], moment[0], 0]]
            )
            turn = mpmath.expm(cross)
            big = mpmath.zeros(4, 4)  # d/ds (∫R e3, …) by a block exponential
            big[:3, :3] = cross
            big[:3, 3] = mpmath.matrix([0, 0, 1])
            integral = mpmath.expm(big)[:3, 3]
        spin = Rotation.from_rotvec([0, 0, moment[2] * (1 / 0.7 - 1)])
        rotation = np.array(turn.tolist(), dtype=float) @ spin.as_matrix()
        assert np.abs(frames[1] - rotation).max() < 1e-13 * (1 + size)
        assert np.abs(line[1] - np.array(integral.tolist(), dtype=float)[:, 0]).max() < 1e-13
