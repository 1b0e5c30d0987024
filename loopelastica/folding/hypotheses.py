"""What a loop may look like: each answer a line with its shape, its place and its expected error.

Templates that a user names come first, then answers that differ in what they assume
(:meth:`.known.Known.answers`): loops of the same
sequence, motif or length, the rod by the rule, the rod in its surroundings, single loops of the
library. The other equilibria of one clamp differ from the first in their turns alone; they are
last.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from loopelastica._arrays import Array, Record
from loopelastica.errors import StructureError
from loopelastica.folding.choice import SAME_A
from loopelastica.folding.expected import largest_rmsd_A
from loopelastica.folding.known import (
    Answer,
    Known,
    known_shapes,
    library_at,
    rod_answers,
    usable_shapes,
)
from loopelastica.folding.library import Library
from loopelastica.folding.like import MOST, loop_templates
from loopelastica.folding.lines import POINTS_PER_NUCLEOTIDE, CandidateLine, RodLine, chain_lines
from loopelastica.folding.motifs import Motif, errors_of, motif_of, of_length, typical_spread_A
from loopelastica.folding.options import FoldOptions
from loopelastica.folding.surroundings import SURROUNDED, rods_among
from loopelastica.folding.template import Deformed, deformed
from loopelastica.molecule.clamp_rule import plain_clamp
from loopelastica.molecule.contacts import contacts
from loopelastica.molecule.ends import ClosingPoses, FittedStem, StemEnds
from loopelastica.molecule.hairpins import Hairpin
from loopelastica.molecule.identity import entries_of
from loopelastica.molecule.neighbours import Neighbours, neighbours
from loopelastica.molecule.nucleotides import Structure
from loopelastica.molecule.polymer import Monomer
from loopelastica.molecule.shapes import LoopShape, loop_shape
from loopelastica.molecule.trace import rmsd_A
from loopelastica.rod.equilibrium import Equilibrium

STRAIGHT: Final = "straight rod"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Hypothesis(Record):
    """One answer, not yet compared with others.

    Attributes
    ----------
    line : RodLine or ChainLine
        Between the ends of the stem.
    shape : str
        What it is, such as "motif GNRA, 130 loops" or "straight rod".
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


@dataclass(frozen=True, slots=True, eq=False)
class Scene(Record):
    """What all loops of a structure share, as far as the options ask for it.

    Attributes
    ----------
    others : Neighbours or None
        Atoms that a loop may run into.
    library : Library or None
        Shapes of loops.
    entries : tuple of str
        Entries of the databank that the structure may be; their shapes are not used.
    own : mapping of str to LoopShape
        Loops as the first model has them, by the names of their hairpins: for leaving them out of
        the library, and for nothing else.
    """

    others: Neighbours | None = None
    library: Library | None = None
    entries: tuple[str, ...] = ()
    own: Mapping[str, LoopShape] = field(default_factory=dict)


def scene_of(structure: Structure, hairpins: Iterable[Hairpin], options: FoldOptions) -> Scene:
    """What the options ask for beside the loop itself.

    Parameters
    ----------
    structure : Structure
        What was read.
    hairpins : iterable of Hairpin
        What was found in it.
    options : FoldOptions

    Returns
    -------
    Scene

    Raises
    ------
    LoopelasticaError
        If the library cannot be read.
    """
    if options.shapes == "rod":
        return Scene()
    return Scene(
        neighbours(structure) if options.surroundings else None,
        library_at(options.library),
        entries_of(structure),
        dict(_own_shapes(structure, hairpins)),
    )


def _own_shapes(
    structure: Structure, hairpins: Iterable[Hairpin]
) -> Iterator[tuple[str, LoopShape]]:
    positions = structure.positions(0)
    for hairpin in hairpins:
        # why a stem cannot be placed is said where it is folded
        with suppress(StructureError):
            made = loop_shape(structure.nucleotides, hairpin, positions)
            if made is not None:
                yield hairpin.name, made[0]


def hypotheses(
    hairpin: Hairpin,
    stem: FittedStem,
    ends: StemEnds,
    rods: Sequence[Equilibrium],
    stem_atoms: tuple[Array, Array],
    positions: Array,
    options: FoldOptions,
    scene: Scene,
) -> tuple[Hypothesis, ...]:
    """All answers for a loop.

    Parameters
    ----------
    hairpin : Hairpin
        Which loop; of its nucleotides only the sequence counts.
    stem : FittedStem
        Ideal strands on its stem.
    ends : StemEnds
        Ends of the rods.
    rods : sequence of Equilibrium
        Between them, least energy first.
    stem_atoms : (m, 3), (m,) array
        Atoms of the stem and their phases (:func:`loopelastica.molecule.contacts.stem_atoms`).
    positions : (n_atoms, 3) array
        All atoms of the model, Å.
    options : FoldOptions
        Those of :func:`loopelastica.fold`.
    scene : Scene
        What the structure has beside the loop.

    Returns
    -------
    tuple of Hypothesis
        In the default order.
    """
    straight = _free_first([RodLine(rod, ends) for rod in rods], stem_atoms)
    poses = stem.closing()
    atoms_A = _in_the_way(hairpin, straight[0], positions, scene)
    bent = [] if atoms_A is None else _surrounded(straight[0], atoms_A)
    known = _known(hairpin, poses, options, scene, atoms_A)
    lines = [*straight, *bent]
    answers = (
        _tabled(hairpin, poses, options, straight, bent)
        if known is None
        else known.answers(straight, bent)
    )
    n = len(hairpin)
    # the fit knows no geometry: a loop that is far from its shape may be said to err by anything
    largest_A = largest_rmsd_A(n, stem.ends(plain_clamp(hairpin.is_dna)).distance_A)
    found: list[Hypothesis] = []
    for one in _like(hairpin, poses, options):
        spread_A = _spread_A(known, one.line.trace, n)
        expected = np.minimum(one.errors.at(spread_A, one.line.energy, n), largest_A)
        found.append(Hypothesis(one.line, one.shape, expected, len(found), one.carried))
    for answer in answers:
        line = lines[answer.rod] if answer.line is None else answer.line
        spread_A = _spread_A(known, answer.trace_A, n)
        kind = answer.kind if known is not None else f"{answer.kind} alone"
        expected = np.minimum(errors_of(kind).at(spread_A, answer.energy, n), largest_A)
        found.append(Hypothesis(line, _called(answer), expected, len(found)))
    return tuple(found)


def _free_first(rods: list[RodLine], stem_atoms: tuple[Array, Array]) -> list[RodLine]:
    """The rods, the first one that touches nothing before all others."""
    near = (contacts(*rod.sampled(), *stem_atoms).touching for rod in rods)
    free = next((k for k, touching in enumerate(near) if not touching), 0)
    return [rods[free], *rods[:free], *rods[free + 1 :]]


def _like(hairpin: Hairpin, poses: ClosingPoses, options: FoldOptions) -> list[Deformed]:
    """The loops of the structure that a user names, before all else."""
    if options.like is None:
        return []
    templates = loop_templates(options.like, len(hairpin), options.limits)
    return deformed(templates, poses, hairpin.sequence, hairpin.is_dna)[:MOST]


def straight_rods(
    hairpin: Hairpin, rods: Sequence[Equilibrium], ends: StemEnds
) -> tuple[Hypothesis, ...]:
    """The equilibria of one clamp, where nothing else is asked for.

    Parameters
    ----------
    hairpin : Hairpin
        Which loop.
    rods : sequence of Equilibrium
        Lowest energy first.
    ends : StemEnds
        Where they are clamped.

    Returns
    -------
    tuple of Hypothesis
    """
    n = len(hairpin)
    spread_A = typical_spread_A(n)
    return tuple(
        Hypothesis(
            RodLine(rod, ends),
            STRAIGHT,
            errors_of("further rod alone" if k else "rod alone").at(spread_A, rod.energy, n),
            k,
        )
        for k, rod in enumerate(rods)
    )


def _called(answer: Answer) -> str:
    """What an answer is to its reader."""
    if answer.line is None:
        return SURROUNDED if answer.kind == SURROUNDED else STRAIGHT
    return answer.shape


def _known(
    hairpin: Hairpin,
    poses: ClosingPoses,
    options: FoldOptions,
    scene: Scene,
    atoms_A: Array | None,
) -> Known | None:
    if scene.library is None:
        return None
    table = usable_shapes(
        scene.library,
        hairpin,
        scene.entries,
        options.exclude_relatives,
        scene.own.get(hairpin.name),
    )
    return known_shapes(hairpin, poses, table, atoms_A)


def _tabled(
    hairpin: Hairpin,
    poses: ClosingPoses,
    options: FoldOptions,
    straight: Sequence[RodLine],
    bent: Sequence[RodLine],
) -> list[Answer]:
    """Answers without a library: the mean of the motif or the length, then the rods."""
    first, among = rod_answers(straight, bent)
    rods = [*first, *among]
    # whether its loops are relatives of this one nobody can say of a mean
    if options.shapes == "rod" or options.exclude_relatives:
        return rods
    motif = None if hairpin.is_dna else motif_of(hairpin.sequence)
    kind = "mean" if motif is None else f"motif {motif.name}"
    mean: Motif | None = motif or of_length(len(hairpin), hairpin.is_dna)
    (line,) = (None,) if mean is None else chain_lines([mean.shape], poses, hairpin.is_dna)
    if line is None:
        return rods
    answer = Answer(kind, line.trace, line.energy, line)
    return [rods[0], answer, *rods[1:]] if hairpin.is_dna else [answer, *rods]


def _spread_A(known: Known | None, trace_A: Array, n: int) -> float:
    return typical_spread_A(n) if known is None else known.spread_A(trace_A)


def _in_the_way(hairpin: Hairpin, free: RodLine, positions: Array, scene: Scene) -> Array | None:
    """What the line of a loop may run into; None where nothing but its own hairpin is near."""
    if scene.others is None:
        return None
    line_A = free.points(POINTS_PER_NUCLEOTIDE * free.ends.n_free + 1)
    return scene.others.around(hairpin, free.ends, line_A, positions)


def _surrounded(straight: RodLine, atoms_A: Array) -> list[RodLine]:
    """The rod of least energy among atoms; none where it is the straight rod."""
    ends = straight.ends
    (rod, *_) = rods_among(ends, atoms_A, straight.points(16 * ends.n_free + 1))
    line = RodLine(rod, ends)
    if not rod.converged or rmsd_A(line.trace, straight.trace) < SAME_A:
        return []
    return [line]
