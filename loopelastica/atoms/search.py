"""From a line to sound atoms: combinations of Ω and χ, and looser lines, tried in a fixed order.

    line → Ω and χ → start → minimum → checks (→ mended → checks)

Where the line itself leads to nothing sound, it is bent to all sides, and the bends on which Ω and
χ find most room are tried first. The first sound models end the search. Where none is sound, the
one that is nearest to it is given back, and its checks say what is wrong.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.atoms.carry import Bent, Curve
from loopelastica.atoms.checks import OUTSIDE, Checks, check
from loopelastica.atoms.measures import angles_deg, bond_lengths
from loopelastica.atoms.minimum import into_clusters, mended, minimum, right_phosphates
from loopelastica.atoms.relax import Relaxed
from loopelastica.atoms.restraints import Problem
from loopelastica.atoms.site import Site
from loopelastica.atoms.start import start_on
from loopelastica.atoms.turn import Turns, turned

LINE_SD_A: Final = (0.3, 1.0, 3.0)
"""How near the backbone centroids are held to the line. The next one is for lines from which no
sound model has come: a rod has no thickness and may run through what is there or itself."""
BENDS_A: Final = (2.5, 5.0)
"""How far the line is bent to all sides where it leads to no sound model."""
MOST_TRIES: Final = 12
"""Combinations of a bend with Ω and χ that are minimized for each of these sizes."""
NEAR_SD_A: Final = (0.5, 2.0)
"""How near each atom is held to where it was, where something that is there is built anew."""
MENDINGS: Final = 3
TURNINGS: Final = 6
"""How often suites of the best model that are outside all clusters are turned towards one."""
RARE: Final = 2.0
OVERLAP: Final = 0.2
"""What a suite outside all clusters and an overlap per thousand atoms cost, in units of the score
of Ω, χ and pucker."""
HOPELESS: Final = 6.0
"""A model that is further from sound than this (see `Checks.excess`) is not mended."""


@dataclass(frozen=True, slots=True)
class Limits:
    """When a search ends.

    Attributes
    ----------
    tries : int
        Sound models that are compared; the best is taken.
    max_steps : int
        Most steps of one minimization.
    max_seconds : float
        Wall time after which nothing more is tried.
    """

    tries: int
    max_steps: int
    max_seconds: float


@dataclass(frozen=True, slots=True, eq=False)
class Attempt:
    """One model in the local frame.

    Attributes
    ----------
    turns : Turns
    line_A : (n, 3) array
        Points of the line it was built on, bent or not.
    start_A : (N, 3) array
        Before anything moved.
    relaxed : Relaxed
    checks : Checks
    near : bool
        Whether it began at given positions, not on the line.
    """

    turns: Turns
    line_A: Array
    start_A: Array
    relaxed: Relaxed
    checks: Checks
    near: bool = False

    @property
    def order(self) -> tuple[float, bool, float]:
        """Chemistry, a contact that is sought, then overlaps, strain, rare backbones and score."""
        missed = self.checks.contact_reached is False
        cost = {**self.relaxed.cost}
        # what let go of the line is held to it as what did not
        cost["line"] = len(self.line_A) * (self.checks.line_after_A / LINE_SD_A[0]) ** 2
        strain = 0.1 * sum(cost.values()) + OVERLAP * self.checks.clashes_per_1000
        return self.checks.excess, missed, strain + RARE * self.rare + self.turns.score

    @property
    def good(self) -> bool:
        """Whether it is sound and has the contact that is sought, if any."""
        return self.checks.sound and self.checks.contact_reached is not False

    @property
    def rare(self) -> int:
        """Number of suites outside all clusters."""
        return sum(name == OUTSIDE for name in self.checks.suites)


def best_on(site: Site, line: Curve, limits: Limits) -> tuple[Attempt, list[Turns], int]:
    """The best model on a line, and the combinations of Ω and χ, best first.

    Parameters
    ----------
    site : Site
        Where it is built.
    line : Curve
        In the site's frame.
    limits : Limits

    Returns
    -------
    Attempt, list of Turns, int
        The last is the number of attempts.
    """
    end = time.monotonic() + limits.max_seconds
    problem = Problem.at(site)
    first = _combinations(site, line, max(limits.tries, 3))
    attempts: list[Attempt] = []
    for curve, turns, line_sd in _schedule(site, line, first):
        # where the line itself leads to few sound models, one is enough
        if len(attempts) >= len(first) and any(attempt.good for attempt in attempts):
            break
        attempts.append(_attempt(problem, curve, turns, line_sd, limits, end))
        if sum(attempt.good for attempt in attempts) == limits.tries or time.monotonic() > end:
            break
    attempts.sort(key=lambda attempt: attempt.order)
    best = _into_clusters(problem, attempts[0], limits, end)
    for other in attempts[1:]:
        # a suite may be kept out by atoms that are fixed; two are no such accident
        if best.rare < 2 or not other.good:
            break
        best = min(best, _into_clusters(problem, other, limits, end), key=lambda one: one.order)
    return best, first, len(attempts)


def _combinations(site: Site, line: Curve, keep: int) -> list[Turns]:
    residues = site.molecule.residues
    letters, is_dna = [r.letter for r in residues], [r.is_dna for r in residues]
    return turned(
        letters, is_dna, line, site.stem, habits=site.habits, contact=site.contact, keep=keep
    )


def _schedule(site: Site, line: Curve, first: list[Turns]) -> Iterator[tuple[Curve, Turns, float]]:
    """Line, combination, and how near to the line: what is tried, in this order."""
    for turns in first:
        yield line, turns, LINE_SD_A[0]
    for line_sd, size_A in zip(LINE_SD_A[1:], BENDS_A, strict=True):
        bent = [line, *_bends(line, site.molecule.n, size_A)]
        found = [(t, curve) for curve in bent for t in _combinations(site, curve, 2)]
        found.sort(key=lambda pair: pair[0].score)
        for turns, curve in found[:MOST_TRIES]:
            yield curve, turns, line_sd


def _bends(line: Curve, n: int, size_A: float) -> list[Bent]:
    """The line bent to eight sides, and in waves."""
    points, frames = line.at([0.5, 0.5 * (n + 1), n + 0.5])
    along = points[2] - points[0]
    # a normal of the line in its middle, where its ends are at one place
    along = along if np.linalg.norm(along) > 1.0 else frames[1][:, 2]
    along = along / np.linalg.norm(along)
    u = frames[1][:, 0] - (frames[1][:, 0] @ along) * along
    if np.linalg.norm(u) < 0.1:
        u = frames[1][:, 1] - (frames[1][:, 1] @ along) * along
    u /= np.linalg.norm(u)
    v = np.cross(along, u)
    size_A = min(size_A, 0.7 * n + 0.7)
    turns = np.arange(8) * (math.tau / 8)
    sides = [size_A * (math.cos(a) * u + math.sin(a) * v) for a in turns]
    return [Bent(line, n, side) for side in sides] + [
        Bent(line, n, 0.5 * side, 2) for side in sides[::2]
    ]


def best_from(
    site: Site, line: Curve, limits: Limits, near: Array
) -> tuple[Attempt, list[Turns], int]:
    """The model next to given positions; the best one on the line where that is not sound.

    Parameters
    ----------
    site, line, limits, near
        As for :func:`best_near`.

    Returns
    -------
    Attempt, list of Turns, int
        As :func:`best_on`; no combinations where the line was not searched.
    """
    first, tried = best_near(site, line, limits, near)
    if first.checks.sound:
        return first, [], tried
    other, combinations, more = best_on(site, line, limits)
    return min(first, other, key=lambda attempt: attempt.order), combinations, tried + more


def best_near(site: Site, line: Curve, limits: Limits, near: Array) -> tuple[Attempt, int]:
    """The model next to given positions: the first that is sound, held less and less.

    Parameters
    ----------
    site : Site
        Where it is built.
    line : Curve
        Through the nucleotides, in the site's frame.
    limits : Limits
    near : (N, 3) array
        Positions in the site's frame, Å; NaN: of the ideal nucleotide laid on those that are there,
        else on the line.

    Returns
    -------
    Attempt, int
        And how many were tried.
    """
    end = time.monotonic() + limits.max_seconds
    n = site.molecule.n
    unturned = Turns((0.0,) * n, (0.0,) * n, 0.0)
    start = start_on(site, line, unturned, near)
    # older files have OP1 and OP2 the other way round, and no small step turns them over
    right_phosphates(site, start)
    problem = Problem.at(site)
    attempts: list[Attempt] = []
    for tether_sd in NEAR_SD_A:
        held = replace(problem, tether_sd=tether_sd)
        attempts.append(_attempt(held, line, unturned, LINE_SD_A[-1], limits, end, start))
        if attempts[-1].checks.sound or time.monotonic() > end:
            break
    return min(attempts, key=lambda attempt: attempt.order), len(attempts)


def _attempt(
    problem: Problem,
    line: Curve,
    turns: Turns,
    line_sd: float,
    limits: Limits,
    end: float,
    start: Array | None = None,
) -> Attempt:
    site = problem.site
    centers = np.round(line.at(np.arange(1, site.molecule.n + 1))[0], 6)
    near = start is not None
    if start is None:
        start = start_on(site, line, turns)
    left = max(end - time.monotonic(), 0.0)
    relaxed = minimum(problem, centers, line_sd, start, turns.c2_endo, limits.max_steps, left)
    checks = check(site, relaxed.positions_A, centers, start, relaxed.status)
    stress = np.ones(len(problem.pairs))
    for _ in range(MENDINGS):
        if checks.sound or checks.excess > HOPELESS or time.monotonic() > end:
            break
        stress *= _stress(site, relaxed.positions_A)
        relaxed = mended(
            problem, centers, relaxed, stress, limits.max_steps, max(end - time.monotonic(), 0.0)
        )
        checks = check(site, relaxed.positions_A, centers, start, relaxed.status)
    return Attempt(turns, centers, start, relaxed, checks, near)


def _into_clusters(problem: Problem, attempt: Attempt, limits: Limits, end: float) -> Attempt:
    """A sound model with fewer suites outside all clusters, where turning them leads to one."""
    site, centers = problem.site, attempt.line_A
    besides: list[set[int]] = [set() for _ in attempt.checks.suites]
    for turn in range(TURNINGS):
        outside = [name == OUTSIDE for name in attempt.checks.suites]
        if not any(outside) or not attempt.good or time.monotonic() > end:
            break
        # first all of them, then one after the other, for one that cannot turn spoils the rest
        places = [k for k, out in enumerate(outside) if out]
        chosen = places if turn == 0 else [places[turn % len(places)]]
        turning = [k in chosen for k in range(len(outside))]
        relaxed = into_clusters(problem, centers, attempt.relaxed, besides, turning,
                                limits.max_steps, max(end - time.monotonic(), 0.0))  # fmt: skip
        checks = check(site, relaxed.positions_A, centers, attempt.start_A, relaxed.status)
        other = replace(attempt, relaxed=relaxed, checks=checks)
        overlaps = checks.clashes_per_1000 > attempt.checks.clashes_per_1000
        if other.good and other.rare < attempt.rare and not overlaps:
            attempt = other
    return attempt


def _stress(site: Site, positions: Array) -> Array:
    """How much stiffer bonds and angles become that are far from ideal."""
    geometry = site.geometry
    bond = np.abs(bond_lengths(positions, geometry.bonds) - geometry.length_A)
    angle = np.abs(angles_deg(positions, geometry.angles) - geometry.angle_deg)
    more = [np.where(bond > 0.04, 2.0, 1.0), np.where(angle > 7.5, 2.0, 1.0)]
    return np.concatenate([*more, np.ones(len(site.contact_pairs))])
