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

import math

import numpy as np

from loopelastica.rod.kernels.cubic import roots
from loopelastica.rod.kernels.elliptic import (
    agm_scale,
    complete_from_scale,
    incomplete,
    jacobi_from_scale,
    theta_phase,
)
from loopelastica.rod.kernels.jit import kernel

# places in the constants c (25,) of an infinite rod: those of the roots, then w, K, K' and 1 − E/K
Z3, Y3, W2, U2, D23, RATE, QUARTER, QUARTER_C, MISSING = range(9)
# first of the five places of each of A, B, P, and what these hold: σ, b, Z(b), π b/(2KK') and the
# rate beside the one of Θ; last, the number of levels of the scale
A, B, P, LEVELS = 9, 14, 19, 24
SIGN, ZERO, ZETA, DRIFT, EXTRA = range(5)


@kernel
def _angle_constants(sine2, cosine2, m, m1, K, Kc):
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
def constants(lam, t_p, a):
    """Everything about an infinite rod that does not depend on s.

    Parameters
    ----------
    lam, t_p, a
        Constants λ, t_P, a (eq. 9–11).

    Returns
    -------
    c : (25,) array
        Constants at the places that the head of this module names.
    scale : (3, 24) array
        Arithmetic–geometric means for m.
    """
    y1, y3, w1, w2, u1, u2, _, d12, d13, d23 = roots(lam, t_p, a)
    m, m1 = (d23 / d13, d12 / d13) if d13 > 0.0 else (0.0, 1.0)
    scale, levels = agm_scale(m, m1)
    K, missing = complete_from_scale(scale, levels)
    Kc, _ = complete_from_scale(*agm_scale(m1, m))
    c = np.empty(25)
    c[Z3] = y3 - 1.0
    c[Y3], c[W2], c[U2], c[D23] = y3, w2, u2, d23
    c[RATE] = math.sqrt(0.5 * d13)
    c[QUARTER], c[QUARTER_C], c[MISSING] = K, Kc, missing
    c[A + SIGN] = 1.0 if lam + t_p >= 0.0 else -1.0
    c[A + ZERO], c[A + ZETA], c[A + DRIFT] = _angle_constants(d13, y3, m, m1, K, Kc)
    c[A + EXTRA] = 0.5 * (lam + t_p) / y1
    c[B + SIGN] = 1.0 if lam - t_p >= 0.0 else -1.0
    c[B + ZERO], c[B + ZETA], c[B + DRIFT] = _angle_constants(w1, w2, m, m1, K, Kc)
    c[B + EXTRA] = 0.0
    # 2t_P − λa without the cancellation near t_P = λ, a = 2
    c[P + SIGN] = 1.0 if 2.0 * (t_p - lam) - lam * (a - 2.0) >= 0.0 else -1.0
    c[P + ZERO], c[P + ZETA], c[P + DRIFT] = _angle_constants(-u1, u2, m, m1, K, Kc)
    c[P + EXTRA] = 0.5 * lam
    c[LEVELS] = levels
    return c, scale


@kernel
def _turned(modulus2, c, k, s, x, wraps):
    """√modulus2 times the unit number of the angle whose constants begin at c[k]; two floats."""
    real, imaginary = theta_phase(x, c[k + ZERO], c[QUARTER], c[QUARTER_C], k != A)
    sign = c[k + SIGN]
    imaginary *= sign
    size = math.hypot(real, imaginary)
    if size == 0.0:  # the zero itself
        return 0.0, 0.0
    phase = c[k + EXTRA] * s + sign * c[k + ZETA] * x
    if wraps != 0.0:
        phase += sign * (c[k + ZETA] + c[k + DRIFT]) * 2.0 * c[QUARTER] * wraps
    modulus = math.sqrt(modulus2) / size
    cosine = math.cos(phase)
    sine = math.sin(phase)
    return (
        modulus * (real * cosine - imaginary * sine),
        modulus * (real * sine + imaginary * cosine),
    )


@kernel
def rod_at(s, c, scale):
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
    x = c[RATE] * s
    K = c[QUARTER]
    wraps = 0.0
    if math.isfinite(K):
        wraps = float(round(0.5 * x / K))
        x -= 2.0 * K * wraps
    sn, cn, zeta = jacobi_from_scale(x, scale, int(c[LEVELS]))
    if sn * sn < 0.5:
        cn2 = 1.0 - sn * sn
        sn2 = sn * sn
    else:
        cn2 = cn * cn
        sn2 = 1.0 - cn2
    A_re, A_im = _turned(0.5 * (c[Y3] + c[D23] * sn2), c, A, s, x, wraps)
    B_re, B_im = _turned(0.5 * (c[W2] + c[D23] * cn2), c, B, s, x, wraps)
    P_re, P_im = _turned(c[U2] + 2.0 * c[D23] * cn2, c, P, s, x, wraps)
    r_z = c[Z3] * s + 2.0 * c[RATE] * (c[MISSING] * c[RATE] * s - zeta)
    return A_re, A_im, B_re, B_im, P_re, P_im, r_z


@kernel
def landau_pose(s, phi0, spin, c, scale):
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
    psi = 0.5 * math.pi * c[A + SIGN]
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
def landau_moment(x, y, lam):
    """Moment e_k × r + λ e_k in Landau's frame, in units of K0/μ (eq. 12c); the force is e_k."""
    return -y, x, lam


@kernel
def period(lam, t_p, a):
    """Period s_per/μ of ρ(s); infinite where the rod is homoclinic.

    Examples
    --------
    >>> print(f"{period(0.0, 0.0, 0.0):.10f} {period(1.0, 1.0, 2.0)}")
    3.7081493546 inf
    """
    _, _, _, _, _, _, _, d12, d13, d23 = roots(lam, t_p, a)
    if d13 <= 0.0:  # triple root: the straight rod at |λ| = 2, between the two kinds
        return math.inf
    K, _ = complete_from_scale(*agm_scale(d23 / d13, d12 / d13))
    return float(2.0 * K / math.sqrt(0.5 * d13))
