"""Worm-like samples in the place of rods and tails, brought apart as those were."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from loopelastica.nanostructures.laying.chains import Chains
from loopelastica.nanostructures.laying.conflicts import CONFLICT, conflicts_of, strands_of
from loopelastica.nanostructures.laying.ends import across
from loopelastica.nanostructures.laying.laid import Sample
from loopelastica.nanostructures.laying.strands import Strands
from loopelastica.nanostructures.laying.wormlike import free_chain, held_chains, stiffness
from loopelastica.nanostructures.oxdna.model import BOND_LENGTH
from loopelastica.nanostructures.oxdna.periodic import nearest_image
from loopelastica.nanostructures.singles import Single, SingleKind

# how often strands that stay in conflict are drawn
_ROUNDS: Final = 3


def draw_sample(strands: Strands, seed: tuple[int, int], persistence: float) -> Sample:
    """Worm-like strands in the place of rods and tails, brought apart as those were."""
    kept = strands.chains
    strands.chains = replace(kept, sites=kept.sites.copy(), direction=kept.direction.copy())
    which = [k for k, shape in enumerate(strands.shape) if shape and shape != "as given"
             and strands.singles[k].kind not in (SingleKind.FREE, SingleKind.CIRCLE)]  # fmt: skip
    for attempt in range(_ROUNDS):
        _draw(strands, which, (*seed, attempt), persistence)
        _, found = strands.resolve()
        system = strands.composed()
        which = np.intersect1d(strands_of(found, kept.strand, CONFLICT), which).tolist()
        if not which:
            break
    labels = [strands.label(k) for k in range(len(strands.singles))]
    left = conflicts_of(system, found, kept.strand, labels)
    strands.chains = kept
    return Sample(system, tuple(one for k in sorted(left) for one in left[k]))


def _draw(strands: Strands, which: list[int], seed: tuple[int, ...], persistence: float) -> None:
    chains, held = strands.chains, []
    kappas: dict[float, float] = {}
    for k in which:
        bond = round(float(chains.bond[strands.singles[k].nucleotides[0]]), 6)
        kappas.setdefault(bond, stiffness(bond / persistence))

    def kappa(k: int) -> float:
        return kappas[round(float(chains.bond[strands.singles[k].nucleotides[0]]), 6)]

    def generator(k: int) -> np.random.Generator:
        return np.random.default_rng([*seed, int(strands.singles[k].nucleotides[0])])

    for k in which:
        one = strands.singles[k]
        if one.before >= 0 and one.after >= 0:
            held.append(k)
            continue
        ahead = one.before >= 0
        anchor = one.before if ahead else one.after
        rows = one.nucleotides if ahead else one.nucleotides[::-1]
        tangent = chains.tangent[anchor] if ahead else -chains.tangent[anchor]
        chains.sites[rows] = free_chain(
            chains.sites[anchor], tangent, BOND_LENGTH, kappa(k), len(rows), generator(k)
        )
    starts = []
    for k in held:
        one = strands.singles[k]
        line = chains.sites[[one.before, *one.nucleotides.tolist(), one.after]]
        steps = nearest_image(np.diff(line, axis=0), strands.system.box)
        starts.append(line[0] + np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)]))
    clamps = np.array(
        [chains.tangent[[strands.singles[k].before, strands.singles[k].after]] for k in held]
    ).reshape(-1, 2, 3)
    drawn = held_chains(
        starts, clamps, np.array([kappa(k) for k in held]), [generator(k) for k in held]
    )
    for k, points in zip(held, drawn, strict=True):
        chains.sites[strands.singles[k].nucleotides] = points[1:-1]
    for k in which:
        _face(chains, strands.singles[k])


def _face(chains: Chains, one: Single) -> None:
    """Let bases look across their strand, from one end's direction to the other's."""
    chain = [end for end in (one.before, *one.nucleotides.tolist(), one.after) if end >= 0]
    tangent = np.gradient(chains.sites[chain], axis=0)
    ends = [end for end in (one.before, one.after) if end >= 0]
    share = np.linspace(0.0, 1.0, len(chain))[:, None]
    towards = (1 - share) * chains.direction[ends[0]] + share * chains.direction[ends[-1]]
    size = np.linalg.norm(tangent, axis=1, keepdims=True)
    found = across(towards, tangent / np.maximum(size, 1e-12))
    inner = slice(int(one.before >= 0), len(chain) - int(one.after >= 0))
    chains.direction[one.nucleotides] = found[inner]
