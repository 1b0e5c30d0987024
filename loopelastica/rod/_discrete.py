"""The discrete rod with an equilibrium's frames: what `stability` and `descent` begin with."""

import functools
import math

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.kernels.discrete_rod import DiscreteRod
from loopelastica.rod.kernels.discrete_starts import graded_nodes
from loopelastica.rod.kernels.records import SEGMENTS
from loopelastica.rod.kernels.shooting import moment_bound

# most segments
_MOST = 1024


def segments(rod: Equilibrium, hinge: float) -> int:
    """How many segments a rod needs for no frame to turn by more than ``hinge`` to the next."""
    n = SEGMENTS
    while n < _MOST and turning(rod) > hinge * n:
        n *= 2
    return n


def turning(rod: Equilibrium) -> float:
    """A bound of the rate, in radians per length, at which the frames turn."""
    return max(float(moment_bound(rod.loads.copy())), abs(math.tau * rod.twist))


def discrete_copy(rod: Equilibrium, n: int, s: Array | None = None) -> DiscreteRod:
    """The frames of a rod in the middle of ``n`` segments that are short where it bends.

    Their ends ``s`` (n + 1,) are those of another copy if given.
    """
    if s is None:
        root = math.ceil(math.sqrt(float(np.linalg.norm(rod.loads[:3]))))
        s = _hinges(root, n)
    frames: Array = np.empty((n + 2, 4))
    frames[0] = (1.0, 0.0, 0.0, 0.0)
    frames[1:] = rod.poses(np.append(0.5 * (s[1:] + s[:-1]), 1.0))[:, 3:]
    return DiscreteRod(s, frames)


@functools.lru_cache(maxsize=256)
def _hinges(root: int, n: int) -> Array:
    s = np.empty(n + 1)
    graded_nodes(float(root), s)
    return s
