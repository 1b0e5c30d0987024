"""Open a structure file with MDAnalysis; every fault becomes one sentence that names the file.

    file → regular? → pieces, up to the limits → scan of the records → MDAnalysis → Universe, models

The text of PDB and mmCIF files is looked through before, by :mod:`loopelastica.molecule._pdb` and
:mod:`loopelastica.molecule._mmcif`; of other formats only the size is known before they are read.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Final

from loopelastica.errors import StructureError
from loopelastica.molecule._frames import (
    Frames,
    TableFrames,
    TrajectoryFrames,
    quiet,
    universe_of,
)
from loopelastica.molecule._mmcif import open_mmcif
from loopelastica.molecule._pdb import open_pdb, pdb_records
from loopelastica.molecule._source import (
    MAX_ATOMS,
    MAX_SIZE_MB,
    Limits,
    first_line,
    kind_of,
    name_of,
    pieces,
)

__all__ = [
    "MAX_ATOMS",
    "MAX_SIZE_MB",
    "Frames",
    "Limits",
    "TableFrames",
    "first_line",
    "is_mmcif",
    "is_pdb",
    "name_of",
    "open_file",
    "pdb_records",
    "quiet",
]

_PDB: Final = (".pdb", ".ent")
_MMCIF: Final = (".cif", ".mmcif")
# What MDAnalysis reads both atoms and coordinates from, and no other file beside it: topologies
# such as .itp include others, trajectories such as .xtc leave a file of offsets behind.
_OTHERS: Final = (
    *(".arc", ".config", ".crd", ".data", ".dms", ".gms", ".gro", ".gsd", ".in", ".lammpsdump"),
    *(".mmtf", ".mol2", ".pdbqt", ".pqr", ".tpr", ".txyz", ".xpdb", ".xyz"),
)
# How many atoms the head of a file states: MDAnalysis makes room for them before it reads on.
_STATED: Final = {
    ".gro": rb"\A[^\n]*\n\s*(\d+)",
    ".xyz": rb"\A\s*(\d+)",
    ".txyz": rb"\A\s*(\d+)",
    ".arc": rb"\A\s*(\d+)",
    ".crd": rb"\A(?:\*[^\n]*\n)*\s*(\d+)",
    ".mol2": rb"@<TRIPOS>MOLECULE[^\n]*\n[^\n]*\n\s*(\d+)",
    ".data": rb"(?m)^\s*(\d+)\s+atoms",
    ".lammpsdump": rb"NUMBER OF ATOMS\s*\n\s*(\d+)",
}


def open_file(path: Path, limits: Limits) -> tuple[Any, Frames]:
    """Universe (topology) and frames of a structure file.

    Parameters
    ----------
    path : Path
        PDB or mmCIF, also compressed by gzip or bzip2, or another file that MDAnalysis reads both
        atoms and coordinates from.
    limits : Limits
        How large it may be.

    Raises
    ------
    StructureError
        If the file is absent, not regular, unreadable, empty, cut short, too large or not
        understood.
    """
    kind = kind_of(path)
    if kind in _PDB:
        return open_pdb(path, limits)
    if kind in _MMCIF:
        return open_mmcif(path, limits)
    head, blank = b"", True
    for piece in pieces(path, limits):
        head, blank = head or piece, blank and piece.isspace()
    if blank:
        raise StructureError(f"{name_of(path)}: the file is empty")
    if kind not in _OTHERS:
        raise StructureError(
            f"{name_of(path)}: MDAnalysis cannot read it (it finds no atoms and coordinates in"
            f" files named *{kind}; PDB and mmCIF are what is read best)"
        )
    stated = re.search(_STATED[kind], head) if kind in _STATED else None
    limits.check_atoms(path, int(stated[1][:20]) if stated else 0)
    universe = universe_of(path, str(path))
    limits.check_atoms(path, len(universe.atoms))
    return universe, TrajectoryFrames(universe)


def is_pdb(path: Path) -> bool:
    """Whether a file is in PDB format, by its name."""
    return kind_of(path) in _PDB


def is_mmcif(path: Path) -> bool:
    """Whether a file is in mmCIF format, by its name."""
    return kind_of(path) in _MMCIF
