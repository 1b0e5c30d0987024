"""The rod from its loads by the method of Bulirsch and Stoer: the paper's numerical q2.

End of section 2.4 of Ameline et al., J. Comput. Phys. 373 (2018) 736,
DOI 10.1016/j.jcp.2018.07.021: where |t_P ± λ| < 1e-2 equations (1)–(4) are integrated "using the
Bulirsch-Stoer method with Richardson's extrapolation". The equations are those of
:mod:`loopelastica.rod.kernels.shooting`, for position and quaternion, with K30 = 1; any other K30
turns the end frame about its tangent.

One step of length h (Stoer & Bulirsch, Introduction to Numerical Analysis, section 7.2.14; Hairer,
Nørsett & Wanner, Solving ODE I, section II.9):

1. Gragg's modified midpoint rule crosses h with n_k = 2, 4, 6, … substeps,

       y_1 = y_0 + g f(y_0),   y_{i+1} = y_{i−1} + 2 g f(y_i),   S = ½ (y_n + y_{n−1} + g f(y_n)),

   g = h/n_k, whose error has even powers of g only.
2. Aitken and Neville's table extrapolates these values as a polynomial in g² to g = 0:
   T_{k,j} = T_{k,j−1} + (T_{k,j−1} − T_{k−1,j−1})/((n_k/n_{k−j})² − 1). The difference of its last
   two columns is the error estimate, relative to rtol (1 + |y|).
3. Order and step are adaptive (Deuflhard's control): from the error in row k follows the step h_k
   that this order could have taken and its work per unit length, A_k/h_k, A_k the number of slopes
   up to row k. A step is accepted in the window k ∈ {target − 1, target, target + 1}; the next
   target is the row with the least work. A step that fails is tried again, shorter.

Legend: f loads, y state (r, q), table the extrapolation table without its most extrapolated value,
which is ``best``, order the target row.
"""

import math

import numpy as np

from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.rotations import spin
from loopelastica.rod.kernels.shooting import POSE, moment_bound, slope

_ROWS = 9
_SUBSTEPS = 2 * np.arange(1, _ROWS + 1)
# A_k, slopes up to row k; the one at the start is shared
_WORK = 1.0 + np.cumsum(_SUBSTEPS)
# safety factors and bounds of the step control: Hairer, Nørsett & Wanner, ODEX
_SAFE_STEP, _SAFE_ERROR = 0.94, 0.65
_SHRINK, _GROW = 0.1, 4.0
# loads beyond have no use in double precision: errors grow like exp(√F)
_LARGEST = 1e4
_MAX_STEPS = 20_000


@kernel
def midpoint(f, y, k0, h, n, out, a, b, k):
    """Gragg's modified midpoint rule over ``h`` with ``n`` substeps, into ``out`` (7,).

    ``f`` (6,) are the loads, ``k0`` (7,) is the slope at ``y`` (7,); ``a``, ``b`` and ``k`` (7,)
    are scratch.
    """
    g = h / n
    for c in range(POSE):
        a[c] = y[c]
        b[c] = y[c] + g * k0[c]
    for _ in range(1, n):
        slope(f, b, k, 0, POSE)
        for c in range(POSE):
            a[c], b[c] = b[c], a[c] + 2.0 * g * k[c]
    slope(f, b, k, 0, POSE)
    for c in range(POSE):
        out[c] = 0.5 * (b[c] + a[c] + g * k[c])


@kernel
def extrapolate(row, table, best):
    """Aitken and Neville's table of row ``row``, whose midpoint value lies in ``table[row - 1]``.

    On return ``best`` (7,) is the most extrapolated value and ``table[0]`` the one before it;
    ``table`` is (9, 7).
    """
    for j in range(row - 1, 0, -1):
        ratio = _SUBSTEPS[row] / _SUBSTEPS[j]
        factor = 1.0 / (ratio * ratio - 1.0)
        for c in range(POSE):
            table[j - 1, c] = table[j, c] + factor * (table[j, c] - table[j - 1, c])
    ratio = _SUBSTEPS[row] / _SUBSTEPS[0]
    factor = 1.0 / (ratio * ratio - 1.0)
    for c in range(POSE):
        best[c] = table[0, c] + factor * (table[0, c] - best[c])


@kernel
def _attempt(f, y, k0, h, order, rtol, best, table, steps, work, a, b, k):
    """Rows of one step until it is accepted or given up: (accepted, row, slopes).

    Arrays as in `integrate`; ``steps`` and ``work`` (9,) receive h_k and A_k/h_k.
    """
    slopes = 0
    for row in range(order + 2):
        n = _SUBSTEPS[row]
        slopes += n
        if row == 0:
            midpoint(f, y, k0, h, n, best, a, b, k)
            continue
        midpoint(f, y, k0, h, n, table[row - 1], a, b, k)
        extrapolate(row, table, best)
        error = 0.0
        for c in range(POSE):
            error = max(error, abs(best[c] - table[0, c]) / (rtol * (1.0 + abs(y[c]))))
        if not error < 1e30:  # not a number as well
            steps[row] = _SHRINK * h
            return False, row, slopes
        change = _SAFE_STEP * (_SAFE_ERROR / max(error, 1e-30)) ** (1.0 / (2 * row + 1))
        steps[row] = h * min(max(change, _SHRINK), _GROW)
        work[row] = _WORK[row] / steps[row]
        if row < order - 1:
            continue
        if error <= 1.0:
            return True, row, slopes
        # would the rows left bring the error down to 1? each divides it by about (n/n_0)²
        hope = 1.0
        for j in range(row + 1, order + 2):
            hope *= (_SUBSTEPS[j] / _SUBSTEPS[0]) ** 2
        if error > hope:
            return False, row, slopes
    return False, order + 1, slopes


@kernel
def _next_order(row, steps, work):
    """Target row and step after a step accepted in ``row``: the neighbour of least work.

    ``steps`` and ``work`` (9,) are those of `_attempt`.
    """
    order, step = row, steps[row]
    if row > 1 and work[row - 1] < 0.8 * work[row]:
        order, step = row - 1, steps[row - 1]
    elif row > 1 and work[row] < 0.9 * work[row - 1] and row < _ROWS - 2:
        # one row more: its step is foreseen by the same work per slope
        order, step = row + 1, steps[row] * _WORK[row + 1] / _WORK[row]
    return min(max(order, 2), _ROWS - 2), step


@kernel
def integrate(f, length, rtol, y):
    """Carry the state ``y`` (7,) along the rod, in place.

    Parameters
    ----------
    f : (6,) array
        Loads in the start frame, L = K0 = 1.
    length
        Arc length to cross.
    rtol
        Error allowed in one step, relative to 1 + |y|.
    y : (7,) array
        Position and unit quaternion.

    Returns
    -------
    int
        Number of slopes evaluated; −1 where the loads are too large to be integrated.
    """
    table, best = np.empty((_ROWS, POSE)), np.empty(POSE)
    k0, a, b, k = np.empty(POSE), np.empty(POSE), np.empty(POSE), np.empty(POSE)
    work, steps = np.empty(_ROWS), np.empty(_ROWS)
    bound = moment_bound(f)
    if not bound < _LARGEST:
        return -1
    at = 0.0
    order = 5
    # about one radian of turning
    h = min(length, 1.0 / max(bound, 1e-3))
    slopes = 1
    slope(f, y, k0, 0, POSE)
    for _ in range(_MAX_STEPS):
        last = at + h >= length
        if last:
            h = length - at
        accepted, row, count = _attempt(f, y, k0, h, order, rtol, best, table, steps, work, a, b, k)
        slopes += count
        if not accepted:
            order = min(max(row, 2), order)
            h = min(steps[row], 0.7 * h)
            continue
        norm = 0.0
        for c in range(3, POSE):
            norm += best[c] * best[c]
        norm = 1.0 / math.sqrt(norm)
        for c in range(POSE):
            y[c] = best[c] if c < 3 else best[c] * norm
        if last:
            return slopes
        at += h
        slope(f, y, k0, 0, POSE)
        slopes += 1
        order, h = _next_order(row, steps, work)
    return -1


@kernel
def end_pose(f, torsion_ratio, rtol, y):
    """Pose of the end of the rod with loads ``f`` (6,) into ``y`` (7,); returns as `integrate`."""
    for c in range(POSE):
        y[c] = 0.0
    y[3] = 1.0
    count = integrate(f, 1.0, rtol, y)
    if torsion_ratio != 1.0:
        spin(y[3:POSE], f[5] * (1.0 / torsion_ratio - 1.0))
    return count
