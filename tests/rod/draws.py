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


def drawn_rods(rng, n, torsion_ratio=1.0, free_spin=False, force=300.0, moment=16.0):
    """Rods of random loads, most of them saddles: |F| log-uniform from 3 on, |η| < 0.98."""
    import loopelastica as le
    from loopelastica.rod.kernels.records import Status
    from loopelastica.rod.kernels.shooting import ends

    rods = []
    while len(rods) < n:
        f = np.exp(rng.uniform(np.log(3.0), np.log(force)))
        load = np.append(directions(rng, 1)[0] * f, directions(rng, 1)[0] * rng.uniform(0, moment))
        if free_spin:
            load[5] = 0.0
        p, q = ends(load[None], torsion_ratio, 8.0)
        if np.linalg.norm(p[0]) < 0.98:
            end = Rotation.from_quat(q[0], scalar_first=True).as_matrix()
            clamping = le.Clamping(p[0], end, free_spin)
            rods.append(shot(clamping, torsion_ratio, load, Status.CONVERGED))
    return rods


def shot(clamping, torsion_ratio, load, status=0):
    """The equilibrium of loads that end at the clamping."""
    import loopelastica as le
    from loopelastica.rod.kernels.records import Status

    rod = le.Equilibrium(clamping, torsion_ratio, load, 0.0, 0.0, Status(status))
    s, weights = np.polynomial.legendre.leggauss(64)
    moment = np.einsum("sji,sj->si", rod.frames(0.5 * (s + 1)), rod.moment(0.5 * (s + 1)))
    density = 0.5 * np.sum(moment**2 / [1.0, 1.0, torsion_ratio], axis=1)
    energy = float(0.5 * weights @ density)
    return le.Equilibrium(clamping, torsion_ratio, load, energy, 1e-10, Status(status))


def closed_ring(times=1, torsion_ratio=1.0, twist=0.0, free_spin=False):
    """A circle run through some times, with so many turns of twist."""
    import loopelastica as le

    rate, angle = 2 * np.pi * times, 2 * np.pi * twist
    m3 = torsion_ratio * angle
    end = Rotation.from_rotvec([0, 0, angle]).as_matrix()
    # M = κ b + M3 t turns with the rod: F × t = M3 κ n
    loads = np.array([0, m3 * rate, 0, 0, rate, m3])
    return shot(le.Clamping(np.zeros(3), end, free_spin), torsion_ratio, loads)
