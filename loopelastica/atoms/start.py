"""Where the atoms start: on the line, Ω and χ chosen, moved out of the stem where they must."""

from __future__ import annotations

from typing import Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.atoms.carry import Curve, own_phase
from loopelastica.atoms.chemistry import LoopMolecule, Residue
from loopelastica.atoms.fibre import fibre_nucleotide
from loopelastica.atoms.measures import rigid_fit
from loopelastica.atoms.site import GRID_A, Site
from loopelastica.atoms.turn import Turns, place
from loopelastica.molecule.strands import ideal_strand

FEWEST_FITTED: Final = 3
_PUSHES: Final = 100
_PUSH_A: Final = 3.5


def start_on(site: Site, line: Curve, turns: Turns) -> Array:
    """Positions (N, 3) on the line, Ω and χ as in `turns`; nucleotides in part there completed.

    Parameters
    ----------
    site : Site
        Where the strand is built.
    line : Curve
        What the nucleotides are laid on.
    turns : Turns
        Ω and χ.

    Returns
    -------
    (N, 3) array
        Å.
    """
    molecule = site.molecule
    positions = np.where(site.moving[:, None], np.nan, site.fixed_A)
    for k in molecule.kinds:
        at = _completed(site, k)
        if at is None and 0 <= k < molecule.n:
            at = _on_line(molecule, line, turns, k)
        for name, place_A in (at or {}).items():
            row = molecule.rows.get((k, name))
            if row is not None and site.moving[row]:
                positions[row] = place_A
    _methyls(molecule, positions)
    return np.asarray(np.round(positions, GRID_A), dtype=np.float64)


def _completed(site: Site, k: int) -> dict[str, Array] | None:
    """Atoms of the ideal nucleotide laid on those that are there; None if fewer than three are."""
    kind = site.molecule.kinds[k]
    fibre = fibre_nucleotide(kind.letter, kind.is_dna)
    there = [
        (fibre[name], site.fixed_A[row])
        for (number, name), row in site.molecule.rows.items()
        if number == k and name in fibre and not site.moving[row]
    ]
    if len(there) < FEWEST_FITTED:
        return None
    model, target = (np.array(side) for side in zip(*there, strict=True))
    rotation, shift = rigid_fit(model, target)
    return {name: rotation @ at + shift for name, at in fibre.items()}


def _on_line(molecule: LoopMolecule, line: Curve, turns: Turns, k: int) -> dict[str, Array]:
    """Atoms of nucleotide k on the line."""
    kind = molecule.kinds[k]
    omega, chi = turns.omega_deg[k], turns.chi_change_deg[k]
    # a phosphate lies between two nucleotides and turns half with each
    before = turns.omega_deg[k - 1] if k else 0.0
    half = before + 0.5 * ((omega - before + 180.0) % 360.0 - 180.0)
    return place(kind.letter, kind.is_dna, line, k + 1, omega, chi) | _phosphate(
        kind, line, k + 1, half
    )


def moved_out(site: Site, start: Array) -> Array:
    """Shifts (n, 3) that take whole nucleotides out of the stem and of each other, Å.

    No atom can pass through a ring once the chemistry is restored; a rigid nucleotide can before.

    Parameters
    ----------
    site : Site
        Where the loop is built.
    start : (N, 3) array
        Positions, Å.

    Returns
    -------
    (n, 3) array
    """
    n = len(site.molecule.residues)
    owner = np.array(site.molecule.residue)
    atoms = [start[owner == k] for k in range(n)]
    shift = np.zeros((n, 3))
    for _ in range(_PUSHES):
        push = np.zeros((n, 3))
        for k in range(n):
            here = atoms[k] + shift[k]
            for other in [
                site.around.positions_A,
                *(atoms[j] + shift[j] for j in range(n) if abs(j - k) > 1),
            ]:
                between = here[:, None] - other[None]
                apart = np.linalg.norm(between, axis=-1)
                overlap = np.maximum(_PUSH_A - apart, 0.0) / np.maximum(apart, 0.1)
                push[k] += (overlap[..., None] * between).sum(axis=(0, 1))
        size = np.linalg.norm(push, axis=1, keepdims=True)
        if size.max() < 1e-6:
            break
        shift += push * np.minimum(0.05, 0.3 / np.maximum(size, 1e-9))
    return shift


def shifted(site: Site, start: Array, shift: Array) -> Array:
    """Positions with every loop nucleotide moved as a whole.

    Parameters
    ----------
    site : Site
        Where the loop is built.
    start : (N, 3) array
        Positions, Å.
    shift : (n, 3) array
        Of each loop nucleotide, Å.

    Returns
    -------
    (N, 3) array
        Å.
    """
    out = start.copy()
    rows = [row for row in site.molecule.loop_atoms if site.moving[row]]
    out[rows] += shift[np.array(site.molecule.residue)[rows]]
    return np.round(out, GRID_A)


def _phosphate(residue: Residue, line: Curve, k: int, omega: float) -> dict[str, Array]:
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


def _methyls(molecule: LoopMolecule, positions: Array) -> None:
    """Put atoms that have no place yet (methyl groups) opposite to the bonds of their carrier."""
    for row in np.flatnonzero(~np.isfinite(positions).all(axis=1)):
        (carrier,) = (a.GetIdx() for a in molecule.mol.GetAtomWithIdx(int(row)).GetNeighbors())
        others = [
            a.GetIdx()
            for a in molecule.mol.GetAtomWithIdx(carrier).GetNeighbors()
            if np.isfinite(positions[a.GetIdx()]).all()
        ]
        away = positions[carrier] - positions[others].mean(axis=0)
        positions[row] = positions[carrier] + 1.5 * away / np.linalg.norm(away)
