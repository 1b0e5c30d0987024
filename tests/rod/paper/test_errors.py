"""The mapping q2, the errors of a pose, and their symmetries."""

import math

import numpy as np
import pytest
from draws import loads as random_loads
from paper_rods import end, matrix, pose, turned_loads
from scipy.spatial.transform import Rotation

from loopelastica.rod.clamping import Clamping
from loopelastica.rod.paper import ERRORS
from loopelastica.rod.paper import errors as kernels
from loopelastica.rod.parameters import PhysicalParameters

# the printed method is compiled for its tests alone
pytestmark = pytest.mark.slow


@pytest.mark.parametrize("torsion_ratio", [1.0, 0.7])
def test_all_ways_of_q2_agree(rng, torsion_ratio):
    for f in random_loads(rng, 60, force=40, moment=10):
        expected = end(f, torsion_ratio, "project")
        for forward in ("printed", "analytic", "numerical"):
            found = end(f, torsion_ratio, forward)
            assert found[:3] == pytest.approx(expected[:3], abs=1e-9)
            assert matrix(found) == pytest.approx(matrix(expected), abs=1e-9)


def test_q2_is_integrated_near_the_singular_rods(monkeypatch):
    p = PhysicalParameters(0.6, 0.6 + 5e-3, 1.5, 0.3, 0.4, 2.0).loads()
    q = PhysicalParameters(0.6, 0.6 + 5e-2, 1.5, 0.3, 0.4, 2.0).loads()
    assert np.array_equal(end(p), end(p, forward="numerical"))
    assert not np.array_equal(end(p), end(p, forward="analytic"))
    assert np.array_equal(end(q), end(q, forward="analytic"))
    # and where there is no force at all
    none = np.array([0, 0, 0, 1.0, 2.0, 0.5])
    assert matrix(end(none)) == pytest.approx(Rotation.from_rotvec(none[3:]).as_matrix(), abs=1e-10)


def signed_angle(first, second, axis):
    """From `first` to the projection of `second` across `axis`, about `axis`."""
    across = second - axis * (axis @ second)
    return math.atan2(axis @ np.cross(first, across), first @ across)


def test_errors_are_those_of_equations_30_to_32(rng):
    for a, b in zip(Rotation.random(40, rng), Rotation.random(40, rng), strict=True):
        bar = Clamping(rng.uniform(-0.5, 0.5, 3), a.as_matrix())
        target = Clamping(rng.uniform(-0.5, 0.5, 3), b.as_matrix())
        e = {name: np.empty(6) for name in ERRORS}
        for name, kind in ERRORS.items():
            kernels.error(kind, pose(bar), pose(target), e[name])
            assert e[name][:3] == pytest.approx(target.position - bar.position)
        assert e["eps1"] == pytest.approx(target.parameters - bar.parameters, abs=1e-12)
        d, d_bar = target.rotation.T, bar.rotation.T
        expected = [signed_angle(d_bar[j], d[j], d_bar[i]) for i, j in ((0, 1), (1, 2), (2, 0))]
        assert e["eps2"][3:] == pytest.approx(expected, abs=1e-12)
        vector = Rotation.from_matrix(target.rotation @ bar.rotation.T).as_rotvec()
        angle = np.linalg.norm(vector)
        v = math.sin(angle / 2) * vector / angle
        assert e["eps3"][3:] == pytest.approx(d_bar @ v, abs=1e-12)


def test_reduced_parameters_ignore_a_turn_of_the_start(rng):
    for turn in Rotation.random(20, rng):
        clamping = Clamping(rng.uniform(-0.5, 0.5, 3), turn.as_matrix())
        first, second = np.empty(5), np.empty(5)
        kernels.reduced_parameters(pose(clamping), first)
        kernels.reduced_parameters(pose(clamping.turned(rng.uniform(-3, 3))), second)
        assert second == pytest.approx(first, abs=1e-12)
        expected = clamping.reduced()[0].parameters[[0, 2, 3, 4, 5]]
        assert first == pytest.approx(expected, abs=1e-12)


def test_rotation_mirror_and_reversal(rng):
    """Eq. 15–16 and 34–35 and the rod run backwards, on loads and poses of random rods."""
    for f in random_loads(rng, 25, force=30, moment=8):
        there = end(f, 0.7)
        q = Clamping(there[:3], matrix(there))
        angle = rng.uniform(-3, 3)
        y = end(turned_loads(f, angle), 0.7)
        assert y[:3] == pytest.approx(q.turned(angle).position, abs=1e-9)
        assert matrix(y) == pytest.approx(q.turned(angle).rotation, abs=1e-9)
        y = end(f * [1, -1, 1, -1, 1, -1], 0.7)
        assert y[:3] == pytest.approx(q.mirrored().position, abs=1e-9)
        assert matrix(y) == pytest.approx(q.mirrored().rotation, abs=1e-9)
        p, flipped = PhysicalParameters.from_loads(f, 0.7), np.empty(7)
        kernels.physical_pose(-p.lam, -p.t_p, p.a, p.s_ini, p.length, 0.7, flipped)
        first, second = np.empty(5), np.empty(5)
        kernels.reduced_parameters(there, first)
        kernels.reduced_parameters(flipped, second)
        assert second[[0, 1, 3]] == pytest.approx(first[[0, 1, 3]], abs=1e-8)
        for k in (2, 4):
            assert math.remainder(first[k] + second[k], math.tau) == pytest.approx(0, abs=1e-7)
        moment = f[3:] + np.cross(f[:3], there[:3])
        turn = np.diag([1.0, -1.0, -1.0]) @ q.rotation.T
        # force and moment act from the other side
        back = np.concatenate([-turn @ f[:3], -turn @ moment])
        y = end(back, 0.7)
        assert y[:3] == pytest.approx(q.reversed().position, abs=1e-8)
        assert matrix(y) == pytest.approx(q.reversed().rotation, abs=1e-8)
