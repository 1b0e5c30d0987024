"""All clamps a stem allows, all equilibria of each: what the rule leaves out.

Neither energy nor anything else that has been tried chooses among clamps better than the rule of
:mod:`loopelastica.molecule.clamp_rule`. The scan shows what there is to choose from. How far its
candidates lie apart is the one blind sign of an error that has been found (Spearman 0.56 over the
RNA loops of the evidence, part of it the length of the loop).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from loopelastica._arrays import Array, Record
from loopelastica._html import html_line, html_table
from loopelastica.errors import StructureError
from loopelastica.folding.clamping import clamping_of
from loopelastica.folding.hypotheses import straight_rods
from loopelastica.folding.options import ScanOptions, keywords
from loopelastica.folding.rank import Candidate, rank
from loopelastica.molecule.clamp_rule import StemClamp, default_clamp, expected_rmsd_A, plain_clamp
from loopelastica.molecule.contacts import stem_atoms
from loopelastica.molecule.ends import FittedStem, StemEnds, fit_stem
from loopelastica.molecule.hairpins import Hairpin, find_hairpins
from loopelastica.molecule.nucleotides import Nucleotides, read_structure
from loopelastica.molecule.trace import native_backbone
from loopelastica.rod.equilibria import equilibria

# fewer free nucleotides than two leave the rod nothing to choose
FREE_MIN = 2


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ScannedCandidate(Record):
    """One equilibrium of one clamp.

    Attributes
    ----------
    candidate : Candidate
        The shape; ``rank`` is its place in the scan by E/K0.
    ends : StemEnds
        The ends it is clamped to.
    rank_by_EL : int
        Its place by E·L/K0, which does not favour long rods.
    is_rule : bool
        Whether this is the clamp of the rule.
    """

    candidate: Candidate
    ends: StemEnds
    rank_by_EL: int
    is_rule: bool

    def __repr__(self) -> str:
        clamp, shape = self.ends.clamp, self.candidate
        return (
            f"<ScannedCandidate {shape.rank}, extensions {clamp.stem_extend_5} and"
            f" {clamp.stem_extend_3}, taper {clamp.taper:g}: {shape.summary}>"
        )


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class LoopScan(Record):
    """The scan of one loop, first model.

    Attributes
    ----------
    hairpin : Hairpin
        What was scanned.
    candidates : tuple of ScannedCandidate
        By E/K0, those that touch nothing first; empty if ``failure`` says why.
    spread_A : float
        Root mean square distance of the traces from their mean, over the lowest equilibrium of each
        clamp with at most (1, 2) extensions; 0 where there is only one.
    failure : str or None
        One sentence, or None.
    file : str or None
        The path as it was given; None of a Universe.

    Examples
    --------
    >>> import loopelastica as le
    >>> from loopelastica._files import data_path
    >>> (loop,) = le.scan(data_path("hairpins/2koc.pdb"), extend_5_max=0, extend_3_max=1)
    >>> sum(one.is_rule for one in loop.candidates), loop.expected_rmsd_A
    (3, (1.9, 3.6))
    """

    hairpin: Hairpin
    candidates: tuple[ScannedCandidate, ...]
    spread_A: float = 0.0
    failure: str | None = None
    file: str | None = None

    @property
    def expected_rmsd_A(self) -> tuple[float, float]:
        """Median and 90 % of the rule's error for loops of this length, Å."""
        return expected_rmsd_A(len(self.hairpin))

    def _repr_html_(self) -> str:
        """A table of the shapes, for notebooks."""
        title = f"{self.hairpin.name}, {self.hairpin.sequence}, {self.hairpin.label}"
        if self.failure is not None:
            return html_line(f"{title}: {self.failure}")
        names = ("rank", "by E·L", "extensions", "taper", "E/K0 (1/Å)", "RMSD (Å)", "touches")
        rows = [
            (
                f"{one.candidate.rank}{' (rule)' if one.is_rule else ''}",
                one.rank_by_EL,
                f"{one.ends.clamp.stem_extend_5}, {one.ends.clamp.stem_extend_3}",
                f"{one.ends.clamp.taper:g}",
                f"{one.candidate.energy_per_A:.4f}",
                None if one.candidate.rmsd_A is None else f"{one.candidate.rmsd_A:.2f}",
                one.candidate.contacts.touched,
            )
            for one in self.candidates
        ]
        return html_table(f"{title}, spread {self.spread_A:.2f} Å", names, rows)

    def __repr__(self) -> str:
        about = f"<LoopScan {self.hairpin.name} {self.hairpin.sequence}:"
        if self.failure is not None:
            return f"{about} {self.failure}>"
        return f"{about} {len(self.candidates)} candidates, spread {self.spread_A:.2f} Å>"


@keywords(ScanOptions)
def scan(structure: Any, options: ScanOptions) -> list[LoopScan]:
    """Solve every feasible clamp of every loop (first model) and rank all by energy, touching last.

    Parameters
    ----------
    structure : path, MDAnalysis.Universe or MDAnalysis.AtomGroup
        As for :func:`loopelastica.fold`.
    {options}

    Returns
    -------
    list of LoopScan
        One per hairpin, in file order.

    Raises
    ------
    StructureError
        If the file cannot be read or holds no nucleic acid.
    ValueError
        If an option is out of range; TypeError if there is no option of that name.

    Examples
    --------
    >>> from loopelastica._files import data_path
    >>> (loop,) = scan(data_path("hairpins/2koc.pdb"), extend_5_max=1, extend_3_max=1)
    >>> print(f"{len(loop.candidates)} candidates, spread {loop.spread_A:.1f} Å")
    19 candidates, spread 1.5 Å
    """
    structure = read_structure(structure, options.limits)
    hairpins = find_hairpins(structure, **options.selection)
    positions = structure.positions(0)
    return [
        replace(
            scan_loop(structure.nucleotides, hairpin, positions, options), file=structure.source
        )
        for hairpin in hairpins
    ]


def scan_loop(
    nucleotides: Nucleotides, hairpin: Hairpin, positions: Array, options: ScanOptions
) -> LoopScan:
    """Scan one hairpin in one model.

    Parameters
    ----------
    nucleotides, hairpin, positions
        As for :func:`loopelastica.folding.fold.fold_model`.
    options : ScanOptions
        As for :func:`scan`.

    Returns
    -------
    LoopScan
        A loop that cannot be scanned says why in ``failure``.
    """
    try:
        stem = fit_stem(nucleotides, hairpin, positions)
        plain, rule = _plain_and_rule(stem, options)
    except StructureError as error:
        return LoopScan(hairpin, (), failure=str(error))
    backbone_A = native_backbone(nucleotides, hairpin, positions)
    atoms = stem_atoms(nucleotides, hairpin, positions)
    found = []
    for ends in _feasible(stem, plain, options):
        clamping = clamping_of(ends, options.free_spin)
        rods = equilibria(clamping, options.torsion_ratio, rounds=1)
        answers = straight_rods(hairpin, rods, ends)
        candidates = rank(answers, options.persistence_length_A, atoms, backbone_A)
        found += [(candidate, ends) for candidate in candidates]
    spread_A = _spread_A([c.trace for c, ends in found if c.rank == 1 and _near(ends)])
    return LoopScan(hairpin, _ranked(found, rule), spread_A)


def _plain_and_rule(stem: FittedStem, options: ScanOptions) -> tuple[StemClamp, StemClamp]:
    """The clamp at the closing pair and that of the rule, with the length per nucleotide given."""
    hairpin = stem.hairpin
    plain, rule = plain_clamp(hairpin.is_dna), default_clamp(hairpin.is_dna, len(hairpin))
    if options.length_per_nucleotide_A is not None:
        length_A = options.length_per_nucleotide_A
        plain, rule = (replace(c, length_per_nucleotide_A=length_A) for c in (plain, rule))
    if not options.irregular:
        stem.ends(plain).check_regular(hairpin.label)
    return plain, stem.feasible(rule).clamp


def _feasible(stem: FittedStem, plain: StemClamp, options: ScanOptions) -> Iterator[StemEnds]:
    """The ends of every clamp that a rod of its length spans."""
    most = len(stem.hairpin) - FREE_MIN
    extend_5 = range(min(options.extend_5_max, most) + 1)
    extend_3 = range(min(options.extend_3_max, most) + 1)
    for five, three, taper in product(extend_5, extend_3, options.tapers):
        if five + three > most:
            continue
        clamp = replace(plain, stem_extend_5=five, stem_extend_3=three, taper=taper)
        try:
            yield stem.ends(clamp).check_reach(stem.hairpin.label)
        except StructureError:
            continue


def _ranked(
    found: list[tuple[Candidate, StemEnds]], rule: StemClamp
) -> tuple[ScannedCandidate, ...]:
    by_E = sorted(found, key=lambda f: (f[0].contacts.touching, f[0].energy_per_A))
    by_EL = sorted(by_E, key=lambda f: (f[0].contacts.touching, f[0].line.energy))
    place = {id(candidate): k for k, (candidate, _) in enumerate(by_EL, start=1)}
    return tuple(
        ScannedCandidate(
            replace(candidate, rank=k, rank_energy=k),
            ends,
            place[id(candidate)],
            ends.clamp == rule,
        )
        for k, (candidate, ends) in enumerate(by_E, start=1)
    )


def _near(ends: StemEnds) -> bool:
    return ends.clamp.stem_extend_5 <= 1 and ends.clamp.stem_extend_3 <= 2


def _spread_A(traces: list[Array]) -> float:
    if len(traces) < 2:
        return 0.0
    deviations = np.array(traces) - np.mean(traces, axis=0)
    return float(np.sqrt((deviations**2).sum(axis=2).mean()))
