"""Open a structure file with MDAnalysis; every fault becomes one sentence that names the file.

MDAnalysis reads most files well, but fails late, loudly or not at all on damaged ones, cannot read
PDB models of unequal size, and takes the first model only of an mmCIF file. The text of a PDB file
is therefore looked through once before, and those two cases are read model by model here.
"""

from __future__ import annotations

import bz2
import gzip
import importlib
import io
import lzma
import warnings
import zlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from loopelastica._arrays import Array
from loopelastica.errors import MissingDependencyError, StructureError

_OPENERS: dict[str, Any] = {".gz": gzip.open, ".bz2": bz2.open}
_PDB = (".pdb", ".ent")
_MMCIF = (".cif", ".mmcif")
_COORDINATES = (slice(30, 38), slice(38, 46), slice(46, 54))  # PDB format 3.3, columns 31-54
_NAMES = slice(12, 20)  # atom name, altloc, residue name: copies of a chain have these in common
_IDENTITY = slice(12, 27)  # atom name, altloc, residue name, chain, number, insertion code


class Frames(Protocol):
    """Coordinates of the models of one structure."""

    @property
    def n_models(self) -> int:
        """Number of models."""

    @property
    def complete(self) -> bool:
        """Whether every model has every atom (NaN stands for an absent one)."""

    def model(self, k: int) -> Array:
        """Positions (n_atoms, 3) of model k, Å."""


@dataclass(frozen=True, slots=True, eq=False)
class TrajectoryFrames:
    """The frames of the Universe of a file, each read when it is needed."""

    universe: Any
    complete: bool = True

    @property
    def n_models(self) -> int:
        """Number of frames."""
        return int(self.universe.trajectory.n_frames)

    def model(self, k: int) -> Array:
        """Positions of frame k."""
        with quiet():
            self.universe.trajectory[k]
        return np.array(self.universe.atoms.positions, dtype=np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class TableFrames:
    """Models whose positions are all in memory."""

    tables: tuple[Array, ...]
    complete: bool

    @property
    def n_models(self) -> int:
        """Number of models."""
        return len(self.tables)

    def model(self, k: int) -> Array:
        """Positions of model k."""
        return np.array(self.tables[k])


class quiet(warnings.catch_warnings):  # noqa: N801 - used like the function it extends
    """Keep the remarks of MDAnalysis on what it guesses away from the user."""

    def __enter__(self) -> None:
        """Ignore warnings until the block ends."""
        super().__enter__()
        warnings.simplefilter("ignore")


def open_file(path: Path) -> tuple[Any, Frames]:
    """Universe (topology) and frames of a structure file.

    Parameters
    ----------
    path : Path
        PDB or mmCIF, also compressed by gzip or bzip2, or any other file with topology and
        coordinates that MDAnalysis reads.

    Raises
    ------
    StructureError
        If the file is absent, a folder, unreadable, empty, cut short or not understood.
    MissingDependencyError
        If an mmCIF file is to be read without gemmi.
    """
    kind = _kind(path)
    data = _bytes(path)
    if not data.strip():
        raise StructureError(f"{path}: the file is empty")
    if kind in _PDB:
        return _open_pdb(path, data.decode("utf-8", errors="replace"))
    if kind in _MMCIF:
        return _open_mmcif(path, data)
    universe = _universe(path, str(path))
    return universe, TrajectoryFrames(universe)


def pdb_records(path: Path) -> list[str]:
    """Lines of the first model of a PDB file as they are: atoms, ANISOU and TER, and CRYST1."""
    records: list[str] = []
    for line in _bytes(path).decode("utf-8", errors="replace").splitlines():
        if line.startswith("ENDMDL"):
            break
        if line.lstrip().startswith(("ATOM  ", "HETATM", "ANISOU", "TER", "CRYST1")):
            records.append(line.lstrip())
    return records


def is_pdb(path: Path) -> bool:
    """Whether a file is in PDB format, by its name."""
    return _kind(path) in _PDB


def first_line(error: BaseException) -> str:
    """Return what an exception says, as one clause."""
    text = str(error).strip() or type(error).__name__
    return text.splitlines()[0].strip().rstrip(".:")[:160]


def _kind(path: Path) -> str:
    suffixes = [suffix.lower() for suffix in path.suffixes]
    if suffixes and suffixes[-1] in _OPENERS:
        suffixes.pop()
    return suffixes[-1] if suffixes else ""


def _bytes(path: Path) -> bytes:
    """Return the decompressed content of a PDB or mmCIF file, one byte of any other."""
    if path.is_dir():
        raise StructureError(f"{path}: this is a folder, not a structure file")
    if not path.exists():
        raise StructureError(f"{path}: there is no such file")
    opener = _OPENERS.get(path.suffix.lower(), open)
    size = -1 if _kind(path) in (*_PDB, *_MMCIF) else 1
    try:
        with opener(path, "rb") as stream:
            return bytes(stream.read(size))
    except EOFError:
        raise StructureError(f"{path}: the compressed file is cut short") from None
    except PermissionError:
        raise StructureError(f"{path}: no permission to read the file") from None
    except (OSError, zlib.error, lzma.LZMAError) as error:
        raise StructureError(f"{path}: the file cannot be read ({first_line(error)})") from None


def _universe(path: Path, source: Any, **kwargs: Any) -> Any:
    """Universe of a path or stream with its first frame read."""
    with quiet():
        import MDAnalysis

        try:
            universe = MDAnalysis.Universe(source, **kwargs)
            _ = universe.atoms.names, universe.atoms.positions
        # MDAnalysis and its readers raise whatever a damaged file provokes.
        except Exception as error:
            raise StructureError(
                f"{path}: MDAnalysis cannot read it ({first_line(error)})"
            ) from error
    return universe


# --- PDB ------------------------------------------------------------------------------------------


@dataclass(slots=True)
class _Model:
    """The atom records of one model; `closed` once its ENDMDL was seen."""

    lines: list[str] = field(default_factory=list)
    closed: bool = False
    indented: bool = False


def _open_pdb(path: Path, text: str) -> tuple[Any, Frames]:
    models = _scan_pdb(path, text)
    sizes = {len(model.lines) for model in models}
    alike = len(sizes) == 1 and _in_one_order(models)
    if alike and not any(model.indented for model in models):
        universe = _universe(path, str(path))
        return universe, TrajectoryFrames(universe)
    if len(models) > 1 and not models[-1].closed:
        raise StructureError(
            f"{path}: the file is cut short, model {len(models)} has "
            f"{len(models[-1].lines)} of {len(models[0].lines)} atoms"
        )
    from MDAnalysis.lib.util import NamedStream

    stream = NamedStream(io.StringIO("\n".join([*models[0].lines, "END", ""])), f"{path.name}.pdb")
    universe = _universe(path, stream, format="PDB", topology_format="PDB")
    order = {key: row for row, key in enumerate(_identities(models[0].lines))}
    tables = tuple(_matched(model.lines, order, len(universe.atoms)) for model in models)
    return universe, TableFrames(tables, complete=alike)


def _scan_pdb(path: Path, text: str) -> list[_Model]:
    """Atom records by model; a record without three readable coordinates ends the reading."""
    models = [_Model()]
    for number, raw in enumerate(text.splitlines(), start=1):
        line = raw.lstrip()
        if line.startswith(("ATOM  ", "HETATM")):
            if len(line) < _COORDINATES[-1].stop:
                raise StructureError(
                    f"{path}: line {number} is cut short before its coordinates end"
                )
            try:
                for part in _COORDINATES:
                    float(line[part])
            except ValueError:
                raise StructureError(
                    f"{path}: line {number} has no readable coordinates ({line[30:54].strip()!r})"
                ) from None
            models[-1].lines.append(line)
            models[-1].indented |= len(line) != len(raw)
        elif line.startswith("MODEL ") and models[-1].lines:
            models.append(_Model())
        elif line.startswith("ENDMDL"):
            models[-1].closed = True
    if not models[0].lines:
        raise StructureError(f"{path}: no ATOM or HETATM record, so this is not a PDB structure")
    if len(models) > 1 and not models[-1].lines:
        raise StructureError(f"{path}: the file is cut short, model {len(models)} has no atoms")
    return models


def _in_one_order(models: list[_Model]) -> bool:
    """Whether all models name the same atoms in the same order, as MDAnalysis takes for granted."""
    first = [line[_NAMES] for line in models[0].lines]
    return all([line[_NAMES] for line in model.lines] == first for model in models[1:])


def _identities(lines: list[str]) -> Iterator[tuple[str, int]]:
    """What names an atom, and how often it came before: without chains two atoms share a name."""
    seen: Counter[str] = Counter()
    for line in lines:
        identity = line[_IDENTITY]
        yield identity, seen[identity]
        seen[identity] += 1


def _matched(lines: list[str], order: dict[tuple[str, int], int], n_atoms: int) -> Array:
    """Positions of one model in the atom order of the first; NaN where it lacks an atom."""
    positions = np.full((n_atoms, 3), np.nan)
    for line, key in zip(lines, _identities(lines), strict=True):
        row = order.get(key)
        if row is not None:
            positions[row] = [float(line[part]) for part in _COORDINATES]
    return positions


# --- mmCIF ----------------------------------------------------------------------------------------


def _open_mmcif(path: Path, data: bytes) -> tuple[Any, Frames]:
    try:
        gemmi = importlib.import_module("gemmi")
    except ImportError:
        raise MissingDependencyError(
            f"{path}: reading mmCIF needs gemmi; install it with `pip install loopelastica[mmcif]`"
        ) from None
    try:
        structure = gemmi.make_structure_from_block(
            gemmi.cif.read_string(data.decode("utf-8", errors="replace")).sole_block()
        )
    # gemmi raises ValueError, RuntimeError or IndexError by the place of the fault.
    except Exception as error:
        raise StructureError(f"{path}: gemmi cannot read it ({first_line(error)})") from error
    if len(structure) == 0 or structure[0].count_atom_sites() == 0:
        raise StructureError(f"{path}: no atoms, so this is not an mmCIF structure")
    universe = _universe(path, str(path))
    if len(structure) == 1:
        return universe, TrajectoryFrames(universe)
    order = {key: row for row, (key, _) in enumerate(_sites(structure[0]))}
    tables = []
    for model in structure:
        positions = np.full((len(universe.atoms), 3), np.nan)
        for key, position in _sites(model):
            if key in order:
                positions[order[key]] = position
        tables.append(positions)
    complete = len({model.count_atom_sites() for model in structure}) == 1
    return universe, TableFrames(tuple(tables), complete)


def _sites(model: Any) -> Iterator[tuple[tuple[str, ...], list[float]]]:
    """Identity and position of each atom of a gemmi model, in the order MDAnalysis keeps."""
    for chain in model:
        for residue in chain:
            for atom in residue:
                key = (chain.name, str(residue.seqid), residue.name, atom.name, atom.altloc)
                yield key, atom.pos.tolist()
