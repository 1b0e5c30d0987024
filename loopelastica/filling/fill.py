"""Fill every internal gap of a structure.

    entry ─find_gaps→ gaps ─ends→ frames, Å ─lines→ rods among atoms ─build→ atoms ─checks→ models

Each model of a file is filled by itself, gap after gap in the order of the chains: what is built is
there for the next one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from scipy.spatial import cKDTree

from loopelastica._files import sha256
from loopelastica.atoms.strand import StrandModel
from loopelastica.errors import StructureError
from loopelastica.filling.compose import hydrogen_remarks
from loopelastica.filling.models import first_model, strand_models
from loopelastica.filling.options import FillOptions
from loopelastica.filling.repair import Mender
from loopelastica.filling.result import (
    Completion,
    FilledCandidate,
    FilledStrand,
    Filling,
    Repair,
    waters_of,
)
from loopelastica.folding.known import Known, library_at
from loopelastica.folding.library import Library
from loopelastica.folding.like import check_strands, remarks, strand_templates
from loopelastica.folding.line import NEAR_A
from loopelastica.folding.options import keywords
from loopelastica.folding.shape_line import expected_error, known_strand
from loopelastica.molecule.entry import Entry, read_entry
from loopelastica.molecule.flanks import around
from loopelastica.molecule.gaps import Gaps, Incomplete, find_gaps
from loopelastica.molecule.identity import entries_of
from loopelastica.molecule.nucleotides import enumerated
from loopelastica.molecule.obstacles import crowding, obstacles
from loopelastica.molecule.polymer import Gap, HeavyAtoms, Monomer
from loopelastica.molecule.refusals import Refusal, refusal
from loopelastica.molecule.strand_ends import StrandEnds, strand_ends
from loopelastica.molecule.surroundings import heavy_atoms, symmetry_mates
from loopelastica.molecule.templates import Template

MATE_A: Final = 3.0
"""Mates in the crystal nearer than this are told."""
MANY: Final = 3
"""Nucleotides of one fault that are named one by one; of more there is one sentence."""


@keywords(FillOptions)
def fill(structure: Any, options: FillOptions) -> Filling:
    """Fill the internal gaps of DNA and RNA chains with all their atoms.

    No atom that is there moves, unless `repair` is set, and none goes but waters in the way, 5'
    phosphates with `no_5_phosphate` and hydrogens at what ends a chain no more.

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

    Examples
    --------
    >>> import MDAnalysis as mda
    >>> import loopelastica as le
    >>> from loopelastica._files import data_path
    >>> from loopelastica.molecule.reading import quiet
    >>> with quiet():
    ...     universe = mda.Universe(data_path("hairpins/2koc.pdb"))
    ...     filling = le.fill(universe, strands="A.7")
    >>> filling
    <Filling of universe: 1 strands filled, 0 refused>
    >>> filling.strands[0]
    <FilledStrand A.7 U: sound, 0.4 Å to expect>
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
    library = None if options.library is None else library_at(options.library)
    strands: list[FilledStrand] = []
    completions: list[Completion] = []
    repairs: list[Repair] = []
    remarks: list[str] = []
    unrepaired: list[str] = []
    for model in range(entry.n_models):
        filler = _Filler(entry, model, options, library)
        if options.repair:
            repairs += filler.repairs()
            unrepaired += filler.unrepaired
        strands += _with_mates(entry, filler.given, list(filler.strands()))
        completions += filler.completions()
        remarks += filler.remarks
    filling = Filling(
        name=entry.name,
        strands=tuple(strands),
        options=options,
        completed=tuple(dict.fromkeys(_completed(strands, completions))),
        repaired=tuple(_in_model(repair.model, str(repair), entry) for repair in repairs),
        remarks=tuple(dict.fromkeys(remarks)),
        entry=entry,
        completions=tuple(completions),
        repairs=tuple(repairs),
        unrepaired=tuple(unrepaired),
        sha256=None if entry.path is None else sha256(entry.path),
    )
    return replace(filling, remarks=(*filling.remarks, *dict.fromkeys(hydrogen_remarks(filling))))


def _with_mates(entry: Entry, atoms: HeavyAtoms, strands: list[FilledStrand]) -> list[FilledStrand]:
    """The strands of one model, and how near what was built comes to its mates in the crystal.

    They are told, not avoided: which of two mates gives way is not for one strand to say.
    """
    built = {
        k: np.concatenate([r.positions_A for r in strand.candidates[0].atoms.residues])
        for k, strand in enumerate(strands)
        if strand.candidates
    }
    if not built:
        return strands
    mates = symmetry_mates(entry, np.concatenate(list(built.values())), MATE_A, atoms)
    if not len(mates):
        return strands
    tree = cKDTree(mates)
    for k, points in built.items():
        nearest = float(tree.query(points)[0].min())
        if nearest < MATE_A:
            remark = f"{strands[k].name}: a mate in the crystal is {nearest:.1f} Å away"
            strands[k] = replace(strands[k], mate_A=nearest, remarks=(*strands[k].remarks, remark))
    return strands


class _Filler:
    """One model of an entry; its atoms grow with every strand."""

    def __init__(
        self, entry: Entry, model: int, options: FillOptions, library: Library | None = None
    ) -> None:
        self.entry, self.model, self.options, self.library = entry, model, options, library
        self.found = _found(entry, model, options)
        if options.like is not None:
            check_strands(options.like, self.found.gaps, options.limits)
        replaced = {m.label for gap in self.found.gaps for m in gap.replaces}
        self.given = heavy_atoms(entry, model)
        self.atoms = self.given.without(replaced)
        self.built: dict[str, Monomer] = {}
        self.unrepaired: list[str] = []
        self.remarks = [*self.found.remarks, *map(str, self.found.tails)]
        if not options.repair:
            self.remarks += self.found.broken

    def repairs(self) -> tuple[Repair, ...]:
        """What is broken, built anew; what is to be filled anyway is left to that."""
        filled = {m.label for gap in self.found.gaps for m in (*gap.monomers, *gap.replaces)}
        chains = self.found.chains
        mender = Mender(self.entry, self.model, chains, self.atoms, filled)
        self.atoms = mender.atoms
        self.built |= {one.label: one for repair in mender.repairs for one in repair.now}
        self.unrepaired = [_in_model(self.model + 1, left, self.entry) for left in mender.left]
        return tuple(mender.repairs)

    def strands(self) -> Iterator[FilledStrand]:
        """Every gap, filled or refused, gaps first."""
        for found in self.found.gaps:
            gap = self._with_built(found)
            try:
                yield self._filled(gap)
            except StructureError as error:
                yield self._refused(refusal(gap.monomers, str(error)))
        for one in self.found.refused:
            yield self._refused(one)

    def completions(self) -> Iterator[Completion]:
        """Nucleotides beside no gap, with the atoms that they lacked."""
        left: list[Incomplete] = []
        for one in self.found.incomplete:
            monomer = one.monomer
            if {*one.missing} <= set(self.built.get(monomer.label, monomer).atoms_A):
                continue
            gap = around(self.found.chains, monomer)
            if gap is None:
                left.append(one)
                continue
            try:
                gap = self._with_built(gap)
                model = first_model(gap, self.atoms)
            except StructureError as error:
                self.remarks.append(str(error))
                continue
            if not model.checks.sound:
                why = "; ".join(model.checks.wrong)
                self.remarks.append(f"{monomer.label}: not sound with its missing atoms ({why})")
            waters = waters_of(model, self.atoms, self.model)
            self._grow(model)
            yield Completion(self.model + 1, model, waters)
        self.remarks += _left(left)

    def _filled(self, gap: Gap) -> FilledStrand:
        ends = strand_ends(gap)
        crowded = crowding(ends, self.atoms.positions_A[obstacles(gap, ends, self.atoms)])
        templates, unlike = self._templates(gap)
        known, unknown = self._known(gap, ends)
        most = self.options.candidates
        models = strand_models(gap, ends, self.atoms, most, templates, known)
        candidates = tuple(
            FilledCandidate(
                rank,
                line,
                model,
                expected_error(line, crowded),
                waters_of(model, self.atoms, self.model),
            )
            for rank, (line, model) in enumerate(models, start=1)
        )
        self._grow(candidates[0].atoms)
        return FilledStrand(
            chain=gap.chain,
            first=gap.monomers[0].place,
            last=gap.monomers[-1].place,
            sequence=gap.sequence,
            status="filled",
            candidates=candidates,
            model=self.model + 1,
            kind=gap.kind,
            distance_A=ends.distance_A,
            length_A=ends.length_A,
            crowding=crowded,
            remarks=(*gap.remarks, *unlike, *unknown, *_remarks(gap, candidates[0], templates)),
            nucleotides=len(gap),
        )

    def _templates(self, gap: Gap) -> tuple[tuple[Template, ...], tuple[str, ...]]:
        """What a strand is to be like, and what is to be said of that."""
        like = self.options.like
        if like is None:
            return (), ()
        found = strand_templates(like, gap, self.options.limits)
        return found, tuple(remarks(like, "strand", gap.name, len(gap), found))

    def _known(self, gap: Gap, ends: StrandEnds) -> tuple[Known | None, tuple[str, ...]]:
        """What the library knows of a strand, and what is to be said where that is nothing."""
        if self.library is None:
            return None, ()
        entries = entries_of(self.entry.path or self.entry.loaded_from)
        found = known_strand(gap, ends, self.atoms, self.library, entries)
        if isinstance(found, Known):
            return found, ()
        return None, (f"{gap.name}: {found}; it is made without the library",)

    def _refused(self, found: Refusal) -> FilledStrand:
        return FilledStrand(
            found.chain,
            found.first,
            found.last,
            found.sequence,
            "refused",
            found.reason,
            model=self.model + 1,
            nucleotides=len(found.sequence),
        )

    def _with_built(self, gap: Gap) -> Gap:
        """The gap with what was built before it on its own nucleotides."""

        def now(monomer: Monomer | None) -> Any:
            return None if monomer is None else self.built.get(monomer.label, monomer)

        return replace(
            gap,
            monomers=tuple(now(monomer) for monomer in gap.monomers),
            before=now(gap.before),
            after=now(gap.after),
            beyond_5=now(gap.beyond_5),
            beyond_3=now(gap.beyond_3),
        )

    def _grow(self, model: StrandModel) -> None:
        """Put what was built among the atoms; waters give way."""
        for residue in model.residues:
            one = residue.monomer
            new = dict(zip(residue.names, residue.positions_A, strict=True))
            self.built[one.label] = replace(one, atoms_A={**one.atoms_A, **new})
        self.atoms = self.atoms.grown(model.residues, model.waters)


def _found(entry: Entry, model: int, options: FillOptions) -> Gaps:
    """What is missing; where the options contradict the file the sentence names it."""
    try:
        return find_gaps(entry, model, options.strands)
    except StructureError as error:
        where = f"{entry.where}: "
        raise StructureError(where + str(error).removeprefix(where)) from None


def _in_model(model: int, sentence: str, entry: Entry) -> str:
    """A sentence that says which model it is about, where there are several."""
    return f"model {model}: {sentence}" if entry.n_models > 1 else sentence


def _left(incomplete: Sequence[Incomplete]) -> Iterator[str]:
    """What is said of nucleotides that lack atoms and cannot get them."""
    if len(incomplete) > MANY:
        names = enumerated([one.monomer.label for one in incomplete])
        yield (
            f"{len(incomplete)} nucleotides lack atoms and do not lie between two with C4' and four"
            f" backbone atoms; they are left as they are: {names}"
        )
        return
    for monomer, missing in incomplete:
        yield (
            f"{monomer.label} lacks {enumerated(missing)} and does not lie between two nucleotides"
            " with C4' and four backbone atoms; it is left as it is"
        )


def _remarks(gap: Gap, first: FilledCandidate, templates: Sequence[Template]) -> Iterator[str]:
    if templates and first.shape not in {template.name for template in templates}:
        yield f"{gap.name}: no model that is like its template is sound; it is made without"
    near = first.line.nearest_A
    if near is not None and near < NEAR_A:
        yield (
            f"{gap.name}: its line comes within {near:.1f} Å of {first.line.nearest_atom}; real"
            f" backbones keep {NEAR_A:.0f} Å"
        )
    if not first.sound:
        yield f"{gap.name}: not sound ({'; '.join(first.atoms.checks.wrong)})"


def _completed(strands: Sequence[FilledStrand], completions: Sequence[Completion]) -> Iterator[str]:
    """Labels of nucleotides that were there in part."""
    for strand in strands:
        for residue in strand.candidates[0].atoms.residues if strand.candidates else ():
            if residue.monomer.atoms_A:
                yield residue.monomer.label
    for completion in completions:
        for residue in completion.atoms.residues:
            yield residue.monomer.label
