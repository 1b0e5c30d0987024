"""The clamping of a rod: position and orientation of its end in its start frame.

Ameline et al., J. Comput. Phys. 373 (2018) 736, doi:10.1016/j.jcp.2018.07.021, eq. 6–7 and 15–19.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from loopelastica._arrays import Array, Record, read_only
from loopelastica._checks import array, finite, positive, shown
from loopelastica.rod._arguments import check_flag

# a matrix read from a file with five decimals is still a rotation; a worse one is a mistake
_ORTHONORMAL = 1e-4
# what is orthonormal to rounding is kept to the last bit, so that clampings read back are equal
_ROUNDING = 1e-14


def nearest_rotation(rotation: Array, name: str = "rotation") -> Array:
    """The rotation nearest to an almost orthonormal matrix; ValueError if it is not near one."""
    if rotation.shape != (3, 3):
        raise ValueError(f"`{name}` has shape {rotation.shape}; it must be (3, 3)")
    if not np.isfinite(rotation).all():
        raise ValueError(f"`{name}` has an entry that is not finite")
    if np.abs(rotation).max() > 2.0:
        raise ValueError(f"`{name}` is not a rotation: it has an entry above 1")
    defect = float(np.abs(rotation.T @ rotation - np.eye(3)).max())
    if defect > _ORTHONORMAL:
        raise ValueError(
            f"`{name}` is not a rotation: its columns miss orthonormality by {defect:.2g}"
        )
    if np.linalg.det(rotation) < 0:
        raise ValueError(f"`{name}` is not a rotation: its determinant is −1, a reflection")
    if defect < _ROUNDING:
        return rotation
    u, _, vt = np.linalg.svd(rotation)
    return np.asarray(u @ vt, dtype=np.float64)


def _rotation_zyz(psi: float, theta: float, phi: float) -> Array:
    def about_z(angle: float) -> Array:
        c, s = math.cos(angle), math.sin(angle)
        return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    c, s = math.cos(theta), math.sin(theta)
    about_y = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    rotation: Array = about_z(psi) @ about_y @ about_z(phi)
    return rotation


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Clamping(Record):
    """Relative pose of the two ends of a rod of unit length.

    Parameters
    ----------
    position : (3,) array_like
        r(L) − r(0) divided by L, in the start frame: (η1, η2, η3) of eq. 7.
    rotation : (3, 3) array_like
        End frame in the start frame; columns d1, d2, d3, with d3 the tangent.
    free_spin : bool
        The end may turn about its tangent: five conditions, and M3 = 0.

    Raises
    ------
    ValueError
        If `position` or `rotation` has a wrong shape, is not finite, or `rotation` is no rotation.

    Examples
    --------
    >>> c = Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
    >>> print(c.position, c.parameters.round(6))
    [-0.4 -0.1  0.5] [-0.4 -0.1  0.5  4.8  1.4  2.2]
    """

    position: Array
    rotation: Array
    free_spin: bool = False

    def __post_init__(self) -> None:
        position = array("position", self.position)
        if position.shape != (3,):
            raise ValueError(f"`position` has shape {position.shape}; it must be (3,)")
        if not np.isfinite(position).all():
            raise ValueError("`position` has an entry that is not finite")
        rotation = nearest_rotation(array("rotation", self.rotation))
        object.__setattr__(self, "position", read_only(position))
        object.__setattr__(self, "rotation", read_only(rotation))
        object.__setattr__(self, "free_spin", check_flag("free_spin", self.free_spin))

    def __repr__(self) -> str:
        parameters = ", ".join(f"{value:.6g}" for value in self.parameters)
        free = ", free_spin=True" if self.free_spin else ""
        return f"Clamping.from_parameters([{parameters}]{free})"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Clamping):
            return NotImplemented
        return (
            self.free_spin == other.free_spin
            and np.array_equal(self.position, other.position)
            and np.array_equal(self.rotation, other.rotation)
        )

    __hash__ = None  # type: ignore[assignment]

    @classmethod
    def from_parameters(cls, q: ArrayLike, free_spin: bool = False) -> "Clamping":
        """From the six parameters of eq. 6.

        Parameters
        ----------
        q : (6,) array_like
            η1, η2, η3 in units of the length; the ZYZ Euler angles ψ, θ, φ in radians.
        free_spin : bool
            As for :class:`Clamping`.

        Returns
        -------
        Clamping

        Raises
        ------
        ValueError
            If `q` has another shape or is not finite.
        """
        values = array("q", q)
        if values.shape != (6,):
            raise ValueError(f"`q` has shape {values.shape}; it must be six clamping parameters")
        if not np.isfinite(values).all():
            raise ValueError("`q` has an entry that is not finite")
        return cls(values[:3], _rotation_zyz(*values[3:]), free_spin)

    @classmethod
    def from_frames(
        cls,
        start_origin: ArrayLike,
        start_frame: ArrayLike,
        end_origin: ArrayLike,
        end_frame: ArrayLike,
        length: float,
        free_spin: bool = False,
    ) -> "Clamping":
        """From two frames in space.

        Parameters
        ----------
        start_origin : (3,) array_like
            Where the rod starts, in any unit.
        start_frame : (3, 3) array_like
            Frame there, columns d1 d2 d3.
        end_origin : (3,) array_like
            Where it ends, in the same unit.
        end_frame : (3, 3) array_like
            Frame there, columns d1 d2 d3.
        length : float
            The rod's length in the same unit.
        free_spin : bool
            As for :class:`Clamping`.

        Returns
        -------
        Clamping

        Raises
        ------
        ValueError
            If `length` is not positive and finite, or a frame is no rotation.
        """
        length = positive("length", length)
        frame = nearest_rotation(array("start_frame", start_frame), "start_frame")
        end = nearest_rotation(array("end_frame", end_frame), "end_frame")
        origins = array("start_origin", start_origin), array("end_origin", end_origin)
        for name, origin in zip(("start_origin", "end_origin"), origins, strict=True):
            if origin.shape != (3,) or not np.isfinite(origin).all():
                raise ValueError(f"`{name}` must be three finite numbers")
        with np.errstate(over="ignore", invalid="ignore"):
            position = frame.T @ ((origins[1] - origins[0]) / length)
        return cls(position, frame.T @ end, free_spin)

    @property
    def parameters(self) -> Array:
        """(η1, η2, η3, ψ, θ, φ), shape (6,): ψ and φ in [0, 2π), θ in [0, π] (eq. 6–7).

        Where θ is 0 or π only ψ ± φ is defined, and φ is 0.
        """
        r = self.rotation
        theta = math.atan2(math.hypot(r[0, 2], r[1, 2]), r[2, 2])
        if math.hypot(r[0, 2], r[1, 2]) > 1e-12:
            psi, phi = math.atan2(r[1, 2], r[0, 2]), math.atan2(r[2, 1], -r[2, 0])
        else:
            psi, phi = math.atan2(-r[0, 1], r[1, 1]), 0.0
        # the second modulo: -1e-17 % 2π is 2π itself
        angles = [psi % math.tau % math.tau, theta, phi % math.tau % math.tau]
        return np.concatenate([self.position, angles])

    @property
    def on_one_line(self) -> bool:
        """Whether both end tangents lie on the line through both ends (θ_R = 0, η1 = η2 = 0).

        Any rod can then be turned about that line at no cost: solutions come in circles. With a
        free end spin the tangents may also be opposed (θ_R = π); a fixed end frame would spin.
        """
        across = max(np.abs(self.position[:2]).max(), np.abs(self.rotation[:2, 2]).max())
        return bool(across < 1e-9 and (self.free_spin or self.rotation[2, 2] > 0))

    @property
    def closed(self) -> bool:
        """Whether both ends are one point with one tangent: the rod is a closed curve."""
        across = max(np.abs(self.position).max(), np.abs(self.rotation[:2, 2]).max())
        return bool(across < 1e-9 and self.rotation[2, 2] > 0)

    def turned(self, angle: float) -> "Clamping":
        """The same rod seen from a start frame turned about its tangent (eq. 15–16).

        The new frame is the old one turned by −`angle` about d3, so that both ends' components
        turn by +`angle`: ψ grows and φ falls by it.

        Parameters
        ----------
        angle : float
            Radians.

        Returns
        -------
        Clamping
        """
        z = _rotation_zyz(finite("angle", angle), 0.0, 0.0)
        return Clamping(z @ self.position, z @ self.rotation @ z.T, self.free_spin)

    def reduced(self) -> tuple["Clamping", float]:
        """The turned clamping with η1 ≥ 0 and η2 = 0, and the angle φ_a of eq. 19.

        ``reduced.turned(angle)`` is this clamping again. Five parameters are left (eq. 17).

        Returns
        -------
        reduced : Clamping
            The turned clamping.
        angle : float
            Radians.
        """
        angle = math.atan2(self.position[1], self.position[0])
        turned = self.turned(-angle)
        exact = np.array([math.hypot(*self.position[:2]), 0.0, self.position[2]])
        return Clamping(exact, turned.rotation, self.free_spin), angle

    def reversed(self) -> "Clamping":
        """The clamping of the same rod run through from its end to its start.

        The frames of the reversed rod are (d1, −d2, −d3) of this one.

        Returns
        -------
        Clamping
        """
        flip = np.diag([1.0, -1.0, -1.0])
        return Clamping(
            -flip @ self.rotation.T @ self.position,
            flip @ self.rotation.T @ flip,
            self.free_spin,
        )

    def mirrored(self) -> "Clamping":
        """The clamping of the rod's mirror image in the plane of d1 and d3 (eq. 34–35).

        Returns
        -------
        Clamping
        """
        mirror = np.diag([1.0, -1.0, 1.0])
        return Clamping(mirror @ self.position, mirror @ self.rotation @ mirror, self.free_spin)

    def to_dict(self) -> dict[str, Any]:
        """Give all that determines it, JSON-ready.

        Returns
        -------
        dict
            For :meth:`from_dict`.
        """
        return {
            "position": self.position.tolist(),
            "rotation": self.rotation.tolist(),
            "free_spin": self.free_spin,
        }

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> "Clamping":
        """Make the inverse of :meth:`to_dict`.

        Parameters
        ----------
        values : dict
            As `to_dict` has given it.

        Returns
        -------
        Clamping

        Raises
        ------
        KeyError
            If a value is missing.
        ValueError
            For what is no clamping.
        """
        if not isinstance(values, dict):
            raise ValueError(f"`values` is {shown(values)}; it must be a dictionary of a clamping")
        return cls(values["position"], values["rotation"], values["free_spin"])
