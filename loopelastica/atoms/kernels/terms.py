"""The sum of squares that restored chemistry minimizes, and its gradient.

    E = ½ Σ w (|x_i − x_j| − l)²                     bonds, and angles as distances
      + ½ Σ w (b · c × d − V)²                       hands, planes, puckers
      + Σ w (1 − cos m (φ − φ₀)) / m²                torsions
      + ½ w Σ |centroid − point|²                    the line
      + ½ w Σ |x − place|²                           tethers
      + ½ w Σ ((r² − d²) / 2r)²   where d < r        atoms that are too near

The last is ½ w (r − d)² where two atoms touch, but flat and finite where they coincide: with a low
weight, atoms pass through one another. It stands twice, once for the distance that atoms like to
keep, and once, much stronger, for the one that they must.
"""

# numba infers the types of kernels
# mypy: disable-error-code="no-untyped-def"
from typing import NamedTuple

import numpy as np

from loopelastica.rod.kernels.jit import kernel

# atoms that come nearer than their least distance and this much are listed, Å
SKIN_A = 1.0


class Terms(NamedTuple):
    """All terms over N atoms, of which the first `tether` (n, 3) move."""

    pairs: np.ndarray  # (p, 2)
    length: np.ndarray  # (p,) Å
    pair_weight: np.ndarray  # (p,) 1/Å²
    quads: np.ndarray  # (q, 4)
    volume: np.ndarray  # (q,) Å³
    quad_weight: np.ndarray  # (q,) 1/Å⁶
    torsions: np.ndarray  # (t, 4)
    torsion_fold: np.ndarray  # (t,) m
    torsion_at: np.ndarray  # (t,) φ₀, rad
    torsion_weight: np.ndarray  # (t,) 1/rad²
    groups: np.ndarray  # (g, 6)
    center: np.ndarray  # (g, 3) Å
    line_weight: float  # 1/Å²
    tether: np.ndarray  # (n, 3) Å
    tether_weight: np.ndarray  # (n,) 1/Å²
    least: np.ndarray  # (n, N) Å, 0 where two atoms may be as near as they like
    floor: np.ndarray  # (n, N) Å
    least_weight: float  # 1/Å²
    floor_weight: float  # 1/Å²


@kernel
def near_pairs(x, least, listed):
    """List the pairs that may soon overlap in `listed` (m, 2); their number, −1 if more than m."""
    count = 0
    n = least.shape[0]
    for i in range(n):
        for j in range(i + 1, x.shape[0]):
            reach = least[i, j]
            if reach <= 0.0:
                continue
            reach += SKIN_A
            dx = x[i, 0] - x[j, 0]
            if dx > reach or dx < -reach:
                continue
            dy = x[i, 1] - x[j, 1]
            dz = x[i, 2] - x[j, 2]
            if dx * dx + dy * dy + dz * dz < reach * reach:
                if count == listed.shape[0]:
                    return -1
                listed[count, 0] = i
                listed[count, 1] = j
                count += 1
    return count


@kernel
def evaluate(x, terms, listed, count, gradient):
    """E at x (N, 3); its gradient by the n moving atoms goes to `gradient` (N, 3)."""
    for i in range(gradient.shape[0]):
        for c in range(3):
            gradient[i, c] = 0.0
    energy = _distances(x, terms.pairs, terms.length, terms.pair_weight, gradient)
    energy += _volumes(x, terms.quads, terms.volume, terms.quad_weight, gradient)
    energy += _torsions(x, terms, gradient)
    energy += _line(x, terms.groups, terms.center, terms.line_weight, gradient)
    for i in range(terms.tether.shape[0]):
        for c in range(3):
            away = x[i, c] - terms.tether[i, c]
            energy += 0.5 * terms.tether_weight[i] * away * away
            gradient[i, c] += terms.tether_weight[i] * away
    for row in range(count):
        i, j = listed[row, 0], listed[row, 1]
        dx, dy, dz = x[i, 0] - x[j, 0], x[i, 1] - x[j, 1], x[i, 2] - x[j, 2]
        square = dx * dx + dy * dy + dz * dz
        r = terms.least[i, j]
        if square >= r * r:
            continue
        near = (r * r - square) / (2.0 * r)
        energy += 0.5 * terms.least_weight * near * near
        slope = -terms.least_weight * near / r
        r = terms.floor[i, j]
        if square < r * r:
            near = (r * r - square) / (2.0 * r)
            energy += 0.5 * terms.floor_weight * near * near
            slope -= terms.floor_weight * near / r
        gradient[i, 0] += slope * dx
        gradient[i, 1] += slope * dy
        gradient[i, 2] += slope * dz
        gradient[j, 0] -= slope * dx
        gradient[j, 1] -= slope * dy
        gradient[j, 2] -= slope * dz
    return energy


@kernel
def _distances(x, pairs, length, weight, gradient):
    energy = 0.0
    for row in range(pairs.shape[0]):
        i, j = pairs[row, 0], pairs[row, 1]
        dx, dy, dz = x[i, 0] - x[j, 0], x[i, 1] - x[j, 1], x[i, 2] - x[j, 2]
        apart = max(np.sqrt(dx * dx + dy * dy + dz * dz), 1e-6)
        off = apart - length[row]
        energy += 0.5 * weight[row] * off * off
        slope = weight[row] * off / apart
        gradient[i, 0] += slope * dx
        gradient[i, 1] += slope * dy
        gradient[i, 2] += slope * dz
        gradient[j, 0] -= slope * dx
        gradient[j, 1] -= slope * dy
        gradient[j, 2] -= slope * dz
    return energy


@kernel
def _volumes(x, quads, volume, weight, gradient):
    energy = 0.0
    for row in range(quads.shape[0]):
        a = quads[row, 0]
        b, c, d = quads[row, 1], quads[row, 2], quads[row, 3]
        bx, by, bz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
        cx, cy, cz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
        dx, dy, dz = x[d, 0] - x[a, 0], x[d, 1] - x[a, 1], x[d, 2] - x[a, 2]
        ux, uy, uz = cy * dz - cz * dy, cz * dx - cx * dz, cx * dy - cy * dx
        vx, vy, vz = dy * bz - dz * by, dz * bx - dx * bz, dx * by - dy * bx
        wx, wy, wz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
        off = bx * ux + by * uy + bz * uz - volume[row]
        energy += 0.5 * weight[row] * off * off
        slope = weight[row] * off
        gradient[b, 0] += slope * ux
        gradient[b, 1] += slope * uy
        gradient[b, 2] += slope * uz
        gradient[c, 0] += slope * vx
        gradient[c, 1] += slope * vy
        gradient[c, 2] += slope * vz
        gradient[d, 0] += slope * wx
        gradient[d, 1] += slope * wy
        gradient[d, 2] += slope * wz
        gradient[a, 0] -= slope * (ux + vx + wx)
        gradient[a, 1] -= slope * (uy + vy + wy)
        gradient[a, 2] -= slope * (uz + vz + wz)
    return energy


@kernel
def _torsions(x, terms, gradient):
    # the gradient of a torsion: Blondel & Karplus, J. Comput. Chem. 17 (1996) 1132
    energy = 0.0
    quads = terms.torsions
    for row in range(quads.shape[0]):
        a, b, c, d = quads[row, 0], quads[row, 1], quads[row, 2], quads[row, 3]
        ux, uy, uz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
        ax, ay, az = x[c, 0] - x[b, 0], x[c, 1] - x[b, 1], x[c, 2] - x[b, 2]
        vx, vy, vz = x[d, 0] - x[c, 0], x[d, 1] - x[c, 1], x[d, 2] - x[c, 2]
        mx, my, mz = uy * az - uz * ay, uz * ax - ux * az, ux * ay - uy * ax
        nx, ny, nz = ay * vz - az * vy, az * vx - ax * vz, ax * vy - ay * vx
        # three atoms in a row have no torsion: what it would pull at is kept finite
        mm = max(mx * mx + my * my + mz * mz, 0.25)
        nn = max(nx * nx + ny * ny + nz * nz, 0.25)
        length = max(np.sqrt(ax * ax + ay * ay + az * az), 0.1)
        angle = np.arctan2(length * (ux * nx + uy * ny + uz * nz), mx * nx + my * ny + mz * nz)
        fold, weight = terms.torsion_fold[row], terms.torsion_weight[row]
        off = fold * (angle - terms.torsion_at[row])
        energy += weight * (1.0 - np.cos(off)) / (fold * fold)
        slope = weight * np.sin(off) / fold
        at_a, at_d = -slope * length / mm, slope * length / nn
        along_u = (ux * ax + uy * ay + uz * az) / (length * length)
        along_v = (vx * ax + vy * ay + vz * az) / (length * length)
        for k in range(3):
            m = mx if k == 0 else (my if k == 1 else mz)
            n = nx if k == 0 else (ny if k == 1 else nz)
            first, last = at_a * m, at_d * n
            gradient[a, k] += first
            gradient[d, k] += last
            gradient[b, k] += -first - along_u * first + along_v * last
            gradient[c, k] += -last + along_u * first - along_v * last
    return energy


@kernel
def _line(x, groups, center, weight, gradient):
    energy = 0.0
    size = groups.shape[1]
    for row in range(groups.shape[0]):
        for c in range(3):
            mean = 0.0
            for k in range(size):
                mean += x[groups[row, k], c]
            away = mean / size - center[row, c]
            energy += 0.5 * weight * away * away
            for k in range(size):
                gradient[groups[row, k], c] += weight * away / size
    return energy
