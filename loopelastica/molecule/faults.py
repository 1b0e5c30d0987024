"""What is broken in chains that are there: bonds, hands, clashes. Geometry alone.

A *fault* is what no chemistry allows: two joined atoms more than 2 Å apart or on top of each other,
a sugar centre of the wrong hand, unjoined atoms of one chain nearer than 2.2 Å. Which of the two
free oxygens of a phosphate is called OP1 is no fault: older files exchange the names.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Final, Literal

import numpy as np

from loopelastica._arrays import Array
from loopelastica.molecule.chains import Chain, bond_A, neighbours
from loopelastica.molecule.components import expected_atoms, is_standard
from loopelastica.molecule.polymer import Monomer

LONGEST_BOND_A: Final = 2.0
SHORTEST_BOND_A: Final = 1.0
CLOSE_A: Final = 2.2
"""Unjoined heavy atoms nearer than this clash."""
JUNCTION: Final = (
    # O3' of a nucleotide or its C3', an atom of the next one, ideal distance in Å
    ("O3'", "P", 1.61),
    ("C3'", "P", 2.60),
    ("O3'", "O5'", 2.50),
    ("O3'", "OP1", 2.52),
    ("O3'", "OP2", 2.52),
)
"""What the O3'–P bond and its angles hold. Ideal values: Parkinson et al., Acta Cryst. D 52 (1996)
57, doi:10.1107/S0907444995011115."""
_ACROSS: Final = {(a, b) for a, b, _ in JUNCTION}
STRAIN_A: Final = 0.6
"""A junction with a distance further off than this is as good as broken."""

FLAT_A3: Final = 0.6
"""Signed volume of a centre and its neighbours below which its hand is wrong, or it has none; right
ones have 2.5 Å³, the flattest of 42,000 in real structures but one 0.61."""

_SUGAR: Final = (
    ("P", "OP1"), ("P", "OP2"), ("P", "O5'"), ("O5'", "C5'"), ("C5'", "C4'"), ("C4'", "C3'"),
    ("C4'", "O4'"), ("C3'", "O3'"), ("C3'", "C2'"), ("C2'", "O2'"), ("C2'", "C1'"), ("C1'", "O4'"),
)  # fmt: skip
_SIX_RING: Final = (
    ("N1", "C2"), ("C2", "N3"), ("N3", "C4"), ("C4", "C5"), ("C5", "C6"), ("C6", "N1"),
)  # fmt: skip
_FIVE_RING: Final = (("C5", "N7"), ("N7", "C8"), ("C8", "N9"), ("N9", "C4"))
_SIDE: Final = {
    "A": (("C6", "N6"),),
    "G": (("C6", "O6"), ("C2", "N2")),
    "C": (("C2", "O2"), ("C4", "N4")),
    "U": (("C2", "O2"), ("C4", "O4")),
    "T": (("C2", "O2"), ("C4", "O4"), ("C5", "C7")),
}
_HANDS: Final = (
    # centre and three neighbours whose signed volume is positive
    ("C1'", "O4'", "C2'", "base"),
    ("C2'", "C1'", "O2'", "C3'"),
    ("C3'", "C4'", "C2'", "O3'"),
    ("C4'", "C5'", "C3'", "O4'"),
)


@dataclass(frozen=True, slots=True)
class Fault:
    """One thing that is broken.

    Attributes
    ----------
    kind : {"bond", "hand", "clash"}
    places : tuple of int
        Nucleotides in the chain, from 0; one of them or both have to change.
    where, what : str
        Such as "A.G12–A.C13" and "O3'–P 3.4 Å".
    atoms : tuple of (int, str)
        The atoms that it is about: nucleotide and name.
    """

    kind: Literal["bond", "hand", "clash"]
    places: tuple[int, ...]
    where: str
    what: str
    atoms: tuple[tuple[int, str], ...]

    @property
    def key(self) -> tuple[object, ...]:
        """What it is, whatever its size; two nucleotides clash or do not."""
        return self.kind, self.places, () if self.kind == "clash" else self.atoms

    def __str__(self) -> str:
        """Return it as a phrase."""
        return f"{self.where}: {self.what}"


def find_faults(chain: Chain) -> list[Fault]:
    """Everything that is broken in one chain: bonds first, then hands, then clashes.

    Parameters
    ----------
    chain : Chain
        Nucleotides that are missing are no fault.

    Returns
    -------
    list of Fault

    Examples
    --------
    >>> from loopelastica._files import data_path
    >>> from loopelastica.molecule.chains import chains_of
    >>> from loopelastica.molecule.entry import read_entry
    >>> [find_faults(c) for c in chains_of(read_entry(data_path("hairpins/2koc.pdb")))]
    [[]]
    """
    slots = chain.slots
    return [*_links(chain), *_bonds(slots), *_hands(slots), *_clashes(slots)]


def broken_or_strained(first: Monomer, second: Monomer) -> bool:
    """Whether the bond between two neighbours, or an angle at it, is far from what it should be.

    Parameters
    ----------
    first, second : Monomer
        Neighbours, 5' to 3'.

    Returns
    -------
    bool
    """
    return bool(np.abs(junction_errors(first.atoms_A, second.atoms_A)).max(initial=0.0) > STRAIN_A)


def junction_errors(first: Mapping[str, Array], second: Mapping[str, Array]) -> Array:
    """By how much the distances across an O3'–P bond are off, Å; those of atoms that are there.

    Parameters
    ----------
    first, second : mapping of str to (3,) array
        Atoms of neighbours, 5' to 3', Å.

    Returns
    -------
    (k,) array
    """
    return np.array(
        [
            np.linalg.norm(first[a] - second[b]) - ideal
            for a, b, ideal in JUNCTION
            if a in first and b in second
        ]
    )


def strain_A(one: Monomer) -> float:
    """By how much a nucleotide's bonds and angles leave their range, summed up.

    Parameters
    ----------
    one : Monomer

    Returns
    -------
    float
        Bonds outside 1.15–1.75 Å, and atoms two bonds apart outside 2.1–2.8 Å.
    """
    if not _known(one):
        return 0.0
    bonded = {frozenset(pair) for pair in bonds_of(one.letter)}
    out = 0.0
    for pair in _within_two(one.letter):
        a, b = (one.atoms_A.get(name) for name in pair)
        if a is not None and b is not None:
            least, most = (1.15, 1.75) if pair in bonded else (2.1, 2.8)
            apart = float(np.linalg.norm(a - b))
            out += max(least - apart, apart - most, 0.0)
    return out


def _known(one: Monomer) -> bool:
    """Whether its bonds are those of the table."""
    return bool(one.atoms_A) and is_standard(one.resname) and one.letter in _SIDE


@lru_cache
def bonds_of(letter: str) -> tuple[tuple[str, str], ...]:
    """Bonds of the heavy atoms of a nucleotide with a base, by names of the wwPDB.

    >>> len(bonds_of("A")), ("C1'", "N9") in bonds_of("A")
    (24, True)
    """
    purine = letter in "AG"
    ring = (*_SIX_RING, *(_FIVE_RING if purine else ()))
    return (*_SUGAR, ("C1'", "N9" if purine else "N1"), *ring, *_SIDE[letter])


@lru_cache
def _within_two(letter: str) -> frozenset[frozenset[str]]:
    """Pairs of atoms of a nucleotide with at most two bonds between them."""
    beside: dict[str, set[str]] = {}
    for a, b in bonds_of(letter):
        beside.setdefault(a, set()).add(b)
        beside.setdefault(b, set()).add(a)
    one = {frozenset(pair) for pair in bonds_of(letter)}
    two = {frozenset((a, b)) for around in beside.values() for a in around for b in around if a < b}
    return frozenset(one | two)


def _lengths(one: Monomer) -> Iterator[tuple[tuple[str, str], float]]:
    if _known(one):
        for a, b in bonds_of(one.letter):
            if a in one.atoms_A and b in one.atoms_A:
                yield (a, b), float(np.linalg.norm(one.atoms_A[a] - one.atoms_A[b]))


def _wrong_length(length_A: float) -> bool:
    return not SHORTEST_BOND_A <= length_A <= LONGEST_BOND_A


def _links(chain: Chain) -> Iterator[Fault]:
    """O3'–P bonds between neighbours."""
    for k, (first, second) in enumerate(pairwise(chain.slots)):
        if not neighbours(chain, first, second):
            continue
        bond = bond_A(first, second)
        if not np.isnan(bond) and _wrong_length(bond):
            where, atoms = f"{first.label}–{second.label}", ((k, "O3'"), (k + 1, "P"))
            yield Fault("bond", (k, k + 1), where, f"O3'–P {bond:.1f} Å", atoms)


def _bonds(slots: Sequence[Monomer]) -> Iterator[Fault]:
    """Bonds inside nucleotides."""
    for k, one in enumerate(slots):
        for (a, b), length in _lengths(one):
            if _wrong_length(length):
                yield Fault("bond", (k,), one.label, f"{a}–{b} {length:.1f} Å", ((k, a), (k, b)))


def _hands(slots: Sequence[Monomer]) -> Iterator[Fault]:
    for k, one in enumerate(slots):
        for centre, *names in _HANDS if _known(one) else ():
            base = "N9" if one.letter in "AG" else "N1"
            atoms = [one.atoms_A.get(base if x == "base" else x) for x in (centre, *names)]
            if any(at is None for at in atoms):
                continue
            origin, *arms = atoms
            a, b, c = (arm - origin for arm in arms)  # type: ignore[operator]
            if a @ np.cross(b, c) < FLAT_A3:
                yield Fault("hand", (k,), one.label, f"wrong hand at {centre}", ((k, centre),))


def _clashes(slots: Sequence[Monomer]) -> Iterator[Fault]:
    """The nearest pair of atoms of each two nucleotides, where they are too near."""
    from scipy.spatial import cKDTree

    rows = [(k, name) for k, one in enumerate(slots) for name in one.atoms_A]
    if not rows:
        return
    positions = np.array([slots[k].atoms_A[name] for k, name in rows])
    pairs = cKDTree(positions).query_pairs(CLOSE_A, output_type="ndarray")
    apart = np.linalg.norm(positions[pairs[:, 0]] - positions[pairs[:, 1]], axis=1)
    seen: set[tuple[int, int]] = set()
    for i, j in pairs[np.argsort(apart, kind="stable")]:
        (k, a), (m, b) = sorted((rows[i], rows[j]))
        if (k, m) in seen or _joined(slots, k, a, m, b):
            continue
        seen.add((k, m))
        yield _clash(slots, k, a, m, b)


def _clash(slots: Sequence[Monomer], k: int, a: str, m: int, b: str) -> Fault:
    distance = float(np.linalg.norm(slots[k].atoms_A[a] - slots[m].atoms_A[b]))
    labels = dict.fromkeys(slots[place].label for place in (k, m))
    places = tuple(dict.fromkeys((k, m)))
    what = f"{a} and {b} {distance:.1f} Å apart"
    return Fault("clash", places, "–".join(labels), what, ((k, a), (m, b)))


def _joined(slots: Sequence[Monomer], k: int, a: str, m: int, b: str) -> bool:
    """Whether at most two bonds lie between two atoms, or it cannot be known."""
    first, second = slots[k], slots[m]
    names = [expected_atoms(one.resname, one.letter, one.is_dna) for one in (first, second)]
    if a not in names[0] or b not in names[1]:
        # groups of modified nucleotides may be bonded to anything
        return True
    if k == m:
        return not _known(first) or frozenset((a, b)) in _within_two(first.letter)
    # chains may be closed, and what is missing between two may be nothing
    if (a, b) in _ACROSS and (m == k + 1 or bond_A(first, second) <= LONGEST_BOND_A):
        return True
    return (b, a) in _ACROSS and bond_A(second, first) <= LONGEST_BOND_A
