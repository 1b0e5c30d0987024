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
def repel(square, cutoff):
    """Energy ½(c − d)², p and q at x² = ``square``: gradient p x, Hessian p 1 + q x xᵀ."""
    d = math.sqrt(square + (SOFTENED * cutoff) ** 2)
    if not d < cutoff:
        return 0.0, 0.0, 0.0
    return 0.5 * (cutoff - d) ** 2, 1.0 - cutoff / d, cutoff / d**3


@kernel
def repel_points(obstacles, rod, forces, blocks):
    """Energy of the points, and the sum of their forces' sizes.

    ``forces`` (n + 1, 3) and ``blocks`` (n + 1, 3, 3) become its first and second derivatives by
    the places of the nodes.
    """
    points, first, corner, shape = (
        obstacles.points, obstacles.first, obstacles.corner, obstacles.shape,
    )  # fmt: skip
    nodes, n = rod.points, rod.s.shape[0] - 1
    cutoff, energy, effort = obstacles.cutoff, 0.0, 0.0
    for k in range(n + 1):
        for i in range(3):
            forces[k, i] = 0.0
            for j in range(3):
                blocks[k, i, j] = 0.0
        if not points.shape[0]:
            continue
        weight = obstacles.stiffness * width(rod.s, k)
        a = math.floor((nodes[k, 0] - corner[0]) / obstacles.cell)
        b = math.floor((nodes[k, 1] - corner[1]) / obstacles.cell)
        c = math.floor((nodes[k, 2] - corner[2]) / obstacles.cell)
        low, high = max(c - 1, 0), min(c + 1, shape[2] - 1)
        if low > high:
            continue
        for ia in range(max(a - 1, 0), min(a + 2, shape[0])):
            for ib in range(max(b - 1, 0), min(b + 2, shape[1])):
                row = (ia * shape[1] + ib) * shape[2]
                for at in range(first[row + low], first[row + high + 1]):
                    x = nodes[k, 0] - points[at, 0]
                    y = nodes[k, 1] - points[at, 1]
                    z = nodes[k, 2] - points[at, 2]
                    square = x * x + y * y + z * z
                    if not square < cutoff * cutoff:
                        continue
                    e, p, q = repel(square, cutoff)
                    energy += weight * e
                    p, q = weight * p, weight * q
                    if 0 < k < n:
                        effort += abs(p) * math.sqrt(square)
                    forces[k, 0] += p * x
                    forces[k, 1] += p * y
                    forces[k, 2] += p * z
                    blocks[k, 0, 0] += p + q * x * x
                    blocks[k, 1, 1] += p + q * y * y
                    blocks[k, 2, 2] += p + q * z * z
                    blocks[k, 0, 1] += q * x * y
                    blocks[k, 0, 2] += q * x * z
                    blocks[k, 1, 2] += q * y * z
        blocks[k, 1, 0], blocks[k, 2, 0] = blocks[k, 0, 1], blocks[k, 0, 2]
        blocks[k, 2, 1] = blocks[k, 1, 2]
    return energy, effort


@kernel
def repel_pair(obstacles, rod, k, m):
    """Energy, p and q (`repel`) of two nodes of the rod, with their weights."""
    s, nodes = rod.s, rod.points
    ramp = min((s[m] - s[k]) / obstacles.apart - 1.0, 1.0)
    if not ramp > 0.0:
        return 0.0, 0.0, 0.0
    square = 0.0
    for i in range(3):
        square += (nodes[m, i] - nodes[k, i]) ** 2
    if not square < obstacles.cutoff**2:
        return 0.0, 0.0, 0.0
    weight = obstacles.stiffness * obstacles.density * ramp * width(s, k) * width(s, m)
    e, p, q = repel(square, obstacles.cutoff)
    return weight * e, weight * p, weight * q


@kernel
def repel_itself(obstacles, rod, forces):
    """Energy of the rod's own repulsion and the sum of its forces' sizes; adds to ``forces``."""
    nodes, n = rod.points, rod.s.shape[0] - 1
    energy, effort = 0.0, 0.0
    if not obstacles.density > 0.0:
        return energy, effort
    for k in range(n):
        for m in range(k + 2, n + 1):
            e, p, _ = repel_pair(obstacles, rod, k, m)
            energy += e
            if p != 0.0:
                for i in range(3):
                    gap = nodes[m, i] - nodes[k, i]
                    forces[m, i] += p * gap
                    forces[k, i] -= p * gap
                    effort += abs(p * gap)
    return energy, effort
