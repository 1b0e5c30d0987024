"""What a loop may look like: each answer a line with its shape, its place and its expected error.

An answer is a chain that remembers a motif, a template or a shape of a library, or a rod. The other
equilibria of one clamp differ from the first in their turns, not in what they assume; they come
last.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from loopelastica._arrays import Array, Record, read_only
from loopelastica.folding.expected import expected_like
from loopelastica.folding.like import MOST, loop_templates
from loopelastica.folding.lines import CandidateLine, RodLine
from loopelastica.folding.options import FoldOptions
from loopelastica.folding.surroundings import SURROUNDED, rods_among
from loopelastica.folding.template import deformed
from loopelastica.molecule.clamp_rule import expected_rmsd_A
from loopelastica.molecule.ends import ClosingPoses, StemEnds
from loopelastica.molecule.hairpins import Hairpin
from loopelastica.molecule.polymer import Monomer
from loopelastica.molecule.trace import rmsd_A
from loopelastica.rod.equilibrium import Equilibrium

LIKE_PLACE: Final = 0
"""Place of the templates that a user gives: before all else."""
SURROUNDED_PLACE: Final = 100
"""Place of the rod in its surroundings: after the shapes, which have those from 0 on."""
SAME_A: Final = 0.25
"""A rod that its surroundings move by less is no answer of its own."""
ROD_PLACE: Final = 200
"""Place of the rods by the rule, which their energies order."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Hypothesis(Record):
    """One answer, not yet compared with others.

    Attributes
    ----------
    line : RodLine or ChainLine
        Between the ends of the stem.
    shape : str
        What it is, such as "motif GNRA" or "straight rod".
    expected_rmsd_A : (3,) array
        10, 50 and 90 % of its error, Å.
    place : int
        In the default order, from 0; equal ones are ordered by energy.
    carried : tuple of Monomer
        Nucleotides of a template where the line takes them, in the coordinates of the file; empty
        where there is none.
    """

    line: CandidateLine
    shape: str
    expected_rmsd_A: Array
    place: int
    carried: tuple[Monomer, ...] = ()

    def __repr__(self) -> str:
        return f"<Hypothesis {self.place}: {self.shape}>"


def hypotheses(
    hairpin: Hairpin, poses: ClosingPoses, options: FoldOptions
) -> tuple[Hypothesis, ...]:
    """The shapes that a loop may have taken over, deformed onto its stem.

    Parameters
    ----------
    hairpin : Hairpin
        Which loop; of its nucleotides only the sequence counts.
    poses : ClosingPoses
        Where the ideal strands have the closing nucleotides.
    options : FoldOptions
        Those of :func:`loopelastica.fold`.

    Returns
    -------
    tuple of Hypothesis
        In the default order; none where nothing is known of such a loop.
    """
    return () if options.like is None else like_templates(hairpin, poses, options)


def like_templates(
    hairpin: Hairpin, poses: ClosingPoses, options: FoldOptions
) -> tuple[Hypothesis, ...]:
    """The loops of another structure, of equal length or respaced, deformed onto a stem.

    Parameters
    ----------
    hairpin, poses, options
        As for :func:`hypotheses`; `options.like` is not None.

    Returns
    -------
    tuple of Hypothesis
        The most similar ones first; none where no loop of that file fits.

    Raises
    ------
    StructureError
        If the file cannot be read, or has no such loop, or none that is whole on a regular stem.
    """
    assert options.like is not None
    templates = loop_templates(options.like, len(hairpin), options.limits)
    found = deformed(templates, poses, hairpin.sequence, hairpin.is_dna)
    return tuple(
        Hypothesis(
            one.line,
            one.shape,
            expected_like(len(hairpin), one.identity),
            LIKE_PLACE + k,
            one.carried,
        )
        for k, one in enumerate(found[:MOST])
    )


def straight_rods(
    hairpin: Hairpin, rods: Sequence[Equilibrium], ends: StemEnds, is_rule: bool = True
) -> tuple[Hypothesis, ...]:
    """The equilibria of one clamp.

    Parameters
    ----------
    hairpin : Hairpin
        Which loop.
    rods : sequence of Equilibrium
        Lowest energy first.
    ends : StemEnds
        Where they are clamped.
    is_rule : bool
        Whether that is the clamp of the rule.

    Returns
    -------
    tuple of Hypothesis
    """
    return tuple(
        Hypothesis(
            RodLine(rod, ends),
            "straight rod",
            rods_expected(hairpin, is_rule and k == 0),
            ROD_PLACE,
        )
        for k, rod in enumerate(rods)
    )


def surrounded_rod(
    hairpin: Hairpin, ends: StemEnds, free: Equilibrium, atoms_A: Array
) -> tuple[Hypothesis, ...]:
    """The rod of least energy among atoms; none where it is the straight rod.

    Parameters
    ----------
    hairpin : Hairpin
        Which loop.
    ends : StemEnds
        Where it is clamped.
    free : Equilibrium
        The straight rod of least energy.
    atoms_A : (m, 3) array
        What is in its way, Å.

    Returns
    -------
    tuple of Hypothesis
        One or none.
    """
    straight = RodLine(free, ends)
    (rod, *_) = rods_among(ends, atoms_A, straight.points(16 * ends.n_free + 1))
    line = RodLine(rod, ends)
    if not rod.converged or rmsd_A(line.trace, straight.trace) < SAME_A:
        return ()
    return (Hypothesis(line, SURROUNDED, rods_expected(hairpin, True), SURROUNDED_PLACE),)


def rods_expected(hairpin: Hairpin, is_rule: bool) -> Array:
    """10, 50 and 90 % of the error to expect of a rod, (3,), Å.

    Parameters
    ----------
    hairpin : Hairpin
        Which loop.
    is_rule : bool
        Whether it is the rod of least energy in the clamp of the rule.
    """
    median, most = expected_rmsd_A(len(hairpin))
    expected = [0.6 * median, median, most]
    return read_only(expected if is_rule else [1.5 * value for value in expected])
