"""Lines between two helices: how long they are, what cannot be spanned, and rods of least energy.

A line of n nucleotides runs from the backbone site of the paired nucleotide before it to that of
the one after it: n + 1 bonds. Bonds have the model's unstretched length; where the ends are too far
apart for that, they are longer, up to a limit within the model's window. A rod of that length is
clamped to both helices. Its end may spin: there is no twist energy.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from loopelastica._arrays import Array, Record
from loopelastica.nanostructures.laying.ends import HelixEnds
from loopelastica.nanostructures.oxdna.model import BOND_LENGTH, UNIT_NM
from loopelastica.nanostructures.oxdna.periodic import nearest_image
from loopelastica.nanostructures.singles import Single
from loopelastica.nanostructures.system import System

LONGEST: Final = 0.98
"""Largest distance of ends per bond that is spanned, oxDNA's units; the window of the model ends at
1.0064."""
# a rod is so much longer than the distance of its ends, where its bonds allow it, and is never
# made of longer bonds: with less slack it is straight but for its very ends
_SLACK: Final = 1.05
_STRETCHED: Final = 0.985
# points of a rod per bond, and rounds that make its chords equal
_FINE: Final = 8
_ROUNDS: Final = 12
# chords are equal if they differ by no more, as a share of their mean
_UNEVEN: Final = 0.005


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Spans(Record):
    """Lines to be laid between helices; arrays over m of them, oxDNA's units.

    Attributes
    ----------
    start, end : HelixEnds
        Of the paired nucleotides before and after; ends are the image that is nearest to starts.
    bonds : (m,) array of int
        How many bonds each has, one more than nucleotides.
    distance : (m,) array
        From start to end.
    length : (m,) array
        Of the rod.
    """

    start: HelixEnds
    end: HelixEnds
    bonds: Array
    distance: Array
    length: Array

    def rows(self, which: list[int]) -> Spans:
        """Some of these lines."""
        start, end = (HelixEnds(e.point[which], e.frame[which]) for e in (self.start, self.end))
        return Spans(start, end, self.bonds[which], self.distance[which], self.length[which])


def spans(system: System, singles: list[Single], start: HelixEnds, end: HelixEnds) -> Spans:
    """Lines between helices with the lengths of their rods."""
    chord = nearest_image(end.point - start.point, system.box)
    end = HelixEnds(start.point + chord, end.frame)
    bonds = np.array([len(one) + 1.0 for one in singles])
    distance = np.linalg.norm(chord, axis=1)
    nominal = np.maximum(BOND_LENGTH * bonds, _SLACK * distance)
    length = np.maximum(np.minimum(nominal, _STRETCHED * bonds), BOND_LENGTH * bonds)
    return Spans(start, end, bonds, distance, length)


def refusal(system: System, single: Single, bonds: float, distance: float) -> str:
    """Why a line cannot be spanned; "" where it can."""
    if distance <= LONGEST * bonds:
        return ""
    n, label = len(single), system.label
    nucleotides = f"{n} nucleotide{'s' if n > 1 else ''}"
    # strands end in these labels; a small allowance for rounding
    enough = int(np.ceil(distance / LONGEST - 1e-9)) - 1
    return (
        f"{system.strand_name[system.strand[single.nucleotides[0]]]}, from {label[single.before]}"
        f" to {label[single.after]}: the {single.kind} of {nucleotides} reaches"
        f" {LONGEST * bonds * UNIT_NM:.2f} nm at most and its ends are {distance * UNIT_NM:.2f} nm"
        f" ({distance:.2f} of oxDNA's units) apart; {enough} nucleotides would suffice"
    )


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Rods(Record):
    """Rods of least energy on nucleotides; arrays over m lines.

    Attributes
    ----------
    sites, direction : tuple of (n, 3) array
        Backbone sites of the nucleotides of each, from 5' to 3', and unit vectors from there
        towards the bases.
    energy : (m,) array
        ∫ ½ κ² ds, per oxDNA's unit of length and bending rigidity.
    """

    sites: tuple[Array, ...]
    direction: tuple[Array, ...]
    energy: Array


def rods(found: Spans, first: Array, last: Array) -> Rods:
    """Solve all lines at once.

    Parameters
    ----------
    found : Spans
        The m lines; each is longer than the distance of its ends.
    first, last : (m, 3) array
        Unit vectors from backbone to base of the nucleotides before and after.

    Returns
    -------
    Rods
        Bonds of one line are all of one length. Bases turn from the first direction to the last
        by equal angles about the rod.
    """
    from loopelastica.rod.batch import solve_batch

    to_start = found.start.frame.transpose(0, 2, 1)
    chord = found.end.point - found.start.point
    positions = np.einsum("mij,mj->mi", to_start, chord) / found.length[:, None]
    batch = solve_batch(positions, to_start @ found.end.frame, free_spin=True)
    empty = np.zeros((0, 3))
    sites, directions = [empty] * len(batch), [empty] * len(batch)
    # all lines of one number of bonds at once
    for bonds in np.unique(found.bonds).astype(int).tolist():
        rows = np.flatnonzero(found.bonds == bonds)
        fine = _FINE * bonds + 1
        pose = np.zeros((len(rows), fine, 7))
        pose[:, :, 3] = 1.0
        for at, i in enumerate(rows.tolist()):
            # one that was not found is straight: what is in its way is put right with the rest
            pose[at, :, :3] = np.linspace(0.0, 1.0, fine)[:, None] * positions[i]
            if batch.converged[i]:
                pose[at] = batch[i].poses(fine)
        places, towards = _evenly(pose, bonds, found.start.frame[rows], first[rows], last[rows])
        places = places @ found.start.frame[rows].transpose(0, 2, 1)
        places *= found.length[rows, None, None]
        places += found.start.point[rows, None]
        for at, i in enumerate(rows.tolist()):
            sites[i], directions[i] = places[at, 1:-1], towards[at, 1:-1]
    energy = np.where(batch.converged, batch.energy, 0.0) / found.length
    return Rods(tuple(sites), tuple(directions), energy)


def _evenly(
    pose: Array, bonds: int, start: Array, first: Array, last: Array
) -> tuple[Array, Array]:
    """Points of m rods between equal chords, and directions turned evenly along them.

    Parameters
    ----------
    pose : (m, k, 7) array
        Positions and quaternions of the rods in their start frames, evenly spaced.
    bonds : int
        Of each.
    start : (m, 3, 3) array
        Start frames.
    first, last : (m, 3) array
        Directions at both ends.

    Returns
    -------
    places, directions : (m, bonds + 1, 3) array
        The first in the start frames.
    """
    from scipy.spatial.transform import Rotation

    m, fine = pose.shape[:2]
    row = np.arange(m)[:, None]
    at = np.tile(np.linspace(0.0, fine - 1.0, bonds + 1), (m, 1))
    for _ in range(_ROUNDS):
        low = np.clip(at.astype(int), 0, fine - 2)
        share = (at - low)[:, :, None]
        places = (1 - share) * pose[row, low, :3] + share * pose[row, low + 1, :3]
        chord = np.linalg.norm(np.diff(places, axis=1), axis=2)
        mean = chord.mean(axis=1, keepdims=True)
        if np.all(np.ptp(chord, axis=1) < _UNEVEN * mean[:, 0]):
            break
        step = np.diff(at, axis=1) * mean / np.maximum(chord, 0.1 * mean)
        at[:, 1:] = np.cumsum(step, axis=1)
        at *= (fine - 1) / at[:, -1:]
    near = np.rint(at).astype(int)
    turns = Rotation.from_quat(pose[row, near, 3:].reshape(-1, 4), scalar_first=True)
    frames = start[:, None] @ turns.as_matrix().reshape(m, bonds + 1, 3, 3)
    angle = [
        np.arctan2(
            np.einsum("mi,mi->m", frame[:, :, 1], to), np.einsum("mi,mi->m", frame[:, :, 0], to)
        )
        for frame, to in ((frames[:, 0], first), (frames[:, -1], last))
    ]
    turn = (angle[1] - angle[0] + np.pi) % (2 * np.pi) - np.pi
    angles = (angle[0][:, None] + turn[:, None] * np.linspace(0.0, 1.0, bonds + 1))[:, :, None]
    return places, np.cos(angles) * frames[..., 0] + np.sin(angles) * frames[..., 1]
