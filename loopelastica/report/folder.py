"""What a fold writes: one folder per hairpin, complete or absent.

A folder is written beside its final place and moved there when all its files are whole, so that
an interrupted run leaves nothing half-written.
"""

import csv
import hashlib
import json
import math
import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from loopelastica._arrays import Array
from loopelastica._version import __version__
from loopelastica.folding.fold import LoopFold
from loopelastica.folding.rank import Candidate
from loopelastica.molecule.nucleotides import Structure, is_pdb
from loopelastica.molecule.trace import to_file_coordinates
from loopelastica.report.pdb import (
    WholeStructure,
    bond_records,
    one_letter_chains,
    path_from,
    point_records,
    renamed_chains,
    write_chimerax,
    write_pymol,
)

if TYPE_CHECKING:
    from loopelastica.atoms.write import LoopAtoms

# points of line.csv and of the plots, per candidate
LINE_POINTS = 101


class Folders:
    """Names for the hairpins' folders: two inputs of one name get different ones.

    `number` is 2, 3 … for a file whose namesakes are somebody else's work.
    """

    def __init__(self, root: Path, number: int = 1) -> None:
        self.root = root
        self._before = number - 1
        self._taken: dict[str, int] = {}

    def claim(self, source: Path, fold: LoopFold) -> Path:
        """The folder of one hairpin: <file>_<chain><first>-<last>, numbered from the second on."""
        stem = source.name.removesuffix(".gz").rsplit(".", 1)[0] or source.name
        name = f"{stem}_{fold.hairpin.name}"
        count = self._taken[name] = self._taken.get(name, self._before) + 1
        return self.root / (name if count == 1 else f"{name}_{count}")


@contextmanager
def whole_folder(path: Path) -> Iterator[Path]:
    """A folder to write into that becomes ``path`` only when the block ends without an error."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = Path(tempfile.mkdtemp(prefix=f".{path.name}.", dir=path.parent))
    try:
        yield part
        # mkdtemp makes it private; results are for the user's group as any other file
        part.chmod(0o777 & ~_umask())
        if path.exists():
            shutil.rmtree(path)
        part.replace(path)
    finally:
        shutil.rmtree(part, ignore_errors=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def write_fold(
    path: Path,
    source: Path | str,
    fold: LoopFold,
    structure: Structure,
    plot: bool = True,
    whole: WholeStructure | None = None,
    atoms: "LoopAtoms | None" = None,
) -> None:
    """Write the folder of one folded loop.

    Parameters
    ----------
    path : Path
        The folder.
    source : Path or str
        The file that was folded, or the sequence the hairpin was built from.
    fold : LoopFold
        What came out, with at least one candidate.
    structure : Structure
        What was read from the file.
    plot : bool
        Draw plot.png.
    whole : WholeStructure, optional
        Write whole.pdb from it.
    atoms : LoopAtoms, optional
        Write atoms.pdb, atoms.cif, loop.sdf and atoms.json from it.
    """
    letters = one_letter_chains(structure.nucleotides.chain.tolist())
    with whole_folder(path) as part:
        _write_ranking_csv(part / "ranking.csv", fold, atoms)
        write_json(part / "ranking.json", ranking(source, fold, structure.remarks))
        _write_line(part / "line.csv", fold)
        _write_traces(part / "traces.pdb", fold, structure, letters)
        if isinstance(source, Path):
            # a PDB file has no longer chain names: there they are those of segments
            chain = fold.hairpin.chain
            seen = "" if is_pdb(source) and len(chain) > 1 else chain
            file = path_from(path, source)
            write_pymol(part / "view.pml", fold, file, seen)
            write_chimerax(part / "view.cxc", fold, file, seen, structure.n_models)
        if whole is not None:
            whole.write(part / "whole.pdb", fold)
        if atoms is not None:
            from loopelastica.atoms.write import write_atoms

            write_atoms(part, atoms)
        if plot:
            from loopelastica.report.plots import plot_fold

            sticks = None if atoms is None else atoms.sticks(1)
            plot_fold(fold, part / "plot.png", title=path.name, sticks=sticks)


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write JSON as a whole or not at all."""
    text = json.dumps(content, indent=1, allow_nan=False, ensure_ascii=False) + "\n"
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        part.write_text(text, encoding="utf-8")
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def rmsd_summary(candidate: Candidate) -> tuple[float | None, float | None, int]:
    """Mean and standard deviation (n − 1) over the models that have this rank, and their number."""
    values = candidate.rmsd_models_A[np.isfinite(candidate.rmsd_models_A)]
    if len(values) == 0:
        return None, None, 0
    deviation = float(np.std(values, ddof=1)) if len(values) > 1 else None
    return float(values.mean()), deviation, len(values)


def row(candidate: Candidate) -> dict[str, Any]:
    """One line of ranking.csv."""
    mean, deviation, count = rmsd_summary(candidate)
    return {
        "rank": candidate.rank,
        "energy_per_A": candidate.energy_per_A,
        "energy_kT": candidate.energy_kT,
        "energy_dimensionless": candidate.rod.energy,
        "stable": candidate.stable,
        "residual": candidate.residual,
        "rmsd_A": candidate.rmsd_A,
        "rmsd_models_mean_A": mean,
        "rmsd_models_sd_A": deviation,
        "n_models": count,
        "length_A": candidate.length_A,
        "touching": candidate.contacts.touching,
        "stem_contact_A": _finite(candidate.contacts.stem_A),
        "self_contact_A": _finite(candidate.contacts.self_A),
        "twist_turns": candidate.rod.twist,
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def ranking(source: Path | str, fold: LoopFold, remarks: Sequence[str] = ()) -> dict[str, Any]:
    """The content of ranking.json: all that is needed to repeat and to judge the result."""
    if fold.ends is None or fold.clamping is None:
        raise ValueError("`fold` has no candidates to write")
    hairpin = fold.hairpin
    return {
        "program": "loopelastica",
        "version": __version__,
        "libraries": {name: version(name) for name in ("numpy", "scipy", "numba", "MDAnalysis")},
        "input": {"file": source.name, "sha256": sha256(source)}
        if isinstance(source, Path)
        else {"sequence": source},
        "hairpin": {
            "chain": hairpin.chain,
            "closing_pair": list(hairpin.closing_pair),
            "residues": list(hairpin.residues),
            "sequence": hairpin.sequence,
            "kind": "DNA" if hairpin.is_dna else "RNA",
            "stem_pairs": len(hairpin.stem_5),
            "contacts": [list(pair) for pair in hairpin.contacts],
            "kissing": list(hairpin.kissing),
        },
        "parameters": fold.parameters,
        "length": {
            "length_A": fold.length_A,
            "nucleotides": fold.ends.n_free,
            "per_nucleotide_A": fold.ends.clamp.length_per_nucleotide_A,
            "from": "option length_per_nucleotide_A"
            if fold.parameters["length_per_nucleotide_A"] is not None
            else f"default for {'DNA' if hairpin.is_dna else 'RNA'}",
        },
        "clamp": {
            "from": "ideal strands fitted to each stem strand; no loop atom",
            **fold.ends.clamp.to_dict(),
            "fit_rms_A": np.asarray(fold.ends.fit_rms_A).tolist(),
            "stem_rms_A": fold.ends.rms_A,
            "start_origin_A": np.asarray(fold.ends.start_origin_A).tolist(),
            "start_frame": np.asarray(fold.ends.start_frame).tolist(),
            "end_origin_A": np.asarray(fold.ends.end_origin_A).tolist(),
            "end_frame": np.asarray(fold.ends.end_frame).tolist(),
            "clamping_parameters": fold.clamping.parameters.tolist(),
        },
        "unseen": fold.unseen,
        "remarks": [*remarks, *fold.remarks],
        "model_failures": list(fold.model_failures),
        "candidates": [
            {
                **row(c),
                "rmsd_models_A": [v if math.isfinite(v) else None for v in c.rmsd_models_A],
                "trace_A": c.trace.tolist(),
                "rod": c.rod.to_dict(),
            }
            for c in fold.candidates
        ],
    }


def sha256(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def line(fold: LoopFold, candidate: Candidate, n: int = LINE_POINTS) -> dict[str, Array]:
    """The dense line of a candidate in the file's coordinates.

    Returns ``s`` (n,), ``points`` (n, 3) in Å, ``tangents`` (n, 3), ``curvature`` (n,) in 1/Å and
    ``twist``, the rate of the frame about the tangent, in rad/Å.
    """
    assert fold.ends is not None
    rod, length_A = candidate.rod, candidate.length_A
    points = to_file_coordinates(
        rod.centerline(n), fold.ends.start_origin_A, fold.ends.start_frame, length_A
    )
    return {
        "s": np.linspace(0.0, length_A, n),
        "points": points,
        "tangents": rod.frames(n)[:, :, 2] @ np.asarray(fold.ends.start_frame).T,
        "curvature": rod.curvature(n) / length_A,
        "twist": np.full(n, math.tau * rod.twist / length_A),
    }


def record(fold: LoopFold, candidate: Candidate) -> dict[str, Any]:
    """A candidate with the loop it belongs to: one line of ranking.csv and of a data frame."""
    return {**loop_record(fold), **row(candidate)}


def loop_record(fold: LoopFold) -> dict[str, Any]:
    """The columns that name a loop."""
    hairpin = fold.hairpin
    return {
        "chain": hairpin.chain,
        "loop": hairpin.name,
        "closing_5": hairpin.closing_pair[0],
        "closing_3": hairpin.closing_pair[1],
        "sequence": hairpin.sequence,
        "stem_rms_A": None if fold.ends is None else fold.ends.rms_A,
    }


def _write_ranking_csv(path: Path, fold: LoopFold, atoms: "LoopAtoms | None") -> None:
    rows = [record(fold, c) | (atoms.columns(c.rank) if atoms else {}) for c in fold.candidates]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, fieldnames=list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def _write_line(path: Path, fold: LoopFold) -> None:
    names = ["rank", "s_A", "x_A", "y_A", "z_A", "tx", "ty", "tz", "curvature_per_A",
             "twist_rad_per_A"]  # fmt: skip
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(names)
        for candidate in fold.candidates:
            dense = line(fold, candidate)
            table = np.column_stack(list(dense.values()))
            writer.writerows([candidate.rank, *(f"{v:.9g}" for v in values)] for values in table)


def _write_traces(
    path: Path, fold: LoopFold, structure: Structure, letters: dict[str, str]
) -> None:
    """One MODEL per candidate: a point CEN per nucleotide, its energy rank as B factor."""
    chain, n = letters[fold.hairpin.chain], len(fold.hairpin)
    lines = renamed_chains({fold.hairpin.chain: chain})
    for candidate in fold.candidates:
        lines.append(f"MODEL     {candidate.rank:4d}")
        lines += point_records(fold, structure, candidate.trace, chain, candidate.rank, 1)
        lines.append("ENDMDL")
    lines += [*bond_records(1, n), "END"]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
