"""What is handed to a simulation: folded and built models as users get them, and natives."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import gemmi
import numpy as np

from loopelastica._arrays import Array
from loopelastica._files import write_text
from loopelastica._names import safe_name
from loopelastica.atoms.conventions import conventional
from loopelastica.atoms.hairpin import fold_sequence
from loopelastica.atoms.hydrogens import add_hydrogens
from loopelastica.atoms.model import build_atoms
from loopelastica.atoms.sequence import read_sequence
from loopelastica.atoms.terminals import chain_bonds, phosphates_at_5, without_phosphate
from loopelastica.errors import LoopelasticaError
from loopelastica.folding.fold import fold
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.chains import chains_of
from loopelastica.molecule.components import METHYLATED, is_standard
from loopelastica.molecule.entry import read_entry
from loopelastica.molecule.nucleotides import Structure, read_structure
from loopelastica.molecule.polymer import Monomer
from loopelastica.report.atoms import LoopAtoms, write_pdb
from loopelastica.report.pdb import renamed

BUILT: Final = {
    "RNA": (
        "GGAC(UUU)GUCC",
        "GCGU(AAU)GCGC",
        "GGCAC(UUCG)GUGCC",
        "GGGC(GAAA)GCCC",
        "GGUGC(GCAA)GUGCC",
        "GCGAG(CUACA)UUCGU",
        "GGCUG(AAUCGA)UAGCC",
        "GACGC(UUAGCAA)GCGUC",
        "GCGAU(AAUCGAUU)GUUGC",
        "GGCC(AUAACUGAA)GGCU",
        "GGC(AGCAUUGACC)GUC",
    ),
    "DNA": (
        "GCGC(GAA)GCGC",
        "GGCAC(TTTT)GTGCC",
        "GCGTG(GAAA)CGCGC",
        "GCTC(ACTGT)GGGC",
        "GGCAG(TTTTTT)TTGCC",
        "GCGTC(ATTGCAA)GGCGC",
        "GGCTC(TACCATGG)GAGCC",
        "GCAGC(CATTACGAT)GCTGC",
        "CGATGC(AACCTTAGTA)GCATCG",
    ),
}
"""Twenty hairpins: loops of 3 to 10, among them GNRA, UNCG, and G·U and G·T pairs, closing too."""
MOST_ATOMS: Final = 5000
"""Larger structures are not simulated: their time would say nothing of the loop."""
TRIED: Final = 5
"""Candidates that are built, the first sound one counts."""


@dataclass(frozen=True, slots=True)
class Case:
    """One PDB file, or why there is none.

    Attributes
    ----------
    source : {"folded", "built", "native"}
    name : str
        Such as "2koc.pdb A6-9", or the sequence.
    kind : {"RNA", "DNA"}
    sequence : str
        The loop's with its closing pair.
    loop : frozenset of (str, str)
        Chain and number of the loop's nucleotides in the file.
    path : Path or None
    failure : str or None
    bare : Path or None
        The same without phosphates at 5' ends, where there are any.
    """

    source: str
    name: str
    kind: str
    sequence: str
    loop: frozenset[tuple[str, str]] = frozenset()
    path: Path | None = None
    failure: str | None = None
    bare: Path | None = None

    def row(self) -> dict[str, Any]:
        """The columns that say what it is."""
        return {
            "source": self.source,
            "name": self.name,
            "kind": self.kind,
            "sequence": self.sequence,
            "failure": self.failure,
        }

    def place(self, folder: Path, more: str = "") -> Path:
        """A path for its file."""
        return folder / f"{safe_name(f'{self.source} {self.name}{more}')}.pdb"


def built_cases(folder: Path, sequences: Mapping[str, tuple[str, ...]]) -> Iterator[Case]:
    """Hairpins of sequences, as ``build --hydrogens`` writes them.

    Parameters
    ----------
    folder : Path
        Where the files go.
    sequences : mapping of str to tuple of str
        By "RNA" and "DNA".

    Yields
    ------
    Case
    """
    for kind, texts in sequences.items():
        for text in texts:
            try:
                read = read_sequence(text, rna=kind == "RNA")
                hairpin = fold_sequence(read, max_candidates=TRIED)
            except LoopelasticaError as error:
                yield Case("built", text, kind, "", failure=str(error))
                continue
            case = _case("built", text, hairpin.fold, {})
            given = hairpin.structure, hairpin.fold, hairpin.positions_A
            yield _or_why(case, _modelled, folder, *given)


def file_cases(folder: Path, file: Path) -> Iterator[Case]:
    """The simple loops of a file, as ``fold --atoms --hydrogens`` writes them, and as they are.

    Parameters
    ----------
    folder : Path
        Where the files go.
    file : Path
        A structure.

    Yields
    ------
    Case
        Two for each loop without pairs to nucleotides outside; one where the file is refused.
    """
    try:
        structure = read_structure(file)
        if len(structure.universe.atoms) > MOST_ATOMS:
            yield Case("folded", file.name, "", "", failure=f"more than {MOST_ATOMS} atoms")
            return
        loops = fold(structure, all_models=False, max_candidates=TRIED)
    except LoopelasticaError as error:
        yield Case("folded", file.name, "", "", failure=str(error))
        return
    letters = renamed(structure)
    for loop in loops:
        if not loop.hairpin.contacts:
            name = f"{file.name} {loop.hairpin.name}"
            given = folder, structure, loop, structure.positions(0)
            yield _or_why(_case("folded", name, loop, letters), _modelled, *given)
            yield _or_why(_case("native", name, loop, letters), _native, folder, file, letters)


def _or_why(case: Case, made: Callable[..., Case], *given: Any) -> Case:
    """The case with its files, or with the reason why there are none."""
    try:
        return made(case, *given)
    except LoopelasticaError as error:
        return replace(case, failure=str(error))


def _modelled(
    case: Case, folder: Path, structure: Structure, loop: LoopFold, positions: Array
) -> Case:
    """The first sound candidate, as the command line writes it."""
    if loop.failure is not None:
        return replace(case, failure=loop.failure)
    for candidate in loop.candidates:
        alone = replace(loop, candidates=(candidate,))
        (model,) = build_atoms(structure, alone, positions=positions)
        if model.checks.sound:
            atoms = LoopAtoms(structure, alone, (model,), positions, hydrogens=True)
            write_pdb(path := case.place(folder), atoms)
            if phosphates_at_5(found := nucleotides(path), chain_bonds(found)):
                bare = case.place(folder, " without 5' phosphate")
                write_pdb(bare, replace(atoms, no_5_phosphate=True))
                return replace(case, path=path, bare=bare)
            return replace(case, path=path)
    return replace(case, failure=f"none of {len(loop.candidates)} candidates is sound")


def _native(case: Case, folder: Path, file: Path, letters: Mapping[str, str]) -> Case:
    """The nucleotides of the first model with hydrogens of ours; all else is left out."""
    found = [replace(m, chain=letters.get(m.chain, m.chain)) for m in nucleotides(file)]
    write_nucleotides(path := case.place(folder), found)
    if phosphates := phosphates_at_5(found, chain_bonds(found)):
        bare = case.place(folder, " without 5' phosphate")
        write_nucleotides(
            bare, [without_phosphate(m) if k in phosphates else m for k, m in enumerate(found)]
        )
        return replace(case, path=path, bare=bare)
    return replace(case, path=path)


def nucleotides(file: Path) -> list[Monomer]:
    """The nucleotides of a file's first model that are there, with their heavy atoms.

    Parameters
    ----------
    file : Path
        A structure.

    Returns
    -------
    list of Monomer
    """
    chains = chains_of(read_entry(file))
    return [monomer for chain in chains for monomer in chain.slots if monomer.atoms_A]


def write_nucleotides(path: Path, monomers: Sequence[Monomer]) -> None:
    """Write nucleotides with all their hydrogens, and nothing else, as a PDB file.

    Parameters
    ----------
    path : Path
        What is written.
    monomers : sequence of Monomer
        With heavy atoms.
    """
    hydrogens = add_hydrogens(monomers, chain_bonds(monomers), np.zeros((0, 3)))
    chains: dict[str, gemmi.Chain] = {}
    for monomer, own in zip(monomers, hydrogens, strict=True):
        residue = gemmi.Residue()
        standard = is_standard(monomer.resname) and monomer.resname not in METHYLATED
        name = conventional(monomer.letter, monomer.is_dna, (), False, False)[0]
        residue.name = name if standard else monomer.resname
        residue.seqid = gemmi.SeqId(monomer.number, monomer.icode or " ")
        for name, at in {**monomer.atoms_A, **own}.items():
            atom = gemmi.Atom()
            atom.name, atom.element = name, gemmi.Element(name[0])
            atom.pos = gemmi.Position(*at)
            residue.add_atom(atom)
        chains.setdefault(monomer.chain, gemmi.Chain(monomer.chain)).add_residue(residue)
    model = gemmi.Model(1)
    for chain in chains.values():
        model.add_chain(chain)
    structure = gemmi.Structure()
    structure.add_model(model)
    structure.setup_entities()
    write_text(path, structure.make_pdb_string(gemmi.PdbWriteOptions(cryst1_record=False)))


def _case(source: str, name: str, loop: LoopFold, letters: Mapping[str, str]) -> Case:
    hairpin = loop.hairpin
    chain = letters.get(hairpin.chain, hairpin.chain)
    numbers = zip(hairpin.resid.tolist(), hairpin.icode.tolist(), strict=True)
    return Case(
        source,
        name,
        "DNA" if hairpin.is_dna else "RNA",
        hairpin.sequence,
        frozenset((chain, f"{number}{icode}".strip()) for number, icode in numbers),
    )
