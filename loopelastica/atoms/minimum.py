"""The minimum next to a start: its stages, puckers and suites."""

from __future__ import annotations

import time
from collections.abc import Collection, Sequence
from typing import Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.atoms.checks import puckers
from loopelastica.atoms.geometry import PUCKERS_DEG, chiral_quads, everywhere
from loopelastica.atoms.relax import STAGES, Index, Relaxed, relax
from loopelastica.atoms.restraints import Problem
from loopelastica.atoms.site import Site
from loopelastica.atoms.suites import DELTA_DEG, MEANS_DEG, nearest, suite_torsions

LOOSE_LINE_SD_A: Final = 4.0
"""How near the centroids are held to the line where it stands in the way of sound atoms."""
TURNING_SD: Final = 0.1
"""How near torsions are held that have to turn into a cluster, rad."""
TURNING_LINE_SD_A: Final = 1.0
"""And the centroids to the line meanwhile."""


def minimum(
    problem: Problem,
    centers: Array,
    line_sd: float,
    start: Array,
    c2_endo: Sequence[bool],
    max_steps: int,
    max_seconds: float,
) -> Relaxed:
    """The minimum next to `start`, its sugars in one of the two usual puckers.

    Where no pucker is given, the loose stages show which of the two is nearer for each sugar. They
    also show which phosphates have turned over, whose free oxygens are put anew, and which cluster
    is nearest to each suite.

    Parameters
    ----------
    problem : Problem
        The strand's molecule and what is around.
    centers : (n, 3) array
        Points of the line that the backbone centroids are held to, Å.
    line_sd : float
        How near they are held, Å.
    start : (N, 3) array
        Positions to begin at, Å.
    c2_endo : sequence of bool
        Pucker of each nucleotide's sugar, else none.
    max_steps, max_seconds : int, float
        Limits of the minimization.

    Returns
    -------
    Relaxed
    """
    limit = time.monotonic() + max_seconds
    given = _given_puckers(problem, c2_endo)
    restraints = problem.restraints(centers, line_sd, start, given)
    loose = relax(restraints, problem.ordered(start), stages=STAGES[:2], max_seconds=max_seconds)
    place = problem.in_molecule(loose.positions_A)
    right_phosphates(problem.site, place)
    whole = problem.ordered(place)
    phases = np.where(np.isfinite(given), given, _near_puckers(whole, problem.rings))
    clusters, _ = _clusters(problem, whole, phases)
    strict = relax(
        problem.restraints(centers, line_sd, start, phases, clusters),
        whole,
        stages=STAGES[2:],
        max_steps=max_steps,
        max_seconds=max(limit - time.monotonic(), 0.0),
    )
    place = problem.in_molecule(strict.positions_A)
    return Relaxed(place, strict.status, loose.steps + strict.steps, strict.cost)


def mended(
    problem: Problem,
    centers: Array,
    relaxed: Relaxed,
    stress: Array,
    max_steps: int,
    max_seconds: float,
) -> Relaxed:
    """A minimum near to another one, the line nearly let go, some bonds and angles made stiffer.

    Parameters
    ----------
    problem : Problem
        The strand's molecule and what is around.
    centers : (n, 3) array
        Points of the line, Å.
    relaxed : Relaxed
        The other minimum.
    stress : (p,) array
        How many times stiffer.
    max_steps, max_seconds : int, float
        Limits of the minimization.

    Returns
    -------
    Relaxed
    """
    there = relaxed.positions_A
    whole = problem.ordered(there)
    phases = _near_puckers(whole, problem.rings)
    clusters, _ = _clusters(problem, whole, phases)
    again = relax(
        problem.restraints(centers, LOOSE_LINE_SD_A, there, phases, clusters, stress),
        whole,
        stages=STAGES[2:],
        max_steps=max_steps,
        max_seconds=max_seconds,
    )
    place = problem.in_molecule(again.positions_A)
    return Relaxed(place, again.status, relaxed.steps + again.steps, again.cost)


def _near_puckers(positions: Array, rings: Index) -> Array:
    """Of the two usual puckers the one next to each sugar's own, degrees."""
    phases = np.array([phase for phase, _ in puckers(positions, rings)])
    away = np.abs((phases[:, None] - np.array(PUCKERS_DEG) + 180.0) % 360.0 - 180.0)
    return np.asarray(np.array(PUCKERS_DEG)[away.argmin(axis=1)], dtype=np.float64)


def _given_puckers(problem: Problem, c2_endo: Sequence[bool]) -> Array:
    """Phases (s,) of the sugars whose pucker is given, degrees; NaN for others."""
    inside = (problem.ring_of >= 0) & (problem.ring_of < len(c2_endo))
    chosen = np.append(np.array(PUCKERS_DEG)[np.array(c2_endo, dtype=np.int64)], np.nan)
    return np.asarray(chosen[np.where(inside, problem.ring_of, -1)])


def _clusters(
    problem: Problem, positions: Array, phases_deg: Array, besides: Sequence[Collection[int]] = ()
) -> tuple[Array, list[int]]:
    """Torsions (u, 7) that each suite is to have, degrees, and the rows of their clusters.

    Those of the cluster that is nearest, of the puckers that its sugars have or are to have. δ
    follows from these and is left free.
    """
    torsions = suite_torsions(positions, problem.suites)
    held = np.full(torsions.shape, np.nan)
    rows = []
    for suite, (quads, found) in enumerate(zip(problem.suites, torsions, strict=True)):
        for place in (0, 6):
            # the third atom of C5' C4' C3' O3' says which sugar it is
            for ring in np.flatnonzero((problem.rings == quads[place, 2]).any(axis=1)):
                found[place] = DELTA_DEG[int(phases_deg[ring] > 90.0)]
        rows.append(nearest(found, besides[suite] if besides else ()))
        held[suite, 1:6] = MEANS_DEG[rows[-1], 1:6]
    return held, rows


def into_clusters(
    problem: Problem,
    centers: Array,
    relaxed: Relaxed,
    besides: Sequence[set[int]],
    turning: Sequence[bool],
    max_steps: int,
    max_seconds: float,
) -> Relaxed:
    """A minimum some of whose suites are turned into a cluster first.

    The chemistry is loose while they turn.

    Parameters
    ----------
    problem : Problem
        The strand's molecule and what is around.
    centers : (n, 3) array
        Points of the line, Å.
    relaxed : Relaxed
        Another minimum.
    besides : sequence of set of int
        Clusters that each suite has been turned to already; the one that it is turned to now is
        added.
    turning : sequence of bool
        Which of the suites turn; the others are held where they are nearest.
    max_steps, max_seconds : int, float
        Limits of the minimization.

    Returns
    -------
    Relaxed
    """
    limit = time.monotonic() + max_seconds
    there = relaxed.positions_A
    whole = problem.ordered(there)
    phases = _near_puckers(whole, problem.rings)
    clusters, rows = _clusters(problem, whole, phases, besides)
    for suite, (row, out) in enumerate(zip(rows, turning, strict=True)):
        if out:
            besides[suite].add(row)
    loose = problem.restraints(
        centers, TURNING_LINE_SD_A, there, phases, clusters, suite_sd=TURNING_SD
    )
    turned = relax(loose, whole, stages=STAGES[1:2], max_seconds=max_seconds)
    strict = relax(
        problem.restraints(centers, TURNING_LINE_SD_A, there, phases, clusters),
        turned.positions_A,
        stages=STAGES[2:],
        max_steps=max_steps,
        max_seconds=max(limit - time.monotonic(), 0.0),
    )
    place = problem.in_molecule(strict.positions_A)
    return Relaxed(place, strict.status, relaxed.steps + turned.steps + strict.steps, strict.cost)


def right_phosphates(site: Site, positions: Array) -> None:
    """Put oxygens of phosphates anew, in place, where they have the wrong hand or none.

    Parameters
    ----------
    site : Site
    positions : (N, 3) array
        Rows of its molecule, Å.
    """
    molecule = site.molecule
    quads, volumes = chiral_quads(molecule)
    for quad, volume in zip(quads, volumes, strict=True):
        residue = molecule.residue[quad[0]]
        o5_row = molecule.rows.get((residue, "O5'"))
        if molecule.names[quad[0]] != "P" or o5_row is None:
            continue
        p, o3, op1, op2 = positions[quad]
        if (o3 - p) @ np.cross(op1 - p, op2 - p) > 0.5 * volume:
            continue
        u, v = (o3 - p) / np.linalg.norm(o3 - p), (positions[o5_row] - p)
        v = v / np.linalg.norm(v)
        outward, across = -(u + v), np.cross(u, v)
        outward = outward / np.linalg.norm(outward)
        across = across / np.linalg.norm(across)
        # half the ideal OP1–P–OP2 angle to either side of the plane of O3', P and O5'
        half = np.deg2rad(0.5 * everywhere("OP1", "P", "OP2"))
        for row, side in ((quad[2], 1.0), (quad[3], -1.0)):
            if site.moving[row]:
                direction = np.cos(half) * outward + side * np.sin(half) * across
                positions[row] = p + everywhere("P", "OP1") * direction
