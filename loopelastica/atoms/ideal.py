"""Ideal bond lengths (Å) and angles (°) of nucleotides, each with its source.

Sugar and phosphate: Parkinson, Vojtechovsky, Clowney, Brünger & Berman, Acta Cryst. D52 (1996) 57,
doi:10.1107/S0907444995011115, read in the table ParkinsonBerman_ActaCrystD_1996_RNA.txt of the
public project rlabduke/javadev. It is for RNA; the C4'–O4' bond of DNA is that of RestraintLib
(Kowiel, Brzezinski, Gilski & Jaskolski, Nucleic Acids Res. 48 (2020) 962,
doi:10.1093/nar/gkz1122), which finds the other sugar values of DNA and RNA alike within its errors.

Bases: Gilski, Zhao, Kowiel, Brzezinski, Turner & Jaskolski, Acta Cryst. B75 (2019) 235,
doi:10.1107/S2052520619002002, read in nucleic_acid_bases.py of mkowiel/restraintlib.

Glycosidic bond and its angles at the base: medians over the 62 unmodified nucleotides of 1EHZ
(tRNA-Phe, 1.93 Å), measured for this project; 1MSY (1.41 Å) agrees within 0.02 Å and 2°.

What is in no table (modified bases) comes from the MMFF94 equilibrium values that rdkit gives out.
"""

from __future__ import annotations

from typing import Final

_BONDS: Final = {
    "P OP1": 1.485,
    "P OP2": 1.485,
    "P O5'": 1.593,
    "P O3'": 1.607,
    "O5' C5'": 1.440,
    "C5' C4'": 1.510,
    "C4' C3'": 1.524,
    "C3' C2'": 1.525,
    "C2' C1'": 1.528,
    "O4' C1'": 1.414,
    "O4' C4'": 1.453,
    "O3' C3'": 1.423,
    "C2' O2'": 1.413,
}
_DNA_BONDS: Final = {"O4' C4'": 1.445}

_ANGLES: Final = {
    "OP1 P OP2": 119.6,
    "O5' P OP1": 108.1,
    "O5' P OP2": 108.3,
    "O3' P O5'": 104.0,
    "OP2 P O3'": 108.3,
    "OP1 P O3'": 107.4,
    "O5' C5' C4'": 110.2,
    "P O5' C5'": 120.9,
    "P O3' C3'": 119.7,
    "O4' C4' C3'": 105.5,
    "C5' C4' C3'": 115.5,
    "C5' C4' O4'": 109.2,
    "C1' O4' C4'": 109.6,
    "C4' C3' C2'": 102.7,
    "C3' C2' C1'": 101.5,
    "O4' C1' C2'": 106.4,
    "C1' C2' O2'": 110.6,
    "C3' C2' O2'": 113.3,
    "C4' C3' O3'": 110.6,
    "C2' C3' O3'": 111.0,
}
_GLYCOSIDIC: Final[dict[bool, dict[str, float]]] = {
    # purine
    True: {
        "C1' N9": 1.464,
        "N9 C1' C2'": 113.4,
        "O4' C1' N9": 108.2,
        "C1' N9 C4": 126.1,
        "C1' N9 C8": 127.8,
    },
    # pyrimidine
    False: {
        "C1' N1": 1.473,
        "N1 C1' C2'": 113.4,
        "O4' C1' N1": 108.2,
        "C1' N1 C2": 118.4,
        "C1' N1 C6": 121.1,
    },
}
_BASES: Final[dict[str, dict[str, float]]] = {
    "A": {
        "N1 C2": 1.339, "C2 N3": 1.330, "N3 C4": 1.346, "C4 C5": 1.382, "C5 C6": 1.406,
        "C6 N1": 1.353, "C5 N7": 1.388, "N7 C8": 1.311, "C8 N9": 1.370, "N9 C4": 1.374,
        "C6 N6": 1.334,
        "C6 N1 C2": 118.6, "N1 C2 N3": 129.4, "C2 N3 C4": 110.5, "N3 C4 C5": 126.9,
        "C4 C5 C6": 117.1, "C5 C6 N1": 117.5, "N3 C4 N9": 127.2, "C6 C5 N7": 132.2,
        "C5 C4 N9": 105.9, "C4 N9 C8": 105.7, "N9 C8 N7": 113.9, "C8 N7 C5": 103.8,
        "N7 C5 C4": 110.6, "N6 C6 N1": 118.6, "N6 C6 C5": 123.9,
    },
    "G": {
        "N1 C2": 1.372, "C2 N3": 1.327, "N3 C4": 1.352, "C4 C5": 1.379, "C5 C6": 1.418,
        "C6 N1": 1.392, "C5 N7": 1.388, "N7 C8": 1.308, "C8 N9": 1.375, "N9 C4": 1.374,
        "C6 O6": 1.238, "C2 N2": 1.338,
        "C6 N1 C2": 125.4, "N1 C2 N3": 123.6, "C2 N3 C4": 112.0, "N3 C4 C5": 128.6,
        "C4 C5 C6": 118.9, "C5 C6 N1": 111.5, "N3 C4 N9": 125.8, "C6 C5 N7": 130.3,
        "C5 C4 N9": 105.6, "C4 N9 C8": 106.2, "N9 C8 N7": 113.2, "C8 N7 C5": 104.2,
        "N7 C5 C4": 110.8, "O6 C6 N1": 120.1, "O6 C6 C5": 128.4, "N2 C2 N1": 116.5,
        "N2 C2 N3": 119.9,
    },
    "U": {
        "N1 C2": 1.381, "C2 N3": 1.373, "N3 C4": 1.381, "C4 C5": 1.432, "C5 C6": 1.337,
        "C6 N1": 1.374, "C2 O2": 1.219, "C4 O4": 1.231,
        "C6 N1 C2": 121.1, "N1 C2 N3": 114.9, "C2 N3 C4": 127.0, "N3 C4 C5": 114.5,
        "C4 C5 C6": 119.7, "C5 C6 N1": 122.7, "O2 C2 N1": 122.8, "O2 C2 N3": 122.3,
        "O4 C4 C5": 126.0, "O4 C4 N3": 119.5,
    },
    "T": {
        "N1 C2": 1.376, "C2 N3": 1.372, "N3 C4": 1.382, "C4 C5": 1.446, "C5 C6": 1.340,
        "C6 N1": 1.381, "C2 O2": 1.222, "C4 O4": 1.229, "C7 C5": 1.498,
        "C6 N1 C2": 121.2, "N1 C2 N3": 114.7, "C2 N3 C4": 127.1, "N3 C4 C5": 115.2,
        "C4 C5 C6": 118.1, "C5 C6 N1": 123.6, "O2 C2 N1": 123.0, "O2 C2 N3": 122.3,
        "O4 C4 C5": 125.0, "O4 C4 N3": 119.8, "C7 C5 C4": 118.7, "C7 C5 C6": 123.2,
    },
    "C": {
        "N1 C2": 1.395, "C2 N3": 1.353, "N3 C4": 1.337, "C4 C5": 1.424, "C5 C6": 1.338,
        "C6 N1": 1.365, "C2 O2": 1.240, "C4 N4": 1.330,
        "C6 N1 C2": 120.3, "N1 C2 N3": 119.1, "C2 N3 C4": 120.1, "N3 C4 C5": 121.6,
        "C4 C5 C6": 117.5, "C5 C6 N1": 121.2, "O2 C2 N1": 118.8, "O2 C2 N3": 122.0,
        "N4 C4 C5": 120.3, "N4 C4 N3": 118.1,
    },
}  # fmt: skip


def ideal_value(letter: str, is_dna: bool, *names: str) -> float | None:
    """Ideal length (two names, Å) or angle (three, °) in a nucleotide, or None if untabulated.

    The atoms of the phosphate belong to the nucleotide whether O3' is the one before or its own.

    Parameters
    ----------
    letter, is_dna
        Parent base and sugar.
    *names : str
        Two or three atoms.

    Returns
    -------
    float or None

    Examples
    --------
    >>> ideal_value("G", False, "O3'", "P"), ideal_value("G", False, "C8", "N9", "C1'")
    (1.607, 127.8)
    """
    tables = (
        _DNA_BONDS if is_dna else {},
        _BONDS,
        _ANGLES,
        _GLYCOSIDIC[letter in "AG"],
        _BASES.get(letter, {}),
    )
    for key in (" ".join(names), " ".join(reversed(names))):
        for table in tables:
            if key in table:
                return table[key]
    return None
