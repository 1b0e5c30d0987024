"""Whether a simulation can begin with a start: bonds, distances, axes and energies of strands."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from loopelastica.nanostructures.laying.conflicts import CONFLICT, overlaps, strands_of
from loopelastica.nanostructures.laying.laid import LaidStrand
from loopelastica.nanostructures.oxdna.checks import NEAREST
from loopelastica.nanostructures.oxdna.energies import (
    bonds,
    close_sites,
    excluded_volume,
    separation,
)
from loopelastica.nanostructures.oxdna.model import BOND_LONGEST, BOND_SHORTEST
from loopelastica.nanostructures.system import System

Row = dict[str, Any]

# centres are looked for up to this distance
_NEAR = 1.5
_SUMS = (
    *("strands", "refused", "nucleotides", "bonds", "broken", "drawn_broken", "close"),
    *("conflicts", "ready", "seconds", "failed", "backbone", "volume"),
)
_LARGEST = ("skew", "largest")


def measured(system: System, strands: tuple[LaidStrand, ...]) -> Row:
    """Measure a start.

    Parameters
    ----------
    system : System
        All nucleotides.
    strands : tuple of LaidStrand
        Single strands; those that were refused count as nothing else.

    Returns
    -------
    dict
        ``strands`` and their ``nucleotides``, ``refused``; of laid strands, junctions included,
        the number of ``bonds`` and of those out of the window (``broken``); other bonds out of it
        (``drawn_broken``); pairs of centres under 0.4 (``close``), the ``nearest`` two up to 1.5;
        largest ``skew`` of axes; ``conflicts``, pairs with an excluded volume of five times kT and
        more; sums of ``backbone`` energy of bonds within the window and of excluded ``volume``, and
        the ``largest`` of one bond or one pair of sites; strands that are ``ready``: without broken
        bonds, close centres and conflicts. oxDNA's units.
    """
    laid = [one for one in strands if one.status == "laid"]
    number = np.full(len(system), -1)
    for k, one in enumerate(laid):
        number[one.nucleotides] = k
    single = number >= 0
    bonded, volume = bonds(system), excluded_volume(system)
    own = single[bonded.first] | single[bonded.second]
    out = (bonded.length <= BOND_SHORTEST) | (bonded.length >= BOND_LONGEST)
    i, j = close_sites(system, system.centre, _NEAR)
    beside = single[i] | single[j]
    apart = np.linalg.norm(separation(system, system.centre[i], system.centre[j]), axis=1)[beside]
    axes = np.stack([system.a1, system.a2, system.a3], axis=1)[single]
    pushed = single[volume.first] | single[volume.second]
    backbone, bonded_volume = bonded.backbone[own & ~out], bonded.excluded_volume[own]
    energies = np.concatenate([backbone, bonded_volume, volume.energy[pushed]])
    found = overlaps(system, single)
    return {
        "strands": len(laid),
        "refused": len(strands) - len(laid),
        "nucleotides": int(single.sum()),
        "bonds": int(own.sum()),
        "broken": int((own & out).sum()),
        "drawn_broken": int((~own & out).sum()),
        "close": int((apart < NEAREST).sum()),
        "nearest": float(apart.min()) if len(apart) else None,
        "skew": float(np.abs(axes @ axes.transpose(0, 2, 1) - np.eye(3)).max(initial=0.0)),
        "conflicts": int((found.energy > CONFLICT).sum()),
        "ready": len(laid) - len(strands_of(found, number, CONFLICT)),
        "backbone": float(backbone.sum()),
        "volume": float(bonded_volume.sum() + volume.energy[pushed].sum()),
        "largest": float(energies.max(initial=0.0)),
    }


def summed(rows: Iterable[Mapping[str, Any]]) -> Row:
    """One row for the designs of a family.

    Parameters
    ----------
    rows : iterable of dict
        Of :func:`measured`, with ``seconds`` of processor time; where there was no start, how many
        strands ``failed``.

    Returns
    -------
    dict
        Sums, extremes, and ``backbone_per_bond``, ``volume_per_nucleotide``, ``ready_share`` (of
        those that failed too), ``ms_per_strand`` (the same as seconds per 1,000 strands); None
        where nothing was laid.
    """
    rows = list(rows)
    total: Row = {key: sum(row.get(key) or 0 for row in rows) for key in _SUMS}
    total |= {key: max((row.get(key) or 0.0 for row in rows), default=0.0) for key in _LARGEST}
    total["nearest"] = min(
        (row["nearest"] for row in rows if row.get("nearest") is not None), default=None
    )
    intact = total["bonds"] - total["broken"]
    for share, part, whole in (
        ("backbone_per_bond", total["backbone"], intact),
        ("volume_per_nucleotide", total["volume"], total["nucleotides"]),
        ("ready_share", total["ready"], total["strands"] + total["failed"]),
        ("ms_per_strand", 1e3 * total["seconds"], total["strands"]),
    ):
        total[share] = part / whole if whole else None
    return total
