"""Names of nucleotides and of their atoms as programs for molecular dynamics write them.

``pdb`` is the wwPDB's, ``amber`` that of tleap's OL3 and OL15 (and of OpenMM's amber14): names of
atoms are the same, names of residues say where a chain ends. ``charmm`` is that of CHARMM36: RNA
and DNA share their names, a patch makes the sugar and the ends; of RNA H2'' is on C2' and H2' on
O2' (read in charmm36.xml of OpenMM 8 and in 1K5I as CHARMM wrote it). Modified nucleotides keep
their names, for each force field has its own.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from loopelastica._checks import one_of
from loopelastica.molecule.components import METHYLATED, is_standard
from loopelastica.molecule.polymer import Monomer

CONVENTIONS: Final = ("pdb", "amber", "charmm")
check_names: Final = one_of(*CONVENTIONS)

_CHARMM: Final = {"A": "ADE", "C": "CYT", "G": "GUA", "U": "URA", "T": "THY"}
_CHARMM_ATOMS: Final = {
    **{"OP1": "O1P", "OP2": "O2P", "OP3": "O3P", "HO5'": "H5T", "HO3'": "H3T"},
    **{"C7": "C5M", "H71": "H51", "H72": "H52", "H73": "H53"},
}
_CHARMM_RIBOSE: Final = {"H2'": "H2''", "HO2'": "H2'"}


def conventional(
    nucleotide: Monomer | str,
    is_dna: bool,
    names: Iterable[str],
    first: bool,
    last: bool,
    convention: str = "pdb",
) -> tuple[str, tuple[str, ...]]:
    """Names of a nucleotide and of its atoms by a convention.

    Parameters
    ----------
    nucleotide : Monomer or str
        Or the letter of its base.
    is_dna : bool
        Whether the sugar is deoxyribose.
    names : iterable of str
        Of the atoms, today's of the wwPDB.
    first, last : bool
        Whether the chain begins or ends with it.
    convention : {"pdb", "amber", "charmm"}
        Whose names.

    Returns
    -------
    resname : str
    names : tuple of str
        In the same order.

    Raises
    ------
    ValueError
        If the convention is unknown.

    Examples
    --------
    >>> conventional("G", False, ["O5'", "HO5'", "HO2'"], True, False, "amber")
    ('G5', ("O5'", "HO5'", "HO2'"))
    >>> conventional("G", False, ["O5'", "HO5'", "HO2'"], True, False, "charmm")
    ('GUA', ("O5'", 'H5T', "H2'"))
    """
    check_names("names", convention)
    atoms = tuple(names)
    letter, own = _letter_and_name(nucleotide, is_dna)
    if letter is None or convention == "pdb":
        return own, atoms
    if convention == "charmm":
        table = _CHARMM_ATOMS if is_dna else _CHARMM_ATOMS | _CHARMM_RIBOSE
        return _CHARMM[letter], tuple(table.get(name, name) for name in atoms)
    # a nucleotide with a phosphate is none of those that Amber begins a chain with
    begins = first and "P" not in atoms
    end = {(True, True): "N", (True, False): "5", (False, True): "3"}.get((begins, last), "")
    return f"{_standard(letter, is_dna)}{end}", atoms


def _letter_and_name(nucleotide: Monomer | str, is_dna: bool) -> tuple[str | None, str]:
    """The base of a standard nucleotide, None of others; and its present name."""
    if isinstance(nucleotide, str):
        return nucleotide, _standard(nucleotide, is_dna)
    name, letter = nucleotide.resname.strip().upper(), nucleotide.letter
    known = name not in METHYLATED and is_standard(name) and letter in _CHARMM
    return letter if known else None, nucleotide.resname


def _standard(letter: str, is_dna: bool) -> str:
    return f"D{letter}" if is_dna else letter
