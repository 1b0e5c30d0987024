"""From a folded line to atoms: carry, turn, restore, check.

    candidate → line with directors → Ω and χ → start → minimum → checks

Everything is computed in the frame of the line's start, rounded there to 1e-6 Å, so that a rigid
motion of the input moves the atoms by the same motion and by nothing else.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import Any, Final

import numpy as np

from loopelastica._arrays import Array, Record
from loopelastica._checks import array, optional, positive, shown, whole
from loopelastica.atoms.carry import Line
from loopelastica.atoms.checks import Checks, check
from loopelastica.atoms.chemistry import LoopMolecule
from loopelastica.atoms.minimum import minimum
from loopelastica.atoms.relax import Relaxed
from loopelastica.atoms.site import Site, site_of
from loopelastica.atoms.start import moved_out, shifted, start_on
from loopelastica.atoms.turn import Turns, check_contact, turned
from loopelastica.errors import StructureError
from loopelastica.folding.rank import Candidate
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.nucleotides import BACKBONE, read_structure
from loopelastica.molecule.strands import ideal_strand

LINE_SD_A: Final = (0.3, 1.0, 3.0)
"""How near the backbone centroids are held to the line. The next one is for lines from which no
sound model (right hands, whole chain, no clash) has come: a rod has no thickness and may run
through the stem or itself. The nucleotides are then moved out of the way first."""
MOST_TRIES: Final = 12
"""Combinations of Ω and χ that are tried in all where the first ones give no sound model."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class AtomModel(Record):
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

    def __repr__(self) -> str:
        sound = "sound" if self.checks.sound else "not sound"
        rmsd = "" if self.rmsd_A is None else f", RMSD {self.rmsd_A:.2f} Å"
        return f"<AtomModel {self.rank}: {len(self.positions_A)} atoms, {sound}{rmsd}>"


def build_atoms(
    structure: Any,
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
    structure : path, MDAnalysis.Universe, MDAnalysis.AtomGroup or Structure
        What was folded.
    fold : LoopFold
        One of its loops.
    model : int
        Model that `positions` are taken from, counted from 0; `fold` is of the first one.
    positions : (n_atoms, 3) array, optional
        Of all atoms, Å; default those of `model`.
    contact : {"sheared", "watson-crick"}, optional
        Contact across the loop to be sought; see :func:`loopelastica.atoms.turn.turned`.
    tries : int
        Combinations of Ω and χ minimized per candidate; the best minimum is kept. More are tried
        (up to `MOST_TRIES`) where none of these gives a sound model.
    max_steps, max_seconds : int, float
        Limits of each minimization; how it ended is in ``relaxed.status``.
    max_candidates : int, optional
        Only the first ones.
    progress : callable, optional
        Called with (done, total) after each candidate.

    Returns
    -------
    list of AtomModel
        One per candidate.

    Raises
    ------
    StructureError
        If the loop was not folded, a loop nucleotide has no known base, or an atom that a junction
        needs is missing.
    ValueError
        If an option is out of range.

    Examples
    --------
    >>> import loopelastica as le
    >>> from loopelastica._files import data_path
    >>> (loop,) = le.fold(data_path("hairpins/2koc.pdb"), all_models=False)
    >>> build_atoms(data_path("hairpins/2koc.pdb"), loop, max_candidates=1)
    [<AtomModel 1: 90 atoms, sound, RMSD 2.34 Å>]
    """
    tries, max_steps = whole(1)("tries", tries), whole(1)("max_steps", max_steps)
    max_candidates = optional(whole(1))("max_candidates", max_candidates)
    max_seconds, model = positive("max_seconds", max_seconds), whole(0)("model", model)
    check_contact(contact)
    if not isinstance(fold, LoopFold):
        raise ValueError(f"`fold` is {shown(fold)}; it must be one of the loops that were folded")
    if fold.ends is None or not fold.candidates:
        raise StructureError(fold.failure or "the loop was not folded; it gets no atoms")
    structure = read_structure(structure, fold.options.limits)
    if positions is None:
        positions = structure.positions(model)
    else:
        positions = array("positions", positions)
        if positions.shape != (len(structure.universe.atoms), 3):
            raise ValueError(
                f"`positions` has shape {positions.shape}; it must be"
                f" ({len(structure.universe.atoms)}, 3)"
            )
        structure.check(positions, model)
    site = site_of(structure, fold, positions)
    chosen = fold.candidates[:max_candidates]
    models = []
    for done, candidate in enumerate(chosen, start=1):
        models.append(_candidate(site, fold, candidate, contact, tries, max_steps, max_seconds))
        if progress is not None:
            progress(done, len(chosen))
    return models


def _candidate(
    site: Site,
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
    line = Line.between(candidate.rod, fold.ends, ideal_strand(fold.hairpin.is_dna))
    combinations = turned(
        [r.letter for r in residues],
        [r.is_dna for r in residues],
        line,
        site.stem,
        contact=contact,
        keep=max(tries, MOST_TRIES),
    )
    centers = line.at(np.arange(1, n + 1))[0]
    best: tuple[tuple[bool, float], Turns, Array, Relaxed, Checks] | None = None
    rounds = product((combinations[:tries], combinations[tries:]), enumerate(LINE_SD_A))
    for chosen, (attempt, line_sd) in rounds:
        for turns in chosen:
            start = start_on(site, line, turns)
            moved = moved_out(site, start) if attempt else np.zeros((n, 3))
            relaxed = minimum(
                site, centers + moved, line_sd, shifted(site, start, moved), max_steps, max_seconds
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
        tuple(t for t in combinations[: max(tries, 3)] if t is not turns),
        start @ site.frame.T + site.origin,
        relaxed,
        checks,
        _rmsd_A(site, out),
    )


def _rmsd_A(site: Site, positions: Array) -> float | None:
    molecule = site.molecule
    own = np.array(
        [
            [positions[molecule.index(k, name)] for name in BACKBONE]
            for k in range(len(molecule.residues))
        ]
    )
    away = ((own - site.native) ** 2).sum(axis=-1)
    return float(np.sqrt(away.mean())) if np.isfinite(away).all() else None
