"""What the minimization of a rod among obstacles begins with: arcs, their tangents, a grid.

Lengths are in units of the rod's, places relative to its start.
"""

import math

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod._arc_check import Repulsion
from loopelastica.rod.curves import Span
from loopelastica.rod.kernels.obstacles import Obstacles

# arcs by default: so many at least and at most, and no longer than a share of the cutoff
_FEWEST, _MOST, _ARC = 16, 512, 0.28
# the longest arc at the clamp, in widths of the boundary layer of a stretched rod, and how often
# an arc there is halved at most
_IN_LAYER, _HALVED = 0.33, 26
# an arc that turns further than this in a guess begins as a right angle: the minimization needs
# less than half a turn
_SHARP = 2.0
# cells of the grid along an axis
_CELLS = 24


def arc_nodes(span: Span, segments: int | None, cutoff: float) -> Array:
    """Arc lengths (n + 1,) of the nodes: equally far apart, nearer in thin boundary layers.

    Where a rod is nearly stretched it bends only near its ends, over a width w: turning from α
    there takes up 2 w (1 − cos(α/2)) of its length (a planar rod under high tension).
    """
    number = segments
    if number is None:
        number = int(min(max(_FEWEST, math.ceil(1.0 / max(_ARC * cutoff, 1e-9))), _MOST))
    chord = span.chord
    distance = float(np.linalg.norm(chord))
    cosines = [float(t @ chord) / distance for t in (span.start_tangent, span.end_tangent)]
    # 1 − cos(α/2) of both ends
    turned = [1.0 - math.sqrt(max(0.5 * (1.0 + cosine), 0.0)) for cosine in cosines]
    width = 0.5 * (1.0 - distance) / max(sum(turned), 1e-12)
    halved = math.ceil(math.log2(1.0 / (number * _IN_LAYER * max(width, 1e-12))))
    s = np.linspace(0.0, 1.0, number + 1)
    closer = s[1] * 0.5 ** np.arange(min(max(halved, 0), _HALVED), 0, -1)
    return np.concatenate([s[:1], closer, s[1:-1], 1.0 - closer[::-1], s[-1:]])


def node_tangents(points: Array, s: Array, span: Span) -> Array:
    """Unit tangents (n + 1, 3) at the nodes of a curve through ``points`` (k, 3).

    No arc between two of them turns further than `_SHARP`, so that each has a middle.
    """
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    if not 0.0 < along[-1] < math.inf:
        points, along = np.array([span.start, span.end]), np.array([0.0, 1.0])
    half = 0.5 * np.minimum(np.diff(s[:-1]), np.diff(s[1:]))
    ends = [
        np.stack([np.interp(at, along / along[-1], points[:, i]) for i in range(3)], axis=1)
        for at in (s[1:-1] - half, s[1:-1] + half)
    ]
    u = np.vstack([span.start_tangent, ends[1] - ends[0], span.end_tangent])
    size = np.linalg.norm(u, axis=1)
    limit = math.cos(_SHARP)
    for k in range(1, len(u) - 1):
        u[k] = u[k] / size[k] if size[k] > 0.0 else u[k - 1]
        if u[k] @ u[k - 1] < limit:
            u[k] = _aside(u[k], u[k - 1])
    if u[-1] @ u[-2] < limit:
        u[-2] = _aside(u[-2], u[-1])
        if u[-2] @ u[-3] < limit:
            u[-2] = _aside(np.cross(u[-1], u[-3]), u[-1])
    return np.ascontiguousarray(u)


def _aside(u: Array, from_: Array) -> Array:
    """The unit vector at a right angle to ``from_`` that is nearest to ``u``."""
    across = u - (u @ from_) * from_
    if np.linalg.norm(across) < 1e-6:
        across = np.cross(from_, np.eye(3)[np.argmin(np.abs(from_))])
    return np.asarray(across / np.linalg.norm(across))


def bowed(u: Array, angle: float) -> Array:
    """The tangents (n + 1, 3) after a bow: inner ones turned, as by a wave, out of their line."""
    chord = u.sum(axis=0)
    side = _aside(np.eye(3)[np.argmin(np.abs(chord))], chord / max(np.linalg.norm(chord), 1e-300))
    wave = np.sin(np.linspace(0.0, math.tau, len(u)))[1:-1, None]
    moved = u.copy()
    moved[1:-1] += angle * wave * side
    return np.asarray(moved / np.linalg.norm(moved, axis=1, keepdims=True))


def grid_of(chord: Array, repulsion: Repulsion) -> Obstacles:
    """The points in the cells of a grid, of those that the rod could come near at all.

    Each place of the rod is within 1 of both ends together: an ellipsoid.
    """
    points, cutoff = repulsion.points, repulsion.cutoff
    reach = np.linalg.norm(points, axis=1) + np.linalg.norm(points - chord, axis=1)
    points = points[reach <= 1.0 + 2.0 * cutoff]
    corner = points.min(axis=0) if len(points) else np.zeros(3)
    extent = float((points.max(axis=0) - corner).max()) if len(points) else 0.0
    cell = max(cutoff, extent / _CELLS)
    cells = ((points - corner) / cell).astype(np.int64)
    shape = cells.max(axis=0) + 1 if len(points) else np.ones(3, np.int64)
    at = (cells[:, 0] * shape[1] + cells[:, 1]) * shape[2] + cells[:, 2]
    first = np.append(0, np.cumsum(np.bincount(at, minlength=int(shape.prod()))))
    return Obstacles(
        np.ascontiguousarray(points[np.argsort(at, kind="stable")]),
        first.astype(np.int64),
        corner,
        cell,
        shape,
        cutoff,
        repulsion.stiffness,
        repulsion.density,
        repulsion.apart,
    )
