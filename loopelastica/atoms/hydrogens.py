"""Hydrogens of nucleotides: wwPDB names, ideal places.

Which hydrogens a nucleotide has, and on which side of its neighbours each one is, says the table
``data/hydrogens.json``, made from the wwPDB's dictionary by ``data/make_hydrogens.py``. Fixed ones
are placed at ideal lengths and angles from the heavy atoms that are there, and bent aside where
they come too near to something else; a hydroxyl or a methyl group turns to where it has room and,
of hydroxyls, a hydrogen bond.

Lengths and angles are those of Amber's parm94, which OL3 and OL15 keep: Cornell et al., J. Am.
Chem. Soc. 117 (1995) 5179, doi:10.1021/ja00124a002. Acids (phosphates) have no hydrogen.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from loopelastica._arrays import Array
from loopelastica._files import data_path
from loopelastica._vectors import unit
from loopelastica.atoms.easing import eased
from loopelastica.atoms.turning import turned
from loopelastica.molecule.components import METHYLATED, is_standard
from loopelastica.molecule.nucleotides import enumerated
from loopelastica.molecule.polymer import Monomer

LENGTH_A: Final = {"C": 1.09, "N": 1.01, "O": 0.96, "S": 1.336}
FLAT_CH_A: Final = 1.08
"""Carbon with a double bond to hydrogen."""
_HALF_CH2: Final = np.deg2rad(109.5 / 2)
_FLAT: Final = np.deg2rad(120.0)
_BONDED_A: Final = (0.9, 2.2)
"""What two bonded heavy atoms are apart at least and at most, where hydrogens can be placed."""
_LINKED_A: Final = 1.9
"""An oxygen with a second heavy atom nearer than this has no hydrogen."""
_SAME_A: Final = 0.3
_SHORTEST: Final = 0.15
"""Shortest sum of unit vectors to the neighbours that still says where away is."""


class Rule(NamedTuple):
    """How hydrogens are placed: see ``data/make_hydrogens.py``."""

    kind: str
    hydrogens: tuple[str, ...]
    carrier: str
    neighbours: tuple[str, ...]


_CAP_5: Final = Rule("turning", ("HO5'",), "O5'", ("C5'", "C4'"))


class Hydrogens(list[dict[str, Array]]):
    """Names and positions (3,) of the hydrogens of each nucleotide, Å.

    Attributes
    ----------
    remarks : tuple of str
        One sentence for each nucleotide that did not get all.
    """

    remarks: tuple[str, ...] = ()


def add_hydrogens(
    monomers: Sequence[Monomer], bonded: Sequence[tuple[bool, bool]], around_A: Array
) -> Hydrogens:
    """All hydrogens of some nucleotides.

    Parameters
    ----------
    monomers : sequence of Monomer
        With their heavy atoms.
    bonded : sequence of (bool, bool)
        Of each: whether its P is bonded to an O3' before it, whether its O3' is bonded to a P
        after it. Without P it gets HO5', without a bond of O3' it gets HO3'.
    around_A : (N, 3) array
        What else is there, Å; the nucleotides' own atoms may be among it.

    Returns
    -------
    Hydrogens
        A list: of each nucleotide wwPDB names and positions (3,), in the order of the wwPDB. What
        is unknown or has atoms where none can be gets none; ``remarks`` says so.

    Examples
    --------
    >>> from loopelastica.atoms.fibre import fibre_nucleotide
    >>> uridine = Monomer("A", 1, "", "U", "U", False, atoms_A=fibre_nucleotide("U", False))
    >>> (found,) = add_hydrogens([uridine], [(True, False)], np.zeros((0, 3)))
    >>> " ".join(found)
    "H5' H5'' H4' H3' HO3' H2' HO2' H1' H3 H5 H6"
    """
    remarks: dict[int, str] = {}
    rules = [_rules_in_chain(k, m, bonded[k], remarks) for k, m in enumerate(monomers)]
    heavy = _Heavy.of(monomers, np.asarray(around_A, dtype=np.float64).reshape(-1, 3))
    sites = list(_sites(monomers, rules, remarks))
    placed: dict[tuple[int, str], Array] = {}
    refused: dict[int, str] = {}
    groups: dict[tuple[str, int], list[_Site]] = defaultdict(list)
    for site in sites:
        groups[site.rule.kind, len(site.rows)].append(site)
    for (kind, _), group in groups.items():
        _place(kind, group, heavy, placed, refused)
    placed = {key: at for key, at in placed.items() if key[0] not in refused}
    _ease([s for s in sites if (s.k, s.rule.hydrogens[0]) in placed], heavy, placed)
    turning = [s for s in sites if s.rule.kind == "turning" and s.k not in refused]
    _turn([s for s in turning if not heavy.linked(s.rows)], heavy, placed)
    remarks |= {
        k: f"{monomers[k].label}: {why}; it gets no hydrogens" for k, why in refused.items()
    }
    out = Hydrogens(
        {name: placed[k, name] for rule in own for name in rule.hydrogens if (k, name) in placed}
        for k, own in enumerate(rules)
    )
    out.remarks = tuple(remarks[k] for k in sorted(remarks))
    return out


class _Site(NamedTuple):
    """A rule on a nucleotide: number of it, and rows of carrier and neighbours."""

    k: int
    rule: Rule
    rows: list[int]


class _Heavy(NamedTuple):
    """Heavy atoms: the nucleotides' own, and all that are there.

    `polar` (N,) says which of all are nitrogens and oxygens of the nucleotides.
    """

    own_A: Array
    all_A: Array
    polar: NDArray[np.bool_]
    tree: cKDTree

    @classmethod
    def of(cls, monomers: Sequence[Monomer], around_A: Array) -> _Heavy:
        """Of nucleotides and of what is around them, which may have the same atoms."""
        names = [name for one in monomers for name in one.atoms_A]
        positions = [at for one in monomers for at in one.atoms_A.values()]
        own = np.array(positions, dtype=np.float64).reshape(-1, 3)
        finite = np.isfinite(own).all(axis=1)
        around = around_A[np.isfinite(around_A).all(axis=1)]
        if finite.any() and len(around):
            around = around[cKDTree(own[finite]).query(around)[0] > _SAME_A]
        everything = np.concatenate([own[finite], around])
        polar = np.zeros(len(everything), dtype=np.bool_)
        polar[: finite.sum()] = np.array([name[0] in "NO" for name in names], dtype=bool)[finite]
        return cls(own, everything, polar, cKDTree(everything))

    def linked(self, rows: list[int]) -> bool:
        """Whether a carrier has a second neighbour, such as the P of a cyclic phosphate."""
        near = self.all_A[self.tree.query_ball_point(self.own_A[rows[0]], _LINKED_A)]
        away = np.linalg.norm(near[:, None] - self.own_A[rows], axis=2).min(axis=1)
        return bool((away > _SAME_A).any())


def _rules_in_chain(
    k: int, monomer: Monomer, bonded: tuple[bool, bool], remarks: dict[int, str]
) -> tuple[Rule, ...]:
    """The rules of a nucleotide that its place in the chain leaves."""
    if not monomer.atoms_A:
        return ()
    wrong = [name for name, at in monomer.atoms_A.items() if not np.isfinite(at).all()]
    if wrong:
        remarks[k] = (
            f"{monomer.label}: the position of {enumerated(wrong)} is no number; it gets no"
            " hydrogens"
        )
        return ()
    rules = hydrogen_rules(monomer)
    if rules is None:
        remarks[k] = (
            f"{monomer.label}: {monomer.resname} is not in the table of hydrogens; it gets none"
        )
        return ()
    if bonded[1]:
        rules = tuple(rule for rule in rules if rule.carrier != "O3'")
    return rules if "P" in monomer.atoms_A else (*rules, _CAP_5)


def _sites(
    monomers: Sequence[Monomer], rules: Sequence[tuple[Rule, ...]], remarks: dict[int, str]
) -> Iterator[_Site]:
    """Every rule whose atoms are there."""
    begin = 0
    for k, monomer in enumerate(monomers):
        rows = {name: begin + i for i, name in enumerate(monomer.atoms_A)}
        begin += len(rows)
        lacking: dict[str, None] = {}
        for rule in rules[k]:
            names = (rule.carrier, *rule.neighbours)
            missing = [name for name in names if name not in rows]
            if not missing:
                yield _Site(k, rule, [rows[name] for name in names])
            lacking |= dict.fromkeys(missing)
        if lacking:
            remarks[k] = (
                f"{monomer.label} lacks {enumerated([*lacking])}; it gets no hydrogens there"
            )


def _place(
    kind: str,
    group: Sequence[_Site],
    heavy: _Heavy,
    placed: dict[tuple[int, str], Array],
    refused: dict[int, str],
) -> None:
    """Place the hydrogens of one kind, if they are fixed; what has wrong bonds is refused."""
    at = heavy.own_A[np.array([site.rows for site in group])]
    chain = kind in ("cis", "trans", "turning")
    lengths = np.linalg.norm(at[:, 1:] - (at[:, :-1] if chain else at[:, :1]), axis=2)
    wrong = (lengths < _BONDED_A[0]) | (lengths > _BONDED_A[1])
    for row, j in np.argwhere(wrong).tolist():
        site = group[row]
        names = (site.rule.carrier, *site.rule.neighbours)
        pair = f"{names[j if chain else 0]} and {names[j + 1]}"
        refused.setdefault(site.k, f"{pair} are {lengths[row, j]:.2f} Å apart")
    if kind == "turning":
        return
    directions, defined = _direction(kind, at)
    to = np.array([_length_A(site.rule) for site in group])[:, None] * directions
    for site, here, good in zip(group, at[:, 0] + to, defined, strict=True):
        placed[site.k, site.rule.hydrogens[0]] = here
        if not good:
            why = (
                f"the neighbours of {site.rule.carrier} leave no place for {site.rule.hydrogens[0]}"
            )
            refused.setdefault(site.k, why)


def _ease(group: Sequence[_Site], heavy: _Heavy, placed: dict[tuple[int, str], Array]) -> None:
    """Bend aside what is placed too near to something else."""
    if not group:
        return
    keys = [(site.k, site.rule.hydrogens[0]) for site in group]
    places = eased(
        np.array([placed[key] for key in keys]),
        heavy.own_A[np.array([site.rows[0] for site in group])],
        np.array([site.rule.carrier[0] in "NO" for site in group]),
        heavy.all_A,
    )
    placed.update(zip(keys, places, strict=True))


def _turn(group: Sequence[_Site], heavy: _Heavy, placed: dict[tuple[int, str], Array]) -> None:
    """Turn what can turn to where it has room among all that is placed."""
    if not group:
        return
    fixed = np.array(list(placed.values())).reshape(-1, 3)
    places = turned(
        heavy.own_A[np.array([site.rows for site in group])],
        [len(site.rule.hydrogens) for site in group],
        np.array([_length_A(site.rule) for site in group]),
        heavy.all_A,
        heavy.polar,
        fixed,
    )
    for site, at in zip(group, places, strict=True):
        placed |= {(site.k, h): here for h, here in zip(site.rule.hydrogens, at, strict=True)}


def hydrogen_rules(monomer: Monomer) -> tuple[Rule, ...] | None:
    """How the hydrogens of a nucleotide are placed, HO5' left out; None where it is unknown.

    Parameters
    ----------
    monomer : Monomer
        Its name counts, and of standard ones base and sugar.

    Returns
    -------
    tuple of Rule or None
    """
    name = monomer.resname.strip().upper()
    if name in METHYLATED or not is_standard(name):
        return _component_rules(name)
    letter, is_dna = monomer.letter, monomer.is_dna
    if letter == "T" and not is_dna and "C5M" in monomer.atoms_A:
        return _component_rules("5MU")
    base = f"D{letter}" if is_dna or letter == "T" else letter
    return _component_rules(base, "dna" if is_dna else "rna")


def carriers(monomer: Monomer) -> dict[str, str]:
    """Heavy atom that carries each hydrogen that a nucleotide may have.

    Parameters
    ----------
    monomer : Monomer
        Its name counts.

    Returns
    -------
    dict of str to str
        Empty where it is unknown.
    """
    rules = hydrogen_rules(monomer)
    return {} if rules is None else {h: r.carrier for r in (*rules, _CAP_5) for h in r.hydrogens}


@cache
def _table() -> Any:
    return json.loads(data_path("hydrogens.json").read_text(encoding="utf-8"))


@cache
def _component_rules(name: str, sugar: str | None = None) -> tuple[Rule, ...] | None:
    """Rules of a component, with another sugar where one is named."""
    table = _table()
    one = table["components"].get(name)
    if one is None:
        return None
    texts = [*table["sugars"].get(sugar or one["sugar"], []), *one["rules"]]
    return tuple(
        Rule(kind, tuple(hydrogens.split(",")), carrier, tuple(neighbours))
        for kind, hydrogens, carrier, *neighbours in map(str.split, texts)
    )


def _length_A(rule: Rule) -> float:
    element = rule.carrier[0]
    flat = rule.kind in ("cis", "trans") or (rule.kind, len(rule.neighbours)) == ("opposite", 2)
    return FLAT_CH_A if element == "C" and flat else LENGTH_A[element]


def _direction(kind: str, at: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Unit vectors (n, 3) from carriers to hydrogens, and whether they are defined (n,).

    `at` (n, m, 3) are carriers and their neighbours.
    """
    if kind in ("cis", "trans"):
        axis = unit(at[:, 1] - at[:, 0])
        across = at[:, 2] - at[:, 1]
        across -= (across * axis).sum(axis=1, keepdims=True) * axis
        sign = 1.0 if kind == "cis" else -1.0
        out = np.cos(_FLAT) * axis + sign * np.sin(_FLAT) * unit(across)
        return out, np.linalg.norm(across, axis=1) > _SHORTEST
    to = unit(at[:, 1:] - at[:, :1])
    away = -to.sum(axis=1)
    defined = np.linalg.norm(away, axis=1) > _SHORTEST
    if to.shape[1] == 3:
        # at equal angles to all three, as in every force field: 614 of NMR entries 0.01-0.02 Å off
        # in the median, along the sum of the three 0.1 Å
        normal = np.cross(to[:, 1] - to[:, 0], to[:, 2] - to[:, 0])
        away = normal * np.sign((normal * away).sum(axis=1))[:, None]
    away = unit(away)
    if kind == "opposite":
        return away, defined
    normal = np.cross(to[:, 0], to[:, 1])
    defined &= np.linalg.norm(normal, axis=1) > _SHORTEST
    return np.cos(_HALF_CH2) * away + np.sin(_HALF_CH2) * unit(normal), defined
