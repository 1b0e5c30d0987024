"""The Hessian of the rod of circular arcs among points: arcs, places of nodes, pairs of nodes.

A node's place is the sum of all chords before it, so that the matrix is dense. It is wanted in the
space where the rod's end stays in place; :mod:`.arc_minimization` has the reflections.
"""

import math

from loopelastica.rod.kernels.arc_rod import add_arcs
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.obstacles import repel_pair


@kernel
def _add_places(own, after, blocks, total, column, hessian):
    """Add to the upper triangle of the Hessian what is due to the places of nodes.

    ``total`` (3, 3) and ``column`` (2, 3, 2) are scratch.
    """
    n = own.shape[0] - 1
    for i in range(3):
        for k in range(3):
            total[i, k] = 0.0
    for j in range(n - 1, 0, -1):
        # the place j moves by ``own``, all after it by ``after``
        for side in range(2):
            for i in range(3):
                column[0, i, side] = column[1, i, side] = 0.0
                for k in range(3):
                    column[0, i, side] += total[i, k] * after[j, k, side]
                    column[1, i, side] += blocks[j, i, k] * own[j, k, side]
        for part in range(2):
            for i in range(1, j + 1):
                _add_block(hessian, own if part == 1 and i == j else after, i, column[part], j)
        for i in range(3):
            for k in range(3):
                total[i, k] += blocks[j, i, k]


@kernel
def _add_block(hessian, rows, i, column, j):
    """Add rowsᵀ column, of tangents ``i`` ≤ ``j``, to the Hessian."""
    for p in range(2):
        for q in range(2):
            for k in range(3):
                hessian[2 * i - 2 + p, 2 * j - 2 + q] += rows[i, k, p] * column[k, q]


@kernel
def _add_pairs(rod, own, after, obstacles, moved, column, hessian):
    """Add what is due to the repulsion between pairs of nodes.

    ``moved`` (n + 1, 3, 2) and ``column`` (3, 2) are scratch.
    """
    nodes, n = rod.points, rod.s.shape[0] - 1
    for k in range(n):
        for m in range(k + 2, n + 1):
            _, p, q = repel_pair(obstacles, rod, k, m)
            if p == 0.0:
                continue
            for j in range(k, m + 1):
                if not 0 < j < n:
                    continue
                for side in range(2):
                    dot = 0.0
                    for i in range(3):
                        # how the gap moves with the tangents from k to m
                        here = own[j, i, side] if j == m else after[j, i, side]
                        moved[j, i, side] = here - own[j, i, side] if j == k else here
                        dot += (nodes[m, i] - nodes[k, i]) * moved[j, i, side]
                    for i in range(3):
                        gap = nodes[m, i] - nodes[k, i]
                        column[i, side] = p * moved[j, i, side] + q * dot * gap
                for i in range(k if k > 0 else 1, j + 1):
                    _add_block(hessian, moved, i, column, j)


@kernel
def assemble(rod, slopes, constraint, blocks, chords, obstacles, moved, w, hessian):
    """The ``hessian`` (m, m) of E − λ·r_n, split by the reflections; its largest diagonal entry.

    ``moved`` (n + 1, 3, 2) and ``w`` (m,) are scratch.
    """
    own, after = slopes.own, slopes.after
    m, largest = hessian.shape[0], 0.0
    for i in range(m):
        for j in range(m):
            hessian[i, j] = 0.0
    add_arcs(rod, chords, slopes.basis, hessian)
    _add_places(own, after, blocks, constraint.upper, moved, hessian)
    if obstacles.density > 0.0:
        # row 0 belongs to a clamp: room for a column
        _add_pairs(rod, own, after, obstacles, moved, own[0], hessian)
    for i in range(m):
        for j in range(i):
            hessian[i, j] = hessian[j, i]
        if not hessian[i, i] ** 2 <= largest:
            largest = hessian[i, i] ** 2
    for r in range(3):
        # (1 − β v vᵀ) H (1 − β v vᵀ) = H − v wᵀ − w vᵀ
        v, beta, dot = constraint.vectors[r], constraint.size[r], 0.0
        for i in range(m):
            w[i] = 0.0
        for j in range(m):
            for i in range(m):
                w[i] += beta * v[j] * hessian[j, i]
        for i in range(m):
            dot += v[i] * w[i]
        for i in range(m):
            w[i] -= 0.5 * beta * dot * v[i]
        for i in range(m):
            for j in range(m):
                hessian[i, j] -= v[i] * w[j] + w[i] * v[j]
    return math.sqrt(largest)
