"""Which entry of the databank a file is, by what it says of itself and by its name.

>>> entry_of(Path("pdb1zih.ent.gz")), entry_of(Path("model_3.pdb"))
('1zih', 'model_3')
"""

from __future__ import annotations

import os
import re
from contextlib import closing
from pathlib import Path
from typing import Any, Final

from loopelastica._names import safe_stem
from loopelastica.errors import StructureError
from loopelastica.molecule._source import Limits, pieces
from loopelastica.molecule.nucleotides import Structure
from loopelastica.molecule.reading import is_mmcif, is_pdb

# Identifiers of the databank. In a file name one has a letter, or else a date would be one.
_CODE: Final = r"(?:pdb_0000)?([0-9][0-9a-z]{3})"
_NAME: Final = re.compile(rf"(?:pdb)?(?=[0-9a-z]{{0,3}}[a-z]){_CODE}(?![0-9a-z])")
_HEADER: Final = re.compile(rf"^HEADER.{{56}}{_CODE}".encode(), re.MULTILINE | re.IGNORECASE)
_ENTRY: Final = re.compile(rf"^_entry\.id\s+['\"]?{_CODE}(?!\w)".encode(), re.M | re.IGNORECASE)


def entry_of(source: Any) -> str:
    """The entry that a structure belongs to, in lower case.

    Parameters
    ----------
    source : path, Structure, MDAnalysis.Universe or MDAnalysis.AtomGroup

    Returns
    -------
    str
        Identifier in the HEADER of a PDB file or the `_entry.id` of an mmCIF file; else the one
        that the file name begins with, such as 1zih of ``1zih_a4.pdb``; else the name without its
        suffixes. "" where there is no file.
    """
    return next(iter(entries_of(source)), "")


def entries_of(source: Any) -> tuple[str, ...]:
    """Every entry that a structure may belong to: by what it says, then by its file's name.

    Parameters
    ----------
    source
        As for :func:`entry_of`.

    Returns
    -------
    tuple of str
        Each once.
    """
    if isinstance(source, Structure):
        source = source.universe if source.source is None else source.source
    if not isinstance(source, str | os.PathLike):
        source = getattr(getattr(source, "universe", None), "filename", None)
    if not isinstance(source, str | os.PathLike):
        return ()
    path = Path(source)
    stated = _stated(path)
    return tuple(dict.fromkeys([*([stated] if stated else []), _named(path)]))


def _named(path: Path) -> str:
    stem = safe_stem(path).lower()
    found = _NAME.match(stem)
    return found[1] if found else stem


def _stated(path: Path) -> str | None:
    pattern = _HEADER if is_pdb(path) else _ENTRY if is_mmcif(path) else None
    if pattern is None:
        return None
    try:
        with closing(pieces(path, Limits())) as content:
            # both stand at the head of a file
            found = pattern.search(next(content, b""))
    except StructureError:
        return None  # whoever reads the structure says so
    return found[1].decode().lower() if found else None
