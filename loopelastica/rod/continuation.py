"""Paths: an equilibrium followed while its clamping moves.

The clamping moves with a parameter t, and the branch of equilibria through the given rod is
followed by pseudo-arclength (``_arclength``) in loads, node poses and t: it passes folds, where t
turns back. Someone who moves the ends by hand cannot follow there: at a fold, or wherever the rod
ceases to be a minimum of the energy, it snaps to another equilibrium. Each point of a path is an
equilibrium in its own right, confirmed on a mesh that the step did not use.

A step is taken again at a fraction of its length until it is accepted: few iterations, and a
tangent within 20° of the one before. Its length is measured in loads divided by max(20, |F|) and
2 √max(20, |F|), and in the turn (radian) and the shift of the clamp.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from loopelastica.rod._arclength import corrected_step, moving_clamp
from loopelastica.rod.clamping import Array, Clamping, read_only
from loopelastica.rod.equilibrium import MESSAGES, METHODS, Equilibrium, Status
from loopelastica.rod.solve import TOLERANCE, quaternion
from loopelastica.rod.stability import morse_index

# Newton steps of an accepted step; few enough, or too many, for a longer or shorter next one
_ITERATIONS, _FEW, _MANY = 8, 4, 6
_GROW, _SHRINK = 1.5, 0.4
_FIRST_STEP, _LEAST_STEP = 0.05, 1e-6
# tangents of two points that follow one another: within 20°, or a nearby branch may be taken
_AGREE = math.cos(math.pi / 9)
# a change of pose (L, radian) that one step of Newton's method is tried on
_SMALL = 0.2
# √F up to which 16, 32 and 64 segments serve; growth is exp(√F h) over a segment
_SEGMENTS = ((14.0, 16), (40.0, 32), (150.0, 64))
# √F below which tails hand over to nodes again
_SLACK = 100.0
_REFINEMENTS = 12


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """A branch of equilibria along a moving clamping.

    Attributes
    ----------
    parameter : (n,) ndarray
        Where along the motion each rod stands: t from 0 to 1, or turns of the end.
    rods : tuple of Equilibrium
        The equilibria, the given one first; with their Morse index if it was asked for.
    folds : (k,) ndarray
        Parameters at which the branch turns back, in the order they were met.
    stability_lost : (l,) ndarray
        Parameters at which the Morse index rises from 0; empty if it was not computed.
    status : Status
        0 if the goal was reached; ``message`` says in words why the path ends.
    message : str
    end : Equilibrium or None
        The equilibrium at the goal.
    """

    parameter: Array
    rods: tuple[Equilibrium, ...]
    folds: Array
    stability_lost: Array
    status: Status
    message: str
    end: Equilibrium | None = None

    def __post_init__(self) -> None:
        for name in ("parameter", "folds", "stability_lost"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @property
    def converged(self) -> bool:
        """Whether the goal was reached."""
        return self.status == Status.CONVERGED

    @property
    def snaps_at(self) -> float | None:
        """Parameter at which a rod moved by hand leaves the branch, or None.

        Where stability is lost first, or, if that was not computed, the first fold.
        """
        known = len(self.rods) > 0 and self.rods[-1].index is not None
        events = self.stability_lost if known else self.folds
        return float(events[0]) if len(events) else None


@dataclass(frozen=True, slots=True)
class _Road:
    """The moving clamp: p + t v, R exp(t [ω])."""

    start: Clamping
    shift: Array
    axis: Array
    torsion_ratio: float
    unit: float
    """Parameter shown to the user per t."""

    def clamping(self, t: float) -> Clamping:
        from loopelastica.rod._rotations import matrix_from_quaternion

        q, p = np.empty(4), np.empty(3)
        moving_clamp(
            self.start.position, quaternion(self.start), self.shift, self.axis, t, q, p
        )  # fmt: skip
        return Clamping(p, matrix_from_quaternion(q), self.start.free_spin)

    def scale(self, values: Array) -> Array:
        """Units of loads and t, (7,)."""
        force = max(20.0, float(np.linalg.norm(values[:3])))
        moment = 2.0 * math.sqrt(force)
        turn = 1.0 if self.start.free_spin else moment
        return np.array([force] * 3 + [moment] * 2 + [turn, self.reach])

    @property
    def in_line(self) -> bool:
        """Whether both ends lie on one line all the way, and the rod may turn about it."""
        across = max(np.abs(self.axis[:2]).max(), np.abs(self.shift[:2]).max())
        return self.start.on_one_line and bool(across < 1e-9)

    @property
    def reach(self) -> float:
        """The t in which the clamp turns by a radian or moves by a quarter of the rod's length."""
        return float(1.0 / (np.linalg.norm(self.axis) + 4.0 * np.linalg.norm(self.shift)))


@dataclass(frozen=True, slots=True)
class _Point:
    """A point of the branch: ``values`` (F, M0, t), nodes, and d(values)/d(length), (7,)."""

    values: Array
    node_s: Array
    node_pose: Array
    tangent: Array
    residual: float = math.inf
    iterations: int = 0

    @property
    def t(self) -> float:
        return float(self.values[6])


def continue_clamping(
    rod: Equilibrium,
    clamping: Clamping,
    *,
    natural: bool | None = None,
    steps: int = 1000,
    max_step: float = 0.5,
    stability: bool = True,
) -> Path:
    """Follow an equilibrium from its clamping to another.

    Parameters
    ----------
    rod : Equilibrium
        Where the path starts.
    clamping : Clamping
        Where it leads: the position moves on a straight line, the rotation on a geodesic, with t
        from 0 to 1.
    natural : bool, optional
        Try a single Newton step from 0 to 1 first, as for a gripper that moves little by little;
        by default where the ends move by less than 0.2 (L, radian).
    steps : int
        Steps allowed.
    max_step : float
        Longest step; see the module's head for its measure.
    stability : bool
        Compute the Morse index along the path.

    Returns
    -------
    Path
        Its ``end`` is the equilibrium at `clamping`. A goal that is not reached is a status.

    Raises
    ------
    ValueError
        If the free spin of `clamping` is not that of `rod`.

    Examples
    --------
    >>> import loopelastica as le
    >>> rod = le.solve(Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2]))
    >>> goal = Clamping.from_parameters([-0.3, 0.1, 0.6, 4.8, 1.4, 2.2])
    >>> path = continue_clamping(rod, goal)
    >>> print(path.converged, round(path.end.energy, 4), len(path.folds))
    True 7.6179 0
    """
    if clamping.free_spin != rod.clamping.free_spin:
        raise ValueError("`clamping` and `rod` must both leave the end's spin free, or neither")
    from scipy.spatial.transform import Rotation

    axis = Rotation.from_matrix(rod.clamping.rotation.T @ clamping.rotation).as_rotvec()
    shift = clamping.position - rod.clamping.position
    road = _Road(rod.clamping, shift, np.asarray(axis), rod.torsion_ratio, 1.0)
    refusal = _refused(rod, clamping)
    if refusal is not None:
        return refusal
    change = float(np.linalg.norm(shift) + np.linalg.norm(axis))
    if change < 1e-14:
        return _Walk(road, 1.0, stability).given(rod)
    walk = _Walk(road, 1.0, stability)
    if rod.clamping.on_one_line and not road.in_line and not len(rod.tail):
        rod = _turned_downhill(road, rod)
    if natural or (natural is None and change < _SMALL):
        path = walk.at_once(rod)
        if path is not None:
            return path
    return walk.follow(rod, steps, max_step)


def twist_end(
    rod: Equilibrium,
    turns: float,
    *,
    steps: int = 4000,
    max_step: float = 0.5,
    stability: bool = False,
) -> Path:
    """Turn the end of a rod about its own tangent d3.

    Parameters
    ----------
    rod : Equilibrium
        Where the path starts, with zero turns.
    turns : float
        How far to go, in turns about d3(L); of either sign.
    steps, max_step, stability
        As for :func:`continue_clamping`.

    Returns
    -------
    Path
        ``parameter`` and ``folds`` in turns. The first fold is where a rod turned by hand snaps
        at the latest (``snaps_at``); the branch goes on, and turns back. After a whole number of
        turns the clamping is again the first one, its equilibrium in general another.

    Raises
    ------
    ValueError
        If `turns` is not finite, or `rod` has a free end spin, which would undo any turn.

    Examples
    --------
    >>> import loopelastica as le
    >>> rod = le.solve(Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2]))
    >>> path = twist_end(rod, 1.0)
    >>> print(path.converged, round(path.end.energy, 4))
    True 19.1464
    """
    if not math.isfinite(turns):
        raise ValueError(f"`turns` is {turns}; it must be finite")
    if rod.clamping.free_spin:
        raise ValueError("`rod` leaves the spin of its end free; turning it changes nothing")
    sign = math.copysign(1.0, turns)
    axis = np.array([0.0, 0.0, sign * math.tau])
    road = _Road(rod.clamping, np.zeros(3), axis, rod.torsion_ratio, sign)
    refusal = _refused(rod, rod.clamping)
    if refusal is not None:
        return refusal
    walk = _Walk(road, abs(float(turns)), stability)
    return walk.given(rod) if turns == 0 else walk.follow(rod, steps, max_step)


def _refused(rod: Equilibrium, clamping: Clamping) -> Path | None:
    """A path of no points where there is nothing to start from or no goal to reach."""
    nothing = np.zeros(0)
    if not rod.converged:
        message = f"the rod to start from is no solution: {rod.message}"
        return Path(nothing, (), nothing, nothing, rod.status, message)
    status, message = Status.CONVERGED, ""
    if np.linalg.norm(clamping.position) >= 1.0:
        status, message = Status.UNREACHABLE, MESSAGES[Status.UNREACHABLE]
    elif rod.method == "straight":
        status = Status.STALLED
        message = "a rod stretched straight has no determined force to follow"
    if status == Status.CONVERGED:
        return None
    return Path(np.zeros(1), (rod,), nothing, nothing, status, message)


class _Walk:
    """A path in the making along ``road`` to t = ``goal``."""

    def __init__(self, road: _Road, goal: float, stability: bool) -> None:
        self.road, self.goal, self.stability = road, goal, stability
        self.t: list[float] = []
        self.rods: list[Equilibrium] = []
        self.folds: list[float] = []
        self.lost: list[float] = []

    def given(self, rod: Equilibrium) -> Path:
        """The goal is where the path starts."""
        self._keep(rod, 0.0)
        return self._path(Status.CONVERGED, "the goal is where the path starts")

    def at_once(self, rod: Equilibrium) -> Path | None:
        """One natural step to the goal, or None if it may have left the branch."""
        first = _first(self.road, rod)
        point = None if first is None else _at(self.road, first, self.goal)
        if first is None or point is None or point.tangent[6] < 0.0:
            return None
        if _agreement(self.road, first, point) < _AGREE:
            return None
        self._keep(rod, 0.0)
        self._keep(_equilibrium(self.road, point), point.t)
        if self.rods[0].index == 0 and self.rods[1].index not in (0, None):
            # lost somewhere on the way: let the steps find where
            self.t.clear()
            self.rods.clear()
            return None
        return self._path(Status.CONVERGED, "reached in one step")

    def follow(self, rod: Equilibrium, steps: int, max_step: float) -> Path:
        """Step by step."""
        self._keep(rod, 0.0)
        if _mesh(rod.loads) is None:
            return self._tense(steps, max_step)
        return self._slack(steps, max_step)

    def _slack(self, steps: int, max_step: float) -> Path:
        """By pseudo-arclength from the last rod, towards growing t at first."""
        point = _first(self.road, self.rods[-1], self.t[-1] * self.road.unit)
        if point is None:
            return self._path(Status.STALLED, "the start is not confirmed, or it is at a fold")
        first, ds = point, min(_FIRST_STEP, max_step)
        for step in range(steps):
            meshed = _remeshed(self.road, point)
            if meshed is None:
                if point.tangent[6] > 0.0:
                    return self._tense(steps - step, max_step)
                return self._path(Status.TOO_STIFF, MESSAGES[Status.TOO_STIFF])
            point = meshed
            following = _step(self.road, point, ds)
            if following is None:
                ds *= _SHRINK
                if ds < _LEAST_STEP:
                    return self._stuck()
                continue
            ending = self._arrival(first, point, following, ds)
            if ending is not None:
                self._pass(point, ending[0], ds)
                return self._path(*ending[1:])
            self._pass(point, following, ds)
            if following.iterations <= _FEW:
                ds = min(_GROW * ds, max_step)
            elif following.iterations >= _MANY:
                ds *= 0.6
            point = following
        return self._path(Status.TOO_MANY_ITERATIONS, "no steps left before the goal is reached")

    def _tense(self, steps: int, max_step: float) -> Path:
        """By natural steps of two tails, where the rod is too stiff for nodes."""
        t, longest = self.t[-1] * self.road.unit, 0.5 * self.road.reach
        dt = longest
        for step in range(steps):
            rod = _by_tails(self.road, self.rods[-1], min(t + dt, self.goal))
            if rod is None:
                dt *= 0.5
                if dt < _LEAST_STEP * longest:
                    return self._stuck()
                continue
            t, dt = min(t + dt, self.goal), min(2.0 * dt, longest)
            self._keep(rod, t)
            if t == self.goal:
                return self._path(Status.CONVERGED, "the goal is reached")
            if _root(rod.loads) < _SLACK:
                return self._slack(steps - step - 1, max_step)
        return self._path(Status.TOO_MANY_ITERATIONS, "no steps left before the goal is reached")

    def _stuck(self) -> Path:
        stiff = _root(self.rods[-1].loads) > 0.5 * _SEGMENTS[-1][0]
        reason = "; the rod is nearly straight there" if stiff else ""
        return self._path(
            Status.TOO_STIFF if stiff else Status.STALLED,
            f"no further step along the branch from {self.t[-1]:.6g}{reason}",
        )

    def _arrival(
        self, first: _Point, before: _Point, after: _Point, ds: float
    ) -> tuple[_Point, Status, str] | None:
        """Where the step meets the goal, or the start again; None if it goes on."""
        if (before.t - self.goal) * (after.t - self.goal) <= 0.0:
            point = _landed(self.road, before, after, ds, self.goal)
            if point is not None:
                return point, Status.CONVERGED, "the goal is reached"
        if first.t == 0.0 and len(self.t) > 3 and before.t * after.t <= 0.0:
            point = _landed(self.road, before, after, ds, 0.0)
            if point is not None and _apart(self.road, first, point) < 1e-6:
                return point, Status.STALLED, "the branch is closed: it returns to its start"
        return None

    def _pass(self, before: _Point, after: _Point, ds: float) -> None:
        """Keep the point ``after`` and what happens on the way to it."""
        if before.tangent[6] * after.tangent[6] < 0.0:
            fold = _where(self.road, before, after, ds, lambda p: float(p.tangent[6]))
            self.folds.append(self.road.unit * fold)
        was_stable = self.stability and self.rods[-1].index == 0
        self._keep(_equilibrium(self.road, after), after.t)
        if was_stable and self.rods[-1].index != 0:
            lost = self.road.unit * _where(self.road, before, after, ds, self._firmness)
            # most often at the fold, which is known better
            at_fold = [t for t in self.folds[-1:] if abs(t - lost) < 1e-4]
            self.lost.append(at_fold[0] if at_fold else lost)

    def _firmness(self, point: _Point) -> float:
        """A number that changes its sign where stability is lost."""
        return 1.0 if morse_index(_equilibrium(self.road, point)) == 0 else -1.0

    def _keep(self, rod: Equilibrium, t: float) -> None:
        from loopelastica.rod.stability import assess

        self.t.append(self.road.unit * t)
        self.rods.append(assess(rod) if self.stability else rod)

    def _path(self, status: Status, message: str) -> Path:
        reached = status == Status.CONVERGED
        if self.folds and not reached:
            message += f"; it first turned back at {self.folds[0]:.6g}"
        return Path(
            np.array(self.t), tuple(self.rods), np.array(self.folds), np.array(self.lost),
            status, message, self.rods[-1] if reached else None,
        )  # fmt: skip


def _first(road: _Road, rod: Equilibrium, t: float = 0.0) -> _Point | None:
    """The point of a rod, the tangent towards growing t."""
    values = np.append(rod.loads, t)
    if road.start.free_spin:
        from loopelastica.rod._rotations import rotation_vector

        end = rod.poses_without_spin(np.ones(1))[0, 3:]
        turn = rotation_vector(end, quaternion(rod.clamping))
        values[5] = float(np.dot(turn, rod.clamping.rotation[:, 2]))
    node_s = _mesh(values)
    if node_s is None:
        return None
    tangent = np.append(np.zeros(6), 1.0)
    point = _Point(values, node_s, rod.poses_without_spin(node_s), tangent)
    return _at(road, point, t)


def _turned_downhill(road: _Road, rod: Equilibrium) -> Equilibrium:
    """The rod turned about the line of its ends to where their motion costs least.

    Of the circle of rods only few follow when the ends leave the line: those for which
    dE/dt = F·v + M(L)·ω is stationary under the turn. The other is the maximum.
    """
    from loopelastica.rod._cascade import _turn_about_start

    force, moment = rod.loads[:3], rod.moment(2)[1]
    turning = rod.clamping.rotation @ road.axis
    cosine = force[:2] @ road.shift[:2] + moment[:2] @ turning[:2]
    sine = force[0] * road.shift[1] - force[1] * road.shift[0]
    sine += moment[0] * turning[1] - moment[1] * turning[0]
    if math.hypot(cosine, sine) < 1e-9:
        return rod
    node_s, loads = np.linspace(0.0, 1.0, 33), rod.loads.copy()
    node_pose = rod.poses_without_spin(node_s)
    _turn_about_start(node_pose, loads, math.atan2(-sine, -cosine))
    return replace(rod, loads=loads, node_s=node_s, node_pose=node_pose)


def _by_tails(road: _Road, rod: Equilibrium, t: float) -> Equilibrium | None:
    """The rod of two tails at ``t`` next to another rod; None if there is none."""
    from loopelastica.rod._cascade import _accept_tails, _tails_from_loads
    from loopelastica.rod._tails import SIZE

    clamping, ratio = road.clamping(t), road.torsion_ratio
    position, q, free = clamping.position, quaternion(clamping), clamping.free_spin
    squares = float(position @ position)
    if squares >= 1.0:
        return None
    gap = (1.0 - squares) / (1.0 + math.sqrt(squares))
    tail, loads = np.zeros(SIZE), rod.loads.copy()
    if not _tails_from_loads(loads, position, q, gap, ratio, free, tail):
        return None
    residual, energy = _accept_tails(tail, q, ratio, free, TOLERANCE, loads)
    near = abs(energy - rod.energy) < 0.5 * rod.energy + 5.0
    # another turn would change M3 by 2π K30
    if not (residual < TOLERANCE and near and abs(loads[5] - rod.loads[5]) < 3.0 * ratio):
        return None
    return Equilibrium(
        clamping, ratio, loads, float(energy), float(residual), Status.CONVERGED, METHODS[2],
        tail=tail,
    )  # fmt: skip


def _root(values: Array) -> float:
    return math.sqrt(float(np.linalg.norm(values[:3])))


def _mesh(values: Array) -> Array | None:
    """Arc lengths of as many nodes as the force needs; None if it is too stiff."""
    from loopelastica.rod._relaxation import graded_nodes

    root = _root(values)
    for most, segments in _SEGMENTS:
        if root < most:
            node_s = np.empty(segments + 1)
            graded_nodes(segments, most, node_s)
            return node_s
    return None


def _remeshed(road: _Road, point: _Point) -> _Point | None:
    """The point on as many nodes as its force needs; None if it is too stiff."""
    node_s = _mesh(point.values)
    if node_s is None or len(node_s) == len(point.node_s):
        return None if node_s is None else point
    from loopelastica.rod._shooting import sample

    loads = point.values[:6].copy()
    if road.start.free_spin:
        loads[5] = 0.0
    node_pose = sample(loads, 1.0, point.node_s, point.node_pose, node_s, 4.0)
    return replace(point, node_s=node_s, node_pose=node_pose)


def _corrected(road: _Road, point: _Point, row: Array, ds: float, phase: bool) -> _Point | None:
    scale = road.scale(point.values)
    values, node_pose, direction = point.values.copy(), point.node_pose.copy(), np.empty(7)
    residual, iterations = corrected_step(
        road.start.position, quaternion(road.start), road.shift, road.axis, road.torsion_ratio,
        road.start.free_spin, point.node_s, node_pose, values, scale, row, ds, _ITERATIONS,
        phase, direction,
    )  # fmt: skip
    if not residual < TOLERANCE:
        return None
    return _Point(values, point.node_s, node_pose, direction * scale, residual, iterations)


def _step(road: _Road, point: _Point, ds: float) -> _Point | None:
    """The next point at the distance ``ds`` along the tangent; None if it is not accepted."""
    row = point.tangent / road.scale(point.values)
    row /= np.linalg.norm(row)
    following = _corrected(road, point, row, ds, road.in_line)
    if following is None or _agreement(road, point, following) < _AGREE:
        return None
    return following


def _at(road: _Road, point: _Point, t: float) -> _Point | None:
    """The point at ``t``, by Newton's method from another one."""
    row = np.append(np.zeros(6), 1.0)
    ds = (t - point.t) / float(road.scale(point.values)[6])
    found = _corrected(road, point, row, ds, road.clamping(t).on_one_line)
    if found is None or point.residual == math.inf or _agreement(road, point, found) > 0.0:
        return found
    # the kernel orients the tangent by the row
    return replace(found, tangent=-found.tangent)


def _agreement(road: _Road, point: _Point, other: _Point) -> float:
    """Cosine between two tangents."""
    scale = road.scale(point.values)
    a, b = point.tangent / scale, other.tangent / scale
    return float(a @ b / (np.linalg.norm(a) * np.linalg.norm(b)))


def _apart(road: _Road, point: _Point, other: _Point) -> float:
    return float(np.linalg.norm((point.values - other.values) / road.scale(point.values)))


def _landed(road: _Road, before: _Point, after: _Point, ds: float, t: float) -> _Point | None:
    """The point at ``t`` within a step across it."""
    share = (t - before.t) / (after.t - before.t) if after.t != before.t else 1.0
    for start in (_step(road, before, share * ds), after, before):
        point = None if start is None else _at(road, start, t)
        if point is not None and _apart(road, before, point) < 1.5 * ds:
            return point
    return None


def _where(
    road: _Road, before: _Point, after: _Point, ds: float, measure: Callable[[_Point], float]
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
        point = _step(road, before, share * ds)
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


def _equilibrium(road: _Road, point: _Point) -> Equilibrium:
    """The rod of a point."""
    from loopelastica.rod._newton import elastic_energy

    clamping = road.clamping(point.t)
    loads = point.values[:6].copy()
    if road.start.free_spin:
        loads[5] = 0.0
    energy = float(elastic_energy(loads, clamping.position, road.torsion_ratio))
    return Equilibrium(
        clamping, road.torsion_ratio, loads, energy, point.residual, Status.CONVERGED,
        METHODS[3], point.node_s, point.node_pose,
    )  # fmt: skip
