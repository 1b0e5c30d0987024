"""Single strands between helices become lines of nucleotides.

Ends, lengths and refusals first; then rods of least energy for all lines between two helices at
once; tails along their helices; what overlaps has its bases turned, and where that is not enough
gives way as a rod in its surroundings (:mod:`.volume`). Helices never move.
"""

from __future__ import annotations

from typing import Final, Literal

import numpy as np

from loopelastica._arrays import Array
from loopelastica._checks import instance, one_of, positive, whole
from loopelastica.nanostructures.laying.chains import Index
from loopelastica.nanostructures.laying.conflicts import Overlaps, conflicts_of, nearest_others
from loopelastica.nanostructures.laying.laid import Conflict, Laid, LaidStrand
from loopelastica.nanostructures.laying.sampling import draw_sample
from loopelastica.nanostructures.laying.strands import Strands
from loopelastica.nanostructures.laying.volume import bending
from loopelastica.nanostructures.oxdna.model import UNIT_NM
from loopelastica.nanostructures.oxdna.periodic import nearest_image
from loopelastica.nanostructures.singles import Single, SingleKind, single_strands
from loopelastica.nanostructures.system import System

PERSISTENCE_NM: Final = 1.5
"""Persistence length of single strands, nm: values in print go from 0.6 nm to several nm."""
_COIL: Final = 3.0
"""Persistence lengths from which on a strand is called a random coil."""


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
    strands = Strands(system, single_strands(system))
    strands.lay_rods()
    strands.lay_tails(turn=tails == "straight")
    strands.lay_free()
    moved, left = strands.resolve()
    result, records = _records(strands, moved, left, persistence / UNIT_NM)
    samples = tuple(draw_sample(strands, (seed, k), persistence / UNIT_NM) for k in range(sample))
    return Laid(result, records, samples, persistence)


def _records(
    strands: Strands, moved: Index, left: Overlaps, persistence: float
) -> tuple[System, tuple[LaidStrand, ...]]:
    """The system, and what became of each strand."""
    system, chains, count = strands.composed(), strands.chains, len(strands.singles)
    labels = [strands.label(k) for k in range(count)]
    found = conflicts_of(system, left, chains.strand, labels)
    near = nearest_others(system, strands.laid)
    hinges = bending(chains)
    for k in moved.tolist():
        strands.energy[k] = float(hinges[strands.singles[k].nucleotides].sum())
        strands.shape[k] = "rod in its surroundings"
    return system, tuple(
        _record(strands, k, labels[k], tuple(found.get(k, ())), near, persistence)
        for k in range(count)
    )


def _record(
    strands: Strands,
    k: int,
    label: str,
    conflicts: tuple[Conflict, ...],
    near: Array,
    persistence: float,
) -> LaidStrand:
    one, energy = strands.singles[k], strands.energy[k]
    length = None if strands.reason[k] else _length(strands, one)
    nearest = float(near[one.nucleotides].min())
    bonds = len(one) - 1 + (one.before >= 0) + (one.after >= 0)
    bonds += one.kind == SingleKind.CIRCLE
    return LaidStrand(
        kind=one.kind,
        label=label,
        nucleotides=one.nucleotides.copy(),
        before=one.before,
        after=one.after,
        status="refused" if strands.reason[k] else "laid",
        reason=strands.reason[k],
        shape=strands.shape[k],
        distance=strands.distance[k],
        length=length,
        spacing=length / bonds if length is not None and bonds else None,
        energy_per_nm=None if energy is None else energy / UNIT_NM,
        energy=None if energy is None or length is None else energy * length,
        remark="" if length is None else _remark(strands, one, length, persistence),
        nearest=nearest if np.isfinite(nearest) else None,
        conflicts=conflicts,
    )


def _length(strands: Strands, one: Single) -> float:
    chain = [end for end in (one.before, *one.nucleotides.tolist(), one.after) if end >= 0]
    if one.kind == SingleKind.CIRCLE:
        chain.append(chain[0])
    steps = np.diff(strands.chains.sites[chain], axis=0)
    return float(np.linalg.norm(nearest_image(steps, strands.system.box), axis=1).sum())


def _remark(strands: Strands, one: Single, length: float, persistence: float) -> str:
    remarks = []
    if length > _COIL * persistence:
        remarks.append(
            f"random coil: {length / persistence:.0f} persistence lengths of"
            f" {persistence * UNIT_NM:g} nm long, so its least energy is one shape of many;"
            " a worm-like sample is nearer to what it does"
        )
    if strands.system.rna[strands.system.strand[one.nucleotides[0]]]:
        remarks.append("RNA, laid with the sites and bonds of DNA")
    return "; ".join(remarks)
