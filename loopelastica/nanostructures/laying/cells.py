"""Which points are near others, coarsely: by the cells of a grid that they are in."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array


def beside(points: Array, others: Array, size: float) -> NDArray[np.bool_]:
    """Which points are in a cell of other points or in one beside it.

    Parameters
    ----------
    points, others : (n, 3), (m, 3) array
        Places; no periodic images of them.
    size : float
        Side of the cells: every point that is as near to one of the others is found.

    Returns
    -------
    (n,) array of bool

    Examples
    --------
    >>> beside(np.array([[0.0, 0, 0], [3.5, 0, 0], [9, 0, 0]]), np.array([[1.0, 1, 1]]), 2.0)
    array([ True,  True, False])
    """
    if not len(others):
        return np.zeros(len(points), dtype=bool)
    corner = others.min(axis=0) - size
    cell, near = (np.floor((these - corner) / size) for these in (points, others))
    count = near.max(axis=0) + 2
    inside = ((cell >= 0) & (cell < count)).all(axis=1)
    # cells as single numbers; a grid too fine for them would take more than the memory there is
    stride = np.array([1.0, count[0], count[0] * count[1]])
    steps = np.array(list(itertools.product((-1, 0, 1), repeat=3))) @ stride
    occupied = np.unique(near @ stride)
    wanted = np.unique(occupied[:, None] + steps)
    found = np.zeros(len(points), dtype=bool)
    found[inside] = np.isin(cell[inside] @ stride, wanted)
    return found
