"""Find the nucleotides of a Universe by their atoms, never by their residue names.

A nucleotide is a residue with C1', C3', C4' and a base ring (N1 C2 N3 C4 C5 C6) in one residue: a
free adenine has no sugar, an amino acid has neither. A sugar with its whole phosphate backbone but
without a base (an abasic or disordered site) counts too, because the chain passes through it.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.molecule._topology import ATOM_NAMES, BACKBONE, RING, Nucleotides, column_of

_SUGAR = ("C1'", "C3'", "C4'")
# A substituent at C2' marks the A-form sugars of RNA; 2'-fluoro, -amino and -thio RNA have no O2'.
RIBO: Final = ("O2'", "F2'", "N2'", "S2'")
_LONGEST = 32
NO_CHAIN: Final = "SYSTEM"
"""The segment name that MDAnalysis invents where the file has none."""


class _Columns(dict[str, int]):
    """Atom name → column, each distinct name looked up once."""

    def __missing__(self, name: str) -> int:
        self[name] = column = column_of(name)
        return column


def recognize(atoms: Any) -> Nucleotides:
    """Table of the nucleotides among some atoms, in the order of their residues.

    Parameters
    ----------
    atoms : MDAnalysis.AtomGroup
        Atoms need names; chains, insertion codes, altlocs and occupancies may be absent. Others of
        the same Universe do not count.

    Returns
    -------
    Nucleotides
        Of length 0 where there is none; atoms count as in the whole Universe. Of alternative
        locations the one of highest mean occupancy in its residue is taken, the first by letter
        among equals.
    """
    residue_of = np.asarray(atoms.resindices, dtype=np.int64)
    altloc = strings(atoms, "altLocs")
    occupancy = np.asarray(getattr(atoms, "occupancies", np.ones(len(atoms))), dtype=np.float64)
    chosen = preferred(residue_of, altloc, occupancy)
    rows, table = _index_table(atoms.names, residue_of, chosen, len(atoms.universe.residues))
    found = _is_nucleotide(table)
    rows, table = rows[found], table[found]

    residues = atoms.universe.residues[rows]
    chain = chains_of(atoms)[table[:, column_of("C1'")]]
    resid = np.asarray(residues.resids, dtype=np.int64)
    icode = strings(residues, "icodes")
    once = _one_of_each(chain, resid, icode, table, altloc, occupancy)
    table = table[once]
    is_dna = np.asarray(~_has(table, RIBO).any(axis=1), dtype=np.bool_)
    return Nucleotides(
        chain=chain[once],
        resid=resid[once],
        icode=icode[once],
        resname=strings(residues, "resnames")[once],
        letter=letters_of(table, is_dna),
        is_dna=is_dna,
        altloc=_taken(altloc, table),
        atom_index=np.where(table >= 0, atoms.indices[table], -1),
    )


def strings(group: Any, attribute: str) -> NDArray[np.str_]:
    """Strings of one topology attribute, stripped; all "" where the Universe lacks it."""
    values = getattr(group, attribute, None)
    if values is None or len(values) == 0:
        return np.zeros(len(group), dtype="U1")
    # NumPy makes room for the longest string in every place
    return np.array([str(value).strip()[:_LONGEST] for value in values])


def _has(table: NDArray[np.int64], names: tuple[str, ...]) -> NDArray[np.bool_]:
    return table[:, [column_of(name) for name in names]] >= 0


def _is_nucleotide(table: NDArray[np.int64]) -> NDArray[np.bool_]:
    sugar = _has(table, _SUGAR).all(axis=1)
    base = _has(table, RING).all(axis=1)
    return np.asarray(sugar & (base | _has(table, BACKBONE).all(axis=1)), dtype=np.bool_)


def preferred(
    residue_of: NDArray[np.int64], altloc: NDArray[np.str_], occupancy: Array
) -> NDArray[np.bool_]:
    """Mark the atoms without altloc and those of the one altloc chosen in each residue.

    Parameters
    ----------
    residue_of : (n,) array of int
        Residue of each atom.
    altloc : (n,) array of str
    occupancy : (n,) array

    Returns
    -------
    (n,) array of bool
    """
    found: NDArray[np.bool_] = np.asarray(altloc == "", dtype=np.bool_)
    alternative = np.flatnonzero(~found)
    alternative = alternative[np.argsort(residue_of[alternative], kind="stable")]
    for here in np.split(alternative, np.flatnonzero(np.diff(residue_of[alternative])) + 1):
        if len(here) == 0:
            break
        letters = np.unique(altloc[here])
        means = [occupancy[here[altloc[here] == letter]].mean() for letter in letters]
        # Occupancies come in hundredths: rounding keeps a tie a tie.
        chosen = letters[int(np.argmax(np.round(means, 4)))]
        found[here[altloc[here] == chosen]] = True
    return found


def _index_table(
    names: Any, residue_of: NDArray[np.int64], preferred: NDArray[np.bool_], n_residues: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Residues (n,) with the atoms of a sugar, and their atom index (n, len(ATOM_NAMES)).

    Preferred atoms come first, then those that are first in the file.
    """
    columns = _Columns()
    column = np.fromiter((columns[name] for name in names), dtype=np.int64, count=len(names))
    sugar = np.ones(n_residues, dtype=np.bool_)
    for name in _SUGAR:
        sugar &= np.bincount(residue_of[column == column_of(name)], minlength=n_residues) > 0
    rows = np.flatnonzero(sugar)
    row_of = np.full(n_residues, -1, dtype=np.int64)
    row_of[rows] = np.arange(len(rows))
    table = np.full((len(rows), len(ATOM_NAMES)), -1, dtype=np.int64)
    for chosen in (~preferred, preferred):
        index = np.flatnonzero(chosen & (column >= 0) & (row_of[residue_of] >= 0))[::-1]
        table[row_of[residue_of[index]], column[index]] = index
    return rows, table


def _taken(altloc: NDArray[np.str_], table: NDArray[np.int64]) -> NDArray[np.str_]:
    """Alternative location of the atoms in the table, "" where none of a nucleotide has one."""
    letters = np.where(table >= 0, altloc[table], "")
    first = np.argmax(letters != "", axis=1)
    return np.asarray(letters[np.arange(len(table)), first], dtype=np.str_)


def chains_of(atoms: Any) -> NDArray[np.str_]:
    """Chain identifiers, else segment identifiers, else "" for each atom."""
    segment = strings(atoms, "segids")
    segment[segment == NO_CHAIN] = ""
    chain = strings(atoms, "chainIDs")
    return np.where(chain == "", segment, chain)


def _one_of_each(
    chain: NDArray[np.str_],
    resid: NDArray[np.int64],
    icode: NDArray[np.str_],
    table: NDArray[np.int64],
    altloc: NDArray[np.str_],
    occupancy: Array,
) -> NDArray[np.int64]:
    """Rows left when two residues share one place (altlocs of different residue names)."""
    sugar = table[:, column_of("C1'")]
    best: dict[tuple[str, int, str] | int, int] = {}
    for row, atom in enumerate(sugar):
        # Without an altloc the same number twice is just sloppy numbering: keep both.
        place = (str(chain[row]), int(resid[row]), str(icode[row])) if altloc[atom] else -1 - row
        rival = best.get(place)
        if rival is None or occupancy[atom] > occupancy[sugar[rival]]:
            best[place] = row
    return np.array(sorted(best.values()), dtype=np.int64)


def letters_of(table: NDArray[np.int64], is_dna: NDArray[np.bool_]) -> NDArray[np.str_]:
    """Parent base: purine by its five-ring, then the exocyclic group at C6 (purine) or C4.

    The methyl of T counts on deoxyribose only: 5-methyluridine of tRNA is a modified U.
    """
    purine = _has(table, ("C8", "N9")).all(axis=1)
    guanine = _has(table, ("O6", "S6")).any(axis=1) | (
        _has(table, ("N2",))[:, 0] & ~_has(table, ("N6",))[:, 0]
    )
    uracil = _has(table, ("O4", "S4")).any(axis=1)
    methyl = _has(table, ("C7",))[:, 0]
    letter = np.full(len(table), "C", dtype="U1")
    letter[uracil] = "U"
    letter[uracil & methyl & is_dna] = "T"
    letter[purine] = "A"
    letter[purine & guanine] = "G"
    letter[~_has(table, RING).all(axis=1)] = "N"
    return letter
