"""One segment of a rod between two nodes: its end, and how that follows the node and the loads.

A segment is integrated from its node (``shooting``, K30 = 1, see there) with the local moment
M_k = M0 + F × r_k. Its six variations with respect to (F, M_k) also tell how its end follows a
turn δθ_k and a shift δr_k of its node, the rod being the same in a turned frame:

    δ(end) = (δθ_k, δr_k + δθ_k × ρ) + A (δF − δθ_k × F, δM_k − δθ_k × M_k),
    δM_k = δM0 + δF × r_k + F × δr_k,      ρ from node to end.
"""

import math
from typing import NamedTuple

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.rotations import cross
from loopelastica.rod.kernels.shooting import POSE, WITH_JACOBIAN, march

# steps over one segment beyond which it is too stiff
MAX_STEPS = 60


class Space(NamedTuple):
    """Room for one segment's integration and its rows."""

    f: Array
    """Local loads, (6,)."""
    y: Array
    """State and variations, (43,)."""
    k: Array
    z: Array
    end_by_node: Array
    """(6, 6): how the segment's end follows its node."""
    end_by_loads: Array
    """(6, 6): how it follows the loads."""


@kernel
def new_space():
    """Room for one segment."""
    return Space(
        np.empty(6),
        np.empty(WITH_JACOBIAN),
        np.empty(12 * WITH_JACOBIAN),
        np.empty(WITH_JACOBIAN),
        np.empty((6, 6)),
        np.empty((6, 6)),
    )


@kernel
def _steps(f, h, density):
    """Steps over a segment of length ``h``: ``density`` per radian of the fastest turning."""
    force = math.sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2])
    moment = math.sqrt(f[3] * f[3] + f[4] * f[4] + f[5] * f[5])
    root = math.sqrt(force)
    return 1 + int(density * h * max(root, moment + 0.5 * min(force * h, root)))


@kernel
def integrate_segment(g, free_spin, node, h, density, size, space):
    """The end of one segment from its node (7,), into ``space.y`` (positions from the node).

    ``space.f`` becomes the local loads. Returns the number of steps.
    """
    f, y = space.f, space.y
    for c in range(3):
        f[c] = g[c]
    m3 = 0.0 if free_spin else g[5]
    f[3] = g[3] + g[1] * node[2] - g[2] * node[1]
    f[4] = g[4] + g[2] * node[0] - g[0] * node[2]
    f[5] = m3 + g[0] * node[1] - g[1] * node[0]
    for c in range(WITH_JACOBIAN):
        y[c] = 0.0
    for c in range(4):
        y[3 + c] = node[3 + c]
    steps = _steps(f, h, density)
    if steps <= MAX_STEPS:
        march(f, y, h, steps, size, space.k, space.z)
    return steps


@kernel
def segment_rows(node, space):
    """Matrices of a segment from its variations: end = t x_k + b g, x = (δθ, δr)."""
    f, y, t, b = space.f, space.y, space.end_by_node, space.end_by_loads
    rho = y[:3]
    for i in range(6):
        for j in range(6):
            b[i, j] = y[POSE + 6 * i + j]
            t[i, j] = 1.0 if i == j else 0.0
    for j in range(3):
        ux, uy, uz = (1.0 if j == 0 else 0.0), (1.0 if j == 1 else 0.0), (1.0 if j == 2 else 0.0)
        # δθ_j: turned loads −u × F, −u × M; the end moves by u × ρ
        fx, fy, fz = cross(f[0], f[1], f[2], ux, uy, uz)
        mx, my, mz = cross(f[3], f[4], f[5], ux, uy, uz)
        # δr_j: δM = F × u
        nx, ny, nz = cross(f[0], f[1], f[2], ux, uy, uz)
        sx, sy, sz = cross(ux, uy, uz, rho[0], rho[1], rho[2])
        for i in range(6):
            t[i, j] += (
                b[i, 0] * fx + b[i, 1] * fy + b[i, 2] * fz
                + b[i, 3] * mx + b[i, 4] * my + b[i, 5] * mz
            )  # fmt: skip
            t[i, 3 + j] += b[i, 3] * nx + b[i, 4] * ny + b[i, 5] * nz
        t[3, j] += sx
        t[4, j] += sy
        t[5, j] += sz
    for j in range(3):
        # δF_j also changes the local moment by u × r_k
        ux, uy, uz = (1.0 if j == 0 else 0.0), (1.0 if j == 1 else 0.0), (1.0 if j == 2 else 0.0)
        mx, my, mz = cross(ux, uy, uz, node[0], node[1], node[2])
        for i in range(6):
            b[i, j] += b[i, 3] * mx + b[i, 4] * my + b[i, 5] * mz
