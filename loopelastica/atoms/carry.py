"""The ideal strand deformed onto the line (step ii of biopolymer chain elasticity).

Phases count nucleotides as in :mod:`loopelastica.molecule.trace`: loop nucleotide k has phase k,
the rod runs from ½ to n + ½ where no nucleotide continues the stem. A free-spin rod leaves the turn
of its frames about the line open. Here they get a uniform spin, so that they meet the stem's
directors at both ends; of the whole turns that remain free, those are taken that twist the strand
most nearly as its helix does. On a rod that is the helix of the stem itself, the carried atoms are
the fibre coordinates.

Beyond the rod's ends the line goes on as the strands of the stem, tapered where the clamp is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from loopelastica._arrays import Array
from loopelastica.molecule.ends import StemEnds
from loopelastica.molecule.strand_ends import StrandEnds
from loopelastica.molecule.strands import Strand, line_cylinder, line_frame, line_length_A
from loopelastica.rod.equilibrium import Equilibrium
from loopelastica.rod.surrounded import SurroundedRod

Rod: TypeAlias = Equilibrium | SurroundedRod


def helix_twist(strand: Strand) -> float:
    """Turn per nucleotide of the ideal strand's directors about its line, rad.

    Torsion of the helix times its length: ω h / √(r²ω² + h²) for a turn ω and a rise h.

    >>> from loopelastica.molecule.strands import A_RNA
    >>> f"{math.degrees(helix_twist(A_RNA)):.1f}"
    '15.7'
    """
    return math.radians(strand.turn_deg) * strand.rise_A / line_length_A(strand)


class Curve(Protocol):
    """What nucleotides are laid on: a line with frames."""

    def at(self, phases: ArrayLike) -> tuple[Array, Array]:
        """Points (m, 3), Å, and frames (m, 3, 3), columns d1 d2 d3, at the phases (m,).

        The strand's nucleotides have the phases 1 … n; d3 is the tangent, 5' to 3'.
        """


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """A rod with the stem's directors, in the frame of its start, Å.

    Attributes
    ----------
    rod : Equilibrium or SurroundedRod
    strand : Strand
    length_A : float
    extend_5, n, extend_3 : int
        Loop nucleotides that continue the 5' strand, are on the rod, and continue the 3' strand.
    taper : float
        Loss of radius per nucleotide of the continued 3' strand.
    end_origin_A, end_frame : (3,), (3, 3) array
        The clamp of the 3' end in the start frame.
    spin : float
        Turn of the directors against the rod's own frames over the whole length, rad.
    """

    rod: Rod
    strand: Strand
    length_A: float
    extend_5: int
    n: int
    extend_3: int
    taper: float
    end_origin_A: Array
    end_frame: Array
    spin: float

    @classmethod
    def between(cls, rod: Rod, ends: StemEnds | StrandEnds, strand: Strand) -> Line:
        """The line of a rod.

        Parameters
        ----------
        rod : Equilibrium or SurroundedRod
            Dimensionless.
        ends : StemEnds or StrandEnds
            Where it is clamped, Å.
        strand : Strand
            What is carried.

        Returns
        -------
        Line
        """
        clamp, n = ends.clamp, ends.n_free
        start = ends.start_frame
        end_frame = start.T @ ends.end_frame
        end_origin = start.T @ (ends.end_origin_A - ends.start_origin_A)
        # the rod's last frame and the clamp's differ by a turn about the common tangent
        turn = rod.frames(np.array([1.0]))[0].T @ end_frame
        mismatch = math.atan2(turn[1, 0] - turn[0, 1], turn[0, 0] + turn[1, 1])
        helical = n * helix_twist(strand) - math.tau * rod.twist
        whole = round((helical - mismatch) / math.tau)
        return cls(
            rod, strand, ends.length_A, clamp.stem_extend_5, n, clamp.stem_extend_3, clamp.taper,
            end_origin, end_frame, mismatch + whole * math.tau,
        )  # fmt: skip

    def at(self, phases: ArrayLike) -> tuple[Array, Array]:
        """Points (m, 3) and frames (m, 3, 3), columns d1 d2 d3, at the phases (m,)."""
        phase = np.atleast_1d(np.asarray(phases, dtype=np.float64))
        first = self.extend_5 + 0.5
        last = first + self.n
        s = np.clip((phase - first) / self.n, 0.0, 1.0)
        points = self.length_A * self.rod.centerline(s)
        frames = self.rod.frames(s) @ _about_d3(self.spin * s)
        for row in np.flatnonzero(phase < first):
            points[row], frames[row] = self._beyond(
                np.zeros(3), np.eye(3), 0.0, phase[row] - first, 0.0
            )
        for row in np.flatnonzero(phase > last):
            points[row], frames[row] = self._beyond(
                self.end_origin_A, self.end_frame, -self.extend_3 - 0.5, phase[row] - last,
                self.taper,
            )  # fmt: skip
        return points, frames

    def _beyond(
        self, origin: Array, frame: Array, start: float, phase: float, taper: float
    ) -> tuple[Array, Array]:
        """The pose reached from a given one by `phase` nucleotides along the stem's strand.

        The given one is at the strand's own phase ``start``, which matters to a tapered one.
        """
        point_0, frame_0 = line_frame(self.strand, start, taper)
        point, other = line_frame(self.strand, start + phase, taper)
        return origin + frame @ frame_0.T @ (point - point_0), frame @ frame_0.T @ other


@dataclass(frozen=True, slots=True, eq=False)
class IdealCurve:
    """The helix line of an ideal strand of which nucleotide 1 is laid somewhere.

    Attributes
    ----------
    strand : Strand
    rotation, shift : (3, 3), (3,) array
        From the coordinates of the strand's table to where it lies, Å.
    """

    strand: Strand
    rotation: Array
    shift: Array

    def at(self, phases: ArrayLike) -> tuple[Array, Array]:
        """Points (m, 3) and frames (m, 3, 3) at the phases (m,)."""
        phase = np.atleast_1d(np.asarray(phases, dtype=np.float64))
        points, frames = zip(*(line_frame(self.strand, x - 1.0) for x in phase), strict=True)
        return np.array(points) @ self.rotation.T + self.shift, self.rotation @ np.array(frames)


@dataclass(frozen=True, slots=True, eq=False)
class Bent:
    """A curve with its middle moved aside: by half a sine wave, or by a whole one.

    Attributes
    ----------
    curve : Curve
    n : int
        Its nucleotides.
    aside_A : (3,) array
        How far and where to.
    waves : int
        Half waves.
    """

    curve: Curve
    n: int
    aside_A: Array
    waves: int = 1

    def at(self, phases: ArrayLike) -> tuple[Array, Array]:
        """Points (m, 3) and frames (m, 3, 3) at the phases (m,)."""
        phase = np.atleast_1d(np.asarray(phases, dtype=np.float64))
        points, frames = self.curve.at(phase)
        u = self.waves * math.pi * np.clip((phase - 0.5) / self.n, 0.0, 1.0)
        bent = points + np.sin(u)[:, None] * self.aside_A
        # tangents by differences: the curve's own speed is not given
        ahead, behind = (self._at(phase + step) for step in (0.05, -0.05))
        tangent = ahead - behind
        tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-9)
        d1 = frames[:, :, 0] - (frames[:, :, 0] * tangent).sum(axis=1)[:, None] * tangent
        d1 /= np.maximum(np.linalg.norm(d1, axis=1, keepdims=True), 1e-9)
        return bent, np.stack([d1, np.cross(tangent, d1), tangent], axis=2)

    def _at(self, phase: Array) -> Array:
        u = self.waves * math.pi * np.clip((phase - 0.5) / self.n, 0.0, 1.0)
        return np.asarray(self.curve.at(phase)[0] + np.sin(u)[:, None] * self.aside_A)


def own_phase(strand: Strand, position: Array) -> tuple[float, Array]:
    """Phase at which an atom lies in the normal plane of the ideal line, and its place there.

    Parameters
    ----------
    strand : Strand
    position : (3,) array
        In the coordinates of the strand's table, Å.

    Returns
    -------
    phase : float
        The one nearest to that of its nucleotide, 0.
    local : (2,) array
        Components along d1 and d2, Å.
    """
    phase = 0.0
    step_A = math.hypot(line_cylinder(strand)[0] * math.radians(strand.turn_deg), strand.rise_A)
    # a fixed-point iteration: atoms of the backbone are much nearer to the line than its radius
    for _ in range(60):
        point, frame = line_frame(strand, phase)
        ahead = float((position - point) @ frame[:, 2])
        phase += ahead / step_A
        if abs(ahead) < 1e-12:
            break
    point, frame = line_frame(strand, phase)
    return phase, (position - point) @ frame[:, :2]


def _about_d3(angles: Array) -> Array:
    c, s = np.cos(angles), np.sin(angles)
    zero, one = np.zeros_like(c), np.ones_like(c)
    rows = [[c, -s, zero], [s, c, zero], [zero, zero, one]]
    return np.moveaxis(np.array(rows), -1, 0)
