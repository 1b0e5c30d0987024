import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import loopelastica as le


@pytest.fixture(scope="session")
def arch():
    """A clamping that every method should solve."""
    rod = le.solve(le.Clamping([0.0, 0.0, 0.9], np.eye(3)))
    turn = Rotation.from_rotvec([0.2, 0.5, 0.3]).as_matrix()
    return le.Clamping(rod.centerline(2)[1] + [0.1, 0.2, -0.3], turn)
