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
from typing import Final, Protocol

import numpy as np
from numpy.typing import ArrayLike

from loopelastica._arrays import Array
from loopelastica._vectors import unit
from loopelastica.folding.lines import CandidateLine, ChainLine, Rod
from loopelastica.molecule.ends import StemEnds
from loopelastica.molecule.strand_ends import StrandEnds
from loopelastica.molecule.strands import Strand, line_cylinder, line_frame, line_length_A

# frames per nucleotide along a curve: neighbours differ by a few degrees
_FRAMES: Final = 32


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
        spin = _spin(turn, n * helix_twist(strand) - math.tau * rod.twist)
        return cls(
            rod, strand, ends.length_A, clamp.stem_extend_5, n, clamp.stem_extend_3, clamp.taper,
            end_origin, end_frame, spin,
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
            points[row], frames[row] = _beyond(
                self.strand, np.zeros(3), np.eye(3), 0.0, phase[row] - first
            )
        for row in np.flatnonzero(phase > last):
            points[row], frames[row] = _beyond(
                self.strand, self.end_origin_A, self.end_frame, -self.extend_3 - 0.5,
                phase[row] - last, self.taper,
            )  # fmt: skip
        return points, frames


@dataclass(frozen=True, slots=True, eq=False)
class ChainCurve:
    """The smooth curve of a chain with the stem's directors, in the frame of its start, Å.

    Attributes
    ----------
    line : ChainLine
    strand : Strand
    phases : (m,) array
        Where frames are kept, close to each other, from closing to closing nucleotide.
    frames : (m, 3, 3) array
        That turn with the tangent and nothing else.
    spin : float
        Turn of the directors against these over the whole length, rad.
    """

    line: ChainLine
    strand: Strand
    phases: Array
    frames: Array
    spin: float

    @classmethod
    def of(cls, line: ChainLine, strand: Strand) -> ChainCurve:
        """The curve of a chain for a strand that is carried."""
        steps = len(line) + 1
        phases = np.linspace(0.0, steps, _FRAMES * steps + 1)
        frames = [np.eye(3)]
        for tangent in unit(line.smooth(phases, 1))[1:]:
            frames.append(_turned_to(tangent, frames[-1]))
        spin = _spin(frames[-1].T @ line.poses.rotation, steps * helix_twist(strand))
        return cls(line, strand, phases, np.array(frames), spin)

    def at(self, phases: ArrayLike) -> tuple[Array, Array]:
        """Points (m, 3) and frames (m, 3, 3), columns d1 d2 d3, at the phases (m,)."""
        phase = np.atleast_1d(np.asarray(phases, dtype=np.float64))
        last = self.phases[-1]
        inside = np.clip(phase, 0.0, last)
        kept = self.frames[np.searchsorted(self.phases, inside, side="right") - 1]
        points, tangents = self.line.smooth(inside), unit(self.line.smooth(inside, 1))
        frames = np.array([_turned_to(*pair) for pair in zip(tangents, kept, strict=True)])
        frames = frames @ _about_d3(self.spin * inside / last)
        for row in np.flatnonzero(phase < 0.0):
            points[row], frames[row] = _beyond(self.strand, np.zeros(3), np.eye(3), 0.0, phase[row])
        end = self.line.poses
        for row in np.flatnonzero(phase > last):
            points[row], frames[row] = _beyond(
                self.strand, end.position_A, end.rotation, 0.0, phase[row] - last
            )
        return points, frames


def curve_on(line: CandidateLine, strand: Strand) -> Curve:
    """What the nucleotides of a candidate are laid on, in the frame of its line's start.

    Parameters
    ----------
    line : RodLine or ChainLine
        The candidate's.
    strand : Strand
        What is carried.

    Returns
    -------
    Curve
    """
    if isinstance(line, ChainLine):
        return ChainCurve.of(line, strand)
    return Line.between(line.rod, line.ends, strand)


def _spin(turn: Array, helical: float) -> float:
    """Turn about a common tangent that takes one frame to another, by as many whole ones as fit.

    Parameters
    ----------
    turn : (3, 3) array
        The other frame in the first.
    helical : float
        What it should be near to, rad.

    Returns
    -------
    float
    """
    mismatch = math.atan2(turn[1, 0] - turn[0, 1], turn[0, 0] + turn[1, 1])
    return mismatch + round((helical - mismatch) / math.tau) * math.tau


def _beyond(
    strand: Strand, origin: Array, frame: Array, start: float, phase: float, taper: float = 0.0
) -> tuple[Array, Array]:
    """The pose reached from a given one by `phase` nucleotides along the stem's strand.

    The given one is at the strand's own phase ``start``, which matters to a tapered one.
    """
    point_0, frame_0 = line_frame(strand, start, taper)
    point, other = line_frame(strand, start + phase, taper)
    return origin + frame @ frame_0.T @ (point - point_0), frame @ frame_0.T @ other


def _turned_to(tangent: Array, frame: Array) -> Array:
    """A frame turned by as little as it takes to have this tangent."""
    d1 = frame[:, 0] - (frame[:, 0] @ tangent) * tangent
    if d1 @ d1 < 1e-12:
        d1 = np.cross(frame[:, 1], tangent)
    d1 = d1 / np.linalg.norm(d1)
    return np.stack([d1, np.cross(tangent, d1), tangent], axis=1)


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
