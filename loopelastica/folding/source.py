"""What a loop was folded in, so that it can be drawn and written later.

A file is read again when it is needed: folds of thousands of files hold no structure. Of a Universe
the atoms are kept, packed, as they were in the frame that was folded; neither later frames nor the
end of the trajectory change them.
"""

from __future__ import annotations

import os
import pickle
import zlib
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from loopelastica._arrays import Array
from loopelastica._files import sha256
from loopelastica.errors import StructureError
from loopelastica.molecule.neighbours import waters
from loopelastica.molecule.nucleotides import Limits, Structure, read_structure
from loopelastica.molecule.reading import TableFrames, quiet


@dataclass(frozen=True, slots=True)
class FileSource:
    """A structure file.

    Attributes
    ----------
    file : str
        The path as it was given.
    path : Path
        The same, absolute.
    sha256 : str
        Digest of its content when it was folded.
    """

    file: str
    path: Path
    sha256: str

    @property
    def name(self) -> str:
        """Name of the file."""
        return self.path.name

    def structure(self, limits: Limits) -> Structure:
        """The structure, read again.

        Parameters
        ----------
        limits : Limits
            How large the file may be.

        Returns
        -------
        Structure

        Raises
        ------
        StructureError
            If the file is gone or has changed.
        """
        try:
            now = sha256(self.path)
        except OSError as error:
            raise StructureError(
                f"{self.file}: the file cannot be read again ({error.strerror or error}); what was"
                " folded in it can be neither drawn nor written"
            ) from None
        if now != self.sha256:
            raise StructureError(
                f"{self.file}: the file has changed since it was folded; fold it again"
            )
        return read_structure(self.path, limits)


@dataclass(frozen=True, slots=True)
class Snapshot:
    """Atoms that were in memory: a frame of a Universe without its water, or an ideal hairpin.

    Attributes
    ----------
    name : str
        "universe", or the letters of the hairpin's sequence.
    about : dict
        What is recorded of it: ``universe`` (name of its file or None) and ``frame``, or
        ``sequence``.
    """

    name: str
    about: dict[str, Any]
    _packed: bytes = field(repr=False)

    @property
    def file(self) -> str:
        """What tables call it."""
        return self.name

    def structure(self, limits: Limits) -> Structure:
        """The structure as it was.

        Parameters
        ----------
        limits : Limits
            Not needed; as for files.

        Returns
        -------
        Structure
        """
        structure: Structure = pickle.loads(zlib.decompress(self._packed))
        return structure


Source = FileSource | Snapshot


def source_of(structure: Structure) -> Source:
    """What a structure is, when it has just been read.

    Parameters
    ----------
    structure : Structure
        Of a file, or of a Universe in its current frame.

    Returns
    -------
    FileSource or Snapshot

    Raises
    ------
    StructureError
        If the file cannot be read any more.
    """
    if structure.source is not None:
        try:
            digest = sha256(Path(structure.source))
        except OSError as error:
            raise StructureError(f"{structure.where}: {error.strerror or error}") from None
        return FileSource(structure.source, Path(os.path.abspath(structure.source)), digest)
    universe = structure.universe
    file = getattr(universe, "filename", None)
    about = {
        "universe": Path(file).name if isinstance(file, str | os.PathLike) else None,
        "frame": int(universe.trajectory.frame),
    }
    kept = np.flatnonzero(~waters(structure))
    left = len(universe.atoms) - len(kept)
    remarks = (
        *structure.remarks,
        *([f"{left} atoms of water are not kept, nor written"] if left else []),
    )
    return _snapshot(
        replace(structure, remarks=remarks), structure.positions(0), kept, structure.name, about
    )


def hairpin_source(
    structure: Structure, positions_A: Array, letters: str, sequence: str
) -> Snapshot:
    """What a hairpin that was made from its sequence is.

    Parameters
    ----------
    structure : Structure
        Stem and loop.
    positions_A : (n_atoms, 3) array
        Of its atoms, Å; NaN for the loop.
    letters : str
        Its bases, 5' to 3', which name its folder.
    sequence : str
        As it is recorded, such as "GGCAC(UUCG)GUGCC".

    Returns
    -------
    Snapshot
    """
    every = np.arange(len(positions_A))
    return _snapshot(structure, positions_A, every, letters, {"sequence": sequence})


def _snapshot(
    structure: Structure,
    positions_A: Array,
    kept: np.ndarray[Any, np.dtype[np.int64]],
    name: str,
    about: dict[str, Any],
) -> Snapshot:
    with quiet():
        import MDAnalysis

        # of its own: no file is held open, and it can be sent to another process
        universe = MDAnalysis.Merge(structure.universe.atoms[kept])
        universe.atoms.positions = np.nan_to_num(positions_A[kept])
    place = np.full(len(positions_A) + 1, -1)
    place[kept] = np.arange(len(kept))
    table = structure.nucleotides
    own = replace(
        structure,
        universe=universe,
        # −1, no atom, takes the last place
        nucleotides=replace(table, atom_index=place[table.atom_index]),
        _frames=TableFrames(
            positions_A[kept][np.newaxis], bool(np.isfinite(positions_A[kept]).all())
        ),
    )
    return Snapshot(name, about, zlib.compress(pickle.dumps(own), 1))
