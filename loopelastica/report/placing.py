"""Where added atoms belong among the rows of a file, and which rows move or go; for any format.

A row is an atom of the file. Rows of one residue that follow each other are a run. A missing
nucleotide comes after the last row of the one before it; a missing atom into the run of its
nucleotide, by the order of the wwPDB.
"""

from __future__ import annotations

import itertools
import math
import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from loopelastica.errors import StructureError
from loopelastica.molecule.components import atom_name
from loopelastica.report.changes import AddedResidue, Changes, Place, Removed, label

_BACKBONE: Final = (
    *("OP3", "P", "OP1", "OP2", "O5'", "C5'", "C4'", "O4'"),
    *("C3'", "O3'", "C2'", "O2'", "C1'"),
)
_PURINE: Final = ("N9", "C8", "N7", "C5", "C6", "O6", "N6", "N1", "C2", "N2", "N3", "C4")
_PYRIMIDINE: Final = ("N1", "C2", "O2", "N3", "C4", "O4", "N4", "C5", "C7", "C6")
_SUGAR: Final = ("P", "O5'", "C5'", "C4'", "C3'", "O3'", "C1'")
_TODAY: Final[dict[str, str]] = {"O1P": "OP1", "O2P": "OP2", "O3P": "OP3"}
_YESTERDAY: Final = {today: old for old, today in _TODAY.items()}
_SAME_A: Final = 0.01

PositionOf = Callable[[int], Sequence[float]]

# nucleotides by their names in the wwPDB and in force fields, such as A, DA, RA5, ADE
_PLAIN: Final = re.compile(r"[DR]?[ACGTUIN][35N]?|ADE|CYT|GUA|THY|URA")


class Row(NamedTuple):
    """One atom of the file."""

    model: int
    place: Place
    resname: str
    name: str
    altloc: str
    asym: str
    # the chain by another name: that of files whose segments name it, say
    chain_too: str


class NewAtom(NamedTuple):
    """One atom that comes in, as it is to be written, and the row that it is like."""

    residue: AddedResidue
    atom: int
    name: str
    resname: str
    altloc: str
    like: int
    # whether its residue is in the file already
    completes: bool


@dataclass(slots=True)
class Plan:
    """New atoms before and after rows; rows that move; rows that go."""

    before: dict[int, list[NewAtom]] = field(default_factory=lambda: defaultdict(list))
    after: dict[int, list[NewAtom]] = field(default_factory=lambda: defaultdict(list))
    moved: dict[int, tuple[float, ...]] = field(default_factory=dict)
    gone: set[int] = field(default_factory=set)

    @property
    def new(self) -> list[NewAtom]:
        """All atoms that come in."""
        return [atom for part in (self.before, self.after) for row in part for atom in part[row]]


def today(name: str) -> str:
    """An atom's name as the wwPDB writes it today.

    >>> today("O1P"), today("C5*"), today("P")
    ('OP1', "C5'", 'P')
    """
    return _TODAY.get(name, name).replace("*", "'")


def record_name(atom: NewAtom, like: str, others: Mapping[str, str]) -> str:
    """ATOM or HETATM for a new atom.

    Parameters
    ----------
    atom : NewAtom
    like : str
        That of the atom it is like.
    others : mapping of str to str
        Those of the residues in the file, by their names.

    Returns
    -------
    str
    """
    if atom.completes:
        return like
    if _PLAIN.fullmatch(atom.resname):
        return "ATOM"
    return others.get(atom.resname, "HETATM")


def plan_for(rows: Sequence[Row], position_A: PositionOf, changes: Changes) -> Plan:
    """Where everything goes.

    Parameters
    ----------
    rows : sequence of Row
        All atoms in the order of the file.
    position_A : callable
        Where the atom of a row is, Å.
    changes : Changes

    Raises
    ------
    StructureError
        If the file lacks the residue that an addition follows, or an atom that is to move; or has
        an atom that is to be added.
    """
    sites = _Sites(rows, position_A)
    plan = Plan()
    followers: dict[tuple[int, Place], list[AddedResidue]] = defaultdict(list)
    first: list[AddedResidue] = []
    for removed in changes.removed:
        plan.gone.update(sites.removed(removed))
    own = {(residue.model, residue.place) for residue in changes.added}
    for residue in changes.added:
        run = sites.nucleotide(residue.model, residue.place, residue.resname, residue.asym)
        if run is not None and plan.gone.issuperset(run):
            # all of it is given up for this one
            plan.after[run[-1]].extend(_whole(residue, like=run[-1]))
            own.discard((residue.model, residue.place))
        elif run is not None:
            own.discard((residue.model, residue.place))
            _complete(plan, rows, run, residue)
        elif residue.after is None:
            first.append(residue)
        else:
            followers[residue.model, residue.after].append(residue)
    for residue in first:
        run = sites.beginning(residue)
        for one in _in_order(residue, followers):
            plan.before[run.start].extend(_whole(one, like=run.start))
    # those that follow a nucleotide of the file, each with the added ones that follow it
    for model, place in [key for key in followers if key not in own]:
        for residue in followers.pop((model, place)):
            run = sites.anchor(residue)
            for one in _in_order(residue, followers):
                plan.after[run[-1]].extend(_whole(one, like=run[-1]))
    for left in itertools.chain(*followers.values()):
        raise StructureError(
            f"{left.label}: it is to follow {label(left.after or left.place)}, which is neither in"
            " the file nor among the nucleotides that lead there"
        )
    for key, position in changes.moved.items():
        row, *others = sites.atom(*key)
        plan.moved[row] = tuple(float(x) for x in position)
        plan.gone.update(others)
    return plan


def renumbered(numbers: Iterable[int | None], floor: dict[int, int], last: int) -> list[int]:
    """Numbers that rise from row to row: the old ones where they can stay, else the next.

    Parameters
    ----------
    numbers : iterable of int or None
        Of rows in their order; None for a new one.
    floor : dict
        What an old number has at least become elsewhere; kept up to date.
    last : int
        The number before the first one.

    Returns
    -------
    list of int

    Examples
    --------
    >>> renumbered([1, 2, None, None, 4, 9], {}, 0)
    [1, 2, 3, 4, 5, 9]
    """
    out = []
    for number in numbers:
        last += 1
        if number is not None:
            last = max(last, number, floor.get(number, last))
            floor[number] = last
        out.append(last)
    return out


class _Sites:
    """The runs of a file, by model and place."""

    def __init__(self, rows: Sequence[Row], position_A: PositionOf) -> None:
        self._rows, self._position = rows, position_A
        self._runs: dict[tuple[int, Place], list[range]] = defaultdict(list)
        self._chains: dict[tuple[int, str], range] = {}
        begin = 0
        for _, group in itertools.groupby(rows, key=lambda r: (r.model, r.place, r.asym)):
            run = range(begin, begin := begin + sum(1 for _ in group))
            row = rows[run.start]
            self._chains.setdefault((row.model, row.place[0]), run)
            self._runs[row.model, row.place].append(run)
            if row.chain_too != row.place[0]:
                self._chains.setdefault((row.model, row.chain_too), run)
                self._runs[row.model, (row.chain_too, *row.place[1:])].append(run)

    def nucleotide(
        self, model: int, place: Place, resname: str = "", asym: str | None = None
    ) -> range | None:
        """The run of a nucleotide that has atoms; None where it has none.

        A water may have its number too, so it is known by its name or by an atom of its backbone.
        """
        for known in (self._is_named, self._has_sugar):
            for run in self._runs.get((model, place), ()):
                if asym in (None, self._rows[run.start].asym) and known(run, resname):
                    return run
        return None

    def _is_named(self, run: range, resname: str) -> bool:
        return any(self._rows[i].resname == resname for i in run)

    def _has_sugar(self, run: range, _: str) -> bool:
        return any(today(self._rows[i].name) in _SUGAR for i in run)

    def anchor(self, residue: AddedResidue) -> range:
        """The run that an added residue follows."""
        after = residue.after or residue.place
        run = self.nucleotide(residue.model, after)
        runs = self._runs.get((residue.model, after), [run])
        if runs[0] is None:
            raise StructureError(
                f"{residue.label}: model {residue.model + 1} has no {label(after)}, which it is to"
                " follow"
            )
        return runs[0] if run is None else run

    def beginning(self, residue: AddedResidue) -> range:
        """The first run of the chain that an added residue begins."""
        run = self._chains.get((residue.model, residue.chain))
        if run is None:
            raise StructureError(
                f"{residue.label}: model {residue.model + 1} has no chain {residue.chain!r} that it"
                " could begin"
            )
        return run

    def removed(self, removed: Removed) -> list[int]:
        """Rows of a residue, or of one atom, that is left out."""
        place = (removed.chain, removed.number, removed.icode)
        runs = self._runs.get((removed.model, place), [])
        if not runs and removed.at_A is not None:
            # beyond 9999 programs count on in several ways, but the place is one
            runs = [
                run
                for (model, _), all_ in self._runs.items()
                for run in all_
                if model == removed.model
            ]
        rows: list[int] = []
        for run in runs:
            mine = [
                i
                for i in run
                # a fourth letter may be that of the chain
                if self._rows[i].resname[:3] == removed.resname[:3]
                and removed.name in (None, self._rows[i].name)
            ]
            at_A = removed.at_A
            if at_A is None or any(math.dist(self._position(i), at_A) < _SAME_A for i in mine):
                rows += mine
        if not rows:
            raise StructureError(
                f"{label(place, removed.resname)}: model {removed.model + 1} has no such residue or"
                " atom that could be left out"
            )
        return rows

    def atom(self, model: int, chain: str, number: int, icode: str, name: str) -> list[int]:
        """Rows of an atom of a nucleotide, one for each of its locations."""
        place = (chain, number, icode)
        run = self.nucleotide(model, place) or range(0)
        rows = [
            i
            for i in run
            if atom_name(self._rows[i].name, self._rows[i].resname) == atom_name(name)
        ]
        if not rows:
            raise StructureError(
                f"{label(place)}: model {model + 1} has no atom {name} there that could be moved"
            )
        return rows


def _in_order(
    residue: AddedResidue, followers: dict[tuple[int, Place], list[AddedResidue]]
) -> Iterable[AddedResidue]:
    """An added residue and the added ones that follow it."""
    waiting = [residue]
    while waiting:
        one = waiting.pop(0)
        yield one
        waiting[:0] = followers.pop((one.model, one.place), [])


def _whole(residue: AddedResidue, like: int) -> list[NewAtom]:
    return [
        NewAtom(residue, k, name, residue.resname, "", like, False) for k, name in _sorted(residue)
    ]


def _complete(plan: Plan, rows: Sequence[Row], run: range, residue: AddedResidue) -> None:
    """Put missing atoms into the run of their nucleotide."""
    named = [i for i in run if rows[i].resname == residue.resname] or list(run)
    resname = rows[named[0]].resname
    mine = [i for i in named if rows[i].resname == resname]
    altlocs = {rows[i].altloc for i in mine}
    altloc = altlocs.pop() if len(altlocs) == 1 else ""
    names = {rows[i].name for i in mine}
    present = {today(rows[i].name): i for i in mine if i not in plan.gone}
    rank = _ranks({*present, *residue.names})
    for k, name in _sorted(residue):
        if today(name) in present:
            raise StructureError(
                f"{residue.label}: the file has its atom {name}, which can therefore not be added"
            )
        # hydrogens come behind all heavy atoms
        own = len(rank) + 1 if residue.elements[k] == "H" else rank.get(name, len(rank))
        earlier = [i for other, i in present.items() if rank.get(other, len(rank)) < own]
        atom = NewAtom(residue, k, _spelt(name, names), resname, altloc, mine[0], True)
        if earlier:
            plan.after[max(earlier)].append(atom)
        else:
            plan.before[mine[0]].append(atom)


def _spelt(name: str, others: set[str]) -> str:
    """An atom's name in the spelling of its residue's others, which may be that of before 2007."""
    if name in _YESTERDAY and any(other in _TODAY for other in others):
        name = _YESTERDAY[name]
    return name.replace("'", "*") if any("*" in other for other in others) else name


def _ranks(names: Iterable[str]) -> dict[str, int]:
    """Place of each atom in the order of the wwPDB, by what the base is."""
    base = _PURINE if "N9" in names else _PYRIMIDINE
    return {name: rank for rank, name in enumerate((*_BACKBONE, *base))}


def _sorted(residue: AddedResidue) -> list[tuple[int, str]]:
    """Number and name of its atoms in the order of the wwPDB, all others behind."""
    rank = _ranks(residue.names)
    return sorted(enumerate(residue.names), key=lambda atom: rank.get(atom[1], len(rank)))
