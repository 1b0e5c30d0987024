"""How well expected errors hold, and how sharp they are."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np

from loopelastica._arrays import Array

LEAST_A: Final = 0.05
"""Below, a 10 % bound counts as this: by zero nothing can be divided."""

ENOUGH: Final = 8
"""Answers, below which quarters of them say nothing."""


class Coverage(NamedTuple):
    """Expected against true errors of some answers.

    Attributes
    ----------
    cases : float
        Sum of the weights.
    inside, below_10, below_50, below_90 : float
        Shares of errors within the 80 % interval, and below its bounds and its median.
    ratio : float
        Median of the 90 % bound over the 10 % one.
    quarters_A : tuple of float
        Median error in each quarter of the expected medians, the smallest first, Å; empty where
        there are fewer than `ENOUGH` answers.
    """

    cases: float
    inside: float
    below_10: float
    below_50: float
    below_90: float
    ratio: float
    quarters_A: tuple[float, ...]


def coverage(error_A: Array, expected_A: Array, weights: Array) -> Coverage:
    """Coverage and sharpness of expected errors.

    Parameters
    ----------
    error_A : (m,) array
        True errors of one answer at least, Å.
    expected_A : (m, 3) array
        10, 50 and 90 % of what was expected, Å.
    weights : (m,) array
        Such as one over the loops of the same sequence.

    Returns
    -------
    Coverage

    Examples
    --------
    >>> expected = np.array([[0.5, 1.0, 2.0]] * 4)
    >>> coverage(np.array([0.2, 0.8, 1.5, 1.6]), expected, np.ones(4)).inside
    0.75
    """
    low, middle, high = expected_A.T
    total = weights.sum()

    def share(of: Array) -> float:
        return float(weights[of].sum() / total)

    quarters: tuple[float, ...] = ()
    if len(error_A) >= ENOUGH:
        bounds = [-np.inf, *weighted_quantiles(middle, weights, [0.25, 0.5, 0.75]), np.inf]
        among = [(middle > a) & (middle <= b) for a, b in pairwise(bounds)]
        quarters = tuple(
            float(weighted_quantiles(error_A[of], weights[of], [0.5])[0])
            for of in among
            if of.any()
        )
    return Coverage(
        float(total),
        share((error_A >= low) & (error_A <= high)),
        share(error_A < low),
        share(error_A < middle),
        share(error_A < high),
        float(weighted_quantiles(high / np.maximum(low, LEAST_A), weights, [0.5])[0]),
        quarters,
    )


def weighted_quantiles(values: Array, weights: Array, at: Sequence[float]) -> Array:
    """Quantiles (q,) of weighted values (m,), one at least.

    >>> weighted_quantiles(np.array([3.0, 1.0, 2.0]), np.ones(3), [0.5]).tolist()
    [2.0]
    """
    order = np.argsort(values)
    share = np.cumsum(weights[order]) - 0.5 * weights[order]
    return np.asarray(np.interp(at, share / weights.sum(), values[order]))
