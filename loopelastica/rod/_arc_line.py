"""A smooth curve of circular arcs: places, tangents and twist-free frames along it.

NumPy alone, by the angle along each arc; the kernels of :mod:`.kernels.arc_rod`, which find the
tangents, have chords by another formula.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array


class ArcLine(NamedTuple):
    """A curve of unit length that begins in the origin.

    Attributes
    ----------
    s : (n + 1,) ndarray
        Arc lengths of its nodes, from 0 to 1.
    tangents : (n + 1, 3) ndarray
        Unit tangents there; between two of them lies an arc of a circle.
    """

    s: Array
    tangents: Array

    @property
    def angles(self) -> Array:
        """By how much each arc turns, (n,), rad."""
        u, v = self.tangents[:-1], self.tangents[1:]
        return np.asarray(2.0 * np.arcsin(np.minimum(0.5 * np.linalg.norm(v - u, axis=1), 1.0)))

    def _inward(self) -> Array:
        """Unit vectors (n, 3) from the start of each arc to its centre; zero for a straight one."""
        u, v = self.tangents[:-1], self.tangents[1:]
        inward = (v - u) + (1.0 - np.einsum("ki,ki->k", u, v))[:, None] * u
        size = np.linalg.norm(inward, axis=1, keepdims=True)
        return np.asarray(np.divide(inward, size, out=np.zeros_like(inward), where=size > 1e-15))

    def _arcs(self, s: Array) -> tuple[NDArray[np.intp], Array, Array]:
        """The arc (m,) that each arc length lies on, how far along it and the angle there."""
        arc = np.clip(np.searchsorted(self.s, s, side="right") - 1, 0, len(self.s) - 2)
        along = s - self.s[arc]
        return arc, along, self.angles[arc] * along / np.diff(self.s)[arc]

    def nodes(self) -> Array:
        """Places (n + 1, 3) of the nodes."""
        u, length, angle = self.tangents[:-1], np.diff(self.s)[:, None], self.angles[:, None]
        chords = length * (_sinc(angle) * u + _rise(angle) * self._inward())
        return np.vstack([np.zeros(3), np.cumsum(chords, axis=0)])

    def places(self, s: Array) -> Array:
        """Places (m, 3) at arc lengths (m,)."""
        arc, along, angle = self._arcs(s)
        angle, along = angle[:, None], along[:, None]
        inside = _sinc(angle) * self.tangents[arc] + _rise(angle) * self._inward()[arc]
        return np.asarray(self.nodes()[arc] + along * inside)

    def directions(self, s: Array) -> Array:
        """Unit tangents (m, 3) at arc lengths (m,)."""
        arc, _, angle = self._arcs(s)
        angle = angle[:, None]
        return np.asarray(np.cos(angle) * self.tangents[arc] + np.sin(angle) * self._inward()[arc])

    def curvatures(self, s: Array) -> Array:
        """Curvatures (m,) at arc lengths (m,), those of the arcs."""
        arc = self._arcs(s)[0]
        return np.asarray((self.angles / np.diff(self.s))[arc])

    def frames(self, s: Array, start: Array) -> Array:
        """Frames (m, 3, 3) at arc lengths (m,) that turn with the tangent and nothing else.

        ``start`` (3, 3) is the one at 0, columns d1 d2 d3; d3 is the tangent.
        """
        inward = self._inward()
        axes = np.cross(self.tangents[:-1], inward)
        turns = _turns(axes, self.angles)
        at_nodes = [start]
        for turn in turns[:-1]:
            at_nodes.append(turn @ at_nodes[-1])
        arc, _, angle = self._arcs(s)
        return np.asarray(_turns(axes[arc], angle) @ np.array(at_nodes)[arc])


def _sinc(angle: Array) -> Array:
    """Sine of φ over φ."""
    return np.asarray(np.sinc(angle / np.pi))


def _rise(angle: Array) -> Array:
    """1 − cos φ over φ."""
    return np.asarray(np.sin(0.5 * angle) * np.sinc(0.5 * angle / np.pi))


def _turns(axes: Array, angles: Array) -> Array:
    """Rotations (m, 3, 3) about unit axes (m, 3); the identity where the axis is zero."""
    k = np.zeros((len(axes), 3, 3))
    k[:, 0, 1], k[:, 0, 2], k[:, 1, 2] = -axes[:, 2], axes[:, 1], -axes[:, 0]
    k -= np.swapaxes(k, 1, 2)
    sine, cosine = np.sin(angles)[:, None, None], 1.0 - np.cos(angles)[:, None, None]
    return np.asarray(np.eye(3) + sine * k + cosine * (k @ k))
