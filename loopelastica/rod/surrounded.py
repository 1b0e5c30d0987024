"""A rod among obstacles: the shapes of least energy under a soft repulsion.

An ideal rod whose end may spin has no twist energy, so that a line describes it. Here it minimizes

    ½ ∫ κ² ds + ½ k ∫ Σ_points (c − d)²₊ ds + ½ k ρ ∬ (c − d)²₊ ds ds′

with K0 = 1, d the distance of a point from the line, c the cutoff, k the stiffness. The last term
is between parts of the rod that are more than 2 c apart along it, growing to its strength up to
4 c; ρ counts the rod as so many points per length. Without obstacles, and where the rod does not
come near itself, it is the ideal rod.

The line is made of circular arcs (:mod:`.kernels.arc_rod`): its error falls with the square of
their length, and where the rod is nearly stretched, arcs become shorter towards its ends. Each
guess leads to one minimum or none (:mod:`.kernels.arc_minimization`); each minimum is judged by
forces that are computed another way (:mod:`._arc_check`).
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from loopelastica._arrays import Array, Record, read_only
from loopelastica._checks import array, between, finite, optional, positive, shown, whole
from loopelastica.rod._arc_check import Repulsion, Verdict, judge, nearest_point
from loopelastica.rod._arc_line import ArcLine
from loopelastica.rod._arc_start import arc_nodes, bowed, grid_of, node_tangents
from loopelastica.rod._arguments import arc_lengths
from loopelastica.rod._starts import Deadline
from loopelastica.rod.clamping import nearest_rotation
from loopelastica.rod.curves import Span, check_points, check_span, standard_guesses
from loopelastica.rod.equilibrium import MESSAGES
from loopelastica.rod.kernels.arc_minimization import Room, minimize_arcs, new_rod, new_room
from loopelastica.rod.kernels.obstacles import Obstacles
from loopelastica.rod.kernels.records import Status

CUTOFF, STIFFNESS, SELF_REPULSION = 5.0, 0.05, 4.0
TOLERANCE = 1e-8

# 1 − |r| below which the rod is straight; tangents that then are along the chord
_STRAIGHT, _ALONG = 1e-9, 1e-6
# k c³ above which a search begins with softer obstacles, in K0/L and 1/L (a bent rod has energies
# of ten or so); how much harder they become each time; tolerance on the way
_SOFT, _HARDER, _ROUGH, _STAGES = 300.0, 30.0, 1e-4, 16
# bows of a guess from which nothing is found as it stands
_BOWS = (0.0, 0.4, -0.9)
# arcs that may be asked for
_MOST = 1000
# two minima nearer to each other than this at all nodes, in lengths, are one
_SAME = 1e-3
# parts of the rod nearer than this along it, in cutoffs, do not repel each other
_APART = 2.0


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class SurroundedRod(Record):
    """A rod of least energy among obstacles, or what became of the attempt to find one.

    Attributes
    ----------
    span : Span
        Its ends and its length, in the unit they were given in.
    start_frame : (3, 3) ndarray
        The frame of its start, columns d1 d2 d3; d3 is the tangent.
    node_s : (n + 1,) ndarray
        Where its arcs meet, in units of the length.
    node_tangent : (n + 1, 3) ndarray
        Unit tangents there.
    energy : float
        ½ ∫ κ² ds in K0/L, as that of an `Equilibrium`; inf if not converged.
    contact_energy, self_energy : float
        Of the repulsion by obstacles and by itself, in K0/L; inf if not converged.
    residual : float
        The larger of the end's error, in lengths, and the share of all forces along the rod that is
        not balanced, computed in another way than the solver's; inf if not converged.
    status : Status
        Why the solver stopped; 0 is success. ``message`` says it in words.
    stable : bool or None
        Whether it is a local minimum with both ends clamped; None if not converged.
    nearest : float or None
        Distance of the nearest obstacle from the line, in the unit of the span; None without any.
    nearest_obstacle : int or None
        Which one that is.
    guess : int
        Which guess led to it first.
    """

    span: Span
    start_frame: Array
    node_s: Array
    node_tangent: Array
    energy: float
    contact_energy: float
    self_energy: float
    residual: float
    status: Status
    stable: bool | None
    nearest: float | None
    nearest_obstacle: int | None
    guess: int

    def __post_init__(self) -> None:
        for name in ("start_frame", "node_s", "node_tangent"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        Record.__post_init__(self)

    def __repr__(self) -> str:
        if not self.converged:
            return f"<SurroundedRod: {self.message}>"
        near = "" if self.nearest is None else f", nearest obstacle at {self.nearest:.3g}"
        return (
            f"<SurroundedRod: energy {self.energy:.6g}, contact {self.contact_energy:.6g}"
            f"{near}, residual {self.residual:.1e}>"
        )

    @property
    def converged(self) -> bool:
        """Whether this is a solution."""
        return self.status == Status.CONVERGED

    @property
    def message(self) -> str:
        """The status in words."""
        if self.converged:
            return "converged; another way of computing the forces confirms it"
        return MESSAGES[self.status].replace("no start", "no guess")

    @property
    def total(self) -> float:
        """The energy that was minimized: of bending, contact and contact with itself, in K0/L."""
        return self.energy + self.contact_energy + self.self_energy

    @property
    def twist(self) -> float:
        """Turns of the frames about the tangent: none, since the end may spin."""
        return 0.0

    def centerline(self, n: int | ArrayLike) -> Array:
        """Points of the line in the start frame in units of the length, shape (n, 3).

        ``n`` is a number of points equally spaced in arc length, both ends included, or an array
        of arc lengths in [0, 1], in any order. ValueError if it is neither.
        """
        return np.asarray(self._line.places(arc_lengths(n)) @ self.start_frame)

    def frames(self, n: int | ArrayLike) -> Array:
        """Frames without twist in the start frame, shape (n, 3, 3), columns d1 d2 d3."""
        return np.asarray(self.start_frame.T @ self._line.frames(arc_lengths(n), self.start_frame))

    def curvature(self, n: int | ArrayLike) -> Array:
        """Curvature in units of one over the length, shape (n,), that of its arcs."""
        return self._line.curvatures(arc_lengths(n))

    def points(self, n: int | ArrayLike) -> Array:
        """Points of the line where the span is, in its unit, shape (n, 3)."""
        return self.span.start + self.span.length * self._line.places(arc_lengths(n))

    @property
    def _line(self) -> ArcLine:
        return ArcLine(self.node_s, self.node_tangent)


def surrounded_rods(
    start: ArrayLike,
    start_tangent: ArrayLike,
    end: ArrayLike,
    end_tangent: ArrayLike,
    length: float,
    obstacles: ArrayLike | None = None,
    *,
    guesses: Iterable[ArrayLike] | None = None,
    cutoff: float = CUTOFF,
    stiffness: float = STIFFNESS,
    self_repulsion: float = SELF_REPULSION,
    segments: int | None = None,
    start_frame: ArrayLike | None = None,
    tolerance: float = TOLERANCE,
    max_iterations: int = 300,
    time_limit_s: float | None = None,
) -> tuple[SurroundedRod, ...]:
    """Find the shapes of least energy of a clamped rod among obstacles that repel it.

    Lengths are in any one unit; the defaults are for ångströms. The bending rigidity is 1.

    Parameters
    ----------
    start, end : (3,) array_like
        Where the rod begins and ends.
    start_tangent, end_tangent : (3,) array_like
        Its directions there, of any length.
    length : float
        Of the rod.
    obstacles : (m, 3) array_like, optional
        Points that repel it.
    guesses : iterable of (k, 3) array_like, optional
        Points along curves to begin with, as `standard_guesses` makes them by default.
    cutoff : float
        Distance of the line below which a point repels it.
    stiffness : float
        k in ½ k (cutoff − distance)² per point and length of rod, in units of the bending rigidity
        over the fourth power of the length's unit.
    self_repulsion : float
        How many points the rod itself counts as per cutoff of its length, where parts of it meet
        that are more than two cutoffs apart along it; 0 for a rod that passes through itself.
    segments : int, optional
        Arcs that it is made of, 4 to 1000; a nearly stretched rod gets more near its ends. By
        default arcs of 0.28 cutoffs at most, 16 or more.
    start_frame : (3, 3) array_like, optional
        Columns d1 d2 d3, d3 along the start tangent: the frame in which `centerline` and `frames`
        are given. By default any.
    tolerance : float
        Largest residual of a solution, 1e-11 to 1e-3.
    max_iterations : int
        Newton steps from each guess.
    time_limit_s : float, optional
        Seconds after which no further guess is tried.

    Returns
    -------
    tuple of SurroundedRod
        Distinct minima by total energy, lowest first. If there is none, one that did not converge,
        whose status says why.

    Raises
    ------
    ValueError
        If no rod can have this span or another argument is out of range.

    Examples
    --------
    A hairpin over a wall: the rod goes round what stands in its way.

    >>> wall = [[5, y, z] for y in range(-2, 3) for z in range(3, 7)]
    >>> rods = surrounded_rods([0, 0, 0], [0, 0, 1], [10, 0, 0], [0, 0, -1], 24.0, wall)
    >>> free = surrounded_rods([0, 0, 0], [0, 0, 1], [10, 0, 0], [0, 0, -1], 24.0)
    >>> print(rods[0].converged, rods[0].nearest > 3, round(free[0].energy, 2))
    True True 6.91
    """
    span = check_span(start, start_tangent, end, end_tangent, length)
    points = _obstacles(obstacles)
    cutoff = positive("cutoff", cutoff) / span.length
    repulsion = Repulsion(
        (points - span.start) / span.length,
        cutoff,
        # in K0/L per L²; beyond the range of numbers it is infinite, and nothing converges
        _not_negative("stiffness", stiffness) * span.length * span.length * span.length**2,
        _not_negative("self_repulsion", self_repulsion) / cutoff,
        _APART * cutoff,
    )
    s = arc_nodes(span, optional(_segments)("segments", segments), cutoff)
    search = _Search(
        span,
        _start_frame(span.start_tangent, start_frame),
        s,
        new_room(s),
        grid_of(span.chord, repulsion),
        repulsion,
        between(1e-11, 1e-3)("tolerance", tolerance),
        whole(1)("max_iterations", max_iterations),
    )
    deadline = Deadline(time_limit_s)
    curves = standard_guesses(*span) if guesses is None else _guesses(guesses)
    if math.hypot(*span.chord) > 1.0 - _STRAIGHT:
        return (search.straight(),)
    found: list[tuple[float, Array, int, bool]] = []
    failure = Status.STALLED
    for index, curve in enumerate(curves):
        status, total, tangents, stable = search.minimize(curve)
        failure = max(failure, status)
        if status == Status.CONVERGED and all(
            np.abs(ArcLine(search.s, tangents - other).nodes()).max() > _SAME
            for _, other, _, _ in found
        ):
            found.append((total, tangents, index, stable))
        if deadline.passed:
            failure = Status.OUT_OF_TIME
            break
    rods = [search.rod(*one[1:]) for one in found]
    rods = sorted((rod for rod in rods if rod.converged), key=lambda rod: rod.total)
    if found and not rods:
        failure = Status.CHECK_FAILED
    return tuple(rods) or (search.failed(failure, curves[0]),)


class _Search(NamedTuple):
    """What all guesses share; lengths in units of the rod's but for the span."""

    span: Span
    frame: Array
    s: Array
    room: Room
    grid: Obstacles
    repulsion: Repulsion
    tolerance: float
    patience: int

    def minimize(self, curve: Array) -> tuple[Status, float, Array, bool]:
        """Status, energy, tangents and whether it is a minimum, from points along a curve."""
        guess = node_tangents(curve, self.s, self.span)
        rod, chord, stages = new_rod(self.s), self.span.chord, self._stages()
        for angle in _BOWS:
            rod.tangents[:] = bowed(guess, angle) if angle else guess
            for stiffness in stages:
                last = stiffness == stages[-1]
                grid = self.grid._replace(stiffness=stiffness)
                tolerance = 0.1 * self.tolerance if last else _ROUGH
                status, bending, contact, stable = minimize_arcs(
                    rod, self.room, chord, grid, tolerance, self.patience
                )
            if status == Status.CONVERGED:
                break
        return Status(status), bending + contact, rod.tangents, bool(stable)

    def _stages(self) -> list[float]:
        """Stiffnesses up to the given one: a hard wall is approached through softer ones."""
        stages: list[float] = []
        stiffness = _SOFT / self.repulsion.cutoff**3
        while stiffness < self.repulsion.stiffness and len(stages) < _STAGES:
            stages.append(stiffness)
            stiffness *= _HARDER
        return [*stages, self.repulsion.stiffness]

    def rod(self, tangents: Array, guess: int, stable: bool) -> SurroundedRod:
        """What the tangents amount to, with the status of a check."""
        line = ArcLine(self.s, tangents)
        verdict = judge(line, self.span.chord, self.repulsion)
        if not verdict.residual <= self.tolerance or not math.isfinite(sum(verdict)):
            nothing = Verdict(math.inf, math.inf, math.inf, math.inf)
            return self._record(tangents, nothing, Status.CHECK_FAILED, None, guess)
        return self._record(tangents, verdict, Status.CONVERGED, stable, guess)

    def straight(self) -> SurroundedRod:
        """The rod that is as long as its chord; ValueError if an end points elsewhere."""
        chord = self.span.chord / np.linalg.norm(self.span.chord)
        for name in ("start_tangent", "end_tangent"):
            if np.abs(getattr(self.span, name) - chord).max() > _ALONG:
                raise ValueError(
                    f"`{name}` is not along the line from start to end, whose distance is the whole"
                    " `length`; no rod fits"
                )
        tangents = np.tile(chord, (len(self.s), 1))
        verdict = judge(ArcLine(self.s, tangents), self.span.chord, self.repulsion)
        # it cannot give way: no force on it needs a balance
        return self._record(
            tangents, verdict._replace(residual=_STRAIGHT), Status.CONVERGED, True, 0
        )

    def failed(self, status: Status, curve: Array) -> SurroundedRod:
        """The record of a search that has found nothing; its line is the first guess."""
        nothing = Verdict(math.inf, math.inf, math.inf, math.inf)
        tangents = node_tangents(curve, self.s, self.span)
        return self._record(tangents, nothing, status, None, 0)

    def _record(
        self, tangents: Array, verdict: Verdict, status: Status, stable: bool | None, guess: int
    ) -> SurroundedRod:
        which, distance = None, None
        if len(self.repulsion.points):
            line = ArcLine(self.s, tangents)
            which, distance = nearest_point(line, self.repulsion.points)
            distance *= self.span.length
        return SurroundedRod(
            self.span,
            self.frame,
            self.s,
            tangents,
            *verdict,
            status,
            stable,
            distance,
            which,
            guess,
        )


def _obstacles(points: ArrayLike | None) -> Array:
    if points is None:
        return np.zeros((0, 3))
    found = array("obstacles", points)
    if found.size == 0:
        return np.zeros((0, 3))
    if found.ndim != 2 or found.shape[1] != 3 or not np.isfinite(found).all():
        raise ValueError("`obstacles` must be an array (m, 3) of finite numbers")
    return found


def _guesses(curves: Iterable[ArrayLike]) -> list[Array]:
    found = [check_points("guesses", points) for points in curves]
    if not found:
        raise ValueError("`guesses` is empty; a search begins with one at least")
    return found


def _not_negative(name: str, value: float) -> float:
    if finite(name, value) < 0.0:
        raise ValueError(f"`{name}` is {shown(value)}; it must not be negative")
    return float(value)


def _segments(name: str, value: int) -> int:
    number: int = whole(4)(name, value)
    if number > _MOST:
        raise ValueError(f"`{name}` is {shown(value)}; it must be at most {_MOST}")
    return number


def _start_frame(tangent: Array, frame: ArrayLike | None) -> Array:
    """The start frame, d3 exactly the tangent; any such frame for None."""
    if frame is None:
        d1 = np.cross(tangent, np.eye(3)[np.argmin(np.abs(tangent))])
    else:
        given = nearest_rotation(array("start_frame", frame), "start_frame")
        if np.abs(given[:, 2] - tangent).max() > _ALONG:
            raise ValueError("`start_frame` has a third column that is not `start_tangent`")
        d1 = given[:, 0] - (given[:, 0] @ tangent) * tangent
    d1 = d1 / np.linalg.norm(d1)
    return np.stack([d1, np.cross(tangent, d1), tangent], axis=1)
