"""Soft repulsion between a rod and points around it, and between parts of the rod.

A point at the distance d of the line stores ½ k (c − d)² per length of line for d below the cutoff
c. The integral over the rod is a sum over its nodes. Two parts of the rod repel each other in the
same way where they are far apart along it: the line itself counts as so many points per length.

d is √(x² + ε²) with a small ε, so that a point on the line is no singularity. Points lie in cells
of a grid that are not smaller than the cutoff; those of a row of cells follow each other.
"""

import math
from typing import Any, NamedTuple

from loopelastica._arrays import Array
from loopelastica.rod.kernels.arc_rod import width
from loopelastica.rod.kernels.jit import kernel

# ε over c
SOFTENED = 0.01


class Obstacles(NamedTuple):
    """Points in the cells of a grid, and how strongly they repel; lengths in units of the rod's."""

    points: Array
    """(m, 3), sorted by cell; relative to the rod's start."""
    first: Any
    """(cells + 1,): the first point of each cell, z running fastest."""
    corner: Array
    """(3,): where the grid begins."""
    cell: float
    shape: Any
    """(3,): cells along each axis."""
    cutoff: float
    stiffness: float
    density: float
    """Points per length that the rod itself counts as; 0 for none."""
    apart: float
    """Parts of the rod repel each other from this length of rod between them on, fully from
    twice that."""


@kernel
def strength(square, cutoff):
    """Energy ½(c − d)², p and q at x² = ``square``: gradient p x, Hessian p 1 + q x xᵀ."""
    d = math.sqrt(square + (SOFTENED * cutoff) ** 2)
    if not d < cutoff:
        return 0.0, 0.0, 0.0
    return 0.5 * (cutoff - d) ** 2, 1.0 - cutoff / d, cutoff / d**3


@kernel
def cells_about(obstacles, x, axis):
    """Range of cells along an axis that may hold a point near the coordinate ``x``."""
    at = math.floor((x - obstacles.corner[axis]) / obstacles.cell)
    high = at + 2 if at + 2 < obstacles.shape[axis] else obstacles.shape[axis]
    return at - 1 if at > 1 else 0, high


@kernel
def repel(obstacles, rod, forces, blocks):
    """Energy of all repulsion, and the sum of the forces' sizes.

    ``forces`` (n + 1, 3) become its derivatives by the places of the nodes, ``blocks``
    (n + 1, 3, 3) the second ones of what the obstacles contribute.
    """
    points, first, shape = obstacles.points, obstacles.first, obstacles.shape
    nodes, n = rod.points, rod.s.shape[0] - 1
    cutoff, energy, effort = obstacles.cutoff, 0.0, 0.0
    for k in range(n + 1):
        for i in range(3):
            forces[k, i] = 0.0
            for j in range(3):
                blocks[k, i, j] = 0.0
    for k in range(n + 1):
        weight = obstacles.stiffness * width(rod.s, k)
        # the cells of the node and those beside it; one row of them is one range of points
        low_a, high_a = cells_about(obstacles, nodes[k, 0], 0)
        low_b, high_b = cells_about(obstacles, nodes[k, 1], 1)
        low_c, high_c = cells_about(obstacles, nodes[k, 2], 2)
        for a in range(low_a, high_a):
            for b in range(low_b, high_b if low_c < high_c else low_b):
                row = (a * shape[1] + b) * shape[2]
                for at in range(first[row + low_c], first[row + high_c]):
                    x = nodes[k, 0] - points[at, 0]
                    y = nodes[k, 1] - points[at, 1]
                    z = nodes[k, 2] - points[at, 2]
                    square = x * x + y * y + z * z
                    if square < cutoff * cutoff:
                        e, p, q = strength(square, cutoff)
                        energy += weight * e
                        if 0 < k < n:
                            effort -= weight * p * math.sqrt(square)
                        for i in range(3):
                            gap = weight * (nodes[k, i] - points[at, i])
                            forces[k, i] += p * gap
                            blocks[k, i, i] += p * weight
                            for j in range(3):
                                blocks[k, i, j] += q * gap * (nodes[k, j] - points[at, j])
        if obstacles.density > 0.0:
            for m in range(k + 2, n + 1):
                e, p, _ = repel_pair(obstacles, rod, k, m)
                energy += e
                for i in range(3):
                    gap = p * (nodes[m, i] - nodes[k, i])
                    forces[m, i] += gap
                    forces[k, i] -= gap
                    effort += abs(gap)
    return energy, effort


@kernel
def repel_pair(obstacles, rod, k, m):
    """Energy, p and q (`strength`) of the nodes k < m of the rod, with their weights."""
    s, nodes, cutoff = rod.s, rod.points, obstacles.cutoff
    ramp, square = (s[m] - s[k]) / obstacles.apart - 1.0, 0.0
    for i in range(3):
        square += (nodes[m, i] - nodes[k, i]) ** 2
    if not (ramp > 0.0 and square < cutoff * cutoff):
        return 0.0, 0.0, 0.0
    weight = obstacles.stiffness * obstacles.density * width(s, k) * width(s, m)
    if ramp < 1.0:
        weight *= ramp
    e, p, q = strength(square, cutoff)
    return weight * e, weight * p, weight * q
