"""Nucleotides as backbone sites and directions, made at random and in a line."""

import numpy as np

from loopelastica.nanostructures.laying.chains import Chains


def crowd(rng, n=30, side=2.5, box=0.0):
    """Nucleotides at random; the first ten are a strand."""
    direction = rng.normal(size=(n, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    n3, n5 = np.full(n, -1), np.full(n, -1)
    last = min(n, 10)
    n3[: last - 1], n5[1:last] = np.arange(1, last), np.arange(last - 1)
    return Chains(
        sites=side * rng.random((n, 3)),
        direction=direction,
        placed=np.ones(n, dtype=bool),
        n3=n3,
        n5=n5,
        strand=np.where(np.arange(n) < 10, 0, -1),
        order=np.arange(n),
        tangent=np.zeros((n, 3)),
        bond=np.full(n, 0.7564),
        cores=np.zeros((0, 3)),
        box=np.full(3, box),
    )


def line(n, gap=0.7564):
    """A straight strand between two nucleotides that are held."""
    chains = crowd(np.random.default_rng(0), n=n)
    chains.sites[:] = gap * np.arange(n)[:, None] * [0.0, 0.0, 1.0]
    chains.direction[:] = [1.0, 0.0, 0.0]
    chains.n3[:], chains.n5[:] = np.append(np.arange(1, n), -1), np.arange(-1, n - 1)
    chains.strand[:] = 0
    chains.strand[[0, -1]] = -1
    chains.tangent[[0, -1]] = [0.0, 0.0, 1.0]
    return chains
