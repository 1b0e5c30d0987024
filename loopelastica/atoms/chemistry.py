"""The molecule of a loop, built by rdkit from its sequence: atoms, bonds, charges, stereo.

Each nucleotide comes from rdkit's own sequence reader, with the names of the wwPDB; what the reader
lacks (thymine on ribose, uracil on deoxyribose, methylated bases) is edited in. Phosphates
carry their charge. Two atoms of the stem belong to the molecule, for the junctions are real bonds:
O3' of the 5' closing nucleotide and P of the 3' closing one, with their neighbours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

from loopelastica.molecule.components import METHYLATED

_LONG_NAMES: Final = {"ADE": "A", "CYT": "C", "GUA": "G", "URA": "U", "THY": "T"}

JUNCTION_5: Final = ("C3'", "O3'")
JUNCTION_3: Final = ("P", "OP1", "OP2", "O5'", "C5'")


@dataclass(frozen=True, slots=True)
class Residue:
    """One nucleotide to build: parent base, sugar, and its name in the structure."""

    letter: str
    is_dna: bool
    resname: str

    @property
    def methyls(self) -> tuple[tuple[str, str], ...]:
        """Methyl groups on the parent: (name, carrier)."""
        return METHYLATED.get(self.resname, ())

    @property
    def renamed(self) -> bool:
        """Whether the structure calls it something that is not built: its name must change."""
        # A, DA, rA, RA5, DA3, ADE: dictionaries and force fields
        short = self.resname.upper().rstrip("35N").removeprefix("D").removeprefix("R")
        return not self.methyls and _LONG_NAMES.get(self.resname.upper(), short) != self.letter

    @property
    def standard(self) -> str:
        """The wwPDB name of what is built."""
        if self.methyls:
            return self.resname
        if self.is_dna:
            return f"D{self.letter}"
        return "5MU" if self.letter == "T" else self.letter


@dataclass(frozen=True, slots=True, eq=False)
class LoopMolecule:
    """Heavy atoms of a loop and of the two junctions, as one rdkit molecule.

    Attributes
    ----------
    mol : rdkit.Chem.Mol
        Atoms in the order of the arrays below; no hydrogens, no conformer.
    names : tuple of str
        wwPDB names.
    residue : tuple of int
        Loop nucleotide (0 … n − 1); −1 the 5' closing one, n the 3' closing one.
    bonds : tuple of (int, int)
    residues : tuple of Residue
    """

    mol: Any
    names: tuple[str, ...]
    residue: tuple[int, ...]
    bonds: tuple[tuple[int, int], ...]
    residues: tuple[Residue, ...]

    def index(self, residue: int, name: str) -> int:
        """Row of an atom; ValueError if it is not there.

        Parameters
        ----------
        residue : int
            As in `residue`.
        name : str
            Of the wwPDB.

        Returns
        -------
        int
        """
        for row, (other, own) in enumerate(zip(self.residue, self.names, strict=True)):
            if other == residue and own == name:
                return row
        raise ValueError(f"`name`: nucleotide {residue} has no atom {name}")

    @property
    def loop_atoms(self) -> list[int]:
        """Rows of the loop's own atoms, in the order of the chain."""
        n = len(self.residues)
        return [row for row, r in enumerate(self.residue) if 0 <= r < n]


def loop_molecule(residues: Sequence[Residue]) -> LoopMolecule:
    """Join nucleotides 5' to 3', with the atoms of the stem that the two junctions touch.

    Raises
    ------
    ValueError
        If there is no residue, or one has a base that cannot be built.

    Examples
    --------
    >>> loop = loop_molecule([Residue("U", False, "U"), Residue("G", False, "G")])
    >>> loop.mol.GetNumAtoms(), len(loop.loop_atoms)
    (50, 43)
    """
    from rdkit import Chem

    if not residues:
        raise ValueError("`residues` is empty; a loop has at least one nucleotide")
    mol = Chem.RWMol()
    names: list[str] = []
    residue: list[int] = []
    n = len(residues)
    for number, part in [
        (-1, _fragment("CO", JUNCTION_5)),
        *((k, _nucleotide(r)) for k, r in enumerate(residues)),
        (n, _fragment("P(=O)([O-])OC", JUNCTION_3)),
    ]:
        offset = mol.GetNumAtoms()
        mol.InsertMol(part)
        names += [atom.GetProp("name") for atom in part.GetAtoms()]
        residue += [number] * part.GetNumAtoms()
        if offset:
            before = max(row for row in range(offset) if names[row] == "O3'")
            here = offset + names[offset:].index("P")
            mol.AddBond(before, here, Chem.BondType.SINGLE)
    Chem.SanitizeMol(mol)
    bonds = tuple((b.GetBeginAtomIdx(), b.GetEndAtomIdx()) for b in mol.GetBonds())
    return LoopMolecule(mol.GetMol(), tuple(names), tuple(residue), bonds, tuple(residues))


def _fragment(smiles: str, names: Sequence[str]) -> Any:
    from rdkit import Chem

    part = Chem.MolFromSmiles(smiles, sanitize=False)
    for atom, name in zip(part.GetAtoms(), names, strict=True):
        atom.SetProp("name", name)
    return part


@lru_cache
def _nucleotide(residue: Residue) -> Any:
    """A nucleotide with its charged 5' phosphate, open at P and at O3'."""
    from rdkit import Chem

    # flavors of rdkit's sequence reader: RNA or DNA with a phosphate at the 5' end
    whole = Chem.MolFromSequence(residue.letter, flavor=7 if residue.is_dna else 3)
    if whole is None or residue.letter not in "ACGUT":
        raise ValueError(f"`residues`: a nucleotide with base {residue.letter!r} cannot be built")
    mol = Chem.RWMol(whole)
    rows = {}
    for atom in mol.GetAtoms():
        name = atom.GetPDBResidueInfo().GetName().strip()
        atom.SetProp("name", name)
        # numbered by the reader, not by the structure
        atom.SetMonomerInfo(None)
        rows[name] = atom.GetIdx()
    mol.GetAtomWithIdx(rows["OP2"]).SetFormalCharge(-1)
    for name, carrier in residue.methyls:
        row = mol.AddAtom(Chem.Atom("C"))
        mol.GetAtomWithIdx(row).SetProp("name", name)
        mol.AddBond(rows[carrier], row, Chem.BondType.SINGLE)
    # the place of the O3' of the nucleotide before
    mol.RemoveAtom(rows["OP3"])
    for atom in mol.GetAtoms():
        atom.SetNoImplicit(False)
    return mol.GetMol()
