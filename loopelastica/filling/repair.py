"""Mend what is broken in chains that are there: the shortest stretch that does it is built anew.

    chain ─faults→ what is wrong ─stretches, shortest first→ atoms near theirs ─checks→ model

A stretch between two broken bonds that fits again when it is moved as a rigid body was shifted as a
whole, and goes back as a whole. For everything else one nucleotide is tried, at each place where
it could help, then two, … Bases that are not themselves at fault stay where they are if that does.
A model is taken if it is sound, what it was built for is gone, and nothing else has come.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from loopelastica._arrays import Array
from loopelastica.atoms.chemistry import Residue, atom_names
from loopelastica.atoms.strand import StrandModel, build_strand
from loopelastica.errors import StructureError
from loopelastica.filling.models import MAX_SECONDS, first_model
from loopelastica.filling.result import Repair, waters_of
from loopelastica.filling.rigid import moved_back
from loopelastica.molecule.chains import Chain, bonded, neighbours
from loopelastica.molecule.components import BASES, PHOSPHATE, is_standard
from loopelastica.molecule.entry import Entry
from loopelastica.molecule.faults import CLOSE_A, Fault, broken_or_strained, find_faults, strain_A
from loopelastica.molecule.polymer import Gap, HeavyAtoms, Monomer
from loopelastica.report.changes import Removed

LONGEST: Final = 8
"""Nucleotides of the longest stretch that is tried."""
LONGEST_END: Final = 3
"""Nucleotides of the longest end of a chain that is taken to have moved."""
HYDROGEN_A: Final = 1.3
"""A hydrogen further from every heavy atom than this is bonded to none."""
EVERYWHERE: Final = 3
"""Up to this length a stretch is tried at every place, longer ones where the fault is central."""
Index = NDArray[np.int64]
Positions = Mapping[str, Mapping[str, Array]]


class Mender:
    """The chains of one model while they are mended.

    Parameters
    ----------
    entry : Entry
        What was read.
    model : int
        From 0.
    chains : sequence of Chain
        As they are in the file.
    atoms : HeavyAtoms
        All of the model.
    barred : collection of str
        Labels of nucleotides that are about to be built anyway.

    Attributes
    ----------
    atoms : HeavyAtoms
        As they are now.
    repairs : list of Repair
    left : list of str
        A sentence for each fault that remains.
    """

    def __init__(
        self,
        entry: Entry,
        model: int,
        chains: Sequence[Chain],
        atoms: HeavyAtoms,
        barred: Collection[str],
    ) -> None:
        self._entry, self._model = entry, model
        self.atoms = atoms
        self.repairs: list[Repair] = []
        self.left: list[str] = []
        for chain in chains:
            slots = tuple(
                replace(one, atoms_A={}) if one.label in barred else one for one in chain.slots
            )
            if len({one.label for one in slots}) == len(slots):
                self._mend(replace(chain, slots=slots))

    def _mend(self, chain: Chain) -> None:
        faults = find_faults(chain)
        for shifted in (_islands, self._loose_ends):
            tried: set[tuple[int, int]] = set()
            while new := [one for one in shifted(chain, faults) if one not in tried]:
                tried.add(new[0])
                chain, faults = self._tried(chain, faults, *new[0], shifted=True) or (chain, faults)
        given_up: set[object] = set()
        while waiting := [fault for fault in faults if fault.key not in given_up]:
            fault = waiting[0]
            for first, last in _stretches(chain, faults, fault):
                if found := self._tried(chain, faults, first, last):
                    chain, faults = found
                    break
            else:
                given_up.add(fault.key)
        self.left += (f"{fault}; not mended, {_why_not(chain, fault)}" for fault in faults)

    def _loose_ends(self, chain: Chain, faults: Sequence[Fault]) -> Iterator[tuple[int, int]]:
        """Short stretches between a broken bond and an open end that run into something."""
        slots = chain.slots
        for k in sorted(_broken(faults)):
            for n in range(1, LONGEST_END + 1):
                for first, last in ((k - n + 1, k), (k + 1, k + n)):
                    if not (first >= 0 and last < len(slots)):
                        continue
                    end = first if last == k else last + 1
                    if _open(chain, end) and self._runs_into(slots, first, last):
                        yield first, last

    def _tried(
        self, chain: Chain, faults: list[Fault], first: int, last: int, shifted: bool = False
    ) -> tuple[Chain, list[Fault]] | None:
        """The chain with one stretch built anew, and what is still wrong; None if that fails."""
        hit = [fault for fault in faults if _hits(fault, first, last)]
        known = {fault.key for fault in faults} - {fault.key for fault in hit}
        original = chain.slots[first : last + 1]
        for gap, near in _attempts(chain, faults, first, last, shifted):
            around = self.atoms.grown((), _rows(self.atoms, original, gap.monomers))
            try:
                model = first_model(gap, around) if near is None else _near(gap, near, around)
            except StructureError:
                continue
            if not model.checks.sound:
                continue
            waters = waters_of(model, around, self._model)
            lost = _hydrogens(self._entry, self._model, original, model)
            repair = Repair(self._model + 1, tuple(hit), model, original, waters, lost)
            now = {one.label: one for one in repair.now}
            changed = replace(chain, slots=tuple(now.get(s.label, s) for s in chain.slots))
            left = find_faults(changed)
            if {fault.key for fault in left} <= known:
                self.repairs.append(repair)
                self.atoms = around.grown(tuple(repair.residues), model.waters)
                return changed, left
        return None

    def _runs_into(self, slots: Sequence[Monomer], first: int, last: int) -> bool:
        """Whether a stretch lies on atoms that are neither its own nor its neighbours'."""
        from scipy.spatial import cKDTree

        stretch, atoms = slots[first : last + 1], self.atoms
        if not all(map(_buildable, stretch)):
            return False
        own = {one.label for one in slots[max(first - 1, 0) : last + 2]}
        others = ~np.isin(atoms.residue, [k for k, x in enumerate(atoms.labels) if x in own])
        others &= ~atoms.water & ~atoms.metal
        here = [at for one in stretch for at in one.atoms_A.values()]
        near = cKDTree(here).query(atoms.positions_A[others], distance_upper_bound=CLOSE_A)[0]
        return bool(np.isfinite(near).any())


def _hits(fault: Fault, first: int, last: int) -> bool:
    return any(first <= place <= last for place in fault.places)


def _buildable(one: Monomer) -> bool:
    """Whether a nucleotide can be built as it is, with every atom that it has."""
    if not one.atoms_A or not is_standard(one.resname) or one.letter not in BASES:
        return False
    kind = Residue(one.letter, one.is_dna, one.resname)
    return not kind.renamed and set(one.atoms_A) <= {*atom_names(kind), "OP3"}


def _open(chain: Chain, k: int) -> bool:
    """Whether nothing is joined to nucleotide k on its 5' side: an end, or something missing."""
    slots = chain.slots
    if not 0 < k < len(slots) or not (slots[k - 1].usable and slots[k].usable):
        return True
    return not neighbours(chain, slots[k - 1], slots[k])


# --- which stretch --------------------------------------------------------------------------------


def _islands(chain: Chain, faults: Sequence[Fault]) -> Iterator[tuple[int, int]]:
    """Stretches between two junctions that are broken or strained, one broken at least."""
    slots, broken = chain.slots, _broken(faults)
    if not broken:
        return
    ends = [
        k
        for k in range(len(slots) - 1)
        if not _open(chain, k + 1) and (k in broken or broken_or_strained(*slots[k : k + 2]))
    ]
    for before, last in pairwise(ends):
        whole = all(map(_buildable, slots[before + 1 : last + 1]))
        joined = not any(_open(chain, k) for k in range(before + 2, last + 1))
        # what is broken in itself is not shifted alone
        inside = any(len(f.places) == 1 and before < f.places[0] <= last for f in faults)
        whole = whole and joined and not inside
        if last - before <= LONGEST and broken & {before, last} and whole:
            yield before + 1, last


def _broken(faults: Sequence[Fault]) -> set[int]:
    """Nucleotides with a broken bond to the next one."""
    return {f.places[0] for f in faults if f.kind == "bond" and len(f.places) == 2}


def _stretches(chain: Chain, faults: Sequence[Fault], fault: Fault) -> Iterator[tuple[int, int]]:
    """Where a fault may be mended: short stretches first, of one length those that mend most."""
    slots = chain.slots
    middle = sum(fault.places) / len(fault.places)
    opened = [k for k in range(len(slots) + 1) if _open(chain, k)]
    left = max(k for k in opened if k <= middle)
    right = min(k for k in opened if k > middle)
    for n in range(1, LONGEST + 1):
        found = []
        for place in fault.places:
            for first in range(max(0, place - n + 1), min(place, len(slots) - n) + 1):
                stretch = slots[first : first + n]
                joined = not any(_open(chain, k) for k in range(first + 1, first + n))
                flanks = _flanks(chain, first, first + n - 1)
                if joined and any(flanks) and all(map(_buildable, stretch)):
                    found.append(first)
        hits = {k: sum(_hits(f, k, k + n - 1) for f in faults) for k in found}
        strain = {k: sum(map(strain_A, slots[k : k + n])) for k in hits}
        off = {k: abs(k + 0.5 * (n - 1) - middle) for k in hits}
        # what is nearer to an end of the chain is more likely to be what has moved
        end = {k: min(k - left, right - k - n) for k in hits}
        order = sorted(hits, key=lambda k: (-hits[k], -round(strain[k], 2), off[k], end[k], k))
        for first in order if n <= EVERYWHERE else order[:2]:
            yield first, first + n - 1


def _why_not(chain: Chain, fault: Fault) -> str:
    if not any(_buildable(chain.slots[place]) for place in fault.places):
        return "for what it is in cannot be built anew"
    return f"no sound model of up to {LONGEST} nucleotides mends it"


# --- what is tried --------------------------------------------------------------------------------


def _attempts(
    chain: Chain, faults: Sequence[Fault], first: int, last: int, shifted: bool
) -> Iterator[tuple[Gap, Positions | None]]:
    """Gaps in place of a stretch, and where its atoms are to be; None: on a rod."""
    there = chain.slots[first : last + 1]
    near: Positions = {one.label: one.atoms_A for one in there}
    whole = [_without_all(one) for one in there]
    if _open(chain, first):
        whole[0] = _with_phosphate(whole[0], near)
    if shifted:
        yield from _shifted(chain, first, last)
        return
    # a base that only its own sugar runs into is where it belongs
    bad = {atom for f in faults if f.kind != "clash" or len(f.places) == 2 for atom in f.atoms}
    inside = {fault.places[0] for fault in faults if len(fault.places) == 1}
    kept = [
        _with_base(empty, one) if not _base_at_fault(one, first + k, bad) else empty
        for k, (empty, one) in enumerate(zip(whole, there, strict=True))
    ]
    if any(one is not empty for one, empty in zip(kept, whole, strict=True)):
        yield _gap(chain, first, last, kept), near
        if inside & set(range(first, last + 1)):
            # what is wrong inside is laid anew on the base
            right = {one.label: {} if first + k in inside else one.atoms_A
                     for k, one in enumerate(there)}  # fmt: skip
            yield _gap(chain, first, last, kept), right
    gap = _gap(chain, first, last, whole)
    yield gap, near
    if last - first < LONGEST_END and (gap.before is None or gap.after is None):
        yield from _shifted(chain, first, last)
    if gap.before is not None and gap.after is not None:
        yield gap, None


def _shifted(chain: Chain, first: int, last: int) -> Iterator[tuple[Gap, Positions]]:
    """A stretch as it is, moved to where it is joined to its neighbours."""
    there = chain.slots[first : last + 1]
    back = moved_back(*_flanks(chain, first, last), there)
    if back is None:
        return
    monomers = [_without_all(one) for one in there]
    if _open(chain, first):
        monomers[0] = _with_phosphate(monomers[0], back)
    yield _gap(chain, first, last, monomers), back


def _with_phosphate(empty: Monomer, places: Positions) -> Monomer:
    """A nucleotide at a 5' end: nothing that is built would hold its phosphate."""
    atoms = places[empty.label]
    return replace(empty, atoms_A={x: at for x, at in atoms.items() if x in (*PHOSPHATE, "OP3")})


def _without_all(one: Monomer) -> Monomer:
    return replace(one, atoms_A={})


def _is_base(name: str) -> bool:
    return "'" not in name and name not in (*PHOSPHATE, "OP3")


def _with_base(empty: Monomer, one: Monomer) -> Monomer:
    base = {name: at for name, at in one.atoms_A.items() if _is_base(name)}
    return replace(empty, atoms_A={**empty.atoms_A, **base})


def _base_at_fault(one: Monomer, place: int, bad: Collection[tuple[int, str]]) -> bool:
    glycosidic = "N9" if one.letter in "AG" else "N1"
    return any(
        (place, name) in bad and name != glycosidic for name in one.atoms_A if _is_base(name)
    )


def _flanks(chain: Chain, first: int, last: int) -> tuple[Monomer | None, Monomer | None]:
    """The nucleotides that a stretch is joined to; None at an open end."""
    before = None if _open(chain, first) else chain.slots[first - 1]
    after = None if _open(chain, last + 1) else chain.slots[last + 1]
    return before, after


def _gap(chain: Chain, first: int, last: int, monomers: Sequence[Monomer]) -> Gap:
    """A stretch as a gap; at an open end without a flank there, which near positions allow."""
    slots = chain.slots
    before, after = _flanks(chain, first, last)

    def beyond(flank: Monomer | None, k: int) -> Monomer | None:
        if flank is None or not 0 <= k < len(slots) or not slots[k].atoms_A:
            return None
        pair = (slots[k], flank) if k < first else (flank, slots[k])
        return slots[k] if bonded(*pair) else None

    return Gap(
        tuple(monomers),
        before,  # type: ignore[arg-type]
        after,  # type: ignore[arg-type]
        beyond(before, first - 2),
        beyond(after, last + 2),
    )


def _rows(atoms: HeavyAtoms, there: Sequence[Monomer], kept: Sequence[Monomer]) -> Index:
    """Rows of the atoms of a stretch that are not kept."""
    out = []
    for one, stays in zip(there, kept, strict=True):
        moving = [at for name, at in one.atoms_A.items() if stays.atoms_A.get(name) is not at]
        mine = np.flatnonzero(
            np.isin(atoms.residue, [k for k, x in enumerate(atoms.labels) if x == one.label])
        )
        away = np.linalg.norm(atoms.positions_A[mine, None] - np.array(moving), axis=2)
        out.append(mine[away.min(axis=1) < 1e-3])
    return np.concatenate(out)


def _near(gap: Gap, near: Positions, around: HeavyAtoms) -> StrandModel:
    return build_strand(gap, _Through(gap, near), around, near=near, max_seconds=MAX_SECONDS)


class _Through:
    """A line through the centroids of nucleotides where they are to be."""

    def __init__(self, gap: Gap, near: Positions) -> None:
        places = {}
        for k, one in enumerate((gap.before, *gap.monomers, gap.after)):
            atoms: Any = {} if one is None else one.atoms_A or near[one.label]
            if atoms:
                places[k] = np.mean(list(atoms.values()), axis=0)
        self._phases = np.array(list(places))
        self._points = np.array(list(places.values()))

    def at(self, phases: ArrayLike) -> tuple[Array, Array]:
        """Points (m, 3), Å, and frames (m, 3, 3) at the phases (m,)."""
        phase = np.atleast_1d(np.asarray(phases, dtype=np.float64))
        points = [np.interp(phase, self._phases, column) for column in self._points.T]
        return np.stack(points, axis=1), np.broadcast_to(np.eye(3), (len(phase), 3, 3)).copy()


def _hydrogens(
    entry: Entry, index: int, original: Sequence[Monomer], model: StrandModel
) -> tuple[Removed, ...]:
    """Hydrogens of atoms that have moved: where they would be now is not known."""
    moved = {residue.monomer.label: set(residue.names) for residue in model.residues}
    places = {(one.chain, one.number, one.icode): one for one in original}
    found = []
    for chain in entry.model(index):
        for residue in chain:
            number, icode = residue.seqid.num, residue.seqid.icode.strip()
            one = places.get((chain.name, number, icode))
            if one is None or residue.name != one.resname:
                continue
            for atom in residue:
                if not atom.is_hydrogen():
                    continue
                if _has_moved(np.array(atom.pos.tolist()), one, moved.get(one.label, set())):
                    found.append(Removed(index, chain.name, number, icode, residue.name, atom.name))
    return tuple(dict.fromkeys(found))


def _has_moved(hydrogen: Array, one: Monomer, moved: Collection[str]) -> bool:
    """Whether the atom that carries a hydrogen has moved, or was nowhere near it before."""
    apart = {name: float(np.linalg.norm(at - hydrogen)) for name, at in one.atoms_A.items()}
    carrier = min(apart, key=lambda name: apart[name])
    return carrier in moved or apart[carrier] > HYDROGEN_A
