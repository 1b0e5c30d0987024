"""The atoms of a structure with a built loop: which stay, which are new, and what they are called.

All atoms but the loop's stay where they are, of alternative locations one. Left out are waters
within 3 Å of any model, for they were placed around the file's own loop, and hydrogens, which the
loop has none of; with `hydrogens` every nucleotide has its own instead (:mod:`.protonation`).
Nucleotides have today's wwPDB names throughout, or those of a force field.
"""

from __future__ import annotations

import itertools
import operator
from bisect import bisect_left
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.atoms.model import AtomModel
from loopelastica.molecule.components import METHYLATED, atom_name, is_standard
from loopelastica.molecule.neighbours import METALS, elements, one_location, waters
from loopelastica.molecule.nucleotides import NO_CHAIN, Structure, is_pdb, linked, strings
from loopelastica.molecule.obstacles import HALIDES
from loopelastica.molecule.origin import Origin, origin_of
from loopelastica.molecule.polymer import Monomer

if TYPE_CHECKING:
    from loopelastica.report.atoms import LoopAtoms

_WATER_A: Final = 3.0
_OVER: Final = 10_000
_IONS: Final = {
    **{name: name for name in (*METALS, *HALIDES)},
    # of CHARMM
    **{"SOD": "NA", "POT": "K", "CLA": "CL", "CAL": "CA", "CES": "CS", "LIT": "LI"},
}
HYDROGEN: Final = ("H", "D")


@dataclass(slots=True)
class Atom:
    """One atom of the files.

    Attributes
    ----------
    name, element : str
        The name of today's wwPDB.
    in_file : int or None
        Row among the structure's atoms.
    in_loop : int or None
        Row of the molecule of the built loop. Without either it is a new hydrogen.
    occupancy, b_factor : float
    charge : int
    """

    name: str
    element: str
    in_file: int | None = None
    in_loop: int | None = None
    occupancy: float = 1.0
    b_factor: float = 0.0
    charge: int = 0

    @property
    def is_new_hydrogen(self) -> bool:
        """Whether it is neither of the file nor of the molecule of the loop."""
        return self.in_file is None and self.in_loop is None


@dataclass(slots=True)
class Residue:
    """One residue of the files.

    Attributes
    ----------
    chain, segment : str
        As the input has them; a segment that says no more than the chain is left out.
    number : int
    icode, name : str
    is_het : bool
        Whether its atoms are HETATM records.
    is_water : bool
    letter : str
        Parent base of a nucleotide, else "".
    is_dna : bool
        Whether it is a nucleotide with deoxyribose.
    nucleotide : int or None
        Row in the table of nucleotides.
    built : int or None
        Place in the loop, from 0.
    first : int
        Row of its first atom in the structure.
    begins : bool
        Whether a chain begins with it.
    atoms : list of Atom
    """

    chain: str
    segment: str
    number: int
    icode: str
    name: str
    is_het: bool
    is_water: bool
    letter: str
    is_dna: bool
    nucleotide: int | None
    built: int | None
    first: int
    begins: bool = False
    atoms: list[Atom] = field(default_factory=list)

    @property
    def label(self) -> str:
        """Label such as "A.G12", "A.DG3^B" (insertion code) or "G12" (no chain)."""
        return self.monomer().label

    @property
    def is_peptide(self) -> bool:
        """Whether it has the backbone of an amino acid."""
        return {"N", "CA", "C"} <= {atom.name for atom in self.atoms}

    @property
    def hydrogens(self) -> set[str]:
        """Names of its hydrogens."""
        return {atom.name for atom in self.atoms if atom.element in HYDROGEN}

    def monomer(self, atoms_A: Mapping[str, Array] = MappingProxyType({})) -> Monomer:
        """The nucleotide that it is, with atoms or without."""
        return Monomer(
            chain=self.chain or self.segment,
            number=self.number,
            icode=self.icode,
            resname=self.name,
            letter=self.letter,
            is_dna=self.is_dna,
            atoms_A=atoms_A,
        )


@dataclass(slots=True, eq=False)
class Assembly:
    """The atoms of all models; they differ in coordinates only.

    Attributes
    ----------
    residues : list of Residue
        In the order of the input.
    origin : Origin
    bonded : (n_nucleotides, 2) array of bool
        Whether P and O3' of each nucleotide are bonded to the nucleotide before and after.
    hydrogens_A : list of dict
        Of each model: new hydrogens by nucleotide and today's name, Å.
    remarks : list of str
        One sentence for each thing that a user should be aware of.
    """

    residues: list[Residue]
    origin: Origin
    bonded: NDArray[np.bool_]
    hydrogens_A: list[dict[tuple[int, str], Array]] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    def atoms(self) -> Iterator[tuple[Residue, Atom]]:
        """All atoms in their order."""
        for residue in self.residues:
            for atom in residue.atoms:
                yield residue, atom

    @property
    def nucleotides(self) -> dict[int, Residue]:
        """Residues by their rows in the table of nucleotides."""
        return {r.nucleotide: r for r in self.residues if r.nucleotide is not None}


def assemble(atoms: LoopAtoms) -> Assembly:
    """The atoms of the files, heavy ones and the file's own hydrogens, under today's names.

    Parameters
    ----------
    atoms : LoopAtoms
        With at least one sound model.

    Returns
    -------
    Assembly
    """
    structure = atoms.structure
    bonded = _bonded(atoms)
    assembly = Assembly(_residues(atoms), origin_of(structure), bonded)
    for residue in assembly.residues:
        if residue.nucleotide is not None and residue.built is None:
            _name_today(residue)
    _mark_chains(assembly)
    return assembly


def _bonded(atoms: LoopAtoms) -> NDArray[np.bool_]:
    """Bonds of P and O3' of each nucleotide to its neighbours, those of the loop as it is built."""
    table, positions = atoms.structure.nucleotides, atoms.positions.copy()
    model = atoms.written[0]
    own = atoms.fold.hairpin.loop
    for name in ("P", "O3'"):
        rows = table.columns([name])[own, 0]
        built = model.positions_A[[model.molecule.index(k, name) for k in range(len(own))]]
        positions[rows[rows >= 0]] = built[rows >= 0]
    ends = table.columns(("O3'", "P"))
    joined = linked(table, positions) & (ends[:-1, 0] >= 0) & (ends[1:, 1] >= 0)
    for row in own.tolist():
        # the file may lack atoms of its own loop, the built one does not
        joined[max(row - 1, 0) : row + 1] = True
    out = np.zeros((len(table), 2), dtype=np.bool_)
    out[1:, 0] = out[:-1, 1] = joined
    return out


def _residues(atoms: LoopAtoms) -> list[Residue]:
    structure = atoms.structure
    source = structure.universe.atoms
    n = len(source)
    table = structure.nucleotides
    resindices = np.asarray(source.resindices)
    of_residue = {int(resindices[i]): k for k, i in enumerate(table.atom_index.max(axis=1))}
    place_in_loop = {int(row): k for k, row in enumerate(atoms.fold.hairpin.loop)}

    element = np.char.capitalize(_elements(structure))
    kept = one_location(structure) & ~_displaced(atoms) & np.isfinite(atoms.positions).all(axis=1)
    if not atoms.hydrogens:
        kept &= ~np.isin(element, HYDROGEN)
    names, records = strings(source, "names"), strings(source, "record_types")
    occupancy = np.asarray(getattr(source, "occupancies", np.ones(n)), dtype=float)
    b_factor = np.asarray(getattr(source, "tempfactors", np.zeros(n)), dtype=float)
    charge = np.asarray(getattr(source, "formalcharges", np.zeros(n)), dtype=int)
    chains, segments = strings(source, "chainIDs"), strings(source, "segids")
    resnames, icodes = (strings(structure.universe.residues, k) for k in ("resnames", "icodes"))
    resids = _numbers(structure)
    is_water = waters(structure)

    out: list[Residue] = []
    last = -1
    for i in range(n):
        here = int(resindices[i])
        nucleotide = of_residue.get(here)
        built = None if nucleotide is None else place_in_loop.get(nucleotide)
        if here != last and (kept[i] or built is not None):
            last = here
            chain = str(chains[i])
            segment = str(segments[i]) if segments[i] not in (chain, NO_CHAIN) else ""
            out.append(
                Residue(
                    chain,
                    segment,
                    number=int(resids[here]),
                    icode=str(icodes[here]),
                    name=str(resnames[here]) or "UNK",
                    is_het=str(records[i]) == "HETATM",
                    is_water=bool(is_water[i]),
                    letter="" if nucleotide is None else str(table.letter[nucleotide]),
                    is_dna=nucleotide is not None and bool(table.is_dna[nucleotide]),
                    nucleotide=nucleotide,
                    built=built,
                    first=i,
                )
            )
            if built is not None:
                _fill_in(out[-1], atoms.written[0])
        if kept[i] and built is None:
            out[-1].atoms.append(
                Atom(str(names[i]), str(element[i]), i, None, float(occupancy[i]),
                     float(b_factor[i]), int(charge[i]))
            )  # fmt: skip
    return [residue for residue in out if residue.atoms]


def _numbers(structure: Structure) -> NDArray[np.int64]:
    """Residue numbers as the input has them."""
    numbers = np.asarray(structure.universe.residues.resids, dtype=np.int64)
    if structure.source is not None and is_pdb(Path(structure.source)):
        # MDAnalysis counts on where the four digits of a PDB file seem to have run over
        return np.where(numbers >= _OVER, numbers % _OVER, numbers)
    return numbers


def _elements(structure: Structure) -> NDArray[np.str_]:
    """Element of each atom as the file has it, else from its name; of an ion from its residue."""
    atoms = structure.universe.atoms
    own = strings(atoms, "elements")
    resnames = np.char.upper(strings(structure.universe.residues, "resnames"))
    residue = np.asarray(atoms.resindices)
    # I is inosine too
    bare = np.bincount(residue)[residue] == 1
    ions = np.where(bare, np.array([_IONS.get(name, "") for name in resnames])[residue], "")
    return np.where(own != "", own, np.where(ions != "", ions, elements(structure)))


def _fill_in(residue: Residue, model: AtomModel) -> None:
    """The built nucleotide in place of the file's own."""
    molecule = model.molecule
    assert residue.built is not None
    kind = molecule.kinds[residue.built]
    if kind.renamed:
        residue.is_het = False
    if kind.renamed or is_standard(residue.name):
        residue.name = kind.standard
    for row in molecule.loop_atoms:
        if molecule.residue[row] == residue.built:
            element = molecule.mol.GetAtomWithIdx(row).GetSymbol()
            residue.atoms.append(Atom(molecule.names[row], element, in_loop=row))


def _name_today(residue: Residue) -> None:
    """Today's wwPDB names of a nucleotide of the file; hydrogens keep theirs."""
    for atom in residue.atoms:
        atom.name = atom_name(atom.name, residue.name)
    plain = is_standard(residue.name) and residue.name.upper() not in METHYLATED
    # thymine on ribose and uracil on deoxyribose are others
    if plain and residue.letter in ("ACGT" if residue.is_dna else "ACGU"):
        residue.name = f"D{residue.letter}" if residue.is_dna else residue.letter


def _mark_chains(assembly: Assembly) -> None:
    """Where chains begin: by the input's TER records, else where names or bonds end."""
    ends = assembly.origin.ends
    by_records = None if ends is None else sorted(ends)
    for residue in assembly.residues[:1]:
        residue.begins = True
    for before, residue in itertools.pairwise(assembly.residues):
        if (before.chain, before.segment) != (residue.chain, residue.segment):
            residue.begins = True
        elif by_records is not None:
            passed = (bisect_left(by_records, one.first) for one in (before, residue))
            residue.begins = operator.ne(*passed)
        else:
            residue.begins = _breaks(assembly, before, residue)


def _breaks(assembly: Assembly, before: Residue, residue: Residue) -> bool:
    """Whether a strand begins that is neither bonded to the one before nor numbered after it."""
    if before.nucleotide is None or residue.nucleotide is None:
        return before.is_peptide != residue.is_peptide and not (before.is_het or residue.is_het)
    joined = bool(assembly.bonded[residue.nucleotide, 0])
    return not joined and residue.number - before.number <= 1 and not residue.icode


def _displaced(atoms: LoopAtoms) -> NDArray[np.bool_]:
    """Waters in the way of any model; the whole molecule goes."""
    from scipy.spatial import cKDTree

    water = np.flatnonzero(waters(atoms.structure))
    out = np.zeros(len(atoms.positions), dtype=np.bool_)
    if len(water) == 0:
        return out
    loop = np.concatenate([m.positions_A[m.molecule.loop_atoms] for m in atoms.written])
    near = cKDTree(loop).query(atoms.positions[water], distance_upper_bound=_WATER_A)[0]
    resindices = atoms.structure.universe.atoms.resindices
    gone = np.unique(resindices[water[np.isfinite(near)]])
    out[water] = np.isin(resindices[water], gone)
    return out
