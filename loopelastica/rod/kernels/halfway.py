"""From a start half way, to an energy that is known to some hundredths, and the other half.

Half way are boundary layers, the linear theory of a nearly straight rod, or a discrete rod. Many
starts lead to few rods, and the energies say which of them are worth the rest of the way.
"""

import math
from typing import NamedTuple

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.kernels.boundary_layers import solve_layers
from loopelastica.rod.kernels.discrete_rod import DiscreteRod
from loopelastica.rod.kernels.discrete_starts import (
    bow,
    loads_as_it_stands,
    start_frames,
    wave,
)
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.layer_poses import layers_apart, layers_energy, layers_loads
from loopelastica.rod.kernels.minimization import minimize
from loopelastica.rod.kernels.nearly_straight import bend_energy
from loopelastica.rod.kernels.records import LAYERS, SEGMENTS, Outcome
from loopelastica.rod.kernels.refinement import (
    BOUNDARY_LAYERS,
    DISCRETE_ROD,
    NEARLY_STRAIGHT,
    NONE,
    REFINED_LAYERS,
    TENSE,
    refine_bend,
    refine_discrete_rod,
    settle_layers,
)
from loopelastica.rod.kernels.rotations import align, end_turn, tangent

# 1 − |r| below which useless starts are recognized beforehand; cosine of an end tangent that
# opposes the chord
STRAIGHTISH, _OPPOSED = 0.05, -0.8


class Halfway(NamedTuple):
    """Starts (n) gone half way: where each has come to."""

    kind: Array
    """(n,): NONE, BOUNDARY_LAYERS, NEARLY_STRAIGHT or DISCRETE_ROD."""
    energy: Array
    """(n,): off by about a hundredth; inf where there is nothing to go on from."""
    load: Array
    """(n, 6): F and M0."""
    layers: Array
    """(n,) of `LAYERS`."""
    s: Array
    """(n, segments + 1)."""
    frames: Array
    """(n, segments + 2, 4)."""


@kernel
def new_halfway(count, segments):
    """Room for ``count`` starts, with discrete rods of so many ``segments``."""
    energy = np.empty(count)
    for i in range(count):
        energy[i] = math.inf
    return Halfway(
        np.zeros(count, np.int64),
        energy,
        np.empty((count, 6)),
        np.zeros(count, LAYERS),
        np.empty((count, segments + 1)),
        np.empty((count, segments + 2, 4)),
    )


@kernel
def discrete_rod(problem, torsion_ratio, start, rod, load, ceiling):
    """The discrete rod of one start: its energy, or inf; ``load`` (6,) is F and M at s = 0.

    One of an energy above ``ceiling`` need not be found.
    """
    force, moment = np.empty(3), np.empty(3)
    start_frames(problem, start, rod, force)
    if not start.minimized:
        # multiple shooting then goes to a saddle as readily as to a minimum
        if start.half_waves > 0.0:
            wave(rod, problem.position, force, start.half_waves)
        loads_as_it_stands(rod, torsion_ratio, force, load)
        return 0.0
    if start.bow > 0.0:
        bow(rod, start.bow, 1)
    found, energy, _, _ = minimize(problem, torsion_ratio, rod, force, moment, ceiling)
    for c in range(3):
        load[c], load[3 + c] = force[c], moment[c]
    return energy if found else math.inf


@kernel
def worthwhile(problem, start):
    """Whether a start can lead to the lowest rod of a nearly straight clamping.

    There a bow is in vain, and the energy is that of the layers plus K30 (twist + 2πn)²/2, least
    for the twist within half a turn; a layer over the other side pays only where the tangent nearly
    opposes the chord.
    """
    if problem.shortening > STRAIGHTISH:
        return True
    if start.bow != 0.0 or not start.minimized:
        return False
    position, length = problem.position, 1.0 - problem.shortening
    ex, ey, ez = position[0] / length, position[1] / length, position[2] / length
    tx, ty, tz = tangent(problem.quaternion)
    if (start.over_0 and ez > _OPPOSED) or (
        start.over_1 and tx * ex + ty * ey + tz * ez > _OPPOSED
    ):
        return False
    if problem.free_spin or start.turns == 0.0:
        return True
    q = np.empty(4)
    align(ex, ey, ez, q)
    turn = end_turn(problem.quaternion, q) + 2.0 * math.pi * start.turns
    return abs(turn) < math.pi + 1.0


@kernel
def begin(problem, minimized_ratio, start, halfway, i, ceiling):
    """Half way from a start, into row ``i`` of ``halfway``; see `discrete_rod`."""
    layers, load = halfway.layers[i], halfway.load[i]
    plain = start.minimized and start.bow == 0.0
    layered = plain and solve_layers(problem, start, layers)
    if plain and not start.over_0 and not start.over_1 and not (layered and layers_apart(layers)):
        energy = bend_energy(problem, start.turns, load)
        if energy < math.inf:
            halfway.kind[i], halfway.energy[i] = NEARLY_STRAIGHT, energy
            return
    if layered and (layers_apart(layers) or math.cos(layers.beta) * layers.root > TENSE):
        layers_loads(layers, load)
        halfway.kind[i] = BOUNDARY_LAYERS
        halfway.energy[i] = layers_energy(layers, problem.torsion_ratio)
        return
    rod = DiscreteRod(halfway.s[i], halfway.frames[i])
    energy = discrete_rod(problem, minimized_ratio, start, rod, load, ceiling)
    halfway.kind[i] = DISCRETE_ROD if energy < math.inf else NONE
    halfway.energy[i] = energy


@kernel
def finish(problem, minimized_ratio, start, halfway, i, solution):
    """The other half from row ``i`` of ``halfway``, to an `Outcome`."""
    rod, load = DiscreteRod(halfway.s[i], halfway.frames[i]), halfway.load[i]
    if halfway.kind[i] == BOUNDARY_LAYERS:
        solution.layers[0] = halfway.layers[i]
        residual, energy, m = settle_layers(problem, solution)
        if residual < problem.tolerance:
            return Outcome(BOUNDARY_LAYERS if m == 0 else REFINED_LAYERS, residual, energy, m)
    elif halfway.kind[i] == NEARLY_STRAIGHT:
        residual, energy, m = refine_bend(problem, start.turns, solution)
        if residual < problem.tolerance:
            return Outcome(NEARLY_STRAIGHT, residual, energy, m)
        if problem.torsion_ratio > minimized_ratio:
            # what the discrete rod is minimized at is then far from what is sought
            return Outcome(NONE, math.inf, math.inf, 0)
    if halfway.kind[i] != DISCRETE_ROD and not (
        discrete_rod(problem, minimized_ratio, start, rod, load, math.inf) < math.inf
    ):
        return Outcome(NONE, math.inf, math.inf, 0)
    outcome = refine_discrete_rod(problem, minimized_ratio, start.minimized, rod, load, solution)
    if outcome.method == NONE and start.minimized and rod.s.shape[0] - 1 < SEGMENTS:
        rod = DiscreteRod(np.empty(SEGMENTS + 1), np.empty((SEGMENTS + 2, 4)))
        if discrete_rod(problem, minimized_ratio, start, rod, load, math.inf) < math.inf:
            outcome = refine_discrete_rod(problem, minimized_ratio, True, rod, load, solution)
    return outcome
