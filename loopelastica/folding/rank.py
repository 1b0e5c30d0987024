"""Candidates: the equilibria of one loop's rod, put back into the molecule and ranked.

The order is least deformation energy first; shapes that run into the stem or themselves come after
all others, for no backbone can take them. The energy is not a confidence: it says which of the
rod's shapes costs least, not how near that shape is to the loop in nature.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from loopelastica._arrays import Array, Record, read_only
from loopelastica.molecule.contacts import Contacts, contacts
from loopelastica.molecule.ends import StemEnds
from loopelastica.molecule.trace import loop_arc_positions, rmsd_A
from loopelastica.rod.equilibrium import Equilibrium

# points per nucleotide at which contacts are looked for: 0.6 Å apart
POINTS_PER_NUCLEOTIDE = 10


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Candidate(Record):
    """One possible shape of a loop.

    Attributes
    ----------
    rank : int
        1 for the least energy among those that touch nothing; those that touch follow, by their
        energy.
    rod : Equilibrium
        The dimensionless rod.
    length_A : float
        Its length in Å.
    energy_per_A : float
        Deformation energy over the bending rigidity, E/K0, in 1/Å.
    energy_kT : float
        The same in kT, for the persistence length in the options (K0 = kT·lp).
    stable : bool or None
        Whether it is a local minimum of the energy; None until it is computed.
    residual : float
        Largest error of the rod's end pose, on a mesh the solver did not use.
    contacts : Contacts
        Nearest approaches to the stem and to itself; ``contacts.touching`` marks what no backbone
        can do.
    trace : (n_nt, 3) ndarray
        Line point of each loop nucleotide in the file's coordinates, Å.
    rmsd_A : float or None
        Trace against the centroids of P O5' C5' C4' C3' O3' of the loop nucleotides, first model,
        without superposition; None where the file has no loop.
    rmsd_models_A : (n_models,) ndarray
        The same for each model: its own clamp, its own prediction of this rank, its own loop;
        inf where the model has none. Empty where the file has no loop.
    """

    rank: int
    rod: Equilibrium
    length_A: float
    energy_per_A: float
    energy_kT: float
    stable: bool | None
    residual: float
    contacts: Contacts
    trace: Array
    rmsd_A: float | None
    rmsd_models_A: Array

    @property
    def summary(self) -> str:
        """Energy, RMSD and contacts in a few words."""
        rmsd = "" if self.rmsd_A is None else f", RMSD {self.rmsd_A:.2f} Å"
        touches = f", touches {self.contacts.touched}" if self.contacts.touching else ""
        return f"E/K0 {self.energy_per_A:.3g} 1/Å{rmsd}{touches}"

    def __repr__(self) -> str:
        return f"<Candidate {self.rank}: {self.summary}>"


def rank(
    rods: Sequence[Equilibrium],
    ends: StemEnds,
    persistence_length_A: float,
    stem: tuple[Array, Array],
    backbone_A: Array | None,
) -> tuple[Candidate, ...]:
    """Candidates of one model: those that touch nothing first, each kind by its energy.

    Parameters
    ----------
    rods : sequence of Equilibrium
        Shapes of the rod between `ends`.
    ends : StemEnds
        Where the rod begins and ends, Å.
    persistence_length_A : float
        Scale of ``energy_kT``, Å.
    stem : (m, 3), (m,) array
        Atoms of the stem and their phases (:func:`stem_atoms`).
    backbone_A : (n_nt + 2, 3) array or None
        Centroids of the file's own loop, closing nucleotide to closing nucleotide, Å;
        `rmsd_models_A` then holds this model only.

    Returns
    -------
    tuple of Candidate
        Each with its rank, from 1.
    """
    near = [contacts(*_line(rod, ends), *stem) for rod in rods]
    order = sorted(range(len(rods)), key=lambda i: (near[i].touching, rods[i].energy))
    candidates = []
    for place, i in enumerate(order, start=1):
        rod = rods[i]
        trace = ends.trace(rod.centerline(loop_arc_positions(ends.n_free)))
        rmsd = None if backbone_A is None else rmsd_A(trace, backbone_A[1:-1])
        energy_per_A = rod.energy / ends.length_A
        candidates.append(
            Candidate(
                place,
                rod,
                ends.length_A,
                energy_per_A,
                energy_per_A * persistence_length_A,
                rod.stable,
                rod.residual,
                near[i],
                read_only(trace),
                rmsd,
                read_only([] if rmsd is None else [rmsd]),
            )
        )
    return tuple(candidates)


def _line(rod: Equilibrium, ends: StemEnds) -> tuple[Array, Array]:
    """Points of the loop's line, nucleotides that continue the stem included, and their phases."""
    first, last, n = len(ends.continued_5_A), len(ends.continued_3_A), ends.n_free
    s = np.linspace(0.0, 1.0, POINTS_PER_NUCLEOTIDE * n + 1)
    before, after = np.arange(1, first + 1), first + n + np.arange(1, last + 1)
    phases = np.concatenate([before, first + 0.5 + n * s, after])
    return ends.trace(rod.centerline(s)), phases
