"""What report.html shows of filled strands."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np
from scipy.spatial import KDTree

from loopelastica._arrays import Array
from loopelastica._names import printable
from loopelastica._version import __version__
from loopelastica.filling.result import FilledCandidate, FilledStrand, Filling
from loopelastica.folding.line import StrandLine
from loopelastica.folding.lines import POINTS_PER_NUCLEOTIDE
from loopelastica.folding.shape_line import ShapeLine
from loopelastica.molecule.polymer import Gap, HeavyAtoms, Monomer
from loopelastica.molecule.setting import NEAR_A
from loopelastica.molecule.surroundings import heavy_atoms
from loopelastica.molecule.trace import smoothed_phases
from loopelastica.report.page.scene import (
    chain_of,
    curve,
    curve_points,
    flat,
    own_curve,
    sticks,
    write_scene,
)

_STEP_A: Final = 9.0
"""Longest step along a chain between C4' atoms, or CA atoms."""


def write_strands(path: Path, filling: Filling, files: Sequence[str]) -> None:
    """Write scene.js of a filling: a strand each, filled or refused.

    Parameters
    ----------
    path : Path
        The file.
    filling : Filling
        What was filled.
    files : sequence of str
        Names of the other files of the folder.
    """
    atoms = cache(lambda model: heavy_atoms(filling.entry, model - 1))
    provenance = {
        "version": __version__,
        "sha256": filling.sha256,
        "parameters": filling.options.to_dict(),
        "files": list(files),
    }
    name = printable(filling.name)
    items = [
        {**_row(strand, name), **(_drawn(strand, atoms(strand.model)) if strand.candidates else {})}
        for strand in filling.strands
    ]
    write_scene(path, items, provenance)


def _row(strand: FilledStrand, name: str) -> dict[str, Any]:
    """What there is of every strand."""
    return {
        "row": {
            "file": name,
            "model": strand.model,
            "loop": strand.name,
            "sequence": strand.sequence,
            "nucleotides": strand.nucleotides,
            "status": strand.status,
            "reason": strand.reason,
        },
        "candidates": [],
        "remarks": list(strand.remarks),
    }


def _drawn(strand: FilledStrand, atoms: HeavyAtoms) -> dict[str, Any]:
    """What a filled strand has beyond."""
    gap = strand.candidates[0].atoms.gap
    before = [one for one in (gap.beyond_5, gap.before) if one is not None]
    after = [one for one in (gap.after, gap.beyond_3) if one is not None]
    return {
        "labels": [one.label for one in gap.monomers],
        "paired": False,
        "strands": [_chain(before), _chain(after)],
        "stem": flat(_flank_bonds(strand.candidates[0])),
        "own": _own(gap),
        "neighbours": [
            chain_of(labels, points)
            for labels, points in _neighbours(gap, strand.candidates[0], atoms)
        ],
        "candidates": [_candidate(candidate) for candidate in strand.candidates],
    }


def _chain(monomers: Sequence[Monomer]) -> dict[str, Any]:
    return chain_of([one.label for one in monomers], [_centroid(one) for one in monomers])


def _centroid(one: Monomer) -> Array:
    """Mean of the backbone atoms that are there."""
    backbone = one.backbone_A
    there = np.isfinite(backbone).all(axis=1)
    return backbone[there].mean(axis=0) if there.any() else np.full(3, np.nan)


def _flank_bonds(candidate: FilledCandidate) -> Array:
    """Bonds (m, 2, 3) of the nucleotides on both sides, which were there."""
    molecule = candidate.atoms.molecule
    outside = [r < 0 or r >= molecule.n for r in molecule.residue]
    bonds = [bond for bond in molecule.bonds if outside[bond[0]] and outside[bond[1]]]
    return candidate.atoms.positions_A[np.array(bonds, dtype=np.int64).reshape(-1, 2)]


def _own(gap: Gap) -> dict[str, Any] | None:
    """The strand that was there and was built anew."""
    centroids = np.array([_centroid(one) for one in (gap.before, *gap.replaces, gap.after)])
    if len(gap.replaces) != len(gap) or not np.isfinite(centroids).all():
        return None
    return {**own_curve(centroids), "bonds": []}


def _candidate(candidate: FilledCandidate) -> dict[str, Any]:
    line, checks = candidate.line, candidate.atoms.checks
    low, middle, high = candidate.expected_rmsd_A.tolist()
    return {
        "rank": candidate.rank,
        "shape": candidate.shape,
        "expected_10_A": low,
        "expected_rmsd_A": middle,
        "expected_90_A": high,
        "energy_per_A": line.energy_per_A,
        "sound": checks.sound,
        "why": "; ".join(checks.wrong),
        **_curve(line, len(candidate.trace)),
        "atoms": sticks(candidate.atoms.molecule, candidate.atoms.positions_A),
    }


def _curve(line: StrandLine | ShapeLine, n: int) -> dict[str, Any]:
    """A strand's line, of either kind."""
    k = curve_points(n)
    if isinstance(line, ShapeLine):
        points, _ = line.chain.sampled()
        return curve(points, line.trace, line.chain.phases(k), line.chain.curvature_per_A(k))
    ends = line.ends
    points = ends.to_file(line.rod.centerline(POINTS_PER_NUCLEOTIDE * n + 1))
    curvature = line.rod.curvature(k) / ends.length_A
    return curve(points, line.trace, smoothed_phases(n, k), curvature)


def _neighbours(
    gap: Gap, candidate: FilledCandidate, atoms: HeavyAtoms
) -> Iterator[tuple[list[str], Array]]:
    """Stretches of chains near the strand: C4' of nucleotides, CA of amino acids."""
    own = {one.label for one in (*gap.monomers, *gap.replaces)}
    own |= {one.label for one in (gap.beyond_5, gap.before, gap.after, gap.beyond_3) if one}
    metal = atoms.metal | atoms.water
    rows = np.flatnonzero(np.isin(atoms.name, ("C4'", "C4*", "CA")) & ~metal)
    near, _ = KDTree(np.concatenate([candidate.trace, _ends(gap)])).query(
        atoms.positions_A[rows], distance_upper_bound=NEAR_A
    )
    labels = [atoms.labels[k] for k in atoms.residue[rows]]
    taken = [k for k in range(len(rows)) if np.isfinite(near[k]) and labels[k] not in own]
    if not taken:
        return
    points = atoms.positions_A[rows[taken]]
    far = np.linalg.norm(np.diff(points, axis=0), axis=1) > _STEP_A
    breaks = np.flatnonzero((np.diff(taken) != 1) | far) + 1
    for run in np.split(np.arange(len(taken)), breaks):
        yield [labels[taken[k]] for k in run], points[run]


def _ends(gap: Gap) -> Array:
    return np.array([_centroid(gap.before), _centroid(gap.after)])
