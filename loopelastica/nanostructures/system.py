"""A nanostructure as oxDNA holds it: a centre and two axes for each nucleotide, and who is next.

Lengths are in oxDNA's unit, 0.8518 nm. Designs and oxDNA's own files become the same record; what
has no place yet (the single strands of a design) has `placed` False and gets one later.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class System(Record):
    """Nucleotides of a nanostructure in the order of its file; arrays over n nucleotides.

    Attributes
    ----------
    name : str
        What sentences call it: the path as given.
    base : (n,) array of str
        "A", "C", "G", "T" or "U", or oxDNA's number of a special base, as the file has it.
    strand : (n,) array of int
        Strands, from 0.
    n3, n5 : (n,) array of int
        Next nucleotide towards the 3' and the 5' end; −1 where there is none.
    pair : (n,) array of int
        Partner in a helix; −1 where there is none.
    placed : (n,) array of bool
        Whether the three below mean something.
    centre : (n, 3) array
        Centre of mass; oxDNA's units.
    a1, a3 : (n, 3) array
        Unit vectors: from the backbone to the base; the base's normal, 3' to 5' along a helix.
        ``a2 = a3 × a1``.
    label : tuple of str
        What sentences call a nucleotide, such as "helix 2, offset 31" or "nucleotide 17".
    strand_name : tuple of str
        What sentences call a strand.
    colour : tuple of str
        "#rrggbb" of each strand, "" where it has none.
    rna : (n_strands,) array of bool
        Whether a strand is RNA.
    box : (3,) array
        Sides of the periodic box; 0 where there is none yet.
    """

    name: str
    base: NDArray[np.str_]
    strand: NDArray[np.int64]
    n3: NDArray[np.int64]
    n5: NDArray[np.int64]
    pair: NDArray[np.int64]
    placed: NDArray[np.bool_]
    centre: Array
    a1: Array
    a3: Array
    label: tuple[str, ...]
    strand_name: tuple[str, ...]
    colour: tuple[str, ...]
    rna: NDArray[np.bool_]
    box: Array

    def __len__(self) -> int:
        """Return the number of nucleotides."""
        return len(self.base)

    def __repr__(self) -> str:
        return (
            f"<System {self.name}: {len(self)} nucleotides in {len(self.strand_name)} strands,"
            f" {int((self.pair >= 0).sum()) // 2} pairs>"
        )

    @property
    def a2(self) -> Array:
        """The third axis (n, 3), a3 × a1."""
        return np.cross(self.a3, self.a1)
