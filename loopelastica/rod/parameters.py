"""Physical parameters of a rod, and the way between them and its loads.

Ameline, Haliyo, Huang, Cognet, J. Comput. Phys. 373 (2018) 736, DOI 10.1016/j.jcp.2018.07.021,
eq. 8–28. In Landau's frame, with the force along e_k and μ = √(K0/F) as the unit of length, an
equilibrium is determined by six numbers p = (λ, t_P, a, φ0, s_ini/μ, L/μ): three constants of the
infinite rod, the spin of its frame, and the piece that is cut out of it. The closed form that
evaluates them is in :mod:`loopelastica.rod.kernels.closed_form`.

In units L = 1 and K0 = 1 (those of the loads) the force is (L/μ)² and a moment (L/μ) times its
value in units K0/μ. A rod without force has no μ and no p: :func:`forceless` draws it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from loopelastica._arrays import Array
from loopelastica._checks import array, finite
from loopelastica.rod._arguments import arc_lengths, check_loads, check_torsion_ratio

if TYPE_CHECKING:
    from loopelastica.rod.clamping import Clamping

__all__ = ["PhysicalParameters", "a_min", "forceless"]

# How far below a_Min an `a` may lie: rounding of eq. 11 and of a_Min itself, with a margin.
_A_TOLERANCE = 1e-12
# beyond, phases and angles have no digits left
_LARGEST = 1e12


def a_min(lam: float, t_p: float) -> float:
    """Least value of the constant a at given λ and t_P (Figure 2 of the paper).

    Parameters
    ----------
    lam, t_p : float
        Constants λ and t_P (eq. 9, 10), dimensionless.

    Returns
    -------
    float
        a_Min(λ, t_P): the rod of this a is a helix about the force, or straight.

    Examples
    --------
    >>> print(f"{a_min(0.0, 0.0):.6f} {a_min(0.5, -0.3):.6f}")
    -2.000000 -1.681675
    """
    from loopelastica.rod.kernels import cubic

    return float(cubic.a_min(float(lam), float(t_p)))


def forceless(
    moment: ArrayLike, n: int | ArrayLike, torsion_ratio: float = 1.0
) -> tuple[Array, Array]:
    """The rod that carries a moment and no force: a helix, a circle or a straight line.

    Parameters
    ----------
    moment : (3,) array_like
        Moment in the start frame, in units of K0/L; it is the same all along the rod.
    n : int or array_like
        Number of points equally spaced in arc length, both ends included, or S/L in [0, 1].
    torsion_ratio : float
        K30 = K3/K0.

    Returns
    -------
    centerline : (n, 3) array
        In the start frame, in units of L.
    frames : (n, 3, 3) array
        Rotations with columns d1, d2, d3, in the start frame.

    Raises
    ------
    ValueError
        If an argument has a wrong shape or is not finite.

    Examples
    --------
    A quarter of a circle:

    >>> line, _ = forceless([0.0, np.pi / 2, 0.0], 2)
    >>> print(line[-1].round(6))
    [0.63662 0.      0.63662]
    """
    from loopelastica.rod.kernels.finite_rod import forceless_along

    vector = array("moment", moment)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise ValueError("`moment` must be three finite numbers")
    line, frames = forceless_along(vector, check_torsion_ratio(torsion_ratio), arc_lengths(n, 2))
    return line, frames


@dataclass(frozen=True, slots=True)
class PhysicalParameters:
    """One equilibrium of a rod as a piece of an infinite rod: p of eq. 14.

    Parameters
    ----------
    lam : float
        λ, moment along the force (eq. 9), in units of √(K0 F).
    t_p : float
        t_P, moment along the tangent (eq. 10), in units of √(K0 F).
    a : float
        2 cos(tangent, force) + ρ², ρ the distance from the axis (eq. 11); not below a_Min(λ, t_P).
    phi0 : float
        φ0, third ZYZ Euler angle of the Darboux frame where ρ is largest, radians (eq. 12b). Since
        ψ is ±π/2 there, with the sign of λ + t_P, the φ0 of one rod changes by π as λ + t_P
        changes sign.
    s_ini : float
        Arc length from the point of largest ρ to the start of the rod, in units of μ (eq. 13).
    length : float
        L/μ, positive.

    Raises
    ------
    ValueError
        If a parameter is not finite, `length` is not positive, or `a` lies below a_Min.

    Examples
    --------
    >>> p = PhysicalParameters(-0.3112, -0.2178, -0.7406, 3.4, 0.5, 4.7988)
    >>> print(f"{p.period:.6f}", p.centerline(2)[-1].round(4))
    3.455360 [-0.4019 -0.0704  0.5087]
    """

    lam: float
    t_p: float
    a: float
    phi0: float
    s_ini: float
    length: float

    def __post_init__(self) -> None:
        for name in ("lam", "t_p", "a", "phi0", "s_ini", "length"):
            value = finite(name, getattr(self, name))
            if abs(value) > _LARGEST:
                raise ValueError(f"`{name}` is {value}; its size must be at most {_LARGEST:g}")
            object.__setattr__(self, name, value)
        if self.length <= 0.0:
            raise ValueError(f"`length` is {self.length}; it must be positive")
        least = a_min(self.lam, self.t_p)
        if self.a < least - _A_TOLERANCE * (1.0 + abs(least) + self.lam**2 + self.t_p**2):
            raise ValueError(f"`a` is {self.a}; no rod has less than a_Min(lam, t_p) = {least}")

    @classmethod
    def from_loads(cls, loads: ArrayLike, torsion_ratio: float = 1.0) -> PhysicalParameters | None:
        """Physical parameters of the rod with given loads (eq. 8–11 and 23–28).

        Parameters
        ----------
        loads : (6,) array_like
            F and M at S = 0 in the start frame, in units L = 1, K0 = 1 (eq. 21).
        torsion_ratio : float
            K30 = K3/K0.

        Returns
        -------
        PhysicalParameters or None
            φ0 in [0, 2π) and s_ini in [0, period); None where the force vanishes (F below 1e-9 of
            the square of the moment, or of 1).

        Raises
        ------
        ValueError
            If `loads` is not six finite numbers or `torsion_ratio` is not positive.

        Examples
        --------
        >>> p = PhysicalParameters.from_loads([0.0, 5.0, 20.0, 1.0, 2.0, 3.0])
        >>> print(f"{p.lam:.6f} {p.t_p:.6f} {p.a:.6f}")
        0.747836 0.660730 2.060126
        """
        from loopelastica.rod.kernels.finite_rod import NO_FORCE, physical_from_loads

        values = check_loads(loads)
        ratio = check_torsion_ratio(torsion_ratio)
        force = float(np.linalg.norm(values[:3]))
        if force <= NO_FORCE * max(1.0, float(values[3:] @ values[3:])):
            return None
        return cls(*physical_from_loads(*values.tolist(), ratio))

    @property
    def period(self) -> float:
        """s_per/μ, the period of the distance from the axis; inf where the rod is homoclinic."""
        from loopelastica.rod.kernels.closed_form import period

        return float(period(self.lam, self.t_p, self.a))

    def _numbers(self) -> tuple[float, float, float, float, float, float]:
        return self.lam, self.t_p, self.a, self.phi0, self.s_ini, self.length

    def _along(self, n: int | ArrayLike, torsion_ratio: float) -> tuple[Array, Array]:
        from loopelastica.rod.kernels.finite_rod import rod_along

        ratio = check_torsion_ratio(torsion_ratio)
        line, frames = rod_along(*self._numbers(), ratio, arc_lengths(n, 2))
        return line, frames

    def centerline(self, n: int | ArrayLike, torsion_ratio: float = 1.0) -> Array:
        """Points of the center line in the start frame, in units of L.

        Parameters
        ----------
        n : int or array_like
            Number of points equally spaced in arc length, both ends included, or S/L in [0, 1].
        torsion_ratio : float
            K30 = K3/K0. It turns the start frame about its tangent by t_P (1/K30 − 1) s_ini, as
            φ0 is counted from the point of largest ρ; the shape does not depend on it.

        Returns
        -------
        (n, 3) array
        """
        return self._along(n, torsion_ratio)[0]

    def frames(self, n: int | ArrayLike, torsion_ratio: float = 1.0) -> Array:
        """Darboux frames in the start frame, columns d1, d2, d3.

        Parameters
        ----------
        n : int or (n,) array_like
            As for `centerline`.
        torsion_ratio : float
            As for `centerline`.

        Returns
        -------
        (n, 3, 3) array
        """
        return self._along(n, torsion_ratio)[1]

    def clamping(self, torsion_ratio: float = 1.0) -> Clamping:
        """Relative pose of the two ends: the closed form q1 (eq. 20), with φ0.

        Parameters
        ----------
        torsion_ratio : float
            K30 = K3/K0.

        Returns
        -------
        Clamping

        Examples
        --------
        >>> p = PhysicalParameters(1.0462, 1.5606, 3.2264, 0.64, 1.8, 3.1601)
        >>> print(p.clamping().parameters.round(3))
        [-0.39  -0.068  0.526  4.738  1.418  2.198]
        """
        from loopelastica.rod.clamping import Clamping

        line, frames = self._along(np.ones(1), torsion_ratio)
        return Clamping(line[0], frames[0])

    def loads(self, torsion_ratio: float = 1.0) -> Array:
        """F and M at S = 0 in the start frame, in units L = 1, K0 = 1 (eq. 12c and 21).

        Parameters
        ----------
        torsion_ratio : float
            K30 = K3/K0.

        Returns
        -------
        (6,) array

        Examples
        --------
        >>> p = PhysicalParameters(0.0, 0.0, 0.0, 0.0, 0.0, 2.0)
        >>> print(p.loads().round(6) + 0.0)
        [ 0.        0.       -4.       -2.828427  0.        0.      ]
        """
        from loopelastica.rod.kernels.finite_rod import loads_from_physical

        return np.array(loads_from_physical(*self._numbers(), check_torsion_ratio(torsion_ratio)))

    def reduced(self, torsion_ratio: float = 1.0) -> tuple[PhysicalParameters, float]:
        """The same rod with its start frame turned so that η1 ≥ 0 and η2 = 0 (eq. 15–19).

        Parameters
        ----------
        torsion_ratio : float
            K30 = K3/K0.

        Returns
        -------
        parameters : PhysicalParameters
            With φ0 + φ_a in place of φ0.
        angle : float
            φ_a of eq. 19, radians: turning the reduced rod by it with eq. 15 gives this one back.
        """
        x, y, _ = self.centerline(np.ones(1), torsion_ratio)[0]
        angle = math.atan2(y, x) if x != 0.0 or y != 0.0 else 0.0
        return replace(self, phi0=(self.phi0 + angle) % math.tau), angle

    def mirrored(self) -> PhysicalParameters:
        """The mirror image of the rod in the plane of d1(0) and d3(0) (eq. 34–35).

        It has η2, ψ and φ of the opposite sign, and for any torsion ratio.

        Returns
        -------
        PhysicalParameters
        """
        phi0 = -self.phi0
        if self.lam + self.t_p == 0.0:  # where ψ(0) = π/2 stands for −π/2 as well
            phi0 += math.pi
        return replace(self, lam=-self.lam, t_p=-self.t_p, phi0=phi0 % math.tau)
