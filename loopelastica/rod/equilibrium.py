"""One equilibrium of a clamped rod, and what follows from it.

An equilibrium carries its loads and the poses of its nodes, or its two boundary layers.
Between two nodes it is integrated from the node before, so that errors grow over one interval
only; loads alone no longer determine the rod in double precision once √F exceeds about 70.
"""

import html
import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from loopelastica._arrays import Array, Record, read_only
from loopelastica._checks import array, finite, optional, shown, whole
from loopelastica.rod._arguments import arc_lengths, check_loads, check_torsion_ratio
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.kernels.records import LAYERS, Method, Status

if TYPE_CHECKING:
    from loopelastica.rod.parameters import PhysicalParameters

# ends nearer than this are one point
_ONE_POINT = 1e-9

# points of a closed rod, and how even its curvature is if it is a circle
_ALL_ROUND, _ROUND = 33, 1e-5

# steps per radian of turning when a solution is drawn: 1e-12 over unit length
_DENSITY = 4.0


MESSAGES = {
    Status.CONVERGED: "converged; the residual is that of a mesh the solver did not use",
    Status.STALLED: "no start led to a solution",
    Status.TOO_MANY_ITERATIONS: "no start led to a solution within the iterations allowed",
    Status.TOO_STIFF: "the loads became too large for the rod to be fixed by them",
    Status.CHECK_FAILED: "the iteration converged but a second mesh does not confirm it",
    Status.UNREACHABLE: "the ends are further apart than the rod is long, or exactly as far with"
    " tangents off the line between them",
    Status.BAD_INPUT: "the position is not finite or the rotation is not a rotation",
    Status.OUT_OF_TIME: "the time limit was reached before a solution was found",
}


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Equilibrium(Record):
    """An equilibrium of an ideal rod: L = K0 = 1, lengths in units of L.

    Attributes
    ----------
    clamping : Clamping
        The clamping that was given.
    torsion_ratio : float
        K30 = K3/K0 (eq. 5 of doi:10.1016/j.jcp.2018.07.021).
    loads : (6,) ndarray
        F and M at s = 0 in the start frame (eq. 21), in K0/L² and K0/L.
    energy : float
        ∫ ½(κ² + K30 τ²) ds in K0/L; inf if not converged.
    residual : float
        Largest component of the end's position error and rotation vector, on a mesh which the
        solver did not use; inf if not converged.
    status : Status
        Why the solver stopped; 0 is success. ``message`` says it in words.
    method : Method
        Which step of the solver delivered it; ``method.label`` says it in words.
    node_s, node_pose : (m,), (m, 7) ndarray
        Arc lengths and poses (position, quaternion, without the extra spin of K30 ≠ 1) of nodes.
    layers : (1,) or (0,) structured ndarray
        The two boundary layers of a tense rod, which then take the nodes' place; its fields are
        those of `kernels.records.LAYERS`.
    index : int or None
        Morse index: independent ways downhill with both ends clamped; None until it is computed
        (see :mod:`.stability`).

    Examples
    --------
    >>> import loopelastica as le
    >>> q = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
    >>> rod = le.solve(q)
    >>> rod.converged, round(rod.energy, 4), rod.centerline(3).shape
    (True, 7.0579, (3, 3))
    >>> le.Equilibrium.from_dict(rod.to_dict()).energy == rod.energy
    True
    """

    clamping: Clamping
    torsion_ratio: float
    loads: Array
    energy: float
    residual: float
    status: Status
    method: Method = Method.SHOOTING
    node_s: Array = field(default_factory=lambda: np.zeros(1), repr=False)
    node_pose: Array = field(
        default_factory=lambda: np.array([[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]]), repr=False
    )
    layers: Any = field(default_factory=lambda: np.zeros(0, LAYERS), repr=False)
    index: int | None = None

    def __post_init__(self) -> None:
        for name in ("loads", "node_s", "node_pose"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        object.__setattr__(self, "layers", np.array(self.layers, dtype=LAYERS))
        Record.__post_init__(self)

    def __repr__(self) -> str:
        if not self.converged:
            return f"<Equilibrium: {self.message}>"
        index = "" if self.index is None else f", index {self.index}"
        return f"<Equilibrium: energy {self.energy:.6g}, residual {self.residual:.1e}{index}>"

    def _repr_html_(self) -> str:
        return html.escape(repr(self)[1:-1])

    @property
    def converged(self) -> bool:
        """Whether this is a solution."""
        return self.status == Status.CONVERGED

    @property
    def stable(self) -> bool | None:
        """Whether it is a local minimum of the energy; None until ``index`` is computed."""
        return None if self.index is None else self.index == 0

    @property
    def periods(self) -> float:
        """How many periods of curvature the rod runs through; 0 for a helix or circle."""
        p = self.physical
        return 0.0 if p is None or not math.isfinite(p.period) else p.length / p.period

    @property
    def message(self) -> str:
        """The status in words."""
        return MESSAGES[self.status]

    @property
    def twist(self) -> float:
        """Turns of the frame about the tangent, ∫ τ ds / 2π with τ = M3/K30 constant (eq. 43)."""
        return float(self.loads[5] / self.torsion_ratio / math.tau)

    @property
    def net_winding(self) -> float | None:
        """Net winding of eq. 43 (Berger & Prior 2006), in turns: twist plus writhe.

        For a rod that is closed with one tangent the writhe is Gauss's integral, and with closed
        frames this is the linking number Lk. None where the rod passes through itself, or where
        its ends meet in a corner. See :mod:`.writhe`.
        """
        from loopelastica.rod._contact import winding_points
        from loopelastica.rod.writhe import net_winding

        corner = np.abs(self.clamping.position).max() < _ONE_POINT and not self.clamping.closed
        if corner or not self.converged:
            return None
        s = winding_points(self)
        if s is None:
            return None
        return net_winding(self.centerline(s), self.frames(s), turns=self.twist)

    @property
    def turns(self) -> int | None:
        """Whole turns of the net winding: the equilibria of a clamping are integers apart in it.

        None where the net winding is, and with a free end spin, which fixes no turns.
        """
        winding = None if self.clamping.free_spin else self.net_winding
        # half a turn, which rounding would put on either side, counts upwards
        return None if winding is None else math.floor(winding + 0.5 + 1e-9)

    @property
    def family(self) -> bool:
        """Whether it stands for a family of solutions that a motion carries into one another."""
        return self.family_dimension > 0

    @property
    def family_dimension(self) -> int:
        """Dimension of the family of solutions of the same energy that it stands for.

        0 where it stands alone. 1, a circle, where both ends are on one line: the rod turns about
        it. 2 for a closed rod, which can also be shifted along itself; but 1 for a circle run
        through once or several times, which such a shift turns only.
        """
        clamping = self.clamping
        if not clamping.on_one_line or not self.converged or self.method == Method.STRAIGHT:
            return 0
        if not clamping.closed:
            return 1
        curvature = self.curvature(_ALL_ROUND)
        return 1 if np.ptp(curvature) < _ROUND * curvature.max() else 2

    @property
    def writhe(self) -> float | None:
        """Writhe, in turns: the net winding less the twist.

        The polar writhe of eq. 43, or Gauss's integral for a closed rod; None where that is.
        """
        winding = self.net_winding
        return None if winding is None else winding - self.twist

    @property
    def physical(self) -> "PhysicalParameters | None":
        """Physical parameters p of eq. 14, or None where the force vanishes."""
        from loopelastica.rod.parameters import PhysicalParameters

        return PhysicalParameters.from_loads(self.loads, self.torsion_ratio)

    def poses(self, n: int | ArrayLike) -> Array:
        """Position and quaternion (w, x, y, z) of the frame along the rod.

        Parameters
        ----------
        n : int or (n,) array_like
            Number of points, equally spaced in arc length, both ends included; or arc lengths in
            [0, 1], in any order.

        Returns
        -------
        (n, 7) array
            In the start frame, in units of L.

        Raises
        ------
        ValueError
            If `n` is neither.
        """
        return self._poses(arc_lengths(n), self.torsion_ratio)

    def poses_without_spin(self, n: int | ArrayLike) -> Array:
        """Poses whose frames turn with M as if K30 were 1 (M3 keeps its value).

        Parameters
        ----------
        n : int or (n,) array_like
            As for `poses`.

        Returns
        -------
        (n, 7) array
            As of `poses`.
        """
        return self._poses(arc_lengths(n), 1.0)

    def _poses(self, s: Array, torsion_ratio: float) -> Array:
        if len(self.layers):
            from loopelastica.rod.kernels.layer_poses import sample_layers

            poses: Array = sample_layers(self.layers[0], torsion_ratio, s.copy())
            return poses
        from loopelastica.rod.kernels.shooting import sample

        order = np.argsort(s, kind="stable")
        out = np.empty((len(s), 7))
        out[order] = sample(
            self.loads.copy(), torsion_ratio, self.node_s.copy(), self.node_pose.copy(),
            s[order], _DENSITY,
        )  # fmt: skip
        return out

    def centerline(self, n: int | ArrayLike) -> Array:
        """Points of the center line.

        Parameters
        ----------
        n : int or (n,) array_like
            As for `poses`.

        Returns
        -------
        (n, 3) array
            In the start frame, in units of L.
        """
        return self.poses(n)[:, :3]

    def frames(self, n: int | ArrayLike) -> Array:
        """Frames along the rod.

        Parameters
        ----------
        n : int or (n,) array_like
            As for `poses`.

        Returns
        -------
        (n, 3, 3) array
            In the start frame, columns d1 d2 d3.
        """
        from scipy.spatial.transform import Rotation

        return np.asarray(Rotation.from_quat(self.poses(n)[:, 3:], scalar_first=True).as_matrix())

    def moment(self, n: int | ArrayLike) -> Array:
        """Moment M(s) = M0 + F × r(s) along the rod (eq. 3b).

        Parameters
        ----------
        n : int or (n,) array_like
            As for `poses`.

        Returns
        -------
        (n, 3) array
            In the start frame, in K0/L.
        """
        return self.loads[3:] + np.cross(self.loads[:3], self.centerline(n))

    def curvature(self, n: int | ArrayLike) -> Array:
        """Curvature ``|κ(s)|`` along the rod: the moment across the tangent (eq. 4).

        Parameters
        ----------
        n : int or (n,) array_like
            As for `poses`.

        Returns
        -------
        (n,) array
            In 1/L.
        """
        moment = self.moment(n)
        # |M × t| keeps its digits where |M|² − M3² would cancel
        return np.asarray(np.linalg.norm(np.cross(moment, self.frames(n)[:, :, 2]), axis=1))

    def to_dict(self) -> dict[str, Any]:
        """Give all that determines it, JSON-ready.

        An equilibrium that was not solved has null energy and residual.

        Returns
        -------
        dict
            For :meth:`from_dict`.
        """
        return {
            "clamping": self.clamping.to_dict(),
            "torsion_ratio": self.torsion_ratio,
            "loads": self.loads.tolist(),
            "energy": self.energy if math.isfinite(self.energy) else None,
            "residual": self.residual if math.isfinite(self.residual) else None,
            "status": int(self.status),
            "message": self.message,
            "method": self.method.name.lower(),
            "node_s": self.node_s.tolist(),
            "node_pose": self.node_pose.tolist(),
            "layers": dict(zip(_LAYER_FIELDS, self.layers[0].tolist(), strict=True))
            if len(self.layers)
            else None,
            "index": self.index,
        }

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> "Equilibrium":
        """Make the inverse of :meth:`to_dict`.

        Parameters
        ----------
        values : dict
            As `to_dict` has given it.

        Returns
        -------
        Equilibrium

        Raises
        ------
        KeyError
            If a value is missing.
        ValueError
            For what is no equilibrium.
        """
        if not isinstance(values, dict):
            raise ValueError(f"`values` is {shown(values)}; it must be a dictionary of a rod")
        try:
            return cls(
                Clamping.from_dict(values["clamping"]),
                check_torsion_ratio(values["torsion_ratio"]),
                check_loads(values["loads"]),
                _number(values["energy"]),
                _number(values["residual"]),
                Status(values["status"]),
                Method[values["method"].upper()],
                *_nodes(values["node_s"], values["node_pose"]),
                _layers(values["layers"]),
                optional(whole(0))("index", values["index"]),
            )
        except (TypeError, AttributeError, IndexError, OverflowError) as error:
            raise ValueError(f"`values` is no dictionary of a rod ({error})") from None


def _number(value: float | None) -> float:
    return math.inf if value is None else finite("values", value)


def _nodes(s: ArrayLike, pose: ArrayLike) -> tuple[Array, Array]:
    found = array("node_s", s), array("node_pose", pose)
    n = found[0].size
    shapes = found[0].shape == (n,) and n > 0 and found[1].shape == (n, 7)
    if not shapes or not all(np.isfinite(a).all() for a in found):
        raise ValueError("`node_s` and `node_pose` must be finite, of shapes (n,) and (n, 7)")
    return found


_LAYER_FIELDS = LAYERS.names or ()


def _layers(values: dict[str, float] | None) -> Any:
    if values is None:
        return np.zeros(0, LAYERS)
    layers = tuple(finite(name, values[name]) for name in _LAYER_FIELDS)
    return np.array([layers], dtype=LAYERS)
