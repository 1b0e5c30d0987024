"""The end of a rod to fifty digits: Taylor series in mpmath, sharing nothing with the solvers.

With L = K0 = K30 = 1 position r and unit quaternion q = (w, x, y, z) obey r' = t(q) and
q' = ½ (0, M) q, M = M0 + F × r. All is polynomial, so the Taylor coefficients at a point follow
from each other by Cauchy products (Moore, Interval Analysis, chapter 11). The step is where the
last two coefficients have faded to rounding (Jorba & Zou, Exp. Math. 14 (2005) 99).
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from loopelastica.errors import MissingDependencyError

DIGITS = 50
# beyond the digits requested: some hundred steps, each with errors that the rod magnifies
_GUARD = 15


def _series(pose: Sequence[Any], f: Sequence[Any], order: int, dot: Any, half: Any) -> list[Any]:
    """Taylor coefficients 0 to ``order`` of the seven components of a pose."""
    rx, ry, rz, w, x, y, z = series = [[value] for value in pose]
    fx, fy, fz, *m0 = f
    mx: list[Any] = []
    my: list[Any] = []
    mz: list[Any] = []
    for n in range(order):
        mx.append(fy * rz[n] - fz * ry[n])
        my.append(fz * rx[n] - fx * rz[n])
        mz.append(fx * ry[n] - fy * rx[n])
        if n == 0:
            mx[0], my[0], mz[0] = mx[0] + m0[0], my[0] + m0[1], mz[0] + m0[2]
        u, v, s, t = w[::-1], x[::-1], y[::-1], z[::-1]
        over = half / (n + 1)
        slopes = (
            4 * (dot(x, t) + dot(w, s)),
            4 * (dot(y, t) - dot(w, v)),
            2 * (dot(w, u) + dot(z, t) - dot(x, v) - dot(y, s)),
            -dot(mx, v) - dot(my, s) - dot(mz, t),
            dot(mx, u) + dot(my, t) - dot(mz, s),
            dot(my, u) + dot(mz, v) - dot(mx, t),
            dot(mz, u) + dot(mx, s) - dot(my, v),
        )
        for component, slope in zip(series, slopes, strict=True):
            component.append(slope * over)
    return series


def end_pose(loads: ArrayLike, digits: int = DIGITS) -> list[Any]:
    """The end of a rod to many digits.

    Parameters
    ----------
    loads : (6,) array_like
        F and M at s = 0, in K0/L² and K0/L; the exact values of these doubles.
    digits : int
        Decimal digits of the result.

    Returns
    -------
    list of 7 mpmath numbers
        Position and quaternion.

    Raises
    ------
    MissingDependencyError
        If mpmath is not installed.
    """
    try:
        import mpmath
    except ImportError:
        raise MissingDependencyError(
            "`mpmath` is not installed; it computes the reference of this report. Install it with"
            " pip install mpmath"
        ) from None
    ctx = mpmath.mp.clone()
    ctx.dps = digits + _GUARD
    f = [ctx.mpf(v) for v in np.asarray(loads, dtype=np.float64).tolist()]
    pose = [ctx.mpf(c) for c in (0, 0, 0, 1, 0, 0, 0)]
    order = int(1.2 * ctx.dps)
    at, half = ctx.mpf(0), ctx.mpf(1) / 2
    while at < 1:
        series = _series(pose, f, order, ctx.fdot, half)
        h = 1 - at
        for n in (order - 1, order):
            last = max(abs(component[n]) for component in series)
            if last:
                h = min(h, (ctx.eps / last) ** (ctx.mpf(1) / n))
        powers = [h**n for n in range(order + 1)]
        pose = [ctx.fdot(component, powers) for component in series]
        at += h
    return pose


def difference(pose: NDArray[np.float64], reference: Sequence[Any]) -> float:
    """Largest component of position and quaternion (of either sign) off the reference.

    Parameters
    ----------
    pose : (7,) ndarray
        Position and quaternion.
    reference : sequence of 7 numbers
        As of `end_pose`.

    Returns
    -------
    float
    """

    def away(sign: float) -> float:
        position = [abs(a - b) for a, b in zip(pose[:3], reference[:3], strict=True)]
        turned = [abs(sign * a - b) for a, b in zip(pose[3:], reference[3:], strict=True)]
        return float(max(position + turned))

    return min(away(1.0), away(-1.0))
