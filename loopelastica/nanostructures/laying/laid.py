"""What became of the single strands of a nanostructure: records."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Record
from loopelastica.nanostructures.oxdna.model import UNIT_NM
from loopelastica.nanostructures.singles import SingleKind
from loopelastica.nanostructures.system import System

Shape = Literal["rod", "rod in its surroundings", "straight", "circle", "as given", ""]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Conflict(Record):
    """Two nucleotides that are too near each other, one of a laid strand at least.

    Attributes
    ----------
    first, second : int
        Nucleotides; the first is in the strand that names the conflict.
    distance : float
        Of their centres, oxDNA's units.
    energy : float
        Of their excluded volume, oxDNA's units.
    sentence : str
        The same in words, with both strands.
    """

    first: int
    second: int
    distance: float
    energy: float
    sentence: str

    def __repr__(self) -> str:
        return f"<Conflict: {self.sentence}>"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class LaidStrand(Record):
    """A single strand and how it lies.

    Attributes
    ----------
    kind : SingleKind
        "hairpin", "linker", "tail 5'", "tail 3'", "free strand" or "circle".
    label : str
        What sentences call it: strand, and the nucleotides that it lies between.
    nucleotides : (n,) array of int
        Indices in the system, from 5' to 3'.
    before, after : int
        Paired nucleotides that it lies between; −1 for none.
    status : {"laid", "refused"}
        Refused strands have no place.
    reason : str
        Why it was refused, in one sentence; "" where it was laid.
    shape : str
        "rod" (least energy, nothing in its way), "rod in its surroundings" (moved by excluded
        volume), "straight", "circle" or "as given".
    distance : float or None
        Between the two ends, oxDNA's units; None where there are not two.
    length : float or None
        Sum of its bonds, oxDNA's units; None where refused.
    spacing : float or None
        Mean length of its bonds.
    energy_per_nm : float or None
        Bending energy over bending rigidity, ∫ ½ κ² ds, 1/nm; None where refused or as given.
    energy : float or None
        The same without a unit: times the length.
    remark : str
        What to keep in mind, such as that the strand is a random coil; "" for nothing.
    nearest : float or None
        Least distance of its centres from that of a nucleotide that is no neighbour.
    conflicts : tuple of Conflict
        What it is too near to.
    """

    kind: SingleKind
    label: str
    nucleotides: NDArray[np.int64]
    before: int
    after: int
    status: Literal["laid", "refused"]
    reason: str
    shape: Shape
    distance: float | None
    length: float | None
    spacing: float | None
    energy_per_nm: float | None
    energy: float | None
    remark: str
    nearest: float | None
    conflicts: tuple[Conflict, ...]

    def __len__(self) -> int:
        """Return the number of nucleotides."""
        return len(self.nucleotides)

    def __repr__(self) -> str:
        return f"<LaidStrand: {self.kind} of {len(self)}, {self.reason or self.shape}>"

    @property
    def length_nm(self) -> float | None:
        """Sum of its bonds, nm."""
        return None if self.length is None else self.length * UNIT_NM


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Sample(Record):
    """One worm-like sample of all single strands.

    Attributes
    ----------
    system : System
        The same helices with other strands.
    conflicts : tuple of Conflict
        What could not be brought apart.
    """

    system: System
    conflicts: tuple[Conflict, ...]

    def __repr__(self) -> str:
        return f"<Sample of {self.system!r}, {len(self.conflicts)} conflicts>"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Laid(Record):
    """A nanostructure with its single strands laid.

    Attributes
    ----------
    system : System
        All nucleotides; those of refused strands have no place. Paired ones are untouched.
    strands : tuple of LaidStrand
        In the order of their first nucleotides.
    samples : tuple of Sample
        As many as were asked for.
    persistence_length_nm : float
        Of single strands, of samples and remarks.
    """

    system: System
    strands: tuple[LaidStrand, ...]
    samples: tuple[Sample, ...]
    persistence_length_nm: float

    @property
    def refused(self) -> tuple[LaidStrand, ...]:
        """Strands that could not be laid."""
        return tuple(one for one in self.strands if one.status == "refused")

    @property
    def conflicts(self) -> tuple[Conflict, ...]:
        """All conflicts; those of two laid strands are named by both."""
        return tuple(conflict for one in self.strands for conflict in one.conflicts)

    def __repr__(self) -> str:
        return (
            f"<Laid {self.system.name}: {len(self.strands)} single strands,"
            f" {len(self.refused)} refused, {len(self.conflicts)} conflicts>"
        )
