"""Systems that several tests of nanostructures use, made from strands."""

import numpy as np
from scipy.spatial.transform import Rotation

from loopelastica.nanostructure.model import duplex
from loopelastica.nanostructure.system import System

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


def hairpin(stem, loop, spread=0.9):
    """A stem and a loop on an arc that closes it: of bonds that are about right."""
    n = len(stem)
    centre, a1, a3 = duplex(n)
    start, end = centre[0, -1], centre[1, -1]
    angle = np.linspace(0, np.pi, len(loop) + 2)[1:-1]
    middle, half = (start + end) / 2, (start - end) / 2
    up = np.array([0.0, 0.0, 1.0]) * np.linalg.norm(half) * spread * len(loop) / 2
    arc = middle + np.cos(angle)[:, None] * half + np.sin(angle)[:, None] * up
    tangent = -np.sin(angle)[:, None] * half + np.cos(angle)[:, None] * up
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    inward = np.cross(tangent, np.cross(half, up) / np.linalg.norm(np.cross(half, up)))
    other = "".join(COMPLEMENT[base] for base in reversed(stem))
    return system_of(
        [
            (
                stem + loop + other,
                np.concatenate([centre[0], arc, centre[1, ::-1]]),
                np.concatenate([a1[0], inward, a1[1, ::-1]]),
                np.concatenate([a3[0], -tangent, a3[1, ::-1]]),
            )
        ]
    )


def shaken(system, rng, shift=0.03, turn=0.1):
    """The same nucleotides, each moved and turned a little at random."""
    from dataclasses import replace

    n = len(system)
    turns = Rotation.from_rotvec(turn * rng.normal(size=(n, 3)))
    return replace(
        system,
        centre=system.centre + shift * rng.normal(size=(n, 3)),
        a1=turns.apply(system.a1.copy()),
        a3=turns.apply(system.a3.copy()),
    )
