"""What a fold writes: one folder per hairpin, complete or absent."""

import json
import os
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from loopelastica._files import printable, whole_folder, write_csv, write_json, write_text
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.nucleotides import Structure, is_pdb
from loopelastica.report.pdb import (
    WholeStructure,
    bond_records,
    one_letter_chains,
    point_records,
    renamed_records,
)
from loopelastica.report.plots import plot_fold
from loopelastica.report.records import candidate_row, line, loop_row, ranking
from loopelastica.report.viewers import path_from, write_chimerax, write_pymol

if TYPE_CHECKING:
    from loopelastica.report.atoms import LoopAtoms


class Folders:
    """Names for the hairpins' folders: two inputs of one name get different ones.

    `number` is 2, 3 … for a file whose namesakes are the work of others.
    """

    def __init__(self, root: Path, number: int = 1) -> None:
        self.root = root
        self._before = number - 1
        self._taken: dict[str, int] = {}

    def claim(self, source: Path, fold: LoopFold) -> Path:
        """The folder of one hairpin: <file>_<chain><first>-<last>, numbered from the second on.

        Parameters
        ----------
        source : Path
            The file it is from.
        fold : LoopFold
            The loop.

        Returns
        -------
        Path
        """
        stem = source.name.removesuffix(".gz").rsplit(".", 1)[0] or source.name
        name = f"{stem}_{fold.hairpin.name}"
        count = self._taken[name] = self._taken.get(name, self._before) + 1
        return self.root / (name if count == 1 else f"{name}_{count}")


def write_fold(
    path: Path,
    source: Path | str,
    fold: LoopFold,
    structure: Structure,
    plot: bool = True,
    whole: WholeStructure | None = None,
    atoms: "LoopAtoms | None" = None,
) -> None:
    """Write the folder of one folded loop, whole or not at all.

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
    chains = structure.nucleotides.chain.tolist()
    letter = one_letter_chains(chains)[fold.hairpin.chain]
    rows = [
        {**loop_row(fold), **candidate_row(c), **(atoms.columns(c.rank) if atoms else {})}
        for c in fold.candidates
    ]
    with whole_folder(path) as part:
        write_csv(part / "ranking.csv", rows)
        write_json(part / "ranking.json", ranking(source, fold, structure.remarks))
        write_csv(part / "line.csv", _line_rows(fold))
        _write_traces(part / "traces.pdb", fold, structure, letter)
        if isinstance(source, Path):
            # a PDB file has no longer chain names: there they are those of segments
            chain = fold.hairpin.chain
            shown = "" if is_pdb(source) and len(chain) > 1 else chain
            file = path_from(path, source)
            write_pymol(part / "view.pml", fold, file, shown)
            write_chimerax(part / "view.cxc", fold, file, shown, structure.n_models)
        if whole is not None:
            whole.write(part / "whole.pdb", fold)
        if atoms is not None:
            from loopelastica.report.atoms import write_atoms

            write_atoms(part, atoms)
        if plot:
            sticks = None if atoms is None else atoms.sticks(1)
            plot_fold(fold, part / "plot.png", title=printable(path.name), sticks=sticks)


def _line_rows(fold: LoopFold) -> Iterator[dict[str, object]]:
    names = ("s_A", "x_A", "y_A", "z_A", "tx", "ty", "tz", "curvature_per_A", "twist_rad_per_A")
    for candidate in fold.candidates:
        for values in np.column_stack(list(line(fold, candidate).values())):
            numbers = (f"{v:.9g}" for v in values)
            yield {"rank": candidate.rank, **dict(zip(names, numbers, strict=True))}


def _write_traces(path: Path, fold: LoopFold, structure: Structure, letter: str) -> None:
    """One MODEL per candidate: a point CEN per nucleotide, its energy rank as B factor."""
    lines = renamed_records({fold.hairpin.chain: letter})
    for candidate in fold.candidates:
        lines.append(f"MODEL     {candidate.rank:4d}")
        lines += point_records(fold, structure, candidate.trace, letter, candidate.rank, 1)
        lines.append("ENDMDL")
    write_text(path, "\n".join([*lines, *bond_records(1, len(fold.hairpin)), "END", ""]))


def other_folds(out: Path, names: Collection[str]) -> list[str]:
    """Folders of folded files in a folder of results, other than those named.

    Parameters
    ----------
    out : Path
        Folder of results.
    names : collection of str
        Folders that are known.

    Returns
    -------
    list of str
        Their names in order; what is not the result of a file's fold is left out.
    """
    others = sorted(f.name for f in os.scandir(out) if f.is_dir() and f.name not in names)
    return [name for name in others if "file" in _input(out / name / "ranking.json")]


def _input(path: Path) -> Any:
    """What a ranking.json says of its input; nothing where it cannot be read."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))["input"]
    except (OSError, ValueError, KeyError, TypeError):
        return {}
