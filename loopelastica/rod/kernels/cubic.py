"""The cubic for t_z, and a_Min, with every difference of its roots accurate by itself.

Source: Ameline, Haliyo, Huang, Cognet, J. Comput. Phys. 373 (2018) 736,
DOI 10.1016/j.jcp.2018.07.021, eq. 9–13 and Figure 2.

The closed form (``closed_form``) needs the roots z1 ≥ 1 ≥ z2 ≥ z3 of
(a − 2z)(1 − z²) − (t_P − λz)².

What accuracy there is to lose lies in differences of the roots (1 + z3, 1 − z2, z1 − 1,
z1 − z2, z2 − z3, u2, …), each of which can be tiny, so the cubic is solved in double-double
arithmetic: the root farther from the middle one by Newton's method, the other two from the
quadratic that is left, so that neither of the double roots (a = a_Min; the homoclinic rod) costs
digits.

Legend: lam, t_p, a the constants λ, t_P, a; y = 1 + z; d12 = z1 − z2 and so on; a name with _h, _l
is the high and low part of a double-double number.
"""

import math

from loopelastica.rod.kernels.jit import kernel

_SPLIT = 134217729.0  # 2**27 + 1: Dekker's splitting of a double into halves


@kernel
def _add(a_h, a_l, b_h, b_l):
    """Sum of two double-double numbers (Knuth's two-sum on both parts)."""
    s = a_h + b_h
    v = s - a_h
    e = (a_h - (s - v)) + (b_h - v)
    t = a_l + b_l
    v = t - a_l
    f = (a_l - (t - v)) + (b_l - v)
    e += t
    h = s + e
    e = f + (e - (h - s))
    s = h + e
    return s, e - (s - h)


@kernel
def _mul(a_h, a_l, b_h, b_l):
    """Product of two double-double numbers (Dekker)."""
    p = a_h * b_h
    t = _SPLIT * a_h
    ah = t - (t - a_h)
    al = a_h - ah
    t = _SPLIT * b_h
    bh = t - (t - b_h)
    bl = b_h - bh
    e = ((ah * bh - p) + ah * bl + al * bh) + al * bl
    e += a_h * b_l + a_l * b_h
    s = p + e
    return s, e - (s - p)


@kernel
def _div(a_h, a_l, b_h, b_l):
    """Quotient of two double-double numbers, b not 0."""
    f = a_h / b_h
    p_h, p_l = _mul(f, 0.0, b_h, b_l)
    rest, _ = _add(a_h, a_l, -p_h, -p_l)
    s = f + rest / b_h
    return s, rest / b_h - (s - f)


@kernel
def _cubic_starts(p, q, r):
    """Roots of y³ − p y² + q y − r, all real, largest first, to about half the digits."""
    spread = max(p * p - 3.0 * q, 0.0) / 9.0
    skew = (-2.0 * p * p * p + 9.0 * p * q - 27.0 * r) / 54.0
    size = math.sqrt(spread)
    scale = size * spread
    angle = math.acos(max(-1.0, min(1.0, skew / scale))) if scale > 0.0 else 0.0
    centre = p / 3.0
    third = 2.0 * math.pi / 3.0
    return (
        centre - 2.0 * size * math.cos(angle / 3.0 + third),
        centre - 2.0 * size * math.cos(angle / 3.0 - third),
        centre - 2.0 * size * math.cos(angle / 3.0),
    )


@kernel
def roots(lam, t_p, a):
    """Roots of the cubic for t_z, as the differences that the closed form needs.

    Each is accurate by itself, however small, at any distance from the double roots.

    Parameters
    ----------
    lam, t_p, a
        Constants λ, t_P, a (eq. 9–11); where a lies below a_Min the double root is taken.

    Returns
    -------
    y1, y3, w1, w2, u1, u2, u3, d12, d13, d23
        1 + z1, 1 + z3, z1 − 1, 1 − z2, the roots u1 ≤ 0 ≤ u2 ≤ u3 in u = a − 2z, z1 − z2, z1 − z3
        and z2 − z3; all but u1 are ≥ 0.
    """
    # Seen from z = −e with e = ±1, y = z + e obeys y³ − p y² + q y − r = 0 where, with A = a + 2e
    # and c = t_P + eλ, p = (A + λ² + 4e)/2, q = eA + cλ, r = c²/2. Where z1 and z2 are the close
    # pair they are close to 1 (a homoclinic rod), so e = −1 makes them small numbers.
    c_plus = lam + t_p
    top, middle, bottom = _cubic_starts(
        0.5 * (a + 6.0 + lam * lam), a + 2.0 + c_plus * lam, 0.5 * c_plus * c_plus
    )
    top_is_single = top - middle > middle - bottom
    e = 1.0 if top_is_single else -1.0
    A_h, A_l = _add(a, 0.0, 2.0 * e, 0.0)
    c_h, c_l = _add(t_p, 0.0, e * lam, 0.0)
    p_h, p_l = _mul(lam, 0.0, lam, 0.0)
    p_h, p_l = _add(p_h, p_l, A_h, A_l)
    p_h, p_l = _add(p_h, p_l, 4.0 * e, 0.0)
    p_h, p_l = 0.5 * p_h, 0.5 * p_l
    q_h, q_l = _mul(c_h, c_l, lam, 0.0)
    q_h, q_l = _add(q_h, q_l, e * A_h, e * A_l)
    r_h, r_l = _mul(c_h, c_l, c_h, c_l)
    r_h, r_l = 0.5 * r_h, 0.5 * r_l

    y_h, y_l = (top if top_is_single else bottom - 2.0), 0.0
    for _ in range(3):  # 1e-8 at worst → 1e-16 → 1e-32
        slope = (3.0 * y_h - 2.0 * p_h) * y_h + q_h
        if slope == 0.0:  # triple root: exact already
            break
        f_h, f_l = _add(y_h, y_l, -p_h, -p_l)
        f_h, f_l = _mul(f_h, f_l, y_h, y_l)
        f_h, f_l = _add(f_h, f_l, q_h, q_l)
        f_h, f_l = _mul(f_h, f_l, y_h, y_l)
        f_h, f_l = _add(f_h, f_l, -r_h, -r_l)
        y_h, y_l = _add(y_h, y_l, -f_h / slope, 0.0)

    # The other two: product r/y, half sum (q − r/y)/(2y), which keeps the digits of small ones.
    s_h, s_l = 0.5 * p_h, 0.5 * p_l
    t_h, t_l = _mul(s_h, s_l, s_h, s_l)
    if y_h != 0.0:  # else a triple root at the straight rod, λ = ±2
        t_h, t_l = _div(r_h, r_l, y_h, y_l)
        s_h, s_l = _add(q_h, q_l, -t_h, -t_l)
        s_h, s_l = _div(0.5 * s_h, 0.5 * s_l, y_h, y_l)
    d_h, d_l = _mul(s_h, s_l, s_h, s_l)
    d_h, d_l = _add(d_h, d_l, -t_h, -t_l)
    g_h, g_l = 0.0, 0.0
    if d_h > 0.0:
        g_h = math.sqrt(d_h)
        t_h, t_l = _mul(g_h, 0.0, g_h, 0.0)
        t_h, t_l = _add(d_h, d_l, -t_h, -t_l)
        g_h, g_l = _add(g_h, 0.0, 0.5 * t_h / g_h, 0.0)
    high_h, high_l = _add(s_h, s_l, g_h, g_l)
    low_h, low_l = _add(s_h, s_l, -g_h, -g_l)
    if top_is_single:
        y1_h, y1_l, y2_h, y2_l, y3_h, y3_l = y_h, y_l, high_h, high_l, low_h, low_l
        d23 = 2.0 * g_h
        d12 = _add(y1_h, y1_l, -y2_h, -y2_l)[0]
    else:
        y1_h, y1_l, y2_h, y2_l, y3_h, y3_l = high_h, high_l, low_h, low_l, y_h, y_l
        d12 = 2.0 * g_h
        d23 = _add(y2_h, y2_l, -y3_h, -y3_l)[0]
    d12, d23 = max(d12, 0.0), max(d23, 0.0)
    return (
        _add(y1_h, y1_l, 1.0 - e, 0.0)[0],
        max(_add(y3_h, y3_l, 1.0 - e, 0.0)[0], 0.0),
        max(_add(y1_h, y1_l, -1.0 - e, 0.0)[0], 0.0),
        max(_add(1.0 + e, 0.0, -y2_h, -y2_l)[0], 0.0),
        min(_add(A_h, A_l, -2.0 * y1_h, -2.0 * y1_l)[0], 0.0),
        max(_add(A_h, A_l, -2.0 * y2_h, -2.0 * y2_l)[0], 0.0),
        max(_add(A_h, A_l, -2.0 * y3_h, -2.0 * y3_l)[0], 0.0),
        d12,
        d12 + d23,
        d23,
    )


@kernel
def a_min(lam, t_p):
    """Least a for which a rod exists: a_Min(λ, t_P), Figure 2 of the paper.

    A rod needs a ≥ h(z) = 2z + (t_P − λz)²/(1 − z²) at some z = t_z in [−1, 1]. In partial
    fractions h = 2z − λ² + α/(1 − z) + β/(1 + z) with α = (t_P − λ)²/2, β = (t_P + λ)²/2 is
    convex, so a_Min is its one minimum, where (1 + z) √(2 + α/(1 − z)²) = √β.

    Parameters
    ----------
    lam, t_p
        Constants λ and t_P, any real numbers.

    Returns
    -------
    float
        a_Min, dimensionless; −2 where t_P = −λ (straight compressed rod).

    Examples
    --------
    >>> print(f"{a_min(0.0, 0.0):.1f} {a_min(1.0, 1.0):.1f} {a_min(0.5, -0.3):.6f}")
    -2.0 1.0 -1.681675
    """
    root_alpha = abs(t_p - lam) / math.sqrt(2.0)
    root_beta = abs(t_p + lam) / math.sqrt(2.0)
    y = root_beta / math.sqrt(2.0)
    if root_alpha == 0.0:
        y = min(y, 2.0)
    else:
        # Both bounds are ≥ the solution; from there Newton's iterates of the convex left side fall.
        y = min(y, 2.0 * root_beta / (root_alpha + root_beta))
        for _ in range(60):
            v = 2.0 - y
            if v <= 0.0 or y <= 0.0:
                break
            ratio = root_alpha / v
            force = math.sqrt(2.0 + ratio * ratio)
            step = (y * force - root_beta) / (force + y * ratio * ratio / (v * force))
            y -= step
            if abs(step) <= 1e-15 * min(y, v):
                break
    y = max(y, 0.0)
    v = 2.0 - y
    if y == 0.0:
        return -2.0
    if v <= 0.0:  # t_P = λ up to rounding: straight rod in tension
        return 2.0
    # t_P − λz from the two small combinations
    numerator = 0.5 * ((t_p - lam) * y + (t_p + lam) * v)
    return 2.0 * (y - 1.0) + numerator * numerator / (y * v)
