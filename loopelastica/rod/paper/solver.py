"""The paper's solver as printed: nearest guess of the grid, Newton–Raphson, restarts.

Ameline, Haliyo, Huang, Cognet, J. Comput. Phys. 373 (2018) 736, DOI 10.1016/j.jcp.2018.07.021,
sections 3 and 4.5. It finds *one* equilibrium of a clamping, whichever is near:

1. turn the target about its start tangent to η1 ≥ 0, η2 = 0 (eq. 15–19), and, with a symmetric
   grid, mirror it to φ_R ≤ π (eq. 34–35);
2. take the element of the grid whose image is nearest by the norm of ε1 (section 3.2);
3. drive the chosen error ε1, ε2 or ε3 (eq. 30–32) to zero over the loads by Algorithms 1 and 2,
   with Ridders' derivatives where that fails, and with up to nine more guesses (eq. 36);
4. undo the mirror and the turn, and give the loads back as physical parameters (eq. 23–28).

Section 4.5's two ways to more solutions: :meth:`PaperSolver.several` starts from the k nearest
guesses, :func:`.continue_angle` follows one solution while an end angle turns.

The package's own solver is :func:`loopelastica.solve`; this one is the reference that it is
measured against.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from loopelastica._arrays import Array
from loopelastica._checks import positive, shown
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.paper import grid as _grid
from loopelastica.rod.paper.solutions import (
    MIRROR,
    PaperSolution,
    end_residual,
    same,
    turned_loads,
)
from loopelastica.rod.parameters import PhysicalParameters

# numbers of the errors (eq. 30–32) and of the mappings q2 in the compiled code
ERRORS = {"eps1": 1, "eps2": 2, "eps3": 3}
FORWARD = {"printed": 0, "analytic": 1, "numerical": 2}

_RESTARTS = 9  # eq. 36


@dataclass(frozen=True, slots=True)
class PaperSolver:
    """The method of section 3 with one grid of initial guesses.

    Parameters
    ----------
    l : float
        Size of the region of guesses (eq. 40), dimensionless.
    delta : float
        Step δ of the grid, dimensionless.
    error : str
        "eps1", "eps2" or "eps3" (eq. 30–32): the error driven to zero.
    symmetry : bool
        Halve the grid by eq. 34–35.
    torsion_ratio : float
        K30 = K3/K0.
    forward : str
        The mapping q2: "printed" (closed form, or Bulirsch–Stoer where ``|t_P ± λ|`` < 1e-2),
        "analytic" or "numerical" (Bulirsch–Stoer).
    scan : str
        The error whose norm chooses the guess; "eps1" but for one test of section 4.4.
    tolerance : float
        ε_c of Algorithm 1. The paper does not print it; 1e-7 keeps the Euler angles within the
        1e-5 of eq. 39 where they magnify ε.

    Raises
    ------
    ValueError
        If a name is unknown or a number is not positive and finite.

    Examples
    --------
    >>> from loopelastica import Clamping
    >>> found = PaperSolver(l=2, delta=1).solve(  # doctest: +SKIP
    ...     Clamping.from_parameters([0.3, 0.2, 0.5, 1.0, 0.8, 5.5]))
    >>> print(found.converged, found.residual < 1e-7)  # doctest: +SKIP
    True True
    """

    l: float = 2.0  # noqa: E741 (the paper's letter)
    delta: float = 0.5
    error: str = "eps2"
    symmetry: bool = True
    torsion_ratio: float = 1.0
    forward: str = "printed"
    scan: str = "eps1"
    tolerance: float = 1e-7

    def __post_init__(self) -> None:
        for name, choices in (("error", ERRORS), ("scan", ERRORS), ("forward", FORWARD)):
            given = getattr(self, name)
            if given not in choices:
                raise ValueError(f"`{name}` is {shown(given)}; it must be one of {sorted(choices)}")
        for name in ("l", "delta", "torsion_ratio", "tolerance"):
            object.__setattr__(self, name, positive(name, getattr(self, name)))

    @property
    def grid(self) -> _grid.Grid:
        """The initial guesses; the last few grids are kept in memory."""
        return _grid.grid(self.l, self.delta, self.symmetry, self.torsion_ratio)

    def _reduced(self, clamping: Clamping) -> tuple[Array, float, bool]:
        """q_5D of the target, the angle φ_a (eq. 19), and whether it is mirrored (eq. 35)."""
        if clamping.free_spin:
            raise ValueError("`clamping` has a free end spin; the paper's method clamps it")
        turned, angle = clamping.reduced()
        q = turned.parameters[[0, 2, 3, 4, 5]]
        mirrored = bool(self.symmetry and q[4] > math.pi)
        if mirrored:
            q[[2, 4]] = (math.tau - q[[2, 4]]) % math.tau
        return q, angle, mirrored

    def _nearest(self, q: Array, count: int) -> NDArray[np.intp]:
        """Indices of the nearest guesses, nearest first (section 3.2)."""
        if self.scan == "eps1" or count < 1:
            return self.grid.nearest(q, count)
        from loopelastica.rod.paper.path import distances

        away = np.empty(len(self.grid))
        distances(self.grid.images, q, ERRORS[self.scan], away)
        return np.argsort(away, kind="stable")[:count]

    def _from(self, clamping: Clamping, rank: int, point: Array, restarts: int) -> PaperSolution:
        """Section 3.3 from one guess."""
        from loopelastica.rod.paper import errors as kernels
        from loopelastica.rod.paper import newton as algorithms

        q, angle, mirrored = self._reduced(clamping)
        target, loads = np.empty(7), np.empty(6)
        kernels.pose_of_parameters(q, target)
        status, iterations, restarts, _ = algorithms.invert(
            point,
            target,
            ERRORS[self.error],
            self.torsion_ratio,
            FORWARD[self.forward],
            self.tolerance,
            restarts,
            loads,
        )
        if mirrored:
            loads *= MIRROR
        loads = turned_loads(loads, angle)
        converged = status == algorithms.CONVERGED
        loads.setflags(write=False)
        return PaperSolution(
            clamping,
            self.torsion_ratio,
            loads,
            PhysicalParameters.from_loads(loads, self.torsion_ratio) if converged else None,
            converged,
            end_residual(loads, clamping, self.torsion_ratio) if converged else math.inf,
            iterations,
            restarts,
            rank,
        )

    def solve(self, clamping: Clamping) -> PaperSolution:
        """One equilibrium of a clamping, from the nearest guess.

        Parameters
        ----------
        clamping : Clamping
            Without a free end spin.

        Returns
        -------
        PaperSolution
            ``converged`` False where no guess led to a solution.

        Raises
        ------
        ValueError
            If the end spin is free.
        """
        q, _, _ = self._reduced(clamping)
        return self._from(clamping, 1, self.grid.points[self._nearest(q, 1)[0]], _RESTARTS)

    def several(self, clamping: Clamping, k: int = 180, restarts: int = 0) -> list[PaperSolution]:
        """Equilibria from the k nearest guesses, without duplicates (section 4.5, Fig. 7).

        Two solutions are one if no physical parameter of p_5D differs by 0.1 or more, s_ini modulo
        the period. φ0 does not count: it follows from the others, or, where the end tangents lie
        on one line, distinguishes members of a circle of solutions that are turned about this line.

        Parameters
        ----------
        clamping : Clamping
            Without a free end spin.
        k : int
            Number of guesses.
        restarts : int
            Guesses by eq. 36 for each of them; none in the paper's Fig. 7.

        Returns
        -------
        list of PaperSolution
            Those that converged, in the order of their guesses' ranks.

        Raises
        ------
        ValueError
            If the end spin is free or `k` is not positive.
        """
        q, _, _ = self._reduced(clamping)
        points = self.grid.points
        found: list[PaperSolution] = []
        for rank, index in enumerate(self._nearest(q, k), start=1):
            one = self._from(clamping, rank, points[index], restarts)
            if one.converged and not any(same(one, other) for other in found):
                found.append(one)
        return found


def solve_paper(
    clamping: Clamping | ArrayLike, torsion_ratio: float = 1.0, **options: object
) -> PaperSolution:
    """One equilibrium of a clamping by the printed method.

    Parameters
    ----------
    clamping : Clamping or (6,) array_like
        The clamping, or its parameters q (eq. 6).
    torsion_ratio : float
        K30 = K3/K0.
    **options
        Of `PaperSolver`.

    Returns
    -------
    PaperSolution

    Raises
    ------
    ValueError
        As `PaperSolver` and `Clamping`.

    Examples
    --------
    >>> found = solve_paper([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2], l=2, delta=1)  # doctest: +SKIP
    >>> print(found.converged)  # doctest: +SKIP
    True
    """
    if not isinstance(clamping, Clamping):
        clamping = Clamping.from_parameters(clamping)
    solver = PaperSolver(torsion_ratio=torsion_ratio, **options)  # type: ignore[arg-type]
    return solver.solve(clamping)
