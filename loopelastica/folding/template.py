"""Templates: strands of other structures deformed onto the ends at hand.

Of a hairpin loop the ends are by the whole stem, of any other strand by the nucleotide on each of
its sides. Several templates are ordered by how similar their sequence is, then by the energy of
their deformation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from loopelastica._arrays import Record
from loopelastica.folding.lines import ChainLine, chain_lines
from loopelastica.molecule.ends import ClosingPoses
from loopelastica.molecule.polymer import Monomer
from loopelastica.molecule.templates import Template

PURINES: Final = "AG"
# weights of a letter that differs: closing pair, first and last of the loop, others; and of one
# that is of the same kind still
_CLOSING, _OUTER, _INNER, _SAME_KIND = 0.25, 1.5, 1.0, 0.6


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Deformed(Record):
    """A template on the ends of another strand.

    Attributes
    ----------
    template : Template
    line : ChainLine
        In the coordinates of these ends.
    identity : float
        Share of the strand's letters that are the template's; 0 where the numbers differ.
    """

    template: Template
    line: ChainLine
    identity: float

    @property
    def shape(self) -> str:
        """What the line is called, such as "like 1zih A.4-A.9"."""
        return self.template.name

    @property
    def carried(self) -> tuple[Monomer, ...]:
        """The template's nucleotides where the line takes them; empty for a respaced one."""
        return self.template.carried(self.line.nodes_A, self.line.rotations, self.line.poses)

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
        Deformed(template, line, _identity(template, sequence))
        for template, line in zip(templates, lines, strict=True)
        if line is not None
    ]
    found.sort(key=lambda one: (difference(one.template.shape.sequence, sequence), one.line.energy))
    return found


def difference(a: str, b: str) -> float:
    """How different two sequences are, closing nucleotides included; those of other lengths alike.

    >>> difference("CGAAAG", "CGAAAG"), difference("CGCAAG", "CGAAAG"), difference("C", "CG")
    (0.0, 1.0, 0.0)
    """
    if len(a) != len(b):
        return 0.0
    n, total = len(a), 0.0
    for k, (x, y) in enumerate(zip(a.replace("T", "U"), b.replace("T", "U"), strict=True)):
        weight = _CLOSING if k in (0, n - 1) else _OUTER if k in (1, n - 2) else _INNER
        kept = (x in PURINES) == (y in PURINES)
        total += 0.0 if x == y else weight * (_SAME_KIND if kept else 1.0)
    return total


def _identity(template: Template, sequence: str) -> float:
    own, other = template.shape.sequence[1:-1], sequence[1:-1].replace("T", "U")
    if len(own) != len(other):
        return 0.0
    return sum(a == b for a, b in zip(own, other, strict=True)) / len(own)
