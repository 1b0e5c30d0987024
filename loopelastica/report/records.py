"""What is recorded of a folded loop: rows of tables, the content of JSON files, its dense line."""

import math
from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from loopelastica._arrays import Array
from loopelastica._files import PROGRAM, sha256
from loopelastica._version import __version__
from loopelastica.folding.rank import Candidate
from loopelastica.folding.result import LoopFold
from loopelastica.folding.scan import LoopScan
from loopelastica.molecule.hairpins import Hairpin

LINE_POINTS = 101
"""Points of line.csv and of the plots, per candidate."""

SCAN_COLUMNS = (
    *("file", "loop", "kind", "closing_pair", "sequence", "nucleotides", "spread_A"),
    *("rank", "rank_by_EL", "is_rule", "stem_extend_5", "stem_extend_3", "taper"),
    *("length_per_nucleotide_A", "length_A", "free_nucleotides", "energy_per_A"),
    *("energy_dimensionless", "stable", "residual", "touching", "stem_contact_A"),
    *("self_contact_A", "rmsd_A"),
)
"""Columns of scan.csv."""

ATOMS_COLUMNS = (
    *("atoms_sound", "atoms_worst_bond_A", "atoms_worst_angle_deg", "atoms_closest_A"),
    "atoms_rmsd_A",
)
"""Columns on a candidate's atoms in the table of a run; empty where none were built."""


def rmsd_summary(candidate: Candidate) -> tuple[float | None, float | None, int]:
    """Mean and standard deviation (n − 1) over the models that have this rank, and their number."""
    values = candidate.rmsd_models_A[np.isfinite(candidate.rmsd_models_A)]
    if len(values) == 0:
        return None, None, 0
    deviation = float(np.std(values, ddof=1)) if len(values) > 1 else None
    return float(values.mean()), deviation, len(values)


def candidate_row(candidate: Candidate) -> dict[str, Any]:
    """The columns of ranking.csv that describe a candidate."""
    mean, deviation, count = rmsd_summary(candidate)
    low, middle, high = candidate.expected_rmsd_A.tolist()
    return {
        "rank": candidate.rank,
        "rank_energy": candidate.rank_energy,
        "shape": candidate.shape,
        "expected_10_A": low,
        "expected_rmsd_A": middle,
        "expected_90_A": high,
        "energy_per_A": candidate.energy_per_A,
        "energy_kT": candidate.energy_kT,
        "energy_dimensionless": candidate.line.energy,
        "stable": candidate.stable,
        "residual": candidate.residual,
        "rmsd_A": candidate.rmsd_A,
        "rmsd_models_mean_A": mean,
        "rmsd_models_sd_A": deviation,
        "n_models": count,
        "length_A": candidate.length_A,
        "touching": candidate.contacts.touching,
        "stem_contact_A": finite(candidate.contacts.stem_A),
        "self_contact_A": finite(candidate.contacts.self_A),
        "twist_turns": candidate.line.twist_turns,
    }


def finite(value: float) -> float | None:
    """A number, or None for what no file can hold."""
    return value if math.isfinite(value) else None


def loop_row(fold: LoopFold) -> dict[str, Any]:
    """The columns of ranking.csv that name a loop."""
    hairpin = fold.hairpin
    return {
        "chain": hairpin.chain,
        "loop": hairpin.name,
        "closing_5": hairpin.closing_pair[0],
        "closing_3": hairpin.closing_pair[1],
        "sequence": hairpin.sequence,
        "stem_rms_A": None if fold.ends is None else fold.ends.rms_A,
    }


def hairpin_row(hairpin: Hairpin) -> dict[str, Any]:
    """The columns that say what a hairpin is."""
    return {
        "chain": hairpin.chain,
        "loop": hairpin.name,
        "closing_pair": hairpin.label,
        "sequence": hairpin.sequence,
        "kind": hairpin.kind,
        "nucleotides": len(hairpin),
        "absent": int((hairpin.loop < 0).sum()),
        "stem_pairs": hairpin.n_pairs,
        "contacts": ", ".join("–".join(pair) for pair in hairpin.contacts),
        "kissing": ", ".join(hairpin.kissing),
    }


def scan_rows(loop: LoopScan) -> Iterator[dict[str, Any]]:
    """The columns of scan.csv, a row per shape."""
    hairpin = loop.hairpin
    about = {
        "file": loop.file,
        "loop": hairpin.name,
        "kind": hairpin.kind,
        "closing_pair": hairpin.label,
        "sequence": hairpin.sequence,
        "nucleotides": len(hairpin),
        "spread_A": loop.spread_A,
    }
    for one in loop.candidates:
        shape = one.candidate
        yield {
            **about,
            "rank": shape.rank,
            "rank_by_EL": one.rank_by_EL,
            "is_rule": one.is_rule,
            **one.ends.clamp.to_dict(),
            "length_A": shape.length_A,
            "free_nucleotides": one.ends.n_free,
            "energy_per_A": shape.energy_per_A,
            "energy_dimensionless": shape.line.energy,
            "stable": shape.stable,
            "residual": shape.residual,
            "touching": shape.contacts.touching,
            "stem_contact_A": finite(shape.contacts.stem_A),
            "self_contact_A": finite(shape.contacts.self_A),
            "rmsd_A": shape.rmsd_A,
        }


def ranking(
    source: Path | str | Mapping[str, Any], fold: LoopFold, remarks: Sequence[str] = ()
) -> dict[str, Any]:
    """The content of ranking.json: all that is needed to repeat and to judge the result.

    Parameters
    ----------
    source : Path, str or mapping
        The file that was folded, the sequence the hairpin was built from, or what is recorded of
        anything else.
    fold : LoopFold
        What came out.
    remarks : sequence of str
        Those of the structure; the loop's own follow.

    Returns
    -------
    dict
        JSON-ready; lengths in Å.

    Raises
    ------
    ValueError
        If `fold` has no candidates.
    """
    if fold.ends is None or fold.clamping is None:
        raise ValueError("`fold` has no candidates to write")
    given = fold.options.length_per_nucleotide_A is not None
    default = f"default for {fold.hairpin.kind}"
    return {
        **program(),
        "libraries": {name: version(name) for name in ("numpy", "scipy", "numba", "MDAnalysis")},
        "input": _input(source),
        "hairpin": {
            **about(fold.hairpin),
            "stem_pairs": fold.hairpin.n_pairs,
            **partners(fold.hairpin),
        },
        "parameters": fold.parameters,
        "length": {
            "length_A": fold.length_A,
            "nucleotides": fold.ends.n_free,
            "per_nucleotide_A": fold.ends.clamp.length_per_nucleotide_A,
            "from": "option length_per_nucleotide_A" if given else default,
        },
        "clamp": {
            "from": "ideal strands fitted to each stem strand; no loop atom",
            **fold.ends.clamp.to_dict(),
            "fit_rms_A": fold.ends.fit_rms_A.tolist(),
            "stem_rms_A": fold.ends.rms_A,
            "start_origin_A": fold.ends.start_origin_A.tolist(),
            "start_frame": fold.ends.start_frame.tolist(),
            "end_origin_A": fold.ends.end_origin_A.tolist(),
            "end_frame": fold.ends.end_frame.tolist(),
            "clamping_parameters": fold.clamping.parameters.tolist(),
        },
        "unseen": fold.unseen,
        "remarks": [*remarks, *fold.remarks],
        "model_failures": list(fold.model_failures),
        "candidates": [
            {
                **candidate_row(c),
                "expected_rmsd_A": c.expected_rmsd_A.tolist(),
                "rmsd_models_A": [finite(v) for v in c.rmsd_models_A.tolist()],
                "trace_A": c.trace.tolist(),
                **c.line.to_dict(),
            }
            for c in fold.candidates
        ],
    }


def _input(source: Path | str | Mapping[str, Any]) -> dict[str, Any]:
    if isinstance(source, Path):
        return {"file": source.name, "sha256": sha256(source)}
    return {"sequence": source} if isinstance(source, str) else dict(source)


def program() -> dict[str, str]:
    """Name and version of the program, the head of every JSON file."""
    return {"program": PROGRAM, "version": __version__}


def about(hairpin: Hairpin) -> dict[str, Any]:
    """What a hairpin is, JSON-ready."""
    return {
        "chain": hairpin.chain,
        "closing_pair": list(hairpin.closing_pair),
        "residues": list(hairpin.residues),
        "sequence": hairpin.sequence,
        "kind": hairpin.kind,
    }


def partners(hairpin: Hairpin) -> dict[str, Any]:
    """What its loop pairs with outside, JSON-ready."""
    return {"contacts": [list(pair) for pair in hairpin.contacts], "kissing": list(hairpin.kissing)}


def line(candidate: Candidate, n: int = LINE_POINTS) -> dict[str, Array]:
    """The dense line of a candidate in the file's coordinates.

    Parameters
    ----------
    candidate : Candidate
        One of a loop's shapes.
    n : int
        Number of points, evenly spaced along the line.

    Returns
    -------
    dict
        ``s`` (n,) and ``points`` (n, 3) in Å, ``tangents`` (n, 3), ``curvature`` (n,) in 1/Å and
        ``twist`` (n,), the rate of the frame about the tangent, in rad/Å.
    """
    own = candidate.line
    return {
        "s": np.linspace(0.0, own.curve_A, n),
        "points": own.points(n),
        "tangents": own.tangents(n),
        "curvature": own.curvature_per_A(n),
        "twist": np.full(n, math.tau * own.twist_turns / own.curve_A),
    }
