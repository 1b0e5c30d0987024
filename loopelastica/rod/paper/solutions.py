"""What the paper's solver returns, and when two solutions are one.

Ameline et al., J. Comput. Phys. 373 (2018) 736, DOI 10.1016/j.jcp.2018.07.021, section 4.5.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.parameters import PhysicalParameters
from loopelastica.rod.writhe import net_winding

# two solutions are one if their physical parameters differ by less (section 4.5)
_SAME = 0.1
# mirror in the plane of d1 and d3 (eq. 34–35): the moment is an axial vector
MIRROR = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])


@dataclass(frozen=True, slots=True, eq=False)
class PaperSolution:
    """What the printed method found.

    Attributes
    ----------
    clamping : Clamping
        The clamping given.
    torsion_ratio : float
        K30.
    loads : (6,) ndarray
        F and M at S = 0 in the start frame (eq. 21), in K0/L² and K0/L; the last iterate where the
        method failed.
    physical : PhysicalParameters or None
        p (eq. 14); None where the force vanishes or the method failed.
    converged : bool
        Whether max|ε| fell below ε_c.
    residual : float
        Largest component of position error and rotation vector, by an integration that the method
        does not use; inf where the method failed.
    iterations : int
        Newton steps of all runs.
    restarts : int
        Guesses by eq. 36 that were needed.
    guess : int
        Rank of the initial guess, 1 for the nearest (IG of Fig. 7).
    """

    clamping: Clamping
    torsion_ratio: float
    loads: Array
    physical: PhysicalParameters | None
    converged: bool
    residual: float
    iterations: int
    restarts: int
    guess: int = 1

    @property
    def net_winding(self) -> float:
        """Twist plus polar writhe in turns (eq. 43); ValueError without physical parameters."""
        if self.physical is None:
            raise ValueError("a solution without physical parameters has no net winding")
        p = self.physical
        points = 200 + 100 * round(p.length / min(p.period, p.length))
        return net_winding(
            p.centerline(points, self.torsion_ratio),
            p.frames(points, self.torsion_ratio),
            turns=self.loads[5] / (self.torsion_ratio * math.tau),
        )


def turned_loads(loads: Array, angle: float) -> Array:
    """Force and moment turned about d3.

    Parameters
    ----------
    loads : (6,) ndarray
        F and M in the start frame.
    angle : float
        Radians.

    Returns
    -------
    (6,) ndarray
    """
    c, s = math.cos(angle), math.sin(angle)
    z = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return np.concatenate([z @ loads[:3], z @ loads[3:]])


def end_residual(loads: Array, clamping: Clamping, torsion_ratio: float) -> float:
    """Largest component of the end's position error and rotation vector.

    Parameters
    ----------
    loads : (6,) ndarray
        F and M at S = 0, in K0/L² and K0/L.
    clamping : Clamping
    torsion_ratio : float
        K30 = K3/K0.

    Returns
    -------
    float
        inf where the loads are too large to be integrated.
    """
    from loopelastica.rod.kernels.rotations import quaternion_from_matrix, rotation_vector
    from loopelastica.rod.paper import errors as kernels

    y = np.empty(7)
    if not kernels.project_end(loads, torsion_ratio, y):
        return math.inf
    away = rotation_vector(y[3:], quaternion_from_matrix(np.array(clamping.rotation)))
    return float(max(np.abs(y[:3] - clamping.position).max(), np.abs(away).max()))


def same(one: PaperSolution, other: PaperSolution) -> bool:
    """Whether two solutions are one (section 4.5).

    Parameters
    ----------
    one, other : PaperSolution

    Returns
    -------
    bool
        Whether no physical parameter differs by 0.1 or more, s_ini modulo the period.
    """
    p, q = one.physical, other.physical
    if p is None or q is None:
        return p is q and bool(np.abs(one.loads - other.loads).max() < _SAME)
    start = p.s_ini - q.s_ini
    if math.isfinite(p.period):
        start = math.remainder(start, p.period)
    differences = (p.lam - q.lam, p.t_p - q.t_p, p.a - q.a, start, p.length - q.length)
    return max(abs(d) for d in differences) < _SAME
