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
points right and does not suffer from the growth exp √F of V, but knows the rod only to the
discretization's error.
"""

import math

import numpy as np

from loopelastica.rod.kernels.discrete_rod import assemble, factor, measure, negative_eigenvalues
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.multiple_shooting import _integrate, _rows
from loopelastica.rod.kernels.rotations import matrix_from_quaternion
from loopelastica.rod.kernels.shooting import WITH_JACOBIAN


@kernel
def _sign_of_determinant(a, n):
    """Sign of det of the leading n × n block, by elimination with partial pivoting, in place."""
    sign = 1.0
    for p in range(n):
        best = p
        for i in range(p + 1, n):
            if abs(a[i, p]) > abs(a[best, p]):
                best = i
        if a[best, p] == 0.0:
            return 0.0
        if best != p:
            sign = -sign
            for j in range(n):
                a[p, j], a[best, j] = a[best, j], a[p, j]
        if a[p, p] < 0.0:
            sign = -sign
        for i in range(p + 1, n):
            factor = a[i, p] / a[p, p]
            for j in range(p, n):
                a[i, j] -= factor * a[p, j]
    return sign


@kernel
def sign_changes(loads, torsion_ratio, free_spin, s, poses):
    """Sign changes of det V between the points ``s`` (n,) after the first few, and before L.

    ``poses`` (n, 7) without the extra spin of K30 ≠ 1, from s = 0 on. Near the start det V grows
    like a power of s without changing sign: points before 0.02 are left out.
    """
    v, t, b, work = np.zeros((6, 6)), np.empty((6, 6)), np.empty((6, 6)), np.empty((6, 6))
    f = np.empty(6)
    y, z, k = np.empty(WITH_JACOBIAN), np.empty(WITH_JACOBIAN), np.empty(12 * WITH_JACOBIAN)
    excess = 0.0 if free_spin else 1.0 / torsion_ratio - 1.0
    previous, changes = 0.0, 0
    scale_f = max(10.0, math.sqrt(loads[0] ** 2 + loads[1] ** 2 + loads[2] ** 2))
    for i in range(s.shape[0] - 1):
        # M3 is in loads[5] in either case: it is zero for a free spin
        _integrate(loads, False, poses[i], s[i + 1] - s[i], 3.0, WITH_JACOBIAN, f, y, k, z)
        _rows(y, f, poses[i], t, b)
        for r in range(6):
            for c in range(6):
                total = b[r, c]
                for j in range(6):
                    total += t[r, j] * v[j, c]
                work[r, c] = total
        for r in range(6):
            for c in range(6):
                v[r, c] = work[r, c]
        if s[i + 1] < 0.02 or i + 2 == s.shape[0]:
            continue
        m = matrix_from_quaternion(poses[i + 1, 3:])
        if free_spin:
            for c in range(5):
                for r in range(3):
                    work[r, c] = v[3 + r, c]
                for r in range(2):
                    work[3 + r, c] = m[0, r] * v[0, c] + m[1, r] * v[1, c] + m[2, r] * v[2, c]
        else:
            for r in range(3):
                work[r, 5] = 0.0
                for c in range(6):
                    work[r, c] = v[r, c]
                    work[3 + r, c] = v[3 + r, c]
                # K30 ≠ 1: the frame spins by M3 (1/K30 − 1) s about its tangent besides
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
        sign = _sign_of_determinant(work, size)
        if previous != 0.0 and sign != 0.0 and sign != previous:
            changes += 1
        if sign != 0.0:
            previous = sign
    return changes


@kernel
def inertia(loads, position, torsion_ratio, free_spin, s, frames, shift):
    """Morse index of the discretization with nodes ``s`` (n + 1,) and ``frames`` (n + 2, 4).

    The frames are those of the rod at the middle of the segments, and the two clamps. ``shift``
    is added to the Hessian per length: a zero mode then counts as positive.
    """
    n = s.shape[0] - 1
    blocks = n + 1 if free_spin else n
    k3 = 1.0 if free_spin else torsion_ratio
    omega, c = np.empty((n + 1, 3)), np.empty(3)
    diagonal, upper = np.empty((blocks, 3, 3)), np.empty((blocks, 3, 3))
    gradient, sides = np.empty((blocks, 3)), np.empty((blocks, 3, 3))
    inverse, x, schur = np.empty((blocks, 3, 3)), np.empty((blocks, 3, 4)), np.zeros((3, 3))
    measure(frames, s, n, position, k3, omega, c)
    assemble(frames, s, n, blocks, k3, omega, loads[:3], diagonal, upper, gradient, sides)
    for k in range(blocks):
        for i in range(3):
            x[k, i, 0] = 0.0
            for j in range(3):
                x[k, i, 1 + j] = sides[k, i, j]
    negative = factor(diagonal, upper, s, n, blocks, shift, inverse, x)
    for k in range(n):
        for i in range(3):
            for a in range(2):
                for j in range(3):
                    schur[i, j] += sides[k, a, i] * x[k, a, 1 + j]
    count, _ = negative_eigenvalues(schur, 0.0)
    return negative - count
