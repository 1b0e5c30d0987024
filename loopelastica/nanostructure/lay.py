"""Single strands between helices become lines of nucleotides.

Ends, lengths and refusals first; then rods of least energy for all lines between two helices at
once; tails along their helices; what overlaps has its bases turned, and where that is not enough
gives way as a rod in its surroundings (:mod:`.volume`). Helices never move.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final, Literal

import numpy as np

from loopelastica._arrays import Array
from loopelastica._checks import instance, one_of, positive, whole
from loopelastica.nanostructure.bases import axes_of, base_directions
from loopelastica.nanostructure.chains import Chains, Index
from loopelastica.nanostructure.conflicts import (
    CONFLICT,
    OVERLAP,
    conflicts_of,
    nearest_others,
    overlaps,
    strands_of,
    worst,
)
from loopelastica.nanostructure.detours import bow
from loopelastica.nanostructure.energies import nearest_image
from loopelastica.nanostructure.ends import HelixEnds, across, helix_ends
from loopelastica.nanostructure.laid import Conflict, Laid, LaidStrand, Sample, Shape
from loopelastica.nanostructure.model import BOND_LENGTH, UNIT_NM, backbone_sites, centre_of
from loopelastica.nanostructure.singles import Single, SingleKind, single_strands
from loopelastica.nanostructure.spans import refusal, rods, spans
from loopelastica.nanostructure.system import System
from loopelastica.nanostructure.tails import Tail, lay_tails, ring, straight
from loopelastica.nanostructure.volume import bending, clear, into_window
from loopelastica.nanostructure.wormlike import free_chain, held_chains, stiffness

PERSISTENCE_NM: Final = 1.5
"""Persistence length of single strands, nm: values in print go from 0.6 nm to several nm."""
_COIL: Final = 3.0
"""Persistence lengths from which on a strand is called a random coil."""
_ROUNDS: Final = 2
_ATTEMPTS: Final = 3
_BESIDE: Final = 3.0


def lay(
    system: System,
    *,
    tails: Literal["straight", "relaxed"] = "straight",
    sample: int = 0,
    seed: int = 0,
    persistence_length_nm: float = PERSISTENCE_NM,
) -> Laid:
    """Lay all single strands of a nanostructure; its helices stay as they are.

    Parameters
    ----------
    system : System
        Of a design or of oxDNA's files; all paired nucleotides are placed.
    tails : {"straight", "relaxed"}, optional
        Whether the tails of strands are straight and turn as a whole out of what is in their way,
        or follow their helices and bend where something is.
    sample : int, optional
        So many worm-like samples besides, clamped where the strands are.
    seed : int, optional
        Of the samples.
    persistence_length_nm : float, optional
        Of single strands, nm: of samples, and of remarks on random coils.

    Returns
    -------
    Laid
        The system, what became of each strand, and the samples.

    Raises
    ------
    ValueError
        If an argument is out of range, or a paired nucleotide has no place.
    """
    instance("system", system, System)
    one_of("straight", "relaxed")("tails", tails)
    sample, seed = whole(0)("sample", sample), whole(0)("seed", seed)
    persistence = positive("persistence_length_nm", persistence_length_nm)
    lost = (system.pair >= 0) & ~(system.placed & np.isfinite(system.centre).all(axis=1))
    if lost.any():
        label = system.label[int(np.argmax(lost))]
        raise ValueError(f"`system`: {label} is paired and has no place, so no strand can be laid")
    strands = _Strands(system, single_strands(system))
    strands.lay_rods()
    strands.lay_tails(turn=tails == "straight")
    strands.lay_free()
    moved = strands.resolve(rigid=tails == "straight")
    result, records = strands.records(moved, persistence / UNIT_NM)
    samples = tuple(strands.sampled((seed, k), persistence / UNIT_NM) for k in range(sample))
    return Laid(result, records, samples, persistence)


class _Strands:
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
            tangent=tangent,
            bond=np.full(n, BOND_LENGTH),
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
            chains.bond[rows] = solved.bond[at]
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

    def resolve(self, rigid: bool) -> Index:
        """Bring apart what overlaps; numbers of the strands that moved."""
        chains = self.chains
        fixed = self._of(SingleKind.FREE, SingleKind.CIRCLE)
        found = overlaps(self.composed(), self.laid)
        clear(chains, strands_of(found, chains.strand, OVERLAP), move=False)
        moved = np.zeros(0, dtype=np.int64)
        for _ in range(_ROUNDS):
            found = overlaps(self.composed(), self.laid)
            which = np.setdiff1d(strands_of(found, chains.strand, OVERLAP), fixed)
            if not len(which):
                return moved
            self._relax(which)
            moved = np.union1d(moved, which)
        for attempt in range(_ATTEMPTS):
            found = overlaps(self.composed(), self.laid)
            which = np.setdiff1d(strands_of(found, chains.strand, CONFLICT), fixed)
            if not len(which):
                break
            before, count = chains.sites.copy(), len(self.singles)
            turned = chains.direction.copy()
            bow(chains, [self.singles[k].nucleotides for k in which.tolist()], attempt)
            self._relax(which)
            now = overlaps(self.composed(), self.laid)
            worse = worst(now, chains.strand, count) >= worst(found, chains.strand, count)
            back = np.isin(chains.strand, which[worse[which]])
            chains.sites[back], chains.direction[back] = before[back], turned[back]
        return moved

    def _relax(self, which: Index) -> None:
        clear(self.chains, which, move=True)
        into_window(self.chains, which)

    def composed(self) -> System:
        """The system with all nucleotides that are placed by now."""
        system, chains = self.system, self.chains
        rows = np.flatnonzero(self.laid & chains.placed)
        tangent = np.zeros((len(rows), 3))
        for neighbour, sign in ((system.n3, 1.0), (system.n5, -1.0)):
            near = neighbour[rows]
            known = (near >= 0) & chains.placed[near]
            step = chains.sites[near[known]] - chains.sites[rows[known]]
            tangent[known] += sign * nearest_image(step, system.box)
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

    def records(self, moved: Index, persistence: float) -> tuple[System, tuple[LaidStrand, ...]]:
        """The system, and what became of each strand."""
        system, chains = self.composed(), self.chains
        labels = [self.label(k) for k in range(len(self.singles))]
        found = conflicts_of(system, overlaps(system, self.laid), chains.strand, labels)
        near = nearest_others(system, self.laid)
        hinges = bending(chains)
        for k in moved.tolist():
            self.energy[k] = float(hinges[self.singles[k].nucleotides].sum())
            self.shape[k] = "rod in its surroundings"
        return system, tuple(
            self._record(k, labels[k], tuple(found.get(k, ())), near, persistence)
            for k in range(len(self.singles))
        )

    def _record(
        self,
        k: int,
        label: str,
        conflicts: tuple[Conflict, ...],
        near: Array,
        persistence: float,
    ) -> LaidStrand:
        one, energy = self.singles[k], self.energy[k]
        length = None if self.reason[k] else self._length(one)
        nearest = float(near[one.nucleotides].min())
        bonds = len(one) - 1 + (one.before >= 0) + (one.after >= 0)
        bonds += one.kind == SingleKind.CIRCLE
        return LaidStrand(
            kind=one.kind,
            label=label,
            nucleotides=one.nucleotides.copy(),
            before=one.before,
            after=one.after,
            status="refused" if self.reason[k] else "laid",
            reason=self.reason[k],
            shape=self.shape[k],
            distance=self.distance[k],
            length=length,
            spacing=length / bonds if length is not None and bonds else None,
            energy_per_nm=None if energy is None else energy / UNIT_NM,
            energy=None if energy is None or length is None else energy * length,
            remark="" if length is None else self._remark(one, length, persistence),
            nearest=nearest if np.isfinite(nearest) else None,
            conflicts=conflicts,
        )

    def _length(self, one: Single) -> float:
        chain = [end for end in (one.before, *one.nucleotides.tolist(), one.after) if end >= 0]
        if one.kind == SingleKind.CIRCLE:
            chain.append(chain[0])
        steps = np.diff(self.chains.sites[chain], axis=0)
        return float(np.linalg.norm(nearest_image(steps, self.system.box), axis=1).sum())

    def _remark(self, one: Single, length: float, persistence: float) -> str:
        remarks = []
        if length > _COIL * persistence:
            remarks.append(
                f"random coil: {length / persistence:.0f} persistence lengths of"
                f" {persistence * UNIT_NM:g} nm long, so its least energy is one shape of many;"
                " a worm-like sample is nearer to what it does"
            )
        if self.system.rna[self.system.strand[one.nucleotides[0]]]:
            remarks.append("RNA, laid with the sites and bonds of DNA")
        return "; ".join(remarks)

    def sampled(self, seed: tuple[int, int], persistence: float) -> Sample:
        """Worm-like strands in the place of rods and tails, brought apart as those were."""
        kept = self.chains
        self.chains = replace(kept, sites=kept.sites.copy(), direction=kept.direction.copy())
        which = [k for k, shape in enumerate(self.shape) if shape and shape != "as given"
                 and self.singles[k].kind not in (SingleKind.FREE, SingleKind.CIRCLE)]  # fmt: skip
        for attempt in range(_ROUNDS):
            self._draw(which, (*seed, attempt), persistence)
            self.resolve(rigid=False)
            system = self.composed()
            found = overlaps(system, self.laid)
            which = np.intersect1d(strands_of(found, kept.strand, CONFLICT), which).tolist()
            if not which:
                break
        labels = [self.label(k) for k in range(len(self.singles))]
        left = conflicts_of(system, found, kept.strand, labels)
        self.chains = kept
        return Sample(system, tuple(one for k in sorted(left) for one in left[k]))

    def _draw(self, which: list[int], seed: tuple[int, ...], persistence: float) -> None:
        chains, held = self.chains, []
        kappas: dict[float, float] = {}
        for k in which:
            bond = round(float(chains.bond[self.singles[k].nucleotides[0]]), 6)
            kappas.setdefault(bond, stiffness(bond / persistence))
        def kappa(k: int) -> float:
            return kappas[round(float(chains.bond[self.singles[k].nucleotides[0]]), 6)]
        def generator(k: int) -> np.random.Generator:
            return np.random.default_rng([*seed, int(self.singles[k].nucleotides[0])])
        for k in which:
            one = self.singles[k]
            if one.before >= 0 and one.after >= 0:
                held.append(k)
                continue
            ahead = one.before >= 0
            anchor = one.before if ahead else one.after
            rows = one.nucleotides if ahead else one.nucleotides[::-1]
            tangent = chains.tangent[anchor] if ahead else -chains.tangent[anchor]
            chains.sites[rows] = free_chain(
                chains.sites[anchor], tangent, BOND_LENGTH, kappa(k), len(rows), generator(k)
            )
        starts = []
        for k in held:
            one = self.singles[k]
            line = chains.sites[[one.before, *one.nucleotides.tolist(), one.after]]
            steps = nearest_image(np.diff(line, axis=0), self.system.box)
            starts.append(line[0] + np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)]))
        clamps = np.array(
            [chains.tangent[[self.singles[k].before, self.singles[k].after]] for k in held]
        ).reshape(-1, 2, 3)
        drawn = held_chains(
            starts, clamps, np.array([kappa(k) for k in held]), [generator(k) for k in held]
        )
        for k, points in zip(held, drawn, strict=True):
            chains.sites[self.singles[k].nucleotides] = points[1:-1]
        for k in which:
            self._face(self.singles[k])

    def _face(self, one: Single) -> None:
        """Let bases look across their strand, from one end's direction to the other's."""
        chains = self.chains
        chain = [end for end in (one.before, *one.nucleotides.tolist(), one.after) if end >= 0]
        tangent = np.gradient(chains.sites[chain], axis=0)
        ends = [end for end in (one.before, one.after) if end >= 0]
        share = np.linspace(0.0, 1.0, len(chain))[:, None]
        towards = (1 - share) * chains.direction[ends[0]] + share * chains.direction[ends[-1]]
        size = np.linalg.norm(tangent, axis=1, keepdims=True)
        found = across(towards, tangent / np.maximum(size, 1e-12))
        inner = slice(int(one.before >= 0), len(chain) - int(one.after >= 0))
        chains.direction[one.nucleotides] = found[inner]
