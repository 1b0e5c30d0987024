"""Initial guesses without the user: rods kept with the poses that they reach.

A rod turned about its start tangent is the same rod (eq. 15–16 of doi:10.1016/j.jcp.2018.07.021),
so poses are compared in the turned frame where η2 = 0 and η1 ≥ 0. There a pose is the point

    (η1, η3, w R)     in R¹¹ for a clamped end,      (η1, η3, w d3)     in R⁵ for a free end spin,

R the end frame, d3 its tangent; w balances lengths against angles. Euler angles would tear
neighbours apart at their seams. A KD-tree returns the nearest rods, whose loads are turned back by
the target's own angle. Other torsion ratios only spin the end frames (K30 never changes the
center line of given loads), so each ratio has its own tree, built when it is first needed.

The file ships in single precision, being guesses; ``data/make_rods.py`` computes it anew and says
which rods it holds.
"""

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica._files import data_path

if TYPE_CHECKING:
    from scipy.spatial import KDTree

_WEIGHT = 0.5
# how much further than the nearest a found one may be: the search takes 0.4 of the time, and the
# distances grow by a thousandth
_LAX = 0.6
_FILE = "rods.npz"


@dataclass(frozen=True, slots=True)
class StoredRods:
    """Stored rods of one torsion ratio: reduced loads (n, 6) and the tree over their poses."""

    loads: Array
    tree: "KDTree"
    free_spin: bool

    def nearest(
        self, positions: Array, rotations: Array, count: int, within: float = np.inf
    ) -> tuple[Array, NDArray[np.intp]]:
        """The rods nearest to each of m poses.

        Parameters
        ----------
        positions, rotations : (m, 3), (m, 3, 3) ndarray
            End poses in the start frame, in units of the length.
        count : int
            How many for each pose.
        within : float
            Largest distance in the reduced pose space (see the module's head).

        Returns
        -------
        loads : (m, count, 6) ndarray
            Nearest first; hardly ever is one of them not among the nearest, see `_LAX`.
        found : (m,) ndarray of int
            How many of each row are not further than `within`; the loads after these mean nothing.
        """
        points, angles = pose_points(positions, rotations, self.free_spin)
        ranks = np.arange(1, count + 1)
        distance, index = self.tree.query(points, ranks, _LAX, distance_upper_bound=within)
        found = np.isfinite(distance).sum(axis=1)
        index = np.where(np.isfinite(distance), index, 0)
        return turned_loads(self.loads[index], angles[:, None]), found


def turned_loads(loads: Array, angles: Array) -> Array:
    """Force and moment turned about d3 by ``angles``, shapes (..., 6) and (...)."""
    c, s = np.cos(angles), np.sin(angles)
    turned = loads.copy()
    for i in (0, 3):
        turned[..., i] = c * loads[..., i] - s * loads[..., i + 1]
        turned[..., i + 1] = s * loads[..., i] + c * loads[..., i + 1]
    return turned


def pose_points(positions: Array, rotations: Array, free_spin: bool) -> tuple[Array, Array]:
    """Points of the reduced pose space and the angles φ_a of eq. 19."""
    angles = np.arctan2(positions[:, 1], positions[:, 0])
    eta = np.stack([np.hypot(positions[:, 0], positions[:, 1]), positions[:, 2]], axis=1)
    c, s = np.cos(angles), np.sin(angles)
    z = np.zeros((len(angles), 3, 3))
    z[:, 0, 0] = z[:, 1, 1] = c
    z[:, 0, 1], z[:, 1, 0] = s, -s
    z[:, 2, 2] = 1.0
    if free_spin:
        return np.hstack([eta, _WEIGHT * (z @ rotations[:, :, 2:])[:, :, 0]]), angles
    turned = z @ rotations @ z.transpose(0, 2, 1)
    return np.hstack([eta, _WEIGHT * turned.reshape(-1, 9)]), angles


@functools.lru_cache(maxsize=2)
def _stored(free_spin: bool) -> Array:
    with np.load(data_path(_FILE)) as archive:
        return np.asarray(archive["free" if free_spin else "clamped"], dtype=np.float64)


@functools.lru_cache(maxsize=4)
def stored_rods(torsion_ratio: float, free_spin: bool) -> StoredRods:
    """The stored rods for one torsion ratio; with a free spin M3 = 0 and the ratio is void."""
    from scipy.spatial import KDTree
    from scipy.spatial.transform import Rotation

    stored = _stored(free_spin)
    loads, positions = stored[:, :6], stored[:, 6:9]
    rotation = Rotation.from_quat(stored[:, 9:], scalar_first=True)
    if not free_spin and torsion_ratio != 1.0:
        rotation = rotation * Rotation.from_rotvec(
            np.array([0.0, 0.0, 1.0]) * (loads[:, 5:] * (1.0 / torsion_ratio - 1.0))
        )
    points, angles = pose_points(positions, rotation.as_matrix(), free_spin)
    return StoredRods(turned_loads(loads, -angles), KDTree(points, leafsize=20), free_spin)
