"""What ``--json`` prints of folds, fillings, scans and libraries: documents for other programs.

Every document has ``version`` and ``command``, the results as a list, ``failures`` (a list of
``file`` and ``failure``; the file is None where a failure is not of one file), ``notes`` (a list of
sentences) and, of commands that write one, ``folder``. Lengths are in Å; what is unknown is null,
and there is no NaN.
"""

import json
from collections.abc import Iterable, Iterator, Mapping
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from loopelastica._files import read_manifest
from loopelastica.report.records import ATOMS_COLUMNS, about, scan_rows

if TYPE_CHECKING:
    from loopelastica.folding.library import Library
    from loopelastica.folding.scan import LoopScan

Row = Mapping[str, Any]

_LOOP: Final = ("input", "hairpin", "length", "clamp", "unseen", "remarks", "model_failures")
_CANDIDATE: Final = (
    *("rank", "rank_energy", "shape", "expected_rmsd_A", "energy_per_A", "energy_kT"),
    *("energy_dimensionless", "stable", "residual", "rmsd_A", "rmsd_models_mean_A"),
    *("rmsd_models_sd_A", "rmsd_models_A", "n_models", "length_A", "touching", "stem_contact_A"),
    *("self_contact_A", "twist_turns", "trace_A"),
)


def fold_documents(out: Path, rows: Iterable[Row]) -> Iterator[dict[str, Any]]:
    """An entry of ``loops`` for each folder of a run of ``fold`` or ``build``.

    Parameters
    ----------
    out : Path
        Folder of the run.
    rows : iterable of mapping
        Those of summary.csv, in its order.

    Yields
    ------
    dict
        ``file`` as it was given, or the name of a hairpin that was built; ``folder``, inside that
        of the run; then as in ranking.json ``input``, ``hairpin``, ``length``, ``clamp``,
        ``unseen``, ``remarks`` and ``model_failures``; and ``candidates``, each with the entries of
        ranking.json but for its line, and with those of the atoms (``atoms_sound``,
        ``atoms_worst_bond_A``, ``atoms_worst_angle_deg``, ``atoms_closest_A``, ``atoms_rmsd_A``)
        where atoms were built.
    """
    for folder, own in groupby(rows, key=lambda row: row["folder"]):
        of_rank = {row["rank"]: row for row in own}
        first = next(iter(of_rank.values()))
        manifest = read_manifest(out / folder / "ranking.json")
        yield {
            "file": first["file"],
            "folder": folder,
            **{name: manifest[name] for name in _LOOP if name in manifest},
            "candidates": [
                {
                    **{name: candidate[name] for name in _CANDIDATE},
                    **_of_atoms(of_rank.get(candidate["rank"], {})),
                }
                for candidate in manifest.get("candidates", ())
            ],
        }


def _of_atoms(row: Row) -> dict[str, Any]:
    if row.get("atoms_sound") is None:
        return {}
    return {name: row[name] for name in ATOMS_COLUMNS}


def fill_documents(out: Path, folders: Iterable[tuple[str, str]]) -> Iterator[dict[str, Any]]:
    """An entry of ``files`` for each folder of a run of ``fill``.

    Parameters
    ----------
    out : Path
        Folder of the run.
    folders : iterable of (str, str)
        Each file as it was given, and the name of its folder.

    Yields
    ------
    dict
        ``file``, ``folder``, and what the fill.json of the folder has.
    """
    for file, folder in folders:
        yield {"file": file, "folder": folder, **read_manifest(out / folder / "fill.json")}


def scan_document(file: str, loop: "LoopScan") -> dict[str, Any]:
    """An entry of ``loops`` of ``scan``.

    Parameters
    ----------
    file : str
        As it was given.
    loop : LoopScan
        With candidates.

    Returns
    -------
    dict
        ``file``, ``hairpin``, ``spread_A``, ``expected_rmsd_A`` (median and 90 % of the error of
        the rule's clamp), and ``candidates`` with the columns of scan.csv and ``trace_A``.
    """
    median_A, most_A = loop.expected_rmsd_A
    of_loop = ("file", "loop", "kind", "closing_pair", "sequence", "nucleotides", "spread_A")
    return {
        "file": file,
        "hairpin": {"name": loop.hairpin.name, **about(loop.hairpin)},
        "spread_A": loop.spread_A,
        "expected_rmsd_A": {"median": median_A, "90 %": most_A},
        "candidates": [
            {
                **{name: value for name, value in row.items() if name not in of_loop},
                "trace_A": one.candidate.trace.tolist(),
            }
            for row, one in zip(scan_rows(loop), loop.candidates, strict=True)
        ],
    }


def library_rows(library: "Library") -> list[dict[str, Any]]:
    """What a library holds, a row per kind and length.

    Parameters
    ----------
    library : Library

    Returns
    -------
    list of dict
        ``kind``, ``nucleotides``, ``loops``, ``sequences``, ``entries``, ``most_frequent`` (its
        letters) and ``copies`` (how often that sequence is there).
    """
    rows = []
    for kind, shapes in library.tables():
        first = int(np.argmax(shapes.copies))
        rows.append(
            {
                "kind": "DNA" if kind.is_dna else "RNA",
                "nucleotides": kind.nucleotides,
                "loops": len(shapes),
                # each sequence is counted once over its copies
                "sequences": round(float((1.0 / shapes.copies).sum())),
                "entries": len(np.unique(shapes.entries)),
                "most_frequent": shapes.sequence(first)[1:-1],
                "copies": int(shapes.copies[first]),
            }
        )
    return rows


def json_text(document: Mapping[str, Any]) -> str:
    """A document as text; ValueError for NaN and infinities.

    Parameters
    ----------
    document : mapping
        JSON-ready.

    Returns
    -------
    str
    """
    return json.dumps(document, indent=1, allow_nan=False)
