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
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from loopelastica import __version__
from loopelastica.folding import LoopFold
from loopelastica.molecule.nucleotides import Nucleotides
from loopelastica.molecule.trace import to_file_coordinates
from loopelastica.rank import Candidate
from loopelastica.rod.clamping import Array

if TYPE_CHECKING:
    from loopelastica.atoms.write import LoopAtoms

# points of line.csv and of the plots, per candidate
LINE_POINTS = 101


class Folders:
    """Names for the hairpins' folders: two inputs of one name get different ones."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self._taken: dict[str, int] = {}

    def claim(self, source: Path, fold: LoopFold) -> Path:
        """The folder of one hairpin: <file>_<chain><first>-<last>, numbered from the second on."""
        stem = source.name.removesuffix(".gz").rsplit(".", 1)[0] or source.name
        name = f"{stem}_{fold.hairpin.name}"
        count = self._taken[name] = self._taken.get(name, 0) + 1
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
    nucleotides: Nucleotides,
    plot: bool = True,
    atoms: "LoopAtoms | None" = None,
) -> None:
    """Write ranking.csv, ranking.json, traces.pdb, line.csv and plot.png of one folded loop.

    With ``atoms`` also atoms.pdb, atoms.cif, loop.sdf and atoms.json. ``source`` is the file that
    was read, or the sequence the hairpin was built from.
    """
    with whole_folder(path) as part:
        _write_ranking_csv(part / "ranking.csv", fold, atoms)
        (part / "ranking.json").write_text(
            json.dumps(ranking(source, fold), indent=1, allow_nan=False, ensure_ascii=False) + "\n",
            encoding="utf-8",
        )
        _write_line(part / "line.csv", fold)
        _write_traces(part / "traces.pdb", fold, nucleotides)
        if atoms is not None:
            from loopelastica.atoms.write import write_atoms

            write_atoms(part, atoms)
        if plot:
            from loopelastica.plots import plot_fold

            sticks = None if atoms is None else atoms.sticks(1)
            plot_fold(fold, part / "plot.png", title=path.name, sticks=sticks)


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
        "twist_turns": candidate.rod.twist,
    }


def ranking(source: Path | str, fold: LoopFold) -> dict[str, Any]:
    """The content of ranking.json: all that is needed to repeat and to judge the result."""
    if fold.ends is None or fold.clamping is None:
        raise ValueError("`fold` has no candidates to write")
    hairpin = fold.hairpin
    return {
        "program": "loopelastica",
        "version": __version__,
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
        },
        "parameters": fold.parameters,
        "length": {
            "length_A": fold.length_A,
            "nucleotides": len(hairpin.loop),
            "per_nucleotide_A": fold.length_A / len(hairpin.loop),
            "from": "option length_per_nucleotide_A"
            if fold.parameters["length_per_nucleotide_A"] is not None
            else f"default for {'DNA' if hairpin.is_dna else 'RNA'}",
        },
        "clamp": {
            "from": "ideal strands fitted to each stem strand; no loop atom",
            "fit_rms_A": np.asarray(fold.ends.fit_rms_A).tolist(),
            "start_origin_A": np.asarray(fold.ends.start_origin_A).tolist(),
            "start_frame": np.asarray(fold.ends.start_frame).tolist(),
            "end_origin_A": np.asarray(fold.ends.end_origin_A).tolist(),
            "end_frame": np.asarray(fold.ends.end_frame).tolist(),
            "clamping_parameters": fold.clamping.parameters.tolist(),
        },
        "unseen": fold.unseen,
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


def _write_ranking_csv(path: Path, fold: LoopFold, atoms: "LoopAtoms | None") -> None:
    rows = [row(c) | (atoms.columns(c.rank) if atoms else {}) for c in fold.candidates]
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


def _write_traces(path: Path, fold: LoopFold, nucleotides: Nucleotides) -> None:
    """One MODEL per candidate: a pseudo-atom CEN per nucleotide, its energy rank as B factor."""
    import MDAnalysis as mda

    loop = fold.hairpin.loop
    n = len(loop)
    with warnings.catch_warnings():
        # what a PDB may hold and this one does not (cell, charges) is not worth a warning
        warnings.simplefilter("ignore")
        universe = mda.Universe.empty(n, n_residues=n, atom_resindex=np.arange(n), trajectory=True)
        for name, values in {
            "name": ["CEN"] * n,
            "element": ["X"] * n,
            "type": ["X"] * n,
            "record_types": ["ATOM"] * n,
            "altLoc": [""] * n,
            "occupancy": np.ones(n),
            "tempfactors": np.zeros(n),
            "chainIDs": [fold.hairpin.chain[:1]] * n,
            "resname": list(nucleotides.resname[loop]),
            "resid": np.asarray(nucleotides.resid[loop]),
            "icode": list(nucleotides.icode[loop]),
            "segid": [fold.hairpin.chain],
            "bonds": [(i, i + 1) for i in range(n - 1)],
        }.items():
            universe.add_TopologyAttr(name, values)
        with mda.Writer(str(path), n_atoms=n, multiframe=True, bonds="all") as writer:
            for candidate in fold.candidates:
                universe.atoms.positions = candidate.trace
                universe.atoms.tempfactors = np.full(n, float(candidate.rank))
                writer.write(universe.atoms)
