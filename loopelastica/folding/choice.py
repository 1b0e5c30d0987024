"""Which of many loop shapes on one stem: a mean as first answer, then distinct ones.

    w_j ∝ 1/copies_j · exp(−a E_j/E_median − b s_j − c_j)

with E the energy of the deformation, s the distance of the sequences, c the atoms within 3.5 Å of a
point of the line, in the mean over its points, and a, b linear in the loop's length. Nothing that
was tried picks one shape better than this mean of all picks none (median over 274 loop sequences,
relatives left out: 2.9 Å; the shape of largest weight 3.7). Where the same loop sequence or its
motif is known, the mean is taken over these alone. Further answers cover what is likely: each is
the shape that most reduces the expected distance of the loop from the nearest answer, under weights
√w. The expected distance of the weighted shapes from an answer tells its error
(:mod:`.expected`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record
from loopelastica.folding.shape_table import rms_A

ENERGY: Final = (2.73, -0.48)
SEQUENCE: Final = (1.0, -0.13)
"""a and b at five nucleotides, and what each further one adds; of three to nine nucleotides."""
CONTACT_A: Final = 3.5
"""Backbones come no nearer to other heavy atoms than this: 0.02 atoms per point in loops."""
SAME_CLASS: Final = 0.6
"""Weight of a substitution that keeps purine or pyrimidine."""
SAME_A: Final = 0.25
"""Answers that are nearer to each other than this are one."""
POINTS: Final = 6
"""Points of a line per nucleotide at which atoms are counted."""
_CLOSING, _FIRST = 0.25, 1.5
_PURINES = np.frombuffer(b"AG", dtype=np.uint8)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Weighted(Record):
    """Loop shapes on one stem and what each weighs.

    Attributes
    ----------
    nodes_A : (k, n, 3) array
        Their loop nucleotides in one frame, Å.
    weights : (k,) array
        Sum 1.
    """

    nodes_A: Array
    weights: Array

    def among(self, rows: NDArray[np.bool_]) -> Weighted:
        """Some of them, (k,); the weights are scaled."""
        weights = self.weights[rows]
        total = weights.sum()
        # all of them can be in the way of something
        share = weights / total if total > 0.0 else np.full(len(weights), 1.0 / len(weights))
        return Weighted(self.nodes_A[rows], share)

    @property
    def mean_A(self) -> Array:
        """The weighted mean (n, 3), Å."""
        return np.asarray(np.tensordot(self.weights, self.nodes_A, axes=1))

    def distance_A(self, trace_A: Array) -> float:
        """Expected root mean square distance of a trace (n, 3) from the shapes, Å."""
        return float(self.weights @ rms_A(self.nodes_A, trace_A))


def sequence_distance(codes: NDArray[np.uint8], own: NDArray[np.uint8]) -> Array:
    """Distances s (k,) of loop sequences from one, closing nucleotides included.

    Parameters
    ----------
    codes : (k, n + 2) array of uint8
        Bases from closing to closing nucleotide in ASCII, T as U.
    own : (n + 2,) array of uint8
        Those of the loop.

    Returns
    -------
    (k,) array
        Substitutions: a quarter in the closing pair, 1.5 beside it, else one; 0.6 of that where
        purine or pyrimidine is kept.

    Examples
    --------
    >>> a, b, c = (np.frombuffer(s, dtype=np.uint8) for s in (b"CGAAAG", b"CGCAAG", b"GGAAAC"))
    >>> sequence_distance(np.array([a, b, c]), a).tolist()
    [0.0, 1.0, 0.5]
    """
    place = np.ones(codes.shape[1])
    place[[0, -1]], place[[1, -2]] = _CLOSING, _FIRST
    kept = np.isin(codes, _PURINES) == np.isin(own, _PURINES)
    return np.asarray(((codes != own) * np.where(kept, SAME_CLASS, 1.0)) @ place)


def weigh(
    energies: Array, distances: Array, copies: NDArray[np.int64], contacts: Array, n: int
) -> Array:
    """Weights w (k,) of deformed shapes.

    Parameters
    ----------
    energies : (k,) array
        E L/K0 of the deformation; inf for what could not be deformed.
    distances : (k,) array
        Of the sequences (:func:`sequence_distance`).
    copies : (k,) array
        How many shapes have the same loop sequence.
    contacts : (k,) array
        Atoms per point of the line.
    n : int
        Loop nucleotides.

    Returns
    -------
    (k,) array
        Sum 1; all zero where no shape could be deformed.
    """
    there = np.isfinite(energies)
    if not there.any():
        return np.zeros(len(energies))
    beyond = min(max(n, 3), 9) - 5
    a, b = (first + more * beyond for first, more in (ENERGY, SEQUENCE))
    scale = max(float(np.median(energies[there])), 1e-12)
    log = np.full(len(energies), -np.inf)
    log[there] = -a * energies[there] / scale - b * distances[there] - contacts[there]
    weights = np.exp(log - log.max()) / copies
    return np.asarray(weights / weights.sum())


def covering(weighted: Weighted, covered_A: Array | None, count: int) -> list[int]:
    """Shapes that cover what is likely, the most useful first.

    Parameters
    ----------
    weighted : Weighted
        Shapes to choose from.
    covered_A : (k,) array or None
        Distance of each from the nearest answer there is already; None where there is none.
    count : int
        How many at most.

    Returns
    -------
    list of int
        Rows, each with some weight; fewer where the others lie on answers that are there.
    """
    rows = np.flatnonzero(weighted.weights > 0.0)
    if not len(rows):
        return []
    likely = np.sqrt(weighted.weights[rows])
    between = _between(weighted.nodes_A[rows])
    nearest = np.full(len(rows), np.inf) if covered_A is None else covered_A[rows].copy()
    chosen: list[int] = []
    for _ in range(min(count, len(rows))):
        left = np.minimum(nearest, between) @ likely
        # what lies on an answer is none of its own
        left[nearest < SAME_A] = np.inf
        best = int(np.argmin(left))
        if not np.isfinite(left[best]):
            break
        chosen.append(best)
        nearest = np.minimum(nearest, between[best])
    return [int(rows[best]) for best in chosen]


def _between(nodes_A: Array) -> Array:
    """Root mean square distances (k, k) of shapes (k, n, 3) from each other."""
    k, n = nodes_A.shape[:2]
    # about their mean, so that squares of large numbers do not cancel
    flat = (nodes_A - nodes_A.mean(axis=0)).reshape(k, -1)
    square = (flat**2).sum(axis=1)
    squares = square[:, None] + square - 2.0 * flat @ flat.T
    return np.asarray(np.sqrt(np.maximum(squares, 0.0) / n))


def atoms_per_point(lines_A: Array, atoms_A: Array) -> Array:
    """How many of the atoms (a, 3) lie within 3.5 Å of a point, mean over each line (k, p, 3)."""
    from scipy.spatial import cKDTree

    if len(atoms_A) == 0 or len(lines_A) == 0:
        return np.zeros(len(lines_A))
    counts = cKDTree(atoms_A).query_ball_point(
        lines_A.reshape(-1, 3), CONTACT_A, return_length=True
    )
    return np.asarray(counts.reshape(lines_A.shape[:2]).mean(axis=1), dtype=np.float64)


def smooth_lines(nodes_A: Array) -> Array:
    """Points (k, p, 3) of smooth lines through nodes (k, n + 2, 3), loop nucleotides only, Å."""
    from scipy.interpolate import CubicSpline

    n = nodes_A.shape[1] - 2
    phases = np.linspace(1.0, n, POINTS * n)
    return np.asarray(CubicSpline(np.arange(n + 2), nodes_A, axis=1)(phases))
