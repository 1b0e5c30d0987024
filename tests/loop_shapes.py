"""Loop shapes made by hand, for the tests of libraries."""

import numpy as np
from scipy.spatial.transform import Rotation

from loopelastica.folding.shape_table import FoundLoop
from loopelastica.molecule.shapes import LoopShape

# nodes of a loop turn about 4 Å off an axis, some 5 Å apart
ARC_A = 5.0


def arc(n, turn=2.6, rise=0.4):
    """Steps and end frame of a circular loop of n nucleotides."""
    angles = (np.arange(n + 1) + 0.5) * turn / (n + 1)
    steps = ARC_A * np.stack([np.sin(angles), np.full(n + 1, rise), np.cos(angles)], axis=1)
    return steps, Rotation.from_rotvec([0.0, turn, 0.0]).as_matrix()


def found(sequence, entry="1abc", is_dna=False, place="A.1-A.9", bend=0.0, seed=None):
    """A loop of any sequence; `bend` widens it, a seed makes it another one."""
    n = len(sequence) - 2
    steps, frame = arc(n, 2.6 + bend)
    if seed is not None:
        draw = np.random.default_rng(seed)
        turned = Rotation.from_rotvec(draw.normal(0.0, 0.1, (n + 2, 3)))
        for k in range(n + 1):
            steps[k:] = steps[k:] @ turned[k].as_matrix().T
            frame = turned[k].as_matrix() @ frame
        frame = turned[n + 1].as_matrix() @ frame
    shape = LoopShape(sequence, is_dna, steps, frame, f"{entry} {place}")
    return FoundLoop(shape, entry, 0.5)
