import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod.kernels.arclength import Condition, Motion, corrected_step, moving_clamp
from loopelastica.rod.kernels.records import Nodes

# kernels that Python does not call otherwise are compiled one by one
pytestmark = pytest.mark.slow

FIGURE_6 = [-0.4, -0.1, 0.5, 4.8, 1.4, 2.2]


def motion_of(clamping, torsion_ratio):
    q = Rotation.from_matrix(clamping.rotation).as_quat(scalar_first=True)
    shift, axis = np.array([0.1, -0.2, 0.05]), np.array([0.3, 0.4, -0.2])
    return Motion(clamping.position.copy(), q, shift, axis, torsion_ratio, clamping.free_spin)


def test_the_clamp_moves_on_a_line_and_turns_about_an_axis_of_its_own():
    clamping = le.Clamping.from_parameters(FIGURE_6)
    motion, q, p = motion_of(clamping, 1.0), np.empty(4), np.empty(3)
    for t in (0.0, 0.4, -2.0):
        moving_clamp(motion, t, q, p)
        np.testing.assert_allclose(p, clamping.position + t * motion.shift, atol=1e-15)
        turned = clamping.rotation @ Rotation.from_rotvec(t * motion.axis).as_matrix()
        frame = Rotation.from_quat(q, scalar_first=True).as_matrix()
        np.testing.assert_allclose(frame, turned, atol=1e-14)


@pytest.mark.parametrize("free_spin", [False, True])
@pytest.mark.parametrize("torsion_ratio", [1.0, 0.7])
def test_the_tangent_of_a_branch_is_its_derivative(torsion_ratio, free_spin):
    clamping = le.Clamping.from_parameters(FIGURE_6, free_spin)
    rod, motion = le.solve(clamping, torsion_ratio), motion_of(clamping, torsion_ratio)
    s = np.linspace(0, 1, 17)
    pose, first = rod.poses_without_spin(s), np.append(rod.loads, 0.0)
    if free_spin:
        # the free end is turned from where the rod leaves it to the clamp's frame
        moved = Rotation.from_quat(motion.quaternion, scalar_first=True)
        left = Rotation.from_quat(pose[-1, 3:], scalar_first=True)
        first[5] = -(left.inv() * moved).as_rotvec()[2]
    ones, at_t = np.ones(7), np.append(np.zeros(6), 1.0)

    def at(t):
        values, direction = first.copy(), np.empty(7)
        residual, energy, _ = corrected_step(
            motion, Nodes(s, pose.copy()), values, Condition(ones, at_t, t, False), 20, direction
        )
        assert residual < 1e-9
        assert values[6] == pytest.approx(t, abs=1e-12)
        return values, direction, energy

    h = 1e-4
    (after, _, high), (_, direction, _), (before, _, low) = at(h), at(0.0), at(-h)
    slope = (after - before) / (2 * h)
    np.testing.assert_allclose(direction / direction[6], slope, rtol=1e-5, atol=1e-5)
    assert np.linalg.norm(direction) == pytest.approx(1)
    assert direction[6] > 0
    # the work of the clamp: dE/dt = F·v + M(L)·Rω
    work = rod.loads[:3] @ motion.shift + rod.moment(2)[-1] @ (clamping.rotation @ motion.axis)
    assert (high - low) / (2 * h) == pytest.approx(work, rel=1e-5)


def test_a_step_has_the_length_that_its_condition_says():
    clamping = le.Clamping.from_parameters(FIGURE_6)
    rod, motion = le.solve(clamping), motion_of(clamping, 1.0)
    s, direction = np.linspace(0, 1, 17), np.empty(7)
    scale = np.array([20.0] * 3 + [9.0] * 3 + [1.5])
    row = np.full(7, 7**-0.5)
    for ds in (0.0, 0.02, -0.02):
        values = np.append(rod.loads, 0.0)
        residual, _, _ = corrected_step(
            motion, Nodes(s, rod.poses_without_spin(s)), values,
            Condition(scale, row, ds, False), 12, direction,
        )  # fmt: skip
        assert residual < 1e-9
        moved = (values - np.append(rod.loads, 0.0)) / scale
        assert row @ moved == pytest.approx(ds, abs=1e-9)
        assert row @ direction > 0


def test_a_step_too_long_is_not_corrected():
    clamping = le.Clamping.from_parameters(FIGURE_6)
    rod, motion = le.solve(clamping), motion_of(clamping, 1.0)
    s, values = np.linspace(0, 1, 17), np.append(rod.loads, 0.0)
    residual, energy, _ = corrected_step(
        motion, Nodes(s, rod.poses_without_spin(s)), values,
        Condition(np.ones(7), np.append(np.zeros(6), 1.0), 50.0, False), 12, np.empty(7),
    )  # fmt: skip
    assert (residual, energy) == (np.inf, np.inf)
