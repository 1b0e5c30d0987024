"""What a rod among obstacles is judged by: its energies and forces by another way of computing.

The minimization (:mod:`.kernels.arc_minimization`) has exact derivatives and a grid of cells. Here
chords come from the angle along each arc and are differentiated numerically, and every node is held
against every point.
"""

from typing import NamedTuple

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod._arc_line import ArcLine
from loopelastica.rod.kernels.obstacles import SOFTENED

# step of the differences: their error is about 1e-10
_STEP = 1e-5
# rad, from where on an arc is stiffer
_SHARP = 2.0
# pairs of a node and a point that are looked at together
_AT_ONCE = 1_000_000
# points whose distance from the line is computed exactly
_CANDIDATES = 3


class Repulsion(NamedTuple):
    """Points that repel a rod; lengths in units of the rod's, places relative to its start."""

    points: Array
    cutoff: float
    stiffness: float
    density: float
    apart: float


class Verdict(NamedTuple):
    """Energies in K0/L and what they miss."""

    bending: float
    contact: float
    own: float
    residual: float
    """The largest of |r_n − r| and the share of all forces that is not balanced."""


def judge(line: ArcLine, goal: Array, repulsion: Repulsion) -> Verdict:
    """Energies and residual of a rod that should end at ``goal`` (3,)."""
    nodes, angles, lengths = line.nodes(), line.angles, np.diff(line.s)
    widths = 0.5 * np.convolve(lengths, [1.0, 1.0])
    contact, forces, effort = _points(nodes, widths, repulsion)
    own, own_forces, own_effort = _itself(line.s, nodes, widths, repulsion)
    forces += own_forces
    # the force on a chord is that on all places after it but the end, which is given
    forces[-1] = 0.0
    on_chords = np.cumsum(forces[:0:-1], axis=0)[::-1]
    gradient, sides = _slopes(line, lengths, on_chords)
    scale = np.sqrt(widths[1:-1])[:, None]
    gradient, sides = gradient[1:-1] / scale, sides[1:-1] / scale[:, :, None]
    flat = sides.reshape(-1, 3)
    # what is left when the best force at the end is taken off
    rest = gradient.ravel() - flat @ np.linalg.lstsq(flat, gradient.ravel(), rcond=None)[0]
    scale_of_all = 1.0 + np.linalg.norm(gradient) + effort + own_effort
    miss = float(np.linalg.norm(nodes[-1] - goal))
    residual = max(miss, float(np.linalg.norm(rest)) / float(scale_of_all))
    bending = float(np.sum(_bending(angles) / lengths))
    return Verdict(bending, contact, own, residual)


def _bending(angles: Array) -> Array:
    """Energies of arcs of unit length: ½ θ², and more where they turn further than 2 rad."""
    past = np.maximum(np.cos(_SHARP) - np.cos(angles), 0.0)
    return np.asarray(0.5 * angles**2 + past**2 / ((1.0 + np.cos(angles)) * (1.0 + np.cos(_SHARP))))


def _strength(square: Array, repulsion: Repulsion) -> tuple[Array, Array]:
    """Energy and the factor of the vector in the force's place, at squared distances."""
    d = np.sqrt(square + (SOFTENED * repulsion.cutoff) ** 2)
    overlap = repulsion.stiffness * np.maximum(repulsion.cutoff - d, 0.0)
    return 0.5 * overlap * np.maximum(repulsion.cutoff - d, 0.0), -overlap / d


def _points(nodes: Array, widths: Array, repulsion: Repulsion) -> tuple[float, Array, float]:
    energy, effort, forces = 0.0, 0.0, np.zeros_like(nodes)
    chunk = max(1, _AT_ONCE // len(nodes))
    for begin in range(0, len(repulsion.points), chunk):
        gaps = nodes[:, None] - repulsion.points[None, begin : begin + chunk]
        square = np.einsum("kmi,kmi->km", gaps, gaps)
        node, point = np.nonzero(square < repulsion.cutoff**2)
        gaps, square = gaps[node, point], square[node, point]
        each, slope = _strength(square, repulsion)
        slope *= widths[node]
        energy += float(np.sum(widths[node] * each))
        np.add.at(forces, node, slope[:, None] * gaps)
        inner = (node > 0) & (node < len(nodes) - 1)
        effort += float(np.sum(np.abs(slope) * np.sqrt(square) * inner))
    return energy, forces, effort


def _itself(
    s: Array, nodes: Array, widths: Array, repulsion: Repulsion
) -> tuple[float, Array, float]:
    forces = np.zeros_like(nodes)
    if not repulsion.density > 0.0:
        return 0.0, forces, 0.0
    a, b = np.triu_indices(len(s), 2)
    gaps = nodes[b] - nodes[a]
    ramp = np.clip((s[b] - s[a]) / repulsion.apart - 1.0, 0.0, 1.0)
    weight = repulsion.density * ramp * widths[a] * widths[b]
    each, slope = _strength(np.einsum("ki,ki->k", gaps, gaps), repulsion)
    push = (weight * slope)[:, None] * gaps
    np.add.at(forces, b, push)
    np.add.at(forces, a, -push)
    return float(np.sum(weight * each)), forces, float(np.sum(np.linalg.norm(push, axis=1)))


def _slopes(line: ArcLine, lengths: Array, on_chords: Array) -> tuple[Array, Array]:
    """Derivatives by tangents across them: (n + 1, 2) of the energy, (n + 1, 2, 3) of the end."""
    u = line.tangents
    least = np.eye(3)[np.argmin(np.abs(u), axis=1)]
    first = np.cross(u, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    across = np.stack([first, np.cross(u, first)], axis=1)
    gradient, sides = np.zeros((len(u), 2)), np.zeros((len(u), 2, 3))
    for side in range(2):
        for sign in (1.0, -1.0):
            moved = u + sign * _STEP * across[:, side]
            moved /= np.linalg.norm(moved, axis=1, keepdims=True)
            for start, end, at in (
                (moved[:-1], u[1:], slice(None, -1)),
                (u[:-1], moved[1:], slice(1, None)),
            ):
                angle = 2.0 * np.arcsin(np.minimum(0.5 * np.linalg.norm(end - start, axis=1), 1.0))
                # a chord: 2 sin(θ/2) over the curvature, halfway between both tangents
                middle = start + end
                middle /= np.linalg.norm(middle, axis=1, keepdims=True)
                chord = (lengths * np.sinc(0.5 * angle / np.pi))[:, None] * middle
                bending = _bending(angle) / lengths
                weight = sign / (2.0 * _STEP)
                gradient[at, side] += weight * (bending + np.einsum("ki,ki->k", on_chords, chord))
                sides[at, side] += weight * chord
    return gradient, sides


def nearest_point(line: ArcLine, points: Array) -> tuple[int, float]:
    """Which of the points (m, 3), one or more, is nearest to the line, and at what distance."""
    # four places on each arc tell which ones may be; then one looks closer
    n = len(line.s) - 1
    s = np.interp(np.arange(4 * n + 1) / 4.0, np.arange(n + 1), line.s)
    places, best = line.places(s), np.empty(len(points))
    where = np.empty(len(points), np.int64)
    chunk = max(1, _AT_ONCE // len(s))
    for begin in range(0, len(points), chunk):
        gaps = points[begin : begin + chunk, None] - places
        square = np.einsum("mki,mki->mk", gaps, gaps)
        where[begin : begin + chunk] = square.argmin(axis=1)
        best[begin : begin + chunk] = np.sqrt(square.min(axis=1))
    order = np.argsort(best, kind="stable")[:_CANDIDATES]
    found = [_distance(line, points[i], s, int(where[i])) for i in order]
    nearest = int(np.argmin(found))
    return int(order[nearest]), found[nearest]


def _distance(line: ArcLine, point: Array, s: Array, near: int) -> float:
    """Least distance of a point from the line about the place ``near`` of ``s``."""
    low, high = s[max(near - 1, 0)], s[min(near + 1, len(s) - 1)]
    for _ in range(4):
        closer = np.linspace(low, high, 17)
        distances = np.linalg.norm(line.places(closer) - point, axis=1)
        at = int(distances.argmin())
        low, high = closer[max(at - 1, 0)], closer[min(at + 1, 16)]
    return float(distances[at])
