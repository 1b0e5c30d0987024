"""What topology demands of a list of equilibria: Morse's inequalities.

Equilibria are the critical points of the elastic energy on the space of rods between two clamps.
For |η| < 1 the frames of a rod between two fixed end frames are, up to deformation, a path in
SO(3): the space has the homology of the loops of SO(3), two components with one class in every
even degree each. With a free end spin it is that of the loops of the sphere of tangents, one
component with one class in every degree. Let b_k be these Betti numbers and m_k the number of
equilibria of index k. Then, M. Morse's inequalities,

    Σ_{i ≤ k} (−1)^(k−i) (m_i − b_i) ≥ 0     for every k,

in each component; so with fixed frames m₁ ≥ m₀ − 1 in either, m₁ ≥ m₀ − 2 in all, and with a free
spin m₁ ≥ m₀. A family of rods counts by its homology (R. Bott, Ann. Math. 60 (1954) 248): a circle
of index k once in k and once in k + 1, a torus once in k, twice in k + 1, once in k + 2.

A list ends at an energy, and what is missing may lie above it: a list that breaks an inequality is
either incomplete or cut off. Only that a component with rods has a minimum below them is certain.
None that keeps the inequalities is proven to be complete.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.rod._starts import quaternion
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.stability import morse_index

# frames per radian of the fastest turning, to follow a quaternion's sign
_PER_RADIAN = 2.0
# √F s at which a boundary layer is straight
_LAYER = 20.0


@dataclass(frozen=True, slots=True)
class MorseCount:
    """Equilibria by index, and Morse's inequalities for them.

    Attributes
    ----------
    by_index : tuple of int
        m₀, m₁, …, up to the largest index counted, and m₁ at least; families count by their
        homology.
    by_component : tuple of tuple of int
        The same for each component of the space of rods: two with fixed frames, one with a free
        end spin.
    expected : tuple of int
        The Betti numbers b₀, b₁, … of the whole space.
    excess : tuple of int
        Σ_{i ≤ k} (−1)^(k−i) (mᵢ − bᵢ) for each k.
    missing : tuple of int
        How many rods of index k (or k − 2, k − 4, …) the inequality of k asks for besides those
        counted, in all components.
    holds : tuple of bool or None
        For each k whether the inequality holds in every component. None where it is open: what is
        missing may lie above the bound. False where the list is certainly incomplete: it has rods
        of a component and no minimum.
    energy_max : float
        The bound below which equilibria were counted.
    """

    by_index: tuple[int, ...]
    by_component: tuple[tuple[int, ...], ...]
    expected: tuple[int, ...]
    excess: tuple[int, ...]
    missing: tuple[int, ...]
    holds: tuple[bool | None, ...]
    energy_max: float

    @property
    def text(self) -> str:
        """The result in a sentence or two."""
        counted = f"m = {', '.join(map(str, self.by_index))} up to the energy {self.energy_max:.4g}"
        faults = [_fault(k, n, self.holds[k]) for k, n in enumerate(self.missing) if n]
        if not faults:
            return f"{counted}: Morse's inequalities hold"
        kept = next(k for k, n in enumerate(self.missing) if n)
        if kept > 1:
            faults.insert(0, f"Morse's inequalities hold up to index {kept - 1}")
        return f"{counted}: {'; '.join(faults)}"

    def __str__(self) -> str:
        return self.text


def morse_count(rods: Iterable[Equilibrium], energy_max: float | None = None) -> MorseCount:
    """Count equilibria of one clamping by index and check Morse's inequalities.

    Parameters
    ----------
    rods : iterable of Equilibrium
        Different ones of one clamping and torsion ratio, as :func:`equilibria` lists them, each
        family once. Those that did not converge are left out; indices are computed where they are
        not known.
    energy_max : float, optional
        Count those with at most this energy. Default: the bound of the list, if it has one, else
        the largest energy.

    Returns
    -------
    MorseCount

    Raises
    ------
    ValueError
        If the rods have different clampings or torsion ratios, or there is none.

    Examples
    --------
    >>> import loopelastica as le
    >>> q = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
    >>> print(morse_count(le.equilibria(q), 35.0))
    m = 3, 1 up to the energy 35: Morse's inequalities hold
    """
    bound = getattr(rods, "energy_max", None) if energy_max is None else energy_max
    listed = [rod for rod in rods if rod.converged]
    if not listed:
        raise ValueError("`rods` has no equilibrium that converged")
    first = listed[0]
    if any(
        rod.clamping != first.clamping or rod.torsion_ratio != first.torsion_ratio for rod in listed
    ):
        raise ValueError("`rods` are of different clampings; count those of each by themselves")
    bound = max(rod.energy for rod in listed) if bound is None else float(bound)
    listed = [rod for rod in listed if rod.energy <= bound]
    free = first.clamping.free_spin
    homotopy = [homotopy_class(rod) for rod in listed]
    members = [
        [rod for rod, where in zip(listed, homotopy, strict=True) if where == c]
        for c in range(1 if free else 2)
    ]
    counts = [_by_index(rods) for rods in members]
    top = max(2, *(len(m) for m in counts))
    counts = [np.pad(m, (0, top - len(m))) for m in counts]
    degree = np.arange(top)
    betti = np.ones(top, int) if free else 1 - degree % 2
    excesses = np.array([_alternating(m - betti) for m in counts])
    missing = np.maximum(-excesses, 0).sum(axis=0)
    holds: list[bool | None] = [True if n == 0 else None for n in missing]
    if any(rods and m[0] == 0 for rods, m in zip(members, counts, strict=True)):
        holds[0] = False
    return MorseCount(
        _integers(np.sum(counts, axis=0)), tuple(_integers(m) for m in counts),
        _integers(betti * len(counts)), _integers(excesses.sum(axis=0)), _integers(missing),
        tuple(holds), bound,
    )  # fmt: skip


def _by_index(rods: list[Equilibrium]) -> NDArray[np.int64]:
    """m₀, m₁, … of rods; (1 + t)^d t^index for a family of d dimensions."""
    indices = [morse_index(rod) if rod.index is None else rod.index for rod in rods]
    counts = np.zeros(max(indices, default=-1) + 3, int)
    for rod, index in zip(rods, indices, strict=True):
        for more in range(rod.family_dimension + 1):
            counts[index + more] += math.comb(rod.family_dimension, more)
    return np.trim_zeros(counts, "b")


def _alternating(values: NDArray[np.int64]) -> NDArray[np.int64]:
    """Σ_{i ≤ k} (−1)^(k−i) values_i for each k."""
    signs = (-1) ** np.arange(len(values))
    sums: NDArray[np.int64] = np.cumsum(signs * values) * signs
    return sums


def _integers(values: NDArray[Any]) -> tuple[int, ...]:
    return tuple(int(value) for value in values)


def _fault(index: int, count: int, holds: bool | None) -> str:
    kind = "minimum" if index == 0 else f"saddle of index {index}"
    if count > 1:
        kind = "minima" if index == 0 else f"saddles of index {index}"
    number = {1: "one"}.get(count, str(count))
    verb = "is" if count == 1 else "are"
    if holds is False:
        return f"at least {number} {kind} {verb} missing below the bound"
    lies = "lies" if count == 1 else "lie"
    return f"at least {number} {kind} {verb} missing below the bound, or {lies} above it"


def homotopy_class(rod: Equilibrium) -> int:
    """In which of the two components of the space of rods between two frames a rod lies.

    Frames followed along the rod lift to unit quaternions, from 1 to one of the two ± q that are
    the end frame. No motion with both ends clamped takes a rod from one to the other: the end
    would have to be turned by a full turn. Two turns undo each other, so that there are no more.

    Parameters
    ----------
    rod : Equilibrium
        One that converged.

    Returns
    -------
    int
        0 or 1; which is which depends on the clamping, so that only rods of one clamping compare.
        With a free end spin there is one component, 0.
    """
    if rod.clamping.free_spin:
        return 0
    frames = rod.poses_without_spin(_followed(rod))[:, 3:]
    signs = np.sign(np.sum(frames[1:] * frames[:-1], axis=1))
    w, x, y, z = frames[-1] * np.prod(signs) * np.sign(frames[0, 0])
    # the spin of K30 ≠ 1, whole turns and all
    half = 0.5 * rod.loads[5] * (1.0 / rod.torsion_ratio - 1.0)
    c, s = math.cos(half), math.sin(half)
    lifted = np.array([w * c - z * s, x * c + y * s, y * c - x * s, z * c + w * s])
    return int(lifted @ quaternion(rod.clamping) < 0.0)


def _followed(rod: Equilibrium) -> Array:
    """Arc lengths close enough for a frame (as if K30 were 1) to be followed from one to the next.

    A rod in two boundary layers is straight between them, and only twisted there.
    """
    root = math.sqrt(float(np.linalg.norm(rod.loads[:3])))
    if not len(rod.layers) or root < 2.0 * _LAYER:
        fastest = float(np.linalg.norm(rod.moment(65), axis=1).max())
        return np.linspace(0.0, 1.0, 9 + int(_PER_RADIAN * fastest))
    twist, layer = abs(rod.loads[5]), _LAYER / root
    near = np.linspace(0.0, layer, 9 + int(_PER_RADIAN * layer * (2.0 * root + twist)))
    between = np.linspace(layer, 1.0 - layer, 9 + int(_PER_RADIAN * twist))
    return np.concatenate([near, between[1:-1], 1.0 - near[::-1]])
