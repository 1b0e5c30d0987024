"""Each fitted constant judged on families that had no part in it.

Loops of one family (`evaluation.loops`) are left out together; taper and extensions are chosen anew
from all others by the least family-averaged RMSD, separately for DNA and RNA.
"""

from typing import Any

import numpy as np

from loopelastica._arrays import Array
from loopelastica.molecule.clamp_rule import default_clamp
from loopelastica.studies.evaluation.loops import EXTENSIONS, TAPERS

# lengths that share one entry of the table of extensions
LENGTHS = ((3, 5), (6, 6), (7, 8), (9, 9))
_UNREACHABLE_A = 30.0
RESAMPLES = 2000


def refitted_A(rows: list[dict[str, Any]]) -> dict[str, Array]:
    """RMSD of every loop with constants chosen without its family.

    Parameters
    ----------
    rows : list of dict
        Simple loops, each with its ``grid``.

    Returns
    -------
    dict
        ``taper``: the taper alone refitted; ``all``: taper and the extensions of each class of
        lengths. Arrays (n,) in Å, in the order of `rows`.
    """
    grid = np.array(
        [[[_UNREACHABLE_A if v is None else v for v in line] for line in r["grid"]] for r in rows]
    ).reshape(len(rows), len(TAPERS), len(EXTENSIONS))
    kinds = np.array([r["kind"] for r in rows])
    families = np.array([r["family"] for r in rows])
    classes = np.array([_class(r["nucleotides"]) for r in rows])
    of_rule = np.array([_entry(r) for r in rows], dtype=int)
    taper_alone, everything = np.zeros(len(rows)), np.zeros(len(rows))
    for family in np.unique(families):
        out = families == family
        for kind in np.unique(kinds[out]):
            train = (kinds == kind) & ~out
            if not train.any():  # nothing to choose from: the rule as it is
                train = kinds == kind
            weights = 1.0 / np.array([(families[train] == f).sum() for f in families[train]])
            errors = grid[train] * weights[:, None, None]
            by_rule = np.take_along_axis(errors, of_rule[train][:, None, None], axis=2)
            taper = int(by_rule.sum(axis=(0, 2)).argmin())
            sums = np.zeros((len(LENGTHS), len(TAPERS), len(EXTENSIONS)))
            np.add.at(sums, classes[train], errors)
            best_taper = int(sums.min(axis=2).sum(axis=0).argmin())
            entries = sums[:, best_taper].argmin(axis=1)
            # a length that no other family has keeps the rule's entry
            elsewhere = np.bincount(classes[train], minlength=len(LENGTHS)) > 0
            for i in np.flatnonzero(out & (kinds == kind)):
                taper_alone[i] = grid[i, taper, of_rule[i]]
                entry = entries[classes[i]] if elsewhere[classes[i]] else of_rule[i]
                everything[i] = grid[i, best_taper, entry]
    return {"taper": taper_alone, "all": everything}


def interval(
    difference_A: Array, families: list[str], seed: int = 20181115
) -> tuple[float, float, float]:
    """Mean of a paired difference over families, and its 95 % bootstrap interval.

    Parameters
    ----------
    difference_A : (n,) ndarray
        Of each loop, Å.
    families : list of str
        The family of each loop; families are drawn, not loops.
    seed : int

    Returns
    -------
    mean, low, high : float
        Å.
    """
    names = sorted(set(families))
    of = np.array(families)
    means = np.array([difference_A[of == name].mean() for name in names])
    draws = np.random.default_rng(seed).integers(0, len(names), (RESAMPLES, len(names)))
    low, high = np.percentile(means[draws].mean(axis=1), [2.5, 97.5])
    return float(means.mean()), float(low), float(high)


def _class(n: int) -> int:
    return next(k for k, (low, high) in enumerate(LENGTHS) if low <= n <= high)


def _entry(row: dict[str, Any]) -> int:
    clamp = default_clamp(row["kind"] == "DNA", row["nucleotides"])
    return EXTENSIONS.index((clamp.stem_extend_5, clamp.stem_extend_3))
