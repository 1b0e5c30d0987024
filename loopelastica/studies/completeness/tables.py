"""Shares over many poses: what lists have of the rods hit, and what they say that they lack."""

from collections.abc import Sequence
from typing import Any

import numpy as np

Row = dict[str, Any]

# poses in a bin of the reliability diagram, at least
_BIN = 30
# draws of poses for an interval, and its ends
_DRAWS, _ENDS = 1000, (0.05, 0.95)


def coverage(rows: Sequence[Row], indices: Sequence[str]) -> list[Row]:
    """Shares of hits and rods that are listed, a row per effort and kind of pose.

    Parameters
    ----------
    rows : sequence of dict
        Lines of ``poses.csv``.
    indices : sequence of str
        Columns of the Morse indices.

    Returns
    -------
    list of dict
        ``effort``, ``kind`` ("all" first), numbers, percentages and times.
    """
    table = []
    for effort in dict.fromkeys(row["effort"] for row in rows):
        of_effort = [row for row in rows if row["effort"] == effort]
        for kind in ("all", *dict.fromkeys(row["kind"] for row in of_effort)):
            chosen = [row for row in of_effort if kind in ("all", row["kind"])]
            times = [row["seconds"] for row in chosen]
            line = {
                "effort": effort,
                "kind": kind,
                "poses": len(chosen),
                "listed": sum(row["listed"] for row in chosen),
                "listed_hit": sum(row["listed_hit"] for row in chosen),
                "seconds_median": float(np.median(times)),
                "seconds_max": max(times),
            }
            for key in ("hits", "rods", *indices):
                done = "_listed" if key in ("hits", "rods") else " listed"
                total = sum(row[key] for row in chosen)
                line[key] = total
                line[f"{key} %"] = _percent(sum(row[key + done] for row in chosen), total)
            table.append(line)
    return table


def _percent(part: int, whole: int) -> float | None:
    return 100.0 * part / whole if whole else None


def reliability(rows: Sequence[Row]) -> list[Row]:
    """What lists said of rods unseen beside what was missing, in bins of what was said.

    Parameters
    ----------
    rows : sequence of dict
        Lines of ``poses.csv``.

    Returns
    -------
    list of dict
        Per effort and bin, each of at least 30 poses unless there are fewer: the mean of what was
        said, and the shares of rods and of hits that were missing, with an interval from draws of
        poses for the former.
    """
    table = []
    for effort in dict.fromkeys(row["effort"] for row in rows):
        chosen = [row for row in rows if row["effort"] == effort and row["rods"]]
        for group in _bins(sorted(chosen, key=lambda row: float(row["unseen"]))):
            said = [row["unseen"] for row in group]
            rods, missed = _pooled(group, "rods")
            hits, missed_hits = _pooled(group, "hits")
            low, high = _interval(rods, missed)
            table.append(
                {
                    "effort": effort,
                    "poses": len(group),
                    "said_least": min(said),
                    "said_most": max(said),
                    "said": float(np.mean(said)),
                    "rods": int(rods.sum()),
                    "rods_missed": float(missed.sum() / rods.sum()),
                    "rods_missed_low": low,
                    "rods_missed_high": high,
                    "hits": int(hits.sum()),
                    "hits_missed": float(missed_hits.sum() / hits.sum()),
                    "rods_missed_per_pose": float(np.mean(missed / rods)),
                }
            )
    return table


def _bins(rows: list[Row]) -> list[list[Row]]:
    """Rows in order, cut where enough are together and what they say differs."""
    groups: list[list[Row]] = []
    for row in rows:
        if not groups or (len(groups[-1]) >= _BIN and row["unseen"] > groups[-1][-1]["unseen"]):
            groups.append([])
        groups[-1].append(row)
    if len(groups) > 1 and len(groups[-1]) < _BIN:
        rest = groups.pop()
        groups[-1] += rest
    return groups


def _pooled(rows: Sequence[Row], key: str) -> tuple[Any, Any]:
    """Numbers (n,) of rods or hits per pose, and of those missed."""
    total = np.array([row[key] for row in rows], dtype=np.float64)
    return total, total - np.array([row[f"{key}_listed"] for row in rows])


def _interval(total: Any, missed: Any) -> tuple[float, float]:
    """Where the pooled share lies if the poses are drawn again."""
    drawn = np.random.default_rng(0).integers(0, len(total), (_DRAWS, len(total)))
    shares = missed[drawn].sum(axis=1) / total[drawn].sum(axis=1)
    low, high = np.quantile(shares, _ENDS)
    return float(low), float(high)
