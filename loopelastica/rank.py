"""Candidates: the equilibria of one loop's rod, put back into the molecule and ranked.

The order is least deformation energy first. The energy is not a confidence: it says which of the
rod's shapes costs least, not how near that shape is to the loop in nature.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from loopelastica.molecule.stem_ends import StemEnds
from loopelastica.molecule.trace import loop_arc_positions, rmsd_A, to_file_coordinates
from loopelastica.rod.clamping import Array, read_only
from loopelastica.rod.equilibrium import Equilibrium


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """One possible shape of a loop.

    Attributes
    ----------
    rank : int
        1 for the least energy.
    rod : Equilibrium
        The dimensionless rod.
    length_A : float
        Its length in Å.
    energy_per_A : float
        Deformation energy over the bending rigidity, E/K0, in 1/Å.
    energy_kT : float
        The same in kT, for the persistence length that was asked for (K0 = kT·lp).
    stable : bool or None
        Whether it is a local minimum of the energy; None until it is computed.
    residual : float
        Largest error of the rod's end pose, on a mesh the solver did not use.
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
    trace: Array
    rmsd_A: float | None
    rmsd_models_A: Array


def rank(
    rods: Sequence[Equilibrium],
    ends: StemEnds,
    length_A: float,
    n_nucleotides: int,
    persistence_length_A: float,
    native_A: Array | None,
) -> tuple[Candidate, ...]:
    """Candidates of one model, least energy first; `rmsd_models_A` holds that model only."""
    candidates = []
    for order, rod in enumerate(sorted(rods, key=lambda r: r.energy), start=1):
        line = rod.centerline(loop_arc_positions(n_nucleotides))
        trace = to_file_coordinates(line, ends.start_origin_A, ends.start_frame, length_A)
        rmsd = None if native_A is None else rmsd_A(trace, native_A)
        energy_per_A = rod.energy / length_A
        candidates.append(
            Candidate(
                order,
                rod,
                length_A,
                energy_per_A,
                energy_per_A * persistence_length_A,
                rod.stable,
                rod.residual,
                read_only(trace),
                rmsd,
                read_only([] if rmsd is None else [rmsd]),
            )
        )
    return tuple(candidates)
