"""Ways down: which equilibria a saddle of the energy separates.

From a saddle the discrete rod is displaced a little along each unstable mode, either way, and
follows the gradient flow of its energy with both ends clamped (``kernels.descent``) to where that
ends; multiple shooting refines what it comes to.
"""

import math
from typing import Any

import numpy as np

from loopelastica._arrays import Array
from loopelastica._checks import instance
from loopelastica.rod._discrete import discrete_copy, segments
from loopelastica.rod._starts import TOLERANCE, check_tolerance, problem_of
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.kernels.descent import (
    close,
    descend,
    displace,
    unstable_modes,
)
from loopelastica.rod.kernels.discrete_rod import DiscreteRod
from loopelastica.rod.kernels.records import (
    LAYERS,
    Method,
    Nodes,
    Problem,
    Solution,
    Status,
)
from loopelastica.rod.kernels.refinement import refine_discrete_rod
from loopelastica.rod.morse import homotopy_class
from loopelastica.rod.stability import morse_index

# first turn of the frames along a mode, and their largest turn in a step of the flow (radian)
_FIRST, _REACH = 0.05, 0.25
# most that a frame turns from one segment to the next
HINGE = 0.7
# what the energy of a discrete rod is off by: relative, and in K0/L
_MARGIN = 0.05


def ways_down(
    rod: Equilibrium, tolerance: float = TOLERANCE, *, reach: float = _REACH
) -> list[Equilibrium]:
    """The equilibria that a saddle's unstable directions lead to.

    The discrete rod follows the gradient flow of the elastic energy, a frame's turn weighed with
    the length that it turns, in steps of at most `reach`. Of a saddle of index 1 the two are those
    that it separates, but for the errors of the mesh and of the steps, which can matter where the
    flow passes near another saddle. Of a higher index each mode is tried by itself, which leads
    to some of what lies below, not to all. No energy on the way is above the saddle's.

    Parameters
    ----------
    rod : Equilibrium
        One that converged; its index is computed if it has none.
    tolerance : float
        Largest residual of what is found.
    reach : float
        Largest turn of a frame in a step of the flow, in radians; smaller steps follow it closer.

    Returns
    -------
    list of Equilibrium
        Two for each unstable direction, one for either way along it, the steepest direction first;
        none for a minimum. Mostly minima; a symmetric way down may end in a lower saddle. Where a
        way was lost an equilibrium that did not converge stands in its place. None has its index.

    Raises
    ------
    ValueError
        If `rod` has not converged, or for a `tolerance` as in :func:`solve`.

    Examples
    --------
    >>> import loopelastica as le
    >>> q = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
    >>> pass_between = next(rod for rod in le.equilibria(q) if abs(rod.energy - 40.211) < 0.01)
    >>> print(sorted(round(rod.energy, 3) for rod in ways_down(pass_between)))
    [19.146, 23.272]
    """
    rod, tolerance = instance("rod", rod, Equilibrium), check_tolerance(tolerance)
    if not rod.converged:
        raise ValueError("`rod` has not converged; only from an equilibrium are there ways down")
    index = morse_index(rod) if rod.index is None else rod.index
    if index == 0:
        return []
    problem = problem_of(rod.clamping, rod.torsion_ratio, tolerance)
    copy = discrete_copy(rod, segments(rod, HINGE))
    modes = np.empty((index, len(copy.frames) - (1 if problem.free_spin else 2), 3))
    shift = unstable_modes(problem, _ratio(problem), copy, rod.loads[:3].copy(), modes)
    found = []
    for mode in modes:
        for amount in (_FIRST, -_FIRST):
            start = DiscreteRod(copy.s, copy.frames.copy())
            displace(start, mode, amount)
            low = _descended(rod, problem, start, 2.0 * shift, reach)
            below = low.energy < rod.energy and homotopy_class(low) == homotopy_class(rod)
            found.append(low if below else _lost(rod))
    return found


def _descended(
    rod: Equilibrium, problem: Problem, start: DiscreteRod, shift: float, reach: float
) -> Equilibrium:
    """Where the gradient flow from a discrete rod ends; ``STALLED`` where the way was lost.

    The frames of ``start`` change. ``shift`` is one over the time of the first step.
    """
    force, moment = np.empty(3), np.empty(3)
    close(problem, _ratio(problem), start, force, reach)
    arrived, energy = descend(problem, _ratio(problem), start, force, moment, shift, reach)
    if arrived:
        found = refined(rod, problem, start, np.concatenate([force, moment]))
        if abs(found.energy - energy) < _MARGIN * (1.0 + energy):
            return found
    return _lost(rod)


def refined(rod: Equilibrium, problem: Problem, near: DiscreteRod, load: Array) -> Equilibrium:
    """The equilibrium of a discrete rod in balance with the loads (6,); ``STALLED`` if none."""
    n = len(near.s)
    nodes = Nodes(np.empty(n), np.empty((n, 7)))
    solution = Solution(np.zeros(6), nodes, np.zeros(1, LAYERS))
    outcome = refine_discrete_rod(problem, rod.torsion_ratio, True, near, load, solution)
    if outcome.method == Method.NONE:
        return _lost(rod)
    m, method = int(outcome.segments), Method(outcome.method)
    record: dict[str, Any] = {}
    if m:
        record = {"node_s": nodes.s[: m + 1].copy(), "node_pose": nodes.pose[: m + 1].copy()}
    elif method == Method.DISCRETE_ROD_LAYERS:
        record = {"layers": solution.layers}
    return Equilibrium(
        rod.clamping, rod.torsion_ratio, solution.loads, float(outcome.energy),
        float(outcome.residual), Status.CONVERGED, method, **record,
    )  # fmt: skip


def _ratio(problem: Problem) -> float:
    # a free spin leaves no twist, whatever it costs
    return 1.0 if problem.free_spin else problem.torsion_ratio


def _lost(rod: Equilibrium) -> Equilibrium:
    return Equilibrium(
        rod.clamping, rod.torsion_ratio, np.zeros(6), math.inf, math.inf, Status.STALLED,
        Method.NONE,
    )  # fmt: skip
