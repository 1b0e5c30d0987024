"""What several tests of the printed method share: rods of Fig. 6, ends, poses."""

import numpy as np
from scipy.spatial.transform import Rotation

from loopelastica.rod.clamping import Clamping
from loopelastica.rod.paper import FORWARD
from loopelastica.rod.paper import errors as kernels

FIG_6 = Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
# λ, t_P, a, L/μ
FIG_6_FIRST = (-0.3112, -0.2178, -0.7406, 4.7988)
FIG_6_SECOND = (1.0462, 1.5606, 3.2264, 3.1601)


def matrix(y):
    return Rotation.from_quat(y[3:], scalar_first=True).as_matrix()


def end(f, torsion_ratio=1.0, forward="printed"):
    y = np.empty(7)
    if forward == "project":
        assert kernels.project_end(f, torsion_ratio, y)
    else:
        assert kernels.end(f, torsion_ratio, FORWARD[forward], y)
    return y


def pose(clamping):
    y = np.empty(7)
    kernels.pose_of_frame(np.array(clamping.position), np.array(clamping.rotation), y)
    return y


def turned_loads(f, angle):
    z = Rotation.from_rotvec([0, 0, angle]).as_matrix()
    return np.concatenate([z @ f[:3], z @ f[3:]])


def rod(p):
    return [p.lam, p.t_p, p.a, p.length]
