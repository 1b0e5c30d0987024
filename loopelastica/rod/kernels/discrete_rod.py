"""The discrete rod: energy, exact Hessian and the solver of its Newton equations.

N segments of length l_k carry a frame R_k each; the frames before the first and after the last
are the clamps. Hinge k between R_k−1 and R_k turns by ω = log(R_k−1ᵀ R_k) and stores
ω·diag(1, 1, K)·ω/(2 h_k). The only constraint is Σ l_k R_k e3 = r, three equations whose
multiplier is the force F. The frames are varied by R → R exp(b). With P = 1 + [ω]/2 + c2 [ω]²
(inverse right Jacobian) and m = diag(1, 1, K) ω/h

    gradient    +Pᵀ m on b_k,  −P m on b_k−1
    Hessian     Pᵀ K P/h + sym(A P),  P K Pᵀ/h + sym(B Pᵀ) on the diagonal,
                −P (K P/h + Aᵀ) between k−1 and k,  A, B = ∂(Pᵀm)/∂ω, ∂(P m)/∂ω at fixed m
    stiffness   l_k (g3 1 − (g e3ᵀ + e3 gᵀ)/2),  g = R_kᵀ F
    constraint  C_k = −l_k R_k [e3]

which is exact. A free end spin is one more variable: the last clamp may turn about its tangent.
Linear systems in H are block tridiagonal with 3×3 blocks.
"""

import math
from typing import NamedTuple

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.linalg import inverse3, negative_eigenvalues
from loopelastica.rod.kernels.rotations import directors, logarithm, product, tangent


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
        hinge_vector(frames[j], frames[j + 1], omega[j])
        h = hinge_length(s, j)
        energy += (
            omega[j, 0] * omega[j, 0] + omega[j, 1] * omega[j, 1] + k3 * omega[j, 2] * omega[j, 2]
        ) / (2.0 * h)
        if j < n:
            length = s[j + 1] - s[j]
            tx, ty, tz = tangent(frames[j + 1])
            c[0] += length * tx
            c[1] += length * ty
            c[2] += length * tz
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
    """Fill ``hessian`` at a rod whose ``omega`` are there already, with ``force`` (3,).

    With W = [ω], W³ = −a² W, m·ω (``dot``) and m × ω (``side``) all products of the module's head
    are sums of 1, [ω], [m] and dyads of ω, m, m × ω and the third row and column of P.
    """
    s, frames, omega = rod.s, rod.frames, hessian.omega
    diagonal, upper = hessian.diagonal, hessian.upper
    gradient, sides = hessian.gradient, hessian.sides
    n, blocks = s.shape[0] - 1, gradient.shape[0]
    w, m, row, column = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    v, side, moved = np.empty(3), np.empty(3), np.empty(3)
    for k in range(blocks):
        for i in range(3):
            gradient[k, i] = 0.0
            for j in range(3):
                diagonal[k, i, j] = 0.0
                upper[k, i, j] = 0.0
                sides[k, i, j] = 0.0
    for hinge in range(n + 1):
        x, y, z = omega[hinge, 0], omega[hinge, 1], omega[hinge, 2]
        h = hinge_length(s, hinge)
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
        w[0], w[1], w[2] = x, y, z
        m[0], m[1], m[2] = x / h, y / h, k3 * z / h
        side[0], side[1], side[2] = m[1] * z - m[2] * y, m[2] * x - m[0] * z, m[0] * y - m[1] * x
        dot = x * m[0] + y * m[1] + z * m[2]
        # third row and column of P = 1 + W/2 + c2 W²
        row[0], row[1], row[2] = c2 * x * z - 0.5 * y, c2 * y * z + 0.5 * x, 1.0 + c2 * (z * z - a2)
        column[0], column[1], column[2] = c2 * x * z + 0.5 * y, c2 * y * z - 0.5 * x, row[2]
        uniform = 1.0 - c2 * a2
        excess = (k3 - 1.0) / h
        # PᵀP = PPᵀ = 1 + square W²
        square = 2.0 * c2 - 0.25 - c2 * c2 * a2
        one = (1.0 - square * a2) / h + dot * (c2 * uniform - 0.25)
        both = square / h + dot * (2.0 * c2 * c2 + dc2)
        bent = c2 * uniform - 2.0 * c2 - dc2 * a2 + 0.25
        before, after = hinge - 1, hinge
        if before >= 0:
            for i in range(3):
                # P m
                moved[i] = uniform * m[i] + c2 * dot * w[i] - 0.5 * side[i]
                gradient[before, i] -= moved[i]
                v[i] = 0.5 * (bent * m[i] - c2 * side[i])
            for i in range(3):
                diagonal[before, i, i] += one
                for j in range(3):
                    diagonal[before, i, j] += (
                        both * w[i] * w[j]
                        + v[i] * w[j]
                        + w[i] * v[j]
                        + excess * column[i] * column[j]
                    )
        # the last clamp, if free, may only turn about its tangent
        first = 2 if after == n else 0
        if after < blocks:
            for i in range(first):
                diagonal[after, i, i] = 1.0
            for i in range(3):
                v[i] = 0.5 * (bent * m[i] + c2 * side[i])
            for i in range(first, 3):
                gradient[after, i] += uniform * m[i] + c2 * dot * w[i] + 0.5 * side[i]
                diagonal[after, i, i] += one
                for j in range(first, 3):
                    diagonal[after, i, j] += (
                        both * w[i] * w[j] + v[i] * w[j] + w[i] * v[j] + excess * row[i] * row[j]
                    )
        if before >= 0 and after < blocks:
            # −P (K P/h + Aᵀ) with P² = 1 + uniform W + (square + 1/2) W²
            square += 0.5
            one = (1.0 - square * a2) / h + c2 * dot * uniform + 0.25 * dot
            both = square / h + c2 * c2 * dot + dc2 * dot
            for i in range(3):
                v[i] = 0.5 * c2 * side[i] - (2.0 * c2 + dc2 * a2) * m[i]
                moved[i] = c2 * moved[i] - 0.25 * m[i]
            for i in range(3):
                for j in range(first, 3):
                    upper[before, i, j] = -(
                        both * w[i] * w[j]
                        + moved[i] * w[j]
                        + w[i] * v[j]
                        + excess * column[i] * row[j]
                    )
            # what multiplies [ω] and [m]
            turned, straight = uniform / h + 0.5 * c2 * dot, -0.5 * uniform
            rx = turned * x + straight * m[0]
            ry = turned * y + straight * m[1]
            rz = turned * z + straight * m[2]
            if first == 0:
                upper[before, 0, 0] -= one
                upper[before, 1, 1] -= one
                upper[before, 0, 1] += rz
                upper[before, 1, 0] -= rz
                upper[before, 2, 0] += ry
                upper[before, 2, 1] -= rx
            upper[before, 2, 2] -= one
            upper[before, 0, 2] -= ry
            upper[before, 1, 2] += rx
    for k in range(n):
        d1x, d1y, d1z, d2x, d2y, d2z, d3x, d3y, d3z = directors(frames[k + 1])
        length = s[k + 1] - s[k]
        gx = d1x * force[0] + d1y * force[1] + d1z * force[2]
        gy = d2x * force[0] + d2y * force[1] + d2z * force[2]
        gz = d3x * force[0] + d3y * force[1] + d3z * force[2]
        diagonal[k, 0, 0] += length * gz
        diagonal[k, 1, 1] += length * gz
        diagonal[k, 0, 2] -= 0.5 * length * gx
        diagonal[k, 2, 0] -= 0.5 * length * gx
        diagonal[k, 1, 2] -= 0.5 * length * gy
        diagonal[k, 2, 1] -= 0.5 * length * gy
        sides[k, 0, 0], sides[k, 0, 1], sides[k, 0, 2] = -length * d2x, -length * d2y, -length * d2z
        sides[k, 1, 0], sides[k, 1, 1], sides[k, 1, 2] = length * d1x, length * d1y, length * d1z


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
