"""An elastic chain deformed from its rest shape to clamped ends, and what follows from it."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from loopelastica._arrays import Array, Record, read_only
from loopelastica._checks import array, finite, instance, optional, shown, whole
from loopelastica.rod._arguments import arc_lengths, check_torsion_ratio
from loopelastica.rod._chain_starts import starts
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibrium import MESSAGES
from loopelastica.rod.kernels.chain import REACH
from loopelastica.rod.kernels.chain_minimization import ChainRows, deform_rows, new_rows
from loopelastica.rod.kernels.records import Status
from loopelastica.rod.rest_shape import RestShape

# two results are one if nodes (L) and turns agree so far
_SAME = 1e-6
_MESSAGES = {
    Status.CONVERGED: "converged; other formulas than the solver's confirm it",
    Status.CHECK_FAILED: "the iteration converged but other formulas do not confirm it",
}


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Chain(Record):
    """A chain in equilibrium with both ends clamped: L = 1, in the start frame.

    Attributes
    ----------
    shape : RestShape
        The shape at rest.
    clamping : Clamping
        The clamping that was given.
    torsion_ratio : float
        Stiffness of the hinges against torsion over that against bending.
    nodes : (m + 1, 3) ndarray
        Where the hinges are; those of the rest shape if not converged.
    rotations : (m + 2, 3, 3) ndarray
        How the start, each segment and the end are turned against their rest; 1 if not converged.
    force, moment : (3,) ndarray
        At the start, in K0/L² and K0/L; as the loads of an `Equilibrium`.
    energy : float
        Stored in the hinges, in K0/L; inf if not converged.
    residual : float
        Largest error by formulas that the solver does not use: of the end's place, of the balance
        of moments relative to the largest load, of the energy; inf if not converged.
    status : Status
        Why the solver stopped; 0 is success. ``message`` says it in words.
    index : int or None
        Morse index: independent ways downhill with both ends clamped; None if not converged.
    """

    shape: RestShape
    clamping: Clamping
    torsion_ratio: float
    nodes: Array
    rotations: Array
    force: Array
    moment: Array
    energy: float
    residual: float
    status: Status
    index: int | None

    def __post_init__(self) -> None:
        for name in ("nodes", "rotations", "force", "moment"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        Record.__post_init__(self)

    def __repr__(self) -> str:
        if not self.converged:
            return f"<Chain: {self.message}>"
        return (
            f"<Chain: energy {self.energy:.6g}, residual {self.residual:.1e}, index {self.index}>"
        )

    @property
    def converged(self) -> bool:
        """Whether this is a solution."""
        return self.status == Status.CONVERGED

    @property
    def stable(self) -> bool | None:
        """Whether it is a local minimum of the energy; None if not converged."""
        return None if self.index is None else self.index == 0

    @property
    def message(self) -> str:
        """The status in words."""
        return _MESSAGES.get(self.status, MESSAGES[self.status].replace("rod", "chain"))

    @property
    def end_frame(self) -> Array:
        """The end frame in the start frame, (3, 3)."""
        return np.asarray(self.rotations[-1] @ self.shape.end_frame)

    def centerline(self, n: int | ArrayLike, tangents: ArrayLike | None = None) -> Array:
        """Points of a smooth curve through the nodes, shape (n, 3).

        Parameters
        ----------
        n : int or array_like
            Number of points equally spaced in s, both ends included, or values of s in [0, 1], in
            any order. s is the length along the segments.
        tangents : (2, 3) array_like, optional
            Directions of the curve at both ends; none in particular by default.

        Returns
        -------
        (n, 3) ndarray
            Of cubic splines, with continuous curvature.

        Raises
        ------
        ValueError
            If an argument is neither.
        """
        return np.asarray(self._curve(tangents)(arc_lengths(n)))

    def curvature(self, n: int | ArrayLike, tangents: ArrayLike | None = None) -> Array:
        """Curvature of the smooth curve, shape (n,), in 1/L; arguments as for `centerline`."""
        curve, s = self._curve(tangents), arc_lengths(n)
        slope, bend = curve(s, 1), curve(s, 2)
        speed = np.maximum(np.linalg.norm(slope, axis=1), np.finfo(float).tiny ** 0.25)
        return np.asarray(np.linalg.norm(np.cross(slope, bend), axis=1) / speed**3)

    def _curve(self, tangents: ArrayLike | None) -> Any:
        from scipy.interpolate import CubicSpline

        sizes = np.linalg.norm(np.diff(self.nodes, axis=0), axis=1)
        s = np.concatenate([[0.0], np.cumsum(sizes) / sizes.sum()])
        if tangents is None:
            return CubicSpline(s, self.nodes)
        ends = array("tangents", tangents)
        if ends.shape != (2, 3) or not np.isfinite(ends).all() or not ends.any(axis=1).all():
            raise ValueError("`tangents` must be two directions, (2, 3)")
        ends = ends / np.abs(ends).max(axis=1, keepdims=True)
        ends = ends / np.linalg.norm(ends, axis=1, keepdims=True)
        return CubicSpline(s, self.nodes, bc_type=((1, ends[0]), (1, ends[1])))

    def to_dict(self) -> dict[str, Any]:
        """All that determines it, JSON-ready (an unsolved one has null energy and residual)."""
        return {
            "shape": self.shape.to_dict(),
            "clamping": self.clamping.to_dict(),
            "torsion_ratio": self.torsion_ratio,
            **{name: getattr(self, name).tolist() for name in _ARRAYS},
            "energy": self.energy if math.isfinite(self.energy) else None,
            "residual": self.residual if math.isfinite(self.residual) else None,
            "status": int(self.status),
            "message": self.message,
            "index": self.index,
        }

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> "Chain":
        """The inverse of :meth:`to_dict`.

        Raises KeyError if a value is missing, and ValueError for what is no chain.
        """
        if not isinstance(values, dict):
            raise ValueError(f"`values` is {shown(values)}; it must be a dictionary of a chain")
        shape = RestShape.from_dict(values["shape"])
        m = len(shape.steps)
        arrays = {name: array(name, values[name]) for name in _ARRAYS}
        for name, wanted in zip(_ARRAYS, ((m + 1, 3), (m + 2, 3, 3), (3,), (3,)), strict=True):
            if arrays[name].shape != wanted or not np.isfinite(arrays[name]).all():
                raise ValueError(f"`{name}` must be finite numbers of shape {wanted}")
        energy, residual = (
            math.inf if values[name] is None else finite(name, values[name])
            for name in ("energy", "residual")
        )
        return cls(
            shape,
            Clamping.from_dict(values["clamping"]),
            check_torsion_ratio(values["torsion_ratio"]),
            **arrays,
            energy=energy,
            residual=residual,
            status=Status(values["status"]),
            index=optional(whole(0))("index", values["index"]),
        )


_ARRAYS = ("nodes", "rotations", "force", "moment")


def deform(
    shape: RestShape, clamping: Clamping, torsion_ratio: float, guess: Chain | None
) -> Chain:
    """See :meth:`.rest_shape.RestShape.deform`."""
    first = np.zeros((1, 0, 4))
    if guess is not None:
        segments = len(instance("guess", guess, Chain).shape.steps)
        if segments != len(shape.steps):
            raise ValueError(
                f"`guess` has {segments} segments; it must have {len(shape.steps)}, as the shape"
            )
        from scipy.spatial.transform import Rotation

        first = Rotation.from_matrix(guess.rotations[1:-1]).as_quat(scalar_first=True)[None]
    ratio = check_torsion_ratio(torsion_ratio)
    _check_reach(shape, clamping)
    return _from_turns(shape, clamping, ratio, first, True)[0]


def equilibria(
    shape: RestShape, clamping: Clamping, torsion_ratio: float, energy_max: float | None
) -> list[Chain]:
    """See :meth:`.rest_shape.RestShape.equilibria`."""
    ratio = check_torsion_ratio(torsion_ratio)
    bound = optional(finite)("energy_max", energy_max)
    _check_reach(shape, clamping)
    first = starts(shape.points, shape.end_frame, clamping, ratio)
    found = [
        chain
        for minimized in (True, False)
        for chain in _from_turns(shape, clamping, ratio, first, minimized)
        if chain.converged and (bound is None or chain.energy <= bound)
    ]
    found.sort(key=lambda chain: chain.energy)
    return _distinct(found)


def _check_reach(shape: RestShape, clamping: Clamping) -> None:
    distance = math.hypot(*instance("clamping", clamping, Clamping).position)
    apart = f"`clamping` has its ends {distance:.9g} chain lengths apart"
    if distance > 1.0 + REACH:
        raise ValueError(f"{apart}; no chain reaches further than its length")
    # the longest segment keeps them so far apart
    nearest = 2.0 * float(np.linalg.norm(shape.steps, axis=1).max()) / shape.length - 1.0
    if distance < nearest - REACH:
        raise ValueError(f"{apart}; its longest segment keeps them {nearest:.9g} apart or more")


def _from_turns(
    shape: RestShape, clamping: Clamping, ratio: float, first: Array, minimized: bool
) -> list[Chain]:
    """From quaternions (k, m or 0, 4) of the segments to k chains."""
    assert shape.stiffness is not None
    rows = new_rows(len(first), len(shape.steps))
    given = (shape.end_frame, shape.stiffness, clamping.position, clamping.rotation)
    # copies: a read-only array is another type
    end, stiffness, position, rotation = (values[None].copy() for values in given)
    deform_rows(
        shape.steps[None] / shape.length, end, stiffness, position, rotation, ratio,
        clamping.free_spin, first, minimized, rows,
    )  # fmt: skip
    return [_chain(shape, clamping, ratio, rows, row) for row in range(len(first))]


def _chain(shape: RestShape, clamping: Clamping, ratio: float, rows: ChainRows, row: int) -> Chain:
    status = Status(int(rows.status[row]))
    nodes, index = shape.points / shape.length, None
    turns = np.tile(np.eye(3), (len(shape.steps) + 2, 1, 1))
    if status == Status.CONVERGED:
        nodes, turns[1:], index = rows.nodes[row], rows.rotations[row], int(rows.morse_index[row])
        turns[-1] = turns[-1] @ shape.end_frame.T
    return Chain(
        shape, clamping, ratio, nodes, turns, rows.force[row], rows.moment[row],
        float(rows.energy[row]), float(rows.residual[row]), status, index,
    )  # fmt: skip


def _distinct(chains: list[Chain]) -> list[Chain]:
    """Those of some chains with one clamping that are no copies of earlier ones."""
    kept: list[int] = []
    marks = np.array([_mark(chain) for chain in chains])
    for i in range(len(chains)):
        if not kept or np.abs(marks[kept] - marks[i]).max(axis=1).min() > _SAME:
            kept.append(i)
    return [chains[i] for i in kept]


def _mark(chain: Chain) -> Array:
    """Numbers that are equal, within `_SAME`, for two copies of one equilibrium only."""
    steps, nodes, turns = chain.shape.steps, chain.nodes, chain.rotations
    if not (chain.clamping.on_one_line and np.abs(steps[:, :2]).max() < _SAME * chain.shape.length):
        return np.concatenate([nodes.ravel(), turns.ravel()])
    # a straight chain can be turned about the line of both ends at no cost; loads tell mirror
    # images apart
    force, moment = chain.force, chain.moment
    handed = [force @ moment / (1.0 + force @ force), moment[2] / (1.0 + abs(moment[2]))]
    return np.concatenate([np.hypot(nodes[:, 0], nodes[:, 1]), nodes[:, 2], turns[:, 2, 2], handed])
