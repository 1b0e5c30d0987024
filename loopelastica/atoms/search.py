"""From a line to sound atoms: combinations of Ω and χ, and looser lines, tried in a fixed order.

    line → Ω and χ → start → minimum → checks

The first sound models end the search. Where none is sound, the one that is nearest to it is given
back, and its checks say what is wrong.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.atoms.carry import Curve
from loopelastica.atoms.checks import Checks, check
from loopelastica.atoms.measures import angles_deg, bond_lengths
from loopelastica.atoms.minimum import Problem, mended, minimum
from loopelastica.atoms.relax import Relaxed
from loopelastica.atoms.site import Site
from loopelastica.atoms.start import start_on
from loopelastica.atoms.turn import Turns, turned

LINE_SD_A: Final = (0.3, 1.0, 3.0)
"""How near the backbone centroids are held to the line. The next one is for lines from which no
sound model has come: a rod has no thickness and may run through the stem or itself. The nucleotides
are then moved out of the way first."""
MENDINGS: Final = 3
MOST_TRIES: Final = 12
"""Combinations of Ω and χ that are tried in all where the first ones give no sound model."""


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
    start_A : (N, 3) array
        On the line, before anything moved.
    relaxed : Relaxed
    checks : Checks
    """

    turns: Turns
    start_A: Array
    relaxed: Relaxed
    checks: Checks

    @property
    def order(self) -> tuple[float, float]:
        """Chemistry first, then the strain that is left against what stacking has gained."""
        return self.checks.excess, 0.1 * sum(self.relaxed.cost.values()) + self.turns.score


def best_on(
    site: Site, line: Curve, limits: Limits, *, contact: str | None = None
) -> tuple[Attempt, list[Turns], int]:
    """The best model on a line, and the combinations of Ω and χ, best first.

    Parameters
    ----------
    site : Site
        Where it is built.
    line : Curve
        In the site's frame.
    limits : Limits
    contact : str, optional
        As for :func:`turned`.

    Returns
    -------
    Attempt, list of Turns, int
    """
    end = time.monotonic() + limits.max_seconds
    problem = Problem.at(site)
    residues = site.molecule.residues
    combinations = turned(
        [r.letter for r in residues],
        [r.is_dna for r in residues],
        line,
        site.stem,
        contact=contact,
        keep=max(limits.tries, MOST_TRIES),
    )
    centers = np.round(line.at(np.arange(1, site.molecule.n + 1))[0], 6)
    attempts: list[Attempt] = []
    for turns, line_sd in product_of(combinations):
        start = start_on(site, line, turns)
        relaxed = minimum(
            problem, centers, line_sd, start, limits.max_steps, max(end - time.monotonic(), 0.0)
        )
        checks = check(site, relaxed.positions_A, centers, start, relaxed.status)
        stress = np.ones(len(problem.pairs))
        for _ in range(MENDINGS):
            if checks.sound or time.monotonic() > end:
                break
            stress *= _stress(site, relaxed.positions_A)
            relaxed = mended(problem, centers, relaxed, stress, limits.max_steps,
                             max(end - time.monotonic(), 0.0))  # fmt: skip
            checks = check(site, relaxed.positions_A, centers, start, relaxed.status)
        attempts.append(Attempt(turns, start, relaxed, checks))
        if sum(attempt.checks.sound for attempt in attempts) == limits.tries:
            break
        if time.monotonic() > end:
            break
    best = min(attempts, key=lambda attempt: attempt.order)
    return best, combinations, len(attempts)


def product_of(combinations: list[Turns]) -> Iterator[tuple[Turns, float]]:
    """Combination, and how near to the line."""
    for line_sd in LINE_SD_A:
        for turns in combinations:
            yield turns, line_sd


def _stress(site: Site, positions: Array) -> Array:
    """How much stiffer bonds and angles become that are far from ideal."""
    geometry = site.geometry
    bond = np.abs(bond_lengths(positions, geometry.bonds) - geometry.length_A)
    angle = np.abs(angles_deg(positions, geometry.angles) - geometry.angle_deg)
    return np.concatenate([np.where(bond > 0.04, 2.0, 1.0), np.where(angle > 7.5, 2.0, 1.0)])
