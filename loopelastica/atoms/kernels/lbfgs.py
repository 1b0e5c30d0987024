"""Minimization by limited-memory BFGS (Nocedal, Math. Comput. 35 (1980) 773).

A step is as long as the quasi-Newton one, no atom moves further than a limit, and is halved until
the sum of squares falls (Armijo). Pairs that may overlap are listed anew when an atom has moved
half the skin.
"""

# numba infers the types of kernels
# mypy: disable-error-code="no-untyped-def"
import numpy as np

from loopelastica.atoms.kernels.terms import SKIN_A, evaluate, near_pairs
from loopelastica.rod.kernels.jit import kernel

_MEMORY = 12


@kernel
def descend(x, terms, listed, max_steps, longest_step, tolerance):
    """Minimize in place from x (N, 3).

    Returns (steps, energy, largest component of the gradient); steps is −1 where `listed` is too
    small for the pairs.
    """
    n = terms.tether.shape[0]
    size = 3 * n
    gradient = np.zeros_like(x)
    other_gradient = np.zeros_like(x)
    trial = x.copy()
    listed_at = x.copy()
    count = near_pairs(x, terms.least, listed)
    if count < 0:
        return -1, np.inf, np.inf
    energy = evaluate(x, terms, listed, count, gradient)
    moves = np.zeros((_MEMORY, size))
    changes = np.zeros((_MEMORY, size))
    curvature = np.zeros(_MEMORY)
    alpha = np.zeros(_MEMORY)
    direction = np.zeros(size)
    kept, newest = 0, -1
    steps = 0
    largest = _largest(gradient, n)
    while steps < max_steps and largest > tolerance:
        steps += 1
        for k in range(size):
            direction[k] = -gradient[k // 3, k % 3]
        for back in range(kept):
            row = (newest - back) % _MEMORY
            alpha[row] = _dot(moves[row], direction) / curvature[row]
            for k in range(size):
                direction[k] -= alpha[row] * changes[row, k]
        scale = curvature[newest] / _dot(changes[newest], changes[newest]) if kept else 1e-4
        for k in range(size):
            direction[k] *= scale
        for back in range(kept):
            row = (newest - kept + 1 + back) % _MEMORY
            beta = _dot(changes[row], direction) / curvature[row]
            for k in range(size):
                direction[k] += (alpha[row] - beta) * moves[row, k]
        slope = 0.0
        longest = 0.0
        for i in range(n):
            square = 0.0
            for c in range(3):
                slope += direction[3 * i + c] * gradient[i, c]
                square += direction[3 * i + c] ** 2
            longest = max(longest, square)
        if not slope < 0.0:
            if kept == 0:
                break
            kept = 0
            continue
        step = min(1.0, longest_step / np.sqrt(longest))
        accepted = False
        for _ in range(20):
            for i in range(n):
                for c in range(3):
                    trial[i, c] = x[i, c] + step * direction[3 * i + c]
            if _furthest(trial, listed_at, n) > 0.5 * SKIN_A:
                # what has come near since enters with no overlap: E does not jump
                count = near_pairs(trial, terms.least, listed)
                if count < 0:
                    return -1, np.inf, np.inf
                for i in range(n):
                    for c in range(3):
                        listed_at[i, c] = trial[i, c]
            other = evaluate(trial, terms, listed, count, other_gradient)
            if other <= energy + 1e-4 * step * slope:
                accepted = True
                break
            # the parabola through both values and the slope
            shorter = -0.5 * slope * step * step / (other - energy - slope * step)
            step = min(max(shorter, 0.1 * step), 0.5 * step)
        if not accepted:
            if kept == 0:
                break
            kept = 0
            continue
        row = (newest + 1) % _MEMORY
        product = 0.0
        length = 0.0
        for i in range(n):
            for c in range(3):
                k = 3 * i + c
                moves[row, k] = trial[i, c] - x[i, c]
                changes[row, k] = other_gradient[i, c] - gradient[i, c]
                product += moves[row, k] * changes[row, k]
                length += changes[row, k] ** 2
                x[i, c] = trial[i, c]
                gradient[i, c] = other_gradient[i, c]
        energy = other
        largest = _largest(gradient, n)
        if product > 1e-10 * length:
            curvature[row] = product
            newest = row
            kept = min(kept + 1, _MEMORY)
    return steps, energy, largest


@kernel
def _dot(a, b):
    total = 0.0
    for k in range(a.shape[0]):
        total += a[k] * b[k]
    return total


@kernel
def _largest(gradient, n):
    largest = 0.0
    for i in range(n):
        for c in range(3):
            largest = max(largest, abs(gradient[i, c]))
    return largest


@kernel
def _furthest(x, other, n):
    square = 0.0
    for i in range(n):
        far = 0.0
        for c in range(3):
            far += (x[i, c] - other[i, c]) ** 2
        square = max(square, far)
    return np.sqrt(square)
