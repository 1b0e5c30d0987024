"""Ideal single strands of A-RNA and B-DNA: six backbone atoms and the helix line through them.

B-DNA: fibre coordinates of Arnott & Hukins, Biochem. Biophys. Res. Commun. 47 (1972) 1504. Their
table lists the O3' of the nucleotide before (φ 97.4°, z 3.63 Å); one step further it is the own
one, 61.4°, 0.25 Å.

A-RNA: taken from a secondary source that names no origin. It is consistent in itself: the bonds
P–O5', O5'–C5' … and the O3'–P bond from one nucleotide to the next come out right.

Both strands run 5' to 3' with a *negative* turn and rise in the coordinates of these tables; with
the opposite signs O3' and the next P would be 10 Å apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from loopelastica._arrays import Array, Record


@dataclass(frozen=True, slots=True, eq=False)
class Strand(Record):
    """One ideal strand, its helix axis along z.

    Attributes
    ----------
    name : str
        What it is.
    atoms : (6, 3) array
        Radius (Å), angle (°) and height (Å) of P O5' C5' C4' C3' O3' of nucleotide 0.
    turn_deg, rise_A : float
        One step from a nucleotide to the next, 5' to 3'.
    length_per_nucleotide_A : float
        Length of line per nucleotide to be used for a loop. Measured on real stems (RNA 5.9–6.4 Å,
        DNA 6.3–6.6 Å), for the ideal B line is too short for real loops.
    fitted_nucleotides : int
        Number of stem nucleotides of one strand that place this ideal strand best.
    """

    name: str
    atoms: Array
    turn_deg: float
    rise_A: float
    length_per_nucleotide_A: float
    fitted_nucleotides: int


B_DNA: Final = Strand(
    name="B-DNA",
    atoms=np.array(
        [
            [8.91, 95.2, 2.08],
            [7.73, 88.0, 1.83],
            [7.70, 79.8, 2.77],
            [7.59, 69.9, 2.04],
            [8.20, 69.9, 0.64],
            [8.75, 61.4, 0.25],
        ]
    ),
    turn_deg=-36.0,
    rise_A=-3.38,
    length_per_nucleotide_A=6.3,
    fitted_nucleotides=2,
)

A_RNA: Final = Strand(
    name="A-RNA",
    atoms=np.array(
        [
            [8.71, 70.5, -3.75],
            [8.49, 60.1, -3.48],
            [9.75, 55.8, -3.35],
            [9.68, 46.9, -3.10],
            [8.86, 41.4, -4.02],
            [9.54, 40.1, -5.25],
        ]
    ),
    turn_deg=-32.7,
    rise_A=-2.81,
    length_per_nucleotide_A=6.0,
    fitted_nucleotides=1,
)

TAPER_ONSET: Final = 0.5
"""Nucleotides over which a taper sets in, from the closing nucleotide to the clamp of the loop."""


def ideal_strand(is_dna: bool) -> Strand:
    """B-DNA or A-RNA.

    >>> ideal_strand(is_dna=False).length_per_nucleotide_A
    6.0
    """
    return B_DNA if is_dna else A_RNA


def strand_atoms(strand: Strand, k: int) -> Array:
    """Cartesian positions (6, 3) of P O5' C5' C4' C3' O3' of nucleotide k, Å.

    Nucleotides count 5' to 3'; k may be negative.

    Parameters
    ----------
    strand : Strand
        Which ideal strand.
    k : int
        Number of the nucleotide, 5' to 3'; may be negative.

    Returns
    -------
    (6, 3) array

    Examples
    --------
    >>> o3, next_p = strand_atoms(B_DNA, 0)[5], strand_atoms(B_DNA, 1)[0]
    >>> print(f"{np.linalg.norm(next_p - o3):.2f}")
    1.59
    """
    radius, angle_deg, height = strand.atoms.T
    angle = np.deg2rad(angle_deg + k * strand.turn_deg)
    return np.stack(
        [radius * np.cos(angle), radius * np.sin(angle), height + k * strand.rise_A], axis=1
    )


def line_cylinder(strand: Strand) -> tuple[float, float, float]:
    """Radius (Å), angle (rad) and height (Å) of the centroid of nucleotide 0.

    >>> print("{:.2f} Å".format(line_cylinder(B_DNA)[0]))
    7.97 Å
    """
    x, y, z = strand_atoms(strand, 0).mean(axis=0)
    return float(np.hypot(x, y)), float(np.arctan2(y, x)), float(z)


def line_length_A(strand: Strand) -> float:
    """Length of the ideal helix line per nucleotide, Å.

    >>> print(f"{line_length_A(A_RNA):.2f} {line_length_A(B_DNA):.2f}")
    5.86 6.04
    """
    return float(np.hypot(line_cylinder(strand)[0] * np.deg2rad(strand.turn_deg), strand.rise_A))


def line_frame(strand: Strand, phase: float, taper: float = 0.0) -> tuple[Array, Array]:
    """Point and Darboux frame of the helix line through the centroids, or of its tapered form.

    The tapered line is the helix down to phase 0. Beyond, at k = −phase > 0 nucleotides from the
    3' closing one into the loop, its radius shrinks by `taper` of itself per nucleotide, a rate
    that sets in evenly over the first `TAPER_ONSET`. Turn and length of line per nucleotide stay
    those of the helix, so that the rise grows.

    Parameters
    ----------
    strand : Strand
        Which ideal strand.
    phase : float
        Place along the strand in nucleotides; whole numbers are centroids.
    taper : float
        Loss of radius per nucleotide, in units of the helix radius.

    Returns
    -------
    point_A : (3,) array
        Å.
    frame : (3, 3) array
        Columns d1 (towards the helix axis, at right angles to d3), d2 = d3 × d1, d3 (tangent,
        5' to 3').

    Raises
    ------
    ValueError
        If the tapered line has reached its own axis.

    Examples
    --------
    >>> for taper in (0.0, 0.2):
    ...     point = line_frame(A_RNA, -2.0, taper)[0]
    ...     height = point[2] - line_frame(A_RNA, 0.0)[0][2]
    ...     print(f"radius {np.hypot(*point[:2]):.1f} Å, {height:.1f} Å up")
    radius 9.0 Å, 5.6 Å up
    radius 5.9 Å, 6.9 Å up
    """
    radius, angle, height = line_cylinder(strand)
    turn = np.deg2rad(strand.turn_deg)
    beyond = max(-phase, 0.0)
    fraction, shrinking = _tapered_radius(beyond, taper)
    if fraction <= 0.0:
        raise ValueError(
            f"`taper` {taper:g} brings the strand to its own axis within {beyond:g} nucleotides"
        )
    c, s = np.cos(angle + phase * turn), np.sin(angle + phase * turn)
    outwards, around = np.array([c, s, 0.0]), np.array([-s, c, 0.0])
    point = radius * fraction * outwards
    point[2] = height + max(phase, 0.0) * strand.rise_A - _tapered_rise(strand, beyond, taper)
    d3 = radius * (shrinking * outwards + fraction * turn * around)
    d3[2] = _rise_rate(strand, fraction, shrinking)
    d3 /= np.linalg.norm(d3)
    d1 = (outwards @ d3) * d3 - outwards
    d1 /= np.linalg.norm(d1)
    return point, np.stack([d1, np.cross(d3, d1), d3], axis=1)


def _tapered_radius(beyond: float, taper: float) -> tuple[float, float]:
    """Radius in units of the helix radius, and what it loses per nucleotide."""
    early = min(beyond, TAPER_ONSET)
    lost = beyond - early + early**2 / (2.0 * TAPER_ONSET)
    return 1.0 - taper * lost, taper * early / TAPER_ONSET


def _rise_rate(strand: Strand, fraction: float, shrinking: float) -> float:
    """Rise per nucleotide (signed as that of the helix) that keeps the line's length, Å."""
    across = line_cylinder(strand)[0] * np.hypot(fraction * np.deg2rad(strand.turn_deg), shrinking)
    return float(np.copysign(np.sqrt(line_length_A(strand) ** 2 - across**2), strand.rise_A))


def _tapered_rise(strand: Strand, beyond: float, taper: float) -> float:
    """Rise (signed as that of the helix) over the first `beyond` tapered nucleotides, Å."""
    if taper == 0.0:
        return beyond * strand.rise_A
    nodes, weights = np.polynomial.legendre.leggauss(8)
    total = 0.0
    # the rate has a kink where the onset ends
    for low, high in ((0.0, min(beyond, TAPER_ONSET)), (TAPER_ONSET, max(beyond, TAPER_ONSET))):
        half = 0.5 * (high - low)
        rates = [_rise_rate(strand, *_tapered_radius(low + half * (1 + x), taper)) for x in nodes]
        total += half * float(weights @ rates)
    return total
