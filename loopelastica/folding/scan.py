"""All clamps a stem allows, all equilibria of each: what the rule leaves out.

Neither energy nor anything else that has been tried chooses among clamps better than the rule of
:mod:`loopelastica.molecule.clamp_rule`. The scan shows what there is to choose from. How far its
candidates lie apart is the one blind sign of an error that has been found (Spearman 0.56 over the
RNA loops of the evidence, part of it the length of the loop).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from loopelastica._arrays import Array
from loopelastica.errors import StructureError
from loopelastica.folding.fold import (
    PERSISTENCE_LENGTH_A,
    TAPER_MAX,
    clamping_of,
    native_backbone,
)
from loopelastica.folding.rank import Candidate, rank
from loopelastica.molecule.clamp_rule import RNA_TAPER, default_clamp, expected_rmsd_A, plain_clamp
from loopelastica.molecule.contacts import stem_atoms
from loopelastica.molecule.ends import StemEnds, placed_stem
from loopelastica.molecule.hairpins import Hairpin, find_hairpins
from loopelastica.molecule.nucleotides import Nucleotides, read_structure
from loopelastica.rod.equilibria import equilibria

if TYPE_CHECKING:
    import os

    from MDAnalysis import Universe

EXTEND_5_MAX = 2
EXTEND_3_MAX = 3
# fewer free nucleotides than two leave the rod nothing to choose
FREE_MIN = 2


@dataclass(frozen=True, slots=True, eq=False)
class Clamped:
    """One equilibrium of one clamp.

    Attributes
    ----------
    candidate : Candidate
        The shape; ``rank`` is its place in the scan by E/K0.
    ends : StemEnds
        The clamp.
    rank_by_EL : int
        Its place by E·L/K0, which does not favour long rods.
    is_rule : bool
        Whether this is the clamp of the rule.
    """

    candidate: Candidate
    ends: StemEnds
    rank_by_EL: int
    is_rule: bool


@dataclass(frozen=True, slots=True, eq=False)
class LoopScan:
    """The scan of one loop, first model.

    Attributes
    ----------
    hairpin : Hairpin
        What was scanned.
    candidates : tuple of Clamped
        By E/K0, those that touch nothing first; empty if ``failure`` says why.
    spread_A : float
        Root mean square distance of the traces from their mean, over the lowest equilibrium of each
        clamp with at most (1, 2) extensions; 0 where there is only one.
    failure : str or None
        One sentence, or None.
    """

    hairpin: Hairpin
    candidates: tuple[Clamped, ...]
    spread_A: float = 0.0
    failure: str | None = None

    @property
    def expected_rmsd_A(self) -> tuple[float, float]:
        """Median and 90 % of the rule's error for loops of this length, Å."""
        return expected_rmsd_A(len(self.hairpin))


def scan(
    path_or_universe: "str | os.PathLike[str] | Universe",
    *,
    extend_5_max: int = EXTEND_5_MAX,
    extend_3_max: int = EXTEND_3_MAX,
    tapers: Sequence[float] = (0.0, RNA_TAPER),
    length_per_nucleotide_A: float | None = None,
    free_spin: bool = True,
    torsion_ratio: float = 1.0,
    persistence_length_A: float = PERSISTENCE_LENGTH_A,
    irregular: bool = False,
    pair: str | Sequence[str] = (),
    dot_bracket: str | None = None,
    loop: str | Sequence[str] = (),
) -> list[LoopScan]:
    """Solve every feasible clamp of every loop (first model) and rank all by energy.

    Parameters
    ----------
    path_or_universe : path or MDAnalysis.Universe
        As for :func:`loopelastica.fold`.
    extend_5_max, extend_3_max : int
        Most nucleotides laid on the continued strands.
    tapers : sequence of float
        Tapers of the 3' strand.
    length_per_nucleotide_A, free_spin, torsion_ratio, persistence_length_A, irregular
        As for :func:`loopelastica.fold`.
    pair, dot_bracket, loop
        As for :func:`loopelastica.find_hairpins`.

    Returns
    -------
    list of LoopScan
        One per hairpin, in file order.

    Raises
    ------
    StructureError
        If the file cannot be read or holds no nucleic acid.
    ValueError
        If an option is out of range.
    """
    if min(extend_5_max, extend_3_max) < 0:
        raise ValueError("`extend_5_max` and `extend_3_max` must be 0 or more")
    if not tapers or not all(0.0 <= taper <= TAPER_MAX for taper in tapers):
        raise ValueError(
            f"`tapers` {tuple(tapers)} must be one or more values from 0 to {TAPER_MAX}"
        )
    structure = read_structure(path_or_universe)
    positions = structure.positions(0)
    options = {
        "grid": list(product(range(extend_5_max + 1), range(extend_3_max + 1), tapers)),
        "length_per_nucleotide_A": length_per_nucleotide_A,
        "free_spin": free_spin,
        "torsion_ratio": torsion_ratio,
        "persistence_length_A": persistence_length_A,
        "irregular": irregular,
    }
    hairpins = find_hairpins(structure, pair=pair, dot_bracket=dot_bracket, loop=loop)
    return [
        _scan_loop(structure.nucleotides, hairpin, positions, **options) for hairpin in hairpins
    ]


def _scan_loop(
    nucleotides: Nucleotides, hairpin: Hairpin, positions: Array, **options: Any
) -> LoopScan:
    name = "–".join(hairpin.closing_pair)
    try:
        stem = placed_stem(nucleotides, hairpin, positions)
        plain = plain_clamp(hairpin.is_dna)
        if options["length_per_nucleotide_A"] is not None:
            plain = replace(plain, length_per_nucleotide_A=options["length_per_nucleotide_A"])
        if not options["irregular"]:
            stem.ends(plain).check_regular(name)
        rule = stem.feasible(
            replace(
                default_clamp(hairpin.is_dna, len(hairpin)),
                length_per_nucleotide_A=plain.length_per_nucleotide_A,
            )
        ).clamp
    except StructureError as error:
        return LoopScan(hairpin, (), failure=str(error))
    backbone_A = native_backbone(nucleotides, hairpin, positions)
    atoms = stem_atoms(nucleotides, hairpin, positions)
    found = []
    for extend_5, extend_3, taper in options["grid"]:
        if len(hairpin) - extend_5 - extend_3 < FREE_MIN:
            continue
        clamp = replace(plain, stem_extend_5=extend_5, stem_extend_3=extend_3, taper=taper)
        try:
            ends = stem.ends(clamp).check_reach(name)
        except StructureError:
            continue  # the rod does not span these ends
        rods = equilibria(
            clamping_of(ends, options["free_spin"]), options["torsion_ratio"], rounds=1
        )
        found += [
            (candidate, ends)
            for candidate in rank(
                rods,
                ends,
                options["persistence_length_A"],
                atoms,
                None if backbone_A is None else backbone_A[1:-1],
            )
        ]
    spread_A = _spread_A([c.trace for c, ends in found if c.rank == 1 and _near(ends)])
    return LoopScan(hairpin, _ranked(found, rule), spread_A)


def _ranked(found: list[tuple[Candidate, StemEnds]], rule: Any) -> tuple[Clamped, ...]:
    by_E = sorted(found, key=lambda f: (f[0].contacts.touching, f[0].energy_per_A))
    by_EL = sorted(by_E, key=lambda f: (f[0].contacts.touching, f[0].rod.energy))
    place = {id(candidate): k for k, (candidate, _) in enumerate(by_EL, start=1)}
    return tuple(
        Clamped(replace(candidate, rank=k), ends, place[id(candidate)], ends.clamp == rule)
        for k, (candidate, ends) in enumerate(by_E, start=1)
    )


def _near(ends: StemEnds) -> bool:
    return ends.clamp.stem_extend_5 <= 1 and ends.clamp.stem_extend_3 <= 2


def _spread_A(traces: list[Array]) -> float:
    if len(traces) < 2:
        return 0.0
    deviations = np.array(traces) - np.mean(traces, axis=0)
    return float(np.sqrt((deviations**2).sum(axis=2).mean()))
