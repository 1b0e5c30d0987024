"""A structure as the file has it: its text, and what gemmi reads from it.

What is to be filled must go back into its file, with everything else in it as it was. So here a
file is its text and gemmi's reading of it; MDAnalysis is asked only for what comes as a Universe.

>>> from loopelastica._files import data_path
>>> entry = read_entry(data_path("hairpins/2koc.pdb"))
>>> entry.name, entry.kind, entry.n_models
('2koc.pdb', 'pdb', 20)
"""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import gemmi
import numpy as np

from loopelastica._checks import whole
from loopelastica.errors import StructureError
from loopelastica.molecule._mmcif import parse_mmcif, read_text
from loopelastica.molecule._pdb import pdb_text, scan_pdb
from loopelastica.molecule._source import Limits, check_regular, first_line, name_of
from loopelastica.molecule.reading import is_mmcif, is_pdb


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """A structure that has been read, with its text.

    Attributes
    ----------
    name : str
        File name, or "universe".
    path : Path or None
        None for a Universe or an AtomGroup.
    kind : str
        "pdb" or "mmcif".
    text : str
        The whole file; lines end in a line feed.
    structure : gemmi.Structure
        What gemmi reads from it.
    document : gemmi.cif.Document or None
        The parsed mmCIF; None for a PDB file.
    loaded_from : path or None
        What a Universe or an AtomGroup was loaded from, where that was a file.
    """

    name: str
    path: Path | None
    kind: Literal["pdb", "mmcif"]
    text: str = field(repr=False)
    structure: Any = field(repr=False)
    document: Any = field(default=None, repr=False)
    loaded_from: str | os.PathLike[str] | None = None

    @property
    def where(self) -> str:
        """What sentences call it: the path as given, or "universe"."""
        return self.name if self.path is None else name_of(self.path)

    @property
    def n_models(self) -> int:
        """Number of models."""
        return len(self.structure)

    def model(self, k: int) -> Any:
        """Model k of gemmi, from 0; ValueError if there is none."""
        if whole(0)("model", k) >= self.n_models:
            raise ValueError(f"`model` is {k}, but {self.name} has {self.n_models} model(s)")
        return self.structure[k]


def read_entry(source: Any, limits: Limits | None = None) -> Entry:
    """Read a PDB or mmCIF file, or take a Universe or an AtomGroup in its current frame.

    Parameters
    ----------
    source : path, MDAnalysis.Universe, MDAnalysis.AtomGroup or Entry
        PDB or mmCIF, also compressed by gzip or bzip2. An Entry is returned as it is.
    limits : Limits, optional
        How large a file may be; default ``Limits()``.

    Returns
    -------
    Entry

    Raises
    ------
    StructureError
        If the file cannot be read; one sentence with file and cause.
    ValueError
        If `source` is none of these.
    """
    if isinstance(source, Entry):
        return source
    limits = limits or Limits()
    if isinstance(source, str | os.PathLike):
        path = Path(source)
        if is_pdb(path):
            return _pdb(path, pdb_text(path, limits), limits, path)
        if is_mmcif(path):
            return _mmcif(path, read_text(path, limits), limits, path)
        # what is no file at all is told so rather than about its name
        with suppress(OSError, ValueError):
            check_regular(path)
        raise StructureError(
            f"{name_of(path)}: only PDB and mmCIF files can be filled, by their name *.pdb, *.ent,"
            " *.cif or *.mmcif, also with .gz or .bz2"
        )
    if hasattr(source, "universe") and hasattr(source, "atoms"):
        from loopelastica.molecule._universe import text_of

        kind, text = text_of(source)
        path = Path("universe")
        if kind == "pdb":
            entry = _pdb(path, text, limits, None)
        else:
            entry = _mmcif(path, text.encode(), limits, None)
        file = getattr(source.universe, "filename", None)
        return replace(entry, loaded_from=file if isinstance(file, str | os.PathLike) else None)
    raise ValueError(
        f"`source` is neither a path nor a Universe nor an AtomGroup but {type(source).__name__}"
    )


def _pdb(shown: Path, text: str, limits: Limits, path: Path | None) -> Entry:
    n_models = scan_pdb(shown, text, limits)
    try:
        structure = gemmi.read_pdb_string(text, split_chain_on_ter=True)
    # gemmi raises ValueError or RuntimeError by the place of the fault.
    except Exception as error:
        raise StructureError(
            f"{name_of(shown)}: gemmi cannot read it ({first_line(error)})"
        ) from error
    if len(structure) != n_models:
        raise StructureError(
            f"{name_of(shown)}: {n_models} models, but only {len(structure)} of them stand between"
            " MODEL and ENDMDL before the END of the file"
        )
    _check(shown, structure)
    return Entry(shown.name, path, "pdb", text, structure)


def _mmcif(shown: Path, text: bytes, limits: Limits, path: Path | None) -> Entry:
    parsed = parse_mmcif(shown, text, limits)
    _check(shown, parsed.structure)
    return Entry(
        shown.name,
        path,
        "mmcif",
        text.decode("utf-8", "replace").replace("\r\n", "\n"),
        parsed.structure,
        parsed.document,
    )


def _check(path: Path, structure: Any) -> None:
    """Refuse coordinates that are no numbers."""
    positions = gemmi.FlatStructure(structure).pos
    if not np.isfinite(positions).all():
        raise StructureError(f"{name_of(path)}: the coordinates of an atom are no numbers")
