"""Nucleosides turned about the line (step iii): one angle Ω per nucleotide, and χ.

Every nucleotide has the same few states (:mod:`.states`): Ω, χ and pucker. The score of a
combination is a sum over nucleotides and pairs,

    clashes      Σ (3.2 Å − d)² over heavy atoms nearer than that, stem and loop, per Å²
    junctions    2 (|d − 2.5 Å| − 1 Å)² where O3' and the next O5' are further from the distance
                 they have round a phosphorus than the minimization mends with ease, per Å²
    stacking     −2 for two bases that lie flat upon each other 3.4 Å apart, falling off smoothly;
                 neighbours in the chain, the closing pair and bases across the loop alike
    habit        −ln of how often nature has such a nucleotide with this pucker and so syn or anti
                 (:mod:`.habits`)
    contact      −4 for a pair of the first and last loop nucleotide that is requested by name

in units of about kT. The weights are stated choices, not fits: they put chemistry (no clash, no
broken chain) before preference. Of the states of each nucleotide those are left that score best
alone; a beam over the chain keeps the best combinations. Ties and order are decided by the state's
number, so that the result is always the same.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record
from loopelastica._checks import shown
from loopelastica.atoms.carry import Curve
from loopelastica.atoms.habits import Habits, usual
from loopelastica.atoms.states import States, chi_changes, ring_plane, states_on

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
_CLASH_A, _JUNCTION_A, _JUNCTION_FREE_A = 3.2, 2.5, 1.0
_STACK_A, _STACK = 3.4, 2.0
_HBOND_A, _CONTACT = 2.9, 4.0
_BEAM, _STATES = 400, 96


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
    """One combination: Ω (°), change of χ (°) and pucker of each nucleotide, and its score.

    `c2_endo` is empty where nothing was chosen.
    """

    omega_deg: tuple[float, ...]
    chi_change_deg: tuple[float, ...]
    score: float
    c2_endo: tuple[bool, ...] = ()


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
    habits: Habits | None = None,
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
    habits : Habits, optional
        How often such nucleotides are C2'-endo and syn; default as :func:`.habits.usual`.
    contact : {"sheared", "watson-crick"}, optional
        Reward this contact between the first and the last nucleotide.
    keep : int
        Most combinations; they differ by at least 45°, by pucker or by syn and anti somewhere.

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
    habits = usual(letters, is_dna) if habits is None else habits
    states, unary = [], []
    for k, (letter, dna) in enumerate(zip(letters, is_dna, strict=True)):
        every = states_on(letter, dna, line, k + 1)
        alone = habits.costs(k, every) + _unary(every, stem, k, n)
        best = np.sort(np.argsort(alone, kind="stable")[:_STATES])
        states.append(every.take(best))
        unary.append(alone[best])
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
    changes = [{c2: chi_changes(letter, dna, c2) for c2 in (False, True)}
               for letter, dna in zip(letters, is_dna, strict=True)]  # fmt: skip
    return _distinct(beam, score, states, changes, keep)


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


def _unary(state: States, stem: Surroundings, k: int, n: int) -> Array:
    score = _clash(state.atoms, stem.atoms_A[None])[:, 0]
    score = score + _stacking(state.ring, ring_plane(stem.rings_A)).sum(axis=1)
    if k == 0 and np.isfinite(stem.o3_A).all():
        distance = np.linalg.norm(state.atom("O5'") - stem.o3_A, axis=1)
        score = score + _junction(distance, _JUNCTION_A)
    if k == n - 1 and np.isfinite(stem.p_A).all():
        # here the phosphorus itself is known
        distance = np.linalg.norm(state.atom("O3'") - stem.p_A, axis=1)
        score = score + _junction(distance, 1.6)
    return np.asarray(score)


def _pairs(
    states: Sequence[States], letters: Sequence[str], contact: str | None
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


def _contact(a: States, b: States, bonds: Sequence[tuple[str, str]]) -> Array:
    reward = np.zeros((len(a.atoms), len(b.atoms)))
    for one, other in bonds:
        distance = np.linalg.norm(a.atom(one)[:, None] - b.atom(other)[None], axis=-1)
        reward -= _CONTACT / len(bonds) * np.exp(-(((distance - _HBOND_A) / 1.0) ** 2))
    return reward


def _distinct(
    beam: NDArray[np.int64],
    score: Array,
    states: Sequence[States],
    changes: Sequence[Mapping[bool, Array]],
    keep: int,
) -> list[Turns]:
    chosen: list[NDArray[np.int64]] = []
    out = []
    for rows, value in zip(beam, score, strict=True):
        if any(_alike(rows, other, states) for other in chosen):
            continue
        chosen.append(rows)
        own = list(zip(states, rows.tolist(), strict=True))
        c2_endo = tuple(bool(s.c2_endo[row]) for s, row in own)
        change = [float(by[c2][s.chi_class[row]])
                  for by, c2, (s, row) in zip(changes, c2_endo, own, strict=True)]  # fmt: skip
        omega = tuple(float(s.omega_deg[row]) for s, row in own)
        out.append(Turns(omega, tuple(change), float(value), c2_endo))
        if len(out) == keep:
            break
    return out


def _alike(a: NDArray[np.int64], b: NDArray[np.int64], states: Sequence[States]) -> bool:
    for state, one, other in zip(states, a, b, strict=True):
        apart = abs((state.omega_deg[one] - state.omega_deg[other] + 180.0) % 360.0 - 180.0)
        same = state.syn[one] == state.syn[other] and state.c2_endo[one] == state.c2_endo[other]
        if apart >= 45.0 or not same:
            return False
    return True
