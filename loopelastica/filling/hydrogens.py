"""Hydrogens of a filled structure, and 5' phosphates that are taken off it.

Both belong to the structure as it is in the end: what was built for one gap may end another one's
chain. So they are worked out when all that changes in a file is known, for each of its models.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from loopelastica._arrays import Array
from loopelastica.atoms.hydrogens import add_hydrogens, carriers
from loopelastica.atoms.terminals import (
    PHOSPHATE_5,
    chain_bonds,
    phosphate_remark,
    phosphates_at_5,
    without_phosphate,
)
from loopelastica.molecule.chains import chains_of
from loopelastica.molecule.components import atom_name
from loopelastica.molecule.conformers import is_hydrogen
from loopelastica.molecule.polymer import Monomer
from loopelastica.molecule.surroundings import heavy_atoms
from loopelastica.report.changes import AddedResidue, Changes, Place, Removed
from loopelastica.report.pdb import b_factor

if TYPE_CHECKING:
    from loopelastica.atoms.strand import StrandModel
    from loopelastica.filling.result import Filling
    from loopelastica.molecule.entry import Entry

CARRIED_A: Final = 1.3
"""A hydrogen nearer than this to a heavy atom is bonded to it."""
RIDING_A: Final = 0.1
"""Error to expect of a hydrogen on an atom of the file."""
MANY: Final = 3
"""Nucleotides without all hydrogens that are named one by one."""


class _There(NamedTuple):
    """A hydrogen of the file."""

    name: str
    at_A: Array


@dataclass(slots=True)
class _Model:
    """One model of a filled structure.

    Attributes
    ----------
    index : int
        From 0.
    now : dict of str to Monomer
        All its nucleotides as they are after filling, by their labels.
    built : set of str
        Those that have new or moved atoms.
    beside : set of str
        Those that what was built is bonded to.
    there : dict of str to list of _There
        Hydrogens of the file that stay, by the labels of their nucleotides.
    """

    index: int
    now: dict[str, Monomer] = field(default_factory=dict)
    built: set[str] = field(default_factory=set)
    beside: set[str] = field(default_factory=set)
    there: dict[str, list[_There]] = field(default_factory=dict)


def hydrogenated(
    filling: Filling, rank: int, changes: Changes, occupancy: float
) -> tuple[Changes, tuple[str, ...]]:
    """The changes with hydrogens, and without 5' phosphates, as the options ask.

    Where the file has hydrogens on its nucleotides, those that were built, completed or repaired
    get theirs; where it has none, every nucleotide does. Hydrogens of the file at an end of a chain
    that is none any more go with or without options.

    Parameters
    ----------
    filling : Filling
        What was filled.
    rank : int
        Which candidate of each strand; the last one where a strand has fewer.
    changes : Changes
        All that changes otherwise.
    occupancy : float
        Of hydrogens on atoms of the file.

    Returns
    -------
    changes : Changes
    remarks : tuple of str
        One sentence for each thing that a user should be aware of.
    """
    options = filling.options
    added, removed = list(changes.added), list(changes.removed)
    said: dict[str, list[int]] = {}
    for index in range(filling.entry.n_models):
        if not _is_concerned(filling, index):
            continue
        model = _model(filling, index, rank, changes)
        removed += _strays(model)
        remarks: list[str] = []
        if not options.hydrogens and model.built and any(model.there.values()):
            remarks.append(
                "the file's nucleotides have hydrogens and what was built has none, for hydrogens"
                " were not requested"
            )
        if options.no_5_phosphate:
            removed += _without_phosphates(model, filling.entry, added)
        elif options.hydrogens:
            remarks += _refused_phosphates(model)
        if options.hydrogens:
            remarks += _add(model, _around(filling.entry, model, changes), added, occupancy)
        for remark in remarks:
            said.setdefault(remark, []).append(index + 1)
    changed = replace(changes, added=tuple(added), removed=tuple(dict.fromkeys(removed)))
    return changed, tuple(_of_models(said, filling.entry.n_models))


def _is_concerned(filling: Filling, index: int) -> bool:
    """Whether there is anything to do in a model."""
    options = filling.options
    if options.hydrogens or options.no_5_phosphate:
        return True
    built = {strand.model for strand in filling.filled}
    built |= {completion.model for completion in filling.completions}
    built |= {repair.model for repair in filling.repairs}
    return index + 1 in built and bool(filling.entry.model(index).has_hydrogen())


def _of_models(said: Mapping[str, Sequence[int]], n_models: int) -> Iterator[str]:
    """Sentences with the models that they are about, where that is not each of them."""
    for sentence, own in said.items():
        which = f"model {own[0]}" if len(own) == 1 else f"{len(own)} models"
        yield sentence if len(own) == n_models else f"{which}: {sentence}"


def _model(filling: Filling, index: int, rank: int, changes: Changes) -> _Model:
    """A model as it is after filling."""
    model = _Model(index)
    there = (one for chain in chains_of(filling.entry, index) for one in chain.slots)
    model.now = {one.label: one for one in there if one.atoms_A}
    for repair in filling.repairs:
        if repair.model == index + 1:
            for one in repair.now:
                model.now[one.label] = one
                model.built.add(one.label)
    for strand in filling.filled:
        if strand.model == index + 1:
            atoms = strand.candidates[min(rank, len(strand.candidates)) - 1].atoms
            for one in atoms.gap.replaces:
                model.now.pop(one.label, None)
            _grow(model, atoms)
    for completion in filling.completions:
        if completion.model == index + 1:
            _grow(model, completion.atoms)
    gone = {
        ((one.chain, one.number, one.icode), one.name)
        for one in changes.removed
        if one.model == index
    }
    places = {(m.chain, m.number, m.icode): m for m in model.now.values()}
    for place, residue in _residues(filling.entry, index):
        nucleotide = places.get(place)
        if nucleotide is None or residue.name != nucleotide.resname or (place, None) in gone:
            continue
        model.there[nucleotide.label] = [
            _There(atom.name, np.array(atom.pos.tolist()))
            for atom in residue
            if is_hydrogen(atom) and (place, atom.name) not in gone
        ]
    return model


def _grow(model: _Model, atoms: StrandModel) -> None:
    """Give nucleotides what was built of them."""
    # a nucleotide at an end of its chain has but one neighbour
    model.beside |= {one.label for one in (atoms.gap.before, atoms.gap.after) if one is not None}
    for residue in atoms.residues:
        one = residue.monomer
        was = model.now.get(one.label)
        new = dict(zip(residue.names, residue.positions_A, strict=True))
        if was is None:
            renamed = not one.atoms_A and residue.kind.renamed
            kind = residue.kind
            one = replace(one, letter=kind.letter, is_dna=kind.is_dna)
            was = replace(one, resname=kind.standard if renamed else one.resname, atoms_A={})
        model.now[one.label] = replace(was, atoms_A={**was.atoms_A, **new})
        model.built.add(one.label)


def _residues(entry: Entry, index: int) -> Iterator[tuple[Place, Any]]:
    """Residues of the file with their places."""
    for chain in entry.model(index):
        for residue in chain:
            yield (chain.name, residue.seqid.num, residue.seqid.icode.strip()), residue


def _removed(model: _Model, one: Monomer, name: str) -> Removed:
    return Removed(model.index, one.chain, one.number, one.icode, one.resname, name)


def _strays(model: _Model) -> Iterator[Removed]:
    """Hydrogens of the file that what was built leaves no place for.

    They are on an O3' or O5' that is bonded now, or on an atom that was not there.
    """
    labels = model.built | model.beside
    monomers = list(model.now.values())
    for one, (_, after) in zip(monomers, chain_bonds(monomers), strict=True):
        if one.label not in labels:
            continue
        ended = [name for name, bonded in (("O3'", after), ("O5'", "P" in one.atoms_A)) if bonded]
        yield from _without(model, one, ended)


def _without(model: _Model, one: Monomer, carriers: Collection[str]) -> Iterator[Removed]:
    """Leave out the hydrogens of a nucleotide on some of its atoms, and those on none."""
    there = model.there.get(one.label, [])
    model.there[one.label] = []
    for hydrogen in there:
        if _carrier(one, hydrogen) in {None, *carriers}:
            yield _removed(model, one, hydrogen.name)
        else:
            model.there[one.label].append(hydrogen)


def _carrier(one: Monomer, hydrogen: _There) -> str | None:
    """The atom that a hydrogen of the file is bonded to; None where it is bonded to none."""
    away = {name: float(np.linalg.norm(at - hydrogen.at_A)) for name, at in one.atoms_A.items()}
    nearest = min(away, key=lambda name: away[name])
    return nearest if away[nearest] < CARRIED_A else None


def _refused_phosphates(model: _Model) -> Iterator[str]:
    """What is said of 5' phosphates."""
    monomers = list(model.now.values())
    for k in phosphates_at_5(monomers, chain_bonds(monomers)):
        yield phosphate_remark(monomers[k])


def _without_phosphates(
    model: _Model, entry: Entry, added: list[AddedResidue]
) -> Iterator[Removed]:
    """Take off the 5' phosphates of a model, from the file and from what was built."""
    monomers = list(model.now.values())
    bare = {monomers[k].label for k in phosphates_at_5(monomers, chain_bonds(monomers))}
    places = {(m.chain, m.number, m.icode): m for m in monomers if m.label in bare}
    for place, residue in _residues(entry, model.index):
        one = places.get(place)
        if one is not None and residue.name == one.resname:
            for atom in residue:
                if atom_name(atom.name) in PHOSPHATE_5 and not is_hydrogen(atom):
                    yield _removed(model, one, atom.name)
    for one in places.values():
        model.now[one.label] = without_phosphate(one)
        yield from _without(model, one, PHOSPHATE_5)
        # its O5' is free for a hydrogen
        model.built.add(one.label)
    added[:] = [
        left
        for residue in added
        if (left := _bare(residue, residue.model == model.index and residue.place in places))
    ]


def _bare(residue: AddedResidue, is_bare: bool) -> AddedResidue | None:
    """What is added without the atoms of a 5' phosphate; None where nothing is left."""
    kept = [k for k, name in enumerate(residue.names) if name not in PHOSPHATE_5]
    if not is_bare or len(kept) == len(residue.names):
        return residue
    if not kept:
        return None
    return replace(
        residue,
        names=tuple(residue.names[k] for k in kept),
        elements=tuple(residue.elements[k] for k in kept),
        positions_A=residue.positions_A[kept],
        occupancy=np.asarray(residue.occupancy)[kept],
        b_factor_A2=np.asarray(residue.b_factor_A2)[kept],
    )


def _around(entry: Entry, model: _Model, changes: Changes) -> Array:
    """Heavy atoms of all that is no nucleotide and stays."""
    atoms = heavy_atoms(entry, model.index)
    others = atoms.without(model.now.keys())
    gone = {
        tuple(np.round(one.at_A, 3))
        for one in changes.removed
        if one.model == model.index and one.at_A is not None
    }
    points = others.positions_A
    kept = [tuple(point) not in gone for point in points.round(3)]
    return np.asarray(points[np.array(kept, dtype=np.bool_)])


def _add(
    model: _Model,
    around_A: Array,
    added: list[AddedResidue],
    occupancy: float,
) -> Iterator[str]:
    """Add the hydrogens that are wanted; yields what is to be said of them."""
    everything = list(model.now.values())
    has = any(model.there.values())
    wanted = [k for k, one in enumerate(everything) if not has or one.label in model.built]
    others = [at for k, one in enumerate(everything) for at in one.atoms_A.values()]
    bonds = chain_bonds(everything)
    own = {residue.place: k for k, residue in enumerate(added) if residue.model == model.index}
    found = add_hydrogens(
        [everything[k] for k in wanted],
        [bonds[k] for k in wanted],
        np.concatenate([np.array(others).reshape(-1, 3), around_A]),
    )
    for k, hydrogens in zip(wanted, found, strict=True):
        one = everything[k]
        new = _lacking(one, hydrogens, model.there.get(one.label, ()))
        place = (one.chain, one.number, one.icode)
        if new and place in own:
            added[own[place]] = _with(added[own[place]], new)
        elif new:
            added.append(_riding(model.index, one, new, occupancy))
    yield from found.remarks[:MANY]
    more = len(found.remarks) - MANY
    if more > 0:
        yield f"{more} more nucleotide{'s do' if more > 1 else ' does'} not get all hydrogens"


def _lacking(
    one: Monomer, hydrogens: Mapping[str, Array], there: Sequence[_There]
) -> dict[str, Array]:
    """Those hydrogens whose carrier has none in the file."""
    if not there:
        return dict(hydrogens)
    carrier = carriers(one)
    full = {_carrier(one, hydrogen) for hydrogen in there}
    names = {atom_name(h.name) for h in there}
    return {x: at for x, at in hydrogens.items() if carrier[x] not in full and x not in names}


def _with(residue: AddedResidue, hydrogens: Mapping[str, Array]) -> AddedResidue:
    """What is added of a nucleotide, with hydrogens."""
    occupancy, b_factors = (np.asarray(x) for x in (residue.occupancy, residue.b_factor_A2))
    more = np.ones(len(hydrogens))
    return replace(
        residue,
        names=(*residue.names, *hydrogens),
        elements=(*residue.elements, *("H" for _ in hydrogens)),
        positions_A=np.concatenate([residue.positions_A, list(hydrogens.values())]),
        occupancy=np.concatenate([occupancy, occupancy.max() * more]),
        b_factor_A2=np.concatenate([b_factors, b_factors.max() * more]),
    )


def _riding(
    index: int, one: Monomer, hydrogens: Mapping[str, Array], occupancy: float
) -> AddedResidue:
    """Hydrogens of a nucleotide of the file."""
    return AddedResidue(
        model=index,
        chain=one.chain,
        number=one.number,
        icode=one.icode,
        resname=one.resname,
        after=None,
        names=tuple(hydrogens),
        elements=("H",) * len(hydrogens),
        positions_A=np.array(list(hydrogens.values())),
        occupancy=occupancy,
        b_factor_A2=b_factor(RIDING_A),
    )
