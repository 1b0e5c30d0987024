"""Single strands while they are laid: placed one kind after the other, then brought apart."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.nanostructures.laying.bases import axes_of, base_directions, turned_apart
from loopelastica.nanostructures.laying.chains import Chains, Index
from loopelastica.nanostructures.laying.conflicts import (
    CONFLICT,
    OVERLAP,
    Overlaps,
    crossed,
    overlaps,
    strands_of,
    worst,
)
from loopelastica.nanostructures.laying.cores import Cores
from loopelastica.nanostructures.laying.detours import bow
from loopelastica.nanostructures.laying.ends import HelixEnds, helix_ends
from loopelastica.nanostructures.laying.laid import Shape
from loopelastica.nanostructures.laying.spans import refusal, rods, spans
from loopelastica.nanostructures.laying.tails import Tail, lay_tails, ring, straight
from loopelastica.nanostructures.laying.volume import clear, into_window
from loopelastica.nanostructures.oxdna.energies import separation
from loopelastica.nanostructures.oxdna.model import BOND_LENGTH, backbone_sites, centre_of
from loopelastica.nanostructures.oxdna.periodic import nearest_image
from loopelastica.nanostructures.singles import Single, SingleKind
from loopelastica.nanostructures.system import System

# rounds of making way, and other ways that are tried for a line in conflict then
_ROUNDS: Final = 2
_ATTEMPTS: Final = 4
# between strands that are paired nowhere
_BESIDE: Final = 3.0


class Strands:
    """All single strands of a system while they are laid."""

    def __init__(self, system: System, singles: tuple[Single, ...]) -> None:
        self.system, self.singles = system, singles
        self.reason = [""] * len(singles)
        self.shape: list[Shape] = [""] * len(singles)
        self.distance: list[float | None] = [None] * len(singles)
        self.energy: list[float | None] = [None] * len(singles)
        kept = [
            one.kind in (SingleKind.FREE, SingleKind.CIRCLE)
            and bool(system.placed[one.nucleotides].all())
            for one in singles
        ]
        n = len(system)
        number = np.full(n, -1, dtype=np.int64)
        for k, one in enumerate(singles):
            if kept[k]:
                self.shape[k] = "as given"
            else:
                number[one.nucleotides] = k
        self.laid = number >= 0
        sites = backbone_sites(system.centre, system.a1, system.a3)
        self.ends_of = np.unique(
            [end for one in singles for end in (one.before, one.after) if end >= 0]
        ).astype(np.int64)
        self.ends = helix_ends(system, self.ends_of)
        tangent = np.zeros((n, 3))
        tangent[self.ends_of] = self.ends.frame[:, :, 2]
        self.chains = Chains(
            sites=sites,
            direction=base_directions(system.a1, system.a3),
            placed=system.placed & ~self.laid,
            n3=system.n3,
            n5=system.n5,
            strand=number,
            order=np.concatenate(
                [one.nucleotides for k, one in enumerate(singles) if not kept[k]]
                or [np.zeros(0, dtype=np.int64)]
            ),
            tangent=tangent,
            bond=np.full(n, BOND_LENGTH),
            cores=_cores(system),
            box=system.box,
        )

    def _of(self, *kinds: SingleKind) -> list[int]:
        return [
            k
            for k, one in enumerate(self.singles)
            if one.kind in kinds and self.shape[k] != "as given"
        ]

    def _ends(self, index: list[int]) -> HelixEnds:
        rows = np.searchsorted(self.ends_of, index)
        return HelixEnds(self.ends.point[rows], self.ends.frame[rows])

    def lay_rods(self) -> None:
        """Rods between two helices; those that cannot be are refused."""
        which = self._of(SingleKind.HAIRPIN, SingleKind.LINKER)
        asked = [self.singles[k] for k in which]
        found = spans(
            self.system,
            asked,
            self._ends([one.before for one in asked]),
            self._ends([one.after for one in asked]),
        )
        keep = []
        for row, (k, one) in enumerate(zip(which, asked, strict=True)):
            distance = float(found.distance[row])
            self.distance[k] = distance
            self.reason[k] = refusal(self.system, one, float(found.bonds[row]), distance)
            if not self.reason[k]:
                keep.append(row)
        if not keep:
            return
        chains = self.chains
        flanks = np.array([[asked[row].before, asked[row].after] for row in keep])
        solved = rods(found.rows(keep), *(chains.direction[flanks[:, side]] for side in (0, 1)))
        for at, row in enumerate(keep):
            k, rows = which[row], asked[row].nucleotides
            chains.sites[rows], chains.direction[rows] = solved.sites[at], solved.direction[at]
            chains.placed[rows] = True
            chains.bond[rows] = max(BOND_LENGTH, found.distance[row] / found.bonds[row])
            self.shape[k], self.energy[k] = "rod", float(solved.energy[at])

    def lay_tails(self, turn: bool) -> None:
        """Tails, straight."""
        which = self._of(SingleKind.TAIL_5, SingleKind.TAIL_3)
        found = []
        for k in which:
            one = self.singles[k]
            ahead = one.kind == SingleKind.TAIL_3
            anchor = one.before if ahead else one.after
            frame = self._ends([anchor]).frame[0]
            found.append(
                Tail(
                    one.nucleotides if ahead else one.nucleotides[::-1],
                    anchor,
                    frame[:, 2] if ahead else -frame[:, 2],
                    -frame[:, 0],
                )
            )
            self.shape[k], self.energy[k] = "straight", 0.0
        lay_tails(self.chains, found, turn)

    def lay_free(self) -> None:
        """Strands that are paired nowhere and have no place: in a row beside all others."""
        which = self._of(SingleKind.FREE, SingleKind.CIRCLE)
        chains = self.chains
        placed = chains.sites[chains.placed]
        low = placed.min(axis=0) if len(placed) else np.zeros(3)
        high = placed.max(axis=0) if len(placed) else np.zeros(3)
        at = float(high[1]) + _BESIDE
        for k in which:
            rows = self.singles[k].nucleotides
            if self.singles[k].kind == SingleKind.FREE:
                start = np.array([low[0], at, low[2] - BOND_LENGTH])
                sites = straight(start, np.array([0.0, 0.0, 1.0]), len(rows))
                directions = np.tile([0.0, 1.0, 0.0], (len(rows), 1))
                self.shape[k], self.energy[k], at = "straight", 0.0, at + _BESIDE
            elif len(rows) < 3:
                self.reason[k] = (
                    f"{self.label(k)}: a circle of {len(rows)} nucleotides cannot be laid; it takes"
                    " 3"
                )
                continue
            else:
                sites, directions = ring(len(rows))
                radius = float(np.linalg.norm(sites[0]))
                sites = sites + [low[0] + radius, at + radius, low[2]]
                self.shape[k], self.energy[k] = "circle", len(rows) * BOND_LENGTH / radius**2 / 2
                at += 2 * radius + _BESIDE
            chains.sites[rows], chains.direction[rows] = sites, directions
            chains.placed[rows] = True

    def resolve(self) -> tuple[Index, Overlaps]:
        """Bring apart what overlaps; numbers of the strands that moved, and what is left."""
        chains = self.chains
        fixed = self._of(SingleKind.FREE, SingleKind.CIRCLE)
        first = self.composed()
        found = overlaps(first, self.laid)
        turning = strands_of(found, chains.strand, OVERLAP)
        clear(chains, np.setdiff1d(turning, crossed(first, chains.strand)), move=False)
        moved = np.zeros(0, dtype=np.int64)
        for _ in range(_ROUNDS):
            found = overlaps(self.composed(), self.laid)
            which = np.setdiff1d(strands_of(found, chains.strand, OVERLAP), fixed)
            if not len(which):
                return moved, found
            self._relax(which)
            moved = np.union1d(moved, which)
        found = overlaps(self.composed(), self.laid)
        for attempt in range(_ATTEMPTS):
            which = np.setdiff1d(strands_of(found, chains.strand, CONFLICT), fixed)
            if not len(which):
                break
            before, count = chains.sites.copy(), len(self.singles)
            turned = chains.direction.copy()
            # out of helices; if that is not enough, to one side and then out of what is there
            if attempt:
                bow(chains, [self.singles[k].nucleotides for k in which.tolist()], attempt - 1)
            clear(chains, which, move=True, repulsion=Cores)
            self._relax(which)
            now = overlaps(self.composed(), self.laid)
            worse = worst(now, chains.strand, count) >= worst(found, chains.strand, count)
            back = np.isin(chains.strand, which[worse[which]])
            chains.sites[back], chains.direction[back] = before[back], turned[back]
            found = overlaps(self.composed(), self.laid) if back.any() else now
        return moved, self._centres_apart(found)

    def _centres_apart(self, found: Overlaps) -> Overlaps:
        """Turn bases whose centres are too near to others, where all else has failed."""
        chains, system = self.chains, self.composed()
        centre = system.centre.copy()
        near = np.isinf(found.energy) & (system.n3[found.first] != found.second)
        near &= system.n5[found.first] != found.second
        rows = np.unique(np.concatenate([found.first[near], found.second[near]]))
        rows = rows[self.laid[rows]]
        for i, tangent in zip(rows.tolist(), self._tangents(rows), strict=True):
            others = system.placed.copy()
            others[[k for k in (i, system.n3[i], system.n5[i]) if k >= 0]] = False
            chains.direction[i] = turned_apart(
                chains.sites[i], chains.direction[i], tangent, centre[others], chains.box
            )
            axes = axes_of(chains.direction[[i]], tangent[None])
            centre[i] = centre_of(chains.sites[[i]], *axes)[0]
        return overlaps(self.composed(), self.laid) if len(rows) else found

    def _relax(self, which: Index) -> None:
        clear(self.chains, which, move=True)
        into_window(self.chains, which)

    def _tangents(self, rows: Index) -> Array:
        """Vectors (m, 3) along strands at nucleotides that are laid."""
        system, chains = self.system, self.chains
        tangent = np.zeros((len(rows), 3))
        for neighbour, sign in ((system.n3, 1.0), (system.n5, -1.0)):
            near = neighbour[rows]
            known = (near >= 0) & chains.placed[near]
            step = chains.sites[near[known]] - chains.sites[rows[known]]
            tangent[known] += sign * nearest_image(step, system.box)
        return tangent

    def composed(self) -> System:
        """The system with all nucleotides that are placed by now."""
        system, chains = self.system, self.chains
        rows = np.flatnonzero(self.laid & chains.placed)
        tangent = self._tangents(rows)
        centre, a1, a3 = system.centre.copy(), system.a1.copy(), system.a3.copy()
        a1[rows], a3[rows] = axes_of(chains.direction[rows], tangent)
        centre[rows] = centre_of(chains.sites[rows], a1[rows], a3[rows])
        return replace(system, centre=centre, a1=a1, a3=a3, placed=chains.placed.copy())

    def label(self, k: int) -> str:
        """What sentences call a single strand."""
        one, system = self.singles[k], self.system
        name = system.strand_name[system.strand[one.nucleotides[0]]]
        ends = " to ".join(system.label[end] for end in (one.before, one.after) if end >= 0)
        return f"{name}, {one.kind} of {len(one)}" + (f" at {ends}" if ends else "")


def _cores(system: System) -> Array:
    """Middles (p, 3) of base pairs."""
    one = np.flatnonzero((system.pair > np.arange(len(system))) & system.placed)
    other = system.pair[one]
    middle = separation(system, system.centre[one], system.centre[other]) / 2
    return np.asarray(system.centre[one] + middle)
