"""Where a loop is clamped when nobody says so: the rule, its constants and their evidence.

The evidence are 73 simple hairpin loops of 52 sequence families (8 DNA, 25 RNA in small files, 40
of the 23S rRNA 1S72), three to nine nucleotides, judged by the RMSD of the loop's centroids without
superposition. ``loopelastica evaluate`` repeats it, each constant refitted without the family it is
judged on.

- *DNA is clamped at the closing pair*: any extension of either strand makes it worse.
- *RNA loops of six and more nucleotides go on stacking, mostly on the 3' strand*: by
  `RNA_EXTENSIONS`. Against a clamp at the closing pair the error falls by 2.9 Å in the mean (95 %
  of the bootstrap over families: 2.0 to 3.8). This is certain; the entries of the table were chosen
  with all 73 loops in view.
- *RNA's 3' strand leans inwards over the closing pair*, as that of every GNRA loop does: by
  `RNA_TAPER` of its radius per nucleotide. Any value from 0.10 to 0.25 is about as good, and the
  gain is not certain: 0.28 Å (−0.04 to 0.59).
- *Length of line per nucleotide* is that of real stems (`Strand.length_per_nucleotide_A`), not
  fitted to loops.
- *A stem whose last two nucleotides miss the ideal strand by more than `STEM_RMS_MAX_A`* is no A or
  B helix: the left-handed stem of 1D16 has 1.56 Å, all others at most 1.10 Å.

Energy does not choose a clamp: it is no better than this table (see README).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from loopelastica.molecule.strands import ideal_strand

STEM_RMS_MAX_A: Final = 1.3

RNA_TAPER: Final = 0.2

RNA_EXTENSIONS: Final = {6: (0, 1), 7: (1, 2), 8: (1, 2), 9: (1, 3)}
"""Loop nucleotides → nucleotides laid on the continued 5' and 3' strand; shorter loops have none,
longer ones (no evidence) that of nine."""

EXPECTED_RMSD_A: Final = {
    3: (1.3, 2.7),
    4: (1.9, 3.6),
    5: (2.6, 5.1),
    6: (2.1, 4.3),
    7: (2.8, 4.8),
    8: (6.0, 9.0),
}
"""Loop nucleotides → median and 90 % of the RMSD of the first-ranked shape over the 73 loops, Å;
the entry of eight is that of all longer ones (six loops)."""


@dataclass(frozen=True, slots=True)
class StemClamp:
    """How the ends of the rod are laid out from the stem.

    Attributes
    ----------
    stem_extend_5, stem_extend_3 : int
        Loop nucleotides that continue the 5' and the 3' strand of the stem; the rod takes the rest.
    taper : float
        Loss of radius per nucleotide of the continued 3' strand, in units of the helix radius.
    length_per_nucleotide_A : float
        Length of the rod per nucleotide, Å.
    """

    stem_extend_5: int
    stem_extend_3: int
    taper: float
    length_per_nucleotide_A: float

    def to_dict(self) -> dict[str, float]:
        """Names and values."""
        return {name: getattr(self, name) for name in self.__slots__}


def plain_clamp(is_dna: bool) -> StemClamp:
    """The clamp at the closing pair: no extension, no taper."""
    return StemClamp(0, 0, 0.0, ideal_strand(is_dna).length_per_nucleotide_A)


def default_clamp(is_dna: bool, n: int) -> StemClamp:
    """The rule's clamp for a loop of `n` nucleotides.

    Parameters
    ----------
    is_dna : bool
        Kind of the stem.
    n : int
        Loop nucleotides.

    Returns
    -------
    StemClamp

    Examples
    --------
    >>> default_clamp(is_dna=False, n=7)
    StemClamp(stem_extend_5=1, stem_extend_3=2, taper=0.2, length_per_nucleotide_A=6.0)
    """
    plain = plain_clamp(is_dna)
    if is_dna:
        return plain
    extend_5, extend_3 = RNA_EXTENSIONS.get(min(n, max(RNA_EXTENSIONS)), (0, 0))
    return StemClamp(extend_5, extend_3, RNA_TAPER, plain.length_per_nucleotide_A)


def expected_rmsd_A(n: int) -> tuple[float, float]:
    """Median and 90 % of the error to expect of a first-ranked loop of `n` nucleotides, Å.

    >>> expected_rmsd_A(4), expected_rmsd_A(12)
    ((1.9, 3.6), (6.0, 9.0))
    """
    return EXPECTED_RMSD_A[min(max(n, min(EXPECTED_RMSD_A)), max(EXPECTED_RMSD_A))]
