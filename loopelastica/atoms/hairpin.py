"""A hairpin from its sequence alone: the ideal stem with its loop folded."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from loopelastica._arrays import Array, Record
from loopelastica.atoms.chemistry import Residue, atom_names
from loopelastica.atoms.duplex import duplex, screwed
from loopelastica.atoms.fibre import fibre_nucleotide
from loopelastica.atoms.sequence import HairpinSequence
from loopelastica.errors import StructureError
from loopelastica.folding.fold import fold_model
from loopelastica.folding.hypotheses import Scene
from loopelastica.folding.known import library_at
from loopelastica.folding.options import FoldOptions
from loopelastica.folding.result import LoopFold
from loopelastica.folding.source import hairpin_source
from loopelastica.molecule.hairpins import Hairpin
from loopelastica.molecule.nucleotides import Structure, read_structure
from loopelastica.molecule.reading import quiet

CHAIN: Final = "A"
_DECIMALS: Final = 3


@dataclass(frozen=True, slots=True, eq=False)
class FoldedHairpin(Record):
    """An ideal stem with its loop folded.

    Attributes
    ----------
    sequence : HairpinSequence
    structure : Structure
        Stem and loop as a structure that was read; its loop nucleotides run on as a helix and mean
        nothing. Chain A, numbered from 1.
    fold : LoopFold
    positions_A : (n_atoms, 3) array
        Of the structure's atoms, Å; NaN for the loop.
    """

    sequence: HairpinSequence
    structure: Structure
    fold: LoopFold
    positions_A: Array


def fold_sequence(
    sequence: HairpinSequence, *, max_candidates: int = 10, phosphate: bool = False
) -> FoldedHairpin:
    """Ideal stem of a sequence with its loop folded.

    Parameters
    ----------
    sequence : HairpinSequence
        What was read.
    max_candidates : int
        Most candidates kept.
    phosphate : bool
        Put a phosphate at the 5' end.

    Returns
    -------
    FoldedHairpin
        With at least one candidate.

    Raises
    ------
    StructureError
        If the stem is not sound, or the loop cannot be folded.
    """
    structure, hairpin, positions = ideal_hairpin(sequence, phosphate)
    options = FoldOptions(max_candidates=max_candidates, all_models=False)
    # nothing but the loop's own stem is around, and no loop of a databank is this one
    scene = Scene(library=library_at(options.library))
    fold = fold_model(structure.nucleotides, hairpin, positions, options, scene)
    if fold.failure is not None:
        raise StructureError(fold.failure)
    source = hairpin_source(structure, positions, sequence.letters, str(sequence))
    return FoldedHairpin(sequence, structure, replace(fold, source=source), positions)


def ideal_hairpin(
    sequence: HairpinSequence, phosphate: bool = False
) -> tuple[Structure, Hairpin, Array]:
    """The ideal stem of a sequence, and the loop that is to be folded on it.

    Parameters
    ----------
    sequence : HairpinSequence
        What was read.
    phosphate : bool
        Put a phosphate at the 5' end.

    Returns
    -------
    structure, hairpin, positions_A
        As in :class:`FoldedHairpin`.
    """
    stem = duplex(sequence, phosphate)
    m, n = sequence.pairs, len(sequence.loop)
    names: list[str] = []
    resindex: list[int] = []
    positions: list[Array] = []
    for k, residue in enumerate(sequence.residues):
        atoms = _run_on(residue, k) if m <= k < m + n else stem.atoms(k)
        names += atoms
        resindex += [k] * len(atoms)
        positions += atoms.values()
    # as files have them: what is computed beside the stem and what is written are the same
    known = np.round(positions, _DECIMALS)
    structure = replace(
        read_structure(universe_of(sequence.residues, names, resindex, known)),
        name=str(sequence),
        remarks=tuple(_remarks(sequence, phosphate)),
    )
    table = structure.nucleotides
    rows = np.arange(m, m + n)
    hairpin = Hairpin(
        chain=CHAIN,
        name=f"{CHAIN}{m + 1}-{m + n}",
        closing_pair=(table.label(m - 1), table.label(m + n)),
        residues=tuple(table.label(int(k)) for k in rows),
        sequence=sequence.letters[m - 1 : m + n + 1],
        is_dna=sequence.is_dna,
        contacts=(),
        kissing=(),
        loop=rows,
        resid=rows + 1,
        icode=np.full(n, ""),
        stem_5=np.arange(m - 1, -1, -1),
        stem_3=np.arange(m + n, 2 * m + n),
    )
    known[np.isin(resindex, rows)] = np.nan
    return structure, hairpin, known


def _remarks(sequence: HairpinSequence, phosphate: bool) -> Iterator[str]:
    if sequence.mismatches:
        yield f"{', '.join(sequence.mismatches)} do not pair; they stand where they find room"
    if phosphate:
        yield "the 5' end has a phosphate"


def _run_on(residue: Residue, number: int) -> dict[str, Array]:
    """Atoms of a loop nucleotide, for which the 5' strand runs on."""
    fibre = fibre_nucleotide(residue.letter, residue.is_dna)
    # a methyl group, which the fibre lacks, is in no place that matters
    at = {name: fibre.get(name, fibre["C1'"]) for name in atom_names(residue)}
    return {name: screwed(place, number, residue.is_dna) for name, place in at.items()}


def universe_of(
    residues: Sequence[Residue], names: Sequence[str], resindex: Sequence[int], positions: Array
) -> Any:
    """A Universe of one chain.

    Parameters
    ----------
    residues : sequence of Residue
        Numbered from 1.
    names : sequence of str
        Of the atoms.
    resindex : sequence of int
        Residue of each atom, from 0.
    positions : (N, 3) array
        Å.

    Returns
    -------
    MDAnalysis.Universe
    """
    import MDAnalysis as mda

    elements = [name[0] for name in names]
    with quiet():
        universe = mda.Universe.empty(
            len(names), n_residues=len(residues), atom_resindex=resindex, trajectory=True
        )
        for attribute, values in {
            "name": names,
            "element": elements,
            "type": elements,
            # what the wwPDB calls a modified nucleotide
            "record_type": ["HETATM" if residues[k].methyls else "ATOM" for k in resindex],
            "chainID": [CHAIN] * len(names),
            "resname": [residue.standard for residue in residues],
            "resid": list(range(1, len(residues) + 1)),
            "segid": [CHAIN],
        }.items():
            universe.add_TopologyAttr(attribute, list(values))
        universe.atoms.positions = positions
    return universe
