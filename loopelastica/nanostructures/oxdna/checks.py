"""Whether a simulation can start from a system: its bonds, its distances, its axes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record
from loopelastica._vectors import dot
from loopelastica.nanostructures.oxdna.energies import bonds, close_sites, separation
from loopelastica.nanostructures.oxdna.model import BOND_LONGEST, BOND_SHORTEST
from loopelastica.nanostructures.system import System

Index = NDArray[np.int64]

NEAREST: Final = 0.4
"""Centres of nucleotides that are not bonded are no nearer than this, oxDNA's units; in the ideal
duplex they are 1.05 apart and more."""
_AXES: Final = 1e-6


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class StartCheck(Record):
    """What keeps a simulation from starting; all empty where nothing does.

    Attributes
    ----------
    system : System
        What was looked at.
    broken : (k, 2) array of int
        A nucleotide and its 3' neighbour whose bond is out of the window of the model.
    length : (k,) array
        Of these bonds; oxDNA's units.
    close : (m, 2) array of int
        Nucleotides that are no neighbours with centres nearer than :data:`NEAREST`.
    distance : (m,) array
        Of these centres.
    skewed : (j,) array of int
        Nucleotides whose axes are not perpendicular unit vectors.
    """

    system: System
    broken: Index
    length: Array
    close: Index
    distance: Array
    skewed: Index

    def __repr__(self) -> str:
        return f"<StartCheck: {'; '.join(self.notes()) or 'sound'}>"

    @property
    def sound(self) -> bool:
        """Whether nothing is wrong."""
        return not (len(self.broken) or len(self.close) or len(self.skewed))

    def sentences(self) -> list[str]:
        """One for each fault, which names the nucleotides."""
        label = self.system.label
        return [
            *(
                f"{label[i]} and {label[j]}: their bond is {length:.3f} long, and the model has"
                f" {BOND_SHORTEST:.4f} to {BOND_LONGEST:.4f}"
                for (i, j), length in zip(self.broken.tolist(), self.length.tolist(), strict=True)
            ),
            *(
                f"{label[i]} and {label[j]}: their centres are {distance:.3f} apart, which is less"
                f" than {NEAREST:g}"
                for (i, j), distance in zip(
                    self.close.tolist(), self.distance.tolist(), strict=True
                )
            ),
            *(
                f"{label[i]}: its axes are not perpendicular unit vectors"
                for i in self.skewed.tolist()
            ),
        ]

    def notes(self) -> Iterator[str]:
        """A sentence for each kind of fault: how many there are, and which is the first."""
        window = "outside of oxDNA's window"
        rest = "; it does not start from that before it is relaxed"
        yield from self._note(self.broken, "bond is", "bonds are", window, rest)
        pairs = ("pair of nucleotides is", "pairs of nucleotides are")
        yield from self._note(self.close, *pairs, f"nearer to each other than {NEAREST:g}")
        if len(self.skewed):
            nucleotides = "nucleotides" if len(self.skewed) > 1 else "nucleotide"
            yield (
                f"axes of {len(self.skewed)} {nucleotides} are not perpendicular unit vectors,"
                f" first of {self.system.label[self.skewed[0]]}"
            )

    def _note(self, faults: Index, one: str, many: str, said: str, rest: str = "") -> Iterator[str]:
        if not len(faults):
            return
        i, j = faults[0]
        label, strand = self.system.label, self.system.strand_name[self.system.strand[j]]
        place = f"from {label[i]} to {label[j]} of {strand}{rest}"
        if len(faults) == 1:
            yield f"1 {one} {said}, {place}"
        else:
            yield f"{len(faults)} {many} {said}, first {place}"


def check_start(system: System) -> StartCheck:
    """Look for what keeps a simulation from starting.

    Parameters
    ----------
    system : System
        The nucleotides; those without a place are left out.

    Returns
    -------
    StartCheck
    """
    found = bonds(system)
    out = (found.length <= BOND_SHORTEST) | (found.length >= BOND_LONGEST)
    i, j = close_sites(system, system.centre, NEAREST)
    apart = np.linalg.norm(separation(system, system.centre[i], system.centre[j]), axis=-1)
    products = np.stack(
        [
            dot(system.a1, system.a1) - 1,
            dot(system.a3, system.a3) - 1,
            dot(system.a1, system.a3),
        ]
    )
    # written so that what is no number counts as skewed
    straight = (np.abs(products) < _AXES).all(axis=0)
    return StartCheck(
        system,
        np.stack([found.first, found.second], axis=1)[out],
        found.length[out],
        np.stack([i, j], axis=1),
        apart,
        np.flatnonzero(system.placed & ~straight),
    )


def closest_centres(system: System, most: float = 1.5) -> float | None:
    """Least distance of two centres that are no neighbours in a strand.

    Parameters
    ----------
    system : System
        The nucleotides; those without a place are left out.
    most : float, optional
        Beyond this nothing is looked for; oxDNA's units.

    Returns
    -------
    float or None
        oxDNA's units; None where all are further apart.
    """
    i, j = close_sites(system, system.centre, most)
    if not len(i):
        return None
    apart = separation(system, system.centre[i], system.centre[j])
    return float(np.linalg.norm(apart, axis=-1).min())
