"""The search for all equilibria of one clamping: what it has found, and by which ways.

Rods are kept twice. As loads in the middle they are compared, and left from on tours
(``kernels.middle``, ``kernels.tours``); those that lie below the bound become solutions
(``kernels.settling``), each checked on a mesh of its own. Rods too tense for a shot from the middle
come from structured starts alone and are solutions already.
"""

import math
from dataclasses import dataclass

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod._middles import draw, middles
from loopelastica.rod._starts import (
    Deadline,
    equilibrium_of,
    from_start,
    problem_of,
)
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.kernels.middle import MAX_RATE, Catch, enter, harvest
from loopelastica.rod.kernels.multistart import new_rows
from loopelastica.rod.kernels.records import Start
from loopelastica.rod.kernels.rotations import matrix_from_quaternion
from loopelastica.rod.kernels.settling import settle
from loopelastica.rod.kernels.shooting import moment_bound
from loopelastica.rod.kernels.tours import Tour, pull, visit

_ROOM = 4000
# Newton steps that a start is given; guesses between two looks at the clock
_PATIENCE, _PART = 25, 40
# new rods of a part with which it is worth while to go on
_FEW = 2
# tours between two looks at the clock, steps of one, and its longest step
_TOURS, _STEPS, _LONGEST = 8, 600, 0.5
# cosine between two tangents of a curve that follow one another
_AGREE = 0.9
# tours go on up to this much above the bound, relative to it
_MARGIN = 0.3
# starts with a loop in the middle: β and azimuths
_BETAS, _AZIMUTHS = (-0.6, -0.35, -0.1, 0.1, 0.35, 0.6), 4
# how a clamping is tilted that has its ends on one line
_SHORTER, _ASIDE, _TILT = 0.995, (0.02, 0.01, 0.0), (0.03, -0.02, 0.0)

AXES = {"d1": (1.0, 0.0, 0.0), "d2": (0.0, 1.0, 0.0), "d3": (0.0, 0.0, 1.0)}


@dataclass
class Tours:
    """How the curves ended that were followed from rods found, their ends turned.

    Attributes
    ----------
    closed : int
        Came back to where they began: all rods along them are known.
    left : int
        Left the energies of interest.
    lost : int
        Could not be followed further.
    unfinished : int
        Were longer than a tour goes on.
    """

    closed: int = 0
    left: int = 0
    lost: int = 0
    unfinished: int = 0


class Search:
    """Rods of one clamping found so far.

    Parameters
    ----------
    clamping : Clamping
        With its ends less than the rod's length apart.
    torsion_ratio, tolerance : float
        As for `equilibria`.
    deadline : Deadline
        When to stop.
    """

    def __init__(
        self, clamping: Clamping, torsion_ratio: float, tolerance: float, deadline: Deadline
    ) -> None:
        self.clamping, self.torsion_ratio, self.tolerance = clamping, torsion_ratio, tolerance
        self.deadline = deadline
        self.starts = 0
        self.patience = _PATIENCE
        self.tours = Tours()
        self.found_by: dict[str, int] = {}
        self._problem = problem_of(clamping, torsion_ratio, tolerance)
        self._catch = Catch(
            np.empty((_ROOM, 6)), np.empty((_ROOM, 6)), np.empty(_ROOM), np.zeros(_ROOM, np.int64),
            np.zeros(1, np.int64), _symmetry(clamping),
        )  # fmt: skip
        self._solved: dict[int, Equilibrium] = {}
        self._tense: list[Equilibrium] = []
        self._walked: dict[str, Array] = {}
        self._drawn = 0
        self._random = np.random.default_rng(0)

    def __len__(self) -> int:
        return int(self._catch.count[0])

    def add(self, rod: Equilibrium, way: str) -> None:
        """Enter what a start led to."""
        self.starts += 1
        if not rod.converged:
            return
        loads = _in_the_middle(rod)
        if loads is None:
            self._tense.append(rod)
            return
        known = len(self)
        place = enter(loads, rod.energy, self._catch)
        if place >= 0:
            self._solved.setdefault(int(place), rod)
            self._count(way, known)

    def structured(self, starts: tuple[Start, ...]) -> None:
        """Run structured starts of ``multistart``."""
        for start in starts:
            if self.deadline.passed:
                return
            rod = from_start(self.clamping, self.torsion_ratio, start, self.tolerance)
            self.add(rod, "structured starts")

    def drawn(self, least: int, most: int) -> None:
        """Newton's method from the nearest of the drawn rods that no call before has used.

        From ``least`` of them, and on until a part brings hardly anything new, to ``most``.
        """
        rods = middles(self.torsion_ratio, self.clamping.free_spin)
        first = self._drawn
        loads = rods.nearest(self.clamping, first + most)[first:]
        for part in range(0, most, _PART):
            known = len(self)
            self._harvest(loads[part : part + _PART], "nearest drawn rods")
            self._drawn = first + min(part + _PART, most)
            if self.deadline.passed or (self._drawn >= first + least and len(self) < known + _FEW):
                break

    def random(self, count: int) -> None:
        """Newton's method from random loads."""
        loads = draw(self._random, count, self.torsion_ratio, self.clamping.free_spin)
        self._harvest(loads, "random loads")

    def _harvest(self, guesses: Array, way: str) -> None:
        for part in range(0, len(guesses), _PART):
            if self.deadline.passed:
                return
            some = guesses[part : part + _PART]
            known = len(self)
            harvest(self._problem, some, self.patience, self._catch)
            self.starts += len(some)
            self._count(way, known)

    @property
    def symmetric(self) -> bool:
        """Whether rods come in families, ends being on one line."""
        return bool(self._catch.symmetry)

    def tour(self, axis: str, energy_max: float, most: int) -> None:
        """Tours about an axis of the end frame, from all rods that none has come through."""
        walked = self._walked.setdefault(axis, np.zeros(_ROOM, np.bool_))
        direction = np.array(AXES[axis])
        tour = Tour(
            direction,
            axis == "d3",
            np.zeros(3),
            energy_max * (1.0 + _MARGIN),
            _STEPS,
            _LONGEST,
            _AGREE,
        )
        ended, known = np.zeros(4, np.int64), len(self)
        while most > 0 and not self.deadline.passed:
            some = min(most, _TOURS)
            made = visit(self._problem, tour, energy_max, self._catch, walked, some, ended)
            most -= made
            if made < some:
                break
        unfinished, lost, left, closed = (int(n) for n in ended)
        self.tours.unfinished += unfinished
        self.tours.lost += lost
        self.tours.left += left
        self.tours.closed += closed
        self._count(f"tours about {axis}", known)

    def looped(self) -> None:
        """Multiple shooting from a loop in the middle of a rod that is stretched between its ends.

        The loop is that of an infinite rod (homoclinic), with M3 = 2√F sin β: at its top the
        tangent is at the angle θ from the tension, sin θ/2 = cos β, and the bending moment
        2√F cos β lies in the plane of both; it shortens the rod by 4 cos β/√F.
        """
        free, loops = self.clamping.free_spin, []
        for beta in (0.0,) if free else _BETAS:
            root = 4.0 * math.cos(beta) / (1.0 - float(np.linalg.norm(self.clamping.position)))
            theta = 2.0 * math.asin(math.cos(beta))
            across = root**2 * math.sin(theta), math.copysign(2.0 * root * math.cos(beta), beta)
            # where both ends are on one line every azimuth is the same rod, turned
            azimuths = 1 if self.symmetric else _AZIMUTHS
            for azimuth in np.arange(azimuths) * (math.tau / azimuths):
                c, s = math.cos(azimuth), math.sin(azimuth)
                loops.append(
                    (
                        across[0] * c, across[0] * s, root**2 * math.cos(theta),
                        across[1] * c, across[1] * s, 2.0 * root * math.sin(beta),
                    )
                )  # fmt: skip
        for rod in self._settled(np.array(loops)):
            self.add(rod, "loops in the middle")

    def pulled(self, drawn: int, slack: float, energy_max: float) -> None:
        """From the rods of a slacker clamping, found there and pulled outwards."""
        clamping, size = self.clamping, float(np.linalg.norm(self.clamping.position))
        short = 1.0 - slack * (1.0 - size)
        # circles of rods have no single direction to go on in: they are pulled beside the line
        if drawn == 0 or self.symmetric or not short > 0.1 or self.deadline.passed:
            return
        near = Clamping(short / size * clamping.position, clamping.rotation, clamping.free_spin)
        near_search = Search(near, self.torsion_ratio, self.tolerance, self.deadline)
        near_search.patience = self.patience
        near_search.drawn(drawn, 2 * drawn)
        shift = clamping.position - near.position
        tour = Tour(
            np.zeros(3), False, shift, energy_max * (1.0 + _MARGIN), _STEPS, _LONGEST, _AGREE
        )
        ended, known = np.zeros(4, np.int64), len(self)
        pull(
            near_search._problem,
            tour,
            energy_max,
            near_search._catch,
            self._problem,
            self._catch,
            ended,
        )
        self.starts += near_search.starts
        self._count("pulled from a slacker clamping", known)

    def beside(self, drawn: int, most: int, energy_max: float) -> None:
        """From the rods of a clamping that is tilted a little, where ends on one line make circles.

        A curve of rods that can be turned at no cost has no single direction to go on in. Beside
        such a clamping, of each circle a few rods remain, with tours of their own.
        """
        if self._catch.symmetry == 0 or most == 0 or self.deadline.passed:
            return
        near = Clamping(
            self.clamping.position * _SHORTER + _ASIDE,
            self.clamping.rotation @ _tilt(),
            self.clamping.free_spin,
        )
        search = Search(near, self.torsion_ratio, self.tolerance, self.deadline)
        search.patience = self.patience
        search.drawn(drawn, 2 * drawn)
        known = len(self)
        harvest(search._problem, self._catch.loads[:known].copy(), self.patience, search._catch)
        for axis in AXES:
            search.tour(axis, energy_max, most)
        low = search._catch.energies[: len(search)] < energy_max
        self._harvest(search._catch.loads[: len(search)][low], "from a tilted clamping")
        self.starts += search.starts
        for name, count in vars(search.tours).items():
            setattr(self.tours, name, getattr(self.tours, name) + count)

    def _count(self, way: str, known: int) -> None:
        self.found_by[way] = self.found_by.get(way, 0) + len(self) - known

    @property
    def lowest(self) -> float:
        """Least energy found; inf if nothing was."""
        energies = [*self._catch.energies[: len(self)], *(rod.energy for rod in self._tense)]
        return float(min(energies, default=math.inf))

    def solutions(self, energy_max: float) -> list[tuple[Equilibrium, int]]:
        """Solutions below a bound and how many starts arrived at each; not all are different."""
        # energies of the coarse mesh are off by a thousandth
        low = self._catch.energies[: len(self)] <= energy_max * (1.0 + 1e-2) + 0.1
        places = [int(i) for i in np.flatnonzero(low) if int(i) not in self._solved]
        for place, rod in zip(places, self._settled(self._catch.loads[places]), strict=True):
            if rod.converged:
                self._solved[place] = rod
        hits = self._catch.hits
        return [
            *((self._solved[i], int(hits[i])) for i in sorted(self._solved) if low[i]),
            *((rod, 1) for rod in self._tense),
        ]

    def _settled(self, loads: Array) -> list[Equilibrium]:
        """Solutions from loads (n, 6) in the middle; some may not have converged."""
        rows = new_rows(len(loads))
        settle(self._problem, loads, rows)
        return [
            equilibrium_of(self.clamping, self.torsion_ratio, rows, i) for i in range(len(loads))
        ]


def _symmetry(clamping: Clamping) -> int:
    """Which motions of the rod keep its clampings, as `Catch` tells them."""
    return 2 if clamping.closed else 1 if clamping.on_one_line else 0


def _in_the_middle(rod: Equilibrium) -> Array | None:
    """Loads (6,) in the middle of a rod, or None if they are too large for a shot."""
    pose = rod.poses(np.array([0.5]))[0]
    x, y, z = pose[:3]
    fx, fy, fz = force = rod.loads[:3]
    moment = rod.loads[3:] + (fy * z - fz * y, fz * x - fx * z, fx * y - fy * x)
    frame = matrix_from_quaternion(pose[3:])
    loads: Array = np.concatenate([frame.T @ force, frame.T @ moment])
    return loads if moment_bound(loads) < MAX_RATE else None


def _tilt() -> Array:
    from scipy.spatial.transform import Rotation

    turn: Array = Rotation.from_rotvec(_TILT).as_matrix()
    return turn
