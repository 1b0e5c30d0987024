"""When two equilibria of one clamping are the same, or of one family."""

import functools
import math
from dataclasses import dataclass

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.equilibrium import Equilibrium

# relative differences of energies, of forces and of moments that are the same; of marks that are
_ENERGIES, _LOADS, SAME = 1e-6, 1e-9, 1e-5
_POINTS = 9
# √F from which marks are taken in the boundary layers too: on them alone tense rods may differ
_TENSE = 16.0


@dataclass
class Marked:
    """An equilibrium to be compared with others of its clamping."""

    rod: Equilibrium

    @functools.cached_property
    def mark(self) -> Array:
        """See `mark`."""
        return mark(self.rod)

    def same(self, other: "Marked") -> bool:
        """Whether both are one equilibrium, or of one family."""
        one, two = self.rod, other.rod
        if not (one.converged and two.converged):
            return False
        if abs(one.energy - two.energy) > _ENERGIES * (1.0 + one.energy):
            return False
        # the torsion moment is nothing beside the force of a tense rod
        if all(_near(one.loads[part], two.loads[part]) for part in (slice(0, 3), slice(3, 6))):
            return True
        return bool(np.abs(self.mark - other.mark).max() < SAME)


def same(one: Equilibrium, other: Equilibrium) -> bool:
    """Whether two equilibria of one clamping are one, or of one family of solutions."""
    return Marked(one).same(Marked(other))


def _near(one: Array, other: Array) -> bool:
    return bool(np.abs(one - other).max() < _LOADS * (1.0 + np.abs(one).max()))


def mark(rod: Equilibrium) -> Array:
    """Numbers that are equal, within `SAME`, for two copies of one equilibrium or family only."""
    force, moment = rod.loads[:3], rod.loads[3:]
    if rod.clamping.closed:
        # the integrals of the rod's equations, which turns and shifts leave alone
        size, whole = math.hypot(*force), 0.5 * float(moment @ moment) + force[2]
        wrench = float(force @ moment)
        return np.array([rod.twist, size, whole, wrench / (1.0 + size)]) / (1.0 + size)
    layer = 1.0 / max(_TENSE, math.sqrt(math.hypot(*force)))
    poses = rod.poses(np.sort(np.append(np.linspace(0.0, 1.0, _POINTS), [layer, 1.0 - layer])))
    from scipy.spatial.transform import Rotation

    frames = Rotation.from_quat(poses[:, 3:], scalar_first=True).as_matrix()
    if not rod.clamping.on_one_line:
        return np.concatenate([poses[:, :3].ravel(), frames.ravel()])
    # what a turn about the common line leaves alone; the moments tell mirror images apart
    wrench = float(force @ moment) / (1.0 + float(force @ force))
    across = np.hypot(poses[:, 0], poses[:, 1])
    return np.concatenate([across, poses[:, 2], frames[:, 2, 2], [rod.twist, wrench]])
