"""Mountain passes: from a path between two minima to a saddle on the boundary of their basins.

The basin of a minimum is what flows to it. A path from one minimum to another leaves the basin of
the first somewhere; bisection finds where, each point of the path being followed down to where its
flow ends (``descent``). From next to the boundary the flow first runs along it, to a saddle of
index 1, and goes slowest there; Newton's method does the rest. Where it does not, the two places
beside the saddle, one on either side, are the ends of the next path.

The path turns each frame straight to its place on the other side. Frames are followed along the
rod as quaternions of one sign, so that no frame goes around the other way than its neighbours.
"""

from collections.abc import Callable, Iterator

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod._discrete import discrete_copy, segments
from loopelastica.rod._starts import problem_of
from loopelastica.rod.descent import HINGE, Descent, descended, settled, soft_modes
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.kernels.descent import displace
from loopelastica.rod.kernels.discrete_rod import DiscreteRod
from loopelastica.rod.stability import assess

# bisections of a path, and paths
_BISECTIONS, _ROUNDS = 9, 4
# one over the time of the first step of a flow
_SHIFT = 100.0
# largest turn in a step: larger ones make a boundary where there is none
_REACH = 0.1
# the softest modes of a minimum, and how far it is moved along them (radian)
_MODES, _AMOUNTS = 2, (0.15, 0.4, 0.9)


def passes(
    start: Equilibrium,
    end: Equilibrium,
    inside: Callable[[Equilibrium], bool],
    tolerance: float,
) -> Iterator[Equilibrium]:
    """Saddles of index 1 next to the boundary of some basins, from a path that leaves them.

    Parameters
    ----------
    start, end : Equilibrium
        Minima of one clamping, in one component of the space of rods.
    inside : callable
        Whether an equilibrium is one of those whose basins count; `start` is, `end` is not.
    tolerance : float
        Largest residual of a saddle.

    Yields
    ------
    Equilibrium
        With its index. The first ones may be off the way; the caller sees what they separate.
    """
    problem = problem_of(start.clamping, start.torsion_ratio, tolerance)
    n = max(segments(start, HINGE), segments(end, HINGE))
    near, far = discrete_copy(start, n), discrete_copy(end, n)
    # both on the hinges of the one under more tension
    if np.linalg.norm(end.loads[:3]) > np.linalg.norm(start.loads[:3]):
        near = discrete_copy(start, n, far.s)
    else:
        far = discrete_copy(end, n, near.s)
    sides = [near.frames, far.frames]
    for _ in range(_ROUNDS):
        a, b = _followed(sides[0]), _followed(sides[1])
        low, high = 0.0, 1.0
        flows: list[Descent | None] = [None, None]
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            frames = _between(a, b, middle)
            flow = descended(start, problem, DiscreteRod(near.s, frames), _SHIFT, _REACH)
            if flow.end.converged and inside(flow.end):
                low, flows[0] = middle, flow
            else:
                high, flows[1] = middle, flow
        beside = [flow for flow in flows if flow is not None and np.isfinite(flow.slowest)]
        for flow in sorted(beside, key=lambda flow: flow.slowest):
            slow = DiscreteRod(near.s, flow.slow_frames)
            found = assess(settled(start, problem, slow, flow.slow_load))
            if found.index == 1:
                yield found
        if len(beside) < 2:
            return
        sides = [flow.slow_frames for flow in beside]


def climbs(rod: Equilibrium, tolerance: float) -> Iterator[Equilibrium]:
    """Saddles of index 1 that Newton's method finds from a minimum, moved along its softest modes.

    They are the ones that a path misses: so near the minimum that its basin ends at once.
    """
    problem = problem_of(rod.clamping, rod.torsion_ratio, tolerance)
    copy, force, modes, _ = soft_modes(rod, problem, _MODES + rod.family_dimension)
    load = np.concatenate([force, rod.loads[3:]])
    for mode in modes:
        for amount in (*_AMOUNTS, *(-a for a in _AMOUNTS)):
            moved = DiscreteRod(copy.s, copy.frames.copy())
            displace(moved, mode, amount)
            found = assess(settled(rod, problem, moved, load))
            if found.index == 1:
                yield found


def _followed(frames: Array) -> Array:
    """Quaternions (n, 4) with the signs that they have when followed from the first."""
    signs = np.sign(np.sum(frames[1:] * frames[:-1], axis=1))
    followed: Array = (
        frames * np.concatenate([[1.0], np.cumprod(signs)])[:, None] * np.sign(frames[0, 0])
    )
    return followed


def _between(a: Array, b: Array, t: float) -> Array:
    """Frames a fraction ``t`` of the way from ``a`` to ``b``, each turned about one axis."""
    cosine = np.clip(np.sum(a * b, axis=1), -1.0, 1.0)
    angle = np.arccos(cosine)
    sine = np.sin(angle)
    close = sine < 1e-6
    sine[close] = 1.0
    left = np.where(close, 1.0 - t, np.sin((1.0 - t) * angle) / sine)
    right = np.where(close, t, np.sin(t * angle) / sine)
    frames = left[:, None] * a + right[:, None] * b
    unit: Array = frames / np.linalg.norm(frames, axis=1, keepdims=True)
    return unit
