"""Motifs, shapes by length, and errors to expect: the tables that come with the program."""

import numpy as np
import pytest

from loopelastica.folding.motifs import (
    class_of,
    errors_of,
    motif_of,
    motifs,
    of_length,
    pattern_fits,
    typical_spread_A,
)
from loopelastica.folding.shape_table import letters_of

KINDS = ("mean", "library", "rod", "further rod", "motif GNRA", "motif UNCG", "same sequence")
KINDS += ("rod in its surroundings", "motif of another time")


@pytest.mark.parametrize(
    ("sequence", "name"),
    [
        ("CGAAAG", "GNRA"), ("GGUGAC", "GNRA"), ("cgcaag", "GNRA"), ("CUUCGG", "UNCG"),
        ("CTTCGG", "UNCG"), ("CUACGG", "UNCG"), ("CGAAUG", None), ("CGAUAG", None),
        ("CUUUGG", None), ("CGAAG", None), ("CGAAAAG", None), ("CNNNNG", None), ("CG", None),
        ("C?éAAG", None),
    ],
)  # fmt: skip
def test_the_sequence_alone_says_which_motif_a_loop_has(sequence, name):
    motif = motif_of(sequence)
    assert (motif.name if motif else None) == name


def test_letters_of_a_pattern_stand_for_the_bases_of_iupac():
    codes = np.array([letters_of(s) for s in ("CGAUC", "CGGUC", "CGCUC", "CGNUC")])
    assert pattern_fits("GRU", codes).tolist() == [True, True, False, False]
    assert pattern_fits("NYN", codes).tolist() == [False, False, True, False]
    assert pattern_fits("GRNA", codes).tolist() == [False] * 4


def shapes():
    lengths = [of_length(n, is_dna) for n in range(1, 15) for is_dna in (False, True)]
    return [*motifs(), *(one for one in lengths if one is not None)]


@pytest.mark.parametrize("motif", shapes(), ids=lambda m: f"{m.name}-{m.shape.is_dna}")
def test_every_shape_of_the_tables_can_be_one_of_a_backbone(motif):
    shape = motif.shape
    assert len(shape) == len(motif.pattern)
    steps = np.linalg.norm(shape.steps_A, axis=1)
    # a mean of many shapes is shorter than each
    assert ((steps > 1.5) & (steps < 8.0)).all()
    # as a chain's frame has to be
    np.testing.assert_allclose(shape.end_frame @ shape.end_frame.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(shape.end_frame) > 0.0
    assert shape.source.endswith(f" {motif.loops} loops")
    assert 2 <= motif.sequences <= motif.loops
    assert 0.0 < motif.rmsd_A[0] < motif.rmsd_A[1] < 20.0


def test_each_length_of_rna_from_3_to_12_has_a_shape_and_none_beyond():
    there = [n for n in range(1, 20) if of_length(n, is_dna=False)]
    assert there == list(range(3, 13))
    assert of_length(3, is_dna=True).shape.is_dna
    assert of_length(9, is_dna=True) is None


@pytest.mark.parametrize("kind", KINDS)
def test_errors_to_expect_are_numbers_in_ascending_order(kind):
    for n in (1, 3, 4, 5, 6, 7, 9, 12, 13, 30):
        for spread in (0.0, 0.5, 2.0, 40.0):
            for energy in (0.0, 1.0, 1e4):
                low, middle, high = errors_of(kind).at(spread, energy, n)
                assert 0.0 <= low <= middle <= high < np.inf
                assert low < middle < high or spread == 0.0


@pytest.mark.parametrize("kind", ["mean", "library", "rod", "same sequence", "motif GNRA"])
@pytest.mark.parametrize("n", [3, 5, 8, 12])
def test_the_further_apart_shapes_are_the_larger_the_error(kind, n):
    medians = [errors_of(kind).at(spread, 1.0, n)[1] for spread in (0.5, 1.0, 2.0, 4.0, 8.0)]
    assert (np.diff(medians) > 0.0).all()


def test_a_motif_is_surer_than_any_loop_of_its_length():
    motif, mean = errors_of("motif GNRA"), errors_of("mean")
    assert (motif.at(1.2, 1.0, 4) < mean.at(2.9, 1.0, 4)).all()


def test_the_error_of_loops_beyond_the_table_grows_with_their_length():
    lengths = (12, 13, 16, 20, 40)
    assert (np.diff([typical_spread_A(n) for n in lengths]) > 0.0).all()
    errors = [errors_of("rod").at(typical_spread_A(n), 1.0, n)[1] for n in lengths]
    assert (np.diff(errors) > 0.0).all()
    assert 0.0 < typical_spread_A(1) < typical_spread_A(3)
    assert class_of(10) == class_of(10**6) == "10-12"
