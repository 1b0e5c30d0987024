"""Elliptic functions for the closed form of the rod, compiled.

Everything rests on one scale of arithmetic–geometric means. With ``a0 = 1``, ``b0 = √(1 − m)``,
``c0 = √m`` and

    a_{n+1} = (a_n + b_n)/2,   b_{n+1} = √(a_n b_n),   c_{n+1} = (a_n − b_n)/2 = c_n²/(4 a_{n+1}),

the complete integrals are ``K = π/(2 a_N)`` and ``E/K = 1 − Σ 2^{n−1} c_n²``. An amplitude goes up
the scale by ``tan(φ_{n+1} − φ_n) = (b_n/a_n) tan φ_n``, which turns am x into
``φ_N = 2^N a_N x`` (the incomplete integral of the first kind), and down the scale by
``sin(2φ_{n−1} − φ_n) = (c_n/a_n) sin φ_n``, which turns x into am x (the Jacobi functions). On
either way ``Z = Σ_{n≥1} c_n sin φ_n`` is Jacobi's Zeta function. These are the classical formulas
of Gauss and Landen (Abramowitz & Stegun, Handbook of Mathematical Functions, 16.4 and 17.6), with
two changes that keep them accurate near m = 1, where they lose half of the digits as they are
usually written:

- every function takes both m and its complement ``m1 = 1 − m``; a caller that has the
  complement with more digits than ``1 - m`` keeps (1e-16 with all of them) passes it on;
- the arc sine of the descending step is taken as an arc tangent, with
  ``1 − (c/a)² sin²φ = cos²φ + (b/a)² sin²φ`` in place of a difference.

At ``m1 = 0`` the functions are hyperbolic and K is infinite; nothing else has a case of its own.

Theta functions of complex argument x + ib appear only with real x in [−K, K] and b in [0, K'] and
only up to a positive factor (the rod needs their phase). Jacobi's imaginary transformation chooses
the nome q = exp(−πK'/K) or q' = exp(−πK/K'), whichever is smaller, so that four terms suffice
everywhere.

Legend: m parameter (k²), m1 = 1 − m, K and Kc = K' complete integrals for m and m1, scale a
(3, 24) array of a_n, b_n, c_n.
"""

import math

import numpy as np

from loopelastica.rod.kernels.jit import kernel

_LEVELS = 24  # the scale for m1 = 5e-324 takes 15
_CONVERGED = 1e-9  # c_N/a_N: what is left out is of the order of its square


@kernel
def agm_scale(m, m1):
    """Arithmetic–geometric means of 1 and √m1.

    Parameters
    ----------
    m, m1
        Parameter in [0, 1] and its complement 1 − m.

    Returns
    -------
    scale : (3, 24) array
        Rows a_n, b_n, c_n.
    levels : int
        Index N of the last level; 0 where m = 0 or m1 = 0.
    """
    scale = np.zeros((3, _LEVELS))
    scale[0, 0] = 1.0
    scale[1, 0] = math.sqrt(m1)
    scale[2, 0] = math.sqrt(m)
    n = 0
    if m1 > 0.0:
        while scale[2, n] > _CONVERGED * scale[0, n] and n < _LEVELS - 1:
            a = 0.5 * (scale[0, n] + scale[1, n])
            scale[1, n + 1] = math.sqrt(scale[0, n] * scale[1, n])
            scale[2, n + 1] = 0.25 * scale[2, n] * scale[2, n] / a
            scale[0, n + 1] = a
            n += 1
    return scale, n


@kernel
def complete_from_scale(scale, levels):
    """K and 1 − E/K from a scale (3, 24) of so many levels; (inf, 1) where m1 = 0.

    >>> print("{:.12f} {:.12f}".format(*complete_from_scale(*agm_scale(0.5, 0.5))))
    1.854074677301 0.271526709478
    """
    if scale[1, 0] == 0.0:
        return math.inf, 1.0
    rest = 0.0
    power = 1.0
    for n in range(2, levels + 1):
        power *= 2.0
        rest += power * scale[2, n] * scale[2, n]
    missing = 0.5 * scale[2, 0] * scale[2, 0] + rest
    if levels > 0:
        missing += scale[2, 1] * scale[2, 1]
    return 0.5 * math.pi / scale[0, levels], missing


@kernel
def jacobi_from_scale(x, scale, levels):
    """sn, cn and Jacobi's Zeta at x from a scale (3, 24); accurate for |x| ≤ K."""
    if scale[1, 0] == 0.0:
        sn = math.tanh(x)
        return sn, 1.0 / math.cosh(x) if abs(x) < 700.0 else 0.0, sn
    phi = math.ldexp(scale[0, levels] * x, levels)
    zeta = 0.0
    for n in range(levels, 0, -1):
        a = scale[0, n]
        b = scale[1, n]
        c = scale[2, n]
        sine = math.sin(phi)
        cosine = math.cos(phi)
        zeta += c * sine
        phi = 0.5 * (phi + math.atan2(c * sine, math.sqrt((a * cosine) ** 2 + (b * sine) ** 2)))
    return math.sin(phi), math.cos(phi), zeta


@kernel
def incomplete(sine, cosine, m, m1):
    """Incomplete integral of the first kind and Jacobi's Zeta of an amplitude.

    Parameters
    ----------
    sine, cosine
        Sine and cosine of the amplitude, times any common positive factor: where the amplitude is
        near π/2 its cosine carries the digits that the angle itself would lose.
    m, m1
        Parameter in [0, 1] and its complement 1 − m.

    Returns
    -------
    F, Z
        F(φ|m) and Z(F|m) = E(φ|m) − F E/K for φ in (−π, π]; F infinite where m1 = 0 and |φ| = π/2.

    Examples
    --------
    >>> print("{:.12f} {:.12f}".format(*incomplete(1.0, 1.0, 0.5, 0.5)))
    0.826017876249 0.146454543836
    """
    if sine == 0.0 and cosine == 0.0:  # no amplitude at all: take 0
        return 0.0, 0.0
    phi = math.atan2(sine, cosine)
    if m1 == 0.0:
        if cosine <= 0.0:
            return math.copysign(math.inf, sine), math.copysign(1.0, sine)
        return math.asinh(sine / cosine), sine / math.hypot(sine, cosine)
    scale, levels = agm_scale(m, m1)
    zeta = 0.0
    size = math.hypot(sine, cosine)
    sine /= size
    cosine /= size
    for n in range(levels):
        across = scale[1, n] * sine
        along = scale[0, n] * cosine
        step = math.atan2(across, along)
        # the branch of the arc tangent that is continuous in φ
        phi += step + 2.0 * math.pi * round((phi - step) / (2.0 * math.pi))
        # sine and cosine by addition: near π/2 the angle has lost the digits of its cosine
        size = math.hypot(across, along)
        sine, cosine = (
            (sine * along + cosine * across) / size,
            (cosine * along - sine * across) / size,
        )
        zeta += scale[2, n + 1] * sine
    return math.ldexp(phi, -levels) / scale[0, levels], zeta


@kernel
def theta_phase(x, b, K, Kc, shifted):
    """Θ(x + ib) or Θ(x + K + ib), times exp(iπxb/(2KK')), up to a positive factor.

    Θ(x) = θ4(πx/(2K), q) is Jacobi's Theta function. With the exponential factor the value stays
    finite as K goes to infinity, where it is cos(b) cosh(x) + i sin(b) sinh(x), or 1 if shifted.

    Parameters
    ----------
    x
        Real part, in [−K, K].
    b
        Imaginary part, in [0, K'].
    K, Kc
        Complete integrals for m and 1 − m; either may be infinite.
    shifted
        Add K to the argument, which turns θ4 into θ3.

    Returns
    -------
    real, imaginary
        Both 0 at the zero of Θ only.
    """
    if Kc > K:  # θ4 or θ3 by its own nome; q^{n²} cosh and sinh with bounded exponentials
        v = math.pi * x / K  # twice the argument of θ
        y = math.pi * b / K
        half = math.pi * Kc / K  # q = exp(−half)
        real = 1.0
        imaginary = 0.0
        for n in range(1, 5):
            grow = math.exp(n * (y - n * half))
            fall = math.exp(-n * (y + n * half))
            sign = -1.0 if (n % 2 == 1 and not shifted) else 1.0
            real += sign * math.cos(n * v) * (grow + fall)
            imaginary -= sign * math.sin(n * v) * (grow - fall)
        phase = 0.5 * math.pi * x * (b / Kc) / K if math.isfinite(Kc) else 0.0
        cosine = math.cos(phase)
        sine = math.sin(phase)
        return real * cosine - imaginary * sine, real * sine + imaginary * cosine
    # Imaginary transformation: θ4(v|τ) ~ exp(v²/(iπτ)) θ2(v/τ|−1/τ), θ3 ~ θ3; the phase of the
    # Gaussian is the exponential factor, its modulus a positive factor.
    beta = 0.5 * math.pi * b / Kc
    xi = 0.5 * math.pi * abs(x) / Kc
    half = math.pi * K / Kc  # q' = exp(−half)
    real = 1.0 if shifted else 0.0
    imaginary = 0.0
    for n in range(4):
        if shifted:
            k = 2.0 * (n + 1)  # q'^{n²} cosh(2nξ)
            grow = math.exp((n + 1) * (2.0 * xi - (n + 1) * half))
            fall = math.exp(-(n + 1) * (2.0 * xi + (n + 1) * half))
        else:
            k = 2.0 * n + 1.0  # q'^{n(n+1)} cosh((2n+1)ξ), divided by exp(ξ)
            weight = -n * (n + 1) * half if n > 0 else 0.0
            grow = math.exp(weight + 2.0 * n * xi)
            fall = math.exp(weight - 2.0 * (n + 1) * xi)
        real += math.cos(k * beta) * (grow + fall)
        imaginary += math.sin(k * beta) * (grow - fall)
    return real, imaginary if x >= 0.0 else -imaginary
