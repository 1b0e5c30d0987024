"""Fill every internal gap of a structure.

    entry ─find_gaps→ gaps ─ends→ frames, Å ─lines→ rods among atoms ─build→ atoms ─checks→ models

Each model of a file is filled by itself, gap after gap in the order of the chains: what is built is
there for the next one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from loopelastica.atoms.carry import FileLine, Line
from loopelastica.atoms.strand import StrandModel, build_strand
from loopelastica.errors import StructureError
from loopelastica.filling.options import FillOptions
from loopelastica.filling.result import Completion, FilledCandidate, FilledStrand, Filling
from loopelastica.folding.expected import expected_rmsd
from loopelastica.folding.line import NEAR_A, StrandLine, strand_lines
from loopelastica.folding.options import keywords
from loopelastica.molecule.entry import Entry, read_entry
from loopelastica.molecule.flanks import strand_ends
from loopelastica.molecule.gaps import Refused, find_gaps
from loopelastica.molecule.obstacles import crowding, obstacles
from loopelastica.molecule.polymer import Gap, HeavyAtoms, Monomer
from loopelastica.molecule.strands import ideal_strand
from loopelastica.molecule.surroundings import heavy_atoms
from loopelastica.report.compose import Removed


@keywords(FillOptions)
def fill(structure: Any, options: FillOptions) -> Filling:
    """Fill the internal gaps of DNA and RNA chains with all their atoms.

    No atom that is there moves.

    Parameters
    ----------
    structure : path, MDAnalysis.Universe, MDAnalysis.AtomGroup or Entry
        PDB or mmCIF, also compressed; a Universe counts with its current frame, and has no sequence
        of record: give `strands`.
    {options}

    Returns
    -------
    Filling
        Its ``write(path)`` writes the structure.

    Raises
    ------
    StructureError
        If the file cannot be read, has no nucleotide, or contradicts `strands`.
    ValueError
        If an option is out of range.
    """
    return fill_entry(read_entry(structure, options.limits), options)


def fill_entry(entry: Entry, options: FillOptions) -> Filling:
    """Fill an entry that was read already.

    Parameters
    ----------
    entry : Entry
        What was read.
    options : FillOptions
        As for :func:`fill`.

    Returns
    -------
    Filling
    """
    strands: list[FilledStrand] = []
    completions: list[Completion] = []
    remarks: list[str] = []
    for model in range(entry.n_models):
        filler = _Filler(entry, model, options)
        strands += filler.strands()
        completions += filler.completions()
        remarks += filler.remarks
    return Filling(
        name=entry.name,
        strands=tuple(strands),
        options=options,
        completed=tuple(dict.fromkeys(_completed(strands, completions))),
        repaired=(),
        remarks=tuple(dict.fromkeys(remarks)),
        entry=entry,
        completions=tuple(completions),
    )


class _Filler:
    """One model of an entry; its atoms grow with every strand."""

    def __init__(self, entry: Entry, model: int, options: FillOptions) -> None:
        self.entry, self.model, self.options = entry, model, options
        self.found = find_gaps(entry, model, options.strands)
        self.atoms = heavy_atoms(entry, model)
        self.built: dict[tuple[str, int, str], Monomer] = {}
        self.remarks = [*self.found.remarks, *self.found.tails]

    def strands(self) -> Iterator[FilledStrand]:
        """Every gap, filled or refused, in the order of the chains."""
        for found in self.found.all:
            if isinstance(found, Refused):
                yield self._refused(found, found.reason)
                continue
            gap = self._with_built(found)
            try:
                yield self._filled(gap)
            except StructureError as error:
                yield self._refused(gap, str(error))

    def completions(self) -> Iterator[Completion]:
        """Nucleotides beside no gap, with the atoms that they lacked."""
        for gap in self.found.incomplete:
            try:
                model = build_strand(self._with_built(gap), None, self.atoms)
            except StructureError as error:
                self.remarks.append(str(error))
                continue
            yield Completion(self.model + 1, model, self._grown(model))

    def _filled(self, gap: Gap) -> FilledStrand:
        ends = strand_ends(gap)
        lines = strand_lines(gap, ends, self.atoms, self.options.candidates)
        crowded = crowding(ends, self.atoms.positions_A[obstacles(gap, ends, self.atoms)])
        models = [(line, self._model(gap, line)) for line in lines]
        # chemistry first, then the order of the lines
        models.sort(key=lambda pair: not pair[1].checks.sound)
        waters = [_waters(self.atoms, model) for _, model in models]
        candidates = tuple(
            FilledCandidate(rank, line, model, expected_rmsd(gap, ends, crowded), left_out)
            for rank, ((line, model), left_out) in enumerate(
                zip(models, waters, strict=True), start=1
            )
        )
        self._grown(models[0][1])
        return FilledStrand(
            **_about(gap),
            status="filled",
            candidates=candidates,
            model=self.model + 1,
            kind=gap.kind,
            distance_A=ends.distance_A,
            length_A=ends.length_A,
            crowding=crowded,
            remarks=(*gap.remarks, *_remarks(gap, candidates[0])),
        )

    def _model(self, gap: Gap, line: StrandLine) -> StrandModel:
        is_dna = sum(monomer.is_dna for monomer in gap.monomers) > len(gap) / 2
        curve = FileLine(Line.between(line.rod, line.ends, ideal_strand(is_dna)), line.ends)
        return build_strand(gap, curve, self.atoms)

    def _refused(self, found: Gap | Refused, reason: str) -> FilledStrand:
        return FilledStrand(
            **_about(found), status="refused", reason=reason, model=self.model + 1
        )

    def _with_built(self, gap: Gap) -> Gap:
        """The gap with what was built before it on its own nucleotides."""

        def now(monomer: Monomer | None) -> Any:
            return None if monomer is None else self.built.get(_place(monomer), monomer)

        return replace(
            gap,
            before=now(gap.before),
            after=now(gap.after),
            beyond_5=now(gap.beyond_5),
            beyond_3=now(gap.beyond_3),
        )

    def _grown(self, model: StrandModel) -> tuple[Removed, ...]:
        """Put what was built among the atoms; the waters that give way."""
        waters = _waters(self.atoms, model)
        self.atoms = self.atoms.with_residues(
            [(r.monomer.label, r.names, r.elements, r.positions_A) for r in model.residues],
            without=model.waters,
        )
        for residue in model.residues:
            monomer = residue.monomer
            atoms = {**monomer.atoms_A, **dict(zip(residue.names, residue.positions_A, strict=True))}
            self.built[_place(monomer)] = replace(monomer, atoms_A=atoms)
        return waters
