"""Compute ``rods.npz``, the guess library of `loopelastica.solve_batch`, anew: some minutes.

    python data/make_rods.py

Some of the rods have random moderate loads, more are the lowest equilibria of random poses, so that
a pose nearby usually leads to its own lowest equilibrium. The arrays ``clamped`` and ``free``
(n, 13), with and without end spin, hold loads, position and quaternion for K30 = 1 as whole
multiples of small units: they are guesses. Poses of clamped ends have a dimension more and need
more rods.
"""

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod._library import UNITS
from loopelastica.rod.kernels.shooting import ends

SEED = 20180717
# rods of random loads, and random poses: with the end clamped, and free to spin
SIZES = {False: (30_000, 90_000), True: (20_000, 20_000)}
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


def make(free_spin, sizes=SIZES, seed=SEED):
    """Rods (at most as many as ``sizes`` say, 13): loads, position and quaternion of the end."""
    rng = np.random.default_rng(seed)
    by_loads, by_poses = sizes[free_spin]
    drawn = draw_loads(by_loads, rng)
    if free_spin:
        drawn[:, 5] = 0.0
    loads = np.concatenate([drawn, draw_lowest(by_poses, free_spin, rng)])
    loads = UNITS[:6] * np.rint(loads / UNITS[:6])
    return np.rint(np.hstack([loads, *ends(loads, 1.0, 3.0)]) / UNITS).astype(np.int16)


def write(path, sizes=SIZES, seed=SEED):
    """Write the file, whole or not at all."""
    part = path.with_suffix(".part.npz")
    np.savez_compressed(part, clamped=make(False, sizes, seed), free=make(True, sizes, seed))
    part.replace(path)


if __name__ == "__main__":
    write(Path(__file__).with_name("rods.npz"))
