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
from loopelastica.atoms.minimum import Problem, minimum
from loopelastica.atoms.relax import Relaxed
from loopelastica.atoms.site import Site
from loopelastica.atoms.start import moved_out, shifted, start_on
from loopelastica.atoms.turn import Turns, turned

LINE_SD_A: Final = (0.3, 1.0, 3.0)
"""How near the backbone centroids are held to the line. The next one is for lines from which no
sound model has come: a rod has no thickness and may run through the stem or itself. The nucleotides
are then moved out of the way first."""
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
) -> tuple[Attempt, list[Turns]]:
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
    Attempt, list of Turns
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
    for turns, line_sd, out in _schedule(combinations, limits.tries):
        start = start_on(site, line, turns)
        shift = moved_out(site, start) if out else np.zeros_like(centers)
        relaxed = minimum(
            problem, centers + shift, line_sd, shifted(site, start, shift), limits.max_steps,
            max(end - time.monotonic(), 0.0),
        )  # fmt: skip
        checks = check(site, relaxed.positions_A, centers, start, relaxed.status)
        attempts.append(Attempt(turns, start, relaxed, checks))
        if sum(attempt.checks.sound for attempt in attempts) == limits.tries:
            break
        if time.monotonic() > end:
            break
    return min(attempts, key=lambda attempt: attempt.order), combinations


def _schedule(combinations: list[Turns], tries: int) -> Iterator[tuple[Turns, float, bool]]:
    """Combination, how near to the line, and whether nucleotides are moved out of the way first."""
    few = max(tries, 3)
    for chosen in (combinations[:few], combinations[few:]):
        for attempt, line_sd in enumerate(LINE_SD_A):
            for turns in chosen:
                yield turns, line_sd, attempt > 0
