"""The molecule of a strand, built by rdkit from its sequence: atoms, bonds, charges, stereo.

Each nucleotide comes from rdkit's own sequence reader, with the names of the wwPDB; what the reader
lacks (thymine on ribose, uracil on deoxyribose, methylated bases) is edited in. Phosphates
carry their charge. Atoms of the nucleotides before and after belong to the molecule, for the
junctions are real bonds: of a hairpin's closing pair O3' and P with their neighbours, of a strand's
flanks all that is there or is to be built.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

from loopelastica.molecule.components import METHYLATED

_LONG_NAMES: Final = {"ADE": "A", "CYT": "C", "GUA": "G", "URA": "U", "THY": "T"}

JUNCTION_5: Final = ("C3'", "O3'")
JUNCTION_3: Final = ("P", "OP1", "OP2", "O5'", "C5'")
"""Atoms of the nucleotides before and after that bonds and angles of the junctions have in them."""
BEYOND_5: Final = ("C5'", "C4'")
BEYOND_3: Final = ("C4'", "C3'", "O3'")
"""And those that torsions have, where they are there."""


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
    """Heavy atoms of a strand and of its two junctions, as one rdkit molecule.

    Attributes
    ----------
    mol : rdkit.Chem.Mol
        Atoms in the order of the arrays below; no hydrogens, no conformer.
    names : tuple of str
        wwPDB names.
    residue : tuple of int
        Nucleotide of the strand (0 … n − 1); −1 the one before, n the one after, −2 and n + 1 the
        next ones outwards.
    bonds : tuple of (int, int)
    kinds : mapping of int to Residue
        What each nucleotide is.
    n : int
        Nucleotides of the strand.
    rows : mapping of (int, str) to int
        Row of each atom.
    """

    mol: Any
    names: tuple[str, ...]
    residue: tuple[int, ...]
    bonds: tuple[tuple[int, int], ...]
    kinds: Mapping[int, Residue]
    n: int
    rows: Mapping[tuple[int, str], int]

    @property
    def symbols(self) -> tuple[str, ...]:
        """Element of each atom."""
        return tuple(atom.GetSymbol() for atom in self.mol.GetAtoms())

    @property
    def residues(self) -> tuple[Residue, ...]:
        """The strand's own nucleotides."""
        return tuple(self.kinds[k] for k in range(self.n))

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
        row = self.rows.get((residue, name))
        if row is None:
            raise ValueError(f"`name`: nucleotide {residue} has no atom {name}")
        return row

    @property
    def loop_atoms(self) -> list[int]:
        """Rows of the strand's own atoms, in the order of the chain."""
        return [row for row, r in enumerate(self.residue) if 0 <= r < self.n]


def loop_molecule(
    residues: Sequence[Residue],
    beyond_5: Collection[str] = BEYOND_5,
    beyond_3: Collection[str] = BEYOND_3,
) -> LoopMolecule:
    """Join nucleotides 5' to 3', with the atoms of the stem that the two junctions touch.

    Parameters
    ----------
    residues : sequence of Residue
        Those of the loop.
    beyond_5, beyond_3 : collection of str
        Which of the atoms that torsions alone have are there.

    Returns
    -------
    LoopMolecule

    Raises
    ------
    ValueError
        If there is no residue, or one has a base that cannot be built.

    Examples
    --------
    >>> loop = loop_molecule([Residue("U", False, "U"), Residue("G", False, "G")])
    >>> loop.mol.GetNumAtoms(), len(loop.loop_atoms)
    (55, 43)
    """
    if not residues:
        raise ValueError("`residues` is empty; a loop has at least one nucleotide")
    n = len(residues)
    anything = Residue("U", False, "U")
    parts: dict[int, tuple[Residue, Collection[str] | None]] = {
        -1: (anything, (*JUNCTION_5, *beyond_5))
    }
    parts |= {k: (residue, None) for k, residue in enumerate(residues)}
    parts[n] = (anything, (*JUNCTION_3, *beyond_3))
    return strand_molecule(parts, n)


def strand_molecule(
    parts: Mapping[int, tuple[Residue, Collection[str] | None]], n: int
) -> LoopMolecule:
    """Join nucleotides 5' to 3', of some of them only named atoms.

    Parameters
    ----------
    parts : mapping of int to (Residue, collection of str or None)
        By number, as in `LoopMolecule.residue`, 5' to 3'; None: all atoms. Names that the
        nucleotide does not have mean nothing.
    n : int
        Nucleotides of the strand itself.

    Returns
    -------
    LoopMolecule

    Raises
    ------
    ValueError
        If a base cannot be built.
    """
    from rdkit import Chem

    mol = Chem.RWMol()
    rows: dict[tuple[int, str], int] = {}
    for number, (kind, names) in parts.items():
        part = _nucleotide(kind, None if names is None else frozenset(names))
        offset = mol.GetNumAtoms()
        mol.InsertMol(part)
        for atom in part.GetAtoms():
            rows[number, atom.GetProp("name")] = offset + atom.GetIdx()
        before, here = rows.get((number - 1, "O3'")), rows.get((number, "P"))
        if before is not None and here is not None:
            mol.AddBond(before, here, Chem.BondType.SINGLE)
    Chem.SanitizeMol(mol)
    bonds = tuple((b.GetBeginAtomIdx(), b.GetEndAtomIdx()) for b in mol.GetBonds())
    return LoopMolecule(
        mol.GetMol(),
        tuple(name for _, name in rows),
        tuple(number for number, _ in rows),
        bonds,
        {number: kind for number, (kind, _) in parts.items()},
        n,
        rows,
    )


@lru_cache
def _nucleotide(residue: Residue, names: frozenset[str] | None = None) -> Any:
    """A nucleotide with its charged 5' phosphate, open at P and at O3'; only the named atoms."""
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
    if names is not None:
        unwanted = [a.GetIdx() for a in mol.GetAtoms() if a.GetProp("name") not in names]
        for row in reversed(unwanted):
            for neighbour in mol.GetAtomWithIdx(row).GetNeighbors():
                # what has lost a neighbour has no hand
                neighbour.SetChiralTag(Chem.ChiralType.CHI_UNSPECIFIED)
            mol.RemoveAtom(row)
    return mol.GetMol()


def atom_names(residue: Residue) -> tuple[str, ...]:
    """Names of all heavy atoms of a nucleotide in the order of the wwPDB."""
    return tuple(atom.GetProp("name") for atom in _nucleotide(residue).GetAtoms())
