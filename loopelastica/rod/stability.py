"""Which equilibria hold: the Morse index of a solution.

The index is the number of independent directions in which the energy falls while both ends stay
clamped; zero is a local minimum. It is counted in two ways (see ``second_variation``). The inertia
of a discretized Hessian, on the directions that keep the end in place, tells it but for modes so
soft that the mesh could turn their sign: a window around zero. The conjugate points have the
index's parity, multiple ones being missed in pairs only. So the inertia counts if its parity is
right, and if one mode is in the window the parity tells its sign; else the mesh is refined. For √F
above `STIFF` det V has lost its digits, and two meshes must agree. Above `_STEEP` all that decides
is in the two boundary layers: modes there cost as much as F, rounding and the mesh far less.

A family of rods (`Equilibrium.family_dimension`) has zero modes, as many as its dimensions: turns
about the common line of both ends, shifts of a closed rod along itself. They cost nothing and do
not count. A rod stretched straight has nowhere to go and is stable.
"""

import math
from dataclasses import replace

import numpy as np

from loopelastica.rod._discrete import discrete_copy, segments, turning
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.kernels.records import Method
from loopelastica.rod.kernels.second_variation import inertia, sign_changes
from loopelastica.rod.kernels.shooting import moment_bound

STIFF = 25.0
# √F; segments of the graded mesh, and the error of its eigenvalues relative to F: at most 1e-6
_STEEP, _LAYERED, _ROUNDED = 1e3, 512, 1e-5
# most that a frame turns from one segment to the next, and the error of an eigenvalue near zero
# for such a turn: 3.2 was the largest of 1,037, and it falls with the square of the turn
_HINGE, _ERROR = 0.4, 4.0
# below any mode that matters
_SOFTEST = 0.05
_REFINEMENTS = 4
# places per radian of the fastest turning, and at least, where the sign of det V is asked for; the
# last place where det V must vanish at the end
_PER_RADIAN, _PLACES, _BEFORE_END = 4.0, 48, 1e-4


def assess(rod: Equilibrium) -> Equilibrium:
    """The same equilibrium with its Morse index computed.

    Parameters
    ----------
    rod : Equilibrium
        Unchanged if it did not converge or has its index already.

    Returns
    -------
    Equilibrium
        With ``index`` and ``stable``.

    Examples
    --------
    >>> import loopelastica as le
    >>> arch = le.solve(le.Clamping([0, 0, 0.9], np.eye(3)))
    >>> print(arch.stable, assess(arch).stable)
    None True
    """
    if not rod.converged or rod.index is not None:
        return rod
    return replace(rod, index=morse_index(rod))


def morse_index(rod: Equilibrium) -> int:
    """Number of independent ways downhill from a converged equilibrium, ends clamped."""
    if rod.method == Method.STRAIGHT:
        return 0
    force = float(np.linalg.norm(rod.loads[:3]))
    tense = math.sqrt(force) > STIFF
    if math.sqrt(force) > _STEEP:
        return _between(rod, _LAYERED, _ROUNDED * force)[0]
    n, before = segments(rod, _HINGE), -1
    conjugate = None if tense else conjugate_points(rod)
    for _ in range(_REFINEMENTS):
        few, many = _between(rod, n, max(_SOFTEST, _ERROR * (turning(rod) / (_HINGE * n)) ** 2))
        soft = many - few - rod.family_dimension
        # a family's zero modes that the window does not hold: the mesh makes them negative
        index = few + min(soft, 0)
        odd = 0 if conjugate is None else (conjugate - index) % 2
        if conjugate is not None and (soft == 1 or (-1 <= soft < 1 and not odd)):
            return index + odd
        if conjugate is None and soft < 1 and index == before:
            return index
        n, before = 2 * n, index
    return index


def conjugate_points(rod: Equilibrium) -> int:
    """Sign changes of det V in (0, L): conjugate points of odd multiplicity."""
    loads = rod.loads.copy()
    s = np.linspace(0.0, 1.0, max(_PLACES, int(_PER_RADIAN * moment_bound(loads))) + 1)
    if rod.family:
        # the end is conjugate to the start itself
        s[-1] = 1.0 - _BEFORE_END
    poses = rod.poses_without_spin(s)
    return int(sign_changes(loads, rod.torsion_ratio, rod.clamping.free_spin, s, poses))


def _between(rod: Equilibrium, n: int, window: float) -> tuple[int, int]:
    """The least and the largest index that a mesh of ``n`` segments allows."""
    few, many = inertia(
        rod.loads.copy(), rod.clamping.position.copy(), rod.torsion_ratio,
        rod.clamping.free_spin, discrete_copy(rod, n), window,
    )  # fmt: skip
    return int(few), int(many)
