"""Points in a periodic box: vectors between nearest images, and trees of points.

A box is its three sides; a side of 0 does not repeat.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from loopelastica._arrays import Array

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


def nearest_image(vector: Array, box: Array) -> Array:
    """Vectors (..., 3) between points in a periodic box (3,), of the nearest images.

    Examples
    --------
    >>> nearest_image(np.array([9.0, 4.0, 9.0]), np.array([10.0, 10.0, 0.0])).tolist()
    [-1.0, 4.0, 9.0]
    """
    if not (box > 0).any():
        return vector
    return vector - np.round(vector / np.where(box > 0, box, np.inf)) * box


def wrapped(points: Array, box: Array) -> Array:
    """Points (..., 3) inside of a periodic box (3,), as they are asked of its trees.

    Examples
    --------
    >>> wrapped(np.array([-1.0, 14.0, -3.0]), np.array([10.0, 10.0, 0.0])).tolist()
    [9.0, 4.0, -3.0]
    """
    repeats = box > 0
    if not repeats.any():
        return points
    inside = points % np.where(repeats, box, 1.0)
    # a tiny negative number comes out as the side itself
    inside = np.where(inside >= box, 0.0, inside)
    return np.where(repeats, inside, points)


def tree_of(points: Array, box: Array) -> cKDTree:
    """A tree of points (n, 3) in a periodic box (3,).

    Examples
    --------
    >>> tree = tree_of(np.array([[9.5, 5.0, 5.0]]), np.array([10.0, 10.0, 10.0]))
    >>> float(tree.query([0.5, 5.0, 5.0])[0])
    1.0
    """
    from scipy.spatial import cKDTree

    return cKDTree(wrapped(points, box), boxsize=box if (box > 0).any() else None)
