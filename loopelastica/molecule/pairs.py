"""Canonical base pairs from three geometric tests, without hydrogens and without names.

A purine and a pyrimidine of matching letters pair when N1 and N3 are near, C1' and C1' as far apart
as in a double helix, and the bases parallel.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.errors import StructureError
from loopelastica.molecule.nucleotides import Nucleotides, atom_positions

# At these bounds the three tests agreed with two independent annotators on 124 of 125 pairs.
N1_N3_MAX_A: Final = 3.7
"""Longest purine N1 – pyrimidine N3 distance of a canonical pair."""
NORMALS_MAX_DEG: Final = 40.0
"""Largest angle between the planes of its two bases."""
C1_C1_MIN_A: Final = 9.4
C1_C1_MAX_A: Final = 11.6
"""Bounds of the C1'–C1' distance; they keep Hoogsteen and sugar-edge pairs out."""

# The last pair of a stem is often opened or buckled in an NMR model. What lies in place next to a
# sound pair counts up to these bounds (1NC0: 4.3 Å, 1JUR: 44°).
OPENED_N1_N3_MAX_A: Final = 4.5
BUCKLED_NORMALS_MAX_DEG: Final = 50.0

CROWDED: Final = 50
"""Most bases in reach of a base, on average: one in a helix, as many as models that are laid over
each other. Collapsed coordinates would fill the memory with pairs."""

CANONICAL: Final = frozenset({"AU", "AT", "GC", "GU", "GT"})
MIN_LOOP: Final = 3
"""Fewest nucleotides between the two of a pair that closes a loop."""

BRACKETS: Final = (
    ("(", ")"),
    ("[", "]"),
    ("{", "}"),
    ("<", ">"),
    ("A", "a"),
    ("B", "b"),
    ("C", "c"),
)


def canonical_pairs(nucleotides: Nucleotides, positions: Array) -> NDArray[np.int64]:
    """Watson–Crick and G·U wobble pairs by two distances and an angle.

    Parameters
    ----------
    nucleotides : Nucleotides
        Table of n nucleotides.
    positions : (n_atoms, 3) array
        All atoms of one model, Å.

    Returns
    -------
    (m, 2) array of int
        Rows i < j of paired nucleotides, sorted; each nucleotide at most once, the pair with the
        shortest N1–N3 first served. Opened pairs count next to sound ones only.

    Raises
    ------
    StructureError
        If so many bases lie in one place that this cannot be a structure.
    """
    i, j, distance, angle_deg = _candidates(nucleotides, positions)
    sound = (distance <= N1_N3_MAX_A) & (angle_deg <= NORMALS_MAX_DEG)
    # G and U also face each other in other ways than the wobble: no wide bounds for them.
    letters = nucleotides.letter
    wobble = np.isin(np.char.add(letters[i], letters[j]), ("GU", "UG", "GT", "TG"))
    partner: dict[int, int] = {}
    waiting = []
    for k in np.argsort(distance, kind="stable"):
        pair = int(i[k]), int(j[k])
        if not sound[k]:
            waiting += [] if wobble[k] else [pair]
        elif not partner.keys() & set(pair):
            partner |= {pair[0]: pair[1], pair[1]: pair[0]}
    for a, b in waiting:
        beside = partner.get(a - 1) == b + 1 or partner.get(a + 1) == b - 1
        # An opened pair must not shrink a triloop to nothing.
        if beside and b - a > MIN_LOOP and not partner.keys() & {a, b}:
            partner |= {a: b, b: a}
    pairs = sorted((a, b) for a, b in partner.items() if a < b)
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def _candidates(
    nucleotides: Nucleotides, positions: Array
) -> tuple[NDArray[np.int64], NDArray[np.int64], Array, Array]:
    """Rows i < j, N1–N3 distance (Å) and angle of the base planes (°) within the wide bounds."""
    from scipy.spatial import cKDTree

    names = ("N1", "N3", "C1'", "C2", "C4", "C6")
    n1, n3, c1, c2, c4, c6 = np.moveaxis(atom_positions(nucleotides, positions, names), 1, 0)
    known = np.isfinite(n1 + n3 + c1 + c2 + c4 + c6).all(axis=1)
    purines = np.flatnonzero(known & np.isin(nucleotides.letter, ("A", "G")))
    pyrimidines = np.flatnonzero(known & np.isin(nucleotides.letter, ("C", "U", "T")))
    tree, other = cKDTree(n1[purines]), cKDTree(n3[pyrimidines])
    crowded = tree.count_neighbors(other, OPENED_N1_N3_MAX_A)
    if crowded > CROWDED * len(nucleotides):
        raise StructureError(
            f"{crowded} pairs of bases are nearer than {OPENED_N1_N3_MAX_A} Å among"
            f" {len(nucleotides)} nucleotides; the coordinates have collapsed, or are those of many"
            " models without MODEL records"
        )
    near = tree.query_ball_tree(other, OPENED_N1_N3_MAX_A)
    r = np.repeat(purines, [len(found) for found in near])
    y = pyrimidines[np.array([k for found in near for k in found], dtype=np.int64)]

    distance = np.linalg.norm(n1[r] - n3[y], axis=1)
    across = np.linalg.norm(c1[r] - c1[y], axis=1)
    normal = np.cross(c4 - c2, c6 - c2)
    # A base whose atoms coincide has no plane; the tiny number only avoids a division by zero.
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    angle_deg = np.rad2deg(np.arccos(np.minimum(np.abs((normal[r] * normal[y]).sum(axis=1)), 1.0)))
    letters = np.char.add(nucleotides.letter[r], nucleotides.letter[y])
    good = np.isin(letters, list(CANONICAL)) & (angle_deg <= BUCKLED_NORMALS_MAX_DEG)
    good &= (across >= C1_C1_MIN_A) & (across <= C1_C1_MAX_A)
    first, last = np.minimum(r, y)[good], np.maximum(r, y)[good]
    return first, last, distance[good], angle_deg[good]


def dot_bracket(n: int, pairs: NDArray[np.int64]) -> str:
    """Secondary structure of n nucleotides as text; crossing pairs take other brackets.

    Parameters
    ----------
    n : int
        Nucleotides.
    pairs : (m, 2) array of int
        Rows i < j.

    Returns
    -------
    str

    Examples
    --------
    >>> dot_bracket(8, np.array([[0, 7], [1, 6], [3, 5]]))
    '((.(.)))'
    """
    text = ["."] * n
    # of each level the ends of the pairs that are open; without crossings the last ends first
    levels: list[list[int]] = [[] for _ in BRACKETS]
    for i, j in sorted(np.asarray(pairs).tolist()):
        for (opening, closing), ends in zip(BRACKETS, levels, strict=True):
            while ends and ends[-1] < i:
                ends.pop()
            if not ends or ends[-1] > j:
                ends.append(j)
                text[i], text[j] = opening, closing
                break
    return "".join(text)
