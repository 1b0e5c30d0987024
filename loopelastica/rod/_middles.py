"""Rods to begin with, by their loads in the middle: the nearest of many, and random ones.

|F| is log-uniform and so are the other rods of a search by random loads; M3 and the bending moment
are drawn as wide as the energies of interest allow. Their end poses are compared as those of the
guess library are (``_library``), which is denser, by loads at the start, and narrower: it is meant
for one rod soon, this one for all of them. Nothing is shipped: they are drawn, from a fixed seed,
when they are first needed.
"""

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod._library import pose_points, turned_loads
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.kernels.middle import ends_from_middle

if TYPE_CHECKING:
    from scipy.spatial import KDTree

_COUNT = 12_000
_SEED = 15
_FORCES = 3.0, 300.0
# energy (K0/L) up to which they are kept: the least of a pose is hardly ever above 80
_ENERGY = 160.0
# steps per radian: what is off by a hundredth still leads to the same rod
_DENSITY = 0.7


@dataclass(frozen=True, slots=True)
class Middles:
    """Drawn rods of one torsion ratio: loads (n, 6) in the middle, and the tree over their ends."""

    loads: Array
    angles: Array
    tree: "KDTree"
    free_spin: bool

    def nearest(self, clamping: Clamping, count: int) -> Array:
        """Loads (count, 6) of the rods whose ends are nearest to a clamping, nearest first."""
        points, angles = pose_points(
            clamping.position[None], clamping.rotation[None], self.free_spin
        )
        _, index = self.tree.query(points[0], np.arange(1, count + 1))
        # a turn of the clamping about d3(0) turns the middle about its own tangent
        return turned_loads(self.loads[index], angles[0] - self.angles[index])


def draw(rng: np.random.Generator, count: int, torsion_ratio: float, free_spin: bool) -> Array:
    """Random loads (count, 6) in the middle of rods.

    Parameters
    ----------
    rng : numpy.random.Generator
    count : int
    torsion_ratio : float
        K30: what M3 a twist energy of interest allows.
    free_spin : bool
        M3 is 0.

    Returns
    -------
    (count, 6) ndarray
    """
    low, high = np.log(_FORCES)
    size = np.exp(rng.uniform(low, high, count))
    force = rng.normal(size=(count, 3))
    force *= (size / np.linalg.norm(force, axis=1))[:, None]
    # 2√|F| is the moment at the top of a loop under tension
    largest = 2.2 * np.sqrt(size) + 4.0
    bending = rng.uniform(0.0, 1.0, count) * largest
    azimuth = rng.uniform(0.0, math.tau, count)
    widest = np.minimum(math.sqrt(2.0 * _ENERGY * torsion_ratio), largest)
    twist = np.zeros(count) if free_spin else rng.uniform(-1.0, 1.0, count) * widest
    moment = np.stack([bending * np.cos(azimuth), bending * np.sin(azimuth), twist], axis=1)
    return np.hstack([force, moment])


@functools.lru_cache(maxsize=4)
def middles(torsion_ratio: float, free_spin: bool) -> Middles:
    """The drawn rods for one torsion ratio; with a free spin M3 = 0 and the ratio is void."""
    from scipy.spatial import KDTree
    from scipy.spatial.transform import Rotation

    rng = np.random.default_rng(_SEED)
    kept: list[tuple[Array, Array, Array]] = []
    while sum(len(loads) for loads, _, _ in kept) < _COUNT:
        loads = draw(rng, _COUNT, torsion_ratio, free_spin)
        positions, quaternions = np.empty((_COUNT, 3)), np.empty((_COUNT, 4))
        energies = np.empty(_COUNT)
        ends_from_middle(loads, torsion_ratio, _DENSITY, positions, quaternions, energies)
        low = energies < _ENERGY
        kept.append((loads[low], positions[low], quaternions[low]))
    loads, positions, quaternions = (
        np.concatenate(part)[:_COUNT] for part in zip(*kept, strict=True)
    )
    rotations = Rotation.from_quat(quaternions, scalar_first=True).as_matrix()
    points, angles = pose_points(positions, rotations, free_spin)
    return Middles(loads, angles, KDTree(points, leafsize=20), free_spin)
