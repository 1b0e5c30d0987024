"""Points of a branch of equilibria along a moving clamp, and the way from one to the next.

``continuation`` follows a branch with them; the compiled correction is in ``arclength``.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod._starts import TOLERANCE, problem_of, quaternion
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.kernels.arclength import Condition, Motion, corrected_step, moving_clamp
from loopelastica.rod.kernels.discrete_starts import graded_nodes
from loopelastica.rod.kernels.records import LAYERS, Method, Nodes, Status
from loopelastica.rod.kernels.refinement import (
    accept_layers,
    layers_from_loads,
    turn_about_start,
)
from loopelastica.rod.kernels.rotations import matrix_from_quaternion, rotation_vector
from loopelastica.rod.kernels.shooting import sample

# Newton steps of an accepted step
_ITERATIONS = 8
# tangents of two points that follow one another: within 20°, or a nearby branch may be taken
AGREE = math.cos(math.pi / 9)
# √F up to which 16, 32 and 64 segments serve; growth is exp(√F h) over a segment
SEGMENTS = ((14.0, 16), (40.0, 32), (150.0, 64))
_REFINEMENTS = 12


@dataclass(frozen=True, slots=True)
class ClampPath:
    """The moving clamp: p + t v, R exp(t [ω])."""

    start: Clamping
    shift: Array
    axis: Array
    torsion_ratio: float
    unit: float
    """Parameter shown to the user per t."""

    @property
    def motion(self) -> Motion:
        """The moving clamp in compiled code's terms."""
        start = self.start
        return Motion(
            start.position.copy(), quaternion(start), self.shift, self.axis,
            self.torsion_ratio, start.free_spin,
        )  # fmt: skip

    def clamping(self, t: float) -> Clamping:
        """The clamping at ``t``."""
        q, p = np.empty(4), np.empty(3)
        moving_clamp(self.motion, t, q, p)
        return Clamping(p, matrix_from_quaternion(q), self.start.free_spin)

    def scale(self, values: Array) -> Array:
        """Units of loads and t, (7,)."""
        force = max(20.0, float(np.linalg.norm(values[:3])))
        moment = 2.0 * math.sqrt(force)
        turn = 1.0 if self.start.free_spin else moment
        return np.array([force] * 3 + [moment] * 2 + [turn, self.reach])

    @property
    def on_one_line(self) -> bool:
        """Whether both ends lie on one line all the way, and the rod may turn about it."""
        across = max(np.abs(self.axis[:2]).max(), np.abs(self.shift[:2]).max())
        return self.start.on_one_line and bool(across < 1e-9)

    @property
    def reach(self) -> float:
        """The t in which the clamp turns by a radian or moves by a quarter of the rod's length."""
        return float(1.0 / (np.linalg.norm(self.axis) + 4.0 * np.linalg.norm(self.shift)))


@dataclass(frozen=True, slots=True)
class Point:
    """A point of the branch: ``values`` (F, M0, t), nodes, and d(values)/d(length), (7,)."""

    values: Array
    node_s: Array
    node_pose: Array
    tangent: Array
    residual: float = math.inf
    energy: float = math.inf
    iterations: int = 0

    @property
    def t(self) -> float:
        return float(self.values[6])


def first_point(path: ClampPath, rod: Equilibrium, t: float = 0.0) -> Point | None:
    """The point of a rod, the tangent towards growing t."""
    values = np.append(rod.loads, t)
    if path.start.free_spin:
        end = rod.poses_without_spin(np.ones(1))[0, 3:]
        turn = rotation_vector(end, quaternion(rod.clamping))
        values[5] = float(np.dot(turn, rod.clamping.rotation[:, 2]))
    node_s = mesh(values)
    if node_s is None:
        return None
    tangent = np.append(np.zeros(6), 1.0)
    point = Point(values, node_s, rod.poses_without_spin(node_s), tangent)
    return point_at(path, point, t)


def turned_downhill(path: ClampPath, rod: Equilibrium) -> Equilibrium:
    """The rod turned about the line of its ends to where their motion costs least.

    Of the circle of rods only few follow when the ends leave the line: those for which
    dE/dt = F·v + M(L)·ω is stationary under the turn. The other is the maximum.
    """
    force, moment = rod.loads[:3], rod.moment(2)[1]
    turning = rod.clamping.rotation @ path.axis
    cosine = force[:2] @ path.shift[:2] + moment[:2] @ turning[:2]
    sine = force[0] * path.shift[1] - force[1] * path.shift[0]
    sine += moment[0] * turning[1] - moment[1] * turning[0]
    if math.hypot(cosine, sine) < 1e-9:
        return rod
    node_s, loads = np.linspace(0.0, 1.0, 33), rod.loads.copy()
    node_pose = rod.poses_without_spin(node_s)
    turn_about_start(node_pose, loads, math.atan2(-sine, -cosine))
    return replace(rod, loads=loads, node_s=node_s, node_pose=node_pose)


def by_layers(path: ClampPath, rod: Equilibrium, t: float) -> Equilibrium | None:
    """The rod of two boundary layers at ``t`` next to another rod; None if there is none."""
    clamping, ratio = path.clamping(t), path.torsion_ratio
    if np.linalg.norm(clamping.position) >= 1.0:
        return None
    problem = problem_of(clamping, ratio)
    layers, loads = np.zeros(1, LAYERS), rod.loads.copy()
    if not layers_from_loads(problem, loads, layers[0]):
        return None
    residual, energy = accept_layers(problem, layers[0], loads)
    near = abs(energy - rod.energy) < 0.5 * rod.energy + 5.0
    # another turn would change M3 by 2π K30
    if not (residual < TOLERANCE and near and abs(loads[5] - rod.loads[5]) < 3.0 * ratio):
        return None
    return Equilibrium(
        clamping, ratio, loads, float(energy), float(residual), Status.CONVERGED,
        Method.CONTINUATION, layers=layers,
    )  # fmt: skip


def root_of_force(values: Array) -> float:
    """√F."""
    return math.sqrt(float(np.linalg.norm(values[:3])))


def mesh(values: Array) -> Array | None:
    """Arc lengths of as many nodes as the force needs; None if it is too stiff."""
    root = root_of_force(values)
    for most, segments in SEGMENTS:
        if root < most:
            node_s = np.empty(segments + 1)
            graded_nodes(most, node_s)
            return node_s
    return None


def remeshed(path: ClampPath, point: Point) -> Point | None:
    """The point on as many nodes as its force needs; None if it is too stiff."""
    node_s = mesh(point.values)
    if node_s is None or len(node_s) == len(point.node_s):
        return None if node_s is None else point
    loads = point.values[:6].copy()
    if path.start.free_spin:
        loads[5] = 0.0
    node_pose = sample(loads, 1.0, point.node_s, point.node_pose, node_s, 4.0)
    return replace(point, node_s=node_s, node_pose=node_pose)


def _corrected(
    path: ClampPath, point: Point, row: Array, ds: float, on_one_line: bool
) -> Point | None:
    scale = path.scale(point.values)
    values, node_pose, direction = point.values.copy(), point.node_pose.copy(), np.empty(7)
    residual, energy, iterations = corrected_step(
        path.motion, Nodes(point.node_s, node_pose), values,
        Condition(scale, row, float(ds), on_one_line), _ITERATIONS, direction,
    )  # fmt: skip
    if not residual < TOLERANCE:
        return None
    return Point(values, point.node_s, node_pose, direction * scale, residual, energy, iterations)


def step_along(path: ClampPath, point: Point, ds: float) -> Point | None:
    """The next point at the distance ``ds`` along the tangent; None if it is not accepted."""
    row = point.tangent / path.scale(point.values)
    row /= np.linalg.norm(row)
    following = _corrected(path, point, row, ds, path.on_one_line)
    if following is None or agreement(path, point, following) < AGREE:
        return None
    return following


def point_at(path: ClampPath, point: Point, t: float) -> Point | None:
    """The point at ``t``, by Newton's method from another one."""
    row = np.append(np.zeros(6), 1.0)
    ds = (t - point.t) / float(path.scale(point.values)[6])
    found = _corrected(path, point, row, ds, path.clamping(t).on_one_line)
    if found is None or point.residual == math.inf or agreement(path, point, found) > 0.0:
        return found
    # the kernel orients the tangent by the row
    return replace(found, tangent=-found.tangent)


def agreement(path: ClampPath, point: Point, other: Point) -> float:
    """Cosine between two tangents."""
    scale = path.scale(point.values)
    a, b = point.tangent / scale, other.tangent / scale
    return float(a @ b / (np.linalg.norm(a) * np.linalg.norm(b)))


def distance(path: ClampPath, point: Point, other: Point) -> float:
    """Distance of two points in units of the path's scale."""
    return float(np.linalg.norm((point.values - other.values) / path.scale(point.values)))


def point_within(path: ClampPath, before: Point, after: Point, ds: float, t: float) -> Point | None:
    """The point at ``t`` within a step across it."""
    share = (t - before.t) / (after.t - before.t) if after.t != before.t else 1.0
    for start in (step_along(path, before, share * ds), after, before):
        point = None if start is None else point_at(path, start, t)
        if point is not None and distance(path, before, point) < 1.5 * ds:
            return point
    return None


def parameter_where(
    path: ClampPath, before: Point, after: Point, ds: float, measure: Callable[[Point], float]
) -> float:
    """The t within a step at which ``measure`` changes its sign.

    By the Illinois method, or, where it only says yes (1) or no (−1), by bisection.
    """
    low, high, at_low, at_high = 0.0, 1.0, measure(before), measure(after)
    t = after.t
    if at_low * at_high >= 0.0:
        return t
    for _ in range(_REFINEMENTS):
        if at_low == -at_high:
            share = 0.5 * (low + high)
        else:
            share = (low * at_high - high * at_low) / (at_high - at_low)
        point = step_along(path, before, share * ds)
        if point is None:
            break
        t, value = point.t, measure(point)
        if abs(value) < 1e-9 or high - low < 1e-9:
            break
        if (value < 0.0) == (at_high < 0.0):
            high, at_high, at_low = share, value, at_low if value == -1.0 else 0.5 * at_low
        else:
            low, at_low, at_high = share, value, at_high if value == 1.0 else 0.5 * at_high
    return t


def equilibrium_of(path: ClampPath, point: Point) -> Equilibrium:
    """The equilibrium of a point."""
    clamping = path.clamping(point.t)
    loads = point.values[:6].copy()
    if path.start.free_spin:
        loads[5] = 0.0
    return Equilibrium(
        clamping, path.torsion_ratio, loads, point.energy, point.residual, Status.CONVERGED,
        Method.CONTINUATION, point.node_s, point.node_pose,
    )  # fmt: skip
