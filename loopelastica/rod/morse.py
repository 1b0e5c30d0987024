"""What topology says of a list of equilibria: components of the space of rods."""

import math

import numpy as np

from loopelastica.rod._starts import quaternion
from loopelastica.rod.equilibrium import Equilibrium

# frames per radian of the fastest turning, to follow a quaternion's sign
_PER_RADIAN = 1.0


def homotopy_class(rod: Equilibrium) -> int:
    """In which of the two components of the space of rods between two frames a rod lies.

    Frames followed along the rod lift to unit quaternions, from 1 to one of the two ± q that are
    the end frame. No motion with both ends clamped takes a rod from one to the other: the end
    would have to be turned by a full turn. Two turns undo each other, so that there are no more.

    Parameters
    ----------
    rod : Equilibrium
        One that converged.

    Returns
    -------
    int
        0 or 1; which is which depends on the clamping, so that only rods of one clamping compare.
        With a free end spin there is one component, 0.
    """
    if rod.clamping.free_spin:
        return 0
    n = 9 + int(_PER_RADIAN * float(np.linalg.norm(rod.moment(65), axis=1).max()) * 2.0)
    frames = rod.poses_without_spin(n)[:, 3:]
    signs = np.sign(np.sum(frames[1:] * frames[:-1], axis=1))
    w, x, y, z = frames[-1] * np.prod(signs) * np.sign(frames[0, 0])
    # the spin of K30 ≠ 1, whole turns and all
    half = 0.5 * rod.loads[5] * (1.0 / rod.torsion_ratio - 1.0)
    c, s = math.cos(half), math.sin(half)
    lifted = np.array([w * c - z * s, x * c + y * s, y * c - x * s, z * c + w * s])
    return int(lifted @ quaternion(rod.clamping) < 0.0)
