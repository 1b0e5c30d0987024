"""Atoms on the lines of a strand: the first that are sound."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

from numpy.typing import ArrayLike

from loopelastica._arrays import Array
from loopelastica.atoms.carry import Line
from loopelastica.atoms.strand import StrandModel, build_strand
from loopelastica.folding.line import StrandLine, strand_lines
from loopelastica.molecule.polymer import Gap, HeavyAtoms
from loopelastica.molecule.strand_ends import StrandEnds, strand_ends
from loopelastica.molecule.strands import ideal_strand

SPARE: Final = 4
"""Lines that are tried where no model on the first one is sound."""
LONGER: Final = (1.15, 1.3)
"""Then the first line of longer rods is: times their length."""
MAX_SECONDS: Final = 10.0
"""Time after which no more is tried on one line."""


def strand_models(
    gap: Gap, ends: StrandEnds, atoms: HeavyAtoms, most: int = 1
) -> list[tuple[StrandLine, StrandModel]]:
    """Lines of a strand with atoms on them: sound models first, then the order of the lines.

    Parameters
    ----------
    gap : Gap
        What is built.
    ends : StrandEnds
        Where its line begins and ends.
    atoms : HeavyAtoms
        All that is there.
    most : int
        How many at most.

    Returns
    -------
    list of (StrandLine, StrandModel)

    Raises
    ------
    StructureError
        If no line was found, or a base is unknown.
    """
    lines = strand_lines(gap, ends, atoms, max(most, SPARE))
    models = [(line, _on(line, gap, atoms)) for line in lines[:most]]
    if not any(model.checks.sound for _, model in models):
        for line in _others(lines[most:], gap, ends, atoms):
            models.append((line, _on(line, gap, atoms)))
            if models[-1][1].checks.sound:
                break
    return sorted(models, key=lambda pair: not pair[1].checks.sound)[:most]


def _others(
    left: Sequence[StrandLine], gap: Gap, ends: StrandEnds, atoms: HeavyAtoms
) -> Iterator[StrandLine]:
    """Lines to be tried where no model on the first ones is sound: other minima, longer rods."""
    yield from left
    for factor in LONGER:
        yield strand_lines(gap, replace(ends, length_A=factor * ends.length_A), atoms)[0]


def _on(line: StrandLine, gap: Gap, atoms: HeavyAtoms) -> StrandModel:
    """Atoms on a line."""
    is_dna = sum(monomer.is_dna for monomer in gap.monomers) > len(gap) / 2
    between = Line.between(line.rod, line.ends, ideal_strand(is_dna))
    return build_strand(gap, _InFile(between, line.ends), atoms, max_seconds=MAX_SECONDS)


def first_model(gap: Gap, atoms: HeavyAtoms) -> StrandModel:
    """The first model of a strand.

    Parameters
    ----------
    gap : Gap
        What is built.
    atoms : HeavyAtoms
        All that is there.

    Returns
    -------
    StrandModel

    Raises
    ------
    StructureError
        As :func:`strand_models`, or if an end cannot be placed.
    """
    return strand_models(gap, strand_ends(gap), atoms)[0][1]


class _InFile:
    """A line of a start frame in the coordinates of the file."""

    def __init__(self, line: Line, ends: StrandEnds) -> None:
        self._line, self._ends = line, ends

    def at(self, phases: ArrayLike) -> tuple[Array, Array]:
        """Points (m, 3), Å, and frames (m, 3, 3) at the phases (m,)."""
        points, frames = self._line.at(phases)
        start = self._ends.start_frame
        return points @ start.T + self._ends.start_origin_A, start @ frames
