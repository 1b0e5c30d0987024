"""The tables of ``data/motifs.json``: shapes of motifs and lengths, and how far answers are off."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.folding.motifs import CLASSES, SHIFT_A, class_of, signs
from loopelastica.molecule.trace import rmsd_A
from loopelastica.rod.chain import deform_batch
from loopelastica.studies.coverage import weighted_quantiles
from loopelastica.studies.motifs.corpus import MOTIFS, StudyLoop
from loopelastica.studies.motifs.habits import shares
from loopelastica.studies.motifs.judge import per_sequence

QUANTILES: Final = (0.1, 0.5, 0.9)
FOLDS: Final = 10
POOLED: Final = 15.0
"""So many sequences of a class weigh as much as all of the kind together."""
_RIDGE: Final = 0.5
FEWEST: Final = 8
"""Sequences of a kind, below which no table of errors is made of it alone."""


def motif_rows(loops: Sequence[StudyLoop]) -> list[dict[str, Any]]:
    """The motifs of two sequences at least: shape, pattern, counts, errors on others of them."""
    of = {name: [x for x in loops if x.motif == name] for name in MOTIFS}
    return [
        _row(name, pattern, "RNA", of[name])
        for name, pattern in MOTIFS.items()
        if len({x.loop for x in of[name]}) >= 2
    ]


def length_rows(loops: Sequence[StudyLoop]) -> list[dict[str, Any]]:
    """One shape per length and kind, of three sequences at least."""
    rows = []
    for kind in ("RNA", "DNA"):
        for n in sorted({x.n for x in loops}):
            of = [x for x in loops if x.n == n and x.hairpin.kind == kind]
            if len({x.loop for x in of}) >= 3:
                rows.append(_row(f"{n} nucleotides", "N" * n, kind, of))
    return rows


def _row(name: str, pattern: str, kind: str, loops: Sequence[StudyLoop]) -> dict[str, Any]:
    steps, end = mean_shape(loops)
    errors, spread = [], []
    for loop in loops:
        # of a motif other sequences stay, of a length other families
        others = [
            x for x in loops
            if x.loop != loop.loop and (loop.motif == name or x.family != loop.family)
        ]  # fmt: skip
        if others:
            errors.append((loop, _error(*mean_shape(others), loop)))
            spread.append(_error(steps, end, loop))
    rows = [{"loop": loop.loop, "n": loop.n} for loop, _ in errors]
    each = per_sequence(rows, np.array([error for _, error in errors]))[1]
    return {
        "name": name,
        "pattern": pattern,
        "kind": kind,
        "loops": len(loops),
        "sequences": len({x.loop for x in loops}),
        "families": len({x.family for x in loops}),
        "rmsd_A": np.quantile(each, [0.5, 0.9]).round(2).tolist(),
        "spread_A": round(float(np.mean(per_sequence(rows, np.array(spread))[1])), 2),
        "steps_A": steps.round(4).tolist(),
        "end_frame": end.round(6).tolist(),
        **shares(loops),
    }


def mean_shape(loops: Sequence[StudyLoop]) -> tuple[Array, Array]:
    """Mean steps and end frame, each sequence counted once."""
    names = [x.loop for x in loops]
    weights = np.array([1.0 / names.count(name) for name in names])
    weights /= weights.sum()
    steps = np.tensordot(weights, np.array([x.found.shape.steps_A for x in loops]), axes=1)
    frames = np.tensordot(weights, np.array([x.found.shape.end_frame for x in loops]), axes=1)
    u, _, vt = np.linalg.svd(frames)
    return np.asarray(steps), np.asarray(u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt)


def _error(steps: Array, end: Array, loop: StudyLoop) -> float:
    batch = deform_batch(steps, end, loop.poses.position_A, loop.poses.rotation)
    return rmsd_A(batch.nodes[0, 1:-1], loop.native_A) if batch.converged[0] else np.inf


def error_tables(rows: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """How far each kind of answer is off (:class:`loopelastica.folding.motifs.Errors`)."""
    tables = {}
    for kind, of_kind in by_kind(rows).items():
        if len({row["loop"] for row in of_kind}) >= FEWEST:
            b, quantiles = fit(of_kind)
            tables[kind] = {
                "b": b.round(3).tolist(),
                "quantiles": {c: q.round(3).tolist() for c, q in quantiles.items()},
                "sequences": len({row["loop"] for row in of_kind}),
            }
    return tables


def by_kind(rows: Iterable[Mapping[str, Any]]) -> dict[str, list[Mapping[str, Any]]]:
    """Rows by their kind, those of any motif once more together."""
    kinds: dict[str, list[Mapping[str, Any]]] = {}
    for row in rows:
        kinds.setdefault(row["kind"], []).append(row)
        if row["kind"].startswith("motif "):
            kinds.setdefault("motif", []).append(row)
    return kinds


def held_out(rows: Sequence[Mapping[str, Any]]) -> Array:
    """10, 50 and 90 % of the error of each row (m, 3), by fits to other families, Å."""
    fold = _folds(rows)
    expected = np.full((len(rows), 3), np.nan)
    for k in range(FOLDS):
        inside = [row for row, f in zip(rows, fold, strict=True) if f != k]
        out = np.flatnonzero(fold == k)
        if not len(out) or not inside:
            continue
        b, quantiles = fit(inside)
        for i in out.tolist():
            log = np.asarray(_signs(rows[i]) @ b + quantiles[class_of(rows[i]["n"])])
            expected[i] = np.maximum(np.exp(log) - SHIFT_A, 0.0)
    return expected


def fit(rows: Sequence[Mapping[str, Any]]) -> tuple[Array, dict[str, Array]]:
    """Coefficients, and quantiles of the residual by class of length.

    Residuals are those of families that a fit has not seen; a class with few sequences keeps near
    to all of the kind.
    """
    x = np.array([_signs(row) for row in rows])
    y = np.log(np.array([row["rmsd_A"] for row in rows]) + SHIFT_A)
    weights = sequence_weights(rows)
    fold = _folds(rows)
    residual = np.empty(len(y))
    for k in range(FOLDS):
        out = fold == k
        if out.any():
            inside = ~out if (~out).any() else out
            residual[out] = y[out] - x[out] @ _solve(x[inside], y[inside], weights[inside])
    pooled = weighted_quantiles(residual, weights, QUANTILES)
    quantiles = {}
    for _, name in CLASSES:
        of = np.array([class_of(row["n"]) == name for row in rows])
        share = weights[of].sum() / (weights[of].sum() + POOLED)
        own = weighted_quantiles(residual[of], weights[of], QUANTILES) if of.any() else pooled
        quantiles[name] = share * own + (1.0 - share) * pooled
    return _solve(x, y, weights), quantiles


def sequence_weights(rows: Sequence[Mapping[str, Any]]) -> Array:
    """One over the number of rows of the same loop sequence, kind and place."""
    keys = [(row["loop"], row["kind"], row["place"]) for row in rows]
    counts: dict[Any, int] = {}
    for key in keys:
        counts[key] = counts.get(key, 0) + 1
    return np.array([1.0 / counts[key] for key in keys])


def _signs(row: Mapping[str, Any]) -> Array:
    return signs(row["spread_A"], row["energy"])


def _solve(x: Array, y: Array, weights: Array) -> Array:
    """Least squares; in doubt the error is in proportion to the spread, whatever the energy."""
    likely = np.array([0.0, 1.0, 0.0])
    stiff = np.diag([0.0, _RIDGE, _RIDGE])
    xw = x * weights[:, None]
    return np.asarray(np.linalg.solve(x.T @ xw + stiff, xw.T @ y + stiff @ likely))


def _folds(rows: Sequence[Mapping[str, Any]]) -> Array:
    """Fold of each row: families stay together, large and small ones go round."""
    # a motif is one family: its sequences are what it is judged on
    group = "loop" if all(row["motif"] for row in rows) else "family"
    members: dict[str, set[str]] = {}
    for row in rows:
        members.setdefault(row[group], set()).add(row["loop"])
    order = sorted(members, key=lambda name: (-len(members[name]), name))
    fold = {name: k % FOLDS for k, name in enumerate(order)}
    return np.array([fold[row[group]] for row in rows])
