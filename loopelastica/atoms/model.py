"""From a folded line to atoms: carry, turn, restore, check.

    candidate → line with directors → Ω and χ → start → minimum → checks

Everything is computed in the frame of the line's start, rounded there to 1e-6 Å, so that a rigid
motion of the input moves the atoms by the same motion and by nothing else.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica.atoms.carry import Line, own_phase
from loopelastica.atoms.checks import Checks, check, puckers
from loopelastica.atoms.chemistry import (
    JUNCTION_3,
    JUNCTION_5,
    LoopMolecule,
    Residue,
    loop_molecule,
)
from loopelastica.atoms.fibre import fibre_nucleotide
from loopelastica.atoms.geometry import (
    BOND_SD_A,
    NEAREST_1_4_A,
    PLANAR_SD_A3,
    PUCKER_SD_A3,
    PUCKERS_DEG,
    VOLUME_SD_A3,
    IdealGeometry,
    chiral_quads,
    ideal_geometry,
    nearest_A,
    outer_distances,
    planar_quads,
    ring_quads,
    separations,
)
from loopelastica.atoms.relax import Relaxed, Restraints, relax
from loopelastica.atoms.turn import Stem, Turns, place, turned
from loopelastica.errors import StructureError
from loopelastica.folding import LoopFold
from loopelastica.molecule.nucleotides import BACKBONE, RING, Structure, atom_positions
from loopelastica.molecule.strands import ideal_strand
from loopelastica.rank import Candidate

Array = NDArray[np.float64]

LINE_SD_A: Final = (0.3, 1.0, 3.0)
"""How near the backbone centroids are held to the line. The next one is for lines from which no
sound model (right hands, whole chain, no clash) has come: a rod has no thickness and may run
through the stem or itself. The nucleotides are then moved out of the way first."""
TETHER_SD_A: Final = 3.0
_NEIGHBOURHOOD_A: Final = 14.0
_GRID_A: Final = 6
_PUSHES: Final = 100
_PUSH_A: Final = 3.5


@dataclass(frozen=True, slots=True, eq=False)
class AtomModel:
    """The atoms of one candidate.

    Attributes
    ----------
    rank : int
        The candidate's.
    molecule : LoopMolecule
    positions_A : (N, 3) array
        In the coordinates of the file, rows of the molecule; stem rows as in the file.
    turns : Turns
        The combination of Ω and χ it started from.
    alternatives : tuple of Turns
        The others that were tried or kept, best first.
    start_A : (N, 3) array
        Positions before the minimization.
    relaxed : Relaxed
        Status, steps and cost; its positions are in the frame of the line's start.
    checks : Checks
    rmsd_A : float or None
        The six backbone atoms of the loop against the file's own loop, without superposition; None
        where the file has none.
    """

    rank: int
    molecule: LoopMolecule
    positions_A: Array
    turns: Turns
    alternatives: tuple[Turns, ...]
    start_A: Array
    relaxed: Relaxed
    checks: Checks
    rmsd_A: float | None


def build_atoms(
    structure: Structure,
    fold: LoopFold,
    *,
    model: int = 0,
    positions: Array | None = None,
    contact: str | None = None,
    tries: int = 3,
    max_steps: int = 300,
    max_seconds: float = 60.0,
    max_candidates: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[AtomModel]:
    """Atoms for each candidate of a folded loop.

    Parameters
    ----------
    structure : Structure
        What was folded.
    fold : LoopFold
        One of its loops.
    positions : (n_atoms, 3) array, optional
        Of all atoms, Å; default those of model 0 of the structure, from which `fold` is.
    contact : {"sheared", "watson-crick"}, optional
        Contact across the loop to be sought; see :func:`loopelastica.atoms.turn.turned`.
    tries : int
        Combinations of Ω and χ minimized per candidate; the best minimum is kept.
    max_steps, max_seconds : int, float
        Limits of each minimization; how it ended is in ``relaxed.status``.
    max_candidates : int, optional
        Only the first ones.
    progress : callable, optional
        Called with (done, total) after each candidate.

    Raises
    ------
    StructureError
        If the loop was not folded, a loop nucleotide has no known base, or an atom that a junction
        needs is missing.
    ValueError
        If an option is out of range.
    """
    if tries < 1:
        raise ValueError(f"`tries` is {tries}; at least one combination is minimized")
    if fold.ends is None or not fold.candidates:
        raise StructureError(fold.failure or "the loop was not folded; it gets no atoms")
    if positions is None:
        positions = structure.positions(model)
    site = _site(structure, fold, np.asarray(positions, dtype=np.float64))
    chosen = fold.candidates[:max_candidates]
    models = []
    for done, candidate in enumerate(chosen, start=1):
        models.append(
            _candidate(site, fold, candidate, contact, tries, max_steps, max_seconds)
        )
        if progress is not None:
            progress(done, len(chosen))
    return models


@dataclass(frozen=True, slots=True, eq=False)
class _Site:
    """What all candidates of a loop share, in the frame of the line's start."""

    molecule: LoopMolecule
    geometry: IdealGeometry
    fixed: dict[int, Array]  # rows of the molecule that belong to the stem
    file_rows: dict[int, Array]  # the same in the file's coordinates
    around: Array  # heavy atoms near the loop that are no part of the molecule
    around_polar: NDArray[np.bool_]
    stem: Stem
    origin: Array
    frame: Array
    native: Array  # six backbone atoms of the file's own loop, its coordinates; NaN where missing


def loop_residues(structure: Structure, fold: LoopFold) -> list[Residue]:
    """The nucleotides to be built.

    Raises
    ------
    StructureError
        If one has no known base.
    """
    table = structure.nucleotides
    residues = []
    for row in fold.hairpin.loop:
        letter = str(table.letter[row])
        if letter not in "ACGUT":
            raise StructureError(
                f"{table.label(int(row))}: its base is unknown; the loop gets no atoms"
            )
        residues.append(Residue(letter, bool(table.is_dna[row]), str(table.resname[row])))
    return residues


def _site(structure: Structure, fold: LoopFold, positions: Array) -> _Site:
    assert fold.ends is not None
    table, hairpin = structure.nucleotides, fold.hairpin
    molecule = loop_molecule(loop_residues(structure, fold))
    origin, frame = np.asarray(fold.ends.start_origin_A), np.asarray(fold.ends.start_frame)
    n = len(hairpin.loop)
    in_file: dict[int, Array] = {}
    used: list[int] = []
    for residue, row, names in (
        (-1, int(hairpin.stem_5[0]), JUNCTION_5),
        (n, int(hairpin.stem_3[0]), JUNCTION_3),
    ):
        for name in names:
            atom = int(table.columns([name])[row, 0])
            if atom < 0 or not np.isfinite(positions[atom]).all():
                raise StructureError(
                    f"{table.label(row)}: no {name} atom; the loop cannot be joined to the stem"
                    " and gets no atoms"
                )
            used.append(atom)
            in_file[molecule.index(residue, name)] = positions[atom]
    local = np.round((positions - origin) @ frame, _GRID_A)
    fixed = {row: np.round((at - origin) @ frame, _GRID_A) for row, at in in_file.items()}
    around, polar = _around(structure, fold, local, used)
    rings = atom_positions(table, local, RING)[[hairpin.stem_5[0], hairpin.stem_3[0]]]
    stem = Stem(
        around,
        rings[np.isfinite(rings).all(axis=(1, 2))],
        fixed[molecule.index(-1, "O3'")],
        fixed[molecule.index(n, "P")],
    )
    return _Site(
        molecule, ideal_geometry(molecule), fixed, in_file, around, polar, stem, origin, frame,
        atom_positions(table, positions, BACKBONE)[hairpin.loop],
    )


def _around(
    structure: Structure, fold: LoopFold, local: Array, used: list[int]
) -> tuple[Array, NDArray[np.bool_]]:
    """Heavy atoms near any candidate, the loop's own and the junctions' left out."""
    from scipy.spatial import cKDTree

    element = elements(structure)
    loop = structure.nucleotides.atom_index[fold.hairpin.loop, :]
    residues = np.unique(structure.universe.atoms.resindices[loop[loop >= 0]])
    outside = ~np.isin(structure.universe.atoms.resindices, residues)
    outside &= (element != "H") & (element != "D") & np.isfinite(local).all(axis=1)
    outside &= ~waters(structure) & _one_altloc(structure)
    outside[used] = False
    points = np.concatenate(
        [c.length_A * c.rod.centerline(4 * len(fold.hairpin.loop)) for c in fold.candidates]
    )
    rows = np.flatnonzero(outside)
    near = cKDTree(points).query(local[rows], distance_upper_bound=_NEIGHBOURHOOD_A)[0]
    rows = rows[np.isfinite(near)]
    return local[rows], np.isin(element[rows], ["N", "O"])


WATER: Final = ("HOH", "DOD", "WAT", "SOL", "H2O", "TIP", "TIP3", "TIP4")


def waters(structure: Structure) -> NDArray[np.bool_]:
    """Which atoms are water: it gives way to the loop, and was placed with the file's own one."""
    names = np.asarray(structure.universe.atoms.resnames, dtype=object).astype(str)
    return np.isin(np.char.strip(names), WATER)


def _one_altloc(structure: Structure) -> NDArray[np.bool_]:
    """Leave one of the alternative locations: the one the nucleotides were read from, else A."""
    atoms = structure.universe.atoms
    altloc = np.asarray(getattr(atoms, "altLocs", np.zeros(len(atoms), "U1")), dtype=object)
    altloc = np.char.strip(altloc.astype(str))
    chosen = np.full(len(structure.universe.residues), "A", dtype=altloc.dtype)
    table = structure.nucleotides.atom_index
    read = table[table >= 0]
    read = read[altloc[read] != ""]
    chosen[atoms.resindices[read]] = altloc[read]
    return np.asarray((altloc == "") | (altloc == chosen[atoms.resindices]))


def elements(structure: Structure) -> NDArray[np.str_]:
    """Element of every atom, from its name (the file may have none)."""
    names = np.asarray(structure.universe.atoms.names, dtype=object).astype(str)
    return np.array([name.strip().lstrip("0123456789")[:1].upper() for name in names])


def _candidate(
    site: _Site,
    fold: LoopFold,
    candidate: Candidate,
    contact: str | None,
    tries: int,
    max_steps: int,
    max_seconds: float,
) -> AtomModel:
    assert fold.ends is not None
    residues = site.molecule.residues
    n = len(residues)
    line = Line.between(
        candidate.rod, fold.ends, ideal_strand(fold.hairpin.is_dna), candidate.length_A, n
    )
    combinations = turned(
        [r.letter for r in residues],
        [r.is_dna for r in residues],
        line,
        site.stem,
        contact=contact,
        keep=max(tries, 3),
    )
    centers = line.at(np.arange(1, n + 1))[0]
    best: tuple[tuple[bool, float], Turns, Array, Relaxed, Checks] | None = None
    for attempt, line_sd in enumerate(LINE_SD_A):
        for turns in combinations[:tries]:
            start = _start(site, line, turns)
            moved = _moved_out(site, start) if attempt else np.zeros((n, 3))
            relaxed = _minimum(
                site, centers + moved, line_sd, _shifted(site, start, moved), max_steps, max_seconds
            )
            checks = check(site.molecule, site.geometry, relaxed.positions_A, site.around,
                           centers, start)  # fmt: skip
            # chemistry first, then the strain that is left against what stacking has gained
            order = (not checks.sound, 0.1 * sum(relaxed.cost.values()) + turns.score)
            if best is None or order < best[0]:
                best = order, turns, start, relaxed, checks
        if best is not None and best[-1].sound:
            break
    assert best is not None
    _, turns, start, relaxed, checks = best
    out = relaxed.positions_A @ site.frame.T + site.origin
    for row, at in site.file_rows.items():
        out[row] = at
    return AtomModel(
        candidate.rank,
        site.molecule,
        out,
        turns,
        tuple(t for t in combinations if t is not turns),
        start @ site.frame.T + site.origin,
        relaxed,
        checks,
        _rmsd_A(site, out),
    )


def _rmsd_A(site: _Site, positions: Array) -> float | None:
    molecule = site.molecule
    own = np.array(
        [
            [positions[molecule.index(k, name)] for name in BACKBONE]
            for k in range(len(molecule.residues))
        ]
    )
    away = ((own - site.native) ** 2).sum(axis=-1)
    return float(np.sqrt(away.mean())) if np.isfinite(away).all() else None


def _start(site: _Site, line: Line, turns: Turns) -> Array:
    """Positions (N, 3) on the line, Ω and χ as in `turns`."""
    molecule = site.molecule
    n = len(molecule.residues)
    at: dict[tuple[int, str], Array] = {}
    for k, residue in enumerate(molecule.residues):
        omega, chi = turns.omega_deg[k], turns.chi_change_deg[k]
        nucleoside = place(residue.letter, residue.is_dna, line, k + 1, omega, chi)
        at |= {(k, name): position for name, position in nucleoside.items()}
        # a phosphate lies between two nucleotides and turns half with each
        before = turns.omega_deg[k - 1] if k else 0.0
        half = before + 0.5 * ((omega - before + 180.0) % 360.0 - 180.0)
        at |= {(k, name): p for name, p in _phosphate(residue, line, k + 1, half).items()}
    positions = np.zeros((len(molecule.names), 3))
    for row, key in enumerate(zip(molecule.residue, molecule.names, strict=True)):
        if row in site.fixed:
            positions[row] = site.fixed[row]
        elif key in at:
            positions[row] = at[key]
    _methyls(molecule, positions, at)
    return np.round(positions, _GRID_A)


def _moved_out(site: _Site, start: Array) -> Array:
    """Shifts (n, 3) that take whole nucleotides out of the stem and of each other, Å.

    No atom can pass through a ring once the chemistry is restored; a rigid nucleotide can before.
    """
    n = len(site.molecule.residues)
    owner = np.array(site.molecule.residue)
    atoms = [start[owner == k] for k in range(n)]
    shift = np.zeros((n, 3))
    for _ in range(_PUSHES):
        push = np.zeros((n, 3))
        for k in range(n):
            here = atoms[k] + shift[k]
            for other in [site.around, *(atoms[j] + shift[j] for j in range(n) if abs(j - k) > 1)]:
                between = here[:, None] - other[None]
                apart = np.linalg.norm(between, axis=-1)
                overlap = np.maximum(_PUSH_A - apart, 0.0) / np.maximum(apart, 0.1)
                push[k] += (overlap[..., None] * between).sum(axis=(0, 1))
        size = np.linalg.norm(push, axis=1, keepdims=True)
        if size.max() < 1e-6:
            break
        shift += push * np.minimum(0.05, 0.3 / np.maximum(size, 1e-9))
    return shift


def _shifted(site: _Site, start: Array, shift: Array) -> Array:
    """Positions with every loop nucleotide moved as a whole."""
    out = start.copy()
    rows = site.molecule.loop_atoms
    out[rows] += shift[np.array(site.molecule.residue)[rows]]
    return np.round(out, _GRID_A)


def _phosphate(residue: Residue, line: Line, k: int, omega: float) -> dict[str, Array]:
    """P, OP1 and OP2, each on the line's normal plane at its own phase."""
    strand = ideal_strand(residue.is_dna)
    fibre = fibre_nucleotide(residue.letter, residue.is_dna)
    turn = np.deg2rad(omega)
    out = {}
    for name in ("P", "OP1", "OP2"):
        phase, (x, y) = own_phase(strand, fibre[name])
        point, frame = line.at([k + phase])
        c, s = np.cos(turn), np.sin(turn)
        out[name] = point[0] + frame[0][:, 0] * (c * x - s * y) + frame[0][:, 1] * (s * x + c * y)
    return out


def _methyls(
    molecule: LoopMolecule, positions: Array, known: dict[tuple[int, str], Array]
) -> None:
    """Put atoms that no fibre has (methyl groups) opposite to the other bonds of their carrier."""
    for row, key in enumerate(zip(molecule.residue, molecule.names, strict=True)):
        if not 0 <= key[0] < len(molecule.residues) or key in known:
            continue
        (carrier,) = (a.GetIdx() for a in molecule.mol.GetAtomWithIdx(row).GetNeighbors())
        others = [
            a.GetIdx()
            for a in molecule.mol.GetAtomWithIdx(carrier).GetNeighbors()
            if a.GetIdx() < row
        ]
        away = positions[carrier] - positions[others].mean(axis=0)
        positions[row] = positions[carrier] + 1.5 * away / np.linalg.norm(away)


def _minimum(
    site: _Site, centers: Array, line_sd: float, start: Array, max_steps: int, max_seconds: float
) -> Relaxed:
    """The minimum next to `start`, its sugars in one of the two usual puckers.

    A first minimization, free of any pucker, tells which of the two is nearer for each sugar.
    """
    order = np.array(site.molecule.loop_atoms + sorted(site.fixed))
    whole = np.concatenate([start[order], site.around])
    restraints = _restraints(site, order, centers, line_sd, start)
    relaxed = relax(restraints, whole, max_steps=max_steps, max_seconds=max_seconds)
    place = np.empty((len(order), 3))
    place[order] = relaxed.positions_A[: len(order)]
    phases = np.array([phase for phase, _ in puckers(site.molecule, place)])
    away = np.abs((phases[:, None] - np.array(PUCKERS_DEG) + 180.0) % 360.0 - 180.0)
    wanted = np.array(PUCKERS_DEG)[away.argmin(axis=1)]
    restraints = _restraints(site, order, centers, line_sd, start, wanted)
    relaxed = relax(
        restraints, relaxed.positions_A, max_steps=max_steps, max_seconds=max_seconds
    )
    place[order] = relaxed.positions_A[: len(order)]
    return Relaxed(place, relaxed.status, relaxed.steps, relaxed.cost)


def _restraints(
    site: _Site,
    order: NDArray[np.int64],
    centers: Array,
    line_sd: float,
    start: Array,
    phases_deg: Array | None = None,
) -> Restraints:
    """Everything that is asked of the atoms; `order` puts those that move first."""
    molecule, geometry = site.molecule, site.geometry
    n, moving = len(molecule.residues), molecule.loop_atoms
    new = np.empty(len(order), dtype=np.int64)
    new[order] = np.arange(len(order))
    pairs, outer, outer_sd = outer_distances(geometry)
    chiral, volume = chiral_quads(molecule)
    planar = planar_quads(molecule)
    quads = [
        (chiral, volume, VOLUME_SD_A3),
        (planar, np.zeros(len(planar)), PLANAR_SD_A3),
    ]
    if phases_deg is not None:
        quads.append((*ring_quads(molecule, geometry, phases_deg), PUCKER_SD_A3))
    near, near_A = _near(site, order, len(moving))
    groups = [[new[molecule.index(k, name)] for name in BACKBONE] for k in range(n)]
    return Restraints(
        n_moving=len(moving),
        pairs=new[np.concatenate([geometry.bonds, pairs])],
        length_A=np.concatenate([geometry.length_A, outer]),
        length_sd=np.concatenate([np.full(len(geometry.bonds), BOND_SD_A), outer_sd]),
        quads=new[np.concatenate([q for q, _, _ in quads])],
        volume=np.concatenate([v for _, v, _ in quads]),
        volume_sd=np.concatenate([np.full(len(q), sd) for q, _, sd in quads]),
        groups=np.array(groups),
        center_A=centers,
        center_sd=line_sd,
        tether_A=start[moving],
        tether_sd=TETHER_SD_A,
        near=near,
        near_A=near_A,
    )


def _near(
    site: _Site, order: NDArray[np.int64], n_moving: int
) -> tuple[NDArray[np.int64], Array]:
    """Pairs of atoms that may not overlap, with their least distances."""
    molecule = site.molecule
    apart = separations(molecule)[np.ix_(order, order)]
    polar = np.array([molecule.mol.GetAtomWithIdx(int(row)).GetSymbol() in "NO" for row in order])
    least = nearest_A(polar, polar)
    least = np.where(apart == 3, np.minimum(least, NEAREST_1_4_A), least)
    inside = np.argwhere(np.triu(apart > 2, k=1))
    inside = inside[inside[:, 0] < n_moving]
    # the neighbours of the junctions in the stem are nearer by nature than anything else
    outside = nearest_A(polar[:n_moving], site.around_polar)
    i, j = np.indices(outside.shape)
    return (
        np.concatenate([inside, np.column_stack([i.ravel(), len(order) + j.ravel()])]),
        np.concatenate([least[inside[:, 0], inside[:, 1]], outside.ravel()]),
    )
