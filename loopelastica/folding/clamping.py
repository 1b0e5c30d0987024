"""From the stem of a loop to the clamping of its rod: by the options given, else by the rule."""

from dataclasses import replace

from loopelastica.folding.options import FoldOptions
from loopelastica.molecule.clamp_rule import default_clamp
from loopelastica.molecule.ends import FittedStem, StemEnds
from loopelastica.rod.clamping import Clamping


def clamped_ends(stem: FittedStem, options: FoldOptions) -> StemEnds:
    """Ends of the rod by the options given, else by the rule.

    Parameters
    ----------
    stem : FittedStem
        Ideal strands on the stem of the loop.
    options : FoldOptions
        Extensions that are given here are not shortened where no rod spans the ends.

    Returns
    -------
    StemEnds

    Raises
    ------
    StructureError
        If the stem is no A or B helix, or no rod of this length spans the ends.
    """
    hairpin = stem.hairpin
    clamp = replace(default_clamp(hairpin.is_dna, len(hairpin)), **options.clamp)
    given = {"stem_extend_5", "stem_extend_3"} & options.clamp.keys()
    ends = stem.ends(clamp) if given else stem.feasible(clamp)
    if not options.irregular:
        ends.check_regular(hairpin.label)
    return ends.check_reach(hairpin.label)


def clamping_of(ends: StemEnds, free_spin: bool) -> Clamping:
    """The dimensionless clamping of a rod between two ends.

    Parameters
    ----------
    ends : StemEnds
        Origins and frames, Å.
    free_spin : bool
        Let the end turn about its tangent.

    Returns
    -------
    Clamping
        Lengths in units of the rod's own.
    """
    return Clamping.from_frames(
        ends.start_origin_A,
        ends.start_frame,
        ends.end_origin_A,
        ends.end_frame,
        ends.length_A,
        free_spin,
    )
