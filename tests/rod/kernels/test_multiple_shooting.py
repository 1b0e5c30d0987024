import numpy as np
import pytest
from draws import load_drawn, loads
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod.kernels.multiple_shooting import _integrate, _rows, gaps, polish
from loopelastica.rod.kernels.shooting import POSE, WITH_JACOBIAN


def scratch():
    return np.empty(6), np.empty(WITH_JACOBIAN), np.empty(12 * WITH_JACOBIAN), np.empty(43)


def test_rows_of_a_segment_are_its_derivatives(rng):
    f, y, k, z = scratch()
    t, b = np.empty((6, 6)), np.empty((6, 6))
    for g in loads(rng, 5):
        node = np.concatenate([rng.normal(size=3), Rotation.random(random_state=rng).as_quat()])

        def end(dx, dg, g=g, node=node):
            turned = Rotation.from_rotvec(dx[:3]) * Rotation.from_quat(node[3:], scalar_first=True)
            moved = np.concatenate([node[:3] + dx[3:], turned.as_quat(scalar_first=True)])
            _integrate(g + dg, False, moved, 0.1, 40.0, POSE, f, y, k, z)
            return moved[:3] + y[:3], Rotation.from_quat(y[3:POSE], scalar_first=True)

        _integrate(g, False, node, 0.1, 40.0, WITH_JACOBIAN, f, y, k, z)
        _rows(y, f, node, t, b)
        t, b = t.copy(), b.copy()
        h = 1e-5
        for matrix, first in ((t, True), (b, False)):
            for j in range(6):
                step = np.zeros(6)
                step[j] = h
                pair = [
                    end(sign * step, np.zeros(6)) if first else end(np.zeros(6), sign * step)
                    for sign in (1, -1)
                ]
                shift = (pair[0][0] - pair[1][0]) / (2 * h)
                turn = (pair[0][1] * pair[1][1].inv()).as_rotvec() / (2 * h)
                np.testing.assert_allclose(matrix[:3, j], turn, atol=1e-7)
                np.testing.assert_allclose(matrix[3:, j], shift, atol=1e-7)


@pytest.mark.parametrize("free_spin", [False, True])
def test_a_disturbed_solution_is_polished_back(rng, free_spin):
    f, y, k, z = scratch()
    for position, rotation in zip(*load_drawn(rng, 8, 0.7, free_spin), strict=True):
        rod = le.solve(le.Clamping(position, rotation, free_spin), 0.7)
        s = np.linspace(0, 1, 17)
        nodes = rod.poses_without_spin(s)
        nodes[1:-1, :3] += 1e-3 * rng.normal(size=(15, 3))
        g = rod.loads + 0.01 * rng.normal(size=6)
        end = Rotation.from_matrix(rotation).as_quat(scalar_first=True)
        if free_spin:
            g[5] = 0.0
            end = nodes[-1, 3:].copy()
        residual, energy, iterations = polish(end, 0.7, free_spin, s, nodes, g, 1e-12, 14)
        assert residual < 1e-10
        assert iterations <= 6
        assert energy == pytest.approx(rod.energy, rel=1e-9)
        np.testing.assert_allclose(g[:5], rod.loads[:5], rtol=1e-5, atol=1e-5)
        assert gaps(g, 0.7, free_spin, s, nodes, 9.0, f, y, k, z)[0] < 1e-10
