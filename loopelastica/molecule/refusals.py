"""What cannot be filled, and why: judged before anything is tried.

The distance that a strand must span is measured here from what the flanks have. Whoever places the
ends of a strand better asks :func:`check_span` again with that distance.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from loopelastica.molecule.chains import bonded
from loopelastica.molecule.components import BASES, is_standard
from loopelastica.molecule.nucleotides import enumerated
from loopelastica.molecule.numbering import NO_CODE
from loopelastica.molecule.polymer import Gap, Monomer

MOST_NUCLEOTIDES: Final = 30
"""Longest gap that is filled. Of 102 gaps of real entries the longest has 22; how well lines are
placed is known up to twelve."""
STEP_REACH_A: Final = 7.0
"""Most that a nucleotide spans, P to P: real strands have 5.0–6.4 Å of line each, and of 56 real
gaps the five that are wider than this are no strands of the length that the record says."""
REACH_ALLOWANCE_A: Final = 4.0
"""Added to it: the O3'–P bond (1.6 Å), a flank without its last atom, coordinates that err."""

MOST_SCRAPS: Final = 12
"""Most atoms of a nucleotide that is not there as a whole and lacks its backbone: the phosphate, a
part of the sugar, or the base."""


class Refusal(NamedTuple):
    """A gap that is not filled.

    Attributes
    ----------
    chain : str
    first, last : str
        Numbers, with insertion codes, of its first and last nucleotide.
    sequence : str
        Parent bases, "N" where unknown.
    reason : str
        One sentence.
    """

    chain: str
    first: str
    last: str
    sequence: str
    reason: str


def refusal(run: Sequence[Monomer], reason: str) -> Refusal:
    """Refuse a stretch of a chain.

    Parameters
    ----------
    run : sequence of Monomer
        Its nucleotides.
    reason : str
        One sentence.

    Returns
    -------
    Refusal
    """
    letters = "".join(one.letter for one in run)
    return Refusal(run[0].chain, run[0].place, run[-1].place, letters, reason)


def is_foreign(one: Monomer) -> bool:
    """Whether a modified nucleotide is there, but with names of its own for the backbone."""
    return len(one.atoms_A) > MOST_SCRAPS and not one.usable and not is_standard(one.resname)


def reason_against(gap: Gap) -> str | None:
    """Why a gap cannot be filled, in a sentence; None where nothing speaks against it."""
    n = len(gap)
    if n > MOST_NUCLEOTIDES:
        return f"{gap.name}: {n} nt are missing, and no more than {MOST_NUCLEOTIDES} are filled"
    foreign = [one.label for one in gap.monomers if is_foreign(one)]
    if foreign:
        return (
            f"{gap.name}: {enumerated(foreign)} is there with atoms of other names, so it can"
            " neither be built nor be an end"
        )
    unknown = [one.label for one in gap.monomers if one.letter not in BASES]
    if unknown:
        return f"{gap.name}: the base of {enumerated(unknown)} is not known, so it cannot be built"
    if any(one.icode == NO_CODE for one in gap.monomers):
        return f"{gap.name}: no numbers and insertion codes are left for {n} nt"
    distance = flank_distance_A(gap)
    if bonded(gap.before, gap.after):
        return (
            f"{gap.name}: {gap.before.label} and {gap.after.label} are bonded ({distance:.1f} Å),"
            f" so {n} nt cannot lie between them"
        )
    return check_span(gap, distance)


def flank_distance_A(gap: Gap) -> float:
    """From the last backbone atom before a gap to the first one after it, Å: O3' to P."""
    before = gap.before.backbone_A[::-1]
    after = gap.after.backbone_A
    ends = (rows[np.isfinite(rows).all(axis=1)][0] for rows in (before, after))
    return float(np.linalg.norm(next(ends) - next(ends)))


def check_span(gap: Gap, distance_A: float) -> str | None:
    """Whether a gap can be spanned.

    Parameters
    ----------
    gap : Gap
    distance_A : float
        Between its ends, O3' to P or about so.

    Returns
    -------
    str or None
        A sentence with both distances where it cannot; else None.
    """
    n = len(gap)
    reach_A = STEP_REACH_A * n + REACH_ALLOWANCE_A
    if distance_A <= reach_A:
        return None
    return f"{gap.name}: {n} nt cannot span {distance_A:.1f} Å: they reach {reach_A:.0f} Å"
