"""What a filling writes: one folder per file, complete or absent, or a structure file alone."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from loopelastica._files import PROGRAM, is_whole, whole_folder, write_json, write_text
from loopelastica._names import printable, safe_stem
from loopelastica._version import __version__
from loopelastica.atoms.checks import Checks
from loopelastica.filling.compose import changes_of, composed, name_of
from loopelastica.filling.result import FilledCandidate, FilledStrand, Filling, Repair
from loopelastica.report.changes import Removed, label
from loopelastica.report.compose import compose
from loopelastica.report.page.scene import SCENE

MANIFEST: Final = "fill.json"
_SUFFIX: Final = {"pdb": ".pdb", "mmcif": ".cif"}
_NAMES: Final = {"pdb": "PDB", "mmcif": "mmCIF"}
_FORMATS: Final = {".pdb": "pdb", ".ent": "pdb", ".cif": "mmcif", ".mmcif": "mmcif"}
_KEY: Final = ("version", "sha256", "parameters", "scene")
"""Entries of the manifest that determine all else."""

STRAND_COLUMNS: Final = (
    *("model", "chain", "first", "last", "sequence", "kind", "nucleotides"),
    *("status", "reason", "sound", "expected_10_A", "expected_rmsd_A", "expected_90_A"),
    *("shape", "distance_A", "length_A", "crowding", "energy_per_A", "contact_energy_per_A"),
    *("nearest_A", "worst_bond_A", "worst_angle_deg", "closest_contact_A"),
    "mate_A",
)
"""Columns of tables that have a row per strand."""


def folder_of(root: Path, source: Path, number: int = 1) -> Path:
    """The folder of a file: its name without suffixes; numbered from the second of a name on.

    Parameters
    ----------
    root : Path
        Folder of all results.
    source : Path
        The file.
    number : int
        1, 2 … for files of one name.

    Returns
    -------
    Path
    """
    return root / (safe_stem(source) + (f"_{number}" if number > 1 else ""))


def write_filling(path: Path, filling: Filling) -> Path:
    """Write a filled structure into a file (by its suffix), else its folder.

    Parameters
    ----------
    path : Path
        Where to.
    filling : Filling
        What was filled.

    Returns
    -------
    Path
        What was written.

    Raises
    ------
    ValueError
        If the name is of another format, of a compressed file, or that of the input.
    """
    suffix = path.suffix.lower()
    if suffix in (".gz", ".bz2"):
        raise ValueError(f"`path` is {path}; compressed files are read, not written")
    if suffix in _FORMATS:
        text, kind = composed(filling)
        if kind != _FORMATS[suffix]:
            raise ValueError(
                f"`path` is {path}, but the filled structure is {_NAMES[kind]}, as it came or"
                f" because PDB does not hold it; name it *{_SUFFIX[kind]}"
            )
        if filling.entry.path is not None and _same(path, filling.entry.path):
            raise ValueError(f"`path` is {path}, the file that was filled; name another one")
        write_text(path, text)
        return path
    write_folder(path, filling)
    return path


def _same(path: Path, other: Path) -> bool:
    return os.path.realpath(path) == os.path.realpath(other)


def write_folder(path: Path, filling: Filling, scene: bool = False) -> dict[str, Any]:
    """Write the folder of a filling: filled.cif or filled.pdb, further candidates, fill.json.

    A structure is written where anything is different from the file.

    Parameters
    ----------
    path : Path
        The folder.
    filling : Filling
        What was filled.
    scene : bool
        Write scene.js too, what report.html shows of the strands.

    Returns
    -------
    dict
        The key of the folder, for :func:`is_there`.

    Raises
    ------
    FileExistsError
        If the folder cannot be written without harm to what is there.
    """
    with whole_folder(path, MANIFEST) as part:
        files = [MANIFEST]
        most = max((len(strand.candidates) for strand in filling.filled), default=1)
        for rank in range(1, most + 1):
            changes = changes_of(filling, rank)
            if not changes:
                break
            text, kind = compose(filling.entry.text, filling.entry.kind, changes)
            name = ("filled" if rank == 1 else f"filled_{rank}") + _SUFFIX[kind]
            write_text(part / name, text)
            files.append(name)
        if scene:
            from loopelastica.filling.scene import write_strands

            write_strands(part / SCENE, filling, files)
            files.append(SCENE)
        content = {**record_of(filling), "scene": scene, "files": sorted(files)}
        write_json(part / MANIFEST, content)
    return {name: content[name] for name in _KEY}


def is_there(path: Path, key: Mapping[str, Any]) -> bool:
    """Whether a folder holds the whole result of one input and one set of options.

    Parameters
    ----------
    path : Path
        The folder.
    key : mapping
        As `write_folder` has returned it.

    Returns
    -------
    bool
    """
    return is_whole(path / MANIFEST, key)


def record_of(filling: Filling) -> dict[str, Any]:
    """The content of fill.json, without its list of files.

    Parameters
    ----------
    filling : Filling
        What was filled.

    Returns
    -------
    dict
        JSON-ready; lengths in Å.
    """
    return {
        "program": PROGRAM,
        "version": __version__,
        "input": printable(filling.name),
        "sha256": filling.sha256,
        "parameters": filling.options.to_dict(),
        "strands": [strand_record(strand) for strand in filling.strands],
        "completed": list(filling.completed),
        "repaired": [_repair_record(repair) for repair in filling.repairs],
        "not_repaired": list(filling.unrepaired),
        "remarks": list(filling.remarks),
    }


def strand_record(strand: FilledStrand) -> dict[str, Any]:
    """What fill.json has of a strand.

    Parameters
    ----------
    strand : FilledStrand
        One gap of one model.

    Returns
    -------
    dict
        JSON-ready; lengths in Å.
    """
    expected = strand.expected_rmsd_A
    return {
        "model": strand.model,
        "chain": strand.chain,
        "first": strand.first,
        "last": strand.last,
        "sequence": strand.sequence,
        "kind": strand.kind,
        "nucleotides": strand.nucleotides,
        "status": strand.status,
        "reason": strand.reason,
        "sound": strand.sound,
        "expected_rmsd_A": None if expected is None else _rounded(expected),
        "distance_A": strand.distance_A,
        "length_A": strand.length_A,
        "crowding": strand.crowding,
        "mate_A": strand.mate_A,
        "remarks": list(strand.remarks),
        "candidates": [_candidate_record(candidate) for candidate in strand.candidates],
    }


def strand_row(strand: FilledStrand) -> dict[str, Any]:
    """The row of a strand in tables: what fill.json has of it and of its first candidate.

    Parameters
    ----------
    strand : FilledStrand
        One gap of one model.

    Returns
    -------
    dict
        By `STRAND_COLUMNS`; None where there is nothing to say.
    """
    record = strand_record(strand)
    low, middle, high = record["expected_rmsd_A"] or (None, None, None)
    first = record["candidates"][0] if record["candidates"] else {}
    own = {"expected_10_A": low, "expected_rmsd_A": middle, "expected_90_A": high}
    return {name: {**first, **record, **own}.get(name) for name in STRAND_COLUMNS}


def _candidate_record(candidate: FilledCandidate) -> dict[str, Any]:
    line, checks = candidate.line, candidate.atoms.checks
    return {
        "rank": candidate.rank,
        "shape": line.shape,
        "energy_per_A": line.energy_per_A,
        "contact_energy_per_A": line.contact_energy_per_A,
        "stable": line.stable,
        "residual": line.residual,
        "nearest_A": line.nearest_A,
        "nearest_atom": line.nearest_atom,
        "expected_rmsd_A": _rounded(candidate.expected_rmsd_A),
        "sound": checks.sound,
        "not_sound_because": list(checks.wrong),
        **_worst(checks),
        "wrong_chirality": list(checks.wrong_chirality),
        "status": checks.status,
        "nucleotides": [name_of(residue) for residue in candidate.atoms.residues],
        "waters_left_out": [
            f"{water.chain}.{water.resname}{water.number}{water.icode}"
            for water in candidate.waters
        ],
        "trace_A": [_rounded(point, 3) for point in candidate.trace],
    }


def _repair_record(repair: Repair) -> dict[str, Any]:
    checks = repair.atoms.checks
    return {
        "model": repair.model,
        "nucleotides": list(repair.labels),
        "wrong": list(map(str, repair.faults)),
        "atoms": {one.monomer.label: list(one.names) for one in repair.residues},
        "sound": checks.sound,
        **_worst(checks),
        "waters_left_out": list(map(_residue_label, repair.waters)),
        "hydrogens_left_out": len(repair.hydrogens),
    }


def _worst(checks: Checks) -> dict[str, Any]:
    return {
        "worst_bond_A": checks.worst_bond_A,
        "worst_angle_deg": checks.worst_angle_deg,
        "closest_contact_A": checks.closest_A,
        "closest_contact": checks.closest,
    }


def _residue_label(one: Removed) -> str:
    return label((one.chain, one.number, one.icode), one.resname)


def _rounded(values: Any, digits: int = 2) -> list[float]:
    return [round(float(value), digits) for value in values]
