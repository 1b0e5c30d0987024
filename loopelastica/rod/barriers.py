"""Barriers: the lowest pass found between minima of the elastic energy.

Every saddle of index 1 joins the two minima that its unstable direction leads to (`ways_down`). The
lowest way from one minimum to another is that of a minimum spanning tree of this graph, and its
highest saddle is the barrier. A list of all equilibria below a bound joins whatever is joined below
it. While minima of one component of the space of rods are apart, the bound is raised; and passes
that differ from known ones by turns of the end are looked for (``_turned``).

A pass between rods of different twist goes over a loop, and the straighter a rod is held the
tighter is the loop. One in an infinite rod under the tension F has the energy 4 √F and shortens it
by 4/√F: in a rod that is shortened by 1 − |η| it costs about 16/(1 − |η|), and the bound is raised
to twice as much.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from loopelastica._arrays import Record
from loopelastica._checks import shown
from loopelastica.rod._same import same
from loopelastica.rod._starts import TOLERANCE, Deadline, check_tolerance
from loopelastica.rod._turned import turned
from loopelastica.rod.descent import ways_down
from loopelastica.rod.equilibria import ENERGY_SPAN, equilibria
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.morse import homotopy_class
from loopelastica.rod.stability import assess

# energy of a loop times what it shortens a rod by; the least of that
_LOOP, _SLACK = 16.0, 1e-9

OTHER_CLASS = (
    "no motion with both ends clamped leads from one to the other: the end would have to be turned"
    " by a full turn"
)
NONE_FOUND = "no pass was found; there is one, for both rods are in one component of the space"
OUT_OF_TIME = "no pass was found within the time limit"


@dataclass(frozen=True, slots=True, eq=False)
class Barrier(Record):
    """The lowest pass found between two minima.

    Attributes
    ----------
    minima : (int, int)
        Their positions in the list.
    energy : float
        Energy of the pass, in K0/L; inf if there is none.
    height_from : (float, float)
        How far it is above either minimum, in K0/L; inf if there is none.
    saddle : Equilibrium or None
        The equilibrium at the pass, of index 1; its energy is the highest on the way.
    via : tuple of Equilibrium
        All saddles of the way in their order; between two of them it goes through a minimum.
    message : str
        Why there is no pass; empty if there is one.

    Examples
    --------
    >>> import loopelastica as le
    >>> q = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
    >>> barrier = le.barriers(le.equilibria(q, energy_max=50)).between(1, 2)
    >>> print(barrier.minima, round(barrier.energy, 3), barrier.saddle.index)
    (1, 2) 40.211 1
    """

    minima: tuple[int, int]
    energy: float
    height_from: tuple[float, float]
    saddle: Equilibrium | None
    via: tuple[Equilibrium, ...] = ()
    message: str = ""


class Barriers(list[Barrier]):
    """Barriers between the minima of a list, in the order of the pairs.

    Attributes
    ----------
    found : tuple of Equilibrium
        Equilibria that the list did not have and the search came across, lowest energy first.
    out_of_time : bool
        Whether a time limit ended the search.

    Examples
    --------
    >>> import loopelastica as le
    >>> q = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
    >>> passes = le.barriers(le.equilibria(q, energy_max=50))
    >>> len(passes), [barrier.minima for barrier in passes if barrier.saddle is not None]
    (3, [(1, 2)])
    """

    def __init__(
        self, barriers: Iterable[Barrier], found: Iterable[Equilibrium], out_of_time: bool
    ) -> None:
        super().__init__(barriers)
        self.found = tuple(sorted(found, key=lambda rod: rod.energy))
        self.out_of_time = out_of_time

    def between(self, i: int, j: int) -> Barrier:
        """The barrier between two minima.

        Parameters
        ----------
        i, j : int
            Their positions in the list.

        Returns
        -------
        Barrier

        Raises
        ------
        ValueError
            If one of them is no minimum, or they are the same.
        """
        for barrier in self:
            if barrier.minima in ((i, j), (j, i)):
                return barrier
        raise ValueError(f"there is no barrier between {shown(i)} and {shown(j)} of the list")

    def records(self) -> Iterator[dict[str, Any]]:
        """Give a row for each barrier, for :func:`loopelastica.to_dataframe`.

        Yields
        ------
        dict
            Positions of the minima in the list; energy of the pass and its heights above them
            (K0/L); number of saddles; why there is no pass.
        """
        for barrier in self:
            known = barrier.saddle is not None
            yield {
                "minimum": barrier.minima[0],
                "other_minimum": barrier.minima[1],
                "barrier_energy": barrier.energy if known else None,
                "height_from_minimum": barrier.height_from[0] if known else None,
                "height_from_other": barrier.height_from[1] if known else None,
                "saddles": len(barrier.via),
                "message": barrier.message,
            }


def barriers(
    equilibria: Iterable[Equilibrium],
    *,
    search: bool = True,
    tolerance: float = TOLERANCE,
    time_limit_s: float | None = None,
) -> Barriers:
    """The lowest pass found between each two minima of a list.

    Parameters
    ----------
    equilibria : iterable of Equilibrium
        Of one clamping and torsion ratio, as :func:`equilibria` lists them, each family once.
        Those that did not converge are passed over; indices are computed where they are not known.
    search : bool
        Look for passes that the list does not have: above its bound, where its saddles of index 1
        leave minima apart; also below, where it is no list of :func:`equilibria`, or one that a
        time limit ended. False: only what its saddles of index 1 join.
    tolerance : float
        Largest residual of a pass that is found.
    time_limit_s : float, optional
        Seconds after which no further pass is looked for; the result then says so by
        ``out_of_time``.

    Returns
    -------
    Barriers
        A list of :class:`Barrier`, one for each pair of minima. The passes are the lowest found,
        not proven to be the lowest. What joins two minima is followed on the discrete rod, and a
        barrier is the energy of a refined equilibrium.

    Raises
    ------
    ValueError
        If they are no equilibria, or of different clampings or torsion ratios.

    Examples
    --------
    >>> import loopelastica as le
    >>> q = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
    >>> rods = le.equilibria(q, energy_max=50)
    >>> for barrier in barriers(rods):
    ...     print(barrier.minima, barrier.message[:31] or round(barrier.energy, 3))
    (0, 1) no motion with both ends clampe
    (0, 2) no motion with both ends clampe
    (1, 2) 40.211
    """
    tolerance, deadline = check_tolerance(tolerance), Deadline(time_limit_s)
    listed = _checked(equilibria)
    landscape = _Landscape(
        {i: rod for i, rod in listed.items() if rod.index == 0}, tolerance, deadline
    )
    saddles = [rod for rod in listed.values() if rod.index == 1]
    for saddle in sorted(saddles, key=lambda rod: rod.energy):
        landscape.add(saddle)
    if search:
        whole = not getattr(equilibria, "out_of_time", False)
        landscape.search(getattr(equilibria, "energy_max", None) if whole else None)
    minima = [i for i, rod in listed.items() if rod.index == 0]
    pairs = [(i, j) for i in minima for j in minima if i < j]
    found = [rod for rod in landscape.found if not any(same(rod, o) for o in listed.values())]
    return Barriers([landscape.barrier(*pair) for pair in pairs], found, deadline.passed)


def _checked(equilibria: Iterable[Equilibrium]) -> dict[int, Equilibrium]:
    """Those that converged by their positions, with their indices."""
    try:
        rods = list(equilibria)
    except TypeError:
        raise ValueError(
            f"`equilibria` is {shown(equilibria)}; it must be a list of them"
        ) from None
    for rod in rods:
        if not isinstance(rod, Equilibrium):
            raise ValueError(f"`equilibria` holds {shown(rod)}; it must hold equilibria only")
        if rod.clamping != rods[0].clamping or rod.torsion_ratio != rods[0].torsion_ratio:
            raise ValueError(
                "`equilibria` are of different clampings or torsion ratios; a barrier is between"
                " two rods of the same"
            )
    return {i: assess(rod) for i, rod in enumerate(rods) if rod.converged}


@dataclass
class _Step:
    """A saddle of index 1 and the two minima, by number, that it joins."""

    saddle: Equilibrium
    ends: tuple[int, int]


@dataclass
class _Landscape:
    """Minima by number, those of the list by their positions, and the saddles that join them."""

    minima: dict[int, Equilibrium]
    tolerance: float
    deadline: Deadline
    steps: list[_Step] = field(default_factory=list)
    found: list[Equilibrium] = field(default_factory=list)
    turned: list[Equilibrium] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.listed = tuple(self.minima)
        self.classes = {i: homotopy_class(rod) for i, rod in self.minima.items()}

    def number(self, rod: Equilibrium) -> int | None:
        """The number of a minimum, new if it is; of the minimum below a lower saddle; or None."""
        if not rod.converged:
            return None
        for i, known in self.minima.items():
            if same(known, rod):
                return i
        rod = assess(rod)
        if rod.index:
            # a symmetric way down ends in a lower saddle: either way on belongs to it
            return self.add(rod)
        new = 1 + max(self.minima, default=-1)
        self.minima[new], self.classes[new] = rod, homotopy_class(rod)
        self.found.append(rod)
        return new

    def add(self, saddle: Equilibrium) -> int | None:
        """Join what a saddle leads to; the number of one of the minima, or None if it is lost."""
        for step in self.steps:
            if same(step.saddle, saddle):
                return step.ends[0]
        ends = [self.number(low) for low in ways_down(saddle, self.tolerance)]
        reached = [end for end in ends if end is not None]
        if saddle.index == 1 and len(reached) == 2:
            self.steps.append(_Step(saddle, (reached[0], reached[1])))
            self.found.append(saddle)
        return reached[0] if reached else None

    def search(self, energy_max: float | None) -> None:
        """Look for passes above the bound of the list, if it has one, while minima are apart."""
        if len(self.listed) < 2:
            return
        energies = [self.minima[i].energy for i in self.listed]
        clamping = self.minima[self.listed[0]].clamping
        bound = energy_max
        if bound is None:
            bound = max(min(energies) + ENERGY_SPAN, *energies)
            self._raise(bound)
        loop = _LOOP / max(1.0 - float(np.linalg.norm(clamping.position)), _SLACK)
        span = max(ENERGY_SPAN, 0.25 * loop)
        while self._apart() and not self.deadline.passed:
            self._raise(bound + span)
            if not clamping.free_spin:
                self._turn()
            if span > 2.0 * loop:
                break
            span *= 2.0

    def _raise(self, energy_max: float) -> None:
        """Add the saddles of index 1 below a bound."""
        rod = self.minima[self.listed[0]]
        if self.deadline.passed:
            return
        rods = equilibria(
            rod.clamping, rod.torsion_ratio, energy_max, tolerance=self.tolerance,
            time_limit_s=self.deadline.left_s,
        )  # fmt: skip
        for found in rods:
            if found.index == 1:
                self.add(found)

    def _turn(self) -> None:
        """Turn the ends of the passes of the tree, the lowest first."""
        while not self.deadline.passed:
            rods = [step.saddle for step in self._tree()]
            left = [rod for rod in rods if not any(same(rod, one) for one in self.turned)]
            if not left or not self._apart():
                break
            self.turned.append(left[0])
            for found in turned(left[0], self.tolerance):
                found = assess(found)
                if found.index == 1:
                    self.add(found)

    def _apart(self) -> list[int]:
        """The listed minima that no way joins to the first of their class."""
        first: dict[int, int] = {}
        return [
            i for i in self.listed
            if self._way(first.setdefault(self.classes[i], i), i) is None
        ]  # fmt: skip

    def _tree(self) -> list[_Step]:
        """The steps of a minimum spanning forest, lowest first (Kruskal)."""
        home = {i: i for i in self.minima}
        tree = []
        for step in sorted(self.steps, key=lambda step: step.saddle.energy):
            a, b = (home[end] for end in step.ends)
            if a != b:
                tree.append(step)
                home = {i: a if at == b else at for i, at in home.items()}
        return tree

    def _way(self, i: int, j: int) -> tuple[Equilibrium, ...] | None:
        """The saddles from one minimum to another in the spanning forest; None if apart."""
        ways: dict[int, tuple[Equilibrium, ...]] = {i: ()}
        tree, new = self._tree(), True
        while new and j not in ways:
            new = False
            for step in tree:
                for a, b in (step.ends, step.ends[::-1]):
                    if a in ways and b not in ways:
                        ways[b] = (*ways[a], step.saddle)
                        new = True
        return ways.get(j)

    def barrier(self, i: int, j: int) -> Barrier:
        """The barrier between two minima."""
        way = self._way(i, j)
        if not way:
            message = OUT_OF_TIME if self.deadline.passed else NONE_FOUND
            if self.classes[i] != self.classes[j]:
                message = OTHER_CLASS
            return Barrier((i, j), math.inf, (math.inf, math.inf), None, (), message)
        saddle = max(way, key=lambda rod: rod.energy)
        low, other = (saddle.energy - self.minima[end].energy for end in (i, j))
        return Barrier((i, j), saddle.energy, (low, other), saddle, way)
