"""All equilibria of a clamping that many starts can find.

What ``solve`` finds is always among them. Then two kinds of starts take turns. The structured ones
of ``multistart`` (whole turns, sides, bows, half waves) mostly end in minima; Newton's method from
the nearest rods of the guess library (``_library``) finds saddles as well.
What they lead to is compared at nine points along the rod: two results are one equilibrium if
positions and frames agree within `SAME`. Where both ends lie on one line the rod can be turned
about it at no cost, and two results are one if they agree after such a turn.

From how often each equilibrium was hit follows how much is still unseen (Good–Turing: the share of
hits that were first and only ones is the chance that the next start finds something new). Rounds
go on, to more turns and farther rods of the library, until that falls under `UNSEEN` or the starts
are used up.
"""

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from loopelastica._arrays import Array
from loopelastica._checks import instance, optional, positive, whole
from loopelastica.rod._arguments import check_torsion_ratio
from loopelastica.rod._library import stored_rods
from loopelastica.rod._starts import (
    TOLERANCE,
    Deadline,
    check_tolerance,
    from_loads,
    from_start,
    straight,
)
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.kernels.records import Start
from loopelastica.rod.solve import solve
from loopelastica.rod.stability import assess

# largest difference of position (L) or frame components between two copies of one equilibrium
SAME = 1e-5
UNSEEN = 0.02
# Newton steps from a rod of the guess library
_PATIENCE = 40
# bending the rod twice around costs ½(4π)²
ENERGY_SPAN = 8.0 * math.pi**2

_SIDES = ((False, False), (True, False), (False, True), (True, True))
_WAVES = (2.0, 3.0, 4.0, 5.0, 6.0)


def _sided(turns: tuple[float, ...], bow: float = 0.0, minimized: bool = True) -> tuple[Start, ...]:
    return tuple(
        Start(n, bow, over_0=a, over_1=b, minimized=minimized) for n in turns for a, b in _SIDES
    )


def _waves(turns: tuple[float, ...]) -> tuple[Start, ...]:
    return tuple(Start(n, half_waves=k, minimized=False) for n in turns for k in _WAVES)


def _both(turns: tuple[float, ...]) -> tuple[Start, ...]:
    """Minimized, and as they stand."""
    return (*_sided(turns), *_sided(turns, minimized=False))


# rounds: their starts, and how many rods of the guess library follow
_ROUNDS: tuple[tuple[tuple[Start, ...], int], ...] = (
    ((*_both((0.0, 1.0, -1.0)), *_waves((0.0,))), 16),
    (
        (
            *_waves((1.0, -1.0)),
            *_both((2.0, -2.0)),
            *(Start(n, bow=0.8) for n in (0.0, 1.0, -1.0)),
        ),
        32,
    ),
    (_both((3.0, -3.0, 4.0, -4.0)), 64),
    ((), 128),
)
_FREE_ROUNDS: tuple[tuple[tuple[Start, ...], int], ...] = (
    ((*_both((0.0,)), *_waves((0.0,))), 16),
    ((*_sided((0.0,), 0.3), *_sided((0.0,), 0.8)), 32),
    ((*_sided((0.0,), 1.5), *_sided((0.0,), 3.0)), 64),
    ((), 128),
)


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
    out_of_time : bool
        Whether a time limit ended the search.
    """

    def __init__(
        self, found: "list[_Found]", energy_max: float, starts: int, out_of_time: bool = False
    ) -> None:
        below = sorted((f for f in found if f.rod.energy <= energy_max), key=lambda f: f.rod.energy)
        super().__init__(f.rod for f in below)
        self.energy_max = energy_max
        self.starts = starts
        self.out_of_time = out_of_time
        self.hits = tuple(f.hits for f in below)
        self.unseen = self.hits.count(1) / sum(self.hits) if below else 1.0


@dataclass
class _Found:
    rod: Equilibrium
    hits: int = 1

    @functools.cached_property
    def mark(self) -> Array:
        return _mark(self.rod)


def equilibria(
    clamping: Clamping,
    torsion_ratio: float = 1.0,
    energy_max: float | None = None,
    rounds: int | None = None,
    turns: int | None = None,
    *,
    tolerance: float = TOLERANCE,
    time_limit_s: float | None = None,
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
    rounds : int, optional
        How many rounds of starts to make, 1 to 4. By default at least two, and more until
        ``unseen`` is small: the starts of one round are not independent, and the estimate alone
        would end the search too early.
    turns : int, optional
        List only rods with that many whole turns (:attr:`Equilibrium.turns`), and start from ends
        wound up that far, beyond half a turn too. Not with a free end spin.
    tolerance : float
        Largest residual of an equilibrium that is listed.
    time_limit_s : float, optional
        Seconds after which no further start is made, the first one being :func:`solve`; the list
        then says so by ``out_of_time``.

    Returns
    -------
    Equilibria
        A list, lowest energy first, each with its Morse index, and the estimate ``unseen`` of what
        is missing. Where both ends lie on one line each circle of solutions is listed once, by one
        of its rods.

    Raises
    ------
    ValueError
        As for :func:`solve`, if `rounds` is not 1 to 4, and for `turns` of a free end spin.

    Examples
    --------
    >>> q = Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
    >>> print([round(rod.energy, 4) for rod in equilibria(q, energy_max=30)])
    [7.0579, 19.1464, 23.2724]
    """
    clamping = instance("clamping", clamping, Clamping)
    torsion_ratio, tolerance = check_torsion_ratio(torsion_ratio), check_tolerance(tolerance)
    deadline = Deadline(time_limit_s)
    energy_max = optional(positive)("energy_max", energy_max)
    rounds, turns = optional(whole(1))("rounds", rounds), optional(whole(-1000))("turns", turns)
    if turns is not None and clamping.free_spin:
        raise ValueError("`turns` are those of an end with a fixed spin; `free_spin` leaves none")
    if rounds is not None and rounds > len(_ROUNDS):
        raise ValueError(f"`rounds` is {rounds}; it must be 1 to {len(_ROUNDS)}")
    stretched = straight(clamping, torsion_ratio)
    if stretched is not None:
        return _result([_Found(stretched, 2)], energy_max, 1)
    # no list may call a rod the lowest that `solve` undercuts
    found: list[_Found] = []
    lowest = solve(clamping, torsion_ratio, tolerance=tolerance, time_limit_s=time_limit_s)
    _merge(found, lowest)
    planned = (_FREE_ROUNDS if clamping.free_spin else _ROUNDS)[:rounds]
    if turns is not None:
        planned = ((_both((turns + 0.0, turns + 1.0, turns - 1.0)), 0), *planned)
    guesses = _stored(clamping, torsion_ratio, sum(count for _, count in planned))
    starts, used = 1, 0
    for number, (everything, count) in enumerate(planned, start=1):
        ways = _ways(clamping, torsion_ratio, everything, guesses[used : used + count], tolerance)
        used += count
        for way in ways:
            if deadline.passed:
                break
            _merge(found, way())
            starts += 1
        chosen = [f for f in found if turns is None or f.rod.turns == turns]
        result = _result(chosen, energy_max, starts, deadline.passed)
        if deadline.passed or (number >= 2 and result.unseen < UNSEEN):
            break
    result[:] = [assess(rod) for rod in result]
    return result


def _ways(
    clamping: Clamping,
    torsion_ratio: float,
    starts: tuple[Start, ...],
    guesses: Array,
    tolerance: float,
) -> list[Callable[[], Equilibrium]]:
    """The starts of a round: structured ones, then rods of the guess library."""
    waves = _nearly_in_line(clamping)
    structured = [start for start in starts if waves or start.half_waves == 0.0]
    shot = partial(from_loads, clamping, torsion_ratio, patience=_PATIENCE, tolerance=tolerance)
    return [
        *(partial(from_start, clamping, torsion_ratio, s, tolerance) for s in structured),
        *(partial(shot, loads=guess) for guess in guesses),
    ]


def _stored(clamping: Clamping, torsion_ratio: float, count: int) -> Array:
    """Loads (count, 6) of the rods of the guess library nearest to a clamping."""
    if count == 0:
        return np.empty((0, 6))
    stored = stored_rods(torsion_ratio, clamping.free_spin)
    loads, _ = stored.nearest(clamping.position[None], clamping.rotation[None], count)
    nearest: Array = loads[0]
    return nearest


def _nearly_in_line(clamping: Clamping) -> bool:
    """Whether the end tangents are within about 0.3 rad of the line between the ends.

    Only then did starts in half waves lead to equilibria that no other start finds.
    """
    size = np.linalg.norm(clamping.position)
    tangent = clamping.rotation[:, 2]
    return bool(clamping.position[2] > 0.95 * size and clamping.position @ tangent > 0.95 * size)


def _result(
    found: list[_Found], energy_max: float | None, starts: int, out_of_time: bool = False
) -> Equilibria:
    lowest = min((f.rod.energy for f in found), default=0.0)
    bound = lowest + ENERGY_SPAN if energy_max is None else energy_max
    return Equilibria(found, bound, starts, out_of_time)


def _merge(found: list[_Found], rod: Equilibrium) -> None:
    """Count ``rod``, if it converged, as a hit of the equilibrium that it equals, or add it."""
    if not rod.converged:
        return
    new = _Found(rod)
    same = _same(found, new)
    if same is None:
        found.append(new)
        return
    same.hits += 1
    if rod.residual < same.rod.residual:
        same.rod = rod


def _same(found: list[_Found], new: _Found) -> _Found | None:
    """The one of ``found`` that is the same equilibrium as ``new``, or None."""
    if not found:
        return None
    loads = np.array([other.rod.loads for other in found])
    apart = np.abs(loads - new.rod.loads).max(axis=1) / (1.0 + np.abs(loads).max(axis=1))
    nearest = int(apart.argmin())
    # equal loads are the same rod; unequal ones may be, on one line or near a fold
    if apart[nearest] < 1e-9:
        return found[nearest]
    further = np.inf if new.rod.clamping.on_one_line else 1e-2
    for i in np.flatnonzero(apart <= further):
        if np.abs(found[i].mark - new.mark).max() < SAME:
            return found[i]
    return None


def _mark(rod: Equilibrium) -> Array:
    """Numbers that are equal, within `SAME`, for two copies of one equilibrium only."""
    poses = rod.poses(9)
    from scipy.spatial.transform import Rotation

    frames = Rotation.from_quat(poses[:, 3:], scalar_first=True).as_matrix()
    if not rod.clamping.on_one_line:
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
