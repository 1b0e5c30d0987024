import numpy as np
import pytest
from draws import loads
from scipy.spatial.transform import Rotation

from loopelastica.rod.kernels.segments import integrate_segment, new_space, segment_rows
from loopelastica.rod.kernels.shooting import POSE, WITH_JACOBIAN

# kernels that Python does not call otherwise are compiled one by one
pytestmark = pytest.mark.slow


def test_rows_of_a_segment_are_its_derivatives(rng):
    space = new_space()
    for g in loads(rng, 5):
        node = np.concatenate([rng.normal(size=3), Rotation.random(random_state=rng).as_quat()])

        def end(dx, dg, g=g, node=node):
            turned = Rotation.from_rotvec(dx[:3]) * Rotation.from_quat(node[3:], scalar_first=True)
            moved = np.concatenate([node[:3] + dx[3:], turned.as_quat(scalar_first=True)])
            integrate_segment(g + dg, False, moved, 0.1, 40.0, POSE, space)
            y = space.y
            return moved[:3] + y[:3], Rotation.from_quat(y[3:POSE], scalar_first=True)

        integrate_segment(g, False, node, 0.1, 40.0, WITH_JACOBIAN, space)
        segment_rows(node, space)
        t, b = space.end_by_node.copy(), space.end_by_loads.copy()
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
