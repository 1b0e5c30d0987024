"""From a gap to the lines that may fill it: the road of :mod:`.fold` for any strand.

    gap ─ends→ frames, Å ─obstacles→ atoms in the way ─rods→ minima among them ─→ lines, best first

A line is a rod of least energy under a soft repulsion of everything that is there (proteins and
ligands too) and of itself. Elastic energy and that of contact are kept apart; their sum orders.
Lines that have the shape of other strands are in :mod:`.shape_line`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record, read_only
from loopelastica.errors import StructureError
from loopelastica.folding.surroundings import SURROUNDED, rods_among
from loopelastica.molecule.obstacles import obstacles
from loopelastica.molecule.polymer import Gap, HeavyAtoms
from loopelastica.molecule.strand_ends import StrandEnds
from loopelastica.molecule.trace import loop_arc_positions
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.solve import solve
from loopelastica.rod.surrounded import SurroundedRod

NEAR_A: Final = 3.0
"""Real backbones come no nearer to an atom than this: what does is said."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class StrandLine(Record):
    """A line between the two ends of a strand.

    Attributes
    ----------
    rank : int
        From 1, by the sum of the energies.
    shape : str
        What it is, such as "rod in its surroundings".
    rod : SurroundedRod
        Dimensionless.
    ends : StrandEnds
        Where it begins and ends, Å.
    trace : (n, 3) array
        Its point for each nucleotide in the coordinates of the file, Å.
    nearest_atom : str
        The atom that it comes nearest to, such as "A.G12 C5'"; "" where there is none.
    """

    rank: int
    shape: str
    rod: SurroundedRod
    ends: StrandEnds
    trace: Array
    nearest_atom: str

    @property
    def energy(self) -> float:
        """Elastic energy E·L/K0, dimensionless."""
        return self.rod.energy

    @property
    def energy_per_A(self) -> float:
        """Elastic energy over the bending rigidity, E/K0, in 1/Å."""
        return self.energy / self.ends.length_A

    @property
    def contact_energy_per_A(self) -> float:
        """What the repulsion costs, in the same unit."""
        return (self.rod.contact_energy + self.rod.self_energy) / self.ends.length_A

    @property
    def nearest_A(self) -> float | None:
        """Distance of the nearest atom from the line; None where there is none."""
        return self.rod.nearest

    @property
    def stable(self) -> bool | None:
        """Whether it is a local minimum of the energy."""
        return self.rod.stable

    @property
    def residual(self) -> float:
        """Error of the solution, by an evaluation that the solver did not use."""
        return self.rod.residual

    def __repr__(self) -> str:
        return (
            f"<StrandLine {self.rank}: E/K0 {self.energy_per_A:.3g} 1/Å, contact"
            f" {self.contact_energy_per_A:.3g} 1/Å>"
        )


def strand_lines(
    gap: Gap, ends: StrandEnds, atoms: HeavyAtoms, most: int = 1
) -> tuple[StrandLine, ...]:
    """Lines of least energy in their surroundings, the least first.

    Parameters
    ----------
    gap : Gap
        What they stand for.
    ends : StrandEnds
        Where they begin and end.
    atoms : HeavyAtoms
        All of the model.
    most : int
        How many at most.

    Returns
    -------
    tuple of StrandLine
        At least one.

    Raises
    ------
    StructureError
        If no rod was found.
    """
    rows = obstacles(gap, ends, atoms)
    rods = rods_among(ends, atoms.positions_A[rows], _free_rod(ends))
    if not rods[0].converged:
        raise StructureError(
            f"{gap.name}: no line was found between its ends ({rods[0].message}); the strand is"
            " not filled"
        )
    return tuple(
        _line(rank, rod, ends, atoms, rows) for rank, rod in enumerate(rods[:most], start=1)
    )


def _free_rod(ends: StrandEnds) -> Array | None:
    """Points of the ideal rod of least energy; None where there is none."""
    clamping = Clamping.from_frames(
        ends.start_origin_A, ends.start_frame, ends.end_origin_A, ends.end_frame, ends.length_A,
        free_spin=True,
    )  # fmt: skip
    rod = solve(clamping)
    return ends.to_file(rod.centerline(16 * ends.n + 1)) if rod.converged else None


def _line(
    rank: int, rod: SurroundedRod, ends: StrandEnds, atoms: HeavyAtoms, rows: NDArray[np.int64]
) -> StrandLine:
    trace = ends.to_file(rod.centerline(loop_arc_positions(ends.n)))
    near = ""
    if rod.nearest_obstacle is not None:
        near = atoms.label(rows[rod.nearest_obstacle])
    return StrandLine(rank, SURROUNDED, rod, ends, read_only(trace), near)
