"""From a structure to the ranked shapes of its loops.

    file → nucleotides → hairpins → ends ─┬→ shapes of other loops, deformed ─┬→ candidates
                                          └→ clamping → equilibria ───────────┘

Each arrow is one call below. Only stem atoms enter the ends; the loop's own coordinates enter the
RMSD and nothing else.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from loopelastica._arrays import Array
from loopelastica.errors import StructureError
from loopelastica.folding.clamping import clamped_ends, clamping_of
from loopelastica.folding.folds import Folds
from loopelastica.folding.hypotheses import Scene, hypotheses, scene_of
from loopelastica.folding.like import check_loops, loop_templates, remarks
from loopelastica.folding.options import FoldOptions, keywords
from loopelastica.folding.rank import rank
from loopelastica.folding.result import LoopFold, with_models
from loopelastica.folding.source import source_of
from loopelastica.molecule.contacts import stem_atoms
from loopelastica.molecule.ends import StemEnds, fit_stem
from loopelastica.molecule.hairpins import Hairpin, find_hairpins
from loopelastica.molecule.nucleotides import Nucleotides, Structure, read_structure
from loopelastica.molecule.trace import native_backbone
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.equilibria import Equilibria, equilibria


@keywords(FoldOptions)
def fold(structure: Any, options: FoldOptions) -> Folds:
    """Fold every hairpin loop of a structure: elastic lines between the ends of its stem.

    Several answers are given for each loop, each with its shape and the error to expect of it:
    shapes that such loops have, deformed onto this stem; the rod in its surroundings; the rods of
    the rule.

    Parameters
    ----------
    structure : path, MDAnalysis.Universe or MDAnalysis.AtomGroup
        PDB or mmCIF file, gzipped or not, with all its models; or
        a Universe or a group of its atoms, in the current frame of its trajectory.
    {options}

    Returns
    -------
    Folds
        A list of :class:`LoopFold`, one per hairpin, in file order; a loop that cannot be folded
        says why in ``failure``. Its ``write(folder)`` writes what ``loopelastica fold`` writes.

    Raises
    ------
    StructureError
        If the file cannot be read or holds no nucleic acid.
    ValueError
        If an option is out of range; TypeError if there is no option of that name.

    Examples
    --------
    >>> from loopelastica._files import data_path
    >>> (loop,) = fold(data_path("hairpins/2koc.pdb"), all_models=False)
    >>> first = loop.candidates[0]
    >>> print(first.shape.split(",")[0], first.rmsd_A < first.expected_rmsd_A[2] < 6.0)
    motif UNCG True

    As rods by the rule alone:

    >>> (loop,) = fold(data_path("hairpins/2koc.pdb"), all_models=False, shapes="rod")
    >>> loop
    <LoopFold A6-9 CUUCGG: 3 candidates, first straight rod, E/K0 0.302 1/Å, RMSD 2.12 Å>
    """
    structure = read_structure(structure, options.limits)
    hairpins = find_hairpins(structure, **options.selection)
    loops = fold_hairpins(structure, hairpins, options)
    source = source_of(structure) if loops else None
    return Folds(
        (replace(loop, source=source) for loop in loops), (*structure.remarks, *hairpins.remarks)
    )


def fold_hairpins(
    structure: Structure, hairpins: Sequence[Hairpin], options: FoldOptions
) -> list[LoopFold]:
    """Fold hairpins that were found already.

    Parameters
    ----------
    structure : Structure
        What was read; of its models all are folded, or the first one by `options.all_models`.
    hairpins : sequence of Hairpin
        What was found in it.
    options : FoldOptions
        As for :func:`fold`.

    Returns
    -------
    list of LoopFold
        One per hairpin.
    """
    if options.like is not None:
        check_loops(options.like, hairpins, options.limits)
    folds: list[list[LoopFold]] = [[] for _ in hairpins]
    scene = scene_of(structure, hairpins, options) if hairpins else Scene()
    for positions in structure.models():
        for hairpin, models in zip(hairpins, folds, strict=True):
            models.append(fold_model(structure.nucleotides, hairpin, positions, options, scene))
        if not options.all_models:
            break
    return [with_models(models) for models in folds]


def fold_model(
    nucleotides: Nucleotides,
    hairpin: Hairpin,
    positions: Array,
    options: FoldOptions,
    scene: Scene | None = None,
) -> LoopFold:
    """Fold one hairpin in one model.

    Parameters
    ----------
    nucleotides : Nucleotides
        The table the hairpin was found in.
    hairpin : Hairpin
        Which loop.
    positions : (n_atoms, 3) array
        All atoms of the model, Å.
    options : FoldOptions
        As for :func:`fold`.
    scene : Scene, optional
        What the structure has beside the loop; by default it is folded as a rod by the rule.

    Returns
    -------
    LoopFold
        A loop that cannot be folded says why in ``failure``.
    """
    try:
        stem = fit_stem(nucleotides, hairpin, positions)
        ends = clamped_ends(stem, options)
        clamping = clamping_of(ends, options.free_spin)
        rods = _rods(hairpin, clamping, options)
        atoms = stem_atoms(nucleotides, hairpin, positions)
        answers = hypotheses(hairpin, stem, ends, rods, atoms, positions, options, scene or Scene())
    except StructureError as error:
        return LoopFold(hairpin, (), options, failure=str(error))
    backbone_A = native_backbone(nucleotides, hairpin, positions)
    candidates = rank(answers, options.persistence_length_A, atoms, backbone_A, options.rank)
    return LoopFold(
        hairpin,
        candidates[: options.max_candidates],
        options,
        ends=ends,
        clamping=clamping,
        backbone_A=backbone_A,
        unseen=rods.unseen,
        remarks=tuple(_remarks(hairpin, ends, backbone_A, options)),
    )


def _rods(hairpin: Hairpin, clamping: Clamping, options: FoldOptions) -> Equilibria:
    # shapes that only a second round finds cost tens of kT more than the first
    rods = equilibria(clamping, options.torsion_ratio, options.energy_max, rounds=1)
    if not rods:
        raise StructureError(
            f"{hairpin.label}: the solver found no equilibrium of the clamped line in"
            f" {rods.starts} starts; the loop is not folded"
        )
    return rods


def _remarks(
    hairpin: Hairpin, ends: StemEnds, backbone_A: Array | None, options: FoldOptions
) -> Iterator[str]:
    if not ends.regular:
        yield f"{hairpin.label}: {ends.misfit}; the clamp means little"
    if backbone_A is None:
        yield (
            f"{hairpin.label}: the file lacks backbone atoms of the loop, so the trace is compared"
            " with nothing"
        )
    if hairpin.contacts and options.shapes == "all":
        yield (
            f"{hairpin.label}: nucleotides of the loop pair elsewhere; errors to expect are those"
            " of loops that do not"
        )
    if options.like is not None:
        templates = loop_templates(options.like, len(hairpin), options.limits)
        yield from remarks(options.like, "loop", hairpin.label, len(hairpin), templates)
