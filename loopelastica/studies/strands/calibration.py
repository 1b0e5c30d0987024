"""The table of expected errors from the rows of a deletion study: fit, quantiles, coverage."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica.folding.expected import CLASSES, SHIFT_A

FEWEST_ENTRIES = 5
_QUANTILES = (0.1, 0.5, 0.9)
_FOLDS = 10
_RIDGE = 2.0


def calibrated(rows: Sequence[Mapping[str, Any]]) -> dict[str, tuple[list[float], list[float]]]:
    """Coefficients and residual quantiles of each class of length.

    Of RNA duplexes with one strand taken out nothing is learned: real gaps are none.

    Parameters
    ----------
    rows : sequence of mapping
        Of the study, with ``signs``, ``class``, ``file`` and ``rmsd_atoms_A``.

    Returns
    -------
    dict
        As ``TABLE`` of :mod:`loopelastica.folding.expected`.
    """
    table = {}
    for _, name in CLASSES:
        x, y, entry = _data(rows, name)
        # from fewer nothing is learned about entries that were not seen
        if len(set(entry.tolist())) < FEWEST_ENTRIES:
            continue
        residual = np.empty(len(y))
        for fold in range(_FOLDS):
            out = entry % _FOLDS == fold
            if out.any():
                residual[out] = y[out] - x[out] @ _fit(x[~out], y[~out])
        b = _fit(x, y)
        # entries are the cases, not their strands: each counts by its root
        weight = 1.0 / np.sqrt(np.bincount(entry)[entry])
        table[name] = (
            [round(float(value), 3) for value in b],
            [round(_quantile(residual, weight, q), 3) for q in _QUANTILES],
        )
    return table


def covered(rows: Sequence[Mapping[str, Any]]) -> dict[str, tuple[int, float, float]]:
    """Strands, share inside the 80 % interval, and median 90 % over 10 %, by class of length.

    The quantiles of each tenth of the entries are those of the others.

    Parameters
    ----------
    rows : sequence of mapping
        As for :func:`calibrated`.

    Returns
    -------
    dict
    """
    found: dict[str, list[tuple[bool, float]]] = defaultdict(list)
    for _, name in CLASSES:
        x, y, entry = _data(rows, name)
        for fold in range(_FOLDS):
            out = entry % _FOLDS == fold
            if not out.any() or out.all():
                continue
            own = [row for row, there in zip(_own(rows, name), ~out, strict=True) if there]
            table = calibrated(own)
            if name not in table:
                continue
            b, (low, _, high) = table[name]
            away = y[out] - x[out] @ np.array(b)
            found[name] += [(bool(low <= r <= high), float(np.exp(high - low))) for r in away]
    return {
        name: (len(own), float(np.mean([i for i, _ in own])), float(np.median([w for _, w in own])))
        for name, own in found.items()
    }


def _own(rows: Sequence[Mapping[str, Any]], name: str) -> list[Mapping[str, Any]]:
    return [
        row
        for row in rows
        if row.get("rmsd_atoms_A") is not None
        and row["class"] == name
        and (row["kind"], row["type"]) != ("RNA", "helix")
    ]


def _data(rows: Sequence[Mapping[str, Any]], name: str) -> tuple[Array, Array, NDArray[np.int64]]:
    own = _own(rows, name)
    x = np.array([row["signs"] for row in own], dtype=np.float64)
    y = np.log(np.array([row["rmsd_atoms_A"] for row in own]) + SHIFT_A)
    files = sorted({row["file"] for row in rows})
    return x, y, np.array([files.index(row["file"]) for row in own], dtype=np.int64)


def _fit(x: Array, y: Array) -> Array:
    # a weak pull to no influence, the constant left alone
    ridge = _RIDGE * np.diag([0.0] + [1.0] * (x.shape[1] - 1))
    return np.asarray(np.linalg.solve(x.T @ x + ridge, x.T @ y))


def _quantile(values: Array, weight: Array, q: float) -> float:
    order = np.argsort(values)
    total = np.cumsum(weight[order])
    return float(values[order][np.searchsorted(total, q * total[-1])])
