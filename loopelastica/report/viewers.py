"""Scripts that show the candidates on the structure in PyMOL and in ChimeraX.

The first candidate is a thick tube with its nucleotides, the others are thin ones; those that run
into something are loaded and not shown. Of a large structure only what is near is drawn.

Both programs take parts of a name for commands: a semicolon, a line feed, a quote. What a file says
of itself therefore stands in a script only where it is made of harmless characters.
"""

import os
import re
import shutil
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from loopelastica._files import write_text
from loopelastica._names import safe_name
from loopelastica._version import __version__
from loopelastica.folding.rank import Candidate
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.setting import NEAR_A, Setting
from loopelastica.report.palette import NATIVE, NEIGHBOUR, STEM, colour
from loopelastica.report.pdb import POINT
from loopelastica.report.scene import View, names_of, short_shape, tube, view_of
from loopelastica.report.tubes import TUBE

# A minus sign that PyMOL does not take for a range.
_MINUS = "\\"
# How near to the first line the structure's cartoon is shown, and its atoms as lines, Å.
_CARTOON_A = 20.0
# Radii of tubes, the first and the others, and of the nucleotides' points, Å.
_RADII = (0.45, 0.15)
_POINT_A = 0.9
# How far from its nucleotide a name stands: of the extent of the loop, and at least so many Å.
_LABEL, _LABEL_A = 0.08, 2.2


def write_pymol(
    path: Path,
    fold: LoopFold,
    source: str,
    chain: str,
    setting: Setting | None = None,
    atoms: Sequence[int] = (),
) -> None:
    """Write a PyMOL script: the candidates as tubes on the file's own structure.

    Parameters
    ----------
    path : Path
        The script; tubes.pdb is beside it.
    fold : LoopFold
        What was folded.
    source : str
        Path of the structure file, from the folder of the script, as `shown_file` gives it.
    chain : str
        Chain of the loop in the viewer, "" where it has none.
    setting : Setting, optional
        Where the closing pair is, to label it and to set the stem upright.
    atoms : sequence of int
        Ranks of the candidates in loop.sdf, in its order; empty where there is no such file.
    """
    numbers = f"resi {_numbers(fold, '+', _MINUS)}"
    name = chain if _is_plain(chain) else f'"{chain}"'
    place = f"chain {name} and {numbers}" if _can_be_said(chain) else numbers
    view = view_of(fold, setting).broadside(fold.candidates[0].trace)
    # columns of the rotation from the file's axes to the screen's, the eye, what it looks at
    turned = np.column_stack([view.across, view.up, view.towards]).ravel()
    looks = (*turned, 0.0, 0.0, -80.0, *view.middle_A, 40.0, 120.0, -20.0)
    first = _object(fold.candidates[0])
    lines = [
        _headline(fold),
        "# Run it in this folder: pymol view.pml",
        # the lines of the candidates are their CONECT records
        "set connect_mode, 1",
        "load tubes.pdb, tubes",
        "split_states tubes, prefix=rank_",
        "delete tubes",
        "set connect_mode, 0",
        f"load {source}, native",
        "bg_color white",
        "set all_states, off",
        "hide everything",
    ]
    for candidate in fold.candidates:
        split, name = f"rank_{candidate.rank:04d}", _object(candidate)
        radius = _RADII[candidate.rank > 1]
        lines += [
            f"set_name {split}, {name}",
            f"color 0x{colour(candidate.rank)[1:]}, {name}",
            f"set stick_radius, {radius}, {name}",
            f"show sticks, {name} and name {TUBE}",
            f"set_title {name}, 1, {_figures(candidate)}",
        ]
        if candidate.contacts.touching and candidate.rank > 1:
            lines.append(f"disable {name}")
    lines += [
        f"show spheres, {first} and name {POINT}",
        f"set sphere_scale, {_POINT_A / 1.8:.2f}, {first}",
        f"show cartoon, byres (native within {_CARTOON_A:.0f} of {first})",
        f"show lines, byres ((native and polymer) within {NEAR_A:.0f} of {first})",
        "hide lines, hydro",
        f"color 0x{STEM[1:]}, native",
        f"color 0x{NEIGHBOUR[1:]}, native and elem C",
        f"select loop, native and {place}",
        "hide lines, loop",
        "hide cartoon, loop",
        "set stick_radius, 0.10, native",
        "set cartoon_transparency, 0.4, native",
        f"color 0x{NATIVE[1:]}, loop",
    ]
    if fold.backbone_A is not None:
        lines.append("show sticks, loop and not hydro")
    if atoms:
        lines += ["load loop.sdf, atoms", "split_states atoms, prefix=atoms_", "delete atoms"]
        for k, rank in enumerate(atoms, start=1):
            name = f"atoms_of_{rank:02d}"
            lines += [
                f"set_name atoms_{k:04d}, {name}",
                f"hide everything, {name}",
                f"show sticks, {name}",
                f"set stick_radius, 0.14, {name}",
                f"color 0x{colour(rank)[1:]}, {name} and elem C",
                *([f"disable {name}"] if rank > 1 else []),
            ]
    for label, (x, y, z) in _labels(fold, setting, view):
        lines.append(f'pseudoatom names, pos=({x:.3f}, {y:.3f}, {z:.3f}), label="{label}"')
    lines += [
        "hide wire, names",
        "set label_position, (0, 0, 3)",
        "set label_color, black",
        "set label_size, 18",
        "set label_outline_color, white",
        "set float_labels, on",
        "set depth_cue, 0",
        "set ray_shadows, 0",
        "deselect",
        f"set_view ({', '.join(f'{value:.6f}' for value in looks)})",
        f"zoom {first}, 8",
        *(f'print("rank {c.rank:2d}  {_plain(c.shape)}  {_figures(c)}")' for c in fold.candidates),
    ]
    write_text(path, "\n".join([*filter(None, lines), ""]))


def write_chimerax(
    path: Path,
    fold: LoopFold,
    source: str,
    chain: str,
    n_models: int,
    setting: Setting | None = None,
    atoms: Sequence[int] = (),
) -> None:
    """Write a ChimeraX script of the same content.

    Parameters
    ----------
    path, fold, source, chain, setting, atoms
        As for :func:`write_pymol`.
    n_models : int
        Models of the structure file.
    """
    several = len(fold.candidates) > 1
    attribute = f'//chain_id="{chain}"' if _can_be_said(chain) else ""
    chain = f"/{chain}" if _is_plain(chain) else attribute
    native = "#2.1" if n_models > 1 else "#2"
    first = "#1.1" if several else "#1"
    place = f"{native}{chain}:{_numbers(fold, ',', '')}"
    view = view_of(fold, setting).broadside(fold.candidates[0].trace)
    eye = view.middle_A + 80.0 * view.towards
    camera = np.column_stack([view.across, view.up, view.towards, eye])
    lines = [
        _headline(fold),
        "open tubes.pdb",
        f'open "{source}"',
        "set bgColor white",
        "hide atoms",
        "hide cartoons",
        "hide #2 models",
        "show #2 models" if native == "#2" else "show #2.1 models",
        f"color {native} {NEIGHBOUR}",
        f"show {native} & {first} :<{_CARTOON_A:.0f} cartoons",
        f"transparency {native} 40 target c",
        f"show {native} & {first} :<{NEAR_A:.0f} & (protein | nucleic) atoms",
        f"style {native} stick",
        f"size {native} stickRadius 0.07",
        f"color {place} {NATIVE}",
        f"{'show' if fold.backbone_A is not None else 'hide'} {place} atoms",
        f"show #1@{TUBE} atoms",
        "style #1 stick",
        f"show {first}@{POINT} atoms",
        f"style {first}@{POINT} sphere",
        f"size {first}@{POINT} atomRadius {_POINT_A}",
        f"label {first}@{POINT} residues text {{0.name}}{{0.number}} height 1.5 color black",
    ]
    for candidate in fold.candidates:
        model = f"#1.{candidate.rank}" if several else "#1"
        lines += [
            f"color {model} {colour(candidate.rank)}",
            f"size {model} stickRadius {_RADII[candidate.rank > 1]}",
            f'rename {model} "{candidate.rank} {_plain(candidate.shape)}  {_figures(candidate)}"',
        ]
        if candidate.contacts.touching and candidate.rank > 1:
            lines.append(f"hide {model} models")
    if atoms:
        lines += ["open loop.sdf", "hide #3 atoms", "style #3 stick", "size #3 stickRadius 0.14"]
        for k, rank in enumerate(atoms, start=1):
            model = f"#3.{k}" if len(atoms) > 1 else "#3"
            lines += [
                f"color {model} {colour(rank)}",
                f"color {model} byhetero",
                f'rename {model} "atoms of {rank}"',
                f"{'show' if rank == 1 else 'hide'} {model} {'atoms' if rank == 1 else 'models'}",
            ]
    lines += [
        f"view matrix camera {','.join(f'{value:.6f}' for value in camera.ravel())}",
        f"view {first} clip false pad 0.3",
    ]
    write_text(path, "\n".join([*lines, ""]))


def _object(candidate: Candidate) -> str:
    """The name of a candidate in PyMOL, such as "rank_01_motif_UNCG"."""
    words = re.sub(r"[^A-Za-z0-9]+", "_", short_shape(candidate, 24)).strip("_")
    return f"rank_{candidate.rank:02d}_{words}".rstrip("_")


def _figures(candidate: Candidate) -> str:
    """Energy and expected error in signs that mean nothing to a viewer.

    A log that says "error" says it of the viewer, hence the other word.
    """
    low, middle, high = candidate.expected_rmsd_A
    return (
        f"E/K0 {candidate.energy_per_A:.4f} 1/A  expected RMSD {middle:.1f} A"
        f" {low:.1f} to {high:.1f} in 80 of 100"
    )


def _plain(text: str) -> str:
    return re.sub(r"[^A-Za-z0-9_.+ -]+", "_", text)


def _labels(fold: LoopFold, setting: Setting | None, view: View) -> list[tuple[str, list[float]]]:
    """Names of nucleotides, closing pair first and last, and where they stand, Å: outside."""
    points = fold.candidates[0].trace
    first, last = tube(fold, fold.candidates[0], setting, 2)
    points = np.concatenate([[first], points, [last]])
    out = points - points.mean(axis=0)
    out -= np.outer(out @ view.towards, view.towards)
    out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-6)
    names = [_plain(name) for name in names_of(fold, setting)]
    away = max(_LABEL_A, _LABEL * float(np.ptp(points, axis=0).max()))
    return list(zip(names, (points + away * out).tolist(), strict=True))


def _headline(fold: LoopFold) -> str:
    # PyMOL takes what follows a semicolon in a comment for a command
    label = "–".join(safe_name(name) for name in fold.hairpin.closing_pair)
    return f"# loopelastica {__version__}: the candidates for {label} over the file's own loop."


def _numbers(fold: LoopFold, joint: str, minus: str) -> str:
    """Residue numbers of the loop as a viewer reads them, a negative one after the sign `minus`."""
    hairpin = fold.hairpin
    return joint.join(
        f"{minus if number < 0 else ''}{number}{icode if _is_plain(icode) else ''}"
        for number, icode in zip(hairpin.resid, hairpin.icode, strict=True)
    )


def _can_be_said(chain: str) -> bool:
    """Whether a chain can be named; else the numbers alone say where the loop is."""
    return re.fullmatch(r"[A-Za-z0-9_. -]*[A-Za-z0-9_.-]", chain) is not None


def _is_plain(text: str) -> bool:
    return text.isascii() and text.isalnum()


def shown_file(folder: Path, source: Path) -> str:
    """What the scripts of a folder call the structure file.

    Parameters
    ----------
    folder : Path
        Where they are.
    source : Path
        The file.

    Returns
    -------
    str
        Its path from the folder. Where a viewer could take a part of that for something else, a
        link in the folder, or a copy where links cannot be made: native.pdb.
    """
    path = path_from(folder, source)
    if re.fullmatch(r"[A-Za-z0-9_.+/-]+", path):
        return path
    suffix = re.search(r"(\.[A-Za-z0-9]+)?(\.gz|\.bz2)?$", source.name)
    name = f"native{suffix.group() if suffix else ''}"
    try:
        (folder / name).symlink_to(path)
    except OSError:
        shutil.copyfile(source, folder / name)
    return name


def path_from(folder: Path, file: Path) -> str:
    """Path of a file as seen from a folder, so that both can be moved together.

    Parameters
    ----------
    folder, file : Path

    Returns
    -------
    str
        With forward slashes; absolute where the two are on different drives.
    """
    try:
        return Path(os.path.relpath(file.resolve(), folder.resolve())).as_posix()
    except ValueError:
        return file.resolve().as_posix()
