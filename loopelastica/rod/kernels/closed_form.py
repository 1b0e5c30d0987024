"""The rod in closed form from its physical parameters, without singular cases.

Source: Ameline, Haliyo, Huang, Cognet, J. Comput. Phys. 373 (2018) 736,
DOI 10.1016/j.jcp.2018.07.021, eq. 8–14, for the parameters; the theta form is derived here. Units
of this module: the length μ = √(K0/F) and K0 = 1, so that the force is e_k.

Equations. In Landau's frame M = e_k × r + λ e_k (eq. 12c); t_P = M·t and a = 2 t_z + ρ² are
constant (eq. 9–11). With z = t_z they give

    z'² = (a − 2z)(1 − z²) − (t_P − λz)² = 2 (z − z1)(z − z2)(z − z3),   z3 ≤ z2 ≤ 1 ≤ z1,

so z = z3 + (z2 − z3) sn²(x|m) with x = w s, w² = (z1 − z3)/2, m = (z2 − z3)/(z1 − z3), where
s = 0 is the point of largest ρ, and u = ρ² = a − 2z. Three angles remain. With A =
cos(θ/2) e^{i(ψ+φ)/2}, B = sin(θ/2) e^{i(ψ−φ)/2} (the quaternion of ZYZ Euler angles) and
P = r_x + i r_y, and for K30 = 1, where the frame turns with M,

    (ψ+φ)' = (λ+t_P)/(1+z),  (ψ−φ)' = (λ−t_P)/(1−z),  (arg P)' = λ/2 + (2t_P − λa)/(2u):

each is an elliptic integral of the third kind whose pole sits where |A|, |B| or |P| vanishes.

The theta form. |A|² = (1+z)/2 is an elliptic function with a double pole and the zeros
x = ±i(K' − β); the logarithmic derivative of A itself has the pole of 1/Θ(x) and *one* zero of each
such pair. An elliptic function of the second kind with that pole and zero is
Θ(x + iσb)/Θ(x) · exp(iκx); the residue at the zero, fixed by the equation for (ψ+φ)', selects
σ = sign(λ + t_P), and the value of (ψ+φ)' there fixes κ. The same holds for B and P, moved by K
since |B| and |P| are least at x = K:

    A: Θ(x + iσb)/Θ(x)     σ = sign(λ+t_P)     sin²am b = (z1−z3)/(1+z1)   cos² = (1+z3)/(1+z1)
    B: Θ(x + K + iσb)/Θ(x) σ = sign(λ−t_P)     sin²am b = (z1−1)/(z1−z2)   cos² = (1−z2)/(z1−z2)
    P: Θ(x + K + iσb)/Θ(x) σ = sign(2t_P−λa)   sin²am b = −u1/(u2−u1)      cos² = u2/(u2−u1)

times exp(iσ[Z(b) + πb/(2KK')]x), and for A also exp(i(λ+t_P)s/(2(1+z1))), for P exp(iλs/2). Here
am b and Z(b) belong to the parameter 1 − m. Where the pole of the third kind falls on the rod
(t_P = ±λ; 2t_P = λa) b = K' and Θ turns into a θ1 that goes through zero: A, B or P changes sign,
and nothing is singular. Finally r_z = z3 s + 2w [x(1 − E/K) − Z(x)].

Only the phases are taken from Θ; the moduli are √((1+z)/2), √((1−z)/2), √u as sums of positive
terms. What accuracy there is to lose lies in differences of the roots, each of which can be tiny
(``cubic``).

Legend: lam, t_p, a the constants λ, t_P, a; y = 1 + z; d12 = z1 − z2 and so on.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from loopelastica.rod.kernels.cubic import a_min, roots
from loopelastica.rod.kernels.elliptic import (
    agm_scale,
    complete_from_scale,
    incomplete,
    jacobi_from_scale,
    theta_phase,
)
from loopelastica.rod.kernels.jit import kernel


@kernel
def _angle_constants(
    sine2: float, cosine2: float, m: float, m1: float, K: float, Kc: float
) -> tuple[float, float, float]:
    """b, Z(b) and π b/(2KK') of one of the three angles, from sin² and cos² of am b."""
    if cosine2 <= 0.0 and m == 0.0:
        return 0.0, 0.0, 0.0  # straight rod: this modulus vanishes and its phase has no meaning
    b, zeta = incomplete(math.sqrt(sine2), math.sqrt(cosine2), m1, m)
    b = min(b, Kc)
    drift = 0.0
    if math.isfinite(K):
        drift = 0.5 * math.pi * b / (K * Kc) if math.isfinite(Kc) else 0.0
    return b, zeta, drift


@kernel
def constants(lam: float, t_p: float, a: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Everything about an infinite rod that does not depend on s.

    Parameters
    ----------
    lam, t_p, a
        Constants λ, t_P, a (eq. 9–11).

    Returns
    -------
    c : (25,) array
        z3, y3, w2, u2, d23, w, K, K', 1 − E/K; then for each of A, B, P: σ, b, Z(b), π b/(2KK')
        and the extra rate; then the number of levels of the scale.
    scale : (3, 24) array
        Arithmetic–geometric means for m.
    """
    y1, y3, w1, w2, u1, u2, _, d12, d13, d23 = roots(lam, t_p, a)
    m, m1 = (d23 / d13, d12 / d13) if d13 > 0.0 else (0.0, 1.0)
    scale, levels = agm_scale(m, m1)
    K, _, missing = complete_from_scale(scale, levels)
    Kc, _, _ = complete_from_scale(*agm_scale(m1, m))
    c = np.empty(25)
    c[0] = y3 - 1.0
    c[1] = y3
    c[2] = w2
    c[3] = u2
    c[4] = d23
    c[5] = math.sqrt(0.5 * d13)
    c[6] = K
    c[7] = Kc
    c[8] = missing
    c[9] = 1.0 if lam + t_p >= 0.0 else -1.0
    c[10], c[11], c[12] = _angle_constants(d13, y3, m, m1, K, Kc)
    c[13] = 0.5 * (lam + t_p) / y1
    c[14] = 1.0 if lam - t_p >= 0.0 else -1.0
    c[15], c[16], c[17] = _angle_constants(w1, w2, m, m1, K, Kc)
    c[18] = 0.0
    # 2t_P − λa without the cancellation near t_P = λ, a = 2
    c[19] = 1.0 if 2.0 * (t_p - lam) - lam * (a - 2.0) >= 0.0 else -1.0
    c[20], c[21], c[22] = _angle_constants(-u1, u2, m, m1, K, Kc)
    c[23] = 0.5 * lam
    c[24] = levels
    return c, scale


@kernel
def _turned(
    modulus2: float, c: NDArray[np.float64], k: int, s: float, x: float, wraps: float
) -> tuple[float, float]:
    """√modulus2 times the unit number of the angle with constants c[k:k + 5]."""
    real, imaginary = theta_phase(x, c[k + 1], c[6], c[7], k > 9)
    imaginary *= c[k]
    size = math.hypot(real, imaginary)
    if size == 0.0:  # the zero itself
        return 0.0, 0.0
    phase = c[k + 4] * s + c[k] * c[k + 2] * x
    if wraps != 0.0:
        phase += c[k] * (c[k + 2] + c[k + 3]) * 2.0 * c[6] * wraps
    modulus = math.sqrt(modulus2) / size
    cosine = math.cos(phase)
    sine = math.sin(phase)
    return (
        modulus * (real * cosine - imaginary * sine),
        modulus * (real * sine + imaginary * cosine),
    )


@kernel
def rod_at(
    s: float, c: NDArray[np.float64], scale: NDArray[np.float64]
) -> tuple[float, float, float, float, float, float, float]:
    """Position and frame at arc length s for K30 = 1, up to the constant phases of A and B.

    Parameters
    ----------
    s
        Arc length from the point of largest ρ, in units of μ.
    c, scale
        From :func:`constants`.

    Returns
    -------
    A_re, A_im, B_re, B_im, x, y, z
        A and B, real and ≥ 0 at s = 0, and the position in units of μ; r(0) = (ρ, 0, 0).
    """
    x = c[5] * s
    K = c[6]
    wraps = 0.0
    if math.isfinite(K):
        wraps = float(round(0.5 * x / K))
        x -= 2.0 * K * wraps
    sn, cn, _, _, zeta = jacobi_from_scale(x, scale, int(c[24]))
    if sn * sn < 0.5:
        cn2 = 1.0 - sn * sn
        sn2 = sn * sn
    else:
        cn2 = cn * cn
        sn2 = 1.0 - cn2
    A_re, A_im = _turned(0.5 * (c[1] + c[4] * sn2), c, 9, s, x, wraps)
    B_re, B_im = _turned(0.5 * (c[2] + c[4] * cn2), c, 14, s, x, wraps)
    P_re, P_im = _turned(c[3] + 2.0 * c[4] * cn2, c, 19, s, x, wraps)
    r_z = c[0] * s + 2.0 * c[5] * (c[8] * c[5] * s - zeta)
    return A_re, A_im, B_re, B_im, P_re, P_im, r_z


@kernel
def landau_pose(
    s: float, phi0: float, spin: float, c: NDArray[np.float64], scale: NDArray[np.float64]
) -> tuple[float, float, float, float, float, float, float]:
    """Unit quaternion of the Darboux frame and position at s, in Landau's frame (eq. 12a, 12b).

    By eq. 8 the tangent at s = 0 lies in the plane of e_j and e_k, so that ψ(0) = ±π/2 with the
    sign of λ + t_P, and φ(0) = φ0. Across λ + t_P = 0 the tangent passes through −e_k and ψ(0)
    changes by π: the same rod has there a φ0 that changes by π.

    Parameters
    ----------
    s
        Arc length from the point of largest ρ, in units of μ.
    phi0
        φ at s = 0, radians.
    spin
        Rate of the additional turn about d3, t_P (1/K30 − 1).
    c, scale
        From :func:`constants`.

    Returns
    -------
    q0, q1, q2, q3, x, y, z
        Quaternion, scalar part first, that takes e_i e_j e_k to d1 d2 d3; position in units of μ.
    """
    A_re, A_im, B_re, B_im, x, y, z = rod_at(s, c, scale)
    psi = 0.5 * math.pi * c[9]
    phi = phi0 + spin * s
    cosine = math.cos(0.5 * (psi + phi))
    sine = math.sin(0.5 * (psi + phi))
    q0 = A_re * cosine - A_im * sine
    q3 = A_re * sine + A_im * cosine
    cosine = math.cos(0.5 * (psi - phi))
    sine = math.sin(0.5 * (psi - phi))
    q2 = B_re * cosine - B_im * sine
    q1 = -(B_re * sine + B_im * cosine)
    return q0, q1, q2, q3, x, y, z


@kernel
def euler_angles(q0: float, q1: float, q2: float, q3: float) -> tuple[float, float, float]:
    """ZYZ Euler angles (ψ, θ, φ) of a quaternion; ψ and φ in (−2π, 2π), θ in [0, π]."""
    half_sum = math.atan2(q3, q0)
    half_difference = math.atan2(-q1, q2)
    theta = 2.0 * math.atan2(math.hypot(q1, q2), math.hypot(q0, q3))
    return half_sum + half_difference, theta, half_sum - half_difference


@kernel
def landau_moment(x: float, y: float, lam: float) -> tuple[float, float, float]:
    """Moment e_k × r + λ e_k in Landau's frame, in units of K0/μ (eq. 12c); the force is e_k."""
    return -y, x, lam


@kernel
def _turn_back(
    q0: float, q1: float, q2: float, q3: float, x: float, y: float, z: float
) -> tuple[float, float, float]:
    """Rᵀ v for the rotation R of a unit quaternion."""
    a = 2.0 * (q3 * y - q2 * z)  # t = −2 q × v, then v + q0 t − q × t
    b = 2.0 * (q1 * z - q3 * x)
    c = 2.0 * (q2 * x - q1 * y)
    return (
        x + q0 * a - (q2 * c - q3 * b),
        y + q0 * b - (q3 * a - q1 * c),
        z + q0 * c - (q1 * b - q2 * a),
    )


@kernel
def rod_along(
    lam: float,
    t_p: float,
    a: float,
    phi0: float,
    s_ini: float,
    length: float,
    torsion_ratio: float,
    arc: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The finite rod in its start frame (q1 of eq. 20, at any point).

    Parameters
    ----------
    lam, t_p, a, phi0, s_ini, length
        Physical parameters p (eq. 14), lengths in units of μ.
    torsion_ratio
        K30 = K3/K0.
    arc : (n,) array
        Arc lengths S/L.

    Returns
    -------
    position : (n, 3) array
        Center line in units of L.
    frame : (n, 3, 3) array
        Rotations, columns d1, d2, d3.
    """
    n = arc.shape[0]
    position = np.empty((n, 3))
    frame = np.empty((n, 3, 3))
    spin = t_p * (1.0 / torsion_ratio - 1.0)
    c, scale = constants(lam, t_p, a)
    p0, p1, p2, p3, x0, y0, z0 = landau_pose(s_ini, phi0, spin, c, scale)
    for i in range(n):
        q0, q1, q2, q3, x, y, z = landau_pose(s_ini + length * arc[i], phi0, spin, c, scale)
        x, y, z = _turn_back(p0, p1, p2, p3, x - x0, y - y0, z - z0)
        position[i, 0], position[i, 1], position[i, 2] = x / length, y / length, z / length
        h0 = p0 * q0 + p1 * q1 + p2 * q2 + p3 * q3  # conj(p) q
        h1 = p0 * q1 - p1 * q0 - p2 * q3 + p3 * q2
        h2 = p0 * q2 + p1 * q3 - p2 * q0 - p3 * q1
        h3 = p0 * q3 - p1 * q2 + p2 * q1 - p3 * q0
        _write_rotation(h0, h1, h2, h3, frame[i])
    return position, frame


@kernel
def _write_rotation(q0: float, q1: float, q2: float, q3: float, out: NDArray[np.float64]) -> None:
    """Rotation matrix of a unit quaternion into out (3, 3)."""
    f = 2.0 / (q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3)
    out[0, 0] = 1.0 - f * (q2 * q2 + q3 * q3)
    out[0, 1] = f * (q1 * q2 - q0 * q3)
    out[0, 2] = f * (q1 * q3 + q0 * q2)
    out[1, 0] = f * (q1 * q2 + q0 * q3)
    out[1, 1] = 1.0 - f * (q1 * q1 + q3 * q3)
    out[1, 2] = f * (q2 * q3 - q0 * q1)
    out[2, 0] = f * (q1 * q3 - q0 * q2)
    out[2, 1] = f * (q2 * q3 + q0 * q1)
    out[2, 2] = 1.0 - f * (q1 * q1 + q2 * q2)


@kernel
def forceless_along(
    moment: NDArray[np.float64], torsion_ratio: float, arc: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The rod without force: helix, circle or straight line, turned by exp of a constant moment.

    Parameters
    ----------
    moment : (3,) array
        Constant moment in the start frame, in units of K0/L.
    torsion_ratio
        K30 = K3/K0.
    arc : (n,) array
        Arc lengths S/L.

    Returns
    -------
    position : (n, 3) array
        Center line in units of L.
    frame : (n, 3, 3) array
        Rotations, columns d1, d2, d3.
    """
    n = arc.shape[0]
    position = np.empty((n, 3))
    frame = np.empty((n, 3, 3))
    size = math.sqrt(moment[0] ** 2 + moment[1] ** 2 + moment[2] ** 2)
    n1, n2, n3 = 0.0, 0.0, 0.0
    if size > 0.0:
        n1, n2, n3 = moment[0] / size, moment[1] / size, moment[2] / size
    spin = moment[2] * (1.0 / torsion_ratio - 1.0)
    for i in range(n):
        s = arc[i]
        angle = size * s
        h = 0.5 * angle
        along = 1.0  # sin(angle)/angle
        across = h  # (1 − cos(angle))/angle
        if abs(h) > 1e-9:
            along = math.sin(angle) / angle
            across = math.sin(h) ** 2 / h
        # ∫ exp(σ [M]×) e3 dσ = n (n·e3) + along (e3 − n (n·e3)) + across n × e3, times s
        rest = (1.0 - along) * n3
        position[i, 0] = s * (rest * n1 + across * n2)
        position[i, 1] = s * (rest * n2 - across * n1)
        position[i, 2] = s * (rest * n3 + along)
        q0, q1, q2, q3 = math.cos(h), math.sin(h) * n1, math.sin(h) * n2, math.sin(h) * n3
        e0, e3 = math.cos(0.5 * spin * s), math.sin(0.5 * spin * s)
        _write_rotation(
            q0 * e0 - q3 * e3, q1 * e0 + q2 * e3, q2 * e0 - q1 * e3, q0 * e3 + q3 * e0, frame[i]
        )
    return position, frame


@kernel
def period(lam: float, t_p: float, a: float) -> float:
    """Period s_per/μ of ρ(s); infinite where the rod is homoclinic.

    Examples
    --------
    >>> print(f"{period(0.0, 0.0, 0.0):.10f} {period(1.0, 1.0, 2.0)}")
    3.7081493546 inf
    """
    _, _, _, _, _, _, _, d12, d13, d23 = roots(lam, t_p, a)
    if d13 <= 0.0:  # triple root: the straight rod at |λ| = 2, between the two kinds
        return math.inf
    K, _, _ = complete_from_scale(*agm_scale(d23 / d13, d12 / d13))
    return float(2.0 * K / math.sqrt(0.5 * d13))


@kernel
def loads_from_physical(
    lam: float, t_p: float, a: float, phi0: float, s_ini: float, length: float, torsion_ratio: float
) -> tuple[float, float, float, float, float, float]:
    """Loading parameters f (eq. 21) in units L = 1, K0 = 1: F and M at S = 0 in the start frame."""
    c, scale = constants(lam, t_p, a)
    spin = t_p * (1.0 / torsion_ratio - 1.0)
    q0, q1, q2, q3, x, y, _ = landau_pose(s_ini, phi0, spin, c, scale)
    f1, f2, f3 = _turn_back(q0, q1, q2, q3, 0.0, 0.0, 1.0)
    m1, m2, m3 = landau_moment(x, y, lam)
    m1, m2, m3 = _turn_back(q0, q1, q2, q3, m1, m2, m3)
    square = length * length
    return square * f1, square * f2, square * f3, length * m1, length * m2, length * m3


_FAR = 40.0  # w s on a homoclinic tail where ρ has fallen below the last digit: e⁻⁴⁰ = 4e-18


@kernel
def physical_from_loads(
    F1: float, F2: float, F3: float, M1: float, M2: float, M3: float, torsion_ratio: float
) -> tuple[float, float, float, float, float, float]:
    """Physical parameters p from loads in units L = 1, K0 = 1 (eq. 8–11 and 23–28).

    Parameters
    ----------
    F1, F2, F3, M1, M2, M3
        Force, not zero, and moment at S = 0 in the start frame.
    torsion_ratio
        K30 = K3/K0.

    Returns
    -------
    lam, t_p, a, phi0, s_ini, length
        φ0 in [0, 2π), s_ini in [0, period), or any sign where the period is infinite. A straight
        rod that shares (λ, t_P, a) with a homoclinic one is put on its far tail.
    """
    force = math.sqrt(F1 * F1 + F2 * F2 + F3 * F3)
    length = math.sqrt(force)
    e1, e2, e3 = F1 / force, F2 / force, F3 / force
    M1, M2, t_p = M1 / length, M2 / length, M3 / length  # eq. 10
    lam = M1 * e1 + M2 * e2 + t_p * e3  # eq. 9
    u = (M1 - lam * e1) ** 2 + (M2 - lam * e2) ** 2 + (t_p - lam * e3) ** 2  # eq. 23, squared
    du = 2.0 * (M1 * e2 - M2 * e1)  # eq. 24, times 2ρ
    a = max(2.0 * e3 + u, a_min(lam, t_p))  # eq. 11

    # eq. 25: u = u3 − (u3 − u2) sn². Of u3 − u and u − u2 the smaller one is taken from
    # u'² = (u3 − u)(u − u2)(u − u1), where it keeps its digits.
    _, _, _, _, u1, u2, u3, d12, d13, d23 = roots(lam, t_p, a)
    s_ini = 0.0
    if d23 > 0.0:
        below, above = max(u3 - u, 0.0), max(u - u2, 0.0)
        if below >= above:
            product = below * (u - u1)
            above = du * du / product if product > 0.0 else 0.0
        else:
            below = du * du / (above * (u - u1))
        m, m1 = d23 / d13, d12 / d13
        x, _ = incomplete(math.sqrt(below), math.sqrt(above), m, m1)
        w = math.sqrt(0.5 * d13)
        K, _, _ = complete_from_scale(*agm_scale(m, m1))
        if math.isinf(K):
            x = min(x, _FAR)
            s_ini = x / w if du <= 0.0 else -x / w
        else:
            x = min(x, K)
            s_ini = x / w if du <= 0.0 or x == 0.0 else (2.0 * K - x) / w

    # eq. 26–28: φ0 turns d1, d2 until both F and M have the components given
    c, scale = constants(lam, t_p, a)
    spin = t_p * (1.0 / torsion_ratio - 1.0)
    q0, q1, q2, q3, x, y, _ = landau_pose(s_ini, 0.0, spin, c, scale)
    f1, f2, _ = _turn_back(q0, q1, q2, q3, 0.0, 0.0, 1.0)
    m1, m2, m3 = landau_moment(x, y, lam)
    m1, m2, m3 = _turn_back(q0, q1, q2, q3, m1, m2, m3)
    sine = f2 * e1 - f1 * e2 + m2 * M1 - m1 * M2
    cosine = f1 * e1 + f2 * e2 + m1 * M1 + m2 * M2
    phi0 = math.atan2(sine, cosine)
    if phi0 < 0.0:
        phi0 += 2.0 * math.pi
    return lam, t_p, a, phi0, s_ini, length
