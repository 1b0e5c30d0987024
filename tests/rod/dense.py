"""The second variation of a rod in a sine basis: an oracle for its Morse index.

For R → R exp([b]) the energy less F times the constraint grows by half of

    Q(b) = ∫ δu·K δu + m·(b × (b × u) − b × b') − n·(b × (b × e3)) ds,   δu = b' + u × b,

u the rates of turning, m = K u and n = Rᵀ F in the body frame, for b that vanish where the rod is
clamped and keep the end in place, ∫ R (b × e3) ds = 0. With a free end spin b3 is free at the end.
"""

import numpy as np


def eigenvalues(rod, size=48):
    """Eigenvalues of Q on ``size`` sines for each of the three components, ascending."""
    points, weights = np.polynomial.legendre.leggauss(6 * size)
    s, weights = 0.5 * (points + 1.0), 0.5 * weights
    frames = rod.frames(s)
    ratio = 1.0 if rod.clamping.free_spin else rod.torsion_ratio
    stiffness = np.array([1.0, 1.0, ratio])
    moment = np.einsum("sji,sj->si", frames, rod.moment(s))
    turning = moment / stiffness
    force = np.einsum("sji,j->si", frames, rod.loads[:3])
    waves = np.pi * np.arange(1, size + 1)
    values, slopes = (
        np.sqrt(2.0) * np.sin(np.outer(waves, s)),
        np.sqrt(2.0) * np.cos(np.outer(waves, s)),
    )
    slopes *= waves[:, None]
    if rod.clamping.free_spin:
        odd = waves - 0.5 * np.pi
        free = (
            np.sqrt(2.0) * np.sin(np.outer(odd, s)),
            np.sqrt(2.0) * odd[:, None] * np.cos(np.outer(odd, s)),
        )
    else:
        free = values, slopes
    b, db = np.zeros((3, size, len(s), 3)), np.zeros((3, size, len(s), 3))
    for i in range(3):
        b[i, :, :, i], db[i, :, :, i] = (values, slopes) if i < 2 else free
    b, db = b.reshape(3 * size, len(s), 3), db.reshape(3 * size, len(s), 3)
    du = db + np.cross(turning, b)
    w = weights[:, None]

    def form(f, g):
        return np.einsum("isk,jsk->ij", f * w, g, optimize=True)

    # a·(b × (b × c)) = (a·b)(b·c) − (a·c) b²
    def twice_crossed(a, c):
        along = form(
            np.einsum("isk,sk->is", b, a)[..., None], np.einsum("jsk,sk->js", b, c)[..., None]
        )
        return along - form(b * np.sum(a * c, axis=1)[:, None], b)

    e3 = np.broadcast_to([0.0, 0.0, 1.0], turning.shape)
    q = form(du * stiffness, du) + twice_crossed(moment, turning) - twice_crossed(force, e3)
    q -= form(np.cross(moment, b), db)
    q = 0.5 * (q + q.T)
    moved = np.einsum("skl,isl,s->ik", frames, np.cross(b, e3), weights)
    keep = np.linalg.svd(moved.T)[2][3:].T
    return np.linalg.eigvalsh(keep.T @ q @ keep)
