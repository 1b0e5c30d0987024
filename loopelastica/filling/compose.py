"""The changes that a filling makes in its file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Final

from loopelastica._arrays import Array
from loopelastica._files import PROGRAM
from loopelastica._version import __version__
from loopelastica.atoms.strand import BuiltResidue
from loopelastica.filling.hydrogens import hydrogenated
from loopelastica.report.compose import AddedResidue, Changes, Composed, Removed, compose
from loopelastica.report.pdb import b_factor

if TYPE_CHECKING:
    from loopelastica.atoms.strand import StrandModel
    from loopelastica.filling.result import Filling, Repair

OCCUPANCY: Final = 0.01
"""Marks what was modelled: not zero, which means that nothing is known."""
COMPLETED_A: Final = 1.0
"""Error to expect of atoms that a nucleotide lacked."""


def composed(filling: Filling, rank: int = 1) -> Composed:
    """The text of the filled structure, and its format.

    Parameters
    ----------
    filling : Filling
        What was filled.
    rank : int
        Which candidate of each strand; the last one where a strand has fewer.

    Returns
    -------
    Composed
    """
    changes = changes_of(filling, rank)
    return compose(filling.entry.text, filling.entry.kind, changes)


def changes_of(filling: Filling, rank: int = 1) -> Changes:
    """What is added and left out in the file.

    Parameters
    ----------
    filling : Filling
        What was filled.
    rank : int
        As for :func:`composed`.

    Returns
    -------
    Changes
        None at all where nothing is added, moved or left out: the file stays as it is, remarks too.
    """
    changes, _ = hydrogenated(filling, rank, _built(filling, rank), OCCUPANCY)
    if not changes:
        return Changes()
    return replace(changes, notes=tuple(_notes(filling, rank)), software=(PROGRAM, __version__))


def hydrogen_remarks(filling: Filling) -> tuple[str, ...]:
    """What is to be said of hydrogens and 5' phosphates.

    Parameters
    ----------
    filling : Filling
        What was filled.

    Returns
    -------
    tuple of str
        One sentence each.
    """
    return hydrogenated(filling, 1, _built(filling, 1), OCCUPANCY)[1]


def _built(filling: Filling, rank: int) -> Changes:
    """What changes by strands, completions and repairs."""
    added: list[AddedResidue] = []
    removed: list[Removed] = []
    for strand in filling.filled:
        candidate = strand.candidates[min(rank, len(strand.candidates)) - 1]
        model, index = candidate.atoms, strand.model - 1
        added += _added(model, index, b_factor(float(candidate.expected_rmsd_A[1])))
        removed += (
            Removed(index, m.chain, m.number, m.icode, m.resname) for m in model.gap.replaces
        )
        removed += candidate.waters
    for completion in filling.completions:
        added += _added(completion.atoms, completion.model - 1, b_factor(COMPLETED_A))
        removed += completion.waters
    moved: dict[tuple[int, str, int, str, str], Array] = {}
    for repair in filling.repairs:
        _repaired(repair, moved, added)
        removed += (*repair.waters, *repair.hydrogens)
    return Changes(
        added=tuple(added),
        moved=moved,
        moved_occupancy=OCCUPANCY,
        moved_b_factor_A2=b_factor(COMPLETED_A),
        removed=tuple(dict.fromkeys(removed)),
    )


def _added(
    model: StrandModel, index: int, b: float, residues: Sequence[BuiltResidue] | None = None
) -> Iterator[AddedResidue]:
    """The built atoms of a strand, or some of them, nucleotide by nucleotide."""
    gap = model.gap
    chain = [gap.before, *gap.monomers, gap.after]
    before = {id(monomer): other for other, monomer in pairwise(chain)}
    for residue in model.residues if residues is None else residues:
        monomer = residue.monomer
        other = before.get(id(monomer))
        yield AddedResidue(
            model=index,
            chain=monomer.chain,
            number=monomer.number,
            icode=monomer.icode,
            resname=name_of(residue),
            after=None if other is None else (other.chain, other.number, other.icode),
            names=residue.names,
            elements=residue.elements,
            positions_A=residue.positions_A,
            occupancy=OCCUPANCY,
            b_factor_A2=b,
            record=monomer.record,
        )


def _repaired(
    repair: Repair,
    moved: dict[tuple[int, str, int, str, str], Array],
    added: list[AddedResidue],
) -> None:
    """Atoms of a stretch built anew: most were there, some may have been missing."""
    index = repair.model - 1
    there = {one.label: one.atoms_A for one in repair.original}
    lacked: list[BuiltResidue] = []
    for residue in repair.residues:
        one = residue.monomer
        new = [k for k, name in enumerate(residue.names) if name not in there.get(one.label, {})]
        for k in set(range(len(residue.names))).difference(new):
            place = index, one.chain, one.number, one.icode, residue.names[k]
            moved[place] = residue.positions_A[k]
        if new:
            names, elements = ([of[k] for k in new] for of in (residue.names, residue.elements))
            lacked.append(
                BuiltResidue(
                    one, residue.kind, tuple(names), tuple(elements), residue.positions_A[new]
                )
            )
    added += _added(repair.atoms, index, b_factor(COMPLETED_A), lacked)


def name_of(residue: BuiltResidue) -> str:
    """What a nucleotide with built atoms is called: the parent's name where that was built."""
    monomer = residue.monomer
    renamed = not monomer.atoms_A and residue.kind.renamed
    return residue.kind.standard if renamed else monomer.resname


def _notes(filling: Filling, rank: int) -> Iterator[str]:
    """What the file says of itself."""
    source = filling.entry.name
    yield (
        f"{PROGRAM} {__version__} modelled the atoms of occupancy {OCCUPANCY:.2f}. Their B factor"
        " is 8 pi^2/3 of the expected error squared."
    )
    digest = filling.sha256
    yield f"Input: {source}" + (f", SHA-256 {digest}" if digest else "")
    many = len({strand.model for strand in filling.strands}) > 1
    for strand in filling.strands:
        model = f"model {strand.model}: " if many else ""
        if strand.status == "refused":
            yield f"{model}{strand.name} {strand.sequence}: not filled"
            continue
        candidate = strand.candidates[min(rank, len(strand.candidates)) - 1]
        low, middle, high = candidate.expected_rmsd_A
        sound = "sound" if candidate.sound else "not sound"
        yield (
            f"{model}{strand.name} {strand.sequence}: candidate {candidate.rank} of"
            f" {len(strand.candidates)}, {candidate.line.shape}, {sound}, expected error"
            f" {middle:.1f} A (80 % between {low:.1f} and {high:.1f})"
        )
    if filling.completed:
        yield f"Missing atoms were added to {', '.join(filling.completed)}"
    yield from filling.repaired
    if filling.options.hydrogens:
        yield "Hydrogens stand at ideal lengths and angles, hydroxyls where they have room"
