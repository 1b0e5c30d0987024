"""The lines of the candidates for viewers: tubes.pdb, a MODEL per candidate.

A line is a row of points TUB, joined to the stem and to each other by CONECT records; with them are
the points CEN of the loop's nucleotides, as in traces.pdb.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from loopelastica.folding.rank import Candidate
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.nucleotides import Structure
from loopelastica.molecule.setting import Setting
from loopelastica.report.pdb import b_factor, bond_records, expected_records, point_records
from loopelastica.report.scene import tube

TUBE: Final = "TUB"
"""Name of the points of a line, and of their residues."""

_PER_NUCLEOTIDE: Final = 12
_MOST_POINTS: Final = 2000


def tubes_text(
    fold: LoopFold,
    structure: Structure,
    setting: Setting | None,
    letter: str,
    candidates: Iterable[Candidate] | None = None,
) -> str:
    """PDB records of the lines of candidates.

    Parameters
    ----------
    fold : LoopFold
        The loop.
    structure : Structure
        What it was found in.
    setting : Setting or None
        The stem that the lines are joined to.
    letter : str
        Chain of all points.
    candidates : iterable of Candidate, optional
        By default all of the loop.

    Returns
    -------
    str
    """
    shown = fold.candidates if candidates is None else tuple(candidates)
    n = min(_PER_NUCLEOTIDE * (len(fold.hairpin) + 1) + 1, _MOST_POINTS)
    lines = expected_records(shown)
    for candidate in shown:
        b = b_factor(float(candidate.expected_rmsd_A[1]))
        lines.append(f"MODEL     {candidate.rank:4d}")
        lines += [
            f"HETATM{k:5d}  {TUBE} {TUBE} {letter or ' '}{k:4d}    {x:8.3f}{y:8.3f}{z:8.3f}"
            f"  1.00{b:6.2f}           C"
            for k, (x, y, z) in enumerate(tube(fold, candidate, setting, n).tolist(), start=1)
        ]
        lines += point_records(fold, structure, candidate, letter, n + 1)
        lines.append("ENDMDL")
    return "\n".join([*lines, *bond_records(1, n), "END", ""])
