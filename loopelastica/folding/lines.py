"""What the line of a candidate is: a rod, or a chain that remembers a shape.

Both answer the same questions in the coordinates of the file. A rod runs from half a nucleotide
beyond one end of the stem to half a nucleotide before the other. A chain runs from closing
nucleotide to closing nucleotide, rigid steps with hinges between them; what is drawn and carried
along is the smooth curve through its nodes, which leaves and meets the stem as its strands do.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from loopelastica._arrays import Array, Record
from loopelastica.molecule.ends import ClosingPoses, StemEnds
from loopelastica.molecule.shapes import LoopShape
from loopelastica.molecule.strands import ideal_strand, line_length_A
from loopelastica.molecule.trace import loop_arc_positions
from loopelastica.rod.chain import deform_batch
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.surrounded import SurroundedRod

Rod: TypeAlias = Equilibrium | SurroundedRod

POINTS_PER_NUCLEOTIDE: Final = 10
"""Points at which contacts are looked for: 0.6 Å apart."""
# points per nucleotide by which the length of a smooth curve is measured
_FINE: Final = 64


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class RodLine(Record):
    """An elastic rod between the ends of a stem.

    Attributes
    ----------
    rod : Equilibrium or SurroundedRod
        Dimensionless.
    ends : StemEnds
        Where it is clamped, Å.
    """

    rod: Rod
    ends: StemEnds

    @property
    def length_A(self) -> float:
        """Length of the elastic line."""
        return self.ends.length_A

    @property
    def curve_A(self) -> float:
        """Length of what is drawn: the rod itself."""
        return self.ends.length_A

    @property
    def energy(self) -> float:
        """Deformation energy E·L/K0, dimensionless."""
        return self.rod.energy

    @property
    def residual(self) -> float:
        """Error of the solution, by an evaluation that the solver did not use."""
        return self.rod.residual

    @property
    def stable(self) -> bool | None:
        """Whether it is a local minimum of the energy; None until that is computed."""
        return self.rod.stable

    @property
    def twist_turns(self) -> float:
        """Turns of the rod's frame about its tangent."""
        return self.rod.twist

    @property
    def start_origin_A(self) -> Array:
        """Where it begins, (3,)."""
        return self.ends.start_origin_A

    @property
    def start_frame(self) -> Array:
        """The frame there, (3, 3), columns d1 d2 d3."""
        return self.ends.start_frame

    @property
    def trace(self) -> Array:
        """Its point (n, 3) for each loop nucleotide, Å."""
        return self.ends.trace(self.rod.centerline(loop_arc_positions(self.ends.n_free)))

    def points(self, n: int | ArrayLike) -> Array:
        """Points (n, 3), Å: a number of them, evenly spaced, or at fractions of its length."""
        return self.ends.to_file(self.rod.centerline(n))

    def tangents(self, n: int | ArrayLike) -> Array:
        """Unit tangents (n, 3); ``n`` as in `points`."""
        return np.asarray(self.rod.frames(n)[:, :, 2] @ self.ends.start_frame.T)

    def curvature_per_A(self, n: int | ArrayLike) -> Array:
        """Curvature (n,), 1/Å; ``n`` as in `points`."""
        return np.asarray(self.rod.curvature(n) / self.ends.length_A)

    def phases(self, n: int | ArrayLike) -> Array:
        """Phases (n,), in nucleotides from the 5' closing one; ``n`` as in `points`."""
        s = np.linspace(0.0, 1.0, n) if isinstance(n, int) else np.asarray(n, dtype=np.float64)
        return np.asarray(len(self.ends.continued_5_A) + 0.5 + self.ends.n_free * s)

    def sampled(self) -> tuple[Array, Array]:
        """Points (m, 3) of the loop's line, Å, and their phases (m,), to look for contacts.

        Nucleotides that continue the stem are among them.
        """
        ends, n = self.ends, self.ends.n_free
        first, last = len(ends.continued_5_A), len(ends.continued_3_A)
        s = np.linspace(0.0, 1.0, POINTS_PER_NUCLEOTIDE * n + 1)
        before, after = np.arange(1, first + 1), first + n + np.arange(1, last + 1)
        phases = np.concatenate([before, self.phases(s), after])
        return ends.trace(self.rod.centerline(s)), phases

    def to_dict(self) -> dict[str, Any]:
        """All that determines it, under the name of its kind; JSON-ready."""
        if isinstance(self.rod, Equilibrium):
            return {"rod": self.rod.to_dict()}
        rod = self.rod
        return {
            "surrounded_rod": {
                "energy": rod.energy,
                "contact_energy": rod.contact_energy,
                "self_energy": rod.self_energy,
                "nearest_A": rod.nearest,
                "node_s": rod.node_s.tolist(),
                "node_tangent": rod.node_tangent.tolist(),
            }
        }


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ChainLine(Record):
    """The shape of a loop, deformed onto a stem as an elastic chain.

    Attributes
    ----------
    shape : LoopShape
        What it is at rest.
    poses : ClosingPoses
        Points and frames of the closing nucleotides that it runs between, Å.
    is_dna : bool
        Kind of the stem that it is on.
    nodes_A : (n + 2, 3) array
        Its nodes in the frame of the first, Å.
    rotations : (n + 1, 3, 3) array
        Turn of each step against the one at rest, in that frame.
    energy : float
        Deformation energy E·L/K0, dimensionless.
    residual : float
        Error of the solution, by an evaluation that the solver did not use.
    stable : bool
        Whether it is a local minimum of the energy.
    """

    shape: LoopShape
    poses: ClosingPoses
    is_dna: bool
    nodes_A: Array
    rotations: Array
    energy: float
    residual: float
    stable: bool | None

    def __len__(self) -> int:
        """Return the number of loop nucleotides."""
        return len(self.nodes_A) - 2

    @property
    def length_A(self) -> float:
        """Length of the elastic line: of all its steps together."""
        return float(np.linalg.norm(self.shape.steps_A, axis=1).sum())

    @property
    def curve_A(self) -> float:
        """Length of the smooth curve through its nodes."""
        return float(self._measured()[1][-1])

    @property
    def twist_turns(self) -> float:
        """Turns of its hinges about the line, against the shape at rest."""
        from scipy.spatial.transform import Rotation

        steps = self.shape.steps_A / np.linalg.norm(self.shape.steps_A, axis=1, keepdims=True)
        axes = np.concatenate([steps[:1], steps[:-1] + steps[1:], steps[-1:]])
        axes /= np.maximum(np.linalg.norm(axes, axis=1, keepdims=True), 1e-12)
        end = self.poses.rotation @ self.shape.end_frame.T
        turns = np.concatenate([np.eye(3)[None], self.rotations, end[None]])
        hinges = np.swapaxes(turns[:-1], 1, 2) @ turns[1:]
        return float((Rotation.from_matrix(hinges).as_rotvec() * axes).sum() / math.tau)

    @property
    def start_origin_A(self) -> Array:
        """Where it begins, (3,)."""
        return self.poses.start_origin_A

    @property
    def start_frame(self) -> Array:
        """The frame there, (3, 3), columns d1 d2 d3."""
        return self.poses.start_frame

    @property
    def trace(self) -> Array:
        """Its node (n, 3) for each loop nucleotide, Å."""
        return self.poses.to_file(self.nodes_A[1:-1])

    def points(self, n: int | ArrayLike) -> Array:
        """Points (n, 3) of the smooth curve, Å; ``n`` as for a rod."""
        return self.poses.to_file(self.smooth(self.phases(n)))

    def tangents(self, n: int | ArrayLike) -> Array:
        """Unit tangents (n, 3) of the smooth curve; ``n`` as in `points`."""
        along = self.smooth(self.phases(n), 1)
        along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
        return np.asarray(along @ self.poses.start_frame.T)

    def curvature_per_A(self, n: int | ArrayLike) -> Array:
        """Curvature (n,) of the smooth curve, 1/Å; ``n`` as in `points`."""
        phases = self.phases(n)
        first, second = self.smooth(phases, 1), self.smooth(phases, 2)
        speed = np.maximum(np.linalg.norm(first, axis=1), 1e-6)
        return np.asarray(np.linalg.norm(np.cross(first, second), axis=1) / speed**3)

    def phases(self, n: int | ArrayLike) -> Array:
        """Phases (n,), in nucleotides from the 5' closing one; ``n`` as in `points`."""
        s = np.linspace(0.0, 1.0, n) if isinstance(n, int) else np.asarray(n, dtype=np.float64)
        phases, along_A = self._measured()
        return np.asarray(np.interp(s * along_A[-1], along_A, phases))

    def sampled(self) -> tuple[Array, Array]:
        """Points (m, 3) of the loop's line, Å, and their phases (m,), to look for contacts."""
        n = len(self)
        phases = np.linspace(0.5, n + 0.5, POINTS_PER_NUCLEOTIDE * n + 1)
        return self.poses.to_file(self.smooth(phases)), phases

    def smooth(self, phases: ArrayLike, derivative: int = 0) -> Array:
        """The smooth curve by phase, in the frame of the start, Å.

        Parameters
        ----------
        phases : (m,) array_like
            From 0, the 5' closing nucleotide, to n + 1, the 3' one.
        derivative : int
            Of the curve by phase, 0 to 3.

        Returns
        -------
        (m, 3) array
        """
        from scipy.interpolate import CubicSpline

        # beyond its ends the ideal strands go on, at their own pace
        pace_A = line_length_A(ideal_strand(self.is_dna))
        ends = [(1, pace_A * np.array([0.0, 0.0, 1.0])), (1, pace_A * self.poses.rotation[:, 2])]
        spline = CubicSpline(np.arange(len(self.nodes_A)), self.nodes_A, bc_type=tuple(ends))
        return np.asarray(spline(np.asarray(phases, dtype=np.float64), derivative))

    def _measured(self) -> tuple[Array, Array]:
        """Phases along the smooth curve, and its length up to each, Å."""
        last = len(self.nodes_A) - 1
        phases = np.linspace(0.0, last, _FINE * last + 1)
        pieces = np.linalg.norm(np.diff(self.smooth(phases), axis=0), axis=1)
        return phases, np.concatenate([[0.0], np.cumsum(pieces)])

    def to_dict(self) -> dict[str, Any]:
        """All that determines it, under the name of its kind; JSON-ready."""
        return {
            "chain": {
                "source": self.shape.source,
                "sequence": self.shape.sequence,
                "steps_A": self.shape.steps_A.tolist(),
                "end_frame": self.shape.end_frame.tolist(),
                "start_origin_A": self.poses.start_origin_A.tolist(),
                "start_frame": self.poses.start_frame.tolist(),
                "position_A": self.poses.position_A.tolist(),
                "rotation": self.poses.rotation.tolist(),
                "nodes_A": self.nodes_A.tolist(),
                "rotations": self.rotations.tolist(),
                "energy": self.energy,
            }
        }


CandidateLine: TypeAlias = RodLine | ChainLine


def chain_lines(
    shapes: Sequence[LoopShape], poses: ClosingPoses, is_dna: bool
) -> list[ChainLine | None]:
    """Shapes of one length, deformed onto a stem.

    Parameters
    ----------
    shapes : sequence of LoopShape
        Of as many nucleotides as the loop has.
    poses : ClosingPoses
        Where the ideal strands have the closing nucleotides.
    is_dna : bool
        Kind of the stem.

    Returns
    -------
    list of ChainLine or None
        One per shape; None where it cannot be deformed so far.
    """
    if not shapes:
        return []
    batch = deform_batch(
        np.array([shape.steps_A for shape in shapes]),
        np.array([shape.end_frame for shape in shapes]),
        poses.position_A,
        poses.rotation,
    )
    lines: list[ChainLine | None] = [None] * len(shapes)
    for k in np.flatnonzero(batch.converged).tolist():
        lines[k] = ChainLine(
            shapes[k],
            poses,
            is_dna,
            batch.nodes[k],
            batch.rotations[k],
            float(batch.energy[k]),
            float(batch.residual[k]),
            bool(batch.stable[k]),
        )
    return lines
