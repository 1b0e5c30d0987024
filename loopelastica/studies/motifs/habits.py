"""How often loops have C2'-endo sugars and syn bases: the table, and what it is worth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from scipy.optimize import minimize

from loopelastica._arrays import Array
from loopelastica.atoms.habits import TERMS, holds
from loopelastica.studies.motifs.corpus import StudyLoop

HABITS: Final = ("c2_endo", "syn")
FOLDS: Final = 10
_RIDGE: Final = 1.0


def shares(loops: Sequence[StudyLoop]) -> dict[str, list[float]]:
    """Share of C2'-endo and syn at each nucleotide of loops of one length.

    Each sequence counts once; a place of which nothing is known has the share of all.
    """
    out = {}
    weights = _weights(loops)[:, None]
    for name in HABITS:
        values = np.array([getattr(loop, name) for loop in loops])
        there = np.isfinite(values)
        seen = (weights * there).sum(axis=0)
        share = (weights * np.where(there, values, 0.0)).sum(axis=0)
        overall = share.sum() / max(seen.sum(), 1e-9)
        each = np.where(seen > 0.0, share / np.maximum(seen, 1e-9), overall)
        out[name] = each.round(2).tolist()
    return out


def habit_table(loops: Sequence[StudyLoop]) -> dict[str, dict[str, float]]:
    """The terms of :mod:`loopelastica.atoms.habits`, by logistic regression."""
    return {name: dict(zip(TERMS, fitted(*_cases(loops, name)[:3]).round(2).tolist(), strict=True))
            for name in HABITS}  # fmt: skip


def habit_rows(loops: Sequence[StudyLoop]) -> list[dict[str, Any]]:
    """What the terms say of families that had no part in their fit.

    Parameters
    ----------
    loops : sequence of StudyLoop

    Returns
    -------
    list of dict
        Per habit: nucleotides, the share that has it, mean of minus the logarithm of the
        probability of what is there, by the terms and by the share alone; how often one with the
        habit is given a higher probability than one without. NaN of one family alone.
    """
    rows = []
    for name in HABITS:
        terms, has, weights, families = _cases(loops, name)
        names = np.unique(families)
        fold = np.random.default_rng(0).integers(0, FOLDS, len(names))[
            np.searchsorted(names, families)
        ]
        share = np.full(len(has), np.nan)
        flat = np.full(len(has), np.nan)
        for k in range(FOLDS):
            inside, out = fold != k, fold == k
            if inside.any() and out.any():
                share[out] = _probability(terms[out], fitted(terms[inside], has[inside],
                                                             weights[inside]))  # fmt: skip
                flat[out] = np.average(has[inside], weights=weights[inside])
        rows.append(
            {
                "habit": name,
                "nucleotides": len(has),
                "share": float(np.average(has, weights=weights)),
                "loss": _loss(share, has, weights),
                "loss_flat": _loss(flat, has, weights),
                "ordered": _ordered(share, has, weights),
            }
        )
    return rows


def fitted(terms: Array, has: Array, weights: Array) -> Array:
    """Weighted logistic regression with a ridge on all terms but the first."""

    def value(b: Array) -> tuple[float, Array]:
        p = _probability(terms, b)
        ridge = np.concatenate([[0.0], _RIDGE * b[1:]])
        loss = -float(weights @ np.log(np.where(has > 0.5, p, 1.0 - p) + 1e-12))
        return loss + 0.5 * float(ridge @ b), ridge - terms.T @ (weights * (has - p))

    return np.asarray(minimize(value, np.zeros(terms.shape[1]), jac=True, method="L-BFGS-B").x)


def _cases(loops: Sequence[StudyLoop], name: str) -> tuple[Array, Array, Array, Array]:
    """Terms that hold, whether the habit is there, weights and families, a row per nucleotide."""
    terms, has, weights, families = [], [], [], []
    for loop, weight in zip(loops, _weights(loops), strict=True):
        letters = loop.hairpin.sequence[1:-1]
        values = getattr(loop, name)
        for row, value in zip(holds(letters, [loop.hairpin.is_dna] * loop.n), values, strict=True):
            if np.isfinite(value):
                terms.append(row)
                has.append(value)
                weights.append(weight)
                families.append(loop.family)
    return np.array(terms), np.array(has), np.array(weights), np.array(families)


def _weights(loops: Sequence[StudyLoop]) -> Array:
    names = [loop.loop for loop in loops]
    return np.array([1.0 / names.count(name) for name in names])


def _probability(terms: Array, b: Array) -> Array:
    return np.asarray(1.0 / (1.0 + np.exp(-terms @ b)))


def _loss(share: Array, has: Array, weights: Array) -> float:
    known = np.isfinite(share)
    if not known.any():
        return math.nan
    p = np.where(has > 0.5, share, 1.0 - share)[known]
    return float(np.average(-np.log(np.maximum(p, 1e-12)), weights=weights[known]))


def _ordered(share: Array, has: Array, weights: Array) -> float:
    known = np.isfinite(share)
    p, yes, w = share[known], has[known] > 0.5, weights[known]
    above = (p[yes][:, None] > p[~yes]) + 0.5 * (p[yes][:, None] == p[~yes])
    both = w[yes][:, None] * w[~yes]
    return float((above * both).sum() / max(both.sum(), 1e-12))
