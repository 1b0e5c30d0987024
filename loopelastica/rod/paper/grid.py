"""The paper's grid of initial guesses, and the rods it is tested with.

Ameline et al., J. Comput. Phys. 373 (2018) 736, DOI 10.1016/j.jcp.2018.07.021, sections 3.2, 4.2
and 4.3. The grid (eq. 33) holds points p_5D = (λ, t_P, a, s_ini/μ, L/μ) of the region

    |λ|, |t_P| ≤ l,  a_Min(λ, t_P) ≤ a ≤ l²,  0 ≤ s_ini ≤ 0.95 s_per,  0.1 μ ≤ L ≤ s_per   (eq. 40)

in steps of δ from each lower bound, and their images q_5D under the closed form q1. With the
symmetry (eq. 34–35) t_P runs from 0 only, and a rod with φ_R > π is replaced by its mirror image.
Guesses with t_P = 0 have singular Jacobians and take t_P = 1e-3 instead, all else unchanged. The
nearest guess is the one of least |ε1|, a plain difference: the seams of the angles are not mended.

Tested rods (section 4.3) lie δ/2 inside these bounds at distances α δ, α1 = (2l − δ)/((2l + 1) δ)
(eq. 41) or α2 = α1/2, with |Δr|/L < 0.95 (eq. 42), and without λ = t_P = 0.

What the text leaves open: rods of infinite period (on λ = t_P, a = 2) are left out of both. Read
so, the test sets have 4,188, 2,712, 57,740 and 53,864 rods for δ = 2, 1, 0.5 and 0.25 (l = 2),
where the paper counts 3,622, 2,154, 53,170 and 50,946.

A grid is built column by column, a column being one (λ, t_P), on as many threads as there are
cores; `grid` keeps the last few.
"""

from __future__ import annotations

import functools
import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from loopelastica._arrays import Array, read_only
from loopelastica._checks import positive

# in place of t_P = 0 (end of section 4.2)
_NO_TWIST = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Initial guesses and their images (eq. 33).

    Attributes
    ----------
    points : (n, 5) ndarray
        λ, t_P, a, s_ini/μ, L/μ, dimensionless.
    images : (n, 5) ndarray
        η1, η3, ψ_R, θ_R, φ_R: lengths in units of L, angles in radians.
    size : float
        l of eq. 40.
    step : float
        δ.
    symmetry : bool
        Whether eq. 34–35 halve it.
    torsion_ratio : float
        K30 of the images.
    """

    points: Array
    images: Array
    size: float
    step: float
    symmetry: bool
    torsion_ratio: float

    def __len__(self) -> int:
        return len(self.points)

    def nearest(self, q: ArrayLike, count: int = 1) -> NDArray[np.intp]:
        """The guesses of least |ε1| (eq. 30).

        Parameters
        ----------
        q : (5,) array_like
            Clamping parameters η1, η3, ψ_R, θ_R, φ_R.
        count : int
            How many guesses, at most.

        Returns
        -------
        (count,) ndarray
            Indices, nearest first.

        Raises
        ------
        ValueError
            If `q` is not five finite numbers or `count` is not positive.
        """
        target = np.asarray(q, dtype=np.float64)
        if target.shape != (5,) or not np.isfinite(target).all():
            raise ValueError("`q` must be five finite clamping parameters, η1 η3 ψ θ φ")
        if count < 1:
            raise ValueError(f"`count` is {count}; it must be at least 1")
        distance = ((self.images - target) ** 2).sum(axis=1)
        count = min(count, len(distance))
        found = np.argpartition(distance, count - 1)[:count]
        # equal distances in the grid's own order
        return found[np.lexsort((found, distance[found]))]


def spacing(size: float, step: float) -> float:
    """α1 of eq. 41; α2 is half of it.

    Parameters
    ----------
    size, step : float
        l and δ, dimensionless.

    Returns
    -------
    float
        Distance of tested points in units of δ.
    """
    return (2.0 * size - step) / ((2.0 * size + 1.0) * step)


def _ladder(low: float, high: float, step: float) -> Array:
    """low, low + step, … up to high, the latter included but for rounding."""
    rungs = max(math.floor((high - low) / step + 1e-9) + 1, 0)
    return np.asarray(low + step * np.arange(rungs), dtype=np.float64)


def _columns(
    column: Callable[[float, float], Array], pairs: list[tuple[float, float]], workers: int | None
) -> Array:
    """Rows (n, 10) of all columns, on several threads, in the order of ``pairs``."""
    column(*pairs[0])  # compiled before the threads meet
    with ThreadPoolExecutor(workers or os.cpu_count() or 1) as pool:
        return np.vstack(list(pool.map(lambda pair: column(*pair), pairs)))


def build(
    size: float,
    step: float,
    symmetry: bool = True,
    torsion_ratio: float = 1.0,
    workers: int | None = None,
) -> Grid:
    """Compute a grid of initial guesses (eq. 33, 40).

    Parameters
    ----------
    size : float
        l of eq. 40, dimensionless.
    step : float
        δ, dimensionless.
    symmetry : bool
        Use eq. 34–35: t_P from 0, images with φ_R ≤ π.
    torsion_ratio : float
        K30 = K3/K0.
    workers : int, optional
        Threads; by default one for each core.

    Returns
    -------
    Grid

    Raises
    ------
    ValueError
        If a number is not positive and finite.

    Examples
    --------
    >>> len(build(1.0, 1.0))
    210
    """
    from loopelastica.rod.paper import grid_kernels

    for name, value in (("size", size), ("step", step), ("torsion_ratio", torsion_ratio)):
        positive(name, value)
    lams = _ladder(-size, size, step)
    t_ps = _ladder(0.0 if symmetry else -size, size, step)
    pairs = [(float(lam), float(t_p)) for lam in lams for t_p in t_ps]

    def column(lam: float, t_p: float) -> Array:
        rows: Array = grid_kernels.guesses(lam, t_p, size, step, _NO_TWIST, symmetry, torsion_ratio)
        return rows

    rows = _columns(column, pairs, workers)
    return Grid(read_only(rows[:, :5]), read_only(rows[:, 5:]), size, step, symmetry, torsion_ratio)


@functools.lru_cache(maxsize=4)
def grid(size: float, step: float, symmetry: bool = True, torsion_ratio: float = 1.0) -> Grid:
    """The grid of `build`, which keeps the last few in memory.

    Parameters
    ----------
    size, step, symmetry, torsion_ratio
        As for `build`.

    Returns
    -------
    Grid

    Raises
    ------
    ValueError
        If a number is not positive and finite.
    """
    return build(size, step, symmetry, torsion_ratio)


def trial_points(size: float, step: float, spacing: float, workers: int | None = None) -> Array:
    """Physical parameters (n, 5) of the rods the paper tests with (section 4.3).

    Parameters
    ----------
    size, step : float
        l and δ of the grid that is tested.
    spacing : float
        α, the distance of tested points in units of δ (eq. 41).
    workers : int, optional
        As for `build`.

    Returns
    -------
    (n, 5) ndarray
        λ, t_P, a, s_ini/μ, L/μ.

    Raises
    ------
    ValueError
        If a number is not positive and finite.
    """
    from loopelastica.rod.paper import grid_kernels

    for name, value in (("size", size), ("step", step), ("spacing", spacing)):
        positive(name, value)
    margin = 0.5 * step
    side = _ladder(-size + margin, size - margin, spacing * step)
    # the ladder meets 0 up to rounding
    side[np.abs(side) < 1e-9] = 0.0
    pairs = [(float(x), float(y)) for x in side for y in side if x != 0.0 or y != 0.0]

    def column(lam: float, t_p: float) -> Array:
        rows: Array = grid_kernels.trials(lam, t_p, size, margin, spacing * step)
        return rows

    return np.ascontiguousarray(_columns(column, pairs, workers)[:, :5])


def singular_share(points: Array) -> float:
    """Share of the rods (n, 5) on t_P = ±λ, which the paper prints in Fig. 4."""
    return float(np.mean(np.abs(np.abs(points[:, 0]) - np.abs(points[:, 1])) < 1e-9))
