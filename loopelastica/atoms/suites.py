"""Backbone of RNA from sugar to sugar (suites), and the clusters in which nature has them.

A suite is δ ε ζ of one nucleotide and α β γ δ of the next. The consensus clusters, the ranges of
each torsion and the half widths are those of Richardson, Schneider, Murray et al., RNA 14 (2008)
465, doi:10.1261/rna.657708, with the means of the program suitename (version 070506 of its
averages), read in ``suiteninit.h`` and ``suitename.c`` of the public project rlabduke/suitename;
"wannabe" clusters count. A suite is inside where a cluster of its puckers and γ is nearer than 1 in
all seven torsions, each over its half width, in the norm of power 3.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.atoms.measures import torsion_deg

TORSIONS: Final = (
    ((0, "C5'"), (0, "C4'"), (0, "C3'"), (0, "O3'")),
    ((0, "C4'"), (0, "C3'"), (0, "O3'"), (1, "P")),
    ((0, "C3'"), (0, "O3'"), (1, "P"), (1, "O5'")),
    ((0, "O3'"), (1, "P"), (1, "O5'"), (1, "C5'")),
    ((1, "P"), (1, "O5'"), (1, "C5'"), (1, "C4'")),
    ((1, "O5'"), (1, "C5'"), (1, "C4'"), (1, "C3'")),
    ((1, "C5'"), (1, "C4'"), (1, "C3'"), (1, "O3'")),
)
"""Four atoms of δ ε ζ α β γ δ; 0 is the first nucleotide, 1 the next."""

HALF_WIDTHS_DEG: Final = (28.0, 60.0, 55.0, 50.0, 70.0, 35.0, 28.0)
_POWER: Final = 3.0
_RANGES_DEG: Final = {1: (155.0, 310.0), 2: (25.0, 335.0), 3: (25.0, 335.0), 4: (50.0, 290.0)}
DELTA_DEG: Final = (84.0, 147.0)
"""δ of C3'-endo and of C2'-endo sugars: means over the clusters."""
_DELTA_RANGES_DEG: Final = ((60.0, 105.0), (125.0, 165.0))
_GAMMA_RANGES_DEG: Final = ((20.0, 95.0), (140.0, 215.0), (260.0, 335.0))

CLUSTERS: Final[dict[str, tuple[float, ...]]] = {
    # C3'-endo to C3'-endo
    "1a": (81.5, 212.3, 288.8, 295.0, 174.0, 53.6, 81.0),
    "1m": (83.5, 218.1, 291.6, 292.2, 222.3, 58.1, 86.1),
    "1L": (85.7, 245.0, 268.3, 303.9, 138.2, 62.0, 79.5),
    "&a": (82.1, 190.7, 264.9, 296.0, 181.8, 51.5, 81.5),
    "7a": (83.4, 217.4, 222.0, 302.9, 160.7, 49.1, 82.4),
    "3a": (85.1, 216.3, 173.3, 289.3, 164.1, 45.9, 85.0),
    "9a": (83.2, 210.3, 121.5, 288.6, 157.3, 49.3, 81.0),
    "1g": (80.9, 218.6, 290.7, 167.4, 159.6, 51.3, 85.2),
    "7d": (83.9, 238.8, 256.9, 69.6, 170.2, 52.8, 85.3),
    "3d": (85.3, 244.1, 203.8, 65.9, 181.1, 54.7, 86.0),
    "5d": (79.7, 202.5, 63.1, 68.2, 143.5, 49.7, 82.8),
    "3g": (84.0, 195.0, 146.0, 170.0, 170.0, 52.0, 84.0),
    "1e": (80.5, 200.5, 280.5, 249.3, 82.7, 167.9, 85.5),
    "1c": (80.2, 196.6, 291.3, 153.1, 194.4, 179.1, 83.6),
    "1f": (81.4, 203.0, 294.4, 172.2, 138.5, 175.6, 84.5),
    "5j": (87.4, 223.6, 80.2, 66.7, 109.2, 176.5, 83.8),
    "5n": (86.1, 246.5, 100.4, 73.6, 213.8, 183.4, 85.5),
    # C3'-endo to C2'-endo
    "1b": (84.2, 215.0, 288.7, 300.4, 177.5, 58.3, 144.8),
    "1[": (82.7, 220.5, 288.7, 297.0, 221.7, 54.2, 143.8),
    "3b": (84.7, 226.4, 168.3, 292.8, 177.6, 48.6, 148.0),
    "1z": (83.4, 206.0, 277.6, 195.7, 161.6, 50.8, 145.3),
    "5z": (82.6, 206.4, 52.5, 163.7, 148.4, 50.2, 147.6),
    "7p": (84.3, 236.6, 220.4, 68.3, 200.1, 53.7, 145.7),
    "5p": (84.5, 213.3, 69.1, 75.5, 156.7, 57.5, 147.7),
    "1t": (81.2, 199.2, 289.0, 180.3, 194.7, 178.2, 147.4),
    "5q": (82.1, 204.9, 69.5, 63.4, 115.2, 176.3, 145.7),
    "1o": (84.0, 216.5, 287.2, 297.3, 225.2, 293.7, 150.7),
    "7r": (84.6, 232.9, 248.1, 63.3, 182.0, 295.7, 149.7),
    "5r": (83.0, 196.9, 65.4, 60.2, 138.4, 292.6, 154.3),
    # C2'-endo to C3'-endo
    "2a": (145.4, 260.3, 288.8, 288.4, 192.7, 53.1, 84.1),
    "4a": (146.3, 259.8, 170.0, 298.5, 169.6, 50.9, 84.0),
    "0a": (149.3, 223.2, 139.4, 284.6, 158.1, 47.9, 84.4),
    "#a": (148.0, 191.9, 146.2, 289.3, 150.8, 42.4, 85.0),
    "4g": (148.0, 256.9, 165.2, 205.0, 165.2, 49.4, 83.0),
    "6g": (145.3, 262.9, 79.6, 203.9, 189.7, 58.0, 84.9),
    "8d": (149.0, 270.6, 240.9, 62.2, 176.3, 53.6, 87.3),
    "4d": (149.8, 250.0, 187.7, 80.4, 198.1, 61.0, 89.4),
    "6d": (146.9, 241.2, 88.9, 59.3, 160.7, 52.3, 83.4),
    "2g": (141.9, 258.4, 286.5, 178.3, 165.2, 48.4, 84.8),
    "2h": (147.8, 260.7, 290.4, 296.2, 177.3, 175.6, 86.6),
    "4n": (143.7, 227.3, 203.8, 73.9, 216.7, 194.4, 80.9),
    "0i": (148.7, 274.7, 100.3, 80.6, 248.1, 181.8, 82.6),
    "6n": (150.3, 268.4, 85.0, 63.8, 191.5, 176.6, 85.6),
    "6j": (141.6, 244.1, 66.1, 71.7, 122.2, 182.2, 83.6),
    "0k": (149.1, 249.8, 111.5, 278.4, 207.8, 287.8, 86.7),
    # C2'-endo to C2'-endo
    "2[": (146.4, 259.4, 291.3, 292.0, 210.0, 54.4, 147.8),
    "4b": (145.3, 244.6, 162.8, 294.2, 171.6, 45.9, 145.8),
    "0b": (147.6, 248.4, 112.1, 274.9, 164.8, 56.8, 146.3),
    "4p": (150.1, 260.2, 213.8, 71.9, 207.6, 56.7, 148.1),
    "6p": (146.4, 257.8, 89.6, 67.9, 173.1, 55.5, 147.6),
    "2z": (142.9, 236.6, 268.8, 180.8, 185.1, 54.5, 143.4),
    "4s": (149.9, 247.6, 170.5, 277.9, 84.4, 176.4, 148.1),
    "2u": (143.9, 258.2, 298.2, 279.6, 183.7, 183.1, 145.1),
    "2o": (147.3, 256.5, 295.5, 287.4, 194.5, 293.7, 150.5),
}  # fmt: skip
"""Means of δ ε ζ α β γ δ, degrees."""

MEANS_DEG: Final = np.array(list(CLUSTERS.values()))
_NAMES: Final = tuple(CLUSTERS)


def suite_torsions(positions: Array, quads: NDArray[np.int64]) -> Array:
    """Torsions of suites, degrees in [0, 360).

    Parameters
    ----------
    positions : (N, 3) array
        Å.
    quads : (u, 7, 4) array of int
        Rows.

    Returns
    -------
    (u, 7) array
    """
    found = [[torsion_deg(*positions[quad]) for quad in suite] for suite in quads]
    return np.array(found).reshape(-1, 7) % 360.0


def suite_name(torsions_deg: Array) -> str | None:
    """The cluster of a suite.

    Parameters
    ----------
    torsions_deg : (7,) array
        δ ε ζ α β γ δ, degrees.

    Returns
    -------
    str or None
        None outside all of them.

    Examples
    --------
    The A helix, and γ in a place where it is never found:

    >>> suite_name([81, 212, 289, 295, 174, 54, 81]), suite_name([81, 212, 289, 295, 174, 120, 81])
    ('1a', None)
    """
    found = np.asarray(torsions_deg, dtype=np.float64) % 360.0
    kind = _class(found)
    if kind is None:
        return None
    same = [row for row in range(len(MEANS_DEG)) if _class(MEANS_DEG[row]) == kind]
    away = distances(found)[same]
    if len(same) == 0 or away.min() > 1.0:
        return None
    return _NAMES[same[int(away.argmin())]]


def distances(torsions_deg: Array, which: slice = slice(None)) -> Array:
    """Distance (54,) of a suite from each cluster, in half widths.

    Parameters
    ----------
    torsions_deg : (7,) array
        Degrees.
    which : slice
        Those of the seven that count.

    Returns
    -------
    (54,) array
    """
    off = (np.asarray(torsions_deg) - MEANS_DEG + 180.0) % 360.0 - 180.0
    scaled = np.abs(off / np.array(HALF_WIDTHS_DEG))[:, which]
    return np.asarray((scaled**_POWER).sum(axis=1) ** (1.0 / _POWER))


def nearest(torsions_deg: Array, besides: Collection[int] = ()) -> int:
    """The row in `MEANS_DEG` of the cluster next to a suite, of the same puckers.

    Parameters
    ----------
    torsions_deg : (7,) array
        Degrees; both δ within 40° of one of the two puckers.
    besides : collection of int
        Rows that are left out.

    Returns
    -------
    int
    """
    away = distances(torsions_deg, slice(1, 6))
    for place in (0, 6):
        away = np.where(np.abs(MEANS_DEG[:, place] - torsions_deg[place]) < 40.0, away, np.inf)
    away[list(besides)] = np.inf
    return int(away.argmin())


def _class(torsions_deg: Array) -> tuple[int, int, int] | None:
    """Puckers and γ of a suite; None where a torsion is out of its range."""
    for place, (low, high) in _RANGES_DEG.items():
        if not low <= torsions_deg[place] <= high:
            return None
    found = tuple(
        next((k for k, (low, high) in enumerate(ranges) if low <= torsions_deg[place] <= high), -1)
        for place, ranges in (
            (0, _DELTA_RANGES_DEG),
            (6, _DELTA_RANGES_DEG),
            (5, _GAMMA_RANGES_DEG),
        )
    )
    return None if -1 in found else (found[0], found[1], found[2])
