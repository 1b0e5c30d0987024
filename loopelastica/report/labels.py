"""Places for the labels of a picture: beside what they name, on no line and on no other label."""

from typing import Final

import numpy as np

from loopelastica._arrays import Array

# distances from a point to the nearest edge of its label, in heights of a line of text
_GAPS: Final = (0.6, 0.9, 1.4, 2.0, 2.8, 3.8, 5.0, 6.5, 8.0, 10.0)
_ANGLES: Final = np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False)
# costs: a label on another, one on a point of a line, a height of a line of text further away, a
# direction that is not outwards
_ON_LABEL: Final = 1e4
_ON_LINE: Final = 3.0
_AWAY: Final = 1.0
_INWARDS: Final = 1.0


def label_places(
    points: Array, sizes: Array, outwards: Array, obstacles: Array, box: tuple[Array, Array]
) -> Array:
    """Middles of labels, one after the other where they cost least.

    Parameters
    ----------
    points : (n, 2) array
        What is labelled.
    sizes : (n, 2) array
        Widths and heights of the labels.
    outwards : (n, 2) array
        Unit vectors to where a label is best, from its point.
    obstacles : (m, 2) array
        Points that labels should not cover, such as those of lines.
    box : (2,) array, (2,) array
        Lower left and upper right corner of the room for labels.

    Returns
    -------
    (n, 2) array
        In the unit of all the others.
    """
    places = np.empty((len(points), 2))
    rays = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)
    for k, (point, size, out) in enumerate(zip(points, sizes, outwards, strict=True)):
        # from the point to the middle of a label whose edge is a gap away
        edge = (0.5 * size / np.maximum(np.abs(rays), 1e-9)).min(axis=1)
        reach = edge[:, None] + size[1] * np.array(_GAPS)
        tried = point + rays[:, None] * reach[:, :, None]
        cost = _AWAY * np.broadcast_to(_GAPS, reach.shape) + _INWARDS * (1.0 - rays @ out)[:, None]
        inside = (tried - 0.5 * size >= box[0]) & (tried + 0.5 * size <= box[1])
        cost = cost + 10.0 * _ON_LABEL * ~inside.all(axis=2)
        half = 0.5 * size + 0.15 * size[1]
        covered = np.abs(tried[:, :, :1] - obstacles[:, 0]) < half[0]
        covered &= np.abs(tried[:, :, 1:] - obstacles[:, 1]) < half[1]
        cost += _ON_LINE * np.count_nonzero(covered, axis=2)
        near = np.abs(tried[:, :, None] - places[:k]) < 0.5 * (size + sizes[:k]) + 0.05 * size[1]
        cost += _ON_LABEL * near.all(axis=3).sum(axis=2)
        best = np.unravel_index(np.argmin(cost), cost.shape)
        places[k] = tried[best]
    return places
