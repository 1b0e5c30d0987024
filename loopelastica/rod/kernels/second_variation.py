"""Second variation of a solved rod: conjugate points, and the inertia of its discretization.

Conjugate points. The variations x = (δθ, δr) of a section that a change g of the loads makes are
x(s) = V(s) g, V(0) = 0. A section where det V vanishes can stay put while the rod before it
changes to first order: a point conjugate to the start (Bretl & McCarthy, Int. J. Robot. Res. 33
(2014) 48, doi:10.1177/0278364912473169, in the body frame; V is their J in the space frame). The
rod is a local minimum of the energy, its ends clamped, if there is none in (0, L), and the Morse
index is their number, each counted with the dimension of the kernel. With a free end spin the
energy is that of bending alone, M3 = 0, and the test is the same for the five variations that
leave M3 alone and the five of position and tangent.

Inertia. The Hessian H of the discretized energy (``discrete_rod``) at the solution and the Schur
complement S of its three constraints give the index neg(H) − neg(S). It counts multiple conjugate
points right and does not suffer from the growth exp √F of V, but sees the rod only to the
discretization's error.
"""

import math

import numpy as np

from loopelastica.rod.kernels.discrete_rod import assemble, factor, measure, new_hessian
from loopelastica.rod.kernels.dop853 import STAGES
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.linalg import eliminate, negative_eigenvalues
from loopelastica.rod.kernels.rotations import matrix_from_quaternion
from loopelastica.rod.kernels.shooting import POSE, WITH_JACOBIAN, march, moment_bound, start

# steps per radian of turning
_DENSITY = 2.5


@kernel
def sign_changes(loads, torsion_ratio, free_spin, s, poses):
    """Sign changes of det V from one point of ``s`` (n,) to the next, but for the first few.

    ``poses`` (n, 7) without the extra spin of K30 ≠ 1, from s = 0 on. Near the start det V grows
    like a power of s without changing sign: points before 0.02 are left out.
    """
    y, z, k = np.empty(WITH_JACOBIAN), np.empty(WITH_JACOBIAN), np.empty(STAGES * WITH_JACOBIAN)
    work = np.empty((6, 6))
    start(y)
    excess = 0.0 if free_spin else 1.0 / torsion_ratio - 1.0
    previous, changes = 0.0, 0
    scale_f = max(10.0, math.sqrt(loads[0] ** 2 + loads[1] ** 2 + loads[2] ** 2))
    rate = _DENSITY * moment_bound(loads)
    for i in range(s.shape[0] - 1):
        # M3 is in loads[5] in either case: it is zero for a free spin
        for c in range(POSE):
            y[c] = poses[i, c]
        length = s[i + 1] - s[i]
        march(loads, y, length, 1 + int(rate * length), WITH_JACOBIAN, k, z)
        for r in range(6):
            for c in range(6):
                work[r, c] = y[POSE + 6 * r + c]
        if s[i + 1] < 0.02:
            continue
        m = matrix_from_quaternion(poses[i + 1, 3:])
        if free_spin:
            for c in range(5):
                for r in range(3):
                    work[r, c] = y[25 + 6 * r + c]
                for r in range(2):
                    work[3 + r, c] = m[0, r] * y[7 + c] + m[1, r] * y[13 + c] + m[2, r] * y[19 + c]
        else:
            # K30 ≠ 1: the frame spins by M3 (1/K30 − 1) s about its tangent besides
            for r in range(3):
                work[r, 5] += m[r, 2] * excess * s[i + 1]
        size = 5 if free_spin else 6
        for r in range(size):
            largest = 0.0
            for c in range(size):
                if c < 3:
                    work[r, c] *= scale_f
                largest = max(largest, abs(work[r, c]))
            for c in range(size):
                work[r, c] /= max(largest, 1e-300)
        sign = eliminate(work, size, size, size, 0.0)
        for r in range(size):
            if work[r, r] < 0.0:
                sign = -sign
        if previous != 0.0 and sign != 0.0 and sign != previous:
            changes += 1
        if sign != 0.0:
            previous = sign
    return changes


@kernel
def inertia(loads, position, torsion_ratio, free_spin, rod, window):
    """Morse index of a discretization, a ``DiscreteRod``: its least and its largest value.

    Its frames are those of the rod at the middle of the segments, and the two clamps. Eigenvalues
    nearer to zero than ``window``, per length, count for the largest alone.
    """
    n = rod.s.shape[0] - 1
    k3 = 1.0 if free_spin else torsion_ratio
    hessian, c = new_hessian(n, free_spin), np.empty(3)
    blocks = hessian.gradient.shape[0]
    inverse, x = np.empty((blocks, 3, 3)), np.empty((blocks, 3, 4))
    measure(rod, position, k3, hessian.omega, c)
    assemble(rod, k3, loads[:3], hessian)
    least = _negative(hessian, rod.s, window, inverse, x)
    if window == 0.0:
        return least, least
    return least, _negative(hessian, rod.s, -window, inverse, x)


@kernel
def _negative(hessian, s, shift, inverse, x):
    """Negative eigenvalues of H + shift on the directions that keep the end in place."""
    sides, schur = hessian.sides, np.zeros((3, 3))
    for k in range(x.shape[0]):
        for i in range(3):
            x[k, i, 0] = 0.0
            for j in range(3):
                x[k, i, 1 + j] = sides[k, i, j]
    negative = factor(hessian, s, shift, inverse, x)
    for k in range(s.shape[0] - 1):
        for i in range(3):
            for a in range(2):
                for j in range(3):
                    schur[i, j] += sides[k, a, i] * x[k, a, 1 + j]
    count, _ = negative_eigenvalues(schur, 0.0)
    return negative - count
