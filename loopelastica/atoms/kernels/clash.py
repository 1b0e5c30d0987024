"""Overlap of rigid groups of atoms, for each two of their states."""

# numba infers the types of kernels
# mypy: disable-error-code="no-untyped-def"
import numpy as np

from loopelastica.rod.kernels.jit import kernel


@kernel
def overlap_sums(a, b, reach):
    """Σ (reach − d)² over atoms nearer than `reach`: (s, t) of states (s, i, 3) and (t, j, 3)."""
    total = np.zeros((a.shape[0], b.shape[0]))
    center = np.zeros((b.shape[0], 3))
    radius = np.zeros(b.shape[0])
    for t in range(b.shape[0]):
        for c in range(3):
            for j in range(b.shape[1]):
                center[t, c] += b[t, j, c] / b.shape[1]
        for j in range(b.shape[1]):
            square = 0.0
            for c in range(3):
                square += (b[t, j, c] - center[t, c]) ** 2
            radius[t] = max(radius[t], np.sqrt(square))
    for s in range(a.shape[0]):
        for t in range(b.shape[0]):
            for i in range(a.shape[1]):
                x, y, z = a[s, i, 0], a[s, i, 1], a[s, i, 2]
                dx, dy, dz = x - center[t, 0], y - center[t, 1], z - center[t, 2]
                far = radius[t] + reach
                if dx * dx + dy * dy + dz * dz > far * far:
                    continue
                for j in range(b.shape[1]):
                    dx, dy, dz = x - b[t, j, 0], y - b[t, j, 1], z - b[t, j, 2]
                    square = dx * dx + dy * dy + dz * dz
                    if square < reach * reach:
                        total[s, t] += (reach - np.sqrt(square)) ** 2
    return total
