"""Paths: an equilibrium followed while its clamping moves.

The clamping moves with a parameter t, and the branch of equilibria through the given rod is
followed by pseudo-arclength (``_branch``) in loads, node poses and t: it passes folds, where t
turns back. Someone who moves the ends by hand cannot follow there: at a fold, or wherever the rod
ceases to be a minimum of the energy, it snaps to another equilibrium. Each point of a path is an
equilibrium in its own right, confirmed on a mesh that the step did not use.

A step is taken again at a fraction of its length until it is accepted: few iterations, and a
tangent within 20° of the one before. Its length is measured in loads divided by max(20, |F|) and
2 √max(20, |F|), and in the turn (radian) and the shift of the clamp.
"""

import math
from dataclasses import dataclass

import numpy as np

from loopelastica._arrays import Array, Record, read_only
from loopelastica._checks import finite, instance, optional, positive, whole
from loopelastica.rod._arguments import check_flag
from loopelastica.rod._branch import (
    AGREE,
    SEGMENTS,
    ClampPath,
    Point,
    agreement,
    by_layers,
    distance,
    equilibrium_of,
    first_point,
    mesh,
    parameter_where,
    point_at,
    point_within,
    remeshed,
    root_of_force,
    step_along,
    turned_downhill,
)
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibrium import MESSAGES, Equilibrium
from loopelastica.rod.kernels.records import Method, Status
from loopelastica.rod.stability import assess, morse_index

# Newton steps of an accepted step that make the next one longer or shorter
_FEW, _MANY = 4, 6
_GROW, _SHRINK = 1.5, 0.4
_FIRST_STEP, _LEAST_STEP = 0.05, 1e-6
# a change of pose (L, radian) that one step of Newton's method is tried on
_SMALL = 0.2
# √F below which boundary layers hand over to nodes again
_SLACK = 100.0


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Path(Record):
    """A branch of equilibria along a moving clamping.

    Attributes
    ----------
    parameter : (n,) ndarray
        Where along the motion each rod stands: t from 0 to 1, or turns of the end.
    rods : tuple of Equilibrium
        The equilibria, the given one first; with their Morse index if `stability` was on.
    folds : (k,) ndarray
        Parameters at which the branch turns back, in the order they were met.
    stability_lost : (l,) ndarray
        Parameters at which the Morse index rises from 0; empty if it was not computed.
    status : Status
        0 if the goal was reached.
    message : str
        The status in words.
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

    def __repr__(self) -> str:
        return f"<Path: {len(self.rods)} rods, {len(self.folds)} folds; {self.message}>"

    @property
    def converged(self) -> bool:
        """Whether the goal was reached."""
        return self.status == Status.CONVERGED

    @property
    def snaps_at(self) -> float | None:
        """Parameter at which a rod moved by hand leaves the branch, or None.

        Where stability is lost first, or, if that was not computed, the first fold.
        """
        judged = len(self.rods) > 0 and self.rods[-1].index is not None
        events = self.stability_lost if judged else self.folds
        return float(events[0]) if len(events) else None


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
    rod, clamping = instance("rod", rod, Equilibrium), instance("clamping", clamping, Clamping)
    steps, max_step = whole(0)("steps", steps), positive("max_step", max_step)
    natural = optional(check_flag)("natural", natural)
    stability = check_flag("stability", stability)
    if clamping.free_spin != rod.clamping.free_spin:
        raise ValueError("`clamping` and `rod` must both leave the end's spin free, or neither")
    refusal = _refused(rod, clamping)
    if refusal is not None:
        return refusal
    from scipy.spatial.transform import Rotation

    axis = Rotation.from_matrix(rod.clamping.rotation.T @ clamping.rotation).as_rotvec()
    shift = clamping.position - rod.clamping.position
    clamp_path = ClampPath(rod.clamping, shift, np.asarray(axis), rod.torsion_ratio, 1.0)
    change = float(np.linalg.norm(shift) + np.linalg.norm(axis))
    if change < 1e-14:
        return _Continuation(clamp_path, 1.0, stability).given(rod)
    following = _Continuation(clamp_path, 1.0, stability)
    if rod.clamping.on_one_line and not clamp_path.on_one_line and not len(rod.layers):
        rod = turned_downhill(clamp_path, rod)
    if natural or (natural is None and change < _SMALL):
        path = following.at_once(rod)
        if path is not None:
            return path
    return following.follow(rod, steps, max_step)


def twist_end(
    rod: Equilibrium,
    turns: float,
    *,
    steps: int = 4000,
    max_step: float = 0.5,
    stability: bool = True,
) -> Path:
    """Turn the end of a rod about its own tangent d3.

    Parameters
    ----------
    rod : Equilibrium
        Where the path starts, with zero turns.
    turns : float
        How far to go, in turns about d3(L); of either sign.
    steps : int
        Most steps.
    max_step : float
        As for :func:`continue_clamping`.
    stability : bool
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
    steps, max_step = whole(0)("steps", steps), positive("max_step", max_step)
    rod, turns = instance("rod", rod, Equilibrium), finite("turns", turns)
    stability = check_flag("stability", stability)
    if rod.clamping.free_spin:
        raise ValueError("`rod` leaves the spin of its end free; turning it changes nothing")
    sign = math.copysign(1.0, turns)
    axis = np.array([0.0, 0.0, sign * math.tau])
    clamp_path = ClampPath(rod.clamping, np.zeros(3), axis, rod.torsion_ratio, sign)
    refusal = _refused(rod, rod.clamping)
    if refusal is not None:
        return refusal
    following = _Continuation(clamp_path, abs(float(turns)), stability)
    return following.given(rod) if turns == 0 else following.follow(rod, steps, max_step)


def _refused(rod: Equilibrium, clamping: Clamping) -> Path | None:
    """A path of no points where there is nothing to start from or no goal to reach."""
    nothing = np.zeros(0)
    if not rod.converged:
        message = f"the rod to start from is no solution: {rod.message}"
        return Path(nothing, (), nothing, nothing, rod.status, message)
    status, message = Status.CONVERGED, ""
    if math.hypot(*clamping.position) >= 1.0:
        status, message = Status.UNREACHABLE, MESSAGES[Status.UNREACHABLE]
    elif rod.method == Method.STRAIGHT:
        status = Status.STALLED
        message = "a rod stretched straight has no determined force to follow"
    if status == Status.CONVERGED:
        return None
    return Path(np.zeros(1), (rod,), nothing, nothing, status, message)


class _Continuation:
    """A path in the making along ``clamp_path`` to t = ``goal``."""

    def __init__(self, clamp_path: ClampPath, goal: float, stability: bool) -> None:
        self.clamp_path, self.goal, self.stability = clamp_path, goal, stability
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
        first = first_point(self.clamp_path, rod)
        point = None if first is None else point_at(self.clamp_path, first, self.goal)
        if first is None or point is None or point.tangent[6] < 0.0:
            return None
        if agreement(self.clamp_path, first, point) < AGREE:
            return None
        self._keep(rod, 0.0)
        self._keep(equilibrium_of(self.clamp_path, point), point.t)
        if self.rods[0].index == 0 and self.rods[1].index not in (0, None):
            # lost somewhere on the way: let the steps find where
            self.t.clear()
            self.rods.clear()
            return None
        return self._path(Status.CONVERGED, "reached in one step")

    def follow(self, rod: Equilibrium, steps: int, max_step: float) -> Path:
        """Step by step."""
        self._keep(rod, 0.0)
        if mesh(rod.loads) is None:
            return self._tense(steps, max_step)
        return self._slack(steps, max_step)

    def _slack(self, steps: int, max_step: float) -> Path:
        """By pseudo-arclength from the last rod, towards growing t at first."""
        point = first_point(self.clamp_path, self.rods[-1], self.t[-1] * self.clamp_path.unit)
        if point is None:
            return self._path(Status.STALLED, "the start is not confirmed, or it is at a fold")
        first, ds = point, min(_FIRST_STEP, max_step)
        for step in range(steps):
            meshed = remeshed(self.clamp_path, point)
            if meshed is None:
                if point.tangent[6] > 0.0:
                    return self._tense(steps - step, max_step)
                return self._path(Status.TOO_STIFF, MESSAGES[Status.TOO_STIFF])
            point = meshed
            following = step_along(self.clamp_path, point, ds)
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
        """By natural steps of two boundary layers, where the rod is too stiff for nodes."""
        t, longest = self.t[-1] * self.clamp_path.unit, 0.5 * self.clamp_path.reach
        dt = longest
        for step in range(steps):
            rod = by_layers(self.clamp_path, self.rods[-1], min(t + dt, self.goal))
            if rod is None:
                dt *= 0.5
                if dt < _LEAST_STEP * longest:
                    return self._stuck()
                continue
            t, dt = min(t + dt, self.goal), min(2.0 * dt, longest)
            self._keep(rod, t)
            if t == self.goal:
                return self._path(Status.CONVERGED, "the goal is reached")
            if root_of_force(rod.loads) < _SLACK:
                return self._slack(steps - step - 1, max_step)
        return self._path(Status.TOO_MANY_ITERATIONS, "no steps left before the goal is reached")

    def _stuck(self) -> Path:
        stiff = root_of_force(self.rods[-1].loads) > 0.5 * SEGMENTS[-1][0]
        reason = "; the rod is nearly straight there" if stiff else ""
        return self._path(
            Status.TOO_STIFF if stiff else Status.STALLED,
            f"no further step along the branch from {self.t[-1]:.6g}{reason}",
        )

    def _arrival(
        self, first: Point, before: Point, after: Point, ds: float
    ) -> tuple[Point, Status, str] | None:
        """Where the step meets the goal, or the start again; None if it goes on."""
        if (before.t - self.goal) * (after.t - self.goal) <= 0.0:
            point = point_within(self.clamp_path, before, after, ds, self.goal)
            if point is not None:
                return point, Status.CONVERGED, "the goal is reached"
        if first.t == 0.0 and len(self.t) > 3 and before.t * after.t <= 0.0:
            point = point_within(self.clamp_path, before, after, ds, 0.0)
            if point is not None and distance(self.clamp_path, first, point) < 1e-6:
                return point, Status.STALLED, "the branch is closed: it returns to its start"
        return None

    def _pass(self, before: Point, after: Point, ds: float) -> None:
        """Keep the point ``after`` and what happens on the way to it."""
        if before.tangent[6] * after.tangent[6] < 0.0:
            fold = parameter_where(
                self.clamp_path, before, after, ds, lambda p: float(p.tangent[6])
            )
            self.folds.append(self.clamp_path.unit * fold)
        was_stable = self.stability and self.rods[-1].index == 0
        self._keep(equilibrium_of(self.clamp_path, after), after.t)
        if was_stable and self.rods[-1].index != 0:
            lost = self.clamp_path.unit * parameter_where(
                self.clamp_path, before, after, ds, self._firmness
            )
            # most often at the fold, which is located more closely
            at_fold = [t for t in self.folds[-1:] if abs(t - lost) < 1e-4]
            self.lost.append(at_fold[0] if at_fold else lost)

    def _firmness(self, point: Point) -> float:
        """A number that changes its sign where stability is lost."""
        return 1.0 if morse_index(equilibrium_of(self.clamp_path, point)) == 0 else -1.0

    def _keep(self, rod: Equilibrium, t: float) -> None:
        self.t.append(self.clamp_path.unit * t)
        self.rods.append(assess(rod) if self.stability else rod)

    def _path(self, status: Status, message: str) -> Path:
        reached = status == Status.CONVERGED
        if self.folds and not reached:
            message += f"; it first turned back at {self.folds[0]:.6g}"
        return Path(
            np.array(self.t), tuple(self.rods), np.array(self.folds), np.array(self.lost),
            status, message, self.rods[-1] if reached else None,
        )  # fmt: skip
