"""The rule of the clamp, by kind and length."""

import dataclasses

import numpy as np
import pytest

from loopelastica.errors import StructureError
from loopelastica.molecule.clamp_rule import StemClamp, default_clamp, expected_rmsd_A, plain_clamp
from loopelastica.molecule.ends import fit_stem, stem_ends
from loopelastica.molecule.hairpins import find_hairpins


@pytest.mark.parametrize("n", range(1, 31))
def test_the_rule_leaves_the_rod_most_of_every_loop(n):
    assert default_clamp(True, n) == plain_clamp(True)
    clamp = default_clamp(False, n)
    assert clamp.taper == 0.2
    assert n - clamp.stem_extend_5 - clamp.stem_extend_3 >= min(n, 4)
    median, nine_tenths = expected_rmsd_A(n)
    assert 0 < median < nine_tenths


@pytest.mark.parametrize(
    ("n", "extensions"),
    [(3, (0, 0)), (5, (0, 0)), (6, (0, 1)), (7, (1, 2)), (8, (1, 2)), (9, (1, 3)), (14, (1, 3))],
)
def test_the_3_strand_of_longer_rna_loops_goes_on_further_than_the_5_strand(n, extensions):
    clamp = default_clamp(False, n)
    assert (clamp.stem_extend_5, clamp.stem_extend_3) == extensions


def test_extensions_move_the_ends_along_the_stem_and_shorten_the_rod(koc):
    (hairpin,) = find_hairpins(koc)
    stem = fit_stem(koc.nucleotides, hairpin, koc.positions(0))
    plain, moved = (stem.ends(StemClamp(*e, 0.0, 6.0)) for e in ((0, 0), (1, 0)))
    assert (plain.n_free, moved.n_free, moved.length_A) == (4, 3, 18.0)
    np.testing.assert_array_equal(plain.end_frame, moved.end_frame)
    # one nucleotide of ideal line further, half of it beyond the nucleotide that is laid on it
    assert np.linalg.norm(moved.start_origin_A - plain.start_origin_A) == pytest.approx(
        5.8, abs=0.1
    )
    middle = (moved.start_origin_A + plain.start_origin_A) / 2
    assert np.linalg.norm(moved.continued_5_A[0] - middle) < 0.5
    back = stem.ends(StemClamp(0, 2, 0.2, 6.0))
    assert back.continued_3_A.shape == (2, 3)
    steps = np.diff([*back.continued_3_A, plain.end_origin_A], axis=0)
    assert (np.linalg.norm(steps, axis=1) < 6.0).all()


def test_a_clamp_that_cannot_be_is_one_sentence(koc):
    (hairpin,) = find_hairpins(koc)
    positions = koc.positions(0)
    with pytest.raises(StructureError, match="leave none to the rod"):
        stem_ends(koc.nucleotides, hairpin, positions, StemClamp(2, 2, 0.0, 6.0))
    with pytest.raises(StructureError, match=r"A\.C5–A\.G10: `taper`"):
        stem_ends(koc.nucleotides, hairpin, positions, StemClamp(0, 3, 0.4, 6.0))


def test_an_unreachable_clamp_gives_up_its_3_strand_first(koc):
    (hairpin,) = find_hairpins(koc)
    stem = fit_stem(koc.nucleotides, hairpin, koc.positions(0))
    assert stem.ends(StemClamp(1, 1, 0.0, 5.8)).distance_A > 11.6
    clamp = stem.feasible(StemClamp(1, 1, 0.0, 5.8)).clamp
    assert clamp.stem_extend_3 == 0
    with pytest.raises(StructureError, match="no rod fits"):
        stem.feasible(StemClamp(1, 1, 0.0, 2.0))
    one_pair = dataclasses.replace(hairpin, stem_5=hairpin.stem_5[:1], stem_3=hairpin.stem_3[:1])
    assert fit_stem(koc.nucleotides, one_pair, koc.positions(0)).ends(clamp).regular
