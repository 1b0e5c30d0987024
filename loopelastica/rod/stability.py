"""Which equilibria hold: the Morse index of a solution.

The index is the number of independent directions in which the energy falls while both ends stay
clamped; zero is a local minimum. It is counted from conjugate points and from the inertia of a
discretized Hessian (see ``second_variation``). Where they differ — multiple conjugate points, which
sign changes miss in pairs, or a point on the verge — the discretization is refined until two meshes
agree, and decides; but of a mode so soft that the error of the mesh could turn its sign, as where
both ends are nearly on one line, the conjugate points decide. For √F above `STIFF` only the inertia
is used: det V has lost its digits there.

A rod stretched straight has nowhere to go and is stable. Where both ends lie on one line the turn
of the rod about it costs nothing; such a zero mode does not count.
"""

import math
from dataclasses import replace

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.kernels.discrete_rod import DiscreteRod
from loopelastica.rod.kernels.discrete_starts import graded_nodes
from loopelastica.rod.kernels.records import Method
from loopelastica.rod.kernels.second_variation import inertia, sign_changes
from loopelastica.rod.kernels.shooting import moment_bound

STIFF = 25.0
_MESHES = (64, 128, 256, 512)
# per unit length: below any mode that matters, above the error of a zero mode on these meshes
_ZERO_MODE = 0.05


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
    root = math.sqrt(float(np.linalg.norm(rod.loads[:3])))
    by_mesh = [_inertia(rod, root, _MESHES[0])]
    if root <= STIFF:
        conjugate = conjugate_points(rod)
        if conjugate == by_mesh[0]:
            return conjugate
        few, many = (_inertia(rod, root, _MESHES[0], s) for s in (_ZERO_MODE, -_ZERO_MODE))
        if few <= conjugate <= many:
            return conjugate
    for mesh in _MESHES[1:]:
        by_mesh.append(_inertia(rod, root, mesh))
        if by_mesh[-1] == by_mesh[-2]:
            break
    return by_mesh[-1]


def conjugate_points(rod: Equilibrium) -> int:
    """Sign changes of det V in (0, L): conjugate points of odd multiplicity."""
    # several points per radian of the fastest turning
    loads = rod.loads.copy()
    n = max(160, int(12 * moment_bound(loads)))
    s = np.linspace(0.0, 1.0, n + 1)
    poses = rod.poses_without_spin(s)
    return int(sign_changes(loads, rod.torsion_ratio, rod.clamping.free_spin, s, poses))


def _inertia(rod: Equilibrium, root: float, n: int, shift: float = 0.0) -> int:
    s = np.empty(n + 1)
    graded_nodes(min(root, 200.0), s)
    frames: Array = np.empty((n + 2, 4))
    frames[0] = (1.0, 0.0, 0.0, 0.0)
    frames[1:] = rod.poses(np.append(0.5 * (s[1:] + s[:-1]), 1.0))[:, 3:]
    if rod.clamping.on_one_line:
        shift = _ZERO_MODE
    return int(
        inertia(
            rod.loads.copy(), rod.clamping.position.copy(), rod.torsion_ratio,
            rod.clamping.free_spin, DiscreteRod(s, frames), shift,
        )
    )  # fmt: skip
