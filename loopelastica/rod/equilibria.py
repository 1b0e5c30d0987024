"""All equilibria of a clamping that a search from several sides can find.

What ``solve`` finds is always among them. Then, round by round, more ways are tried (``_search``):

* structured starts of ``multistart`` (whole turns, as many as the bound allows, and the sides of
  the end layers), which end in minima or, taken as they stand, in saddles of tense rods;
* Newton's method from the nearest of some ten thousand drawn rods, shot from their middle;
* tours: the end of each rod found is turned all the way round about d1, d2 and d3 of its frame, and
  whatever has the same clamping again is another equilibrium (or the same);
* Newton's method from random loads.

What they lead to is compared at points along the rod (``_same``): two results are one equilibrium
if energies, positions and frames agree. Where both ends lie on one line the rod can be turned
about it at no cost, and two results are one if they agree after such a turn; a closed rod can be
shifted along itself as well.
"""

import functools
import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from loopelastica._checks import instance, optional, positive, whole
from loopelastica._html import html_table
from loopelastica.rod._arguments import check_torsion_ratio
from loopelastica.rod._same import Marked
from loopelastica.rod._search import Search, Tours
from loopelastica.rod._starts import (
    TOLERANCE,
    Deadline,
    check_tolerance,
    straight,
)
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.kernels.records import Method, Start
from loopelastica.rod.morse import MorseCount, morse_count
from loopelastica.rod.solve import solve
from loopelastica.rod.stability import assess

# bending the rod twice around costs ½(4π)²
ENERGY_SPAN = 8.0 * math.pi**2

_SIDES = ((False, False), (True, False), (False, True), (True, True))
_WAVES = (2.0, 3.0, 4.0, 5.0, 6.0)
# whole turns that starts are wound up to at most
_MOST_TURNS = 12


@dataclass(frozen=True, slots=True)
class _Round:
    """What a round adds: nearest drawn rods, those of a slacker clamping, random loads, tours."""

    least: int
    drawn: int
    """How many drawn rods, at least and at most."""
    pulled: int
    slack: float
    """How many times as far from straight the slacker clamping is."""
    random: int
    tours: int
    """From how many rods at most."""
    patience: int
    """Newton steps that a start is given."""


# each is made after the ones before it
_ROUNDS = (
    _Round(40, 40, 0, 2.0, 0, 0, 25),
    _Round(40, 280, 80, 1.8, 0, 100, 25),
    _Round(400, 600, 300, 2.5, 300, 400, 40),
    _Round(1200, 2400, 600, 1.5, 2200, 2000, 40),
)
_AXES = ("d3", "d1", "d2")
_DEFAULT_ROUNDS = 2
# for each equilibrium listed, of index 0, 1, 2 and more, how many are not, after each round: fitted
# to what an independent search hit at 290 poses (`loopelastica bench completeness`)
_MISSED = (
    (0.01, 0.06, 1.8, 1.9),
    (0.0005, 0.003, 0.03, 0.11),
    (0.0002, 0.0008, 0.002, 0.02),
    (0.0001, 0.0002, 0.0005, 0.003),
)


def _sided(turns: tuple[float, ...], minimized: bool = True) -> tuple[Start, ...]:
    return tuple(
        Start(n, over_0=a, over_1=b, minimized=minimized) for n in turns for a, b in _SIDES
    )


def _both(turns: tuple[float, ...]) -> tuple[Start, ...]:
    """Minimized, and as they stand."""
    return (*_sided(turns), *_sided(turns, minimized=False))


def _structured(clamping: Clamping, torsion_ratio: float, energy: float) -> tuple[Start, ...]:
    """The structured starts of a search up to an ``energy``."""
    waves = _WAVES if _nearly_in_line(clamping) else ()
    if clamping.free_spin:
        return (*_both((0.0,)), *(Start(half_waves=k, minimized=False) for k in waves))
    # beyond, a rod's twist alone costs more
    most = min(_MOST_TURNS, max(2, math.ceil(math.sqrt(2.0 * energy / torsion_ratio) / math.tau)))
    wound = tuple(sign * n for n in range(2, most + 1) for sign in (1.0, -1.0))
    return (
        *_both((0.0, 1.0, -1.0)),
        *(Start(n) for n in wound),
        *(Start(n, over_0=a, over_1=not a, minimized=False) for n in wound for a in (True, False)),
        *(Start(n, half_waves=k, minimized=False) for k in waves for n in (0.0, 1.0, -1.0)),
    )


class Equilibria(list[Equilibrium]):
    """Equilibria of one clamping, lowest energy first, and what is known of their completeness.

    Attributes
    ----------
    energy_max : float
        The bound below which equilibria are listed.
    starts : int
        How many starts were made.
    hits : tuple of int
        How many starts arrived at each listed equilibrium; 0 for those met on tours only.
    rounds : int
        How many rounds of the search were completed.
    found_by : dict of str to int
        How many rods each way of searching found first, of any energy.
    tours : Tours
        How the curves ended that were followed from the rods found, their end turned all round.
    out_of_time : bool
        Whether a time limit ended the search.

    Examples
    --------
    >>> import loopelastica as le
    >>> q = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
    >>> rods = le.equilibria(q, energy_max=50)
    >>> [rod.index for rod in rods], rods.hits[0] > 1, rods.unseen < 0.1
    ([0, 0, 0, 1, 2, 1], True, True)
    """

    def __init__(
        self,
        found: "list[_Found]",
        energy_max: float,
        starts: int,
        out_of_time: bool = False,
        *,
        rounds: int = 0,
        found_by: dict[str, int] | None = None,
        tours: Tours | None = None,
        selected: bool = False,
    ) -> None:
        # rods that lie on the bound itself are listed, whatever rounding says
        highest = energy_max * (1.0 + 1e-9)
        below = sorted((f for f in found if f.rod.energy <= highest), key=lambda f: f.rod.energy)
        super().__init__(f.rod for f in below)
        self.energy_max = energy_max
        self.starts = starts
        self.out_of_time = out_of_time
        self.hits = tuple(f.hits for f in below)
        self.rounds = rounds
        self._selected = selected
        self.found_by = found_by or {}
        self.tours = tours or Tours()

    def records(self) -> Iterator[dict[str, Any]]:
        """Give a row for each equilibrium, for :func:`loopelastica.to_dataframe`.

        Yields
        ------
        dict
            ``rank``, ``energy`` (K0/L), ``index`` (Morse), ``stable``, ``twist`` (turns),
            ``residual``, loads ``F1`` … ``M3`` in the start frame, and ``hits``.
        """
        for rank, (rod, hits) in enumerate(zip(self, self.hits, strict=True), start=1):
            yield {
                "rank": rank,
                "energy": rod.energy,
                "index": rod.index,
                "stable": rod.stable,
                "twist": rod.twist,
                "residual": rod.residual,
                **dict(zip(("F1", "F2", "F3", "M1", "M2", "M3"), rod.loads.tolist(), strict=True)),
                "hits": hits,
            }

    def _repr_html_(self) -> str:
        """A table of them, for notebooks."""
        rows = [
            (row["rank"], f"{row['energy']:.6g}", row["index"], f"{row['twist']:.4f}", row["hits"])
            for row in self.records()
        ]
        caption = f"{len(self)} equilibria up to {self.energy_max:.6g} K0/L"
        return html_table(caption, ("rank", "energy (K0/L)", "index", "twist", "hits"), rows)

    @functools.cached_property
    def unseen(self) -> float:
        """Estimated share of the equilibria below the bound that the list lacks; 1 if it is empty.

        Calibrated, for the default bound, on what an independent search hits. Above it Good and
        Turing's estimate from single hits counts where it is larger.
        """
        if not self:
            return 1.0
        if self[0].method == Method.STRAIGHT:
            return 0.0
        shares = _MISSED[min(max(self.rounds, 1), len(_MISSED)) - 1]
        lacking = sum(shares[min(rod.index or 0, len(shares) - 1)] for rod in self)
        share = lacking / (len(self) + lacking)
        if self.energy_max > self[0].energy + 1.01 * ENERGY_SPAN:
            # not calibrated up there: Good and Turing's estimate, the share of single hits
            share = max(share, self.hits.count(1) / max(sum(self.hits), 1))
        return share

    @property
    def by_index(self) -> tuple[int, ...]:
        """How many of the list have the Morse index 0, 1, ….

        A family of rods counts once here; in `morse` it counts by its homology.
        """
        counts = Counter(rod.index or 0 for rod in self)
        return tuple(counts[k] for k in range(max(counts, default=-1) + 1))

    @functools.cached_property
    def morse(self) -> MorseCount | None:
        """What topology demands of the list (:func:`.morse_count`).

        None if it is empty, or if only rods with certain `turns` were asked for.
        """
        return morse_count(self) if self and not self._selected else None

    @property
    def evidence(self) -> str:
        """What speaks for the list being complete, in sentences."""
        t = self.tours
        curves = t.closed + t.left + t.lost + t.unfinished
        listed = ", ".join(f"{n} of index {k}" for k, n in enumerate(self.by_index) if n)
        sentences = [
            f"{len(self)} equilibria up to the energy {self.energy_max:.4g}: {listed or 'none'}.",
            f"{self.starts} starts in {self.rounds} of {len(_ROUNDS)} rounds; "
            + (
                f"{curves} curves followed: {t.closed} closed, {t.left} left the energies of"
                f" interest, {t.lost} lost, {t.unfinished} unfinished."
                if curves
                else "no curves followed."
            ),
            f"Estimated share not found: {self.unseen:.3f}.",
        ]
        if self.morse is not None:
            sentences.append(f"{self.morse.text}.")
        if self.out_of_time:
            sentences.append("The time limit ended the search.")
        return " ".join(sentences)


@dataclass
class _Found(Marked):
    hits: int = 1


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
        How deep to search, 1 to 4; that many rounds are made, whatever they find. Default: 2, some
        0.1 s. 1 makes starts only, 3 and 4 take some 0.5 and 3 s.
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
        A list, lowest energy first, each with its Morse index, and what is known of its
        completeness (``evidence``). Where both ends lie on one line rods come in families; each is
        listed once, by one of its rods (`Equilibrium.family_dimension`).

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
        return Equilibria([_Found(stretched, 2)], _bound(energy_max, stretched.energy), 1)
    search = Search(clamping, torsion_ratio, tolerance, deadline)
    # no list may call a rod the lowest that `solve` undercuts
    lowest = solve(clamping, torsion_ratio, tolerance=tolerance, time_limit_s=time_limit_s)
    search.add(lowest, "solve")
    if turns is not None:
        search.structured(_both((turns + 0.0, turns + 1.0, turns - 1.0)))
    span = ENERGY_SPAN if energy_max is None else energy_max
    search.structured(_structured(clamping, torsion_ratio, span))
    if _nearly_in_line(clamping):
        search.looped()
    done = 0
    for plan in _ROUNDS[: rounds or _DEFAULT_ROUNDS]:
        search.patience = plan.patience
        search.drawn(plan.least, plan.drawn)
        search.pulled(plan.pulled, plan.slack, _bound(energy_max, search.lowest))
        search.random(plan.random)
        if search.symmetric:
            search.beside(plan.least, plan.tours, _bound(energy_max, search.lowest))
        else:
            for axis in _AXES if plan.tours else ():
                search.tour(axis, _bound(energy_max, search.lowest), plan.tours)
        if deadline.passed:
            break
        done += 1
    bound = _bound(energy_max, search.lowest)
    found: list[_Found] = []
    for rod, hits in search.solutions(bound):
        _merge(found, rod, hits)
    result = Equilibria(
        [f for f in found if turns is None or f.rod.turns == turns],
        bound,
        search.starts,
        deadline.passed,
        rounds=done,
        found_by=search.found_by,
        tours=search.tours,
        selected=turns is not None,
    )
    result[:] = [assess(rod) for rod in result]
    return result


def _bound(energy_max: float | None, lowest: float) -> float:
    if energy_max is not None:
        return energy_max
    return ENERGY_SPAN + (lowest if math.isfinite(lowest) else 0.0)


def _nearly_in_line(clamping: Clamping) -> bool:
    """Whether the end tangents are within about 0.3 rad of the line between the ends.

    Only then did starts in half waves lead to equilibria that no other start finds.
    """
    size = np.linalg.norm(clamping.position)
    tangent = clamping.rotation[:, 2]
    return bool(clamping.position[2] > 0.95 * size and clamping.position @ tangent > 0.95 * size)


def _merge(found: list[_Found], rod: Equilibrium, hits: int = 1) -> None:
    """Add ``rod``, if it converged, or its hits to those of the equilibrium that it equals."""
    if not rod.converged:
        return
    new = _Found(rod, hits)
    known = next((i for i, old in enumerate(found) if old.same(new)), None)
    if known is None:
        found.append(new)
        return
    if rod.residual >= found[known].rod.residual:
        new = found[known]
    found[known] = replace(new, hits=found[known].hits + hits)
