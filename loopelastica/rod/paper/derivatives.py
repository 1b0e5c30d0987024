"""The error of given loads and its derivatives, as the paper takes them.

Ameline et al., J. Comput. Phys. 373 (2018) 736, DOI 10.1016/j.jcp.2018.07.021, section 3.3: central
differences of second order with one step h = 1e-5 |f| for all six loads; or Ridders' method
(C. J. F. Ridders, Adv. Eng. Softw. 4 (1982) 75; Press et al., Numerical Recipes, section 5.7),
which extrapolates differences of falling step to h = 0. The paper does not print Ridders' first
step; here it is 1e-2 |f|, divided by 1.4 up to nine times (Numerical Recipes' constants).

Legend: f loads (6,), y pose (7,), target (7,) the pose given, e error ε (6,), j Jacobian (6, 6).
"""

import math

import numpy as np

from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.paper.errors import end, error

_STEP = 1e-5  # section 3.3: h = 1e-5 |f|
# Numerical Recipes 5.7, dfridr: divisor of the step, table size, factor of divergence
_RIDDERS_STEP, _CON, _TABLE, _SAFE = 1e-2, 1.4, 10, 2.0


@kernel
def error_at(f, target, kind, torsion_ratio, forward, y, e):
    """Error ``e`` (6,) at the loads ``f`` (6,); False where q2 fails."""
    if not end(f, torsion_ratio, forward, y):
        return False
    error(kind, y, target, e)
    return True


@kernel
def norm(values):
    """Euclidean norm of an array (n,)."""
    total = 0.0
    for c in range(values.shape[0]):
        total += values[c] * values[c]
    return math.sqrt(total)


@kernel
def largest(e):
    """Maximum norm of an array (n,); inf where an entry is not a number."""
    worst = 0.0
    for c in range(e.shape[0]):
        if not abs(e[c]) <= worst:
            worst = abs(e[c]) if e[c] == e[c] else math.inf
    return worst


@kernel
def central_column(f, c, h, target, kind, torsion_ratio, forward, y, trial, out, other):
    """Central difference of the error by the load ``c`` into ``out`` (6,); False if q2 fails."""
    trial[:] = f
    trial[c] = f[c] + h
    if not error_at(trial, target, kind, torsion_ratio, forward, y, out):
        return False
    trial[c] = f[c] - h
    if not error_at(trial, target, kind, torsion_ratio, forward, y, other):
        return False
    for i in range(6):
        out[i] = (out[i] - other[i]) / (2.0 * h)
    return True


@kernel
def central_jacobian(f, target, kind, torsion_ratio, forward, y, j):
    """Second-order central differences with h = 1e-5 |f| (section 3.3) into ``j`` (6, 6)."""
    trial, out, other = np.empty(6), np.empty(6), np.empty(6)
    h = _STEP * norm(f)
    for c in range(6):
        if not central_column(f, c, h, target, kind, torsion_ratio, forward, y, trial, out, other):
            return False
        j[:, c] = out
    return True


@kernel
def ridders_jacobian(f, target, kind, torsion_ratio, forward, y, j):
    """Ridders' derivatives into ``j`` (6, 6): central differences extrapolated to h = 0.

    Each entry keeps its own table and error, and stops by itself; the differences are shared.
    """
    trial, out, other = np.empty(6), np.empty(6), np.empty(6)
    table, before = np.empty((_TABLE, 6)), np.empty((_TABLE, 6))
    best, running = np.empty(6), np.empty(6)
    for c in range(6):
        h = _RIDDERS_STEP * norm(f)
        best[:] = math.inf
        running[:] = 1.0
        for n in range(_TABLE):
            if not central_column(
                f, c, h, target, kind, torsion_ratio, forward, y, trial, out, other
            ):
                return False
            before[:] = table
            table[0] = out
            alive = False
            for i in range(6):
                if running[i] == 0.0:
                    continue
                if n == 0:
                    j[i, c] = out[i]
                factor = _CON * _CON
                for m in range(1, n + 1):
                    table[m, i] = (table[m - 1, i] * factor - before[m - 1, i]) / (factor - 1.0)
                    factor *= _CON * _CON
                    doubt = max(
                        abs(table[m, i] - table[m - 1, i]), abs(table[m, i] - before[m - 1, i])
                    )
                    if doubt <= best[i]:
                        best[i] = doubt
                        j[i, c] = table[m, i]
                if n > 0 and abs(table[n, i] - before[n - 1, i]) >= _SAFE * best[i]:
                    running[i] = 0.0  # higher orders have become worse
                else:
                    alive = True
            if not alive:
                break
            h /= _CON
    return True
