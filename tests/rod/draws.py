"""Random rods and poses that several tests draw."""

import numpy as np
from scipy.spatial.transform import Rotation


def directions(rng, n):
    v = rng.normal(size=(n, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def loads(rng, n, force=60.0, moment=12.0):
    """|F| and |M| uniform below the bounds, directions uniform."""
    return np.hstack(
        [
            directions(rng, n) * rng.uniform(0, force, (n, 1)),
            directions(rng, n) * rng.uniform(0, moment, (n, 1)),
        ]
    )


def load_drawn(rng, n, torsion_ratio=1.0, free_spin=False, below=0.95):
    """End poses (positions, rotations) of random loads, kept where |η| < ``below``."""
    from loopelastica.rod.kernels.shooting import ends

    f = loads(rng, 4 * n)
    if free_spin:
        f[:, 5] = 0.0
    p, q = ends(f, torsion_ratio, 4.0)
    keep = np.flatnonzero(np.linalg.norm(p, axis=1) < below)[:n]
    return p[keep], Rotation.from_quat(q[keep], scalar_first=True).as_matrix()


def pose_drawn(rng, n, low=0.0, high=0.95):
    """Positions uniform in a shell, rotations uniform."""
    radius = rng.uniform(low**3, high**3, (n, 1)) ** (1 / 3)
    return directions(rng, n) * radius, Rotation.random(n, random_state=rng).as_matrix()
