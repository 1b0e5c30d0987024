"""Atoms for the loops of a folder of structures: how good is the chemistry, how far the backbone.

Simple loops only, those without pairs to nucleotides outside; first model, first candidate.
"""

import resource
import statistics
from pathlib import Path
from typing import Any

from loopelastica._files import write_csv, write_json
from loopelastica._names import printable
from loopelastica.errors import LoopelasticaError
from loopelastica.molecule.folders import structure_files


def run(folder: Path, out: Path, *, sample: int | None = None, progress: bool = False) -> str:
    """Measure; write ``atoms.csv`` (a row per loop) and ``atoms.json`` (the summary).

    Parameters
    ----------
    folder : Path
        PDB and mmCIF files, gzipped or not.
    out : Path
    sample : int, optional
        Only so many files, evenly spread over the names.
    progress : bool
        Show a bar.

    Returns
    -------
    str
        The summary in words.

    Raises
    ------
    ValueError
        If `folder` holds no such file.
    """
    from loopelastica._progress import progress_bar

    files = structure_files(folder)
    if sample is not None and sample < len(files):
        files = [files[round(k * (len(files) - 1) / max(sample - 1, 1))] for k in range(sample)]
    rows: list[dict[str, Any]] = []
    for file in progress_bar(files, shown=progress, unit="file", leave=False):
        rows += _file(file)
    if rows:
        write_csv(
            out / "atoms.csv", rows, list(dict.fromkeys(name for row in rows for name in row))
        )
    summary = _summary(rows)
    write_json(out / "atoms.json", summary)
    texts = (f"{v:.4g}" if isinstance(v, float) else str(v) for v in summary.values())
    return "\n".join(
        printable(f"{name}: {text}") for name, text in zip(summary, texts, strict=True)
    )


def _file(file: Path) -> list[dict[str, Any]]:
    from loopelastica.atoms.model import build_atoms
    from loopelastica.folding.fold import fold
    from loopelastica.molecule.nucleotides import read_structure

    rows = []
    try:
        structure = read_structure(file)
        loops = fold(structure, all_models=False, max_candidates=1)
    except LoopelasticaError as error:
        return [{"file": file.name, "failure": str(error)}]
    for loop in loops:
        if loop.hairpin.contacts:
            continue
        row: dict[str, Any] = {
            "file": file.name,
            "loop": loop.hairpin.name,
            "sequence": loop.hairpin.sequence,
            "kind": "DNA" if loop.hairpin.is_dna else "RNA",
            "failure": loop.failure,
        }
        rows.append(row)
        if loop.failure:
            continue
        before = resource.getrusage(resource.RUSAGE_SELF).ru_utime
        try:
            (model,) = build_atoms(structure, loop, max_candidates=1)
        except LoopelasticaError as error:
            row["failure"] = str(error)
            continue
        spent = resource.getrusage(resource.RUSAGE_SELF).ru_utime - before
        checks = model.checks.to_dict()
        row |= {name: value for name, value in checks.items() if not isinstance(value, tuple)}
        row["wrong_chirality"] = " ".join(model.checks.wrong_chirality)
        row["status"] = model.relaxed.message
        row["trace_rmsd_A"] = loop.candidates[0].rmsd_A
        row["atoms_rmsd_A"] = model.rmsd_A
        row["user_s"] = round(spent, 2)
    return rows


def _summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    built = [row for row in rows if "sound" in row]
    compared = [row for row in built if row["atoms_rmsd_A"] is not None]

    def share(name: str, count: str) -> float | None:
        total = sum(row[count] for row in built)
        return sum(row[name] * row[count] for row in built) / total if total else None

    def median(values: list[float]) -> float | None:
        return statistics.median(values) if values else None

    return {
        "loops": len(rows),
        "built": len(built),
        "not sound": [f"{row['file']} {row['loop']}" for row in built if not row["sound"]],
        "wrong chirality": sum(bool(row["wrong_chirality"]) for row in built),
        "broken chain": sum(row["chain_worst_A"] > 0.05 for row in built),
        "closest contact (Å)": min((row["closest_A"] for row in built), default=None),
        "bonds within 0.05 Å": share("bonds_within", "bonds"),
        "angles beyond 10°": sum(row["worst_angle_deg"] > 10.0 for row in built),
        "angles within 6°": share("angles_within", "angles"),
        "median RMSD of the trace (Å)": median([row["trace_rmsd_A"] for row in compared]),
        "median RMSD of the backbone atoms (Å)": median([r["atoms_rmsd_A"] for r in compared]),
        "median of the difference (Å)": median(
            [row["atoms_rmsd_A"] - row["trace_rmsd_A"] for row in compared]
        ),
        "median user time (s)": median([row["user_s"] for row in built]),
        "largest user time (s)": max((row["user_s"] for row in built), default=None),
    }
