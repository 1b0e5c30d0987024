"""All equilibria of a clamping that many starts can find.

Starts are the stored rods nearest to the clamping, nearest first, in rounds. What they lead to is
compared at nine points along the rod: two results are one equilibrium if positions and frames
agree within `SAME`. Where both ends lie on one line the rod can be turned about it at no cost, and
two results are one if they agree after such a turn. From how often each equilibrium was hit
follows how much is still unseen (Good–Turing: the share of hits that were first and only ones is
the chance that the next start finds something new); rounds go on until that falls under
`UNSEEN` or the budget ends.
"""

import math
from dataclasses import dataclass

import numpy as np

from loopelastica.rod.clamping import Array, Clamping
from loopelastica.rod.equilibrium import Equilibrium, Status
from loopelastica.rod.solve import TOLERANCE, check_torsion_ratio, straight

# largest difference of position (L) or frame components between two copies of one equilibrium
SAME = 1e-5
UNSEEN = 0.02
# bending the rod twice around costs ½(4π)²
ENERGY_SPAN = 8.0 * math.pi**2

_ROUND, _BUDGET = 48, 384


class Equilibria(list[Equilibrium]):
    """Equilibria of one clamping, lowest energy first.

    Attributes
    ----------
    energy_max : float
        The bound below which equilibria are listed.
    unseen : float
        Good–Turing estimate of the chance that the next start that converges below the bound
        finds an equilibrium that is not listed; 1 if nothing was found.
    starts : int
        How many starts were made.
    hits : tuple of int
        How often each listed equilibrium was found.
    """

    def __init__(self, found: "list[_Found]", energy_max: float, starts: int) -> None:
        below = sorted((f for f in found if f.rod.energy <= energy_max), key=lambda f: f.rod.energy)
        super().__init__(f.rod for f in below)
        self.energy_max = energy_max
        self.starts = starts
        self.hits = tuple(f.hits for f in below)
        self.unseen = self.hits.count(1) / sum(self.hits) if below else 1.0


@dataclass(slots=True)
class _Found:
    rod: Equilibrium
    mark: Array
    hits: int = 1


def equilibria(
    clamping: Clamping, torsion_ratio: float = 1.0, energy_max: float | None = None
) -> Equilibria:
    """Find the equilibria of a clamped rod up to an energy.

    Parameters
    ----------
    clamping : Clamping
        The end's pose in the start frame, lengths in units of the rod's.
    torsion_ratio : float
        K30 = K3/K0.
    energy_max : float, optional
        List equilibria with at most this energy, in K0/L; above any bound there are infinitely
        many. Default: the lowest energy found plus 8π² (79), what it costs to bend a rod twice
        around.

    Returns
    -------
    Equilibria
        A list, lowest energy first, with the estimate ``unseen`` of what is missing. Where both
        ends lie on one line each circle of solutions is listed once, by one of its rods.

    Raises
    ------
    ValueError
        As for :func:`solve`.

    Examples
    --------
    >>> q = Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
    >>> print([round(rod.energy, 4) for rod in equilibria(q, energy_max=30)])
    [7.0579, 19.1464, 23.2724]
    """
    torsion_ratio = check_torsion_ratio(torsion_ratio)
    stretched = straight(clamping, torsion_ratio)
    if stretched is not None:
        bound = stretched.energy + ENERGY_SPAN if energy_max is None else float(energy_max)
        return Equilibria([_Found(stretched, np.zeros(0), 2)], bound, 1)
    from loopelastica.rod.library import library

    guesses = library(torsion_ratio, clamping.free_spin).nearest(
        clamping.position[None], clamping.rotation[None], _BUDGET
    )[0]
    found: list[_Found] = []
    result = Equilibria(found, math.inf, 0)
    for first in range(0, _BUDGET, _ROUND):
        for guess in guesses[first : first + _ROUND]:
            rod = _from_guess(clamping, torsion_ratio, guess)
            if rod.converged:
                _merge(found, rod)
        lowest = min((f.rod.energy for f in found), default=0.0)
        bound = lowest + ENERGY_SPAN if energy_max is None else float(energy_max)
        result = Equilibria(found, bound, first + _ROUND)
        if result.unseen < UNSEEN:
            break
    return result


def _from_guess(clamping: Clamping, torsion_ratio: float, guess: Array) -> Equilibrium:
    from loopelastica.rod._newton import elastic_energy, newton
    from loopelastica.rod._rotations import quaternion_from_matrix

    loads = guess.copy()
    status, residual, _, _ = newton(
        loads, clamping.position, quaternion_from_matrix(clamping.rotation),
        torsion_ratio, clamping.free_spin, TOLERANCE,
    )  # fmt: skip
    if status != Status.CONVERGED:
        return Equilibrium(clamping, torsion_ratio, loads, math.inf, math.inf, Status(status))
    energy = elastic_energy(loads, clamping.position, torsion_ratio)
    return Equilibrium(clamping, torsion_ratio, loads, energy, residual, Status.CONVERGED)


def _merge(found: list[_Found], rod: Equilibrium) -> None:
    """Count ``rod`` as a hit of the equilibrium that it equals, or add it."""
    for other in found:
        # equal loads are the same rod; unequal ones may be, on one line or near a fold
        if np.abs(other.rod.loads - rod.loads).max() < 1e-7:
            other.hits += 1
            return
    mark = _mark(rod)
    for other in found:
        if np.abs(other.mark - mark).max() < SAME:
            other.hits += 1
            if rod.residual < other.rod.residual:
                other.rod = rod
            return
    found.append(_Found(rod, mark))


def _mark(rod: Equilibrium) -> Array:
    """Numbers that are equal, within `SAME`, for two copies of one equilibrium only."""
    poses = rod.poses(9)
    from scipy.spatial.transform import Rotation

    frames = Rotation.from_quat(poses[:, 3:], scalar_first=True).as_matrix()
    if not on_one_line(rod.clamping):
        return np.concatenate([poses[:, :3].ravel(), frames.ravel()])
    # what a turn about the common line leaves alone; the moments tell mirror images apart
    force, moment = rod.loads[:3], rod.loads[3:]
    return np.concatenate(
        [
            np.hypot(poses[:, 0], poses[:, 1]),
            poses[:, 2],
            frames[:, 2, 2],
            [rod.twist, float(force @ moment) / (1.0 + float(force @ force))],
        ]
    )


def on_one_line(clamping: Clamping) -> bool:
    """Whether both end tangents lie on the line through both ends (θ_R = 0, η1 = η2 = 0)."""
    across = max(np.abs(clamping.position[:2]).max(), np.abs(clamping.rotation[:2, 2]).max())
    return bool(across < 1e-9 and clamping.rotation[2, 2] > 0)
