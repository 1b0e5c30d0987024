"""Compile now what would be compiled when the first atoms are built.

``python -m loopelastica.atoms.warm`` needs NumPy and numba alone, so that it runs where the package
is built; `LOOPELASTICA_CACHE` says where to.
"""

import gc

import numpy as np

from loopelastica.atoms.kernels.clash import overlap_sums
from loopelastica.atoms.kernels.lbfgs import descend
from loopelastica.atoms.kernels.terms import Terms


def compile_atoms() -> None:
    """Compile the kernels of this room, by one tiny problem each."""
    x = np.array([[0.0, 0.0, 0.0], [1.5, 0.0, 0.0]])
    two, four, six = (np.zeros((0, m), dtype=np.int64) for m in (2, 4, 6))
    nothing, points = np.zeros(0), np.zeros((0, 3))
    terms = Terms(
        two, nothing, nothing, four, nothing, nothing, four, nothing, nothing, nothing, six, points,
        1.0, x[:1].copy(), np.ones(1), np.zeros((1, 2)), np.zeros((1, 2)), 1.0, 1.0,
    )  # fmt: skip
    descend(x, terms, np.zeros((1, 2), dtype=np.int64), 1, 0.1, 1.0)
    overlap_sums(x[None], x[None], 3.0)


if __name__ == "__main__":
    gc.disable()
    compile_atoms()
