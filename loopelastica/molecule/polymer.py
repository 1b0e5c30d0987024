"""Chains as they are meant: every nucleotide of the record, whether its atoms are there or not.

:mod:`.nucleotides` holds what can be folded: nucleotides that are there. A strand that is to be
filled is told by what is missing, so here a nucleotide is a name, a number and whatever atoms it
has; numbers are those of the author, and `record` is the place in the sequence of record.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record
from loopelastica.molecule._topology import BACKBONE

FEWEST_ATOMS = 4
"""Fewest of the six backbone atoms, C4' among them, that place a strand's end."""


@dataclass(frozen=True, slots=True, eq=False)
class Monomer(Record):
    """One nucleotide of a chain, there or missing.

    Attributes
    ----------
    chain : str
        The author's name of the chain; "" where it has none.
    number : int
        The author's residue number.
    icode : str
        Insertion code or "".
    resname : str
        Component name as the file (or the record) has it, such as "G", "DG", "5MU".
    letter : str
        Parent base: A, C, G, U, T; "N" where it is unknown.
    is_dna : bool
        Whether the sugar is deoxyribose.
    record : int or None
        Place in the sequence of record, from 1; None where the file gives none.
    atoms_A : mapping of str to (3,) array
        Heavy atoms that are there, by today's wwPDB names, Å; of alternative locations one. Empty:
        the nucleotide is missing.
    """

    chain: str
    number: int
    icode: str
    resname: str
    letter: str
    is_dna: bool
    record: int | None = None
    atoms_A: Mapping[str, Array] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """Label such as "A.G12", "A.DG3^B" (insertion code) or "G12" (no chain)."""
        chain = f"{self.chain}." if self.chain else ""
        icode = f"^{self.icode}" if self.icode else ""
        return f"{chain}{self.resname}{self.number}{icode}"

    @property
    def place(self) -> str:
        """Number and insertion code, such as "12" or "3B"."""
        return f"{self.number}{self.icode}"

    @property
    def backbone_A(self) -> Array:
        """P O5' C5' C4' C3' O3' (6, 3), Å; NaN where one is missing."""
        nowhere = np.full(3, np.nan)
        return np.array([self.atoms_A.get(name, nowhere) for name in BACKBONE])

    @property
    def usable(self) -> bool:
        """Whether a strand can end on it: C4' and four of the six backbone atoms."""
        return (
            "C4'" in self.atoms_A and sum(name in self.atoms_A for name in BACKBONE) >= FEWEST_ATOMS
        )


@dataclass(frozen=True, slots=True, eq=False)
class Gap(Record):
    """A stretch of a chain that is to be filled, with the nucleotides it lies between.

    Attributes
    ----------
    monomers : tuple of Monomer
        What is to be built, 5' to 3'. One that has some atoms keeps them.
    before, after : Monomer
        The usable nucleotides on the 5' and on the 3' side.
    beyond_5, beyond_3 : Monomer or None
        Their own neighbours outwards, where a bond joins them; None at an end of the chain.
    given : bool
        Whether the sequence is the user's, not the file's.
    remarks : tuple of str
        One sentence for each thing that a user should be aware of.
    replaces : tuple of Monomer
        What is there now and is given up for it, where a user asks for a strand that exists.
    """

    monomers: tuple[Monomer, ...]
    before: Monomer
    after: Monomer
    beyond_5: Monomer | None = None
    beyond_3: Monomer | None = None
    given: bool = False
    remarks: tuple[str, ...] = ()
    replaces: tuple[Monomer, ...] = ()

    def __len__(self) -> int:
        """Return the number of nucleotides to be built."""
        return len(self.monomers)

    @property
    def chain(self) -> str:
        """The author's name of the chain."""
        return self.monomers[0].chain

    @property
    def sequence(self) -> str:
        """Parent bases of what is built, 5' to 3'."""
        return "".join(monomer.letter for monomer in self.monomers)

    @property
    def context(self) -> str:
        """The same, with the nucleotides before and after."""
        return f"{self.before.letter}{self.sequence}{self.after.letter}"

    @property
    def kind(self) -> str:
        """Sugars of what is built: "RNA", "DNA" or "DNA/RNA"."""
        kinds = {"DNA" if monomer.is_dna else "RNA" for monomer in self.monomers}
        return "/".join(sorted(kinds))

    @property
    def name(self) -> str:
        """Name such as "A.6-9", as the user gives it; "A.6" where it is one nucleotide."""
        first, last = self.monomers[0].place, self.monomers[-1].place
        numbers = first if len(self) == 1 else f"{first}-{last}"
        return f"{self.chain}.{numbers}" if self.chain else numbers


@dataclass(frozen=True, slots=True, eq=False)
class HeavyAtoms(Record):
    """The heavy atoms of one model, one alternative location of each.

    Attributes
    ----------
    positions_A : (N, 3) array
        Å.
    element : (N,) array of str
        Such as "C", "MG".
    name : (N,) array of str
        Atom names as in the file.
    residue : (N,) array of int
        Row in `labels`.
    labels : tuple of str
        One per residue, as :attr:`Monomer.label`.
    water, metal : (N,) array of bool
        Of waters; of metal ions.
    places : tuple of (str, int, str, str)
        Chain, number, insertion code and name of each residue, as the author has them.
    """

    positions_A: Array
    element: NDArray[np.str_]
    name: NDArray[np.str_]
    residue: NDArray[np.int64]
    labels: tuple[str, ...]
    water: NDArray[np.bool_]
    metal: NDArray[np.bool_]
    places: tuple[tuple[str, int, str, str], ...] = ()

    def label(self, row: int) -> str:
        """Residue and name of an atom, such as "A.G12 C5'"."""
        return f"{self.labels[self.residue[row]]} {self.name[row]}"

    def without(self, labels: Collection[str]) -> HeavyAtoms:
        """The atoms of all residues but those of some labels.

        Parameters
        ----------
        labels : collection of str
            As in `labels`.

        Returns
        -------
        HeavyAtoms
        """
        own = [row for row, label in enumerate(self.labels) if label in labels]
        return self.grown((), np.flatnonzero(np.isin(self.residue, own))) if own else self

    def grown(self, built: Sequence[BuiltAtoms], without: NDArray[np.int64]) -> HeavyAtoms:
        """These atoms with more of them in some residues, and without others.

        Parameters
        ----------
        built : sequence of BuiltAtoms
            A nucleotide each; one that is there gets more atoms.
        without : (w,) array of int
            Rows that are left out.

        Returns
        -------
        HeavyAtoms
        """
        kept = np.ones(len(self.residue), dtype=np.bool_)
        kept[without] = False
        rows = {label: row for row, label in enumerate(self.labels)}
        places = list(self.places)
        for one in built:
            if one.monomer.label not in rows:
                rows[one.monomer.label] = len(rows)
                m = one.monomer
                places.append((m.chain, m.number, m.icode, m.resname))
        residue = [np.full(len(b.names), rows[b.monomer.label]) for b in built]
        none = np.zeros(sum(len(b.names) for b in built), dtype=np.bool_)
        return HeavyAtoms(
            positions_A=np.concatenate([self.positions_A[kept], *(b.positions_A for b in built)]),
            element=np.concatenate([self.element[kept], *(b.elements for b in built)]),
            name=np.concatenate([self.name[kept], *(b.names for b in built)]),
            residue=np.concatenate([self.residue[kept], *residue]).astype(np.int64),
            labels=tuple(rows),
            water=np.concatenate([self.water[kept], none]),
            metal=np.concatenate([self.metal[kept], none]),
            places=tuple(places),
        )


class BuiltAtoms(Protocol):
    """Atoms that a nucleotide has got."""

    @property
    def monomer(self) -> Monomer:
        """The nucleotide as it was."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the atoms."""

    @property
    def elements(self) -> tuple[str, ...]:
        """Their elements."""

    @property
    def positions_A(self) -> Array:
        """Where they are, (k, 3), Å."""
