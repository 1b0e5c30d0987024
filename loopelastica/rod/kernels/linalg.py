"""Small dense linear algebra in compiled code: two eliminations, and symmetric 3×3 blocks.

Systems are augmented arrays (rows, unknowns + right-hand sides), eliminated in place.
"""

import numpy as np

from loopelastica.rod.kernels.jit import kernel


@kernel
def eliminate(a, rows, pivots, columns, least):
    """Forward elimination of the first ``pivots`` columns of ``a`` by partial pivoting, in place.

    Of ``a`` the leading (rows, columns) count. Returns the sign of the permutation of the rows, 0
    if a pivot is not larger than ``least``.
    """
    sign = 1.0
    for p in range(pivots):
        best = p
        for i in range(p + 1, rows):
            if abs(a[i, p]) > abs(a[best, p]):
                best = i
        if best != p:
            sign = -sign
            for j in range(p, columns):
                a[p, j], a[best, j] = a[best, j], a[p, j]
        pivot = a[p, p]
        if not abs(pivot) > least:
            return 0.0
        for i in range(p + 1, rows):
            factor = a[i, p] / pivot
            if factor != 0.0:
                for j in range(p + 1, columns):
                    a[i, j] -= factor * a[p, j]
    return sign


@kernel
def solve_deficient(a, rows, unknowns, sides, drop, x):
    """Solve the consistent system ``a`` (rows, unknowns + sides) by complete pivoting, in place.

    Directions whose pivots are below ``drop`` times the first one stay put. ``x`` (sides, unknowns)
    becomes the solutions. Returns the rank.
    """
    order = np.empty(unknowns, np.int64)
    for j in range(unknowns):
        order[j] = j
    columns, rank, first = unknowns + sides, unknowns, 0.0
    for p in range(unknowns):
        best, bi, bj = -1.0, p, p
        for i in range(p, rows):
            for j in range(p, unknowns):
                if abs(a[i, j]) > best:
                    best, bi, bj = abs(a[i, j]), i, j
        if p == 0:
            first = best
        if not best > drop * first:
            rank = p
            break
        if bi != p:
            for j in range(columns):
                a[p, j], a[bi, j] = a[bi, j], a[p, j]
        if bj != p:
            for i in range(rows):
                a[i, p], a[i, bj] = a[i, bj], a[i, p]
            order[p], order[bj] = order[bj], order[p]
        for i in range(p + 1, rows):
            factor = a[i, p] / a[p, p]
            for j in range(p, columns):
                a[i, j] -= factor * a[p, j]
    for side in range(sides):
        for j in range(unknowns):
            x[side, j] = 0.0
        for i in range(rank - 1, -1, -1):
            total = a[i, unknowns + side]
            for j in range(i + 1, rank):
                total -= a[i, j] * x[side, order[j]]
            x[side, order[i]] = total / a[i, i]
    return rank


@kernel
def negative_eigenvalues(a, shift):
    """Negative eigenvalues of the symmetric 3×3 ``a`` + shift·1, and its determinant."""
    a00, a11, a22 = a[0, 0] + shift, a[1, 1] + shift, a[2, 2] + shift
    minor = a00 * a11 - a[0, 1] * a[1, 0]
    det = (
        a22 * minor
        - a[1, 2] * (a00 * a[2, 1] - a[0, 1] * a[2, 0])
        + a[0, 2] * (a[1, 0] * a[2, 1] - a11 * a[2, 0])
    )
    count = 0
    if a00 < 0.0:
        count += 1
    if minor * a00 < 0.0:
        count += 1
    if det * minor < 0.0:
        count += 1
    return count, det


@kernel
def inverse3(a, out):
    """Inverse of a symmetric 3×3 array."""
    c00 = a[1, 1] * a[2, 2] - a[1, 2] * a[1, 2]
    c01 = a[0, 2] * a[1, 2] - a[0, 1] * a[2, 2]
    c02 = a[0, 1] * a[1, 2] - a[0, 2] * a[1, 1]
    det = a[0, 0] * c00 + a[0, 1] * c01 + a[0, 2] * c02
    if abs(det) < 1e-300:
        det = 1e-300
    r = 1.0 / det
    out[0, 0], out[0, 1], out[0, 2] = r * c00, r * c01, r * c02
    out[1, 0], out[1, 1] = r * c01, r * (a[0, 0] * a[2, 2] - a[0, 2] * a[0, 2])
    out[1, 2] = r * (a[0, 1] * a[0, 2] - a[0, 0] * a[1, 2])
    out[2, 0], out[2, 1] = r * c02, out[1, 2]
    out[2, 2] = r * (a[0, 0] * a[1, 1] - a[0, 1] * a[0, 1])


@kernel
def copy(source, target):
    """Copy a row to the start of another; a slice would have numba compile its error message."""
    for i in range(source.shape[0]):
        target[i] = source[i]


@kernel
def copy_rows(source, target):
    """Copy rows (n, k) to the start of others."""
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            target[i, j] = source[i, j]
