"""The discrete rod of least energy: a start wherever no stored rod is near.

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

which is exact. The Newton step of the constrained problem comes from a block
tridiagonal LDLᵀ (3×3 pivots, four right-hand sides) and a 3×3 Schur complement S = C H⁻¹ Cᵀ. It
goes downhill iff H and S have equally many negative eigenvalues; otherwise H is shifted. A line
search on energy + μ |constraint|₁ with a second-order correction makes it robust: it starts from
anywhere. At the end the difference of the two counts is the Morse index of the discrete rod.

A free end spin is one more variable: the last clamp may turn about its tangent; then its twist
costs nothing in the end, M3 = 0.

Nodes are crowded at the ends, where a tense rod has its boundary layers of width 1/√F.
"""

import math

import numpy as np
from numba import njit

from loopelastica.rod._rotations import matrix_from_quaternion, tangent
from loopelastica.rod._tails import align, multiply, planar_start, wrap

SEGMENTS = 64
_ITERATIONS = 200
_STEP = 0.6
_FLOOR = 1e-6


@njit(cache=True, nogil=True, error_model="numpy")
def graded_nodes(n, root, s):
    """Arc lengths s (n + 1,) with density 1 + (q/2)(e^(−qs) + e^(−q(1−s))), q = √F/2."""
    q = 0.5 * root
    total = 1.0 + (1.0 - math.exp(-q))
    low = 0.0
    for i in range(n + 1):
        wanted = total * i / n
        high = 1.0
        a = low
        for _ in range(26):
            middle = 0.5 * (a + high)
            value = middle + 0.5 * (
                1.0 - math.exp(-q * middle) + math.exp(-q * (1.0 - middle)) - math.exp(-q)
            )
            if value < wanted:
                a = middle
            else:
                high = middle
        s[i] = 0.5 * (a + high)
        low = a
    s[0], s[n] = 0.0, 1.0


@njit(cache=True, nogil=True, error_model="numpy")
def _axis_angle(x, y, z, angle, out):
    """Quaternion of a turn by ``angle`` about the unit vector (x, y, z)."""
    s = math.sin(0.5 * angle)
    out[0], out[1], out[2], out[3] = math.cos(0.5 * angle), s * x, s * y, s * z


@njit(cache=True, nogil=True, error_model="numpy")
def _turn(q, bx, by, bz):
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
def _layer(s, root, half_angle_tan):
    """Angle of a tail at distance ``s`` from its end: tan(θ/4) = tan(α/4) sinh(√f(1−s))/sinh √f."""
    if root < 1e-3:
        ratio = 1.0 - s
    else:
        ratio = math.exp(-root * s) * (
            (1.0 - math.exp(-2.0 * root * (1.0 - s))) / (1.0 - math.exp(-2.0 * root))
        )
    return 4.0 * math.atan(half_angle_tan * ratio)


@njit(cache=True, nogil=True, error_model="numpy")
def start_frames(position, quaternion, gap, free_spin, turns, side0, side1, n, s, frames, force):
    """Fill nodes ``s`` (n + 1,), ``frames`` (n + 2, 4) and ``force`` (3,) of the analytic start.

    The frames go from the start clamp through an axis under tension to the end clamp, with the
    wanted number of turns spread evenly; see `solve_tails` for ``turns`` and the sides.
    """
    root, ex, ey, ez = planar_start(position, quaternion, gap, side0, side1)
    if root < 0.5:
        root = 0.5
    root = min(root, 200.0)
    graded_nodes(n, root, s)
    tx, ty, tz = tangent(quaternion)
    # B carries e3 to e the shortest way; the end frame is Rot(a1, α1) B Rz(twist)
    b, spun, turn0, turn1 = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    first, second = np.empty(4), np.empty(4)
    align(ex, ey, ez, b)
    alpha0 = 2.0 * math.atan2(
        math.sqrt(max(0.5 * (1.0 - ez), 0.0)), math.sqrt(max(0.5 * (1.0 + ez), 0.0))
    )
    # axis of B
    norm0 = math.sqrt(b[1] * b[1] + b[2] * b[2] + b[3] * b[3])
    if norm0 > 1e-12:
        ax, ay, az = b[1] / norm0, b[2] / norm0, b[3] / norm0
    else:
        ax, ay, az = 1.0, 0.0, 0.0
    cx, cy, cz = ey * tz - ez * ty, ez * tx - ex * tz, ex * ty - ey * tx
    norm1 = math.sqrt(cx * cx + cy * cy + cz * cz)
    dot = ex * tx + ey * ty + ez * tz
    alpha1 = math.atan2(norm1, dot)
    if norm1 > 1e-12:
        cx, cy, cz = cx / norm1, cy / norm1, cz / norm1
    else:
        # any axis across e
        m = matrix_from_quaternion(b)
        cx, cy, cz = m[0, 0], m[1, 0], m[2, 0]
    twist = 0.0
    if not free_spin:
        # twist = angle of (Rot(a1, α1) B)ᵀ target about e3
        _axis_angle(cx, cy, cz, -alpha1, turn1)
        multiply(turn1, quaternion, first)
        turn0[0], turn0[1], turn0[2], turn0[3] = b[0], -b[1], -b[2], -b[3]
        multiply(turn0, first, second)
        twist = wrap(2.0 * math.atan2(second[3], second[0])) + 2.0 * math.pi * turns
    if side0:
        alpha0 -= 2.0 * math.pi
    if side1:
        alpha1 -= 2.0 * math.pi
    tan0, tan1 = math.tan(0.25 * alpha0), math.tan(0.25 * alpha1)
    frames[0, 0], frames[0, 1], frames[0, 2], frames[0, 3] = 1.0, 0.0, 0.0, 0.0
    for i in range(n):
        at = 0.5 * (s[i] + s[i + 1])
        _axis_angle(0.0, 0.0, 1.0, twist * at, spun)
        multiply(b, spun, first)
        _axis_angle(cx, cy, cz, _layer(1.0 - at, root, tan1), turn1)
        multiply(turn1, first, second)
        _axis_angle(ax, ay, az, -_layer(at, root, tan0), turn0)
        multiply(turn0, second, frames[i + 1])
    for c in range(4):
        frames[n + 1, c] = quaternion[c]
    if free_spin:
        # the end's spin starts where nothing twists the last hinge
        align_spin(frames[n], frames[n + 1])
    f = root * root if root > 3.0 else 0.0
    force[0], force[1], force[2] = f * ex, f * ey, f * ez


@njit(cache=True, nogil=True, error_model="numpy")
def align_spin(reference, q):
    """Turn q about its own d3 so that it differs from ``reference`` by a turn without twist."""
    p, conjugate = np.empty(4), np.empty(4)
    conjugate[0], conjugate[1] = reference[0], -reference[1]
    conjugate[2], conjugate[3] = -reference[2], -reference[3]
    multiply(conjugate, q, p)
    _turn(q, 0.0, 0.0, -2.0 * math.atan2(p[3], p[0]))


@njit(cache=True, nogil=True, error_model="numpy")
def bow(frames, s, n, size, mode):
    """Bend the inner frames by smooth fixed rotations, to leave a symmetric start."""
    for i in range(n):
        at = 0.5 * (s[i] + s[i + 1])
        slope = size * math.sin(2.0 * math.pi * at)
        other = 0.37 * size * math.sin(math.pi * (1 + mode) * at)
        _turn(frames[i + 1], other, slope, 0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def _hinge(p, q, out):
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
def _measure(frames, s, n, position, k3, omega, c):
    """Energy of all hinges; ``omega`` (n + 1, 3) and the constraint ``c`` (3,) on the way."""
    energy = 0.0
    c[0], c[1], c[2] = -position[0], -position[1], -position[2]
    for j in range(n + 1):
        _hinge(frames[j], frames[j + 1], omega[j])
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
def _assemble(frames, s, n, blocks, k3, omega, force, diagonal, upper, gradient, sides):
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
def _negative(a, shift):
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
def _inverse(a, out):
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
def _factor(diagonal, upper, s, n, blocks, shift, inverse, x):
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
        count, _ = _negative(pivot, 0.0)
        negative += count
        _inverse(pivot, inverse[k])
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


@njit(cache=True, nogil=True, error_model="numpy")
def relax(position, quaternion, torsion_ratio, free_spin, n, s, frames, force, moment):
    """Minimize the energy of the discrete rod from ``frames`` (n + 2, 4), in place.

    ``force`` (3,) starts and ends as the multiplier, ``moment`` (3,) is M at s = 0. Returns
    (found, energy, Morse index, iterations).
    """
    k3 = 1.0 if free_spin else torsion_ratio
    blocks = n + 1 if free_spin else n
    omega, c, trial_c = np.empty((n + 1, 3)), np.empty(3), np.empty(3)
    diagonal, upper = np.empty((blocks, 3, 3)), np.empty((blocks, 3, 3))
    gradient, sides = np.empty((blocks, 3)), np.empty((blocks, 3, 3))
    inverse, x = np.empty((blocks, 3, 3)), np.empty((blocks, 3, 4))
    schur, schur_inverse = np.empty((3, 3)), np.empty((3, 3))
    b, trial, target = np.empty((blocks, 3)), np.empty((n + 2, 4)), np.empty(3)
    correction = np.empty(3)
    mu = 0.0
    kicks = 0
    energy = _measure(frames, s, n, position, k3, omega, c)
    for iteration in range(_ITERATIONS):
        _assemble(frames, s, n, blocks, k3, omega, force, diagonal, upper, gradient, sides)
        size_f = math.sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2)
        worst = 0.0
        for k in range(blocks):
            for i in range(3):
                r = gradient[k, i]
                for j in range(3):
                    r -= sides[k, i, j] * force[j]
                worst = max(worst, abs(r))
        norm_c = abs(c[0]) + abs(c[1]) + abs(c[2])
        done = worst < 1e-4 * (1.0 + size_f) and norm_c < 1e-5
        shift = _FLOOR
        index = 0
        for attempt in range(14):
            for k in range(blocks):
                for i in range(3):
                    x[k, i, 0] = -gradient[k, i]
                    for j in range(3):
                        x[k, i, 1 + j] = sides[k, i, j]
            negative = _factor(diagonal, upper, s, n, blocks, shift, inverse, x)
            for i in range(3):
                target[i] = -c[i]
                for j in range(3):
                    schur[i, j] = 0.0
            for k in range(n):
                for i in range(3):
                    for a in range(2):
                        side = sides[k, a, i]
                        target[i] -= side * x[k, a, 0]
                        for j in range(3):
                            schur[i, j] += side * x[k, a, 1 + j]
            count, _ = _negative(schur, 0.0)
            index = negative - count
            if index == 0 or (done and attempt == 0):
                break
            shift = 2.0 if shift < 1.0 else 4.0 * shift
        if done:
            if index <= 0 or kicks == 2:
                _first_moment(omega, s, n, k3, moment)
                return True, energy, index, iteration
            kicks += 1
            bow(frames, s, n, 0.07, kicks)
            energy = _measure(frames, s, n, position, k3, omega, c)
            continue
        _inverse(schur, schur_inverse)
        worst_f = 0.0
        for i in range(3):
            r = (
                schur_inverse[i, 0] * target[0]
                + schur_inverse[i, 1] * target[1]
                + schur_inverse[i, 2] * target[2]
            )
            correction[i] = r
            worst_f = max(worst_f, abs(r))
        if not worst_f < 1e12:
            # the frames are straight: the constraint has no slope along the chord
            bow(frames, s, n, 0.1, 1 + kicks)
            kicks += 1
            if kicks > 3:
                return False, math.inf, 0, iteration
            energy = _measure(frames, s, n, position, k3, omega, c)
            continue
        largest, downhill = 0.0, 0.0
        for k in range(blocks):
            total = 0.0
            for i in range(3):
                b[k, i] = x[k, i, 0]
                for j in range(3):
                    b[k, i] += x[k, i, 1 + j] * correction[j]
                total += b[k, i] * b[k, i]
                downhill += gradient[k, i] * b[k, i]
            largest = max(largest, total)
        mu = max(mu, 1.1 * worst_f)
        downhill -= mu * norm_c
        t = min(1.0, _STEP / max(math.sqrt(largest), 1e-300))
        merit = energy + mu * norm_c
        accepted = False
        for attempt in range(12):
            _move(frames, b, x, t, False, correction, n, blocks, trial)
            value = _measure(trial, s, n, position, k3, omega, trial_c)
            norm = abs(trial_c[0]) + abs(trial_c[1]) + abs(trial_c[2])
            if value + mu * norm <= merit + 1e-4 * t * downhill + 1e-13 * abs(merit):
                accepted = True
            elif attempt < 3:
                # second order: bring the constraint's curvature back to zero
                for i in range(3):
                    target[i] = -(
                        schur_inverse[i, 0] * trial_c[0]
                        + schur_inverse[i, 1] * trial_c[1]
                        + schur_inverse[i, 2] * trial_c[2]
                    )
                _move(frames, b, x, t, True, target, n, blocks, trial)
                value = _measure(trial, s, n, position, k3, omega, trial_c)
                norm = abs(trial_c[0]) + abs(trial_c[1]) + abs(trial_c[2])
                accepted = value + mu * norm <= merit + 1e-4 * t * downhill
            if accepted:
                break
            t *= 0.4
        if not accepted and kicks < 3:
            # nothing along this direction: leave the place
            kicks += 1
            bow(frames, s, n, 0.07, kicks)
            energy = _measure(frames, s, n, position, k3, omega, c)
            mu = 0.0
            continue
        if not accepted:
            return False, math.inf, 0, iteration
        energy = value
        for i in range(3):
            c[i] = trial_c[i]
            force[i] += t * (correction[i] - force[i])
        for k in range(n + 2):
            for i in range(4):
                frames[k, i] = trial[k, i]
    return False, math.inf, 0, _ITERATIONS


@njit(cache=True, nogil=True, error_model="numpy")
def _move(frames, b, x, t, corrected, extra, n, blocks, trial):
    """Fill ``trial`` with frames exp(t b), or frames exp(t b + W extra) with W = H⁻¹ Cᵀ."""
    for c in range(4):
        trial[0, c] = frames[0, c]
        trial[n + 1, c] = frames[n + 1, c]
    for k in range(blocks):
        v0, v1, v2 = t * b[k, 0], t * b[k, 1], t * b[k, 2]
        if corrected:
            for j in range(3):
                v0 += x[k, 0, 1 + j] * extra[j]
                v1 += x[k, 1, 1 + j] * extra[j]
                v2 += x[k, 2, 1 + j] * extra[j]
        for c in range(4):
            trial[k + 1, c] = frames[k + 1, c]
        _turn(trial[k + 1], v0, v1, v2)


@njit(cache=True, nogil=True, error_model="numpy")
def _first_moment(omega, s, n, k3, moment):
    """M at s = 0: P m of the first hinge, whose left frame is the start frame."""
    x, y, z = omega[0, 0], omega[0, 1], omega[0, 2]
    h = hinge_length(s, n, 0)
    mx, my, mz = x / h, y / h, k3 * z / h
    # P = 1 + [ω]/2 to first order; the hinge is half a segment and small
    moment[0] = mx + 0.5 * (y * mz - z * my)
    moment[1] = my + 0.5 * (z * mx - x * mz)
    moment[2] = mz + 0.5 * (x * my - y * mx)


@njit(cache=True, nogil=True, error_model="numpy")
def unrelaxed_loads(frames, s, n, k3, force, load):
    """Loads (6,) of frames in no equilibrium: the force given, the first hinge's moment."""
    omega = np.empty((1, 3))
    _hinge(frames[0], frames[1], omega[0])
    _first_moment(omega, s, n, k3, load[3:])
    for c in range(3):
        load[c] = force[c]


@njit(cache=True, nogil=True, error_model="numpy")
def hinge_poses(position, frames, s, n, torsion_ratio, m3, stride, node_s, node_pose):
    """Poses at every ``stride``-th hinge, without the extra spin of K30 ≠ 1, as start nodes.

    ``node_s`` (m + 1,), ``node_pose`` (m + 1, 7) with m = n/stride.
    """
    omega = np.empty(3)
    x, y, z = 0.0, 0.0, 0.0
    excess = 1.0 / torsion_ratio - 1.0
    for j in range(n + 1):
        if j % stride == 0:
            k = j // stride
            node_s[k] = s[j]
            node_pose[k, 0], node_pose[k, 1], node_pose[k, 2] = x, y, z
            q = node_pose[k, 3:]
            # the clamps at the ends, the middle of the hinge between
            source = n + 1 if j == n else j
            for c in range(4):
                q[c] = frames[source, c]
            if 0 < j < n:
                _hinge(frames[j], frames[j + 1], omega)
                _turn(q, 0.5 * omega[0], 0.5 * omega[1], 0.5 * omega[2])
            _turn(q, 0.0, 0.0, -m3 * excess * s[j])
        if j < n:
            length = s[j + 1] - s[j]
            tx, ty, tz = tangent(frames[j + 1])
            x += length * tx
            y += length * ty
            z += length * tz
    for c in range(3):
        node_pose[n // stride, c] = position[c]
