"""A loop as it is shown, in pictures and in viewers: which way is up, its line joined to the stem.

The stem stands upright with its loop on top, the closing pair from left to right. What is drawn of
a candidate is its line and the short joints between that and the stem, which the rod leaves out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica._names import printable
from loopelastica.folding.lines import RodLine
from loopelastica.folding.rank import Candidate
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.setting import Setting

# points of a line, and of the joint between it and the stem
_DENSE: Final = 401
_JOINT: Final = 8
_LONGEST_NAME: Final = 8


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """From where a loop is seen.

    Attributes
    ----------
    middle_A : (3,) array
        Between the ends of its line.
    across, up, towards : (3,) array
        To the right, upwards and out of the picture; orthogonal, of unit length, right-handed.
    """

    middle_A: Array
    across: Array
    up: Array
    towards: Array

    def broadside(self, points: Array) -> View:
        """The same turned about the vertical, so that the points (n, 3) spread from side to side.

        It turns by a right angle at most, either way.
        """
        beside = (points - points.mean(axis=0)) @ np.column_stack([self.across, self.towards])
        x, y = np.linalg.eigh(beside.T @ beside)[1][:, -1]
        sign = 1.0 if x >= 0.0 else -1.0
        across = sign * (x * self.across + y * self.towards)
        return View(self.middle_A, across, self.up, np.cross(across, self.up))


def view_of(fold: LoopFold, setting: Setting | None = None) -> View:
    """The view of a folded loop: up along the stem, the closing pair across.

    Parameters
    ----------
    fold : LoopFold
        With at least one candidate.
    setting : Setting, optional
        Where it has a stem of two pairs or more, its axis is up; otherwise the loop's middle is.

    Returns
    -------
    View
    """
    assert fold.ends is not None
    start, end = fold.ends.start_origin_A, fold.ends.end_origin_A
    middle = 0.5 * (start + end)
    if setting is not None and len(setting.strand_5_A) > 1:
        axis = _stem_axis(setting)
        if np.linalg.norm(axis) > 1e-6:
            up = axis / np.linalg.norm(axis)
            across = _perpendicular(setting.strand_3_A[0] - setting.strand_5_A[-1], up)
            return View(middle, across, up, np.cross(across, up))
    across = (end - start) / np.linalg.norm(end - start)
    up = _perpendicular(fold.candidates[0].trace.mean(axis=0) - middle, across)
    return View(middle, across, up, np.cross(across, up))


def _stem_axis(setting: Setting) -> Array:
    """Along the helix, towards the loop; not finite where a strand is not whole."""
    strands = (setting.strand_5_A, setting.strand_3_A[::-1])
    pairs = 0.5 * (strands[0] + strands[1])
    along = pairs[-1] - pairs[0]
    # second differences of a helix point at its axis, and two of them are across it (P. C. Kahn,
    # Computers Chem. 13 (1989) 185); the middles of pairs wind around it themselves
    inwards = [np.diff(strand, 2, axis=0) for strand in strands]
    axis = sum((np.cross(v[:-1], v[1:]).sum(axis=0) for v in inwards), np.zeros(3))
    turns = float(axis @ along)
    return along if len(pairs) < 4 or turns == 0.0 else np.asarray(axis * np.sign(turns))


def _perpendicular(vector: Array, axis: Array) -> Array:
    """The direction of a vector across an axis; any one where it lies along it."""
    rest = vector - axis * float(vector @ axis)
    if np.linalg.norm(rest) < 1e-6:
        rest = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    return np.asarray(rest / np.linalg.norm(rest))


def tube(fold: LoopFold, candidate: Candidate, setting: Setting | None, n: int) -> Array:
    """The line of a candidate with the joints to its stem, points evenly spaced.

    The joints begin and end at the closing nucleotides. A rod leaves half a nucleotide for each; a
    chain goes on to where the ideal strand has the closing nucleotides, and that part is left out.

    Parameters
    ----------
    fold : LoopFold
        The loop.
    candidate : Candidate
        One of its shapes.
    setting : Setting or None
        Where the stem is; without it there are no joints.
    n : int
        Number of points.

    Returns
    -------
    (n, 3) array
        Å.
    """
    line, n_nt = candidate.line, len(fold.hairpin)
    along, phases = line.points(_DENSE), line.phases(_DENSE)
    # half a nucleotide is left for the joint
    along = along[(phases > 0.499) & (phases < n_nt + 0.501)]
    if isinstance(line, RodLine):
        along = np.concatenate([line.ends.continued_5_A, along, line.ends.continued_3_A])
    if setting is not None:
        before = _joint(setting.strand_5_A[-1], along[0], along[1] - along[0])
        after = _joint(setting.strand_3_A[0], along[-1], along[-2] - along[-1])
        along = np.concatenate([before, along, after[::-1]])
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(along, axis=0), axis=1))])
    at = np.linspace(0.0, s[-1], n)
    return np.stack([np.interp(at, s, values) for values in along.T], axis=1)


def _joint(stem_A: Array, end_A: Array, tangent: Array) -> Array:
    """Points from the stem up to the end of a line, without it, that run into its tangent."""
    chord = end_A - stem_A
    if not np.isfinite(chord).all():
        return np.empty((0, 3))
    t = np.linspace(0.0, 1.0, _JOINT, endpoint=False)[:, None]
    slope = tangent / np.linalg.norm(tangent) * np.linalg.norm(chord)
    # the parabola through both points with that tangent at its end
    return np.asarray(stem_A + (2.0 * t - t**2) * chord + (t**2 - t) * slope)


def names_of(fold: LoopFold, setting: Setting | None = None) -> list[str]:
    """Closing nucleotide, nucleotides of the loop and closing nucleotide, such as "C5".

    Parameters
    ----------
    fold : LoopFold
    setting : Setting, optional
        Whose names the closing ones get; without it they are as in labels, such as "DC5".

    Returns
    -------
    list of str
        Printable and short.
    """
    hairpin = fold.hairpin
    if setting is not None:
        five, three = setting.names_5[-1], setting.names_3[0]
    else:
        five, three = (label.rpartition(".")[2] for label in hairpin.closing_pair)
    parts = zip(hairpin.sequence[1:-1], hairpin.resid, hairpin.icode, strict=True)
    names = [five, *(f"{letter}{number}{code}" for letter, number, code in parts), three]
    return [printable(name)[:_LONGEST_NAME] for name in names]


def short_shape(candidate: Candidate, most: int) -> str:
    """What a candidate is, in at most so many letters: clauses are left out from the end.

    Parameters
    ----------
    candidate : Candidate
    most : int

    Returns
    -------
    str
        Printable, for a shape may be called after a file.
    """
    text = printable(candidate.shape)
    while len(text) > most and (cut := max(text.rfind(", "), text.rfind(" ("))) > 0:
        text = text[:cut]
    return text if len(text) <= most else f"{text[: most - 1]}…"


def smooth_strand(points_A: Array, n: int = 6) -> Array:
    """A strand of the stem as a smooth line, n points from nucleotide to nucleotide.

    Parameters
    ----------
    points_A : (k, 3) array
        Its nucleotides, Å; those that are not finite are left out.
    n : int

    Returns
    -------
    (m, 3) array
    """
    from scipy.interpolate import CubicSpline

    points_A = points_A[np.isfinite(points_A).all(axis=1)]
    if len(points_A) < 3:
        return points_A
    last = len(points_A) - 1
    spline = CubicSpline(np.arange(last + 1), points_A, bc_type="natural")
    return np.asarray(spline(np.linspace(0.0, last, n * last + 1)))
