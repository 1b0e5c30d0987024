"""A hairpin from its sequence alone: ideal stem, folded loop, atoms of both.

sequence → nucleotides, pairs → stem → folded loop → atoms
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record
from loopelastica._checks import flag, whole
from loopelastica.atoms.chemistry import Residue, atom_names
from loopelastica.atoms.duplex import duplex, screwed
from loopelastica.atoms.fibre import fibre_nucleotide
from loopelastica.atoms.model import AtomModel, build_atoms
from loopelastica.atoms.sequence import HairpinSequence, read_sequence
from loopelastica.atoms.turn import check_contact
from loopelastica.errors import StructureError
from loopelastica.folding.fold import fold_model
from loopelastica.folding.hypotheses import Scene
from loopelastica.folding.known import library_at
from loopelastica.folding.options import FoldOptions
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.hairpins import Hairpin
from loopelastica.molecule.nucleotides import Structure, read_structure
from loopelastica.molecule.reading import quiet

CHAIN = "A"
_DECIMALS = 3


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


@dataclass(frozen=True, slots=True, eq=False)
class HairpinAtoms(Record):
    """All atoms of a hairpin, 5' to 3'.

    Attributes
    ----------
    names, elements, resnames : tuple of str
        Of each atom; names of the wwPDB.
    resids : (N,) array of int
        Number of its nucleotide, from 1.
    chain : str
    positions_A : (N, 3) array
        Å.
    """

    names: tuple[str, ...]
    elements: tuple[str, ...]
    resnames: tuple[str, ...]
    resids: NDArray[np.int64]
    chain: str
    positions_A: Array


@dataclass(frozen=True, slots=True, eq=False, repr=False, kw_only=True)
class HairpinModel(AtomModel):
    """A built hairpin: what :class:`AtomModel` has of its loop, and the whole of it.

    Attributes
    ----------
    hairpin : FoldedHairpin
        The stem, and the folded loop.
    models : tuple of AtomModel
        The loop's atoms on all lines that were asked for, ranked.
    """

    hairpin: FoldedHairpin
    models: tuple[AtomModel, ...]

    def __repr__(self) -> str:
        sound = "sound" if self.checks.sound else "not sound"
        n = len(self.hairpin.sequence.residues)
        return f"<HairpinModel {self.rank}: {self.hairpin.sequence}, {n} nucleotides, {sound}>"

    @property
    def candidates(self) -> tuple[HairpinModel, ...]:
        """All that were asked for, ranked; the first is what `build` returns."""
        return tuple(_model(self.hairpin, model, self.models) for model in self.models)

    @property
    def sequence(self) -> str:
        """Such as "GGCAC(UUCG)GUGCC"."""
        return str(self.hairpin.sequence)

    @property
    def atoms(self) -> HairpinAtoms:
        """The atoms of stem and loop."""
        universe, molecule = self.hairpin.structure.universe, self.molecule
        positions = np.array(self.hairpin.positions_A)
        first = self.hairpin.sequence.pairs
        for row, (name, resid) in enumerate(
            zip(universe.atoms.names, universe.atoms.resids, strict=True)
        ):
            if np.isnan(positions[row]).any():
                positions[row] = self.positions_A[molecule.index(int(resid) - 1 - first, name)]
        return HairpinAtoms(
            tuple(universe.atoms.names.tolist()),
            tuple(universe.atoms.elements.tolist()),
            tuple(universe.atoms.resnames.tolist()),
            universe.atoms.resids.astype(np.int64),
            CHAIN,
            positions,
        )

    def universe(self) -> Any:
        """The atoms of stem and loop as an MDAnalysis Universe."""
        atoms = self.atoms
        residues = self.hairpin.sequence.residues
        return _universe(residues, atoms.names, (atoms.resids - 1).tolist(), atoms.positions_A)


def build(
    sequence: str,
    rna: bool | None = None,
    *,
    structure: str | None = None,
    candidates: int = 1,
    phosphate: bool = False,
    mismatches: bool = False,
    contact: str | None = None,
) -> HairpinModel:
    """Build a hairpin from its sequence: ideal stem, folded loop, atoms of both.

    Parameters
    ----------
    sequence : str
        Such as "GGCAC(UUCG)GUGCC", or with its dot-bracket, "GGCACUUCGGUGCC (((((....)))))";
        spaces and lower case mean nothing. Modified nucleotides stand in square brackets by their
        wwPDB names, "GG[5MC]A(UUCG)UGCC".
    rna : bool, optional
        True: A-RNA, False: B-DNA; by default T and U decide.
    structure : str, optional
        The dot-bracket, where it is not in `sequence`.
    candidates : int
        Most shapes of the loop.
    phosphate : bool
        Put a phosphate at the 5' end.
    mismatches : bool
        Take nucleotides that do not pair into the stem; they stand where they find room.
    contact : {"sheared", "watson-crick"}, optional
        Contact across the loop to be sought.

    Returns
    -------
    HairpinModel
        The first of its :attr:`~HairpinModel.candidates`. Its checks say whether it is sound.

    Raises
    ------
    ValueError
        If `sequence` is no hairpin, or an option is out of range; the sentence says where.
    StructureError
        If the stem does not get sound, or the loop cannot be folded.

    Examples
    --------
    >>> model = build("GGC(GAA)GCC", rna=False)
    >>> model
    <HairpinModel 1: GGC(GAA)GCC, 9 nucleotides, sound>
    >>> len(model.atoms.names), model.atoms.resnames[-1]
    (186, 'DC')
    """
    candidates, phosphate = whole(1)("candidates", candidates), flag("phosphate", phosphate)
    check_contact(contact)
    read = read_sequence(sequence, structure, rna=rna, mismatches=mismatches)
    hairpin = fold_sequence(read, max_candidates=candidates, phosphate=phosphate)
    models = build_atoms(
        hairpin.structure, hairpin.fold, positions=hairpin.positions_A, contact=contact
    )
    return _model(hairpin, models[0], tuple(models))


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
    return FoldedHairpin(sequence, structure, fold, positions)


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
        read_structure(_universe(sequence.residues, names, resindex, known)),
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


def _model(hairpin: FoldedHairpin, model: AtomModel, models: tuple[AtomModel, ...]) -> HairpinModel:
    values = {item.name: getattr(model, item.name) for item in fields(AtomModel)}
    return HairpinModel(**values, hairpin=hairpin, models=models)


def _universe(
    residues: Sequence[Residue], names: Sequence[str], resindex: Sequence[int], positions: Array
) -> Any:
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
            "chainID": [CHAIN] * len(names),
            "resname": [residue.standard for residue in residues],
            "resid": list(range(1, len(residues) + 1)),
            "segid": [CHAIN],
        }.items():
            universe.add_TopologyAttr(attribute, list(values))
        universe.atoms.positions = positions
    return universe
