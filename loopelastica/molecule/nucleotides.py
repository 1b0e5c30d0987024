"""A file, a Universe or an AtomGroup becomes a table of nucleotides, and positions by model.

>>> from loopelastica._files import data_path
>>> structure = read_structure(data_path("hairpins/2koc.pdb"))
>>> structure.n_models, "".join(structure.nucleotides.letter)
(20, 'GGCACUUCGGUGCC')
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array
from loopelastica._checks import whole
from loopelastica.errors import StructureError
from loopelastica.molecule._recognition import NO_CHAIN, recognize, strings
from loopelastica.molecule._topology import ATOM_NAMES, BACKBONE, RING, Nucleotides
from loopelastica.molecule.reading import (
    MAX_ATOMS,
    MAX_SIZE_MB,
    Frames,
    Limits,
    TableFrames,
    first_line,
    is_pdb,
    name_of,
    open_file,
    pdb_records,
    quiet,
)

__all__ = [
    "ATOM_NAMES",
    "BACKBONE",
    "MAX_ATOMS",
    "MAX_SIZE_MB",
    "NO_CHAIN",
    "RING",
    "Limits",
    "Nucleotides",
    "Structure",
    "atom_positions",
    "centroids",
    "centroids_at",
    "enumerated",
    "is_pdb",
    "linked",
    "pdb_records",
    "quiet",
    "read_structure",
    "strings",
]

LINK_MAX_A = 2.5
"""Longest O3'–P distance of two joined nucleotides; the bond has 1.6 Å, models of repute 2.0."""

FARTHEST_A = 1e6
"""Largest coordinate of a nucleotide: there single precision resolves 0.06 Å."""

STEP_MAX_A = 9.0
"""Longest C4'–C4' distance of two joined nucleotides where O3' or P is missing."""


@dataclass(frozen=True, slots=True, eq=False)
class Structure:
    """A structure that has been read: its nucleotides, and its models on demand.

    Attributes
    ----------
    name : str
        File name, or "universe".
    source : str or None
        Path as given, None for a Universe or an AtomGroup.
    nucleotides : Nucleotides
        Table of the nucleotides, the same for every model.
    universe : MDAnalysis.Universe
        All atoms; `nucleotides.atom_index` counts in them.
    remarks : tuple of str
        One sentence for each choice made in reading that a user should be aware of.
    """

    name: str
    source: str | None
    nucleotides: Nucleotides
    universe: Any = field(repr=False)
    remarks: tuple[str, ...]
    _frames: Frames = field(repr=False)

    @property
    def n_models(self) -> int:
        """Number of models of a file; 1 for the current frame of a Universe."""
        return self._frames.n_models

    @property
    def where(self) -> str:
        """What sentences call it: the path as given, or "universe"."""
        return self.name if self.source is None else name_of(Path(self.source))

    def positions(self, model: int = 0) -> Array:
        """Positions (n_atoms, 3) of all atoms of one model, Å, read-only.

        MDAnalysis keeps single precision: positions have about 1e-5 Å, more than any file has.
        A model that lacks atoms of the first one has NaN rows there.

        Raises
        ------
        ValueError
            If `model` is not in 0 … n_models − 1.
        StructureError
            If the model cannot be read, or a nucleotide lies at the origin, too far away, or has no
            numbers.
        """
        if whole(0)("model", model) >= self.n_models:
            raise ValueError(f"`model` is {model}, but {self.name} has {self.n_models} model(s)")
        try:
            positions = self._frames.model(model)
        # Readers of MDAnalysis raise whatever a damaged frame provokes.
        except Exception as error:
            raise StructureError(
                f"{self.where}: model {model + 1} cannot be read ({first_line(error)})"
            ) from error
        self.check(positions, model, self._frames.complete)
        positions.setflags(write=False)
        return positions

    def check(self, positions: Array, model: int = 0, complete: bool = False) -> None:
        """Refuse positions that are none of its nucleotides.

        Parameters
        ----------
        positions : (n_atoms, 3) array
            All atoms of one model, Å.
        model : int
            Its number, for the sentence.
        complete : bool
            Whether each atom must have one; otherwise NaN stands for an absent atom.

        Raises
        ------
        StructureError
            If a nucleotide lies at the origin, too far away, or has no numbers.
        """
        where = f"{self.where}, model {model + 1}" if self.n_models > 1 else self.where
        _check_positions(where, self.nucleotides, positions, complete)

    def models(self) -> Iterator[Array]:
        """Positions of each model in turn; one model is in memory at a time."""
        for model in range(self.n_models):
            yield self.positions(model)


def read_structure(source: Any, limits: Limits | None = None) -> Structure:
    """Read a file, or take a Universe or an AtomGroup in its current frame.

    Parameters
    ----------
    source : path, MDAnalysis.Universe, MDAnalysis.AtomGroup or Structure
        PDB or mmCIF (also gzipped), or whatever MDAnalysis reads, with all its models; a Universe,
        or a group of its atoms, in the frame its trajectory is at, which is the only model; a
        Structure is returned as it is.
    limits : Limits, optional
        How large a file may be; default ``Limits()``.

    Returns
    -------
    Structure

    Raises
    ------
    StructureError
        If the file cannot be read or has no nucleotide; one sentence with file and cause.
    ValueError
        If `source` is none of these.
    """
    if isinstance(source, Structure):
        return source
    frames: Frames
    if isinstance(source, str | os.PathLike):
        path = Path(source)
        universe, frames = open_file(path, limits or Limits())
        atoms, name, where = universe.atoms, path.name, name_of(path)
        given: str | None = str(path)
    elif hasattr(source, "universe") and hasattr(source, "atoms"):
        universe, atoms, name, where = source.universe, source.atoms.unique, "universe", "universe"
        given = None
        if not hasattr(universe, "trajectory"):
            raise StructureError("universe: it has no coordinates")
        frames = TableFrames(np.array([universe.atoms.positions], dtype=np.float64), True)
    else:
        raise ValueError(
            f"`source` is neither a path nor a Universe nor an AtomGroup but"
            f" {type(source).__name__}"
        )
    with quiet():
        if not hasattr(universe.atoms, "names"):
            raise StructureError(f"{where}: the atoms have no names")
        nucleotides = recognize(atoms)
    if len(nucleotides) == 0:
        n_residues = len(atoms.residues)
        raise StructureError(f"{where}: no nucleotide found among {n_residues} residues")
    remarks = tuple(_remarks(nucleotides, frames))
    structure = Structure(name, given, nucleotides, universe, remarks, frames)
    structure.positions(0)
    return structure


def _remarks(nucleotides: Nucleotides, frames: Frames) -> Iterator[str]:
    """Sentences on what was chosen where the file leaves a choice."""
    rows = np.flatnonzero(nucleotides.altloc != "")
    if len(rows):
        taken = [f"{nucleotides.label(int(row))} {nucleotides.altloc[row]}" for row in rows]
        yield (
            f"alternative locations in {len(rows)} nucleotide(s), the one of highest occupancy is"
            f" used: {enumerated(taken)}"
        )
    if not frames.complete:
        yield f"its {frames.n_models} models differ in their atoms and are read one by one"


def enumerated(names: Sequence[str], most: int = 8) -> str:
    """Names joined by commas, the surplus over `most` as a number.

    Parameters
    ----------
    names : sequence of str
        What is listed.
    most : int
        How many of them by name.

    Returns
    -------
    str

    Examples
    --------
    >>> enumerated(["a", "b", "c", "d"], most=2)
    'a, b and 2 more'
    """
    surplus = len(names) - most
    return ", ".join(names[:most]) + (f" and {surplus} more" if surplus > 0 else "")


def _check_positions(
    where: str, nucleotides: Nucleotides, positions: Array, complete: bool
) -> None:
    """Refuse coordinates that are no numbers, too large, or placeholders at the origin."""
    present = nucleotides.atom_index >= 0
    values = positions[nucleotides.atom_index]
    far = present & (np.abs(values) > FARTHEST_A).any(axis=2)
    if far.any():
        row = int(np.argmax(far.any(axis=1)))
        raise StructureError(
            f"{where}: the coordinates of {nucleotides.label(row)} are beyond {FARTHEST_A:,.0f} Å,"
            " where single precision ends"
        )
    finite = np.isfinite(values).all(axis=2)
    if not (finite & present).any() or (complete and (present & ~finite).any()):
        row = int(np.argmax((present & ~finite).any(axis=1)))
        raise StructureError(f"{where}: the coordinates of {nucleotides.label(row)} are no numbers")
    # One atom may lie at the origin by chance, two of one nucleotide cannot.
    at_origin = ((values == 0.0).all(axis=2) & present).sum(axis=1) > 1
    if at_origin.any():
        row = int(np.argmax(at_origin))
        count = "every nucleotide lies" if at_origin.all() else f"{nucleotides.label(row)} lies"
        raise StructureError(f"{where}: {count} at the origin, the coordinates are placeholders")


def atom_positions(nucleotides: Nucleotides, positions: Array, names: Sequence[str]) -> Array:
    """Positions (n, len(names), 3) of the named atoms of all nucleotides, NaN where missing.

    Parameters
    ----------
    nucleotides : Nucleotides
        Table of n nucleotides.
    positions : (n_atoms, 3) array
        All atoms of one model, Å.
    names : sequence of str
        Names among ``ATOM_NAMES``.

    Returns
    -------
    (n, len(names), 3) array
        Å.
    """
    index = nucleotides.columns(names)
    found = np.asarray(positions, dtype=np.float64)[index]
    found[index < 0] = np.nan
    return found


def linked(nucleotides: Nucleotides, positions: Array) -> NDArray[np.bool_]:
    """Whether the chain goes on from each nucleotide but the last to the next one.

    Parameters
    ----------
    nucleotides : Nucleotides
        Table of n nucleotides.
    positions : (n_atoms, 3) array
        All atoms of one model, Å.

    Returns
    -------
    (n − 1,) array of bool
        Same chain and O3'–P up to ``LINK_MAX_A``. Where O3' or the next P is not in the file:
        consecutive numbers, and C4'–C4' up to ``STEP_MAX_A``.
    """
    o3, p, c4 = np.moveaxis(atom_positions(nucleotides, positions, ("O3'", "P", "C4'")), 1, 0)
    bond = np.linalg.norm(p[1:] - o3[:-1], axis=1)
    step = np.linalg.norm(c4[1:] - c4[:-1], axis=1)
    difference = np.diff(nucleotides.resid)
    inserted = (difference == 0) & (nucleotides.icode[1:] != nucleotides.icode[:-1])
    consecutive = ((difference == 1) | inserted) & (step <= STEP_MAX_A)
    joined = np.where(np.isnan(bond), consecutive, bond <= LINK_MAX_A)
    same_chain = nucleotides.chain[1:] == nucleotides.chain[:-1]
    return np.asarray(joined & same_chain, dtype=np.bool_)


def centroids(nucleotides: Nucleotides, positions: Array) -> Array:
    """Mean (n, 3) of P O5' C5' C4' C3' O3' of each nucleotide, Å; NaN where one is missing.

    Parameters
    ----------
    nucleotides : Nucleotides
        Table of n nucleotides.
    positions : (n_atoms, 3) array
        All atoms of one model, Å.

    Returns
    -------
    (n, 3) array
    """
    mean: Array = atom_positions(nucleotides, positions, BACKBONE).mean(axis=1)
    return mean


def centroids_at(nucleotides: Nucleotides, positions: Array, rows: NDArray[np.int64]) -> Array:
    """Centroids (len(rows), 3) of some nucleotides, Å; NaN for the row −1 of an absent one.

    Parameters
    ----------
    nucleotides : Nucleotides
        Table of n nucleotides.
    positions : (n_atoms, 3) array
        All atoms of one model, Å.
    rows : (m,) array of int
        Rows of the table.

    Returns
    -------
    (m, 3) array
    """
    found = centroids(nucleotides, positions)[rows]
    found[np.asarray(rows) < 0] = np.nan
    return found
