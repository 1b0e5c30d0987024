"""Loop motifs, shapes by length, and how far answers are off: the numbers of ``data/motifs.json``.

``loopelastica studies motifs DIR`` makes them from a folder of loops, each judged on families that
its numbers had not seen (:mod:`loopelastica.studies.motifs`).
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record, read_only
from loopelastica._files import data_path
from loopelastica.folding.shape_table import letters_of
from loopelastica.molecule.shapes import LoopShape

SHIFT_A: Final = 0.05
"""Of errors before their logarithm is taken."""
SHIFT_ENERGY: Final = 0.05
CLASSES: Final = (
    (3, "3"), (4, "4"), (5, "5"), (6, "6"), (7, "7"), (9, "8-9"), (math.inf, "10-12"),
)  # fmt: skip
"""Loop lengths whose errors scatter alike: up to how many nucleotides, and their name."""
_BASES: Final = {
    **{base: base for base in "ACGU"},
    **{"R": "AG", "Y": "CU", "S": "CG", "W": "AU", "K": "GU", "M": "AC"},
    **{"B": "CGU", "D": "AGU", "H": "ACU", "V": "ACG", "N": "ACGU"},
}


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Motif(Record):
    """A shape that loops of certain sequences have, or those of a length.

    Attributes
    ----------
    name : str
        Such as "GNRA" or "7 nucleotides".
    pattern : str
        Of the loop without its closing pair, in IUPAC letters.
    shape : LoopShape
        The mean of its loops, each sequence counted once.
    loops, sequences, families : int
        What it is from.
    rmsd_A : (2,) array
        Median and 90 % of its error on sequences that it had not seen, Å.
    spread_A : float
        How far its loops lie from their mean, Å.
    c2_endo, syn : (n,) array
        Share of C2'-endo sugars and of syn bases at each nucleotide.
    """

    name: str
    pattern: str
    shape: LoopShape
    loops: int
    sequences: int
    families: int
    rmsd_A: Array
    spread_A: float
    c2_endo: Array
    syn: Array

    def __repr__(self) -> str:
        return f"<Motif {self.name}: {self.loops} loops>"

    def matches(self, codes: NDArray[np.uint8]) -> NDArray[np.bool_]:
        """Which sequences (k, n + 2), closing pair included, in ASCII, have it."""
        return pattern_fits(self.pattern, codes)


def pattern_fits(pattern: str, codes: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Which sequences (k, n + 2), closing pair included, in ASCII, have a pattern of n letters."""
    if codes.shape[1] != len(pattern) + 2:
        return np.zeros(len(codes), dtype=np.bool_)
    sets = (np.frombuffer(_BASES[letter].encode(), dtype=np.uint8) for letter in pattern)
    fits = [np.isin(codes[:, k], bases) for k, bases in enumerate(sets, start=1)]
    return np.asarray(np.logical_and.reduce(fits))


@dataclass(frozen=True, slots=True, eq=False)
class Errors(Record):
    """How far one kind of answer is off.

        log(error + 0.05 Å) = b · (1, log spread, log(E L/K0 + 0.05)) + a residual

    Attributes
    ----------
    b : (3,) array
    quantiles : mapping of str to (3,) array
        10, 50 and 90 % of the residual by class of length (`CLASSES`).
    """

    b: Array
    quantiles: Mapping[str, Array]

    def at(self, spread_A: float, energy: float, n: int) -> Array:
        """10, 50 and 90 % of the error of an answer, (3,), Å.

        Parameters
        ----------
        spread_A : float
            Expected distance of the weighted shapes from it, Å.
        energy : float
            E L/K0 of its deformation.
        n : int
            Loop nucleotides.
        """
        middle = float(self.b @ signs(spread_A, energy))
        return read_only(np.maximum(np.exp(middle + self.quantiles[class_of(n)]) - SHIFT_A, 0.0))


def signs(spread_A: float, energy: float) -> Array:
    """What is known of an answer without the loop itself, (3,)."""
    return np.array([1.0, math.log(max(spread_A, SHIFT_A)), math.log(energy + SHIFT_ENERGY)])


def class_of(n: int) -> str:
    """The name of the class of a length.

    >>> class_of(3), class_of(6), class_of(12)
    ('3', '6', '10-12')
    """
    return next(name for most, name in CLASSES if n <= most)


def motif_of(sequence: str) -> Motif | None:
    """The motif of an RNA loop, by its sequence from closing to closing nucleotide.

    >>> motif_of("CGAAAG"), motif_of("CAAAAG")
    (<Motif GNRA: 130 loops>, None)
    """
    codes = letters_of(sequence)
    return next((motif for motif in motifs() if motif.matches(codes[None])[0]), None)


def motifs() -> tuple[Motif, ...]:
    """All motifs."""
    return tuple(_motif(one, f"motif {one['name']}, ") for one in _content()["motifs"])


def of_length(n: int, is_dna: bool) -> Motif | None:
    """The shape of loops of a length, whatever their sequence; None where there is none."""
    of_kind = (one for one in _content()["lengths"] if one["kind"] == ("DNA" if is_dna else "RNA"))
    return next((_motif(one, "mean of ") for one in of_kind if len(one["pattern"]) == n), None)


def typical_spread_A(n: int) -> float:
    """How far RNA loops of a length lie from their mean, Å; beyond the table in proportion."""
    spreads = {
        len(one["pattern"]): one["spread_A"]
        for one in _content()["lengths"]
        if one["kind"] == "RNA"
    }
    near = min(max(n, min(spreads)), max(spreads))
    return float(spreads[near] * n / near)


def errors_of(kind: str) -> Errors:
    """How far answers of a kind are off, such as "mean", "motif GNRA", "same sequence" or "rod"."""
    table = _content()["errors"]
    # a motif that is too rare to be judged for itself errs as all of them
    base = "motif" if kind.startswith("motif ") else "rod" if kind.startswith("rod ") else "mean"
    alone = [f"{'rod' if base == 'rod' else 'mean'} alone"] if kind.endswith(" alone") else []
    row = next(table[name] for name in (kind, *alone, base) if name in table)
    return Errors(np.array(row["b"]), {c: np.array(q) for c, q in row["quantiles"].items()})


def habit_terms() -> tuple[Array, Array]:
    """Terms of the log odds of C2'-endo and of syn; :mod:`loopelastica.atoms.habits` adds them."""
    table = _content()["habits"]
    return read_only(list(table["c2_endo"].values())), read_only(list(table["syn"].values()))


@cache
def _content() -> dict[str, Any]:
    content: dict[str, Any] = json.loads(data_path("motifs.json").read_text(encoding="utf-8"))
    return content


def _motif(row: Mapping[str, Any], called: str) -> Motif:
    from scipy.spatial.transform import Rotation

    # six digits of a frame are none yet
    steps, end = read_only(row["steps_A"]), Rotation.from_matrix(row["end_frame"]).as_matrix()
    # a pattern is no sequence: what stands at a place where all may stand is unknown
    sequence, source = f"N{row['pattern']}N", f"{called}{row['loops']} loops"
    shape = LoopShape(sequence, row["kind"] == "DNA", steps, read_only(end), source)
    return Motif(
        row["name"], row["pattern"], shape, row["loops"], row["sequences"], row["families"],
        read_only(row["rmsd_A"]), row["spread_A"], read_only(row["c2_endo"]), read_only(row["syn"]),
    )  # fmt: skip
