import numpy as np
import pytest
from draws import load_drawn

import loopelastica as le


def test_rotating_the_start_frame_rotates_the_loads(rng):
    c, s = np.cos(1.234), np.sin(1.234)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    for position, rotation in zip(*load_drawn(rng, 10), strict=True):
        clamping = le.Clamping(position, rotation)
        loads, turned = (
            le.solve(q, lowest=False).loads.reshape(2, 3)
            for q in (clamping, clamping.turned(1.234))
        )
        np.testing.assert_allclose(turned, loads @ turn.T, atol=1e-6)


def test_reversed_and_mirrored_loads_solve_the_reversed_and_mirrored_clamping(rng):
    from loopelastica.rod.kernels.shooting import ends

    flip, mirror = np.diag([1.0, -1, -1]), np.diag([1.0, -1, 1])
    for position, rotation in zip(*load_drawn(rng, 10, 0.7), strict=True):
        clamping = le.Clamping(position, rotation)
        rod = le.solve(clamping, 0.7, lowest=False)
        force, moment = rod.loads[:3], rod.moment(2)[-1]
        back = -flip @ rotation.T
        mirrored = np.concatenate([mirror @ rod.loads[:3], -mirror @ rod.loads[3:]])
        for loads, target in (
            (np.concatenate([back @ force, back @ moment]), clamping.reversed()),
            (mirrored, clamping.mirrored()),
        ):
            p, _ = ends(loads[None], 0.7, 4.0)
            np.testing.assert_allclose(p[0], target.position, atol=1e-8)


def test_what_cannot_be_is_refused_with_the_reason():
    with pytest.raises(ValueError, match="further"):
        le.solve(le.Clamping([0, 0, 1.1], np.eye(3)))
    with pytest.raises(ValueError, match="full length"):
        le.solve(le.Clamping([0, 1, 0], np.eye(3)))
    with pytest.raises(ValueError, match="torsion_ratio"):
        le.solve(le.Clamping([0, 0, 0.5], np.eye(3)), torsion_ratio=0)
    with pytest.raises(ValueError, match="rotations"):
        le.solve_batch(np.zeros((2, 3)), np.zeros((3, 3, 3)))


def test_the_straight_rod_carries_twist_and_no_force():
    quarter = le.Clamping.from_parameters([0, 0, 1, np.pi / 2, 0, 0])
    rod = le.solve(quarter, torsion_ratio=0.7)
    assert rod.converged
    assert rod.twist == pytest.approx(0.25)
    assert rod.energy == pytest.approx(0.5 * 0.7 * (np.pi / 2) ** 2)
    np.testing.assert_allclose(rod.loads[:3], 0)
    np.testing.assert_allclose(rod.frames(3)[-1], quarter.rotation, atol=1e-12)
