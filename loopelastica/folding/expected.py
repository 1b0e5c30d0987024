"""The error to expect of a filled strand, from what is known of it blind.

    log(error + 0.05 Å) = b · (1, log n, log(1 + E), crowding, stretch, DNA) + a residual

with n nucleotides, E the elastic energy of its line (E L/K0), crowding the atoms within 10 Å of the
chord per nucleotide (in fifties, 3 at most), stretch the distance of the ends over the length. For
each class of length b is a least-squares fit to strands that were taken out of structures and
filled again, and the quantiles of the residual are those of entries that the fit had not seen
(:mod:`loopelastica.studies.strands.calibration` makes the table anew). The energy tells most up to
four nucleotides: ends that do not fit together; crowding and length tell more beyond.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from loopelastica._arrays import Array, read_only
from loopelastica.folding.line import StrandLine

SHIFT_A: Final = 0.05
STEP_A: Final = 7.0
"""Longest step along a backbone, as in :mod:`loopelastica.molecule.refusals`."""
CLASSES: Final = ((1, "1"), (2, "2"), (4, "3-4"), (9, "5-9"), (math.inf, "10-12"))
"""Lengths that are counted together: up to how many nucleotides, and their name."""

TABLE: Final[dict[str, tuple[tuple[float, ...], tuple[float, float, float]]]] = {
    # class: coefficients b, quantiles (10, 50, 90 %) of the residual
    "1": ((-0.408, 0.0, 0.184, -0.029, -0.798, -0.086), (-1.026, 0.026, 1.041)),
    "2": ((0.092, 0.0, 0.255, 0.011, -0.6, -0.037), (-0.564, -0.008, 0.623)),
    "3-4": ((0.104, 0.312, 0.258, -0.196, -0.216, -0.327), (-0.571, -0.001, 0.633)),
    "5-9": ((0.451, 0.526, 0.124, -0.473, -0.117, -0.296), (-0.634, 0.005, 0.692)),
    "10-12": ((1.574, 0.105, 0.18, -0.296, -0.225, 0.0), (-0.455, 0.032, 0.377)),
}


def expected_text(values: ArrayLike) -> str:
    """An expected error in a few characters: the median, and 80 % of cases.

    >>> expected_text([0.9, 2.1, 4.3])
    '2.1 (0.9–4.3)'
    """
    low, middle, high = np.asarray(values, dtype=np.float64)
    return f"{middle:.1f} ({low:.1f}–{high:.1f})"


def largest_rmsd_A(n: int, distance_A: float) -> float:
    """How far two loops between the same ends can lie from each other at most.

    Nucleotide k of both is within k − ½ steps of the one end and n − k + ½ of the other: in a lens.

    Parameters
    ----------
    n : int
        Nucleotides.
    distance_A : float
        Of the ends, half a nucleotide beyond the closing ones, Å.

    Returns
    -------
    float
        Root mean square of the lenses' diameters, Å.

    Examples
    --------
    >>> print(f"{largest_rmsd_A(3, 17.0):.1f} {largest_rmsd_A(3, 0.0):.1f}")
    9.1 13.4
    """
    place = np.arange(n) + 0.5
    near = STEP_A * np.minimum(place, n - place)
    far = STEP_A * n - near
    if distance_A <= far.min() - near.max():
        return float(np.sqrt((4.0 * near**2).mean()))
    # where the plane through the rim of a lens cuts the line of the ends, from the nearer end
    rim = (distance_A**2 + near**2 - far**2) / (2.0 * distance_A)
    radius = np.where(rim > 0.0, np.sqrt(np.maximum(near**2 - rim**2, 0.0)), near)
    return float(np.sqrt((4.0 * radius**2).mean()))


def length_class(n: int) -> str:
    """The name of the class of a length.

    >>> length_class(1), length_class(4), length_class(20)
    ('1', '3-4', '10-12')
    """
    return next(name for most, name in CLASSES if n <= most)


def signs(line: StrandLine, crowding: float) -> Array:
    """What is known of a strand without its answer: the factors of b, (6,)."""
    n, ends = line.ends.n, line.ends
    return np.array(
        [
            1.0,
            math.log(n),
            math.log1p(line.rod.energy),
            min(crowding / 50.0, 3.0),
            ends.distance_A / ends.length_A,
            float(ends.is_dna),
        ]
    )


def expected_rmsd(line: StrandLine, crowding: float) -> Array:
    """10, 50 and 90 % of the error of a strand's backbone centroids, Å.

    Beyond twelve nucleotides, where there was nothing to learn from, it is that of ten to twelve,
    in proportion to the number.

    Parameters
    ----------
    line : StrandLine
        The rod that the strand is built on.
    crowding : float
        Atoms within 10 Å of its chord, per nucleotide.

    Returns
    -------
    (3,) array
    """
    coefficients, quantiles = TABLE[length_class(line.ends.n)]
    middle = float(np.dot(coefficients, signs(line, crowding)))
    return read_only([max(math.exp(middle + q) - SHIFT_A, 0.0) for q in quantiles])
