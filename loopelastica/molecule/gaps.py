"""What is missing inside the chains of a structure, and what stands on each side of it.

    entry → chains as they are meant → runs of what is missing or too incomplete → gaps

A gap lies between two usable nucleotides: those with C4' and four of the six backbone atoms.
Nucleotides between that lack more are part of the gap and keep what atoms they have. What cannot be
filled is refused here, before anything is tried, with its reason.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from loopelastica._arrays import Record
from loopelastica.errors import StructureError
from loopelastica.molecule.chains import Chain, bond_A, called, chains_of, joined
from loopelastica.molecule.components import is_standard
from loopelastica.molecule.entry import Entry
from loopelastica.molecule.flanks import gap_between, missing_atoms
from loopelastica.molecule.nucleotides import enumerated
from loopelastica.molecule.polymer import Gap, Monomer
from loopelastica.molecule.refusals import (
    MOST_NUCLEOTIDES,
    Refusal,
    is_foreign,
    reason_against,
    refusal,
)
from loopelastica.molecule.requests import requests, with_request


class Tail(NamedTuple):
    """Nucleotides missing at an end of a chain; they are left.

    Attributes
    ----------
    chain : str
    end : str
        "5'" or "3'".
    first, last : str
        Numbers, with insertion codes.
    sequence : str
    """

    chain: str
    end: str
    first: str
    last: str
    sequence: str

    def __str__(self) -> str:
        """Return it as a sentence."""
        numbers = self.first if self.first == self.last else f"{self.first}-{self.last}"
        where = f"{self.chain}.{numbers}" if self.chain else numbers
        n = len(self.sequence)
        left = "is" if n == 1 else "are"
        return f"{where} ({self.sequence}): {n} nt missing at the {self.end} end {left} left"


class Incomplete(NamedTuple):
    """A nucleotide away from any gap that lacks atoms: which ones."""

    monomer: Monomer
    missing: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Gaps(Record):
    """What is missing in one model.

    Attributes
    ----------
    gaps : tuple of Gap
        What can be filled, in the order of the chains.
    refused : tuple of Refusal
    tails : tuple of Tail
    incomplete : tuple of Incomplete
    remarks : tuple of str
        Sentences on chains as a whole: choices of the reading, contradictions.
    chains : tuple of Chain
        The chains as they are meant.
    broken : tuple of str
        Sentences on broken bonds with nothing missing between.
    """

    gaps: tuple[Gap, ...]
    refused: tuple[Refusal, ...]
    tails: tuple[Tail, ...]
    incomplete: tuple[Incomplete, ...]
    remarks: tuple[str, ...]
    chains: tuple[Chain, ...]
    broken: tuple[str, ...] = ()


def find_gaps(entry: Entry, model: int = 0, strands: Any = None) -> Gaps:
    """Find every internal gap of the DNA and RNA chains of one model.

    Parameters
    ----------
    entry : Entry
        What was read.
    model : int
        Which model, from 0.
    strands : str or sequence of str, optional
        Strands to be filled, and no others: "A.6-9", with the sequence of the file, or
        "A.6-9=UUCG". One that is there is taken as missing. Default: all gaps, by the file.

    Returns
    -------
    Gaps

    Raises
    ------
    StructureError
        If there is no nucleotide, or a strand of `strands` is not where it is said to be.
    ValueError
        If there is no such model, or `strands` cannot be understood.

    Examples
    --------
    >>> from loopelastica._files import data_path
    >>> from loopelastica.molecule.entry import read_entry
    >>> entry = read_entry(data_path("hairpins/2koc.pdb"))
    >>> found = find_gaps(entry, strands="A.6-9")
    >>> [(gap.name, gap.sequence, gap.before.label) for gap in found.gaps]
    [('A.6-9', 'UUCG', 'A.C5')]
    """
    wanted = requests(strands)
    chains = chains_of(entry, model)
    if not chains:
        n = sum(len(chain) for chain in entry.model(model))
        raise StructureError(f"{entry.where}: no nucleotide found among {n} residues")
    gaps: list[Gap] = []
    refused: list[Refusal] = []
    for request in wanted:
        gap, refusals = _judged(with_request(chains, request), "")
        gaps += gap
        refused += refusals
    _check_apart(gaps)
    tails: list[Tail] = []
    incomplete: list[Incomplete] = []
    remarks: list[str] = []
    broken: list[str] = []
    for chain in chains:
        found = _Found(chain)
        tails += found.tails
        remarks += found.remarks
        broken += found.broken
        if not wanted:
            gaps += found.gaps
            refused += found.refused
        incomplete += found.incomplete
    beside = {one.label for gap in gaps for one in _touched(gap)}
    return Gaps(
        tuple(gaps),
        tuple(refused),
        tuple(tails),
        tuple(one for one in incomplete if one.monomer.label not in beside),
        tuple(remarks),
        tuple(chains),
        tuple(broken),
    )


def _check_apart(gaps: Sequence[Gap]) -> None:
    """Refuse strands of a user that are each other's flanks."""
    built = {one.label: gap for gap in gaps for one in gap.monomers}
    for gap in gaps:
        other = built.get(gap.after.label) or built.get(gap.before.label)
        if other is not None:
            raise StructureError(
                f"`strands`: {gap.name} and {other.name} have no nucleotide between them; name them"
                " as one strand"
            )


def _touched(gap: Gap) -> Iterator[Monomer]:
    yield gap.before
    yield gap.after
    yield from gap.monomers
    yield from gap.replaces


class _Found:
    """What one chain comes to."""

    def __init__(self, chain: Chain) -> None:
        self.gaps: list[Gap] = []
        self.refused: list[Refusal] = []
        self.tails: list[Tail] = []
        self.remarks: list[str] = list(chain.remarks)
        self.broken: list[str] = []
        self.incomplete = list(_incomplete(chain.slots))
        usable = [k for k, one in enumerate(chain.slots) if one.usable]
        if not usable:
            self._without_flanks(chain)
            return
        self._ends(chain, usable[0], usable[-1])
        for i, j in pairwise(usable):
            between = chain.slots[i + 1 : j]
            unlisted = [] if chain.source else list(_jumps(chain.slots[i : j + 1]))
            if unlisted:
                self.refused += [_unlisted(chain, *ends) for ends in unlisted]
            elif between and all(map(is_foreign, between)):
                names = enumerated([one.label for one in between])
                self.remarks.append(
                    f"{names}: the backbone has atoms of other names; left as it is"
                )
            elif between:
                gap, refusals = _judged(gap_between(chain, i, j), chain.fault)
                self.gaps += gap
                self.refused += refusals
            else:
                self._step(chain, chain.slots[i], chain.slots[j])
        if chain.fault and not self.refused:
            self.remarks.append(chain.fault)

    def _without_flanks(self, chain: Chain) -> None:
        reason = f"{called(chain.name)} has no nucleotide with C4' and four backbone atoms"
        runs = [run for run in _runs(chain.slots) if run[0] > 0 and run[1] < len(chain.slots)]
        for begin, end in runs:
            self.refused.append(refusal(chain.slots[begin:end], f"{reason} to end on"))
        self.remarks.append(f"{reason}, so nothing of it is filled")

    def _ends(self, chain: Chain, first: int, last: int) -> None:
        """Name what is missing before the first usable nucleotide and after the last."""
        slots = chain.slots
        for begin, end in _runs(slots):
            run = slots[begin:end]
            if first < begin < last:
                continue
            at_end = begin == 0 or end == len(slots)
            side = "5'" if begin < first else "3'"
            if at_end:
                places = (run[0].place, run[-1].place, "".join(one.letter for one in run))
                self.tails.append(Tail(chain.name, side, *places))
            else:
                self.refused.append(
                    refusal(
                        run,
                        f"{_name(run)}: no nucleotide on its {side} side has C4' and four backbone"
                        " atoms, so the strand has no end there",
                    )
                )

    def _step(self, chain: Chain, first: Monomer, second: Monomer) -> None:
        """A step between usable neighbours: a bond, or a broken one."""
        bond = bond_A(first, second)
        if not np.isnan(bond) and not joined(first, second):
            self.broken.append(
                f"{first.label}–{second.label}: the bond is broken (O3'–P {bond:.1f} Å) and nothing"
                " is missing between, so it is left"
            )


def _jumps(slots: Sequence[Monomer]) -> Iterator[tuple[Monomer, Monomer]]:
    """Steps without a bond over which the numbers jump."""
    for first, second in pairwise(slots):
        if second.number - first.number > 1 and not joined(first, second):
            yield first, second


def _unlisted(chain: Chain, first: Monomer, second: Monomer) -> Refusal:
    """Refuse a gap that only the numbers tell of."""
    n = second.number - first.number - 1
    bond = bond_A(first, second)
    far = "" if np.isnan(bond) else f" (O3'–P {bond:.1f} Å)"
    numbers = str(first.number + 1), str(second.number - 1)
    name = numbers[0] if n == 1 else "-".join(numbers)
    where = f"{chain.name}.{name}" if chain.name else name
    letters = "N" * min(n, MOST_NUCLEOTIDES + 1)
    fault = f"; {chain.fault}" if chain.fault else " and the file has no sequence for them"
    advice = f"give the sequence as a strand, {where}={letters}"
    if n > MOST_NUCLEOTIDES:
        advice = f"no more than {MOST_NUCLEOTIDES} are filled"
    return Refusal(
        chain.name,
        *numbers,
        letters,
        f"{where}: the numbers say that {n} nt {'is' if n == 1 else 'are'} missing between"
        f" {first.label} and {second.label}{far}{fault}; {advice}",
    )


def _incomplete(slots: Sequence[Monomer]) -> Iterator[Incomplete]:
    for k, one in enumerate(slots):
        at_5 = k == 0 or not slots[k - 1].atoms_A
        # what a modified nucleotide should have is not known, only what its parent has
        known = is_standard(one.resname)
        if known and one.atoms_A and (lacking := missing_atoms(one, at_5)):
            yield Incomplete(one, tuple(lacking))


def _runs(slots: Sequence[Monomer]) -> Iterator[tuple[int, int]]:
    """Stretches of nucleotides without any atom."""
    begin = None
    for k in range(len(slots) + 1):
        there = k == len(slots) or bool(slots[k].atoms_A)
        if not there and begin is None:
            begin = k
        elif there and begin is not None:
            yield begin, k
            begin = None


def _name(run: Sequence[Monomer]) -> str:
    return Gap(tuple(run), run[0], run[-1]).name


def _judged(gap: Gap, fault: str) -> tuple[list[Gap], list[Refusal]]:
    """Put a gap among those to be filled or those that are refused."""
    reason = f"{gap.name}: {fault}" if fault else reason_against(gap)
    if reason is None:
        return [gap], []
    return [], [refusal(gap.monomers, reason)]
