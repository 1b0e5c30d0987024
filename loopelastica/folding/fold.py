"""The road from a structure to the ranked shapes of its loops.

    file → nucleotides → hairpins → stem ends → clamping → equilibria → candidates

Each arrow is one call below. Only stem atoms reach the clamping; the loop's own coordinates enter
the RMSD and nothing else.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from loopelastica._arrays import Array, read_only
from loopelastica.errors import StructureError
from loopelastica.folding.rank import Candidate, rank
from loopelastica.molecule.clamp_rule import default_clamp
from loopelastica.molecule.contacts import stem_atoms
from loopelastica.molecule.ends import PlacedStem, StemEnds, placed_stem
from loopelastica.molecule.hairpins import Hairpin, find_hairpins
from loopelastica.molecule.nucleotides import (
    Nucleotides,
    Structure,
    centroids_at,
    read_structure,
)
from loopelastica.molecule.selection import as_texts
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibria import equilibria

if TYPE_CHECKING:
    import os

    from MDAnalysis import Universe

# persistence lengths of single strands in print run from 6 Å to several nm; this one only sets
# the scale of energy_kT
PERSISTENCE_LENGTH_A = 10.0

# beyond, the strand would turn straight to its axis
TAPER_MAX = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class LoopFold:
    """The folded loop of one hairpin.

    Attributes
    ----------
    hairpin : Hairpin
        What was folded.
    candidates : tuple of Candidate
        Ranked; empty if ``failure`` says why the loop could not be folded.
    failure : str or None
        One sentence, or None.
    ends : StemEnds or None
        The clamp: frames at both ends, from stem atoms only (first model).
    clamping : Clamping or None
        The same, dimensionless.
    length_A : float
        Length of the rod, Å; ``ends.clamp`` tells how many nucleotides it carries.
    backbone_A : (n_nt + 2, 3) ndarray or None
        Centroids of the file's own backbone, closing nucleotide to closing nucleotide (first
        model); None where the file has no loop. For comparison only.
    parameters : dict
        Every option that was in force.
    model_failures : tuple of str
        One sentence for each further model that could not be folded.
    unseen : float
        Estimate of the chance that the search missed an equilibrium (`Equilibria.unseen`).
    remarks : tuple of str
        One sentence for each thing about this loop that a user should know of.
    """

    hairpin: Hairpin
    candidates: tuple[Candidate, ...]
    parameters: dict[str, Any]
    failure: str | None = None
    ends: StemEnds | None = None
    clamping: Clamping | None = None
    length_A: float = 0.0
    backbone_A: Array | None = None
    model_failures: tuple[str, ...] = field(default=())
    unseen: float = 1.0
    remarks: tuple[str, ...] = field(default=())


def fold(
    path_or_universe: "str | os.PathLike[str] | Universe",
    *,
    free_spin: bool = True,
    torsion_ratio: float = 1.0,
    length_per_nucleotide_A: float | None = None,
    stem_extend_5: int | None = None,
    stem_extend_3: int | None = None,
    taper: float | None = None,
    persistence_length_A: float = PERSISTENCE_LENGTH_A,
    energy_max: float | None = None,
    max_candidates: int = 10,
    all_models: bool = True,
    irregular: bool = False,
    pair: str | Sequence[str] = (),
    dot_bracket: str | None = None,
    loop: str | Sequence[str] = (),
) -> list[LoopFold]:
    """Fold every hairpin loop of a structure as an elastic rod clamped to its stem.

    Parameters
    ----------
    path_or_universe : path or MDAnalysis.Universe
        PDB or mmCIF file (gzipped or not; mmCIF needs the extra ``mmcif``), or a Universe.
    free_spin : bool
        Let the rod's end turn about its tangent; otherwise the direction to the helix axis is
        clamped too and `torsion_ratio` matters.
    torsion_ratio : float
        K3/K0 of the backbone; unmeasured for single strands.
    length_per_nucleotide_A : float, optional
        Line length per loop nucleotide; default 6.0 (RNA) or 6.3 (DNA).
    stem_extend_5, stem_extend_3 : int, optional
        Loop nucleotides laid on the continued 5' and 3' strand of the stem. Default: the rule of
        :mod:`loopelastica.molecule.clamp_rule`, less where the rod could not span its ends.
    taper : float, optional
        Loss of radius per nucleotide of the continued 3' strand, in units of its radius. Default:
        the same rule. ``stem_extend_5=0, stem_extend_3=0, taper=0`` clamps at the closing pair.
    persistence_length_A : float
        Sets the scale of ``energy_kT`` (K0 = kT·lp).
    energy_max : float, optional
        Highest dimensionless energy E·L/K0 listed; default as in :func:`equilibria`.
    max_candidates : int
        How many candidates are kept.
    all_models : bool
        Fold each model with its own clamp and compare it with its own loop.
    irregular : bool
        Fold loops too whose stem is no A or B helix: the ideal strand misses it by more than 1.3 Å.
    pair, dot_bracket, loop
        Pairs, a secondary structure, or loops to take in place of what the coordinates show; a loop
        may be absent from the file. See :func:`find_hairpins`.

    Returns
    -------
    list of LoopFold
        One per hairpin, in file order; a loop that cannot be folded says why in ``failure``.

    Raises
    ------
    StructureError
        If the file cannot be read or holds no nucleic acid.
    ValueError
        If an option is out of range.
    """
    parameters = checked_parameters(
        free_spin=free_spin,
        torsion_ratio=torsion_ratio,
        length_per_nucleotide_A=length_per_nucleotide_A,
        stem_extend_5=stem_extend_5,
        stem_extend_3=stem_extend_3,
        taper=taper,
        persistence_length_A=persistence_length_A,
        energy_max=energy_max,
        max_candidates=max_candidates,
        all_models=all_models,
        irregular=irregular,
        pair=pair,
        dot_bracket=dot_bracket,
        loop=loop,
    )
    structure = read_structure(path_or_universe)
    hairpins = find_hairpins(structure, pair=pair, dot_bracket=dot_bracket, loop=loop)
    return fold_hairpins(structure, hairpins, parameters)


def fold_hairpins(
    structure: Structure, hairpins: Sequence[Hairpin], parameters: dict[str, Any]
) -> list[LoopFold]:
    """Fold hairpins that are known already, by :func:`checked_parameters`."""
    folds: list[list[LoopFold]] = [[] for _ in hairpins]
    for positions in structure.models():
        for hairpin, models in zip(hairpins, folds, strict=True):
            models.append(fold_positions(structure.nucleotides, hairpin, positions, **parameters))
        if not parameters["all_models"]:
            break
    return [_together(models) for models in folds]


def checked_parameters(
    *,
    free_spin: bool = True,
    torsion_ratio: float = 1.0,
    length_per_nucleotide_A: float | None = None,
    stem_extend_5: int | None = None,
    stem_extend_3: int | None = None,
    taper: float | None = None,
    persistence_length_A: float = PERSISTENCE_LENGTH_A,
    energy_max: float | None = None,
    max_candidates: int = 10,
    all_models: bool = True,
    irregular: bool = False,
    pair: str | Sequence[str] = (),
    dot_bracket: str | None = None,
    loop: str | Sequence[str] = (),
) -> dict[str, Any]:
    """The options of :func:`fold`, each in range, for :func:`fold_positions`."""
    return {
        "free_spin": bool(free_spin),
        "torsion_ratio": _positive("torsion_ratio", torsion_ratio),
        "length_per_nucleotide_A": (
            None
            if length_per_nucleotide_A is None
            else _positive("length_per_nucleotide_A", length_per_nucleotide_A)
        ),
        "stem_extend_5": _extension("stem_extend_5", stem_extend_5),
        "stem_extend_3": _extension("stem_extend_3", stem_extend_3),
        "taper": _taper(taper),
        "persistence_length_A": _positive("persistence_length_A", persistence_length_A),
        "energy_max": None if energy_max is None else _positive("energy_max", energy_max),
        "max_candidates": int(_positive("max_candidates", max_candidates)),
        "all_models": bool(all_models),
        "irregular": bool(irregular),
        "pair": list(as_texts(pair)),
        "dot_bracket": dot_bracket,
        "loop": list(as_texts(loop)),
    }


def fold_positions(
    nucleotides: Nucleotides, hairpin: Hairpin, positions: Array, **parameters: Any
) -> LoopFold:
    """Fold one hairpin in one model, from the positions (n_atoms, 3) of all atoms, Å.

    ``parameters`` are those of :func:`fold`. A loop that cannot be folded says why in ``failure``.
    """
    try:
        ends = clamped_ends(placed_stem(nucleotides, hairpin, positions), parameters)
        clamping = clamping_of(ends, parameters["free_spin"])
        # shapes that only a second round finds cost tens of kT more than the first
        rods = equilibria(clamping, parameters["torsion_ratio"], parameters["energy_max"], rounds=1)
        if not rods:
            raise StructureError(
                f"{_name(hairpin)}: the solver found no equilibrium of the clamped line in"
                f" {rods.starts} starts; the loop is not folded"
            )
    except StructureError as error:
        return LoopFold(hairpin, (), parameters, failure=str(error))
    remarks = []
    if not ends.regular:
        remarks.append(f"{_name(hairpin)}: {ends.misfit}; the clamp means little")
    backbone_A = native_backbone(nucleotides, hairpin, positions)
    if backbone_A is None:
        remarks.append(
            f"{_name(hairpin)}: the file lacks backbone atoms of the loop, so the trace is compared"
            " with nothing"
        )
    candidates = rank(
        rods,
        ends,
        parameters["persistence_length_A"],
        stem_atoms(nucleotides, hairpin, positions),
        None if backbone_A is None else backbone_A[1:-1],
    )[: parameters["max_candidates"]]
    return LoopFold(
        hairpin,
        candidates,
        parameters,
        None,
        ends,
        clamping,
        ends.length_A,
        backbone_A,
        (),
        rods.unseen,
        tuple(remarks),
    )


def clamped_ends(stem: PlacedStem, parameters: dict[str, Any]) -> StemEnds:
    """Ends of the rod by the options in force, else by the rule.

    Raises
    ------
    StructureError
        If the stem is no A or B helix, or no rod of this length spans the ends.
    """
    hairpin = stem.hairpin
    asked = {
        name: parameters[name]
        for name in ("stem_extend_5", "stem_extend_3", "taper", "length_per_nucleotide_A")
        if parameters[name] is not None
    }
    clamp = replace(default_clamp(hairpin.is_dna, len(hairpin)), **asked)
    # what the user asked for is not taken back
    fixed = {"stem_extend_5", "stem_extend_3"} & asked.keys()
    ends = stem.ends(clamp) if fixed else stem.feasible(clamp)
    if not parameters.get("irregular", False):
        ends.check_regular(_name(hairpin))
    return ends.check_reach(_name(hairpin))


def clamping_of(ends: StemEnds, free_spin: bool) -> Clamping:
    """The dimensionless clamping of a rod between two ends."""
    return Clamping.from_frames(
        ends.start_origin_A,
        ends.start_frame,
        ends.end_origin_A,
        ends.end_frame,
        ends.length_A,
        free_spin,
    )


def native_backbone(nucleotides: Nucleotides, hairpin: Hairpin, positions: Array) -> Array | None:
    """Centroids (n_nt + 2, 3) from closing to closing nucleotide; None if one is not in the file.

    For comparison only.
    """
    shown = np.concatenate([hairpin.stem_5[:1], hairpin.loop, hairpin.stem_3[:1]])
    backbone = centroids_at(nucleotides, positions, shown)
    return read_only(backbone) if np.isfinite(backbone).all() else None


def _together(models: list[LoopFold]) -> LoopFold:
    """The first model's fold with the RMSDs of all models beside its own."""
    first = models[0]
    failures = tuple(
        f"model {number}: {model.failure}"
        for number, model in enumerate(models[1:], start=2)
        if model.failure
    )
    candidates = tuple(
        replace(c, rmsd_models_A=read_only(list(_rmsds(models, c.rank))))
        if c.rmsd_A is not None
        else c
        for c in first.candidates
    )
    return replace(first, candidates=candidates, model_failures=failures)


def _rmsds(models: list[LoopFold], order: int) -> Iterator[float]:
    for model in models:
        rmsd = model.candidates[order - 1].rmsd_A if len(model.candidates) >= order else None
        yield math.inf if rmsd is None else rmsd


def _name(hairpin: Hairpin) -> str:
    return "–".join(hairpin.closing_pair)


def _positive(name: str, value: float) -> float:
    if not (math.isfinite(value) and value > 0):
        raise ValueError(f"`{name}` is {value}; it must be positive and finite")
    return float(value)


def _extension(name: str, value: int | None) -> int | None:
    if value is not None and (value != int(value) or value < 0):
        raise ValueError(
            f"`{name}` is {value}; it must be a whole number of nucleotides, 0 or more"
        )
    return None if value is None else int(value)


def _taper(value: float | None) -> float | None:
    if value is not None and not 0.0 <= value <= TAPER_MAX:
        raise ValueError(f"`taper` is {value}; it must be between 0 and {TAPER_MAX}")
    return None if value is None else float(value)
