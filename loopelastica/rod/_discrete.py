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

import numpy as np
from numba import njit

from loopelastica.rod._rotations import matrix_from_quaternion, tangent


@njit(cache=True, nogil=True, error_model="numpy")
def turn(q, bx, by, bz):
    """Turn q by exp(b) from the right, in place."""
    a2 = bx * bx + by * by + bz * bz
    a = math.sqrt(a2)
    s = math.sin(0.5 * a) / a if a > 1e-8 else 0.5 - a2 / 48.0
    w, x, y, z = q[0], q[1], q[2], q[3]
    c = math.cos(0.5 * a)
    px, py, pz = s * bx, s * by, s * bz
    q[0] = w * c - x * px - y * py - z * pz
    q[1] = w * px + x * c + y * pz - z * py
    q[2] = w * py - x * pz + y * c + z * px
    q[3] = w * pz + x * py - y * px + z * c
    norm = 1.0 / math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    q[0] *= norm
    q[1] *= norm
    q[2] *= norm
    q[3] *= norm


@njit(cache=True, nogil=True, error_model="numpy")
def hinge_vector(p, q, out):
    """ω = log(pᵀ q) in the frame of p, |ω| ≤ π, into ``out``."""
    w = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3]
    x = p[0] * q[1] - p[1] * q[0] - p[2] * q[3] + p[3] * q[2]
    y = p[0] * q[2] + p[1] * q[3] - p[2] * q[0] - p[3] * q[1]
    z = p[0] * q[3] - p[1] * q[2] + p[2] * q[1] - p[3] * q[0]
    if w < 0.0:
        w, x, y, z = -w, -x, -y, -z
    s2 = x * x + y * y + z * z
    s = math.sqrt(s2)
    factor = 2.0 * math.atan2(s, w) / s if s > 1e-5 else 2.0 / w * (1.0 - s2 / (3.0 * w * w))
    out[0], out[1], out[2] = factor * x, factor * y, factor * z


@njit(cache=True, nogil=True, error_model="numpy")
def measure(frames, s, n, position, k3, omega, c):
    """Energy of all hinges; ``omega`` (n + 1, 3) and the constraint ``c`` (3,) on the way."""
    energy = 0.0
    c[0], c[1], c[2] = -position[0], -position[1], -position[2]
    for j in range(n + 1):
        hinge_vector(frames[j], frames[j + 1], omega[j])
        h = hinge_length(s, n, j)
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


@njit(cache=True, nogil=True, error_model="numpy")
def hinge_length(s, n, j):
    """Half of either neighbouring segment."""
    h = 0.0
    if j > 0:
        h += 0.5 * (s[j] - s[j - 1])
    if j < n:
        h += 0.5 * (s[j + 1] - s[j])
    return h


@njit(cache=True, nogil=True, error_model="numpy")
def _sandwich(p, q, k3, h, out):
    """Product p diag(1, 1, k3) q / h of 3×3 arrays, into ``out``."""
    for i in range(3):
        for j in range(3):
            out[i, j] = (p[i, 0] * q[0, j] + p[i, 1] * q[1, j] + k3 * p[i, 2] * q[2, j]) / h


@njit(cache=True, nogil=True, error_model="numpy")
def _second(x, y, z, mx, my, mz, c2, dc2, a):
    """Derivative of c2 ω × (ω × m) with respect to ω, m fixed, into ``a`` (3, 3)."""
    dot = x * mx + y * my + z * mz
    a2 = x * x + y * y + z * z
    v = (x, y, z)
    w = (mx, my, mz)
    for i in range(3):
        along = dc2 * (v[i] * dot - w[i] * a2)
        for j in range(3):
            a[i, j] = c2 * (v[i] * w[j] - 2.0 * w[i] * v[j]) + along * v[j]
        a[i, i] += c2 * dot


@njit(cache=True, nogil=True, error_model="numpy")
def _add_symmetric(a, p, mx, my, mz, sign, out):
    """Add to ``out`` the symmetric part of (a + sign [m]/2) p: what exp adds to second order."""
    h = 0.5 * sign
    t = np.empty((3, 3))
    for j in range(3):
        t[0, j] = a[0, 0] * p[0, j] + (a[0, 1] - h * mz) * p[1, j] + (a[0, 2] + h * my) * p[2, j]
        t[1, j] = (a[1, 0] + h * mz) * p[0, j] + a[1, 1] * p[1, j] + (a[1, 2] - h * mx) * p[2, j]
        t[2, j] = (a[2, 0] - h * my) * p[0, j] + (a[2, 1] + h * mx) * p[1, j] + a[2, 2] * p[2, j]
    for i in range(3):
        for j in range(3):
            out[i, j] += 0.5 * (t[i, j] + t[j, i])


@njit(cache=True, nogil=True, error_model="numpy")
def assemble(frames, s, n, blocks, k3, omega, force, diagonal, upper, gradient, sides):
    """Hessian blocks, gradient and constraint rows of the Lagrangian at ``frames``.

    ``diagonal``, ``upper`` (blocks, 3, 3), ``gradient`` (blocks, 3) of the energy alone, and
    ``sides`` (blocks, 3, 3), the transposed constraint rows C_kᵀ.
    """
    p, pt, a = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    t1, t2, t3 = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    for k in range(blocks):
        for i in range(3):
            gradient[k, i] = 0.0
            for j in range(3):
                diagonal[k, i, j] = 0.0
                upper[k, i, j] = 0.0
                sides[k, i, j] = 0.0
    for hinge in range(n + 1):
        x, y, z = omega[hinge, 0], omega[hinge, 1], omega[hinge, 2]
        h = hinge_length(s, n, hinge)
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
        p[0, 0] = 1.0 - c2 * (y * y + z * z)
        p[1, 1] = 1.0 - c2 * (x * x + z * z)
        p[2, 2] = 1.0 - c2 * (x * x + y * y)
        p[0, 1], p[1, 0] = -0.5 * z + c2 * x * y, 0.5 * z + c2 * x * y
        p[0, 2], p[2, 0] = 0.5 * y + c2 * x * z, -0.5 * y + c2 * x * z
        p[1, 2], p[2, 1] = -0.5 * x + c2 * y * z, 0.5 * x + c2 * y * z
        for i in range(3):
            for j in range(3):
                pt[i, j] = p[j, i]
        mx, my, mz = x / h, y / h, k3 * z / h
        _second(x, y, z, mx, my, mz, c2, dc2, a)
        before, after = hinge - 1, hinge
        if before >= 0:
            _sandwich(p, pt, k3, h, t1)
            _add_symmetric(a, pt, mx, my, mz, -1.0, t1)
            for i in range(3):
                gradient[before, i] -= p[i, 0] * mx + p[i, 1] * my + p[i, 2] * mz
                for j in range(3):
                    diagonal[before, i, j] += t1[i, j]
        if after < blocks:
            _sandwich(pt, p, k3, h, t2)
            _add_symmetric(a, p, mx, my, mz, 1.0, t2)
            # −P (K P/h + Aᵀ), A the derivative of Pᵀ m
            _sandwich(p, p, k3, h, t3)
            for i in range(3):
                for j in range(3):
                    t3[i, j] = -t3[i, j] - (
                        p[i, 0] * a[j, 0] + p[i, 1] * a[j, 1] + p[i, 2] * a[j, 2]
                    )
                # A = a + [m]/2, and its transpose has −[m]/2
                t3[i, 0] += 0.5 * (p[i, 1] * mz - p[i, 2] * my)
                t3[i, 1] += 0.5 * (p[i, 2] * mx - p[i, 0] * mz)
                t3[i, 2] += 0.5 * (p[i, 0] * my - p[i, 1] * mx)
            # the last clamp, if free, may only turn about its tangent
            clamp = after == n
            for i in range(3):
                if clamp and i < 2:
                    diagonal[after, i, i] = 1.0
                    continue
                gradient[after, i] += pt[i, 0] * mx + pt[i, 1] * my + pt[i, 2] * mz
                for j in range(3):
                    if not (clamp and j < 2):
                        diagonal[after, i, j] += t2[i, j]
            if before >= 0:
                for i in range(3):
                    for j in range(3):
                        if not (clamp and j < 2):
                            upper[before, i, j] = t3[i, j]
    for k in range(n):
        m = matrix_from_quaternion(frames[k + 1])
        length = s[k + 1] - s[k]
        gx = m[0, 0] * force[0] + m[1, 0] * force[1] + m[2, 0] * force[2]
        gy = m[0, 1] * force[0] + m[1, 1] * force[1] + m[2, 1] * force[2]
        gz = m[0, 2] * force[0] + m[1, 2] * force[1] + m[2, 2] * force[2]
        diagonal[k, 0, 0] += length * gz
        diagonal[k, 1, 1] += length * gz
        diagonal[k, 0, 2] -= 0.5 * length * gx
        diagonal[k, 2, 0] -= 0.5 * length * gx
        diagonal[k, 1, 2] -= 0.5 * length * gy
        diagonal[k, 2, 1] -= 0.5 * length * gy
        for j in range(3):
            sides[k, 0, j] = -length * m[j, 1]
            sides[k, 1, j] = length * m[j, 0]


@njit(cache=True, nogil=True, error_model="numpy")
def negative_eigenvalues(a, shift):
    """Negative eigenvalues of the symmetric 3×3 ``a`` + shift·1, and its determinant."""
    a00, a11, a22 = a[0, 0] + shift, a[1, 1] + shift, a[2, 2] + shift
    minor = a00 * a11 - a[0, 1] * a[1, 0]
    det = (
        a22 * minor
        - a[1, 2] * (a00 * a[2, 1] - a[0, 1] * a[2, 0])
        + a[0, 2] * (a[1, 0] * a[2, 1] - a11 * a[2, 0])
    )
    count = 0
    if a00 < 0.0:
        count += 1
    if minor * a00 < 0.0:
        count += 1
    if det * minor < 0.0:
        count += 1
    return count, det


@njit(cache=True, nogil=True, error_model="numpy")
def inverse3(a, out):
    """Inverse of a symmetric 3×3 array."""
    c00 = a[1, 1] * a[2, 2] - a[1, 2] * a[1, 2]
    c01 = a[0, 2] * a[1, 2] - a[0, 1] * a[2, 2]
    c02 = a[0, 1] * a[1, 2] - a[0, 2] * a[1, 1]
    det = a[0, 0] * c00 + a[0, 1] * c01 + a[0, 2] * c02
    if abs(det) < 1e-300:
        det = 1e-300
    r = 1.0 / det
    out[0, 0], out[0, 1], out[0, 2] = r * c00, r * c01, r * c02
    out[1, 0], out[1, 1] = r * c01, r * (a[0, 0] * a[2, 2] - a[0, 2] * a[0, 2])
    out[1, 2] = r * (a[0, 1] * a[0, 2] - a[0, 0] * a[1, 2])
    out[2, 0], out[2, 1] = r * c02, out[1, 2]
    out[2, 2] = r * (a[0, 0] * a[1, 1] - a[0, 1] * a[0, 1])


@njit(cache=True, nogil=True, error_model="numpy")
def factor(diagonal, upper, s, n, blocks, shift, inverse, x):
    """Solve the block tridiagonal H + shift·h for the four columns of ``x``, in place.

    ``x`` (blocks, 3, 4); ``inverse`` (blocks, 3, 3) is scratch. Returns the number of negative
    eigenvalues of H + shift·h.
    """
    negative = 0
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
