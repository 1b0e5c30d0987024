"""Scripts that show the candidates over the structure in PyMOL and in ChimeraX."""

import os
from pathlib import Path

from loopelastica._files import write_text
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
        Path of the structure file, from the folder of the script.
    chain : str
        Chain of the loop in the viewer, "" where it has none.
    """
    place = " and ".join([f"chain {chain}"] * bool(chain) + [f"resi {_numbers(fold, '+', _MINUS)}"])
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
    chain = f"/{chain}" if chain else ""
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
    label = fold.hairpin.label
    return f"# loopelastica {__version__}: the candidates for {label} over the file's own loop."


def _numbers(fold: LoopFold, joint: str, minus: str) -> str:
    """Residue numbers of the loop as a viewer reads them, a negative one after the sign `minus`."""
    hairpin = fold.hairpin
    return joint.join(
        f"{minus if number < 0 else ''}{number}{icode}"
        for number, icode in zip(hairpin.resid, hairpin.icode, strict=True)
    )


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
