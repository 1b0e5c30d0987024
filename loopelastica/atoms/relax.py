"""Restored chemistry (step iv): least squares of ideal geometry with all that is there held fixed.

Every term is a residual over its standard deviation: bond lengths, angles (as distances of the two
outer atoms), signed volumes (chirality, and planarity where the volume is zero), torsions (α γ ζ
staggered, suites of RNA in a cluster: :mod:`.suites`), overlap of atoms nearer than they may be,
distance of each nucleotide's backbone centroid from the line, and a weak tether of every atom to
where the line had carried it.
The tethers make the minimum a smooth function of the input.

rdkit's force fields were tried in its place, with the stem fixed and the backbone held near the
line, on the first candidates of 2KOC, 1BJH, 1AC7, 1JUR, 1KR8 and 1HLX. Share of bonds within 0.05 Å
and of angles within 6° of the values of :mod:`.ideal`:

    MMFF94 98.5 % and 98.7 % (rms 0.019 Å, 2.0°)    UFF 79.6 % and 85.3 % (0.061 Å, 4.3°)
    these residuals 100 % and 99.6 % (0.001 Å, 0.9°)

MMFF94 restores sugar and phosphate much better than UFF, which makes O3'–P 0.11 Å too long and
turns hands over; neither reaches 99 % of the bonds, for their equilibrium values are not those of
nucleotides in crystals.

The sum is minimized in stages (:data:`STAGES`). In the first ones the chemistry is loose and
overlap is cheap, so that atoms pass through one another and the chain closes; then both are
tightened. The kernels (:mod:`.kernels`) are imported when the first sum is minimized.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record

if TYPE_CHECKING:
    from loopelastica.atoms.kernels.terms import Terms

Index = NDArray[np.int64]


class Status(IntEnum):
    """How a minimization ended."""

    CONVERGED = 0
    STEPS = 1
    TIME = 2


MESSAGES: Final = {
    Status.CONVERGED: "converged",
    Status.STEPS: "the limit of steps was reached",
    Status.TIME: "the limit of time was reached",
}


@dataclass(frozen=True, slots=True)
class Stage:
    """Weights of one minimization.

    Attributes
    ----------
    chemistry, hands : float
        Standard deviations of lengths and angles, and of volumes, over their own.
    overlap_sd, floor_sd : float
        Of atoms nearer than they like to be, and than they may be, Å.
    tolerance : float
        Largest component of the gradient at the end, 1/Å.
    steps : int
        Most steps of an early stage; the last one has the caller's limit.
    """

    chemistry: float
    hands: float
    overlap_sd: float
    floor_sd: float
    tolerance: float
    steps: int


STAGES: Final = (
    Stage(6.0, 2.0, 1.5, 1.5, 3.0, 150),
    Stage(3.0, 1.0, 0.4, 0.4, 3.0, 150),
    Stage(1.5, 1.0, 0.15, 0.08, 3.0, 200),
    Stage(1.0, 1.0, 0.10, 0.02, 1e-3, 0),
)
"""From loose to strict. A tolerance of 1e-3 leaves atoms within 0.004 Å of the minimum, along what
nothing but the tether holds."""
_LONGEST_A: Final = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class Restraints:
    """Terms over N atoms, of which the first `n_moving` move.

    Attributes
    ----------
    n_moving : int
    pairs, length_A, length_sd : (p, 2), (p,), (p,) array
        Distances: bonds and angles.
    quads, volume, volume_sd : (q, 4), (q,), (q,) array
        (b − a) · (c − a) × (d − a) in Å³ for atoms a b c d.
    torsions, torsion_fold, torsion_at, torsion_sd : (t, 4), (t,), (t,), (t,) array
        Torsions a–b–c–d, rad, how many places on the circle they like, one of these, and how near
        they are held to it.
    groups, center_A, center_sd : (g, m), (g, 3), float
        Centroids held to points.
    tether_A, tether_sd : (n_moving, 3), (n_moving,) array
        Places the atoms are held to, and how near.
    least_A, floor_A : (n_moving, N) array
        Distance that two atoms like to keep, and that they must; 0 where there is none.
    """

    n_moving: int
    pairs: Index
    length_A: Array
    length_sd: Array
    quads: Index
    volume: Array
    volume_sd: Array
    torsions: Index
    torsion_fold: Array
    torsion_at: Array
    torsion_sd: Array
    groups: Index
    center_A: Array
    center_sd: float
    tether_A: Array
    tether_sd: Array
    least_A: Array
    floor_A: Array

    def terms(self, stage: Stage) -> Terms:
        """The arrays of the kernel at one stage."""
        from loopelastica.atoms.kernels.terms import Terms

        loose = stage.chemistry
        return Terms(
            self.pairs,
            self.length_A,
            (loose * self.length_sd) ** -2.0,
            self.quads,
            self.volume,
            (stage.hands * self.volume_sd) ** -2.0,
            self.torsions,
            self.torsion_fold,
            self.torsion_at,
            self.torsion_sd**-2.0,
            self.groups,
            self.center_A,
            self.center_sd**-2.0,
            self.tether_A,
            self.tether_sd**-2.0,
            self.least_A,
            self.floor_A,
            stage.overlap_sd**-2.0,
            stage.floor_sd**-2.0,
        )


@dataclass(frozen=True, slots=True, eq=False)
class Relaxed(Record):
    """Result: positions (N, 3), status, steps and the final sum of squares by kind of term."""

    positions_A: Array
    status: Status
    steps: int
    cost: dict[str, float]

    @property
    def message(self) -> str:
        """The status in words."""
        return MESSAGES[self.status]


def relax(
    restraints: Restraints,
    start_A: Array,
    *,
    stages: Sequence[Stage] = STAGES[-1:],
    max_steps: int = 5000,
    max_seconds: float = 30.0,
) -> Relaxed:
    """Minimize from `start_A` (N, 3); atoms from `n_moving` on stay where they are.

    Parameters
    ----------
    restraints : Restraints
    start_A : (N, 3) array
    stages : sequence of Stage
        One minimization each, from loose to strict.
    max_steps : int
        Most steps of the last stage.
    max_seconds : float
        Wall time after which no further piece is begun; the result then depends on the machine.

    Returns
    -------
    Relaxed
    """
    from loopelastica.atoms.kernels.lbfgs import descend

    limit = time.monotonic() + max_seconds
    x = np.array(start_A, dtype=np.float64)
    listed = np.empty((60 * restraints.n_moving + 1000, 2), dtype=np.int64)
    status, steps = Status.STEPS, 0
    for stage in stages:
        terms = restraints.terms(stage)
        left = stage.steps or max_steps
        while left > 0:
            if time.monotonic() > limit:
                return Relaxed(x, Status.TIME, steps, cost(restraints, x))
            # pieces, so that the clock is looked at
            piece = min(left, 1000)
            took, _, largest = descend(x, terms, listed, piece, _LONGEST_A, stage.tolerance)
            if took < 0:
                listed = np.empty((2 * len(listed), 2), dtype=np.int64)
                continue
            steps += took
            left -= piece
            if took < piece:
                break
        status = Status.CONVERGED if largest <= stage.tolerance else Status.STEPS
    return Relaxed(x, status, steps, cost(restraints, x))


def cost(restraints: Restraints, x: Array, stage: Stage = STAGES[-1]) -> dict[str, float]:
    """The sum of squares at x (N, 3) by kind of term."""
    r, terms = restraints, restraints.terms(stage)
    apart = np.linalg.norm(x[r.pairs[:, 0]] - x[r.pairs[:, 1]], axis=1)
    a, b, c, d = (x[r.quads[:, column]] for column in range(4))
    volume = ((b - a) * np.cross(c - a, d - a)).sum(axis=1)
    away = (x[r.groups].mean(axis=1) - r.center_A) / r.center_sd
    tethers = (x[: r.n_moving] - r.tether_A) / r.tether_sd[:, None]
    turned = np.sin(0.5 * r.torsion_fold * (_torsions(x, r.torsions) - r.torsion_at))
    return {
        "lengths_and_angles": float(terms.pair_weight @ (apart - r.length_A) ** 2),
        "overlaps": _overlap(x, r.least_A) * terms.least_weight
        + _overlap(x, r.floor_A) * terms.floor_weight,
        "chirality_and_planarity": float(terms.quad_weight @ (volume - r.volume) ** 2),
        "torsions": float(((2.0 * turned / (r.torsion_fold * r.torsion_sd)) ** 2).sum()),
        "line": float((away**2).sum()),
        "tethers": float((tethers**2).sum()),
    }


def _overlap(x: Array, least: Array) -> float:
    from scipy.spatial.distance import cdist

    square = cdist(x[: len(least)], x, "sqeuclidean")
    later = np.arange(len(x)) > np.arange(len(least))[:, None]
    rows, columns = np.nonzero((square < least**2) & later)
    r = least[rows, columns]
    return float((((r * r - square[rows, columns]) / (2.0 * r)) ** 2).sum())


def _torsions(x: Array, quads: Index) -> Array:
    a, b, c, d = (x[quads[:, column]] for column in range(4))
    u, axis, v = b - a, c - b, d - c
    m, n = np.cross(u, axis), np.cross(axis, v)
    length = np.linalg.norm(axis, axis=1)
    return np.asarray(np.arctan2(length * (u * n).sum(axis=1), (m * n).sum(axis=1)))
