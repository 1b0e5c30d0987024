"""Initial guesses without the user: rods kept with the poses that they reach.

A rod turned about its start tangent is the same rod (eq. 15–16 of doi:10.1016/j.jcp.2018.07.021),
so poses are compared in the turned frame where η2 = 0 and η1 ≥ 0. There a pose is the point

    (η1, η3, w R)     in R¹¹ for a clamped end,      (η1, η3, w d3)     in R⁵ for a free end spin,

R the end frame, d3 its tangent; w balances lengths against angles. Euler angles would tear
neighbours apart at their seams. A KD-tree returns the nearest rods, whose loads are turned back by
the target's own angle. Other torsion ratios only spin the end frames (K30 never changes the
center line of given loads), so each ratio has its own tree, built when it is first asked for.

The rods are random: half from moderate loads (|F| < 60, |M| < 12), half from loads up to
|F| = 1500 that reach the poses of nearly straight rods. They ship as single precision, being
guesses. ``python -m loopelastica.rod.library`` writes the file anew.
"""

import functools
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from loopelastica._data import data_path
from loopelastica.rod._shooting import ends
from loopelastica.rod.clamping import Array

if TYPE_CHECKING:
    from scipy.spatial import KDTree

_WEIGHT = 0.5
_FILE = "rods.npz"
_SEED, _SIZE = 20180717, 40_000


@dataclass(frozen=True, slots=True)
class Library:
    """Stored rods of one torsion ratio: reduced loads (n, 6) and the tree over their poses."""

    loads: Array
    tree: "KDTree"
    free_spin: bool

    def nearest(self, positions: Array, rotations: Array, count: int) -> Array:
        """Loads (m, count, 6) of the ``count`` stored rods nearest to each of m poses."""
        points, angles = _points(positions, rotations, self.free_spin)
        _, index = self.tree.query(points, k=np.arange(1, count + 1))
        return _turn_loads(self.loads[index], angles[:, None])


def _turn_loads(loads: Array, angles: Array) -> Array:
    """Force and moment turned about d3 by ``angles``, shapes (..., 6) and (...)."""
    c, s = np.cos(angles), np.sin(angles)
    turned = loads.copy()
    for i in (0, 3):
        turned[..., i] = c * loads[..., i] - s * loads[..., i + 1]
        turned[..., i + 1] = s * loads[..., i] + c * loads[..., i + 1]
    return turned


def _points(positions: Array, rotations: Array, free_spin: bool) -> tuple[Array, Array]:
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


def draw_loads(size: int, seed: int) -> Array:
    """Random loads (size, 6): the rods of the library before reduction."""
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(2, size, 3))
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    half = size // 2
    force = np.where(
        np.arange(size) < half,
        rng.uniform(0.0, 60.0, size),
        np.exp(rng.uniform(np.log(3.0), np.log(1500.0), size)),
    )
    # M is worth about √F: the depth of a tail is 1/√F
    moment = np.where(
        np.arange(size) < half,
        rng.uniform(0.0, 12.0, size),
        rng.uniform(0.0, 2.2, size) * np.sqrt(np.maximum(force, 4.0)),
    )
    return np.hstack([force[:, None] * directions[0], moment[:, None] * directions[1]])


def write(path: Path, size: int = _SIZE, seed: int = _SEED) -> None:
    """Compute the rods and write them: reduced loads and end poses at K30 = 1, with and without M3.

    The arrays ``clamped`` and ``free`` (n, 13) hold loads, position and quaternion.
    """
    arrays = {}
    for name in ("clamped", "free"):
        loads = draw_loads(size, seed)
        if name == "free":
            loads[:, 5] = 0.0
        positions, quaternions = ends(loads, 1.0, 2.0)
        keep = np.linalg.norm(positions, axis=1) < 0.9999
        loads, positions, quaternions = loads[keep], positions[keep], quaternions[keep]
        arrays[name] = np.hstack([loads, positions, quaternions]).astype(np.float32)
    np.savez_compressed(path, clamped=arrays["clamped"], free=arrays["free"])


@functools.lru_cache(maxsize=2)
def _stored(free_spin: bool) -> Array:
    with np.load(data_path(_FILE)) as archive:
        return np.asarray(archive["free" if free_spin else "clamped"], dtype=np.float64)


@functools.lru_cache(maxsize=4)
def library(torsion_ratio: float, free_spin: bool) -> Library:
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
    points, angles = _points(positions, rotation.as_matrix(), free_spin)
    return Library(_turn_loads(loads, -angles), KDTree(points), free_spin)


if __name__ == "__main__":
    write(data_path(_FILE))
