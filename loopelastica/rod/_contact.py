"""Where a rod passes through itself or nearly so: whether its winding is an integer, and which.

An ideal rod has no thickness. Where two of its pieces meet, its winding is between two integers;
where they nearly meet, a polygon has to follow both closely to be on the right side.
"""

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from loopelastica._arrays import Array
from loopelastica.rod.clamping import Clamping

# pieces nearer than this, in rod lengths, are one: what a center line is accurate to
_CONTACT = 1e-8
# points along the rod, and in each boundary layer of some widths 1/√F
_POINTS, _LAYER_POINTS, _LAYER_WIDTHS = 401, 81, 12.0
# points about a near approach, ever closer to it
_CLOSER = np.geomspace(1e-6, 2e-3, 12)
_STEPS = 20


class _Rod(Protocol):
    """What is asked of an equilibrium."""

    @property
    def clamping(self) -> Clamping: ...
    @property
    def loads(self) -> Array: ...
    def centerline(self, n: int | ArrayLike) -> Array: ...
    def frames(self, n: int | ArrayLike) -> Array: ...
    def curvature(self, n: int | ArrayLike) -> Array: ...


def winding_points(rod: _Rod) -> Array | None:
    """Arc lengths of a polygon that winds as the rod does.

    Parameters
    ----------
    rod : Equilibrium
        Any that converged.

    Returns
    -------
    (n,) ndarray or None
        In order, both ends included; None where the rod passes through itself.
    """
    width = 1.0 / np.sqrt(max(float(np.linalg.norm(rod.loads[:3])), 1.0))
    layer = np.linspace(0.0, min(_LAYER_WIDTHS * width, 0.5), _LAYER_POINTS)
    s = np.unique(np.concatenate([np.linspace(0.0, 1.0, _POINTS), layer, 1.0 - layer]))
    closer = [s]
    for a, b in _near_pairs(rod, s):
        a, b, distance = _nearest(rod, a, b)
        if distance < _CONTACT:
            return None
        closer += [at + sign * _CLOSER for at in (a, b) for sign in (-1.0, 1.0)]
        closer.append(np.array([a, b]))
    s = np.concatenate(closer)
    s = np.unique(s[(s >= 0.0) & (s <= 1.0)])
    # points that are one to rounding have no direction between them
    apart = np.diff(s) > 1e-9
    return np.asarray(s[np.concatenate([[True], apart])])


def _near_pairs(rod: _Rod, s: Array) -> list[tuple[float, float]]:
    """Pairs of arc lengths where a point of the rod is as near to another as to its neighbors."""
    points = rod.centerline(s)
    gap = np.linalg.norm(points[:, None] - points[None], axis=2)
    along = np.abs(s[:, None] - s[None])
    if rod.clamping.closed:
        along = np.minimum(along, 1.0 - along)
    # within half a turn at its largest curvature the rod cannot come back to itself (Schur)
    half_turn = np.pi / max(float(rod.curvature(s).max()), 1e-9)
    spacing = np.gradient(s)
    near = (gap < 0.75 * (spacing[:, None] + spacing[None])) & (along > half_turn)
    pairs: list[tuple[int, int]] = []
    order = np.argwhere(np.triu(near))
    for i, j in order[np.argsort(gap[order[:, 0], order[:, 1]])]:
        if all(abs(i - k) + abs(j - m) > 6 for k, m in pairs):
            pairs.append((int(i), int(j)))
    return [(float(s[i]), float(s[j])) for i, j in pairs]


def _nearest(rod: _Rod, a: float, b: float) -> tuple[float, float, float]:
    """The places nearest to each other about ``a`` and ``b``, and their distance."""

    def look(a: float, b: float) -> tuple[Array, Array]:
        s = np.array([a, b])
        return np.diff(rod.centerline(s), axis=0)[0], rod.frames(s)[:, :, 2]

    gap, (t, u) = look(a, b)
    for _ in range(_STEPS):
        # both pieces as straight lines along their tangents t and u
        cosine = float(t @ u)
        sine = 1.0 - cosine**2
        if sine < 1e-10:
            break  # side by side: they are as near anywhere
        step = np.array([gap @ t - cosine * (gap @ u), cosine * (gap @ t) - gap @ u]) / sine
        step *= min(1.0, 0.01 / max(float(np.abs(step).max()), 1e-300))
        next_a, next_b = np.clip([a + step[0], b + step[1]], 0.0, 1.0).tolist()
        next_gap, tangents = look(next_a, next_b)
        if not float(next_gap @ next_gap) < float(gap @ gap):
            break
        a, b, gap, (t, u) = next_a, next_b, next_gap, tangents
    return a, b, float(np.linalg.norm(gap))
