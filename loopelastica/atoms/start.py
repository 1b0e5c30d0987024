"""Where the atoms start: on the line, Ω and χ chosen, moved out of the stem where they must."""

from __future__ import annotations

from typing import Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.atoms.carry import Line, own_phase
from loopelastica.atoms.chemistry import LoopMolecule, Residue
from loopelastica.atoms.fibre import fibre_nucleotide
from loopelastica.atoms.site import GRID_A, Site
from loopelastica.atoms.turn import Turns, place
from loopelastica.molecule.strands import ideal_strand

_PUSHES: Final = 100
_PUSH_A: Final = 3.5


def start_on(site: Site, line: Line, turns: Turns) -> Array:
    """Positions (N, 3) on the line, Ω and χ as in `turns`.

    Parameters
    ----------
    site : Site
        Where the loop is built.
    line : Line
        What the nucleotides are laid on.
    turns : Turns
        Ω and χ.

    Returns
    -------
    (N, 3) array
        Å.
    """
    molecule = site.molecule
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
    return np.round(positions, GRID_A)


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
    rows = site.molecule.loop_atoms
    out[rows] += shift[np.array(site.molecule.residue)[rows]]
    return np.round(out, GRID_A)


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


def _methyls(molecule: LoopMolecule, positions: Array, known: dict[tuple[int, str], Array]) -> None:
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
