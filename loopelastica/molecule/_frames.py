"""A Universe of MDAnalysis, and the positions of its models."""

from __future__ import annotations

import io
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from loopelastica._arrays import Array
from loopelastica.errors import StructureError
from loopelastica.molecule._source import first_line, name_of


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
    """Models whose positions (n_models, n_atoms, 3) are all in memory."""

    table: Array
    complete: bool

    @property
    def n_models(self) -> int:
        """Number of models."""
        return len(self.table)

    def model(self, k: int) -> Array:
        """Positions of model k."""
        return np.array(self.table[k])


class quiet(warnings.catch_warnings):  # noqa: N801 - used like the function it extends
    """Keep the remarks of MDAnalysis on what it guesses away from the user."""

    def __enter__(self) -> None:
        """Ignore warnings until the block ends."""
        super().__enter__()
        warnings.simplefilter("ignore")


def universe_of(path: Path, *sources: Any, **kwargs: Any) -> Any:
    """Universe of a file, its first frame read.

    Parameters
    ----------
    path : Path
        The file, for the sentence.
    sources, kwargs
        What MDAnalysis takes.

    Raises
    ------
    StructureError
        If MDAnalysis raises anything.
    """
    with quiet():
        import MDAnalysis

        try:
            universe = MDAnalysis.Universe(*sources, **kwargs)
            _ = universe.atoms.names, universe.atoms.positions
        # MDAnalysis and its readers raise whatever a damaged file provokes.
        except Exception as error:
            raise StructureError(
                f"{name_of(path)}: MDAnalysis cannot read it ({first_line(error)})"
            ) from error
    return universe


def universe_with(path: Path, topology: bytes, kind: str, models: Array) -> Any:
    """Universe of the atoms that a text lists, with models that are in memory.

    Parameters
    ----------
    path : Path
        The file they are from.
    topology : bytes
        Records of the first model.
    kind : str
        "PDB" or "CIF".
    models : (n_models, n_atoms, 3) array
        Positions, Å; they become the frames.
    """
    from MDAnalysis.coordinates.memory import MemoryReader
    from MDAnalysis.lib.util import NamedStream

    text = io.TextIOWrapper(io.BytesIO(topology), encoding="utf-8")
    stream = NamedStream(text, f"{path.name}.{kind.lower()}")
    # a number beyond single precision becomes infinite, and is refused where it is used
    with np.errstate(over="ignore"):
        single = models.astype(np.float32)
    return universe_of(
        path, stream, single, topology_format=kind, format=MemoryReader, order="fac", to_guess=()
    )
