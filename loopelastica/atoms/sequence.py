"""A hairpin from its sequence alone: the ideal stem, and a loop to be folded."""

from __future__ import annotations

import re
from typing import Any, Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica._checks import shown
from loopelastica.atoms.fibre import fibre_nucleotide
from loopelastica.folding.fold import fold_model
from loopelastica.folding.options import FoldOptions
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.hairpins import MAX_LOOP, Hairpin
from loopelastica.molecule.nucleotides import Structure, read_structure
from loopelastica.molecule.pairs import MIN_LOOP
from loopelastica.molecule.reading import quiet
from loopelastica.molecule.strands import ideal_strand

_PAIRS: Final = frozenset(("AU", "UA", "AT", "TA", "GC", "CG", "GU", "UG", "GT", "TG"))


def read_sequence(text: str, is_dna: bool) -> tuple[str, str, str]:
    """The 5' strand, the loop and the 3' strand of "GGCAC(UUCG)GUGCC".

    Parameters
    ----------
    text : str
        Such as "GGCAC(UUCG)GUGCC".
    is_dna : bool
        A, C, G, T, else A, C, G, U.

    Returns
    -------
    strand_5, loop, strand_3 : str

    Raises
    ------
    ValueError
        If the text is not of that form, a letter is unknown, the strands differ in length or do not
        pair, or the loop is too short or too long.

    Examples
    --------
    >>> read_sequence("ggc(ttt)gcc", is_dna=True)
    ('GGC', 'TTT', 'GCC')
    """
    found = re.fullmatch(r"\s*([A-Za-z]+)\(([A-Za-z]+)\)([A-Za-z]+)\s*", text)
    if found is None:
        raise ValueError(
            f"`sequence` is {shown(text)}; it must be two strands with the loop in brackets between"
            ' them, such as "GGCAC(UUCG)GUGCC"'
        )
    strand_5, loop, strand_3 = (part.upper() for part in found.groups())
    letters = "ACGT" if is_dna else "ACGU"
    kind = "DNA" if is_dna else "RNA"
    for letter in strand_5 + loop + strand_3:
        if letter not in letters:
            raise ValueError(f"`sequence`: {letter} is no base of {kind} (one of {letters})")
    if len(strand_5) != len(strand_3):
        raise ValueError(
            f"`sequence`: the strands {strand_5} and {strand_3} have {len(strand_5)} and"
            f" {len(strand_3)} nucleotides; a stem needs equal ones"
        )
    for one, other in zip(strand_5, reversed(strand_3), strict=True):
        if one + other not in _PAIRS:
            raise ValueError(f"`sequence`: {one} and {other} do not pair, the stem is none")
    if not MIN_LOOP <= len(loop) <= MAX_LOOP:
        raise ValueError(
            f"`sequence`: the loop {loop} has {len(loop)} nucleotides, not {MIN_LOOP} to {MAX_LOOP}"
        )
    return strand_5, loop, strand_3


def ideal_hairpin(text: str, is_dna: bool) -> tuple[Structure, Hairpin, Array]:
    """Ideal stem of a sequence and the loop's places in it.

    Parameters
    ----------
    text : str
        Such as "GGCAC(UUCG)GUGCC".
    is_dna : bool
        B-DNA, else A-RNA; chain A, numbered from 1, without a phosphate at the 5' end.

    Returns
    -------
    structure : Structure
        Its loop nucleotides run on as a helix and mean nothing.
    hairpin : Hairpin
    positions : (n_atoms, 3) array
        Å, NaN for the loop, which is not yet folded.

    Raises
    ------
    ValueError
        As :func:`read_sequence`.
    """
    strand_5, loop, strand_3 = read_sequence(text, is_dna)
    m, n = len(strand_5), len(loop)
    sequence = strand_5 + loop + strand_3
    names: list[str] = []
    resindex: list[int] = []
    positions: list[Array] = []
    for k, letter in enumerate(sequence):
        # the nucleotide that pairs with number j of the 5' strand is its image by the dyad there
        paired = k >= m + n
        step = 2 * m + n - 1 - k if paired else k
        for name, at in fibre_nucleotide(letter, is_dna).items():
            if k == 0 and name in ("P", "OP1", "OP2"):
                continue
            names.append(name)
            resindex.append(k)
            positions.append(_screwed(at * [1.0, -1.0, -1.0] if paired else at, step, is_dna))
    places = np.array(positions)
    universe = _universe(sequence, is_dna, names, resindex, places)
    structure = read_structure(universe)
    table = structure.nucleotides
    rows = np.arange(m, m + n)
    hairpin = Hairpin(
        chain="A",
        name=f"A{m + 1}-{m + n}",
        closing_pair=(table.label(m - 1), table.label(m + n)),
        residues=tuple(table.label(int(k)) for k in rows),
        sequence=sequence[m - 1 : m + n + 1],
        is_dna=is_dna,
        contacts=(),
        kissing=(),
        loop=rows,
        resid=rows + 1,
        icode=np.full(n, ""),
        stem_5=np.arange(m - 1, -1, -1),
        stem_3=np.arange(m + n, 2 * m + n),
    )
    known = np.array(places)
    known[np.isin(resindex, rows)] = np.nan
    return structure, hairpin, known


def fold_sequence(
    text: str, is_dna: bool, *, max_candidates: int = 10
) -> tuple[Structure, LoopFold, Array]:
    """Ideal stem of a sequence with its loop folded.

    Parameters
    ----------
    text, is_dna
        As for :func:`ideal_hairpin`.
    max_candidates : int
        Most candidates kept.

    Returns
    -------
    structure : Structure
    fold : LoopFold
    positions : (n_atoms, 3) array
        For :func:`loopelastica.atoms.model.build_atoms`, Å; NaN for the loop.
    """
    structure, hairpin, positions = ideal_hairpin(text, is_dna)
    options = FoldOptions(max_candidates=max_candidates, all_models=False)
    return structure, fold_model(structure.nucleotides, hairpin, positions, options), positions


def _screwed(at: Array, step: int, is_dna: bool) -> Array:
    strand = ideal_strand(is_dna)
    angle = np.deg2rad(step * strand.turn_deg)
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = at
    return np.array([c * x - s * y, s * x + c * y, z + step * strand.rise_A])


def _universe(
    sequence: str, is_dna: bool, names: list[str], resindex: list[int], positions: Array
) -> Any:
    import MDAnalysis as mda

    with quiet():
        universe = mda.Universe.empty(
            len(names), n_residues=len(sequence), atom_resindex=resindex, trajectory=True
        )
        for attribute, values in {
            "name": names,
            "element": [name[0] for name in names],
            "type": [name[0] for name in names],
            "chainID": ["A"] * len(names),
            "resname": [f"D{letter}" if is_dna else letter for letter in sequence],
            "resid": list(range(1, len(sequence) + 1)),
            "segid": ["A"],
        }.items():
            universe.add_TopologyAttr(attribute, values)
        universe.atoms.positions = positions
    return universe
