"""The tables of the deletion study."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from loopelastica.studies.bench.markdown import markdown_table

Row = Mapping[str, Any]
_METHODS = {
    "chord": "rmsd_chord_A",
    "cubic": "rmsd_cubic_A",
    "free rod": "rmsd_free_rod_A",
    "rod in its surroundings": "rmsd_line_A",
    "atoms": "rmsd_atoms_A",
    "best of five": "rmsd_best_of_five_A",
    "PDBFixer": "pdbfixer_rmsd_A",
}


def report(rows: Sequence[Row]) -> str:
    """Tables in markdown.

    Parameters
    ----------
    rows : sequence of mapping
        One per strand.

    Returns
    -------
    str
    """
    built = [row for row in rows if "sound" in row]
    lines = [f"{len(rows)} strands, {len(built)} filled; median / 90 % in Å", ""]
    lines.append(_errors(built))
    lines += ["", "Chemistry and time", "", _chemistry(built)]
    lines += ["", "Expected error: share of strands within the 80 % interval", "", _cover(built)]
    failed = [row for row in rows if "sound" not in row]
    if failed:
        lines += ["", *(f"- {row['file']} {row['strand']}: {row['failure']}" for row in failed)]
    return "\n".join([*lines, ""])


def grouped(rows: Iterable[Row]) -> dict[tuple[str, str], list[Row]]:
    """Rows by kind and type, and class of length; those of paired flanks once more together."""
    groups: dict[tuple[str, str], list[Row]] = defaultdict(list)
    for row in rows:
        groups[f"{row['kind']} {row['type']}", row["class"]].append(row)
        if row["type"] in ("bulge", "internal", "junction"):
            groups[f"{row['kind']} paired flanks", row["class"]].append(row)
    order = {"1": 0, "2": 1, "3-4": 2, "5-9": 3, "10-12": 4}
    return {k: groups[k] for k in sorted(groups, key=lambda key: (key[0], order[key[1]]))}


def _errors(rows: Sequence[Row]) -> str:
    table = []
    for (what, length), own in grouped(rows).items():
        line: dict[str, Any] = {"what": what, "n": length, "N": len(own)}
        for name, key in _METHODS.items():
            values = [row[key] for row in own if row.get(key) is not None]
            if values:
                line[name] = f"{np.median(values):.2f} / {np.quantile(values, 0.9):.2f}"
        both = [r for r in own if r.get("pdbfixer_rmsd_A") is not None]
        if both:
            ours = float(np.median([r["rmsd_atoms_A"] for r in both]))
            line["ratio"] = ours / float(np.median([r["pdbfixer_rmsd_A"] for r in both]))
        table.append(line)
    columns = {"what": ("strand", ""), "n": ("n", ""), "N": ("N", "d")}
    columns |= {name: (name, "") for name in _METHODS}
    return markdown_table(table, {**columns, "ratio": ("atoms / PDBFixer", ".2f")})


def _chemistry(rows: Sequence[Row]) -> str:
    table = []
    for length in ("1", "2", "3-4", "5-9", "10-12"):
        own = [row for row in rows if row["class"] == length]
        if not own:
            continue
        peers = [row for row in own if row.get("pdbfixer_s") is not None]
        line: dict[str, Any] = {
            "n": length,
            "N": len(own),
            "sound": 100.0 * float(np.mean([row["sound"] for row in own])),
            "hands": sum(row["wrong_hands"] > 0 for row in own),
            "bonds": sum(row["worst_bond_A"] > 0.05 for row in own),
            "contacts": sum(row["closest_A"] < 2.2 for row in own),
            "lines": 1e3 * float(np.median([row["lines_s"] for row in own])),
            "whole": float(np.median([row["whole_s"] for row in own])),
            "whole90": float(np.quantile([row["whole_s"] for row in own], 0.9)),
        }
        if peers:
            line |= {
                "peers": len(peers),
                "peer_hands": sum(row["pdbfixer_wrong_hands"] > 0 for row in peers),
                "peer_contacts": sum(row["pdbfixer_closest_A"] < 2.2 for row in peers),
                "peer_s": float(np.median([row["pdbfixer_s"] for row in peers])),
            }
        table.append(line)
    return markdown_table(
        table,
        {
            "n": ("n", ""),
            "N": ("N", "d"),
            "sound": ("sound, %", ".1f"),
            "hands": ("wrong hands", "d"),
            "bonds": ("bonds off by 0.05 Å", "d"),
            "contacts": ("contacts under 2.2 Å", "d"),
            "lines": ("lines, ms", ".0f"),
            "whole": ("all, s", ".2f"),
            "whole90": ("90 %", ".2f"),
            "peers": ("PDBFixer: N", "d"),
            "peer_hands": ("wrong hands", "d"),
            "peer_contacts": ("contacts under 2.2 Å", "d"),
            "peer_s": ("s", ".1f"),
        },
    )


def _cover(rows: Sequence[Row]) -> str:
    table = []
    for length in ("1", "2", "3-4", "5-9", "10-12", "all"):
        own = [row for row in rows if length in (row["class"], "all")]
        if own:
            inside = [r["expected_10_A"] <= r["rmsd_atoms_A"] <= r["expected_90_A"] for r in own]
            wide = [r["expected_90_A"] / r["expected_10_A"] for r in own]
            table.append(
                {
                    "n": length,
                    "N": len(own),
                    "inside": 100.0 * float(np.mean(inside)),
                    "wide": float(np.median(wide)),
                }
            )
    return markdown_table(
        table,
        {"n": ("n", ""), "N": ("N", "d"), "inside": ("inside, %", ".0f"),
         "wide": ("median 90 % / 10 %", ".1f")},
    )  # fmt: skip
