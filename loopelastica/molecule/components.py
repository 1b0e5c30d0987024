"""What the names of nucleotides mean: parent base, sugar, and the heavy atoms that belong there.

Names are those of the wwPDB and what older files and force fields write for them. Where a name says
nothing the atoms do (:mod:`._recognition`).
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import lru_cache
from typing import Final, NamedTuple

import gemmi
import numpy as np

from loopelastica.molecule._recognition import RIBO, letters_of
from loopelastica.molecule._topology import ATOM_NAMES, BACKBONE, column_of

BASES: Final = "ACGUT"
"""Parent bases that can be built."""

METHYLATED: Final[dict[str, tuple[tuple[str, str], ...]]] = {
    # wwPDB residue name: (new atom, atom that carries it) each
    "5MU": (("C5M", "C5"),),
    "5MC": (("CM5", "C5"),),
    "2MG": (("CM2", "N2"),),
    "M2G": (("CM1", "N2"), ("CM2", "N2")),
    "6MZ": (("C9", "N6"),),
    "OMC": (("CM2", "O2'"),),
    "OMG": (("CM2", "O2'"),),
    "OMU": (("CM2", "O2'"),),
    "A2M": (("CM'", "O2'"),),
}
"""Common modified nucleotides that are a parent with methyl groups; names of the wwPDB."""

PHOSPHATE: Final = ("P", "OP1", "OP2")

_LONG_NAMES: Final = {"ADE": "A", "CYT": "C", "GUA": "G", "URA": "U", "URI": "U", "THY": "T"}
# +A, RA, RA5, DA3, A5, AN: dictionaries and force fields
_SHORT: Final = re.compile(r"\+?([RD]?)([ACGUTN])[35N]?")
# parents that neither gemmi's table nor the name tells
_PARENTS: Final = {
    **{"A2M": "A", "MA6": "A", "T6A": "A", "MIA": "A", "I": "G", "DI": "G", "YG": "G", "YYG": "G"},
    **{"QUO": "G", "GTP": "G", "GDP": "G", "ATP": "A", "CTP": "C", "UTP": "U", "CCC": "C"},
    **{"5MC": "C"},
    **{"U34": "U", "4SU": "U", "70U": "U", "CM0": "U", "3AU": "U", "UR3": "U", "CBV": "C"},
}
_OTHER_NAMES: Final = {"O1P": "OP1", "O2P": "OP2", "O3P": "OP3"}
_SUGAR: Final = ("O5'", "C5'", "C4'", "O4'", "C3'", "O3'", "C2'", "C1'")
_PYRIMIDINE: Final = ("N1", "C2", "O2", "N3", "C4", "C5", "C6")
_PURINE: Final = ("N9", "C8", "N7", "C5", "C6", "N1", "C2", "N3", "C4")
_BASE_ATOMS: Final = {
    "A": (*_PURINE, "N6"),
    "C": (*_PYRIMIDINE, "N4"),
    "G": (*_PURINE, "O6", "N2"),
    "U": (*_PYRIMIDINE, "O4"),
    "T": (*_PYRIMIDINE, "O4", "C7"),
}


class Component(NamedTuple):
    """What a residue name means.

    Attributes
    ----------
    letter : str
        Parent base, "N" where the name does not say which.
    is_dna : bool or None
        Whether the sugar is deoxyribose; None where the name does not say.
    """

    letter: str
    is_dna: bool | None


@lru_cache(maxsize=4096)
def component(resname: str) -> Component | None:
    """What a residue name means; None where it is no known nucleotide.

    Parameters
    ----------
    resname : str
        As files and force fields write it.

    Returns
    -------
    Component or None

    Examples
    --------
    >>> component("DT"), component("5MU").letter, component("RA5").letter, component("GLY")
    (Component(letter='T', is_dna=True), 'U', 'A', None)
    """
    name = resname.strip().upper()
    if name in _LONG_NAMES:
        letter = _LONG_NAMES[name]
        return Component(letter, True if letter == "T" else None)
    if short := _SHORT.fullmatch(name):
        is_dna = short[1] == "D" or (not short[1] and short[2] == "T")
        return Component(short[2], is_dna)
    known = gemmi.find_tabulated_residue(name)
    kinds = (gemmi.ResidueKind.RNA, gemmi.ResidueKind.DNA)
    if known.kind not in kinds and name not in _PARENTS:
        return None
    letter = _PARENTS.get(name, known.one_letter_code.upper())
    kind = known.kind == gemmi.ResidueKind.DNA if known.kind in kinds else None
    return Component(letter if letter in BASES else "N", kind)


def is_standard(resname: str) -> bool:
    """Whether a name is that of a nucleotide that can be built as it is.

    >>> is_standard("DU"), is_standard("5MU"), is_standard("PSU")
    (True, True, False)
    """
    name = resname.strip().upper()
    if name in METHYLATED:
        return True
    short = _SHORT.fullmatch(name)
    return name in _LONG_NAMES or (short is not None and short[2] != "N")


def atom_name(name: str, resname: str = "") -> str:
    """Today's wwPDB name of an atom of a nucleotide.

    >>> atom_name("O1P"), atom_name("C5*"), atom_name("C5M", "DT"), atom_name("C5M", "5MU")
    ('OP1', "C5'", 'C7', 'C5M')
    """
    name = name.strip().replace("*", "'")
    if name == "C5M" and resname.strip().upper() in ("T", "DT", "THY"):
        return "C7"
    return _OTHER_NAMES.get(name, name)


def expected_atoms(resname: str, letter: str, is_dna: bool) -> tuple[str, ...]:
    """Heavy atoms that a nucleotide has within a chain; of a modified one those that all have.

    >>> len(expected_atoms("G", "G", False)), len(expected_atoms("PSU", "U", False))
    (23, 11)
    """
    everywhere = (*PHOSPHATE, *_SUGAR)
    if not is_standard(resname) or letter not in _BASE_ATOMS:
        return everywhere
    base = _BASE_ATOMS["U" if letter == "T" and not is_dna else letter]
    return (*everywhere, *(() if is_dna else ("O2'",)), *base)


def sugar_of(names: Iterable[str]) -> bool | None:
    """Whether the atoms of a nucleotide are those of deoxyribose; None without C2' or C1'."""
    found = {name.replace("*", "'") for name in names}
    if any(name in found for name in RIBO):
        return False
    return True if {"C1'", "C2'", "C3'"} <= found else None


def letter_of(names: Iterable[str], is_dna: bool) -> str:
    """Parent base by the atoms, "N" where the ring of the base is not complete.

    >>> letter_of(["N1", "C2", "N3", "C4", "C5", "C6", "O4"], is_dna=False)
    'U'
    """
    table = np.full((1, len(ATOM_NAMES)), -1, dtype=np.int64)
    for name in names:
        if (column := column_of(name)) >= 0:
            table[0, column] = 0
    return str(letters_of(table, np.array([is_dna]))[0])


def is_nucleotide(resname: str, names: Iterable[str]) -> bool:
    """Whether a residue may stand in a chain of nucleotides, by its name or by its atoms.

    >>> is_nucleotide("U", ["P"]), is_nucleotide("HOH", ["O"])
    (True, False)
    >>> is_nucleotide("X1Y", ["P", "O5'", "C5'", "C4'", "C3'", "O3'", "C1'"])
    True
    """
    if component(resname) is not None:
        return True
    found = {atom_name(name) for name in names}
    return "C1'" in found and set(BACKBONE[1:]) <= found
