"""The discrete rod: energy, exact Hessian and the solver of its Newton equations.

N segments of length l_k carry a frame R_k each; the frames before the first and after the last
are the clamps. Hinge k between R_k−1 and R_k turns by ω = log(R_k−1ᵀ R_k) and stores
ω·diag(1, 1, K)·ω/(2 h_k). The only constraint is Σ l_k R_k e3 = r, three equations whose
multiplier is the force F. The frames are varied by R → R exp(b). With P = 1 + [ω]/2 + c2 [ω]²
(inverse right Jacobian) and m = diag(1, 1, K) ω/h

    gradient    +Pᵀ m on b_k,  −P m on b_k−1
    Hessian     Pᵀ K P/h + sym(A P),  P K Pᵀ/h + sym(B Pᵀ) on the diagonal,
                −P (K P/h + Aᵀ) between k−1 and k,  A, B = ∂(Pᵀm)/∂ω, ∂(P m)/∂ω at fixed m
    stiffness   v·g 1 − (g vᵀ + v gᵀ)/2,  g = R_kᵀ F,  v = l_k e3
    constraint  C_k = −R_k [v]

which is exact. A free end spin is one more variable: the last clamp may turn about its tangent.
Linear systems in H are block tridiagonal with 3×3 blocks.
"""

import math
from typing import NamedTuple

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.linalg import inverse3, negative_eigenvalues
from loopelastica.rod.kernels.rotations import cross, directors, logarithm, product


class DiscreteRod(NamedTuple):
    """Arc lengths ``s`` (n + 1,) of the hinges; ``frames`` (n + 2, 4) of segments and clamps."""

    s: Array
    frames: Array


class Hessian(NamedTuple):
    """Derivatives of the Lagrangian; ``blocks`` is n, or n + 1 for a free spin."""

    diagonal: Array
    """(blocks, 3, 3)."""
    upper: Array
    """(blocks, 3, 3): between a block and the next."""
    gradient: Array
    """(blocks, 3): of the energy alone."""
    sides: Array
    """(blocks, 3, 3): transposed constraint rows C_kᵀ."""
    omega: Array
    """(n + 1, 3): hinge vectors ω."""


@kernel
def new_hessian(n, free_spin):
    """Room for the Hessian of ``n`` segments."""
    blocks = n + 1 if free_spin else n
    return Hessian(
        np.empty((blocks, 3, 3)),
        np.empty((blocks, 3, 3)),
        np.empty((blocks, 3)),
        np.empty((blocks, 3, 3)),
        np.empty((n + 1, 3)),
    )


@kernel
def hinge_vector(p, q, out):
    """ω = log(pᵀ q) in the frame of p, |ω| ≤ π, into ``out``."""
    out[0], out[1], out[2] = logarithm(*product(p[0], -p[1], -p[2], -p[3], q[0], q[1], q[2], q[3]))


@kernel
def measure(rod, position, k3, omega, c):
    """Energy of all hinges; ``omega`` (n + 1, 3) and the constraint ``c`` (3,) on the way."""
    s, frames, energy = rod.s, rod.frames, 0.0
    n = s.shape[0] - 1
    c[0], c[1], c[2] = -position[0], -position[1], -position[2]
    for j in range(n + 1):
        w, a, b, d = frames[j + 1, 0], frames[j + 1, 1], frames[j + 1, 2], frames[j + 1, 3]
        x, y, z = logarithm(
            *product(frames[j, 0], -frames[j, 1], -frames[j, 2], -frames[j, 3], w, a, b, d)
        )
        omega[j, 0], omega[j, 1], omega[j, 2] = x, y, z
        energy += (x * x + y * y + k3 * z * z) / (2.0 * hinge_length(s, j))
        if j < n:
            # d3 of the segment
            length = 2.0 * (s[j + 1] - s[j])
            c[0] += length * (a * d + w * b)
            c[1] += length * (b * d - w * a)
            c[2] += length * (0.5 - a * a - b * b)
    return energy


@kernel
def hinge_length(s, j):
    """Half of either neighbouring segment of hinge ``j``."""
    n, h = s.shape[0] - 1, 0.0
    if j > 0:
        h += 0.5 * (s[j] - s[j - 1])
    if j < n:
        h += 0.5 * (s[j + 1] - s[j])
    return h


@kernel
def assemble(rod, k3, force, hessian):
    """Fill ``hessian`` at a rod whose ``omega`` are there already, with ``force`` (3,)."""
    s, frames = rod.s, rod.frames
    n = s.shape[0] - 1
    clear(hessian)
    for hinge in range(n + 1):
        h = hinge_length(s, hinge)
        add_hinge(hessian, hinge, 1.0 / h, k3 / h, 0.0, 0.0, 1.0)
    if hessian.gradient.shape[0] > n:
        keep_spin(hessian, 0.0, 0.0, 1.0)
    for k in range(n):
        add_segment(hessian, k, frames[k + 1], 0.0, 0.0, s[k + 1] - s[k], force)


@kernel
def clear(hessian):
    """Set all but ``omega`` to zero."""
    hessian.gradient.fill(0.0)
    hessian.diagonal.fill(0.0)
    hessian.upper.fill(0.0)
    hessian.sides.fill(0.0)


@kernel
def add_hinge(hessian, hinge, bending, torsion, tx, ty, tz):
    """Add a hinge whose ω is there: ω·K·ω/2, K ``torsion`` along t and ``bending`` across.

    With W = [ω], W³ = −a² W, m = K ω, m·ω (``dot``) and m × ω (``side``) all products of the
    module's head are sums of 1, [ω], [m] and dyads of ω, m, m × ω, P t (``column``) and Pᵀ t
    (``row``).
    """
    diagonal, upper, gradient = hessian.diagonal, hessian.upper, hessian.gradient
    omega, blocks = hessian.omega, gradient.shape[0]
    x, y, z = omega[hinge, 0], omega[hinge, 1], omega[hinge, 2]
    a2 = x * x + y * y + z * z
    if a2 > 1e-2:
        half = 0.5 * math.sqrt(a2)
        cot = 1.0 / math.tan(half)
        c2 = (1.0 - half * cot) / a2
        # (dc2/da)/a, a = |ω|
        dc2 = ((-0.5 * cot + 0.5 * half * (1.0 + cot * cot)) / (2.0 * half) - 2.0 * c2) / a2
    else:
        c2 = 1.0 / 12.0 + a2 / 720.0 + a2 * a2 / 30240.0
        dc2 = 1.0 / 360.0 + a2 / 7560.0 + a2 * a2 / 201600.0
    along = x * tx + y * ty + z * tz
    w = (x, y, z)
    m = (
        bending * (x - along * tx) + torsion * along * tx,
        bending * (y - along * ty) + torsion * along * ty,
        bending * (z - along * tz) + torsion * along * tz,
    )
    side = cross(m[0], m[1], m[2], x, y, z)
    dot = x * m[0] + y * m[1] + z * m[2]
    uniform = 1.0 - c2 * a2
    # P t and Pᵀ t, P = 1 + W/2 + c2 W²
    ax, ay, az = cross(0.5 * x, 0.5 * y, 0.5 * z, tx, ty, tz)
    ex, ey, ez = (
        c2 * along * x + uniform * tx, c2 * along * y + uniform * ty, c2 * along * z + uniform * tz
    )  # fmt: skip
    column, row = (ex + ax, ey + ay, ez + az), (ex - ax, ey - ay, ez - az)
    excess = torsion - bending
    # PᵀP = PPᵀ = 1 + square W²
    square = 2.0 * c2 - 0.25 - c2 * c2 * a2
    one = (1.0 - square * a2) * bending + dot * (c2 * uniform - 0.25)
    both = square * bending + dot * (2.0 * c2 * c2 + dc2)
    bent = c2 * uniform - 2.0 * c2 - dc2 * a2 + 0.25
    before, after = hinge - 1, hinge
    # P m and Pᵀ m
    ax, ay, az = 0.5 * side[0], 0.5 * side[1], 0.5 * side[2]
    ex, ey, ez = (
        uniform * m[0] + c2 * dot * x, uniform * m[1] + c2 * dot * y, uniform * m[2] + c2 * dot * z
    )  # fmt: skip
    moved = (ex - ax, ey - ay, ez - az)
    bx, by, bz = 0.5 * bent * m[0], 0.5 * bent * m[1], 0.5 * bent * m[2]
    if before >= 0:
        gradient[before, 0] -= moved[0]
        gradient[before, 1] -= moved[1]
        gradient[before, 2] -= moved[2]
        v = (bx - c2 * ax, by - c2 * ay, bz - c2 * az)
        _add(diagonal[before], 1.0, one, both, w, v, v, excess, column, column)
    if after < blocks:
        gradient[after, 0] += ex + ax
        gradient[after, 1] += ey + ay
        gradient[after, 2] += ez + az
        v = (bx + c2 * ax, by + c2 * ay, bz + c2 * az)
        _add(diagonal[after], 1.0, one, both, w, v, v, excess, row, row)
    if before >= 0 and after < blocks:
        # −P (K P/h + Aᵀ) with P² = 1 + uniform W + (square + 1/2) W²
        square += 0.5
        one = (1.0 - square * a2) * bending + c2 * dot * uniform + 0.25 * dot
        both = square * bending + c2 * c2 * dot + dc2 * dot
        left = (
            c2 * moved[0] - 0.25 * m[0], c2 * moved[1] - 0.25 * m[1], c2 * moved[2] - 0.25 * m[2]
        )  # fmt: skip
        spare = 2.0 * c2 + dc2 * a2
        v = (c2 * ax - spare * m[0], c2 * ay - spare * m[1], c2 * az - spare * m[2])
        _add(upper[before], -1.0, one, both, w, left, v, excess, column, row)
        # what multiplies [ω] and [m]
        turned, straight = uniform * bending + 0.5 * c2 * dot, -0.5 * uniform
        rx = turned * x + straight * m[0]
        ry = turned * y + straight * m[1]
        rz = turned * z + straight * m[2]
        upper[before, 0, 1] += rz
        upper[before, 1, 0] -= rz
        upper[before, 2, 0] += ry
        upper[before, 0, 2] -= ry
        upper[before, 2, 1] -= rx
        upper[before, 1, 2] += rx


@kernel
def _add(block, sign, one, both, w, left, right, excess, a, b):
    """Add one·1 + both·w wᵀ + left wᵀ + w rightᵀ + excess·a bᵀ, times ``sign``, to a block."""
    for i in range(3):
        u, t, e = sign * (both * w[i] + left[i]), sign * w[i], sign * excess * a[i]
        block[i, 0] += u * w[0] + t * right[0] + e * b[0]
        block[i, 1] += u * w[1] + t * right[1] + e * b[1]
        block[i, 2] += u * w[2] + t * right[2] + e * b[2]
        block[i, i] += sign * one


@kernel
def keep_spin(hessian, tx, ty, tz):
    """Leave the last block, the free clamp's, one variable: the turn about t, in third place."""
    last = hessian.gradient.shape[0] - 1
    diagonal, upper, gradient = hessian.diagonal[last], hessian.upper, hessian.gradient
    t = (tx, ty, tz)
    slope, curvature = 0.0, 0.0
    for i in range(3):
        slope += gradient[last, i] * t[i]
        for j in range(3):
            curvature += t[i] * diagonal[i, j] * t[j]
    for i in range(3):
        gradient[last, i] = 0.0
        for j in range(3):
            diagonal[i, j] = 1.0 if i == j else 0.0
        coupling = 0.0
        for j in range(3):
            coupling += upper[last - 1, i, j] * t[j]
            upper[last - 1, i, j] = 0.0
        upper[last - 1, i, 2] = coupling
    gradient[last, 2], diagonal[2, 2] = slope, curvature


@kernel
def add_segment(hessian, k, frame, x, y, z, force):
    """Add segment ``k``, whose vector in its ``frame`` (4,) is v: stiffness and constraint."""
    diagonal, sides = hessian.diagonal, hessian.sides
    d1x, d1y, d1z, d2x, d2y, d2z, d3x, d3y, d3z = directors(frame)
    v = (x, y, z)
    g = (
        d1x * force[0] + d1y * force[1] + d1z * force[2],
        d2x * force[0] + d2y * force[1] + d2z * force[2],
        d3x * force[0] + d3y * force[1] + d3z * force[2],
    )
    along = g[0] * x + g[1] * y + g[2] * z
    for i in range(3):
        diagonal[k, i, i] += along
        for j in range(3):
            diagonal[k, i, j] -= 0.5 * (g[i] * v[j] + v[i] * g[j])
    columns = (d1x, d2x, d3x), (d1y, d2y, d3y), (d1z, d2z, d3z)
    for i in range(3):
        # −R [v], transposed: v × d
        a, b, c = columns[i]
        sides[k, 0, i], sides[k, 1, i], sides[k, 2, i] = cross(x, y, z, a, b, c)


@kernel
def factor(hessian, s, shift, inverse, x):
    """Solve the block tridiagonal H + shift·h for the four columns of ``x``, in place.

    ``x`` (blocks, 3, 4); ``inverse`` (blocks, 3, 3) is scratch. Returns the number of negative
    eigenvalues of H + shift·h.
    """
    diagonal, upper = hessian.diagonal, hessian.upper
    n, blocks, negative = s.shape[0] - 1, diagonal.shape[0], 0
    pivot, lower = np.empty((3, 3)), np.empty((3, 3))
    for k in range(blocks):
        length = s[k + 1] - s[k] if k < n else 1.0 / n
        for i in range(3):
            for j in range(3):
                pivot[i, j] = diagonal[k, i, j]
            pivot[i, i] += shift * length
        if k > 0:
            # L = Uᵀ D⁻¹
            for i in range(3):
                for j in range(3):
                    lower[i, j] = (
                        upper[k - 1, 0, i] * inverse[k - 1, 0, j]
                        + upper[k - 1, 1, i] * inverse[k - 1, 1, j]
                        + upper[k - 1, 2, i] * inverse[k - 1, 2, j]
                    )
            for i in range(3):
                for j in range(3):
                    pivot[i, j] -= (
                        lower[i, 0] * upper[k - 1, 0, j]
                        + lower[i, 1] * upper[k - 1, 1, j]
                        + lower[i, 2] * upper[k - 1, 2, j]
                    )
                for j in range(4):
                    x[k, i, j] -= (
                        lower[i, 0] * x[k - 1, 0, j]
                        + lower[i, 1] * x[k - 1, 1, j]
                        + lower[i, 2] * x[k - 1, 2, j]
                    )
        count, _ = negative_eigenvalues(pivot, 0.0)
        negative += count
        inverse3(pivot, inverse[k])
    for k in range(blocks - 1, -1, -1):
        for j in range(4):
            r0, r1, r2 = x[k, 0, j], x[k, 1, j], x[k, 2, j]
            if k + 1 < blocks:
                a, b, c = x[k + 1, 0, j], x[k + 1, 1, j], x[k + 1, 2, j]
                r0 -= upper[k, 0, 0] * a + upper[k, 0, 1] * b + upper[k, 0, 2] * c
                r1 -= upper[k, 1, 0] * a + upper[k, 1, 1] * b + upper[k, 1, 2] * c
                r2 -= upper[k, 2, 0] * a + upper[k, 2, 1] * b + upper[k, 2, 2] * c
            for i in range(3):
                x[k, i, j] = inverse[k, i, 0] * r0 + inverse[k, i, 1] * r1 + inverse[k, i, 2] * r2
    return negative
