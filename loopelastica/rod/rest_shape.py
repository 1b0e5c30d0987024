"""The shape that an elastic chain remembers.

A chain has m rigid segments and m + 1 hinges between them and two clamps. At rest the segments are
parallel to the start frame and the hinges store nothing. The limit of many short segments is an
elastic rod with natural curvature and twist; straight at rest, it is the ideal rod.
Chains deformed from their rest shape are in :mod:`.deformed`.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from loopelastica._arrays import Array, Record, read_only
from loopelastica._checks import array, finite, shown, whole
from loopelastica.rod.clamping import Clamping, nearest_rotation

if TYPE_CHECKING:
    from loopelastica.rod.deformed import Chain

Rate = float | Callable[[float], float]

# segments and stiffness factors beyond these leave the range of floating point
_LEAST, _LARGEST = 1e-100, 1e100
_MOST_SEGMENTS = 100_000


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class RestShape(Record):
    """The shape of an elastic chain at rest.

    Parameters
    ----------
    steps : (m, 3) array_like
        Vectors of the segments in the start frame, in any unit of length.
    end_frame : (3, 3) array_like
        The end frame in the start frame; columns d1, d2, d3.
    stiffness : (m + 1,) array_like, optional
        Factors of the hinges' stiffness, the hinges at both clamps included; 1 is that of an ideal
        rod, K0 over half the length of either neighbouring segment.

    Raises
    ------
    ValueError
        If an array has a wrong shape or is not finite, a segment has no length, `end_frame` is no
        rotation, or `stiffness` is not positive.

    Examples
    --------
    A rod that is three quarters of a circle at rest, opened to a half.

    >>> shape = RestShape.from_rates(0, 1.5 * np.pi, 0)
    >>> half = RestShape.from_rates(0, np.pi, 0)
    >>> chain = shape.deform(half.clamping)
    >>> print(chain.converged, chain.stable, round(chain.energy, 4))
    True True 1.2337
    """

    steps: Array
    end_frame: Array
    stiffness: Array | None = None

    def __post_init__(self) -> None:
        steps = array("steps", self.steps)
        if steps.ndim != 2 or steps.shape[1:] != (3,) or not 2 <= len(steps) <= _MOST_SEGMENTS:
            raise ValueError(
                f"`steps` has shape {steps.shape}; it must be (m, 3), m from 2 to {_MOST_SEGMENTS}"
            )
        sizes = np.hypot(np.hypot(steps[:, 0], steps[:, 1]), steps[:, 2])
        if not np.isfinite(steps).all():
            raise ValueError("`steps` has an entry that is not finite")
        if not ((sizes > _LEAST) & (sizes < _LARGEST)).all():
            k = int(np.argmin((sizes > _LEAST) & (sizes < _LARGEST)))
            raise ValueError(
                f"`steps` has a segment of length {sizes[k]:g}, number {k}; each must have a length"
            )
        ones = np.ones(len(steps) + 1)
        stiffness = ones if self.stiffness is None else array("stiffness", self.stiffness)
        if stiffness.shape != ones.shape:
            raise ValueError(
                f"`stiffness` has shape {stiffness.shape}; it must be {ones.shape}, one more than"
                " segments"
            )
        if not ((stiffness > _LEAST) & (stiffness < _LARGEST)).all():
            raise ValueError("`stiffness` has an entry that is not a positive, finite number")
        frame = nearest_rotation(array("end_frame", self.end_frame), "end_frame")
        object.__setattr__(self, "steps", read_only(steps))
        object.__setattr__(self, "end_frame", read_only(frame))
        object.__setattr__(self, "stiffness", read_only(stiffness))

    def __repr__(self) -> str:
        return f"<RestShape: {len(self.steps)} segments, length {self.length:.6g}>"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, RestShape):
            return NotImplemented
        names = ("steps", "end_frame", "stiffness")
        return all(np.array_equal(getattr(self, name), getattr(other, name)) for name in names)

    __hash__ = None  # type: ignore[assignment]

    @classmethod
    def from_rates(
        cls, curvature_1: Rate, curvature_2: Rate, twist: Rate, segments: int = 100
    ) -> "RestShape":
        """From natural curvature and twist, of a rod of length 1.

        Parameters
        ----------
        curvature_1, curvature_2, twist : float or callable
            Rates at which the frame turns about d1, d2 and d3, in 1/L; a number, or a function of
            the arc length s in [0, 1]. They count where each segment has its middle.
        segments : int
            How many segments of equal length there are; the error falls with its square.

        Returns
        -------
        RestShape
            Of length 1.

        Raises
        ------
        ValueError
            If a rate is not finite, or turns a segment by more than half a turn.
        """
        m = whole(2)("segments", segments)
        if m > _MOST_SEGMENTS:
            raise ValueError(f"`segments` is {m}; it must be at most {_MOST_SEGMENTS}")
        given = {"curvature_1": curvature_1, "curvature_2": curvature_2, "twist": twist}
        middles = (np.arange(m) + 0.5) / m
        rates = np.stack([_rates(name, rate, middles) for name, rate in given.items()], axis=1)
        half = math.pi * m
        # large ones by their largest entry: squares overflow
        if np.abs(rates).max() > half or np.linalg.norm(rates, axis=1).max() > half:
            raise ValueError(
                f"`segments` is {m}; with these rates a segment turns by more than half a turn"
            )
        from scipy.spatial.transform import Rotation

        halves = Rotation.from_rotvec(rates / (2 * m)).as_matrix()
        frame, steps = np.eye(3), np.empty((m, 3))
        for k in range(m):
            frame = frame @ halves[k]
            steps[k] = frame[:, 2] / m
            frame = frame @ halves[k]
        return cls(steps, Rotation.from_matrix(frame).as_matrix())

    @classmethod
    def from_poses(
        cls, points: ArrayLike, start_frame: ArrayLike, end_frame: ArrayLike
    ) -> "RestShape":
        """From points along the shape and the frames at both its ends.

        Parameters
        ----------
        points : (m + 1, 3) array_like
            Where the hinges are, in any coordinates and any unit.
        start_frame, end_frame : (3, 3) array_like
            Frames of the ends in the same coordinates; columns d1, d2, d3.

        Returns
        -------
        RestShape
            In the unit of the points.

        Raises
        ------
        ValueError
            If there are fewer than three points, two neighbours are one, or a frame is no rotation.
        """
        places = array("points", points)
        if places.ndim != 2 or places.shape[1:] != (3,) or len(places) < 3:
            raise ValueError(
                f"`points` has shape {places.shape}; it must be (m + 1, 3), three points or more"
            )
        if not np.isfinite(places).all():
            raise ValueError("`points` has an entry that is not finite")
        with np.errstate(over="ignore"):
            steps = np.diff(places, axis=0)
        if not steps.any(axis=1).all():
            k = int(np.argmin(steps.any(axis=1)))
            raise ValueError(f"`points` has the same point twice, numbers {k} and {k + 1}")
        start = nearest_rotation(array("start_frame", start_frame), "start_frame")
        end = nearest_rotation(array("end_frame", end_frame), "end_frame")
        return cls(steps @ start, start.T @ end)

    @property
    def length(self) -> float:
        """Sum of the segments' lengths, in the unit of the steps."""
        return float(np.linalg.norm(self.steps, axis=1).sum())

    @property
    def points(self) -> Array:
        """Where the hinges are at rest, (m + 1, 3), in the start frame and the unit of steps."""
        return np.concatenate([np.zeros((1, 3)), np.cumsum(self.steps, axis=0)])

    @property
    def clamping(self) -> Clamping:
        """The pose of the end at rest, lengths in units of the shape's."""
        return Clamping(self.points[-1] / self.length, self.end_frame)

    def deform(
        self, clamping: Clamping, torsion_ratio: float = 1.0, guess: "Chain | None" = None
    ) -> "Chain":
        """Deform the chain to a clamped end, to a minimum of its energy.

        The chain is moved downhill from the rest shape with the end's turn spread evenly; which
        minimum it comes to, where there are several, is not promised to be the lowest.

        Parameters
        ----------
        clamping : Clamping
            The end's pose in the start frame, lengths in units of the shape's. With a free spin
            the end may turn about its d3.
        torsion_ratio : float
            Stiffness of the hinges against torsion over that against bending.
        guess : Chain, optional
            A chain of as many segments, from whose turns to begin.

        Returns
        -------
        Chain
            Its status says whether it is a solution.

        Raises
        ------
        ValueError
            If the ends are further apart than the chain is long, or nearer than its longest
            segment lets them come; or another argument is wrong.
        """
        from loopelastica.rod.deformed import deform

        return deform(self, clamping, torsion_ratio, guess)

    def equilibria(
        self, clamping: Clamping, torsion_ratio: float = 1.0, energy_max: float | None = None
    ) -> "list[Chain]":
        """Find the equilibria of the chain near its rest shape.

        Searches begin from the rest shape with the end's turn spread evenly, taken the long way
        round, with a whole turn more and less, each bowed to several sides; with 16 segments or
        more from the equilibria of the ideal rod too. Each goes downhill to a minimum, and by
        Newton's method to whatever equilibrium is near. So the minima that a gentle deformation
        leads to are found, and some saddles between them; that none is missed is not promised.

        Parameters
        ----------
        clamping : Clamping
            As for :meth:`deform`.
        torsion_ratio : float
            As for :meth:`deform`.
        energy_max : float, optional
            List equilibria up to this energy, in K0/L; by default all.

        Returns
        -------
        list of Chain
            Distinct ones that converged, lowest energy first; each with its Morse index.

        Raises
        ------
        ValueError
            As :meth:`deform`.
        """
        from loopelastica.rod.deformed import equilibria

        return equilibria(self, clamping, torsion_ratio, energy_max)

    def to_dict(self) -> dict[str, Any]:
        """Give all that determines it, JSON-ready.

        Returns
        -------
        dict
            For :meth:`from_dict`.
        """
        assert self.stiffness is not None
        return {
            "steps": self.steps.tolist(),
            "end_frame": self.end_frame.tolist(),
            "stiffness": self.stiffness.tolist(),
        }

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> "RestShape":
        """Make the inverse of :meth:`to_dict`.

        Parameters
        ----------
        values : dict
            As `to_dict` has given it.

        Returns
        -------
        RestShape

        Raises
        ------
        KeyError
            If a value is missing.
        ValueError
            For what is no rest shape.
        """
        if not isinstance(values, dict):
            raise ValueError(f"`values` is {shown(values)}; it must be a dictionary of a shape")
        return cls(values["steps"], values["end_frame"], values["stiffness"])


def _rates(name: str, rate: Rate, s: Array) -> Array:
    """A rate at each arc length."""
    values = [rate(float(at)) for at in s] if callable(rate) else [rate] * len(s)
    return np.array([finite(name, value) for value in values])
