"""Where searches for equilibria of an elastic chain begin."""

import itertools
import math

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibria import equilibria

# bends to either side, rad, and half waves of a bow
_BENDS, _WAVES = (0.0, 0.8, -0.8, 1.6, -1.6), (1, 2)
# segments from which on rods of the ideal kind are laid on the chain; ends further apart make none
_FINE, _SLACK = 16, 0.999
# turns below have no direction of their own
_NO_TURN = 1e-6


def starts(points: Array, end_frame: Array, clamping: Clamping, torsion_ratio: float) -> Array:
    """Turns of the segments to begin with, quaternions (k, m, 4), of a shape (m + 1, 3) at rest."""
    from scipy.spatial.transform import Rotation

    steps = np.diff(points, axis=0)
    sizes = np.linalg.norm(steps, axis=1)
    s = (np.cumsum(sizes) - 0.5 * sizes) / sizes.sum()
    along = steps / sizes[:, None]
    turn = Rotation.from_matrix(clamping.rotation @ end_frame.T).as_rotvec()
    size = float(np.linalg.norm(turn))
    ways = [turn, turn * (1.0 - math.tau / size)] if size > _NO_TURN else [turn]
    found = []
    for way, spin in itertools.product(ways, (0, 1, -1)):
        spread = Rotation.from_rotvec(np.outer(s, way))
        spun = spread * Rotation.from_rotvec(math.tau * spin * s[:, None] * along)
        for axis, bend, waves in itertools.product(np.eye(3), _BENDS, _WAVES):
            bow = np.outer(bend * np.sin(math.pi * waves * s), axis)
            if bend or (axis[0] and waves == 1):
                found.append((Rotation.from_rotvec(bow) * spun).as_quat(scalar_first=True))
    if len(steps) >= _FINE and np.linalg.norm(clamping.position) < _SLACK:
        rest = _carried(along)
        for rod in equilibria(clamping, torsion_ratio, rounds=1):
            turns = Rotation.from_matrix(rod.frames(s) @ rest.transpose(0, 2, 1))
            found.append(turns.as_quat(scalar_first=True))
    return np.ascontiguousarray(found)


def _carried(along: Array) -> Array:
    """Frames (m, 3, 3) with d3 ``along`` (m, 3), carried from the start frame without twist."""
    from scipy.spatial.transform import Rotation

    frames, frame = np.empty((len(along), 3, 3)), np.eye(3)
    for k, direction in enumerate(along):
        axis = np.cross(frame[:, 2], direction)
        sine = float(np.linalg.norm(axis))
        angle = math.atan2(sine, float(frame[:, 2] @ direction))
        # straight back: about d1
        axis = axis / sine if sine > _NO_TURN else frame[:, 0]
        frame = Rotation.from_rotvec(angle * axis).as_matrix() @ frame
        frames[k] = frame
    return frames
