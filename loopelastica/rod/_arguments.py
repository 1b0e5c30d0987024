"""Arguments that several public functions of the rod take, each checked in one place."""

import numpy as np
from numpy.typing import ArrayLike

from loopelastica._arrays import Array
from loopelastica._checks import array, flag, positive, shown

# points of a rod; their frames then take 7 GB
_MOST = 100_000_000
# beyond, moments leave the range of floating point
_EXTREME = 1e100


def check_torsion_ratio(torsion_ratio: float) -> float:
    """K30 as a float; ValueError unless it is positive and finite, its inverse too."""
    ratio = positive("torsion_ratio", torsion_ratio)
    if not 1.0 / _EXTREME <= ratio <= _EXTREME:
        raise ValueError(f"`torsion_ratio` is {ratio}; it must be from 1e-100 to 1e+100")
    return ratio


def check_flag(name: str, value: bool) -> bool:
    """True or False, for which 1 and 0 may stand; ValueError for anything else."""
    return (
        bool(value)
        if isinstance(value, int | np.integer) and value in (0, 1)
        else flag(name, value)
    )


def check_loads(loads: ArrayLike) -> Array:
    """A copy (6,) of F and M at s = 0; ValueError unless they are six finite numbers."""
    values = array("loads", loads)
    if values.shape != (6,) or not np.isfinite(values).all():
        raise ValueError("`loads` must be six finite numbers, F1 F2 F3 M1 M2 M3")
    return values


def arc_lengths(n: int | ArrayLike, least: int = 1) -> Array:
    """Arc lengths in units of L, as a new array.

    Parameters
    ----------
    n : int or array_like
        Number of points equally spaced in arc length, both ends included, or arc lengths in [0, 1],
        in any order.
    least : int
        The smallest number of points allowed.

    Returns
    -------
    (n,) ndarray

    Raises
    ------
    ValueError
        If `n` is neither.
    """
    if isinstance(n, int | np.integer) and not isinstance(n, bool):
        if n < least:
            raise ValueError(f"`n` is {n}; it must be at least {least}")
        if n > _MOST:
            raise ValueError(f"`n` is {shown(n)}; it must be at most {_MOST}")
        return np.linspace(0.0, 1.0, int(n))
    s = array("n", n)
    if s.ndim != 1:
        raise ValueError("`n` must be a number of points or a one-dimensional array of arc lengths")
    # not (all inside) rather than (any outside): NaN is neither
    if not ((s >= 0.0) & (s <= 1.0)).all():
        raise ValueError("`n` has an arc length outside [0, 1]")
    return s
