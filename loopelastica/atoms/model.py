"""From a folded line to atoms: carry, turn, restore, check.

    candidate → line with directors → Ω and χ → start → minimum → checks

Everything is computed in the frame of the line's start, rounded there to 1e-6 Å, so that a rigid
motion of the input moves the atoms by the same motion and by nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from loopelastica._arrays import Array, Record
from loopelastica._checks import array, keywords_known, optional, positive, shown, whole
from loopelastica.atoms.carry import curve_on
from loopelastica.atoms.checks import Checks
from loopelastica.atoms.chemistry import LoopMolecule
from loopelastica.atoms.graft import grafts
from loopelastica.atoms.relax import Relaxed
from loopelastica.atoms.search import Limits, best_from, best_on
from loopelastica.atoms.site import Site, native_backbone, site_of
from loopelastica.atoms.turn import Turns, check_contact
from loopelastica.errors import StructureError
from loopelastica.folding.rank import Candidate
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.nucleotides import BACKBONE, read_structure
from loopelastica.molecule.strands import Strand, ideal_strand


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
    carried : bool
        Whether sugars and bases began where those of a template were carried to, not on the line.

    Examples
    --------
    >>> import loopelastica as le
    >>> from loopelastica._files import data_path
    >>> (loop,) = le.fold(data_path("hairpins/2koc.pdb"), all_models=False, shapes="rod")
    >>> (model,) = loop.atoms(max_candidates=1)
    >>> model.checks.sound, model.positions_A.shape, round(model.rmsd_A, 2)
    (True, (95, 3), 2.41)
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
    carried: bool = False

    def records(self) -> Iterator[dict[str, Any]]:
        """Give its row, for :func:`loopelastica.to_dataframe`.

        Yields
        ------
        dict
            ``rank``, ``sound``, and what was measured on its atoms.
        """
        from loopelastica.report.atoms import model_row

        yield model_row(self)

    def __repr__(self) -> str:
        sound = "sound" if self.checks.sound else "not sound"
        rmsd = "" if self.rmsd_A is None else f", RMSD {self.rmsd_A:.2f} Å"
        return f"<AtomModel {self.rank}: {len(self.positions_A)} atoms, {sound}{rmsd}>"


@keywords_known
def build_atoms(
    structure: Any,
    fold: LoopFold,
    *,
    model: int = 0,
    positions: Array | None = None,
    contact: str | None = None,
    tries: int = 3,
    max_steps: int = 5000,
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
        Contact of the first and the last loop nucleotide to be sought: its hydrogen bonds are held
        at 2.9 Å; ``checks.contact_A`` says whether they were reached.
    tries : int
        Sound models, of different Ω and χ, that are compared per candidate; the best is kept.
    max_steps : int
        Most steps of a minimization; how it ended is in ``relaxed.status``.
    max_seconds : float
        Time per candidate.
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
    >>> (loop,) = le.fold(data_path("hairpins/2koc.pdb"), all_models=False, shapes="rod")
    >>> build_atoms(data_path("hairpins/2koc.pdb"), loop, max_candidates=1)
    [<AtomModel 1: 95 atoms, sound, RMSD 2.41 Å>]
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
    native = native_backbone(structure, fold, positions)
    limits = Limits(tries, max_steps, max_seconds)
    chosen = fold.candidates[:max_candidates]
    strand = ideal_strand(fold.hairpin.is_dna)
    models, sites = [], dict[bytes, Site]()
    for done, candidate in enumerate(chosen, start=1):
        # lines of one kind begin in one place
        start = candidate.line.start_origin_A.tobytes()
        if start not in sites:
            site = site_of(structure, fold, positions, candidate.line)
            sites[start] = site.seeking(contact)
        built = _candidate(sites[start], candidate, limits, strand)
        models.append(replace(built, rmsd_A=_rmsd_A(built, native)))
        if progress is not None:
            progress(done, len(chosen))
    return models


def _candidate(site: Site, candidate: Candidate, limits: Limits, strand: Strand) -> AtomModel:
    line = curve_on(candidate.line, strand)
    if candidate.carried:
        near = site.given(grafts(site, candidate.carried))
        best, combinations, _ = best_from(site, line, limits, near)
    else:
        best, combinations, _ = best_on(site, line, limits)
    return AtomModel(
        candidate.rank,
        site.molecule,
        site.in_file(best.relaxed.positions_A),
        best.turns,
        tuple(t for t in combinations[: max(limits.tries, 3)] if t is not best.turns),
        best.start_A @ site.frame.T + site.origin,
        best.relaxed,
        best.checks,
        None,
        best.near,
    )


def _rmsd_A(model: AtomModel, native: Array) -> float | None:
    molecule = model.molecule
    rows = [[molecule.index(k, name) for name in BACKBONE] for k in range(molecule.n)]
    away = ((model.positions_A[np.array(rows)] - native) ** 2).sum(axis=-1)
    return float(np.sqrt(away.mean())) if np.isfinite(away).all() else None
