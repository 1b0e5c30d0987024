"""When two equilibria of one clamping are the same, or of one family."""

import math

import numpy as np
from scipy.spatial.transform import Rotation

from loopelastica._arrays import Array
from loopelastica.rod.equilibrium import Equilibrium

# relative difference of loads that are the same; of marks that are
_LOADS, SAME = 1e-9, 1e-5
_POINTS = 9


def same(one: Equilibrium, other: Equilibrium) -> bool:
    """Whether two equilibria of one clamping are one, or of one family of solutions."""
    if not (one.converged and other.converged):
        return False
    if abs(one.energy - other.energy) > 1e-6 * (1.0 + one.energy):
        return False
    size = 1.0 + float(np.abs(one.loads).max())
    if float(np.abs(one.loads - other.loads).max()) < _LOADS * size:
        return True
    return bool(np.abs(mark(one) - mark(other)).max() < SAME)


def mark(rod: Equilibrium) -> Array:
    """Numbers that are equal, within `SAME`, for two copies of one equilibrium or family only."""
    force, moment = rod.loads[:3], rod.loads[3:]
    if rod.clamping.closed:
        # the integrals of the rod's equations, which turns and shifts leave alone
        size, whole = math.hypot(*force), 0.5 * float(moment @ moment) + force[2]
        wrench = float(force @ moment)
        return np.array([rod.twist, size, whole, wrench / (1.0 + size)]) / (1.0 + size)
    poses = rod.poses(_POINTS)
    frames = Rotation.from_quat(poses[:, 3:], scalar_first=True).as_matrix()
    if not rod.clamping.on_one_line:
        return np.concatenate([poses[:, :3].ravel(), frames.ravel()])
    # what a turn about the common line leaves alone; the moments tell mirror images apart
    wrench = float(force @ moment) / (1.0 + float(force @ force))
    across = np.hypot(poses[:, 0], poses[:, 1])
    return np.concatenate([across, poses[:, 2], frames[:, 2, 2], [rod.twist, wrench]])
