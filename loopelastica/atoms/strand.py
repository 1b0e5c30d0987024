"""Atoms for any strand of a chain, and for a nucleotide that lacks some of its own.

``build_strand(gap, line, atoms, *, near=None, contact=None, tries=1, max_steps=5000,
max_seconds=30.0)`` gives a :class:`StrandModel`. `gap` is a
:class:`~loopelastica.molecule.polymer.Gap`, `line` anything with
``at(phases) -> points (m, 3), frames (m, 3, 3)`` in the coordinates of the file (phases 1 … n are
the nucleotides, the curve reaches at least from ½ to n + ½), and `atoms` the
:class:`~loopelastica.molecule.polymer.HeavyAtoms` of the model. No atom that is there moves.
:func:`complete_nucleotide` does the same for one nucleotide beside no gap.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._arrays import Array, Record
from loopelastica._checks import positive, whole
from loopelastica.atoms.carry import Curve, IdealCurve
from loopelastica.atoms.checks import Checks
from loopelastica.atoms.chemistry import LoopMolecule, Residue
from loopelastica.atoms.fibre import fibre_nucleotide
from loopelastica.atoms.gap_site import LocalCurve, gap_site, numbered
from loopelastica.atoms.graft import grafts
from loopelastica.atoms.measures import rigid_fit
from loopelastica.atoms.relax import Relaxed
from loopelastica.atoms.search import Limits, best_from, best_near, best_on
from loopelastica.atoms.start import FEWEST_FITTED
from loopelastica.atoms.turn import Turns
from loopelastica.errors import StructureError
from loopelastica.molecule.polymer import Gap, HeavyAtoms, Monomer
from loopelastica.molecule.strands import ideal_strand

WATER_A: Final = 2.5
"""Waters nearer than this to a built atom have to go."""


@dataclass(frozen=True, slots=True, eq=False)
class BuiltResidue(Record):
    """The built atoms of one nucleotide.

    Attributes
    ----------
    monomer : Monomer
    kind : Residue
        What was built; ``kind.standard`` is its wwPDB name.
    names, elements : tuple of str
    positions_A : (k, 3) array
        In the coordinates of the file, Å.
    """

    monomer: Monomer
    kind: Residue
    names: tuple[str, ...]
    elements: tuple[str, ...]
    positions_A: Array


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class StrandModel(Record):
    """The atoms of a filled strand.

    Attributes
    ----------
    gap : Gap
    molecule : LoopMolecule
        The strand with its flanks.
    positions_A : (N, 3) array
        In the coordinates of the file, rows of the molecule; atoms that were there to the digit.
    built : (N,) array of bool
        Which atoms were not there.
    turns : Turns
        The combination of Ω and χ it started from.
    start_A : (N, 3) array
        Positions before the minimization.
    relaxed : Relaxed
        Status, steps and cost; its positions are in a local frame.
    checks : Checks
    waters : (w,) array of int
        Rows of `atoms`: waters nearer than 2.5 Å to a built atom.
    attempts : int
        Combinations that were minimized.
    near : bool
        Whether it began at atoms that were given, or carried over from a template.
    """

    gap: Gap
    molecule: LoopMolecule
    positions_A: Array
    built: NDArray[np.bool_]
    turns: Turns
    start_A: Array
    relaxed: Relaxed
    checks: Checks
    waters: NDArray[np.int64]
    attempts: int
    near: bool = False

    def __repr__(self) -> str:
        state = "sound" if self.checks.sound else f"not sound ({'; '.join(self.checks.wrong)})"
        return f"<StrandModel {self.gap.name}: {int(self.built.sum())} atoms built, {state}>"

    @property
    def residues(self) -> tuple[BuiltResidue, ...]:
        """Every nucleotide that has got atoms, flanks included, 5' to 3'."""
        monomers = numbered(self.gap)
        out = []
        for k, kind in self.molecule.kinds.items():
            rows = [
                row for row, r in enumerate(self.molecule.residue) if r == k and self.built[row]
            ]
            if rows:
                names = tuple(self.molecule.names[row] for row in rows)
                elements = tuple(self.molecule.mol.GetAtomWithIdx(row).GetSymbol() for row in rows)
                out.append(BuiltResidue(monomers[k], kind, names, elements, self.positions_A[rows]))
        return tuple(out)


def build_strand(
    gap: Gap,
    line: Curve,
    atoms: HeavyAtoms,
    *,
    near: Mapping[str, Mapping[str, Array]] | None = None,
    templates: Sequence[Monomer] = (),
    contact: str | None = None,
    tries: int = 1,
    max_steps: int = 5000,
    max_seconds: float = 30.0,
) -> StrandModel:
    """All atoms that a strand and its flanks lack.

    Parameters
    ----------
    gap : Gap
        What is built, and what it is bonded to.
    line : Curve
        Where the strand runs; a start, not a constraint.
    atoms : HeavyAtoms
        Of the whole model: what must not be run into. Atoms of the strand and its flanks may be
        among them. Waters give way.
    near : mapping of str to mapping of str to (3,) array, optional
        By labels and names of atoms, where atoms are to stay as near as the chemistry allows, Å.
        The line and its turns are then no start, but for atoms that are not named here.
    templates : sequence of Monomer, optional
        One for each nucleotide of the strand, with its atoms: where sugars and bases start. The
        line is searched where this leads to nothing sound.
    contact : {"sheared", "watson-crick"}, optional
        Contact of the first and the last nucleotide to be sought; see :func:`.turn.turned`.
    tries : int
        Sound models that are compared; the best is taken.
    max_steps : int
        Most steps of one minimization.
    max_seconds : float
        Time after which nothing more is tried.

    Returns
    -------
    StrandModel
        Sound, or the one that is nearest to it: ``checks.wrong`` says what is not.

    Raises
    ------
    StructureError
        If a base is unknown or a flank has too few atoms.
    ValueError
        If an option is out of range.
    """
    limits = Limits(
        whole(1)("tries", tries),
        whole(1)("max_steps", max_steps),
        positive("max_seconds", max_seconds),
    )
    site = gap_site(gap, line, atoms).seeking(contact)
    local = LocalCurve(line, site.origin, site.frame)
    if near is not None:
        best, attempts = best_near(site, local, limits, site.given(near))
    elif templates:
        start = site.given(grafts(site, templates))
        best, _, attempts = best_from(site, local, limits, start)
    else:
        best, _, attempts = best_on(site, local, limits)
    positions = site.in_file(best.relaxed.positions_A)
    return StrandModel(
        gap,
        site.molecule,
        positions,
        site.moving,
        best.turns,
        best.start_A @ site.frame.T + site.origin,
        best.relaxed,
        best.checks,
        _waters(atoms, positions[site.moving]),
        attempts,
        best.near,
    )


def complete_nucleotide(
    monomer: Monomer,
    atoms: HeavyAtoms,
    *,
    before: Monomer | None = None,
    after: Monomer | None = None,
    **options: Any,
) -> StrandModel:
    """The atoms that one nucleotide lacks, beside no gap.

    Parameters
    ----------
    monomer : Monomer
        With some atoms.
    atoms : HeavyAtoms
        Of the whole model.
    before, after : Monomer, optional
        Its neighbours in the chain, where they are bonded to it. Without one before it gets no
        phosphate, unless it has one.
    **options
        As for :func:`build_strand`.

    Returns
    -------
    StrandModel

    Raises
    ------
    StructureError
        If it has fewer than three atoms of the ideal nucleotide, lacks none, or its base is
        unknown.
    """
    fibre = fibre_nucleotide(monomer.letter, monomer.is_dna) if monomer.letter in "ACGUT" else {}
    names = [name for name in fibre if np.isfinite(monomer.atoms_A.get(name, np.nan)).all()]
    if len(names) < FEWEST_FITTED:
        raise StructureError(
            f"{monomer.label}: {len(names)} atoms of a known nucleotide; it cannot be completed"
        )
    there = np.array([monomer.atoms_A[name] for name in names])
    curve = IdealCurve(
        ideal_strand(monomer.is_dna), *rigid_fit(np.array([fibre[name] for name in names]), there)
    )
    # a nucleotide at an end of its chain has but one neighbour
    gap = Gap((monomer,), before, after)  # type: ignore[arg-type]
    return build_strand(gap, curve, atoms, **options)


def _waters(atoms: HeavyAtoms, built: Array) -> NDArray[np.int64]:
    from scipy.spatial import cKDTree

    water = np.flatnonzero(atoms.water & np.isfinite(atoms.positions_A).all(axis=1))
    if len(water) == 0 or len(built) == 0:
        return np.empty(0, dtype=np.int64)
    near = cKDTree(built).query(atoms.positions_A[water], distance_upper_bound=WATER_A)[0]
    return np.asarray(water[np.isfinite(near)], dtype=np.int64)
