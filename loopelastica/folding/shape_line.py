"""Lines of a strand that have the shape of others: of a template, or of a library's loops.

    gap ─flanks→ poses ─templates, library→ elastic chains on them ─→ lines, best first

A library holds hairpin loops. What it knows counts for a strand whose ends are like those of a
hairpin loop: where its shapes need little energy to come there.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Final

from scipy.spatial import cKDTree

from loopelastica._arrays import Array, Record, read_only
from loopelastica.folding.expected import expected_rmsd
from loopelastica.folding.known import Known, known_shapes, usable_shapes
from loopelastica.folding.library import Library
from loopelastica.folding.like import MOST
from loopelastica.folding.line import StrandLine
from loopelastica.folding.lines import ChainLine
from loopelastica.folding.motifs import errors_of, typical_spread_A
from loopelastica.folding.template import deformed
from loopelastica.molecule.obstacles import crowding, obstacles
from loopelastica.molecule.polymer import Gap, HeavyAtoms, Monomer
from loopelastica.molecule.strand_ends import StrandEnds, flank_poses
from loopelastica.molecule.templates import Template, counted

MOST_BENT: Final = 3.0
"""Least energy E·L/K0 of a library's shapes on ends that are like those of a hairpin loop: 61 of 62
loops that were taken out of structures have less, and 67 of 148 other strands. Beyond it further
candidates from the library gain little."""
FEWEST: Final = 10
"""Shapes from which on how far they lie from a line says how far it is off."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ShapeLine(Record):
    """The shape of another strand between the two ends of this one, in place of a rod.

    Attributes
    ----------
    chain : ChainLine
        It, in the coordinates of the file.
    shape : str
        What it is, such as "like 1zih A.4-A.9" or "motif GNRA, 130 loops".
    expected_rmsd_A : (3,) array
        10, 50 and 90 % of its error, Å.
    carried : tuple of Monomer
        A template's nucleotides where the line takes them; empty where there are no atoms.
    nearest_A : float or None
        Distance of the nearest atom from the line; None where there is none.
    nearest_atom : str
        That atom, such as "A.G12 C5'"; "" where there is none.
    """

    chain: ChainLine
    shape: str
    expected_rmsd_A: Array
    carried: tuple[Monomer, ...]
    nearest_A: float | None
    nearest_atom: str

    @property
    def trace(self) -> Array:
        """Its node for each nucleotide (n, 3) in the coordinates of the file, Å."""
        return read_only(self.chain.trace)

    @property
    def energy_per_A(self) -> float:
        """Energy of the deformation over the bending rigidity, E/K0, in 1/Å."""
        return self.chain.energy / self.chain.length_A

    @property
    def contact_energy_per_A(self) -> None:
        """None: its surroundings do not bend it."""

    @property
    def stable(self) -> bool | None:
        """Whether it is a local minimum of the energy."""
        return self.chain.stable

    @property
    def residual(self) -> float:
        """Error of the solution, by an evaluation that the solver did not use."""
        return self.chain.residual

    def __repr__(self) -> str:
        return f"<ShapeLine {self.shape}: E/K0 {self.energy_per_A:.3g} 1/Å>"


@dataclass(frozen=True, slots=True)
class _Loop:
    """A strand as the loop that its flanking nucleotides would close."""

    sequence: str
    is_dna: bool

    def __len__(self) -> int:
        return len(self.sequence) - 2


def known_strand(
    gap: Gap,
    ends: StrandEnds,
    atoms: HeavyAtoms,
    library: Library,
    entries: Collection[str] = (),
) -> Known | str:
    """What a library knows of a strand.

    Parameters
    ----------
    gap : Gap
        What is missing.
    ends : StrandEnds
        Where a rod in its place begins and ends.
    atoms : HeavyAtoms
        All of the model.
    library : Library
        Loop shapes.
    entries : collection of str
        Entries of the databank that the structure may be: their shapes are left out.

    Returns
    -------
    Known or str
        Or why it knows nothing.
    """
    loop = _Loop(gap.context, ends.is_dna)
    table = usable_shapes(library, loop, entries)
    if not len(table):
        return f"the library has no other loop of {counted(len(gap))}"
    in_the_way_A = atoms.positions_A[obstacles(gap, ends, atoms)]
    known = known_shapes(loop, flank_poses(gap.before, gap.after), table, in_the_way_A)
    if known is None or known.energies.min() > MOST_BENT:
        return "its ends are not like those of a hairpin loop"
    return known


def like_lines(
    gap: Gap,
    ends: StrandEnds,
    atoms: HeavyAtoms,
    templates: Sequence[Template],
    known: Known | None = None,
) -> tuple[ShapeLine, ...]:
    """Templates of a strand deformed onto its ends, the most similar first.

    Parameters
    ----------
    gap : Gap
        What they stand for.
    ends : StrandEnds
        The ends of a rod in their place.
    atoms : HeavyAtoms
        All of the model.
    templates : sequence of Template
        Of as many nucleotides.
    known : Known or None
        What a library knows of it.

    Returns
    -------
    tuple of ShapeLine
        The first few; none that cannot be deformed so far.
    """
    if not templates:
        return ()
    found = deformed(templates, flank_poses(gap.before, gap.after), gap.context, ends.is_dna)[:MOST]
    near = _Near(gap, ends, atoms)
    return tuple(
        ShapeLine(
            one.line,
            one.shape,
            one.errors.at(_spread_A(known, one.line), one.line.energy, len(gap)),
            one.carried,
            *near.to(one.line),
        )
        for one in found
    )


def library_lines(
    gap: Gap, ends: StrandEnds, atoms: HeavyAtoms, known: Known, rods: Sequence[StrandLine]
) -> list[StrandLine | ShapeLine]:
    """Rods of a strand and what a library knows of it, the best first.

    Of the mean and the first rod the one comes first that has the smaller error to expect: of 58
    hairpin loops that were taken out of structures the mean is before the rod in 45 and better in
    36 of these, after it in 13 and better in one.

    Parameters
    ----------
    gap : Gap
        What they stand for.
    ends : StrandEnds
        The ends of the rods.
    atoms : HeavyAtoms
        All of the model.
    known : Known
        What a library knows of it.
    rods : sequence of StrandLine
        In their order; at least one.

    Returns
    -------
    list of StrandLine or ShapeLine
    """
    answers = known.answers(rods)
    near = _Near(gap, ends, atoms)
    lines: list[StrandLine | ShapeLine] = []
    for answer in answers:
        chain = answer.line
        if chain is None:
            lines.append(rods[answer.rod])
            continue
        errors = errors_of(answer.kind)
        expected = errors.at(_spread_A(known, chain), answer.energy, len(gap))
        lines.append(ShapeLine(chain, answer.shape, expected, (), *near.to(chain)))
    if "library" not in {answer.kind for answer in answers[:2]}:
        crowded = crowding(ends, near.atoms_A)
        lines[:2] = sorted(lines[:2], key=lambda line: expected_error(line, crowded)[1])
    return lines


def expected_error(line: StrandLine | ShapeLine, crowded: float) -> Array:
    """10, 50 and 90 % of the error of a line's backbone centroids, (3,), Å.

    Parameters
    ----------
    line : StrandLine or ShapeLine
        What the strand is built on.
    crowded : float
        Atoms within 10 Å of its chord, per nucleotide.
    """
    return line.expected_rmsd_A if isinstance(line, ShapeLine) else expected_rmsd(line, crowded)


def _spread_A(known: Known | None, line: ChainLine) -> float:
    """Expected distance of a line from the strand; from few shapes that cannot be told."""
    if known is None or len(known.table) < FEWEST:
        return typical_spread_A(len(line))
    return known.spread_A(line.trace)


class _Near:
    """The atoms that a line may come near to."""

    def __init__(self, gap: Gap, ends: StrandEnds, atoms: HeavyAtoms) -> None:
        self._atoms, self._rows = atoms, obstacles(gap, ends, atoms)
        self.atoms_A = atoms.positions_A[self._rows]
        self._tree = cKDTree(self.atoms_A)

    def to(self, line: ChainLine) -> tuple[float | None, str]:
        """Distance and label of the nearest one."""
        if not len(self._rows):
            return None, ""
        apart, which = self._tree.query(line.sampled()[0])
        return float(apart.min()), self._atoms.label(self._rows[which[apart.argmin()]])
