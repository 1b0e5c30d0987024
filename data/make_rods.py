"""Compute ``rods.npz``, the guess library of `loopelastica.solve_batch`, anew: some minutes.

    python data/make_rods.py

Half of the rods have random moderate loads, half are the lowest equilibria of random poses, so that
a pose nearby usually leads to its own lowest equilibrium. The arrays ``clamped`` and ``free``
(n, 13), with and without end spin, hold loads, position and quaternion for K30 = 1, in single
precision: they are guesses.
"""

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod.kernels.shooting import ends

SEED, SIZE = 20180717, 40_000
# |F| beyond which no pose nearby was reached from stored loads: errors of those grow like exp √F
SHOOTABLE = 60.0
LARGEST_MOMENT = 12.0


def draw_loads(size, rng):
    """Random loads (size, 6): |F| and |M| uniform, directions uniform."""
    directions = rng.normal(size=(2, size, 3))
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    force = rng.uniform(0.0, SHOOTABLE, (size, 1)) * directions[0]
    return np.hstack([force, rng.uniform(0.0, LARGEST_MOMENT, (size, 1)) * directions[1]])


def draw_lowest(size, free_spin, rng):
    """Loads (at most size, 6) of the lowest rods of random poses, where loads determine them."""
    directions = rng.normal(size=(size, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    positions = directions * 0.95 * rng.uniform(size=(size, 1)) ** (1.0 / 3.0)
    rotations = Rotation.random(size, random_state=rng).as_matrix()
    batch = le.solve_batch(positions, rotations, free_spin=free_spin, lowest=True)
    keep = batch.converged & (np.linalg.norm(batch.loads[:, :3], axis=1) < SHOOTABLE)
    return batch.loads[keep]


def make(free_spin, size=SIZE, seed=SEED):
    """Rods (at most size, 13): loads, position and quaternion of the end."""
    rng = np.random.default_rng(seed)
    drawn = draw_loads(size // 2, rng)
    if free_spin:
        drawn[:, 5] = 0.0
    loads = np.concatenate([drawn, draw_lowest(size - size // 2, free_spin, rng)])
    return np.hstack([loads, *ends(loads, 1.0, 3.0)]).astype(np.float32)


def write(path, size=SIZE, seed=SEED):
    """Write the file, whole or not at all."""
    part = path.with_suffix(".part.npz")
    np.savez_compressed(part, clamped=make(False, size, seed), free=make(True, size, seed))
    part.replace(path)


if __name__ == "__main__":
    write(Path(__file__).with_name("rods.npz"))
