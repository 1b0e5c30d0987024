"""A structure with a built loop as gemmi holds it: one model, put in the place of each in turn.

Only one model is in memory: a ribosome has a hundred thousand atoms, and all but the loop's are the
same in each.
"""

from __future__ import annotations

import string
from collections.abc import Iterator, Sequence
from functools import cached_property
from itertools import count, product
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.atoms.model import AtomModel
from loopelastica.report.assembly import Atom, Residue
from loopelastica.report.pdb import b_factor, pdb_name
from loopelastica.report.protonation import position

if TYPE_CHECKING:
    from loopelastica.report.atoms import LoopAtoms

_LETTERS: Final = string.ascii_uppercase
_DECIMALS: Final = 3
"""Of coordinates in Å: all that PDB files have, and more than single precision of a ribosome."""


class ModelStructure:
    """All atoms of a loop's files.

    Parameters
    ----------
    atoms : LoopAtoms
        With at least one sound model.

    Attributes
    ----------
    atoms : LoopAtoms
    rows : list of (Residue, Atom)
        All atoms in their order.
    parts : list of list of Residue
        Chains of gemmi: a polymer each, with what follows it under the same name.
    gemmi : gemmi.Structure
        With one model.
    """

    def __init__(self, atoms: LoopAtoms) -> None:
        self.atoms = atoms
        assembly = atoms.assembly
        self.rows: list[tuple[Residue, Atom]] = list(assembly.atoms())
        self.parts: list[list[Residue]] = []
        for residue in assembly.residues:
            if residue.begins:
                self.parts.append([])
            self.parts[-1].append(residue)
        self.gemmi = _structure(self.parts, atoms)
        self._loop = [k for k, (residue, _) in enumerate(self.rows) if residue.built is not None]
        # the same atoms may be in another place in each model
        moving = {k for k, (_, atom) in enumerate(self.rows) if atom.in_file is None}
        self._moving = {k: one for k, one in enumerate(_atoms(self.gemmi)) if k in moving}

    def place(self, model: AtomModel) -> None:
        """Put the atoms where a model has them; the error to expect is the loop's B factor.

        Parameters
        ----------
        model : AtomModel
            One of the sound ones.
        """
        import gemmi

        (candidate,) = (c for c in self.atoms.fold.candidates if c.rank == model.rank)
        expected = b_factor(float(candidate.expected_rmsd_A[1]))
        for k, at in zip(self._moving, self._places(model, self._moving), strict=True):
            self._moving[k].pos = gemmi.Position(*at.round(_DECIMALS).tolist())
        for k in self._loop:
            self._moving[k].b_iso = expected

    def _places(self, model: AtomModel, rows: Any) -> Iterator[Array]:
        assembly = self.atoms.assembly
        number = next(k for k, one in enumerate(self.atoms.written) if one is model)
        for k in rows:
            residue, atom = self.rows[k]
            if atom.is_new_hydrogen:
                assert residue.nucleotide is not None
                yield assembly.hydrogens_A[number][residue.nucleotide, atom.name]
            else:
                yield position(atom, self.atoms, model)

    def call_chains(self, names: Sequence[str]) -> None:
        """Name the chains, one name for each of `parts`."""
        for chain, name in zip(self.gemmi[0], names, strict=True):
            chain.name = name

    @cached_property
    def long_names(self) -> list[str]:
        """A name for each part that is not empty, for mmCIF."""
        known = [pdb_name(part[0].chain or part[0].segment) for part in self.parts]
        free = (name for name in _labels() if name not in known)
        return [name or next(free) for name in known]

    @cached_property
    def polymer_ends(self) -> list[int]:
        """Rows of the last atom of each polymer."""
        import gemmi

        out, k = [], -1
        for chain in self.gemmi[0]:
            end = None
            for residue in chain:
                k += len(residue)
                if residue.entity_type == gemmi.EntityType.Polymer:
                    end = k
            out += [] if end is None else [end]
        return out

    def bonds(self) -> Iterator[tuple[int, int]]:
        """Bonds of the built nucleotides, junctions included, and of HO5', in rows.

        A component of the wwPDB has a phosphate in the place of HO5', so its name says no bond.
        """
        model = self.atoms.written[0]
        molecule, hairpin = model.molecule, self.atoms.fold.hairpin
        table = self.atoms.structure.nucleotides
        of_loop = {a.in_loop: k for k, (_, a) in enumerate(self.rows) if a.in_loop is not None}
        of_file = {a.in_file: k for k, (_, a) in enumerate(self.rows) if a.in_file is not None}
        closing = {-1: int(hairpin.stem_5[0]), molecule.n: int(hairpin.stem_3[0])}

        def row(one: int) -> int:
            nucleotide = molecule.residue[one]
            if nucleotide not in closing:
                return of_loop[one]
            return of_file[int(table.columns([molecule.names[one]])[closing[nucleotide], 0])]

        mine = set(molecule.loop_atoms)
        for i, j in molecule.bonds:
            if i in mine or j in mine:
                yield row(i), row(j)
        for k, (residue, atom) in enumerate(self.rows):
            if atom.name == "HO5'" and atom.is_new_hydrogen:
                names = [other.name for other in residue.atoms]
                yield k + names.index("O5'") - names.index("HO5'"), k
        # a hydrogen is bonded to the heavy atom next to it
        places = np.array(list(self._places(model, self._loop)))
        heavy = [n for n, k in enumerate(self._loop) if not self.rows[k][1].is_new_hydrogen]
        for n, k in enumerate(self._loop):
            if self.rows[k][1].is_new_hydrogen:
                away = np.linalg.norm(places[heavy] - places[n], axis=1)
                yield self._loop[heavy[int(np.argmin(away))]], k


def _atoms(structure: Any) -> Iterator[Any]:
    for chain in structure[0]:
        for residue in chain:
            yield from residue


def _structure(parts: Sequence[Sequence[Residue]], atoms: LoopAtoms) -> Any:
    """The atoms where the first model has them, and what kinds of molecules they are."""
    import gemmi

    structure, model = gemmi.Structure(), gemmi.Model(1)
    for part in parts:
        chain = gemmi.Chain("A")
        for residue in part:
            chain.add_residue(_residue(residue, atoms))
        model.add_chain(chain)
    structure.add_model(model)
    assembly = atoms.assembly
    if assembly.origin.cell is not None:
        structure.cell = gemmi.UnitCell(*assembly.origin.cell)
        structure.spacegroup_hm = assembly.origin.space_group or "P 1"
    structure.add_entity_types()
    _sort_out(structure, parts, assembly.bonded)
    structure.info["_struct_keywords.pdbx_keywords"] = atoms.fold.hairpin.kind
    return structure


def _residue(residue: Residue, atoms: LoopAtoms) -> Any:
    import gemmi

    out = gemmi.Residue()
    out.name, names = atoms.names_of(residue)
    out.seqid = gemmi.SeqId(residue.number, pdb_name(residue.icode)[:1] or " ")
    out.het_flag = "H" if residue.is_het else "A"
    out.segment = pdb_name(residue.segment)[:4]
    places = atoms.positions[[0 if a.in_file is None else a.in_file for a in residue.atoms]]
    places = places.round(_DECIMALS).tolist()
    for atom, name, at in zip(residue.atoms, names, places, strict=True):
        one = gemmi.Atom()
        one.name, one.element = name, gemmi.Element(atom.element)
        one.occ, one.b_iso, one.charge = atom.occupancy, atom.b_factor, atom.charge
        if atom.in_file is not None:
            one.pos = gemmi.Position(*at)
        out.add_atom(one)
    return out


def _sort_out(structure: Any, parts: Sequence[Sequence[Residue]], bonded: Any) -> None:
    """Which molecules there are: strands, and each water, ion or ligand by itself."""
    import gemmi

    kinds = gemmi.EntityType
    entities: dict[tuple[Any, ...], Any] = {}
    labels = _labels()
    for chain, part in zip(structure[0], parts, strict=True):
        polymer = [_is_polymer(r, own, bonded) for r, own in zip(chain, part, strict=True)]
        strand = [k for k, is_part in enumerate(polymer) if is_part]
        asym = next(labels) if strand else ""
        if strand:
            sequence = [chain[k].name for k in strand]
            kind = _polymer_type([part[k] for k in strand], chain)
            entity = entities.setdefault((str(kind), *sequence), gemmi.Entity(""))
            entity.entity_type, entity.polymer_type = kinds.Polymer, kind
            entity.full_sequence = sequence
            entity.subchains = [*entity.subchains, asym]
        for label, k in zip(count(1), strand, strict=False):
            chain[k].entity_type, chain[k].subchain = kinds.Polymer, asym
            chain[k].label_seq = label
        for k, (residue, own) in enumerate(zip(chain, part, strict=True)):
            if polymer[k]:
                continue
            # waters too have a label each: by it OpenMM tells them apart
            residue.subchain = next(labels)
            residue.entity_type = kinds.Water if own.is_water else kinds.NonPolymer
            entity = entities.setdefault((residue.name, own.is_water), gemmi.Entity(""))
            entity.entity_type = residue.entity_type
            entity.subchains = [*entity.subchains, residue.subchain]
    for number, entity in enumerate(entities.values(), start=1):
        entity.name = str(number)
    structure.entities = gemmi.EntityList(list(entities.values()))
    number_of = {asym: e.name for e in structure.entities for asym in e.subchains}
    for chain in structure[0]:
        for residue in chain:
            residue.entity_id = number_of[residue.subchain]


def _is_polymer(residue: Any, own: Residue, bonded: Any) -> bool:
    import gemmi

    if own.is_water:
        return False
    if own.nucleotide is not None and bonded[own.nucleotide].any():
        return True
    # a nucleotide or an amino acid by itself is a ligand
    if own.nucleotide is not None:
        return False
    return residue.entity_type == gemmi.EntityType.Polymer or (own.is_peptide and not own.is_het)


def _polymer_type(strand: Sequence[Residue], chain: Any) -> Any:
    import gemmi

    if all(residue.nucleotide is None for residue in strand):
        kind = chain.get_polymer().check_polymer_type()
        peptide = kind == gemmi.PolymerType.Unknown and any(r.is_peptide for r in strand)
        return gemmi.PolymerType.PeptideL if peptide else kind
    sugars = {residue.is_dna for residue in strand if residue.nucleotide is not None}
    if len(sugars) > 1:
        return gemmi.PolymerType.DnaRnaHybrid
    return gemmi.PolymerType.Dna if sugars.pop() else gemmi.PolymerType.Rna


def _labels() -> Iterator[str]:
    """A, B, … Z, AA, AB and so on."""
    for length in count(1):
        yield from map("".join, product(_LETTERS, repeat=length))
