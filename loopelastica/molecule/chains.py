"""Chains of nucleotides as they are meant: what is there and what is missing, in one row.

A chain is what the author calls so. In mmCIF the places in the sequence of record are in the file;
in PDB files they are found by alignment. Where there is no record a chain is what is there.
"""

from __future__ import annotations

from bisect import bisect
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from loopelastica.molecule.alignment import align, disagreements
from loopelastica.molecule.components import component
from loopelastica.molecule.conformers import Taken, monomer, taken
from loopelastica.molecule.entry import Entry
from loopelastica.molecule.nucleotides import LINK_MAX_A, STEP_MAX_A
from loopelastica.molecule.numbering import Place, free_places
from loopelastica.molecule.polymer import Monomer
from loopelastica.molecule.record import Absent, Listed, Record, Records, records_of


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """A chain of nucleotides.

    Attributes
    ----------
    name : str
        The author's name; "" where it has none.
    slots : tuple of Monomer
        Every nucleotide, 5' to 3', whether it is there or missing.
    source : str
        Where its sequence of record stands in the file; "" where there is none.
    fault : str
        Why nothing of it can be filled; "" where nothing stands in the way.
    used : frozenset of (int, str)
        Numbers and insertion codes in use in this chain, ligands and waters included.
    remarks : tuple of str
    """

    name: str
    slots: tuple[Monomer, ...]
    source: str = ""
    fault: str = ""
    used: frozenset[Place] = frozenset()
    remarks: tuple[str, ...] = ()


def called(name: str) -> str:
    """What sentences call a chain."""
    return f"chain {name}" if name else "the chain without a name"


def bond_A(first: Monomer, second: Monomer) -> float:
    """O3'–P distance of two nucleotides, Å; NaN where one of both is not there."""
    if "O3'" not in first.atoms_A or "P" not in second.atoms_A:
        return float("nan")
    return float(np.linalg.norm(first.atoms_A["O3'"] - second.atoms_A["P"]))


def neighbours(chain: Chain, first: Monomer, second: Monomer) -> bool:
    """Whether two nucleotides, one after the other in a chain, have nothing missing between them.

    Without a sequence of record the numbers say so.
    """
    there = bool(first.atoms_A and second.atoms_A)
    return there and (bool(chain.source) or not _between(first, second))


def bonded(first: Monomer, second: Monomer) -> bool:
    """Whether O3' of a nucleotide and P of the next are as near as a bond may be."""
    return bond_A(first, second) <= LINK_MAX_A


def joined(first: Monomer, second: Monomer) -> bool:
    """Whether a bond joins a nucleotide to the next; without O3' or P by C4' and the numbers."""
    bond = bond_A(first, second)
    if not np.isnan(bond):
        return bond <= LINK_MAX_A
    if not (first.atoms_A and second.atoms_A) or _between(first, second):
        return False
    if "C4'" not in first.atoms_A or "C4'" not in second.atoms_A:
        return True
    step = np.linalg.norm(first.atoms_A["C4'"] - second.atoms_A["C4'"])
    return bool(step <= STEP_MAX_A)


def chains_of(entry: Entry, model: int = 0) -> list[Chain]:
    """Chains of nucleotides of one model, in the order of the file.

    Parameters
    ----------
    entry : Entry
        What was read.
    model : int
        Which model, from 0.

    Returns
    -------
    list of Chain
    """
    records = records_of(entry, model)
    names = {chain: record.names for chain, record in records.by_author.items()}
    used: dict[str, set[Place]] = {}
    rows: dict[tuple[str, str | None], list[_Row]] = {}
    for part, chain in enumerate(entry.model(model)):
        for one in taken(chain):
            used.setdefault(chain.name, set()).add(one.place)
            subchain = one.residue.subchain
            label = subchain if subchain in records.by_label else None
            # whatever the record lists is part of the chain, however its atoms are called
            known = label is not None or one.residue.name in names.get(chain.name, ())
            if not known and not one.is_nucleotide:
                continue
            rows.setdefault((chain.name, label), []).append(_Row(one, part))
    found = []
    for (name, label), group in rows.items():
        chain_used = frozenset(used[name])
        absent = records.absent.get(name, [])
        record = records.by_author.get(name) if label is None else records.by_label[label]
        if record and label and all(row.one.residue.label_seq is not None for row in group):
            found.append(_labelled(name, group, record, absent, chain_used))
        elif kept := _in_chain(group, record, records):
            found.append(_unlabelled(name, kept, record, records, chain_used))
    return _without_two_of_one_name(found)


class _Row(NamedTuple):
    """A residue, and which part of the model it stands in: TER ends one."""

    one: Taken
    part: int


def _in_chain(group: list[_Row], record: Record | None, records: Records) -> list[Taken]:
    """Residues that belong to the chain: a free nucleotide does not, by no bond and as HETATM.

    Modified nucleotides that a file lists behind its chains are put where their bonds are.
    """
    names = record.names if record else frozenset()
    plain: list[Taken] = []
    apart: list[Taken] = []
    for k, (one, part) in enumerate(group):
        hetero = one.residue.het_flag == "H"
        beside = [group[j].one for j in (k - 1, k + 1) if 0 <= j < len(group)]
        listed = one.residue.name in names or one.residue.name in records.parents
        beside_it = any(_touch(one, other) for other in beside)
        if not hetero or beside_it or (listed and part == group[0].part):
            plain.append(one)
        else:
            apart.append(one)
    for one in apart:
        for k, other in enumerate(plain):
            if _touch(one, other):
                plain.insert(k if _bond(one, other) <= LINK_MAX_A else k + 1, one)
                break
    return plain


def _bond(first: Taken, second: Taken) -> float:
    o3 = next((a.pos for a in first.atoms if a.name in ("O3'", "O3*")), None)
    p = next((a.pos for a in second.atoms if a.name == "P"), None)
    return float("inf") if o3 is None or p is None else float(o3.dist(p))


def _touch(one: Taken, other: Taken) -> bool:
    return min(_bond(one, other), _bond(other, one)) <= LINK_MAX_A


# --- places in the record -------------------------------------------------------------------------


def _labelled(
    name: str,
    group: list[_Row],
    record: Record,
    absent: list[Absent],
    used: frozenset[Place],
) -> Chain:
    """A chain whose residues have their places in the record."""
    ordered = sorted((row.one for row in group), key=lambda one: one.residue.label_seq)
    places = [one.residue.label_seq - 1 for one in ordered]
    remarks = _choices(name, ordered)
    there = [monomer(name, one) for one in ordered]
    if any(one.repeated for one in ordered):
        return Chain(name, tuple(there), "", _two_chains(name), used, remarks)
    if places[0] < 0 or places[-1] >= len(record.residues) or len(set(places)) < len(places):
        fault = f"label_seq_id of {called(name)} contradicts {record.source}"
        return Chain(name, tuple(there), "", fault, used, remarks)
    return _placed(name, there, places, record, absent, used, remarks)


def _unlabelled(
    name: str,
    ordered: list[Taken],
    record: Record | None,
    records: Records,
    used: frozenset[Place],
) -> Chain:
    """A chain whose places in the record are to be found; without a record only what is there."""
    there = [
        monomer(name, one, letter=records.parents.get(one.residue.name, "N")) for one in ordered
    ]
    remarks = _choices(name, ordered)
    seen = {one.place for one in ordered}
    twice = len(seen) < len(ordered) or any(one.repeated for one in ordered)
    absent = [one for one in records.absent.get(name, []) if (one.number, one.icode) not in seen]
    absent = [one for one in absent if component(one.name) is not None]
    if twice:
        fault = _two_chains(name)
        return Chain(name, tuple(there), "", fault, used, remarks)
    if record is None and absent and _increasing(there):
        record, places = _merged(there, absent)
        return _placed(name, there, places, record, absent, used, remarks)
    if record is None:
        return Chain(name, tuple(there), "", "", used, remarks)
    unseen = sorted((one.number, one.icode) for one in absent)
    between = [
        bisect(unseen, _key(b)) - bisect(unseen, _key(a)) if unseen else _between(a, b)
        for a, b in pairwise(there)
    ]
    before = bisect(unseen, _key(there[0])) if unseen else there[0].number - 1
    bonds = [bonded(a, b) for a, b in pairwise(there)]
    found = align(there, record.residues, bonds, between, before if before >= 0 else None)
    if found is None:
        fault = (
            f"{called(name)}: {record.source} lists {len(record.residues)} nucleotides where the"
            f" file has {len(there)}, so the two contradict each other"
        )
        return Chain(name, tuple(there), "", fault, used, remarks)
    return _placed(name, there, found, record, absent, used, remarks)


def _two_chains(name: str) -> str:
    return (
        f"two chains are named {name or repr(name)}, or numbers repeat in it, so its nucleotides"
        " cannot be told apart; give each chain a name of its own"
    )


def _merged(there: list[Monomer], absent: list[Absent]) -> tuple[Record, list[int]]:
    """Sequence of what is there and of what the file lists as not observed, by the numbers."""
    rows: list[tuple[tuple[int, str], Listed, bool]] = [
        (_key(one), Listed((one.resname,), one.letter, one.is_dna, one.number, one.icode), True)
        for one in there
    ]
    for one in absent:
        known = component(one.name)
        assert known is not None
        key = (one.number, one.icode)
        rows.append((key, Listed((one.name,), known.letter, known.is_dna, *key), False))
    rows.sort(key=lambda row: row[0])
    record = Record(tuple(listed for _, listed, _ in rows), "REMARK 465")
    return record, [k for k, (_, _, here) in enumerate(rows) if here]


def _key(one: Monomer) -> Place:
    return one.number, one.icode


def _increasing(there: Sequence[Monomer]) -> bool:
    return all(_key(a) < _key(b) for a, b in pairwise(there))


def _between(first: Monomer, second: Monomer) -> int:
    """How many nucleotides lie between two, by their numbers."""
    return max(0, second.number - first.number - 1)


def _placed(
    name: str,
    there: list[Monomer],
    places: list[int],
    record: Record,
    absent: list[Absent],
    used: frozenset[Place],
    remarks: tuple[str, ...],
) -> Chain:
    """The chain of the record, with what is there in its places."""
    wrong = disagreements(there, record.residues, places)
    if wrong:
        first = there[wrong[0]]
        listed = record.residues[places[wrong[0]]].names[0]
        more = f", and {len(wrong) - 1} more disagree" if len(wrong) > 1 else ""
        fault = (
            f"{first.label} is {listed} in the sequence of record ({record.source}){more}, so the"
            f" record of {called(name)} contradicts the file"
        )
        return Chain(name, tuple(there), "", fault, used, remarks)
    row_of = {place: k for k, place in enumerate(places)}
    slots: list[Monomer | None] = [None] * len(record.residues)
    for place, k in row_of.items():
        letter = there[k].letter
        if letter == "N":
            letter = record.residues[place].letter
        slots[place] = replace(there[k], record=place + 1, letter=letter)
    trusted = all(
        record.residues[place].number in (None, there[k].number)
        and (
            record.residues[place].number is None or record.residues[place].icode == there[k].icode
        )
        for place, k in row_of.items()
    )
    more_remarks = list(remarks)
    taken_places = set(used)
    for begin, end in _runs(slots):
        listed_run = record.residues[begin:end]
        before = there[row_of[begin - 1]] if begin else None
        after = there[row_of[end]] if end < len(slots) else None
        numbers = _numbers_of(listed_run, trusted, absent, before, after)
        if numbers is None:
            numbers, sentence = free_places(name, before, after, len(listed_run), taken_places)
            if sentence and before and after:
                more_remarks.append(sentence)
        taken_places.update(numbers)
        styles = _dna_by_name(there)
        for k, (number, icode) in enumerate(numbers):
            one = listed_run[k]
            is_dna = styles.get(one.names[0], one.is_dna or False)
            slots[begin + k] = Monomer(
                name, number, icode, one.names[0], one.letter, is_dna, begin + k + 1
            )
    whole = tuple(slot for slot in slots if slot is not None)
    return Chain(name, whole, record.source, "", used, tuple(more_remarks))


def _runs(slots: Sequence[Monomer | None]) -> Iterator[tuple[int, int]]:
    """Stretches of what is missing."""
    begin = None
    for k, slot in enumerate([*slots, ...]):
        if slot is None and begin is None:
            begin = k
        elif slot is not None and begin is not None:
            yield begin, k
            begin = None


def _numbers_of(
    run: Sequence[Listed],
    trusted: bool,
    absent: list[Absent],
    before: Monomer | None,
    after: Monomer | None,
) -> list[Place] | None:
    """Numbers that the file itself gives to what is missing; None where it gives none."""
    if trusted and all(one.number is not None for one in run):
        return [(one.number, one.icode) for one in run if one.number is not None]
    rows = [
        one
        for one in absent
        if (before is None or _key(before) < (one.number, one.icode))
        and (after is None or (one.number, one.icode) < _key(after))
    ]
    if len(rows) == len(run) and all(
        row.name in one.names for row, one in zip(rows, run, strict=True)
    ):
        return [(row.number, row.icode) for row in rows]
    return None


def _dna_by_name(there: Sequence[Monomer]) -> dict[str, bool]:
    """Kind of the sugar for names that old files use for DNA and RNA alike: A, C, G."""
    short = [one for one in there if one.resname in ("A", "C", "G", "U", "T")]
    if not short or not all(one.is_dna for one in short):
        return {}
    return dict.fromkeys("ACGT", True)


# --- what is to be said ---------------------------------------------------------------------------


def _choices(name: str, ordered: Sequence[Taken]) -> tuple[str, ...]:
    """Sentences on what was chosen where the file leaves a choice."""
    remarks = []
    for one in ordered:
        if one.rivals:
            number, icode = one.place
            place = f"{name}.{number}{icode}" if name else f"{number}{icode}"
            remarks.append(
                f"{place} is {one.residue.name} or {' or '.join(one.rivals)};"
                f" {one.residue.name}, of higher occupancy, is used"
            )
    located = [one for one in ordered if one.altloc and not one.rivals]
    if located:
        first = located[0]
        remarks.append(
            f"{called(name)}: alternative locations in {len(located)} nucleotide(s), the one of"
            f" highest occupancy is used ({first.residue.name}{first.place[0]} {first.altloc}"
            + (", …)" if len(located) > 1 else ")")
        )
    return tuple(remarks)


def _without_two_of_one_name(found: list[Chain]) -> list[Chain]:
    """Refuse chains of one name that share numbers; others are told apart by these."""
    places: dict[str, list[set[Place]]] = {}
    for chain in found:
        places.setdefault(chain.name, []).append({_key(one) for one in chain.slots})
    refused = {name for name, sets in places.items() if sum(map(len, sets)) > len(set.union(*sets))}
    return [
        replace(chain, fault=_two_chains(chain.name)) if chain.name in refused else chain
        for chain in found
    ]
