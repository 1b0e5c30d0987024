"""Chains that several tests draw."""

import numpy as np
from scipy.spatial.transform import Rotation

import loopelastica as le


def shape_drawn(rng, m, turn=0.6, varied=True):
    """A rest shape whose segments turn by about `turn`, its end and stiffness at random."""
    turns = Rotation.from_rotvec(turn * rng.normal(size=(m, 3)))
    direction, steps = np.array([0.0, 0.0, 1.0]), []
    for k in range(m):
        direction = turns[k].apply(direction)
        steps.append(rng.uniform(0.5, 1.5) * direction)
    end = Rotation.random(random_state=rng).as_matrix()
    return le.RestShape(steps, end, rng.uniform(0.5, 2, m + 1) if varied else None)


def clamping_near(rng, shape, away=0.5, free_spin=False):
    """The end of a rest shape, turned by about `away` and moved by a little of the way inwards."""
    place = shape.clamping.position * (1 - 0.3 * rng.uniform()) + 0.05 * rng.normal(size=3)
    place /= max(1.0, 1.02 * np.linalg.norm(place))
    turn = Rotation.from_rotvec(away * rng.normal(size=3)).as_matrix()
    return le.Clamping(place, turn @ shape.end_frame, free_spin)


def energy_by_scipy(shape, torsion_ratio, turns):
    """½ Σ u·K u in K0/L from the turns (m + 2, 3, 3), with SciPy's logarithm."""
    sizes = np.linalg.norm(shape.steps, axis=1)
    along = shape.steps / sizes[:, None]
    axes = np.concatenate([along[:1], along[:-1] + along[1:], along[-1:]])
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    halves = np.concatenate([sizes[:1], sizes[:-1] + sizes[1:], sizes[-1:]]) / 2
    k = shape.stiffness * sizes.sum() / halves
    u = Rotation.from_matrix(turns[:-1].transpose(0, 2, 1) @ turns[1:]).as_rotvec()
    twist = np.einsum("ij,ij->i", u, axes)
    return 0.5 * float(k @ ((u * u).sum(axis=1) + (torsion_ratio - 1) * twist**2))
