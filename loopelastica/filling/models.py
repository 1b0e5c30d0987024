"""Atoms on the lines of a strand: the first that are sound."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

from numpy.typing import ArrayLike

from loopelastica._arrays import Array
from loopelastica.atoms.carry import ChainCurve, Curve, Line
from loopelastica.atoms.strand import StrandModel, build_strand
from loopelastica.folding.known import Known
from loopelastica.folding.line import StrandLine, strand_lines
from loopelastica.folding.shape_line import ShapeLine, library_lines, like_lines
from loopelastica.molecule.ends import ClosingPoses
from loopelastica.molecule.polymer import Gap, HeavyAtoms
from loopelastica.molecule.strand_ends import StrandEnds, strand_ends
from loopelastica.molecule.strands import ideal_strand
from loopelastica.molecule.templates import Template

SPARE: Final = 4
"""Lines that are tried where no model on the first one is sound."""
LONGER: Final = (1.15, 1.3)
"""Then the first line of longer rods is: times their length."""
MAX_SECONDS: Final = 10.0
"""Time after which no more is tried on one line."""


def strand_models(
    gap: Gap,
    ends: StrandEnds,
    atoms: HeavyAtoms,
    most: int = 1,
    templates: Sequence[Template] = (),
    known: Known | None = None,
) -> list[tuple[StrandLine | ShapeLine, StrandModel]]:
    """Lines of a strand with atoms on them: sound models first, then the order of the lines.

    Templates come before all else, which is tried where they leave something to be wished.

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
    templates : sequence of Template
        Of as many nucleotides.
    known : Known or None
        What a library knows of it.

    Returns
    -------
    list of (StrandLine or ShapeLine, StrandModel)

    Raises
    ------
    StructureError
        If no line was found, or a base is unknown.
    """
    models: list[tuple[StrandLine | ShapeLine, StrandModel]] = [
        (line, _on(line, gap, atoms)) for line in like_lines(gap, ends, atoms, templates, known)
    ]
    sound = sum(model.checks.sound for _, model in models)
    if sound < most:
        models += _without_template(gap, ends, atoms, most - sound, known)
    return sorted(models, key=lambda pair: not pair[1].checks.sound)[:most]


def _without_template(
    gap: Gap, ends: StrandEnds, atoms: HeavyAtoms, most: int, known: Known | None
) -> list[tuple[StrandLine | ShapeLine, StrandModel]]:
    """Rods in their surroundings and what a library knows, with atoms; more where none is sound."""
    rods = strand_lines(gap, ends, atoms, max(most, SPARE))
    lines: Sequence[StrandLine | ShapeLine] = (
        rods if known is None else library_lines(gap, ends, atoms, known, rods)
    )
    models = [(line, _on(line, gap, atoms)) for line in lines[:most]]
    if not any(model.checks.sound for _, model in models):
        for line in _others(lines[most:], gap, ends, atoms):
            models.append((line, _on(line, gap, atoms)))
            if models[-1][1].checks.sound:
                break
    return models


def _others(
    left: Sequence[StrandLine | ShapeLine], gap: Gap, ends: StrandEnds, atoms: HeavyAtoms
) -> Iterator[StrandLine | ShapeLine]:
    """Lines to be tried where no model on the first ones is sound: those left, longer rods."""
    yield from left
    for factor in LONGER:
        yield strand_lines(gap, replace(ends, length_A=factor * ends.length_A), atoms)[0]


def _on(line: StrandLine | ShapeLine, gap: Gap, atoms: HeavyAtoms) -> StrandModel:
    """Atoms on a line; on a template from its own where it has as many nucleotides."""
    strand = ideal_strand(sum(monomer.is_dna for monomer in gap.monomers) > len(gap) / 2)
    if isinstance(line, ShapeLine):
        curve = _InFile(ChainCurve.of(line.chain, strand), line.chain.poses)
        return build_strand(gap, curve, atoms, templates=line.carried, max_seconds=MAX_SECONDS)
    curve = _InFile(Line.between(line.rod, line.ends, strand), line.ends)
    return build_strand(gap, curve, atoms, max_seconds=MAX_SECONDS)


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

    def __init__(self, line: Curve, ends: StrandEnds | ClosingPoses) -> None:
        self._line, self._ends = line, ends

    def at(self, phases: ArrayLike) -> tuple[Array, Array]:
        """Points (m, 3), Å, and frames (m, 3, 3) at the phases (m,)."""
        points, frames = self._line.at(phases)
        start = self._ends.start_frame
        return points @ start.T + self._ends.start_origin_A, start @ frames
