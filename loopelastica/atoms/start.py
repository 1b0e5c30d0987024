"""Where the atoms start: on the line, Ω and χ chosen."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica.atoms.carry import Curve, own_phase
from loopelastica.atoms.chemistry import LoopMolecule
from loopelastica.atoms.fibre import fibre_nucleotide
from loopelastica.atoms.measures import rigid_fit
from loopelastica.atoms.site import GRID_A, Site
from loopelastica.atoms.states import place
from loopelastica.atoms.turn import Turns
from loopelastica.molecule.strands import ideal_strand

FEWEST_FITTED: Final = 3


def start_on(site: Site, line: Curve, turns: Turns, given: Array | None = None) -> Array:
    """Positions (N, 3) on the line, Ω and χ as in `turns`; nucleotides in part there completed.

    Parameters
    ----------
    site : Site
        Where the strand is built.
    line : Curve
        What the nucleotides are laid on.
    turns : Turns
        Ω and χ.
    given : (N, 3) array, optional
        Where atoms that are to be built start instead, NaN for those that it leaves open, Å.

    Returns
    -------
    (N, 3) array
        Å.
    """
    molecule = site.molecule
    begun = np.nan if given is None else np.round(given, GRID_A)
    there = np.where(site.moving[:, None], begun, site.fixed_A)
    positions = there.copy()
    for k in molecule.kinds:
        at = _completed(molecule, there, k)
        if at is None and 0 <= k < molecule.n:
            at = _on_line(molecule, line, turns, k)
        for name, place_A in (at or {}).items():
            row = molecule.rows.get((k, name))
            if row is not None and not np.isfinite(positions[row]).all():
                positions[row] = place_A
    _methyls(molecule, positions)
    return np.asarray(np.round(positions, GRID_A), dtype=np.float64)


def _completed(molecule: LoopMolecule, there: Array, k: int) -> dict[str, Array] | None:
    """Atoms of the ideal nucleotide laid on those that are there; None if fewer than three are."""
    kind = molecule.kinds[k]
    fibre = fibre_nucleotide(kind.letter, kind.is_dna)
    known = [
        (fibre[name], there[row])
        for (number, name), row in molecule.rows.items()
        if number == k and name in fibre and np.isfinite(there[row]).all()
    ]
    if len(known) < FEWEST_FITTED:
        return None
    model, target = (np.array(side) for side in zip(*known, strict=True))
    rotation, shift = rigid_fit(model, target)
    return {name: rotation @ at + shift for name, at in fibre.items()}


def _on_line(molecule: LoopMolecule, line: Curve, turns: Turns, k: int) -> dict[str, Array]:
    """Atoms of nucleotide k on the line."""
    kind = molecule.kinds[k]
    omega, chi = turns.omega_deg[k], turns.chi_change_deg[k]
    c2_endo = turns.c2_endo[k] if turns.c2_endo else kind.is_dna
    # a phosphate lies between two nucleotides and turns half with each
    before = turns.omega_deg[k - 1] if k else 0.0
    half = before + 0.5 * ((omega - before + 180.0) % 360.0 - 180.0)
    nucleoside = place(kind.letter, kind.is_dna, line, k + 1, omega, chi, c2_endo)
    return nucleoside | _phosphate(c2_endo, line, k + 1, half)


def _phosphate(c2_endo: bool, line: Curve, k: int, omega: float) -> dict[str, Array]:
    """P, OP1 and OP2, each on the line's normal plane at its own phase."""
    names = ("P", "OP1", "OP2")
    phases, local = _own_phases(c2_endo, names)
    points, frames = line.at(k + phases)
    c, s = np.cos(np.deg2rad(omega)), np.sin(np.deg2rad(omega))
    across = local @ np.array([[c, s], [-s, c]])
    return dict(zip(names, points + (frames[:, :, :2] @ across[:, :, None])[..., 0], strict=True))


@lru_cache
def _own_phases(b_form: bool, names: tuple[str, ...]) -> tuple[Array, Array]:
    """Phases (a,) and places (a, 2) of atoms that every nucleotide has; see :func:`own_phase`."""
    fibre = fibre_nucleotide("A", b_form)
    phases, local = zip(*(own_phase(ideal_strand(b_form), fibre[x]) for x in names), strict=True)
    return np.array(phases), np.array(local)


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
