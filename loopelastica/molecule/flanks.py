"""A gap with the nucleotides on both its sides, and what these lack."""

from __future__ import annotations

from collections.abc import Sequence

from loopelastica.molecule.chains import Chain, bonded
from loopelastica.molecule.components import BASES, PHOSPHATE, expected_atoms, is_standard
from loopelastica.molecule.nucleotides import enumerated
from loopelastica.molecule.polymer import Gap, Monomer


def gap_between(chain: Chain, i: int, j: int, given: bool = False) -> Gap:
    """The gap between two usable nucleotides of a chain.

    Parameters
    ----------
    chain : Chain
    i, j : int
        Their places in it.
    given : bool
        Whether the sequence is the user's.

    Returns
    -------
    Gap
        With a sentence for each choice in it.
    """
    slots = chain.slots
    before, after, monomers = slots[i], slots[j], slots[i + 1 : j]
    outwards = slots[i - 1] if i else None, slots[j + 1] if j + 1 < len(slots) else None
    remarks = []
    for one in monomers:
        if one.atoms_A:
            remarks.append(f"{one.label} has only {_listed(one)}; it is part of the gap")
        if not is_standard(one.resname) and one.letter in BASES:
            remarks.append(f"{one.label} is built as its parent base, {one.letter}")
    for one, at_5 in ((before, i == 0 or not slots[i - 1].atoms_A), (after, False)):
        lacking = missing_atoms(one, at_5)
        if lacking:
            remarks.append(
                f"{one.label} beside the gap lacks {enumerated(lacking)}; they are added"
            )
    return Gap(
        monomers=monomers,
        before=before,
        after=after,
        beyond_5=outwards[0] if outwards[0] and bonded(outwards[0], before) else None,
        beyond_3=outwards[1] if outwards[1] and bonded(after, outwards[1]) else None,
        given=given,
        remarks=tuple(remarks),
    )


def _listed(one: Monomer) -> str:
    names = list(one.atoms_A)
    if len(names) == 1:
        return names[0]
    if len(names) > 6:
        return f"{len(names)} atoms, and not the backbone"
    return f"{', '.join(names[:-1])} and {names[-1]}"


def missing_atoms(one: Monomer, at_5_end: bool) -> list[str]:
    """Heavy atoms that a nucleotide lacks; at a 5' end the phosphate may be absent.

    Parameters
    ----------
    one : Monomer
    at_5_end : bool
        Whether nothing stands before it.

    Returns
    -------
    list of str
    """
    lacking = [
        name
        for name in expected_atoms(one.resname, one.letter, one.is_dna)
        if name not in one.atoms_A
    ]
    if at_5_end and set(PHOSPHATE) <= set(lacking):
        lacking = [name for name in lacking if name not in PHOSPHATE]
    return lacking


def around(chains: Sequence[Chain], monomer: Monomer) -> Gap | None:
    """One nucleotide that lacks atoms, as a gap between its neighbours.

    Parameters
    ----------
    chains : sequence of Chain
    monomer : Monomer
        One of their nucleotides.

    Returns
    -------
    Gap or None
        None where one of its neighbours is not there, or no strand can end on it.
    """
    for chain in chains:
        for k, one in enumerate(chain.slots[1:-1], start=1):
            if one is monomer:
                sides = chain.slots[k - 1], chain.slots[k + 1]
                return gap_between(chain, k - 1, k + 1) if all(s.usable for s in sides) else None
    return None
