"""Scripts that show the candidates over the structure in PyMOL and in ChimeraX.

Both programs take parts of a name for commands: a semicolon, a line feed, a quote. What a file says
of itself therefore stands in a script only where it is made of harmless characters.
"""

import os
import re
import shutil
from pathlib import Path

from loopelastica._files import write_text
from loopelastica._names import safe_name
from loopelastica._version import __version__
from loopelastica.folding.result import LoopFold

# The first ten colours of matplotlib, so that plot.png and the scripts agree.
_COLOURS = ("1f77b4", "ff7f0e", "2ca02c", "d62728", "9467bd",
            "8c564b", "e377c2", "7f7f7f", "bcbd22", "17becf")  # fmt: skip
# A minus sign that PyMOL does not take for a range.
_MINUS = "\\"


def write_pymol(path: Path, fold: LoopFold, source: str, chain: str) -> None:
    """Write a PyMOL script: the candidates as sticks over the file's own structure.

    Parameters
    ----------
    path : Path
        The script; traces.pdb is beside it.
    fold : LoopFold
        What was folded.
    source : str
        Path of the structure file, from the folder of the script, as `shown_file` gives it.
    chain : str
        Chain of the loop in the viewer, "" where it has none.
    """
    numbers = f"resi {_numbers(fold, '+', _MINUS)}"
    name = chain if _is_plain(chain) else f'"{chain}"'
    place = f"chain {name} and {numbers}" if _can_be_said(chain) else numbers
    lines = [
        _headline(fold),
        "# Run it in this folder: pymol view.pml",
        # the lines of the candidates are their CONECT records
        "set connect_mode, 1",
        "load traces.pdb, candidates",
        "split_states candidates, prefix=rank_",
        "delete candidates",
        "set connect_mode, 0",
        f"load {source}, native",
        "hide everything",
        "show cartoon, native",
        "color grey70, native",
        f"select loop, native and {place}",
        "show sticks, loop",
        "color grey40, loop",
        "set all_states, off",
        "set stick_radius, 0.12, native",
    ]
    for candidate in fold.candidates:
        name = f"rank_{candidate.rank:04d}"
        lines += [
            f"show sticks, {name}",
            f"show spheres, {name}",
            f"color 0x{_COLOURS[(candidate.rank - 1) % len(_COLOURS)]}, {name}",
            f"set stick_radius, {0.4 if candidate.rank == 1 else 0.2}, {name}",
            f"set sphere_scale, {0.35 if candidate.rank == 1 else 0.2}, {name}",
        ]
    lines += ["deselect", "orient rank_0001", "zoom rank_0001, 12"]
    write_text(path, "\n".join([*lines, ""]))


def write_chimerax(path: Path, fold: LoopFold, source: str, chain: str, n_models: int) -> None:
    """Write a ChimeraX script of the same content.

    Parameters
    ----------
    path, fold, source, chain
        As for :func:`write_pymol`.
    n_models : int
        Models of the structure file.
    """
    several = len(fold.candidates) > 1
    attribute = f'//chain_id="{chain}"' if _can_be_said(chain) else ""
    chain = f"/{chain}" if _is_plain(chain) else attribute
    native = "#2.1" if n_models > 1 else "#2"
    lines = [
        _headline(fold),
        "open traces.pdb",
        f'open "{source}"',
        "hide atoms",
        "hide #2 models",
        "show #2 models" if native == "#2" else "show #2.1 models",
        f"cartoon {native}",
        f"color {native} gray",
        f"show {native}{chain}:{_numbers(fold, ',', '')} atoms",
        "show #1 atoms",
        "style #1 ball",
    ]
    for candidate in fold.candidates:
        model = f"#1.{candidate.rank}" if several else "#1"
        lines += [
            f"color {model} #{_COLOURS[(candidate.rank - 1) % len(_COLOURS)]}",
            f"size {model} stickRadius {0.4 if candidate.rank == 1 else 0.2}",
        ]
    lines += [f"view #1{'.1' if several else ''}"]
    write_text(path, "\n".join([*lines, ""]))


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
