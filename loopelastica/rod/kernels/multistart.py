"""From starts to solutions: boundary layers, multiple shooting, the discrete rod.

A start is a number of whole turns added to the end-to-end twist and, for each end, the side that
its boundary layer takes (`records.START`). Cheap steps come first, and each result is judged by an
evaluation that the step did not use (``refinement``):

1. two boundary layers in closed form, where they do not reach each other;
2. else, at still high tension, their poses as nodes of multiple shooting;
3. where the rod is bent by little, the poses of the linear theory as nodes;
4. the discrete rod of least energy, which always has somewhere to go; under high tension its loads
   are turned into boundary layers, under little they are shot from the start, otherwise its hinges
   become nodes of multiple shooting.

Results are written into records of the caller (`records.Solution`).
"""

import math
from typing import Any, NamedTuple

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.kernels.boundary_layers import MAX_RATIO
from loopelastica.rod.kernels.discrete_rod import DiscreteRod
from loopelastica.rod.kernels.halfway import (
    STRAIGHTISH,
    begin,
    discrete_rod,
    finish,
    new_halfway,
    worthwhile,
)
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.linalg import copy, copy_rows
from loopelastica.rod.kernels.newton import CONVERGED, elastic_energy, newton, shot_error
from loopelastica.rod.kernels.records import (
    LAYERS,
    SEGMENTS,
    Method,
    Nodes,
    Outcome,
    Problem,
    Solution,
    Start,
    starts_array,
)
from loopelastica.rod.kernels.refinement import (
    DISCRETE_ROD_SHOOTING,
    NONE,
    refine_discrete_rod,
    relative_distance,
)

SHOOTING = int(Method.SHOOTING)

# 1 − |r| above which a quarter of the segments does to begin with, below it half; what hinge
# energies may be off by, and how far above the lowest of them a start is given up on its way
_SHORTENED, _MARGIN, _HOPELESS = 0.15, 0.02, 0.3

# what is tried where nothing else has led anywhere
RETRIES = starts_array(
    (
        Start(),
        Start(minimized=False),
        Start(bow=0.2),
        Start(1.0),
        Start(-1.0),
        Start(over_0=True),
        Start(over_1=True),
        Start(bow=0.5),
        Start(1.0, bow=0.4),
        Start(-1.0, bow=0.4),
        Start(2.0, bow=0.2),
        Start(-2.0, bow=0.2),
        Start(over_0=True, over_1=True, bow=0.1),
        Start(-1.0, over_0=True, bow=0.3),
        Start(1.0, over_0=True, bow=0.3),
        Start(bow=0.9),
    )
)


class Problems(NamedTuple):
    """Many clampings (n), as `records.Problem` for one."""

    positions: Array
    quaternions: Array
    torsion_ratio: float
    free_spin: bool
    tolerance: float


class Search(NamedTuple):
    """How clampings (n) are searched."""

    guesses: Array
    """(n, g, 6): loads to begin with."""
    known: Any
    """(n,): how many of them there are."""
    patience: int
    """Newton steps that a guess is given to come near."""
    starts: Any
    """(m,) of `records.START`."""
    retries: Any
    """Starts where nothing else has led anywhere."""
    lowest: bool
    """Whether the lowest solution is sought, or the first."""
    sparing: bool
    """Whether what can hardly lead to the lowest solution is left out."""
    keep_nodes: bool


class Rows(NamedTuple):
    """Room for the solutions of many clampings (n), as `records.Solution` for one."""

    loads: Array
    energy: Array
    residual: Array
    method: Array
    shot: Any
    """(n,): whether one shot from the loads ends at the clamping too."""
    segments: Array
    node_s: Array
    node_pose: Array
    layers: Array


def new_rows(n: int) -> Rows:
    """Room for ``n`` solutions: nothing found yet."""
    return Rows(
        np.zeros((n, 6)),
        np.full(n, np.inf),
        np.full(n, np.inf),
        np.zeros(n, np.int64),
        np.zeros(n, np.bool_),
        np.zeros(n, np.int64),
        np.empty((n, SEGMENTS + 1)),
        np.empty((n, SEGMENTS + 1, 7)),
        np.zeros(n, LAYERS),
    )


@kernel
def _minimized_ratio(torsion_ratio):
    """The torsion ratio at which discrete rods are minimized.

    A large ratio makes the energy a narrow valley; the rod depends on 1/K30 only, and multiple
    shooting goes the rest of the way.
    """
    return min(torsion_ratio, MAX_RATIO)


@kernel
def _run_starts(problem, search, solution):
    """Run a search's starts and keep the first or the lowest solution, as an `Outcome`.

    For the lowest, all starts go half way first and are finished in the order of their energies,
    down to where none of those left can be lower. The retries follow where nothing has led to a
    solution.
    """
    starts, retries, lowest = search.starts, search.retries, search.lowest
    n = SEGMENTS
    if search.sparing:
        n = SEGMENTS // 4 if problem.shortening > _SHORTENED else SEGMENTS // 2
    count = starts.shape[0]
    ratio = _minimized_ratio(problem.torsion_ratio)
    halfway, ended = new_halfway(count, n), np.zeros(count, np.bool_)
    energies = halfway.energy
    trial = _new_solution()
    best, ceiling = Outcome(NONE, math.inf, math.inf, 0), math.inf
    for i in range(count):
        if search.sparing and not worthwhile(problem, starts[i]):
            continue
        begin(problem, ratio, starts[i], halfway, i, ceiling)
        if lowest and search.sparing:
            ceiling = min(ceiling, energies[i] * (1.0 + _HOPELESS) + 1.0)
        if lowest or halfway.kind[i] == NONE:
            continue
        best = _keep(finish(problem, ratio, starts[i], halfway, i, trial), best, trial, solution)
        if best.method != NONE:
            return best
    while lowest:
        i = 0
        for j in range(1, count):
            if energies[j] < energies[i]:
                i = j
        # those of hinges are too low by some hundredths, hardly ever too high
        if not energies[i] < best.energy * (1.0 + _MARGIN) + _MARGIN:
            break
        energies[i] = math.inf
        if _seen(halfway.load, ended, i):
            continue
        ended[i] = True
        best = _keep(finish(problem, ratio, starts[i], halfway, i, trial), best, trial, solution)
    again = new_halfway(1, SEGMENTS)
    rod, load = DiscreteRod(again.s[0], again.frames[0]), again.load[0]
    for i in range(retries.shape[0]):
        if best.method != NONE:
            break
        # first the narrow valley itself, where the ratio is large
        for trial_ratio in (problem.torsion_ratio, ratio):
            if discrete_rod(problem, trial_ratio, retries[i], rod, load, math.inf) < math.inf:
                outcome = refine_discrete_rod(problem, trial_ratio, True, rod, load, trial)
                best = _keep(outcome, best, trial, solution)
            if best.method != NONE or problem.torsion_ratio == ratio:
                break
    return best


@kernel
def _new_solution():
    """Room for a solution of up to `SEGMENTS` segments."""
    nodes = Nodes(np.empty(SEGMENTS + 1), np.empty((SEGMENTS + 1, 7)))
    return Solution(np.zeros(6), nodes, np.zeros(1, LAYERS))


@kernel
def _keep(outcome, best, trial, solution):
    """The better of two outcomes; a new one's record is copied from the ``trial``."""
    if not outcome.energy < best.energy:
        return best
    m = outcome.segments
    copy(trial.loads, solution.loads)
    copy(trial.nodes.s[: m + 1], solution.nodes.s)
    copy_rows(trial.nodes.pose[: m + 1], solution.nodes.pose)
    solution.layers[0] = trial.layers[0]
    return outcome


@kernel
def _seen(load, ended, i):
    """Whether a start that has come to its end was at the same rod half way as start ``i``."""
    for j in range(load.shape[0]):
        if ended[j] and relative_distance(load[i], load[j]) < 1e-3:
            return True
    return False


@kernel
def shortening_of(position):
    """1 − |r|, to its last digits."""
    squares = position[0] ** 2 + position[1] ** 2 + position[2] ** 2
    return (1.0 - squares) / (1.0 + math.sqrt(squares))


@kernel
def run_batch(problems, search, rows):
    """Search each clamping: Newton's method from its guesses, then the starts.

    Results go into ``rows``. Where one shot from the loads ends at the clamping too, the nodes are
    not needed (unless they are to be kept), and the residual is that of the shot.
    """
    for i in range(problems.positions.shape[0]):
        position = problems.positions[i]
        problem = Problem(
            position,
            problems.quaternions[i],
            shortening_of(position),
            problems.torsion_ratio,
            problems.free_spin,
            problems.tolerance,
        )
        loads = rows.loads[i]
        known = search.known[i]
        if search.sparing and not problem.shortening > STRAIGHTISH:
            # no stored rod is that nearly straight
            known = 0
        for j in range(known):
            copy(search.guesses[i, j], loads)
            status, residual, _, end = newton(problem, loads, search.patience)
            if status == CONVERGED:
                rows.energy[i] = elastic_energy(loads, end, problem.torsion_ratio)
                rows.residual[i], rows.method[i], rows.shot[i] = residual, SHOOTING, True
                break
        if rows.method[i] != NONE:
            continue
        nodes = Nodes(rows.node_s[i], rows.node_pose[i])
        outcome = _run_starts(problem, search, Solution(loads, nodes, rows.layers[i : i + 1]))
        rows.method[i], rows.energy[i] = outcome.method, outcome.energy
        rows.residual[i], rows.segments[i] = outcome.residual, outcome.segments
        if outcome.method == DISCRETE_ROD_SHOOTING:
            rows.shot[i] = True
        elif outcome.method != NONE and not search.keep_nodes:
            residual = shot_error(problem, loads)
            if residual < problem.tolerance:
                rows.residual[i], rows.segments[i], rows.shot[i] = residual, 0, True
