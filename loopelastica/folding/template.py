"""Templates: strands of other structures deformed onto the ends at hand.

Of a hairpin loop the ends are by the whole stem, of any other strand by the nucleotide on each of
its sides. Several templates are ordered by how similar their sequence is, then by the energy of
their deformation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Record
from loopelastica.folding.choice import sequence_distance
from loopelastica.folding.lines import ChainLine, chain_lines
from loopelastica.folding.motifs import Errors, errors_of, motif_of
from loopelastica.folding.shape_table import letters_of
from loopelastica.molecule.ends import ClosingPoses
from loopelastica.molecule.polymer import Monomer
from loopelastica.molecule.templates import Template


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Deformed(Record):
    """A template on the ends of another strand.

    Attributes
    ----------
    template : Template
    line : ChainLine
        In the coordinates of these ends.
    alike : bool
        Whether it has the letters of the strand, or the motif that these have.
    """

    template: Template
    line: ChainLine
    alike: bool

    @property
    def shape(self) -> str:
        """What the line is called, such as "like 1zih A.4-A.9"."""
        return self.template.name

    @property
    def carried(self) -> tuple[Monomer, ...]:
        """The template's nucleotides where the line takes them; empty for a respaced one."""
        return self.template.carried(self.line.nodes_A, self.line.rotations, self.line.poses)

    @property
    def errors(self) -> Errors:
        """How far such a line is off: as one over the same sequence, or as any of a library."""
        return errors_of("same sequence" if self.alike else "library")

    def __repr__(self) -> str:
        return f"<Deformed {self.shape}: energy {self.line.energy:.3g}>"


def deformed(
    templates: Sequence[Template], poses: ClosingPoses, sequence: str, is_dna: bool
) -> list[Deformed]:
    """Templates of equal length deformed onto ends, the most similar first, then the least bent.

    Parameters
    ----------
    templates : sequence of Template
        Of n nucleotides each.
    poses : ClosingPoses
        Where the ideal strands have the nucleotides before and after.
    sequence : str
        Letters of the strand with the two beside it.
    is_dna : bool
        Kind of its ends.

    Returns
    -------
    list of Deformed
        Without those that cannot be deformed so far.
    """
    lines = chain_lines([template.shape for template in templates], poses, is_dna)
    found = [
        Deformed(template, line, _alike(template, sequence))
        for template, line in zip(templates, lines, strict=True)
        if line is not None
    ]
    own = letters_of(sequence)
    found.sort(key=lambda one: (_distance(one.template, own), one.line.energy))
    return found


def _distance(template: Template, own: NDArray[np.uint8]) -> float:
    """Of the sequences; those of another length are all alike."""
    letters = letters_of(template.shape.sequence)
    return float(sequence_distance(letters[None], own)[0]) if len(letters) == len(own) else 0.0


def _alike(template: Template, sequence: str) -> bool:
    letters, own = letters_of(template.shape.sequence), letters_of(sequence)
    if len(letters) != len(own):
        return False
    motif = motif_of(sequence)
    same_motif = motif is not None and bool(motif.matches(letters[None])[0])
    return same_motif or bool((letters[1:-1] == own[1:-1]).all())
