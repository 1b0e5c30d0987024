"""Mountain passes: from a path between two minima to a saddle on the boundary of their basins.

The basin of a minimum is what flows to it. A path from one minimum to another leaves the basin of
the first somewhere; bisection finds where, each point of the path being followed down to where its
flow ends (``descent``). From next to the boundary the flow first runs along it, to a saddle of
index 1, and goes slowest there; from that place Newton's method goes on to the saddle.

The path turns frames q_A(s) into q_B(s). Followed along the rod from the start frame as unit
quaternions, γ = q_A* q_B is a closed curve on the sphere S³ through 1, or one that ends at a spin.
Seen from a point P of the sphere that it stays away from, by stereographic projection, it shrinks
to 1 along straight lines; so neighbours never go around different ways. (Turned each about its own
axis they would, wherever q_B is a whole turn away from q_A, as between rods two turns apart.)
"""

import itertools
import math
from collections.abc import Callable, Iterator

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod._discrete import discrete_copy, segments
from loopelastica.rod._starts import problem_of
from loopelastica.rod.descent import HINGE, descended, settled, soft_modes
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.kernels.descent import displace
from loopelastica.rod.kernels.discrete_rod import DiscreteRod
from loopelastica.rod.stability import assess

# bisections of a path; a flow that goes slower by this has come nearer to a saddle
_BISECTIONS, _SLOWER = 26, 0.7
# cosine of the angle at which a curve on the sphere is too near to a point
_NEAR = 0.98
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
    for straight in (True, False):
        path = _Path(near.frames, far.frames, problem.free_spin, straight)
        low, high, slowest = 0.0, 1.0, math.inf
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            on_path = DiscreteRod(near.s, path.frames(middle))
            flow = descended(start, problem, on_path, _SHIFT, _REACH)
            if inside(flow.end):
                low = middle
            else:
                high = middle
            if flow.slowest < _SLOWER * slowest:
                slowest = flow.slowest
                slow = DiscreteRod(near.s, flow.slow_frames)
                found = assess(settled(start, problem, slow, flow.slow_load))
                if found.index == 1:
                    yield found


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


class _Path:
    """From frames (n, 4) to others with the same first frame."""

    def __init__(self, near: Array, far: Array, free_spin: bool, straight: bool) -> None:
        self.near, self.free_spin = _followed(near), free_spin
        curve = _product(self.near * _CONJUGATE, _followed(far))
        # −1 makes the shortest turns; where the curve comes near it, the point farthest from it
        nearest = [float((curve @ point).max()) for point in _POINTS]
        best = 0 if straight and nearest[0] < _NEAR else 1 + int(np.argmin(nearest[1:]))
        self.away = -_POINTS[best]
        seen = _product(self.away * _CONJUGATE, curve)
        self.seen = seen[:, 1:] / (1.0 + seen[:, :1])

    def frames(self, t: float) -> Array:
        """The frames a fraction ``t`` of the way."""
        x = (1.0 - t) * self.seen[:1] + t * self.seen
        square = np.sum(x * x, axis=1, keepdims=True)
        back = np.hstack([1.0 - square, 2.0 * x]) / (1.0 + square)
        frames = _product(self.near, _product(self.away, back))
        # the clamps are exact; a free end takes the spin that twists nothing
        frames[0] = self.near[0]
        end = self.near[-1]
        if self.free_spin:
            off = _product(frames[-2] * _CONJUGATE, end)
            half = -math.atan2(off[3], off[0])
            end = _product(end, np.array([math.cos(half), 0.0, 0.0, math.sin(half)]))
        frames[-1] = end
        return frames


_CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])
# −1, and points off the circle of spins in all directions
_POINTS = np.array(
    [(-1.0, 0.0, 0.0, 0.0)]
    + [(w, *v) for w in (-0.5, 0.0) for v in itertools.product((-0.6, 0.6), repeat=3)]
)
_POINTS /= np.linalg.norm(_POINTS, axis=1, keepdims=True)


def _product(p: Array, q: Array) -> Array:
    """Quaternion products, (…, 4)."""
    a, b, c, d = np.moveaxis(p, -1, 0)
    w, x, y, z = np.moveaxis(q, -1, 0)
    product: Array = np.stack(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ],
        axis=-1,
    )
    return product
