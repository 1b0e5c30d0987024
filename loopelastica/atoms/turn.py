"""Nucleosides turned about the line (step iii): one angle Ω per nucleotide, and χ.

Every nucleotide has the same few states: Ω in steps round the circle, χ at that of the fibre, 30°
to either side, and syn. The score of a combination is a sum over nucleotides and pairs,

    clashes      Σ (3.2 Å − d)² over heavy atoms nearer than that, stem and loop, per Å²
    junctions    2 (|d − 2.5 Å| − 1 Å)² where O3' and the next O5' are further from the distance
                 they have round a phosphorus than the minimization mends with ease, per Å²
    stacking     −2 for two bases that lie flat upon each other 3.4 Å apart, falling off smoothly;
                 neighbours in the chain, the closing pair and bases across the loop alike
    syn          +1, for pyrimidines +2
    contact      −4 for a pair of the first and last loop nucleotide that is requested by name

in units of about kT. The weights are stated choices, not fits: they put chemistry (no clash, no
broken chain) before preference. A beam over the chain keeps the best combinations; ties and order
are decided by the state's number, so that the result is always the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from loopelastica._arrays import Array, Record
from loopelastica._checks import shown
from loopelastica.atoms.carry import Curve
from loopelastica.atoms.fibre import fibre_nucleotide, in_line_frame
from loopelastica.atoms.measures import chi_torsion, torsion_deg
from loopelastica.molecule.nucleotides import RING
from loopelastica.molecule.strands import ideal_strand

OMEGA_STEPS: Final = 24
CHI_CHANGES_DEG: Final = (0.0, -30.0, 30.0)
SYN_CHI_DEG: Final = 60.0
CONTACTS: Final[dict[str, dict[str, tuple[tuple[str, str], ...]]]] = {
    # donor–acceptor pairs of a sheared G·A and of Watson–Crick and wobble pairs
    "sheared": {"GA": (("N2", "N7"), ("N3", "N6")), "AG": (("N7", "N2"), ("N6", "N3"))},
    "watson-crick": {
        "GC": (("N1", "N3"), ("O6", "N4"), ("N2", "O2")),
        "CG": (("N3", "N1"), ("N4", "O6"), ("O2", "N2")),
        "AU": (("N1", "N3"), ("N6", "O4")),
        "UA": (("N3", "N1"), ("O4", "N6")),
        "GU": (("N1", "O2"), ("O6", "N3")),
        "UG": (("O2", "N1"), ("N3", "O6")),
    },
}
_PHOSPHATE: Final = ("P", "OP1", "OP2")
_CLASH_A, _JUNCTION_A, _JUNCTION_FREE_A = 3.2, 2.5, 1.0
_STACK_A, _STACK = 3.4, 2.0
_HBOND_A, _CONTACT = 2.9, 4.0
_BEAM = 400


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings(Record):
    """What the loop must not run into, in the frame of the line's start.

    Attributes
    ----------
    atoms_A : (m, 3) array
        Heavy atoms near the strand, without those that the junctions bond.
    rings_A : (b, 6, 3) array
        Six-membered rings of the nucleotides before and after.
    o3_A, p_A : (3,) array
        O3' of the nucleotide before and P of the one after; NaN where they are not there.
    """

    atoms_A: Array
    rings_A: Array
    o3_A: Array
    p_A: Array


@dataclass(frozen=True, slots=True)
class Turns:
    """One combination: Ω (°) and change of χ (°) of each nucleotide, and its score."""

    omega_deg: tuple[float, ...]
    chi_change_deg: tuple[float, ...]
    score: float


def check_contact(contact: str | None) -> None:
    """Raise ValueError unless `contact` is None or one that can be sought."""
    if contact is not None and not (isinstance(contact, str) and contact in CONTACTS):
        raise ValueError(f"`contact` is {shown(contact)}; it must be one of {', '.join(CONTACTS)}")


def turned(
    letters: Sequence[str],
    is_dna: Sequence[bool],
    line: Curve,
    stem: Surroundings,
    *,
    contact: str | None = None,
    keep: int = 3,
) -> list[Turns]:
    """The best combinations of Ω and χ on a line, best first.

    Parameters
    ----------
    letters, is_dna : sequence
        Parent base and sugar of each loop nucleotide.
    line : Curve
        What they are turned about.
    stem : Surroundings
        What is in the way.
    contact : {"sheared", "watson-crick"}, optional
        Reward this contact between the first and the last nucleotide.
    keep : int
        Most combinations; they differ by at least 45° or by syn and anti somewhere.

    Returns
    -------
    list of Turns

    Raises
    ------
    ValueError
        If `contact` is unknown.
    """
    check_contact(contact)
    n = len(letters)
    states = [
        _states(letter, dna, line, k)
        for k, (letter, dna) in enumerate(zip(letters, is_dna, strict=True), start=1)
    ]
    unary = [_unary(state, letter, stem, k, n) for k, (state, letter) in
             enumerate(zip(states, letters, strict=True))]  # fmt: skip
    pairs = _pairs(states, letters, contact)
    beam = np.zeros((1, 0), dtype=np.int64)
    score = np.zeros(1)
    for k in range(n):
        grown = score[:, None] + unary[k][None, :]
        for j in range(k):
            if (j, k) in pairs:
                grown = grown + pairs[j, k][beam[:, j]]
        order = np.argsort(grown, axis=None, kind="stable")[:_BEAM]
        parent, state = np.unravel_index(order, grown.shape)
        score = grown[parent, state]
        beam = np.column_stack([beam[parent], state])
    changes = [_chi_changes(*own) for own in zip(letters, is_dna, strict=True)]
    return _distinct(beam, score, changes, keep)


def place(
    letter: str, is_dna: bool, line: Curve, k: int, omega: float, chi: float
) -> dict[str, Array]:
    """Atoms of one loop nucleotide without its phosphate.

    Parameters
    ----------
    letter, is_dna
        Parent base and sugar.
    line : Curve
        Where it lies.
    k : int
        Its number in the loop, from 1.
    omega, chi : float
        Ω and change of χ, degrees.

    Returns
    -------
    dict of str to (3,) array
        Å.
    """
    names, local = _local(letter, is_dna, np.array([chi]))
    point, frame = line.at([float(k)])
    at = _about_line(local[0][None], np.array([omega])) @ frame[0].T + point[0]
    return dict(zip(names, at[0], strict=True))


@dataclass(frozen=True, slots=True, eq=False)
class _State:
    names: tuple[str, ...]
    atoms: Array  # (s, a, 3)

    def atom(self, name: str) -> Array:
        return self.atoms[:, self.names.index(name)]

    @property
    def ring(self) -> tuple[Array, Array]:
        """Centres (s, 3) and normals (s, 3) of the six-membered ring."""
        return _plane(self.atoms[:, [self.names.index(name) for name in RING]])


@lru_cache
def _all_turns() -> tuple[Array, Array]:
    """Ω and χ class of each state: χ varies fastest."""
    omega = np.arange(OMEGA_STEPS) * (360.0 / OMEGA_STEPS)
    n_chi = len(CHI_CHANGES_DEG) + 1
    return np.repeat(omega, n_chi), np.tile(np.arange(n_chi), OMEGA_STEPS)


@lru_cache
def _chi_changes(letter: str, is_dna: bool) -> Array:
    atoms = fibre_nucleotide(letter, is_dna)
    fibre = torsion_deg(*(atoms[name] for name in chi_torsion(letter)))
    return np.array([*CHI_CHANGES_DEG, SYN_CHI_DEG - fibre])


def _states(letter: str, is_dna: bool, line: Curve, k: int) -> _State:
    omega, chi = _all_turns()
    names, local = _local(letter, is_dna, _chi_changes(letter, is_dna))
    point, frame = line.at([float(k)])
    return _State(names, _about_line(local[chi], omega) @ frame[0].T + point[0])


def _local(letter: str, is_dna: bool, chi_deg: Array) -> tuple[tuple[str, ...], Array]:
    """Names and places (c, a, 3) in the line's frame for each change of χ, phosphate left out."""
    atoms = {k: v for k, v in fibre_nucleotide(letter, is_dna).items() if k not in _PHOSPHATE}
    names = tuple(atoms)
    local = in_line_frame(ideal_strand(is_dna), np.array(list(atoms.values())))
    c1, n = names.index("C1'"), names.index(chi_torsion(letter)[2])
    base = [row for row, name in enumerate(names) if "'" not in name]
    axis = (local[n] - local[c1]) / np.linalg.norm(local[n] - local[c1])
    out = np.repeat(local[None], len(chi_deg), axis=0)
    for row, angle in enumerate(chi_deg):
        turn = Rotation.from_rotvec(np.deg2rad(angle) * axis)
        out[row, base] = turn.apply(local[base] - local[c1]) + local[c1]
    return names, out


def _about_line(local: Array, omega_deg: Array) -> Array:
    c, s = np.cos(np.deg2rad(omega_deg))[:, None], np.sin(np.deg2rad(omega_deg))[:, None]
    x, y, z = np.moveaxis(local, -1, 0)
    return np.stack([c * x - s * y, s * x + c * y, z], axis=-1)


def _plane(rings: Array) -> tuple[Array, Array]:
    centre = rings.mean(axis=-2)
    normal = np.cross(rings[..., 0, :] - rings[..., 2, :], rings[..., 1, :] - rings[..., 3, :])
    # a ring whose atoms are one point has no plane, and nothing stacks on it
    size = np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-12)
    return centre, normal / size


def _clash(a: Array, b: Array) -> Array:
    """Σ over atom pairs, (s, t), of (s, a, 3) and (t, b, 3)."""
    from loopelastica.atoms.kernels.clash import overlap_sums

    # copies: slices and read-only arrays would be other types to the kernel
    return np.asarray(overlap_sums(np.array(a, order="C"), np.array(b, order="C"), _CLASH_A))


def _stacking(a: tuple[Array, Array], b: tuple[Array, Array]) -> Array:
    """−2 where two planes lie upon each other, (s, t)."""
    between = b[0][None] - a[0][:, None]
    parallel = np.abs(a[1] @ b[1].T)
    normal = a[1][:, None] * np.sign(a[1] @ b[1].T)[..., None] + b[1][None]
    normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-9)
    rise = np.abs((between * normal).sum(axis=-1))
    slide = np.sqrt(np.maximum((between**2).sum(axis=-1) - rise**2, 0.0))
    shape = np.exp(-(((rise - _STACK_A) / 0.7) ** 2) - (slide / 3.0) ** 2)
    return np.asarray(-_STACK * parallel**4 * shape)


def _junction(distance: Array, ideal: float) -> Array:
    return 2.0 * np.maximum(np.abs(distance - ideal) - _JUNCTION_FREE_A, 0.0) ** 2


def _unary(state: _State, letter: str, stem: Surroundings, k: int, n: int) -> Array:
    _, chi = _all_turns()
    score = np.where(chi == len(CHI_CHANGES_DEG), 1.0 if letter in "AG" else 2.0, 0.0)
    score = score + _clash(state.atoms, stem.atoms_A[None])[:, 0]
    score = score + _stacking(state.ring, _plane(stem.rings_A)).sum(axis=1)
    if k == 0 and np.isfinite(stem.o3_A).all():
        distance = np.linalg.norm(state.atom("O5'") - stem.o3_A, axis=1)
        score = score + _junction(distance, _JUNCTION_A)
    if k == n - 1 and np.isfinite(stem.p_A).all():
        # here the phosphorus itself is known
        distance = np.linalg.norm(state.atom("O3'") - stem.p_A, axis=1)
        score = score + _junction(distance, 1.6)
    return np.asarray(score)


def _pairs(
    states: Sequence[_State], letters: Sequence[str], contact: str | None
) -> dict[tuple[int, int], Array]:
    table = {}
    reach = [np.abs(s.atoms - s.atoms.mean(axis=(0, 1))).max() * 2.0 for s in states]
    for k in range(len(states)):
        for j in range(k):
            a, b = states[j], states[k]
            apart = np.linalg.norm(a.atoms.mean(axis=(0, 1)) - b.atoms.mean(axis=(0, 1)))
            if apart > reach[j] + reach[k] + _CLASH_A:
                continue
            neighbours = k == j + 1
            # O3' and O5' of one phosphate are neighbours by nature
            left = [i for i, name in enumerate(a.names) if not (neighbours and name == "O3'")]
            right = [i for i, name in enumerate(b.names) if not (neighbours and name == "O5'")]
            score = _clash(a.atoms[:, left], b.atoms[:, right]) + _stacking(a.ring, b.ring)
            if neighbours:
                between = a.atom("O3'")[:, None] - b.atom("O5'")[None]
                score = score + _junction(np.linalg.norm(between, axis=-1), _JUNCTION_A)
            if contact and (j, k) == (0, len(states) - 1):
                score = score + _contact(a, b, CONTACTS[contact].get(letters[j] + letters[k], ()))
            table[j, k] = score
    return table


def _contact(a: _State, b: _State, bonds: Sequence[tuple[str, str]]) -> Array:
    reward = np.zeros((len(a.atoms), len(b.atoms)))
    for one, other in bonds:
        distance = np.linalg.norm(a.atom(one)[:, None] - b.atom(other)[None], axis=-1)
        reward -= _CONTACT / len(bonds) * np.exp(-(((distance - _HBOND_A) / 1.0) ** 2))
    return reward


def _distinct(
    beam: NDArray[np.int64], score: Array, changes: Sequence[Array], keep: int
) -> list[Turns]:
    omega, chi = _all_turns()
    chosen: list[NDArray[np.int64]] = []
    out = []
    for states, value in zip(beam, score, strict=True):
        if any(_alike(states, other) for other in chosen):
            continue
        chosen.append(states)
        change = [float(own[chi[s]]) for own, s in zip(changes, states, strict=True)]
        out.append(Turns(tuple(omega[states].tolist()), tuple(change), float(value)))
        if len(out) == keep:
            break
    return out


def _alike(a: NDArray[np.int64], b: NDArray[np.int64]) -> bool:
    omega, chi = _all_turns()
    apart = np.abs((omega[a] - omega[b] + 180.0) % 360.0 - 180.0)
    syn = len(CHI_CHANGES_DEG)
    return bool((apart < 45.0).all() and ((chi[a] == syn) == (chi[b] == syn)).all())
