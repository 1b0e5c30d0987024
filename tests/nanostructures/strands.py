"""Systems that several tests of nanostructures use, made from strands."""

from dataclasses import replace

import numpy as np
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from loopelastica.nanostructures.oxdna.model import backbone_sites, centre_of, duplex
from loopelastica.nanostructures.system import System

COMPLEMENT = {"A": "T", "T": "A", "G": "C", "C": "G"}


def system_of(strands, circular=(), pair=None, box=(0.0, 0.0, 0.0), name="made"):
    """A system from (bases, centre, a1, a3) of strands, listed from 5' to 3'."""
    bases = [base for strand in strands for base in strand[0]]
    strand = np.concatenate([np.full(len(s[0]), k) for k, s in enumerate(strands)])
    n = len(bases)
    n3, n5 = np.arange(1, n + 1), np.arange(-1, n - 1)
    first = 0
    for k, (sequence, *_) in enumerate(strands):
        last = first + len(sequence) - 1
        n5[first], n3[last] = (last, first) if k in circular else (-1, -1)
        first = last + 1
    centre, a1, a3 = (np.concatenate([s[axis] for s in strands]) for axis in (1, 2, 3))
    return System(
        name=name,
        base=np.array(bases),
        strand=strand,
        n3=n3,
        n5=n5,
        pair=np.full(n, -1) if pair is None else np.asarray(pair),
        placed=np.ones(n, dtype=bool),
        centre=centre,
        a1=a1,
        a3=a3,
        label=tuple(f"nucleotide {i}" for i in range(n)),
        strand_name=tuple(f"strand {k + 1}" for k in range(len(strands))),
        colour=("",) * len(strands),
        rna=np.zeros(len(strands), dtype=bool),
        box=np.array(box, dtype=float),
    )


def helix(sequence, **changes):
    """An ideal duplex of a sequence, each strand from 5' to 3'."""
    centre, a1, a3 = duplex(len(sequence))
    other = "".join(COMPLEMENT[base] for base in reversed(sequence))
    return system_of(
        [(sequence, centre[0], a1[0], a3[0]), (other, *(x[1, ::-1] for x in (centre, a1, a3)))],
        **changes,
    )


def hairpin(stem, loop, bond=0.75):
    """An ideal stem and a loop on a circle, its bases outwards, with bonds of one length."""
    n, steps = len(stem), len(loop) + 1
    centre, a1, a3 = duplex(n)
    start, end = backbone_sites(centre[:, -1], a1[:, -1], a3[:, -1])
    across = end - start
    distance = np.linalg.norm(across)
    # a polygon of so many equal sides on a circle, whose ends are so far apart
    turn = brentq(
        lambda t: bond * np.sin(steps * t / 2) - distance * np.sin(t / 2), 1e-3, 2 * np.pi / steps
    )
    radius = bond / (2 * np.sin(turn / 2))
    angle = turn * (np.arange(1, steps) - steps / 2)
    right, up = across / distance, np.array([0.0, 0.0, 1.0])
    out = np.sin(angle)[:, None] * right + np.cos(angle)[:, None] * up
    along = np.cos(angle)[:, None] * right - np.sin(angle)[:, None] * up
    middle = (start + end) / 2 - radius * np.cos(steps * turn / 2) * up
    loop_centre = centre_of(middle + radius * out, out, -along)
    other = "".join(COMPLEMENT[base] for base in reversed(stem))
    parts = zip((centre, a1, a3), (loop_centre, out, -along), strict=True)
    return system_of(
        [(stem + loop + other, *(np.concatenate([x[0], y, x[1, ::-1]]) for x, y in parts))]
    )


def nicked(sequence, after):
    """An ideal duplex whose first strand is in two pieces."""
    one = helix(sequence)
    n = len(sequence)
    pieces = [slice(0, after), slice(after, n), slice(n, 2 * n)]
    return system_of([("".join(one.base[s]), one.centre[s], one.a1[s], one.a3[s]) for s in pieces])


def moved(system, rotation, shift):
    """The same nucleotides, rotated as a whole and shifted."""
    turn = rotation.as_matrix().T
    return replace(
        system,
        centre=system.centre @ turn + shift,
        a1=system.a1 @ turn,
        a3=system.a3 @ turn,
    )


def shaken(system, rng, shift=0.03, turn=0.1):
    """The same nucleotides, each moved and turned a little at random."""
    n = len(system)
    turns = Rotation.from_rotvec(turn * rng.normal(size=(n, 3)))
    return replace(
        system,
        centre=system.centre + shift * rng.normal(size=(n, 3)),
        a1=turns.apply(system.a1.copy()),
        a3=turns.apply(system.a3.copy()),
    )
