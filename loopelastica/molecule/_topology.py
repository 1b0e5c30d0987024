"""The table of nucleotides: which atom is where, without coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Record

BACKBONE: Final = ("P", "O5'", "C5'", "C4'", "C3'", "O3'")
"""The six atoms, in chain order, whose mean is the centroid of a nucleotide."""

RING: Final = ("N1", "C2", "N3", "C4", "C5", "C6")
"""The six-membered ring that every base has."""

ATOM_NAMES: Final = (
    *BACKBONE,
    *("OP1", "OP2", "C2'", "C1'", "O4'", "O2'"),
    *RING,
    *("N7", "C8", "N9", "N2", "N4", "N6", "O2", "O4", "O6", "C7"),
    *("S4", "S6", "F2'", "N2'", "S2'"),
)
"""Columns of :attr:`Nucleotides.atom_index`, in today's (remediated) PDB names."""

_COLUMN: Final = {name: column for column, name in enumerate(ATOM_NAMES)}

_OTHER_NAMES: Final = {
    "O1P": "OP1",
    "O2P": "OP2",
    # The methyl of thymine and of the 5-methylated pyrimidines, by dictionary and force field.
    "C5M": "C7",
    "CM5": "C7",
    "C5A": "C7",
}


def column_of(name: str) -> int:
    """Column of an atom name, old or new, in :attr:`Nucleotides.atom_index`; −1 if it has none.

    >>> column_of("P"), column_of("C5*") == column_of("C5'"), column_of("H8")
    (0, True, -1)
    """
    name = name.strip().replace("*", "'")
    return _COLUMN.get(_OTHER_NAMES.get(name, name), -1)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Nucleotides(Record):
    """The nucleotides of a structure in the order of the file; arrays over n nucleotides.

    Attributes
    ----------
    chain : (n,) array of str
        Chain identifier, else segment identifier, else "".
    resid : (n,) array of int
        Residue number as in the file.
    icode : (n,) array of str
        Insertion code or "".
    resname : (n,) array of str
        Residue name as in the file.
    letter : (n,) array of str
        Parent base read from the atoms: A, C, G, U, T; "N" where the base is missing.
    is_dna : (n,) array of bool
        True where the sugar carries nothing at C2'.
    altloc : (n,) array of str
        Alternative location that was taken; "" where the file has one location only.
    atom_index : (n, k) array of int
        Index among all atoms of the structure for each of ``ATOM_NAMES``; −1 where missing.
    """

    chain: NDArray[np.str_]
    resid: NDArray[np.int64]
    icode: NDArray[np.str_]
    resname: NDArray[np.str_]
    letter: NDArray[np.str_]
    is_dna: NDArray[np.bool_]
    altloc: NDArray[np.str_]
    atom_index: NDArray[np.int64]

    def __repr__(self) -> str:
        return f"<Nucleotides: {len(self)} in {len(set(self.chain))} chain(s)>"

    def __len__(self) -> int:
        """Return the number of nucleotides."""
        return len(self.resid)

    def columns(self, names: Sequence[str]) -> NDArray[np.int64]:
        """Atom indices (n, len(names)) of the named atoms; −1 where missing.

        Raises
        ------
        ValueError
            If one of `names` is not in ``ATOM_NAMES``.
        """
        columns = [column_of(name) for name in names]
        if -1 in columns:
            raise ValueError(f"`names`: {names[columns.index(-1)]!r} is not among {ATOM_NAMES}")
        return self.atom_index[:, columns]

    def number(self, i: int) -> str:
        """Residue number with its insertion code, such as "12" or "3B"."""
        return f"{self.resid[i]}{self.icode[i]}"

    def label(self, i: int) -> str:
        """Label such as "A.G12", "A.DG3^B" (insertion code) or "G12" (no chain)."""
        chain = f"{self.chain[i]}." if self.chain[i] else ""
        icode = f"^{self.icode[i]}" if self.icode[i] else ""
        return f"{chain}{self.resname[i]}{self.resid[i]}{icode}"
