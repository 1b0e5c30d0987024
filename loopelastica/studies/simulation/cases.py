"""What is handed to a simulation: folded and built models as users get them, and natives."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from loopelastica._arrays import Array
from loopelastica._names import safe_name
from loopelastica.errors import LoopelasticaError

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
    hydrogens : bool
        Whether OpenMM's Modeller has to add them.
    """

    source: str
    name: str
    kind: str
    sequence: str
    loop: frozenset[tuple[str, str]] = frozenset()
    path: Path | None = None
    failure: str | None = None
    hydrogens: bool = True

    def row(self) -> dict[str, Any]:
        """The columns that say what it is."""
        return {
            "source": self.source,
            "name": self.name,
            "kind": self.kind,
            "sequence": self.sequence,
            "failure": self.failure,
        }


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
    from loopelastica.atoms.sequence import fold_sequence

    for kind, texts in sequences.items():
        for text in texts:
            structure, loop, positions = fold_sequence(text, kind == "DNA", max_candidates=TRIED)
            yield _modelled(folder, "built", text, structure, loop, positions)


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
    from loopelastica.folding.fold import fold
    from loopelastica.molecule.nucleotides import read_structure

    try:
        structure = read_structure(file)
        if len(structure.universe.atoms) > MOST_ATOMS:
            yield Case("folded", file.name, "", "", failure=f"more than {MOST_ATOMS} atoms")
            return
        loops = fold(structure, all_models=False, max_candidates=TRIED)
    except LoopelasticaError as error:
        yield Case("folded", file.name, "", "", failure=str(error))
        return
    for loop in loops:
        if not loop.hairpin.contacts:
            name = f"{file.name} {loop.hairpin.name}"
            yield _modelled(folder, "folded", name, structure, loop, structure.positions(0))
            yield _native(folder, name, file, loop)


def _modelled(
    folder: Path, source: str, name: str, structure: Any, loop: Any, positions: Array
) -> Case:
    from loopelastica.atoms.model import build_atoms
    from loopelastica.report.atoms import LoopAtoms, write_pdb

    case = _case(source, name, loop)
    if loop.failure is not None:
        return replace(case, failure=loop.failure)
    for candidate in loop.candidates:
        alone = replace(loop, candidates=(candidate,))
        try:
            (model,) = build_atoms(structure, alone, positions=positions)
        except LoopelasticaError as error:
            return replace(case, failure=str(error))
        if model.checks.sound:
            path = folder / f"{safe_name(f'{source} {name}')}.pdb"
            write_pdb(path, LoopAtoms(structure, alone, (model,), positions))
            return replace(case, path=path)
    return replace(case, failure=f"none of {len(loop.candidates)} candidates is sound")


def _native(folder: Path, name: str, file: Path, loop: Any) -> Case:
    case = _case("native", name, loop)
    try:
        path = folder / f"{safe_name(f'native {name}')}.pdb"
        write_native(file, path)
    except LoopelasticaError as error:
        return replace(case, failure=str(error))
    return replace(case, path=path)


def write_native(file: Path, path: Path) -> None:
    """The nucleotides of a file's first model, heavy atoms by today's names, as a PDB file.

    Parameters
    ----------
    file : Path
        A structure.
    path : Path
        What is written. Proteins, ligands, ions and waters are left out.
    """
    import gemmi

    from loopelastica._files import write_text
    from loopelastica.molecule.chains import chains_of
    from loopelastica.molecule.components import METHYLATED, is_standard
    from loopelastica.molecule.entry import read_entry

    model = gemmi.Model(1)
    for chain in chains_of(read_entry(file)):
        own = gemmi.Chain(chain.name or "A")
        for monomer in chain.slots:
            residue = gemmi.Residue()
            residue.name = monomer.resname
            if is_standard(monomer.resname) and monomer.resname not in METHYLATED:
                residue.name = ("D" if monomer.is_dna else "") + monomer.letter
            residue.seqid = gemmi.SeqId(monomer.number, monomer.icode or " ")
            for name, at in monomer.atoms_A.items():
                atom = gemmi.Atom()
                atom.name, atom.element = name, gemmi.Element(name[0])
                atom.pos = gemmi.Position(*at)
                residue.add_atom(atom)
            own.add_residue(residue)
        model.add_chain(own)
    structure = gemmi.Structure()
    structure.add_model(model)
    structure.setup_entities()
    write_text(path, structure.make_pdb_string())


def _case(source: str, name: str, loop: Any) -> Case:
    hairpin = loop.hairpin
    numbers = zip(hairpin.resid.tolist(), hairpin.icode.tolist(), strict=True)
    return Case(
        source,
        name,
        "DNA" if hairpin.is_dna else "RNA",
        hairpin.sequence,
        frozenset(
            (hairpin.chain[:1] or "A", f"{number}{icode}".strip()) for number, icode in numbers
        ),
    )
