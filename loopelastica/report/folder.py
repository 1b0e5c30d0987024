"""What a fold writes: one folder per hairpin, complete or absent.

ranking.json is the manifest of the folder. It says which files are the program's own and what they
came from, is written last and, when the folder is written anew, removed first.
"""

import os
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from loopelastica._files import (
    NOTE,
    is_whole,
    read_manifest,
    whole_folder,
    write_csv,
    write_json,
    write_text,
)
from loopelastica._names import printable, safe_name, safe_stem
from loopelastica.folding.result import LoopFold
from loopelastica.molecule._universe import text_of
from loopelastica.molecule.nucleotides import Structure, is_pdb
from loopelastica.molecule.setting import Setting, Settings
from loopelastica.report.page.scene import SCENE, fold_scene, write_scene
from loopelastica.report.pdb import (
    WholeStructure,
    bond_records,
    chain_letters,
    expected_records,
    point_records,
    renamed_records,
)
from loopelastica.report.plots import plot_fold
from loopelastica.report.records import candidate_row, line, loop_row, ranking
from loopelastica.report.tubes import tubes_text
from loopelastica.report.viewers import path_from, shown_file, write_chimerax, write_pymol

if TYPE_CHECKING:
    from loopelastica.report.atoms import LoopAtoms

MANIFEST: Final = "ranking.json"
_KEY: Final = ("version", "input", "parameters", "written")
"""Entries of the manifest that determine all else: the folder's key."""


class Folders:
    """Names for the hairpins' folders: two inputs of one name get different ones.

    `number` is 1, 2, 3 … for files of one name that are folded apart from each other; None for one
    run over all files, which counts by itself.
    """

    def __init__(self, root: Path, number: int | None = None) -> None:
        self.root = root
        self._of_file = "" if number in (None, 1) else f"_{number}"
        # what no other file's number can be taken for
        self._joint = "_" if number is None else "+"
        self._taken: set[str] = set()

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
        first = name = f"{safe_stem(source)}_{safe_name(fold.hairpin.name)}{self._of_file}"
        count = 1
        while name in self._taken:
            count += 1
            name = f"{first}{self._joint}{count}"
        self._taken.add(name)
        return self.root / name


def write_fold(
    path: Path,
    source: Path | str | Mapping[str, Any],
    fold: LoopFold,
    structure: Structure,
    plot: bool = True,
    whole: WholeStructure | None = None,
    atoms: "LoopAtoms | None" = None,
    settings: Settings | None = None,
    report: bool = False,
) -> dict[str, Any]:
    """Write the folder of one folded loop, whole or not at all.

    What a user has put into the folder stays there.

    Parameters
    ----------
    path : Path
        The folder.
    source : Path, str or mapping
        The file that was folded, the sequence the hairpin was built from, or what is recorded of
        anything else.
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
    settings : Settings, optional
        What the settings of a structure's loops share; without them they are made anew, which
        takes a third of a second for a ribosome.
    report : bool
        Write scene.js, what report.html shows of the loop.

    Returns
    -------
    dict
        The key of the folder, for :func:`is_there`: content of the input, options, version.

    Raises
    ------
    FileExistsError
        If the folder cannot be written without harm to what is there.
    """
    letter = chain_letters(structure)[fold.hairpin.chain]
    setting = (settings or Settings(structure)).of(fold.hairpin, fold.candidates[0].trace)
    rows = [
        {**loop_row(fold), **candidate_row(c), **(atoms.columns(c.rank) if atoms else {})}
        for c in fold.candidates
    ]
    with whole_folder(path, MANIFEST) as part:
        write_csv(part / "ranking.csv", rows)
        write_csv(part / "line.csv", _line_rows(fold))
        _write_traces(part / "traces.pdb", fold, structure, letter)
        write_text(part / "tubes.pdb", tubes_text(fold, structure, setting, letter))
        if whole is not None:
            whole.write(part / "whole.pdb", fold)
        if atoms is not None:
            from loopelastica.report.atoms import write_atoms

            write_atoms(part, atoms, _named(source))
        seen = path_from(path, source) if isinstance(source, Path) else None
        _write_scripts(part, source, fold, structure, setting, atoms)
        if plot:
            sticks = None if atoms is None else atoms.sticks(1)
            title = source.name if isinstance(source, Path) else _origin(source)
            plot_fold(fold, part / "plot.png", title, sticks, setting)
        content = ranking(source, fold, structure.remarks)
        built = None if atoms is None else atoms.options()
        content["written"] = {
            "path": seen, "plot": plot, "whole": whole is not None, "atoms": built,
            "report": report,
        }  # fmt: skip
        files = {MANIFEST, *(entry.name for entry in part.iterdir() if entry.name != NOTE)}
        if report:
            _write_scene(part / SCENE, fold, setting, atoms, content, files)
            files.add(SCENE)
        write_json(part / MANIFEST, {**content, "files": sorted(files)})
    return {name: content[name] for name in _KEY}


def _shown(part: Path, source: Path | str | Mapping[str, Any], structure: Structure) -> str | None:
    """The structure file that viewers open; of a frame of a Universe it is made, native.*."""
    if isinstance(source, Path):
        return shown_file(part, source)
    if isinstance(source, str) or "universe" not in source:
        return None
    kind, text = text_of(structure.universe)
    file = "native.pdb" if kind == "pdb" else "native.cif"
    write_text(part / file, text)
    return file


def _named(source: Path | str | Mapping[str, Any]) -> Path | str | None:
    """The file or the sequence; None for anything else, such as a Universe."""
    if isinstance(source, Mapping):
        sequence = source.get("sequence")
        return None if sequence is None else str(sequence)
    return source


def _origin(source: str | Mapping[str, Any]) -> str:
    """What a picture says of a loop that is from no file."""
    built = isinstance(source, str) or "sequence" in source
    return "built from its sequence" if built else "universe"


def _write_scripts(
    part: Path,
    source: Path | str | Mapping[str, Any],
    fold: LoopFold,
    structure: Structure,
    setting: Setting,
    atoms: "LoopAtoms | None",
) -> None:
    """Write view.pml and view.cxc; of a hairpin from its sequence they show atoms.pdb."""
    ranks = [] if atoms is None else [model.rank for model in atoms.written]
    chain, n_models = fold.hairpin.chain, structure.n_models
    file = _shown(part, source, structure)
    if file is not None:
        # a PDB file has no longer chain names: there they are those of segments
        chain = "" if is_pdb(Path(file)) and len(chain) > 1 else chain
    elif (part / "atoms.pdb").exists():
        file, n_models = "atoms.pdb", len(ranks)
    else:
        return
    write_pymol(part / "view.pml", fold, file, chain, setting, ranks)
    write_chimerax(part / "view.cxc", fold, file, chain, n_models, setting, ranks)


def is_there(path: Path, key: Mapping[str, Any]) -> bool:
    """Whether a folder holds the whole result of one input and one set of options.

    Parameters
    ----------
    path : Path
        The folder.
    key : mapping
        As `write_fold` has returned it.

    Returns
    -------
    bool
    """
    return is_whole(path / MANIFEST, key)


def _line_rows(fold: LoopFold) -> Iterator[dict[str, object]]:
    names = ("s_A", "x_A", "y_A", "z_A", "tx", "ty", "tz", "curvature_per_A", "twist_rad_per_A")
    for candidate in fold.candidates:
        for values in np.column_stack(list(line(candidate).values())):
            numbers = (f"{v:.9g}" for v in values)
            yield {"rank": candidate.rank, **dict(zip(names, numbers, strict=True))}


def _write_traces(path: Path, fold: LoopFold, structure: Structure, letter: str) -> None:
    """One MODEL per candidate: a point CEN per nucleotide, its expected error as B factor."""
    lines = renamed_records({fold.hairpin.chain: letter}) + expected_records(fold.candidates)
    for candidate in fold.candidates:
        lines.append(f"MODEL     {candidate.rank:4d}")
        lines += point_records(fold, structure, candidate, letter, 1)
        lines.append("ENDMDL")
    write_text(path, "\n".join([*lines, *bond_records(1, len(fold.hairpin)), "END", ""]))


def _write_scene(
    path: Path,
    fold: LoopFold,
    setting: Setting,
    atoms: "LoopAtoms | None",
    content: Mapping[str, Any],
    files: Collection[str],
) -> None:
    """What report.html shows of the loop, with what the manifest says of its origin."""
    source = content["input"]
    name = printable(str(source.get("file") or source.get("sequence") or "universe"))
    provenance = {
        "version": content["version"],
        "sha256": source.get("sha256"),
        "parameters": content["parameters"],
        "files": sorted(files),
    }
    write_scene(path, [fold_scene(fold, setting, name, atoms, content["remarks"])], provenance)


def other_folders(out: Path, names: Collection[str], manifest: str = MANIFEST) -> list[str]:
    """Folders of results of files in a folder of results, other than those named.

    Parameters
    ----------
    out : Path
        Folder of results.
    names : collection of str
        Folders that are known.
    manifest : str
        File that each of them has.

    Returns
    -------
    list of str
        Their names in order; what is no result of a file is left out.
    """
    others = sorted(f.name for f in os.scandir(out) if f.is_dir() and f.name not in names)
    manifests = ((name, read_manifest(out / name / manifest)) for name in others)
    return [name for name, found in manifests if _is_of_file(found.get("input", {}))]


def _is_of_file(source: Mapping[str, Any] | str) -> bool:
    """Whether the input is a file: `fill` has its name, `build` a sequence in place of a file."""
    return isinstance(source, str) or "file" in source
