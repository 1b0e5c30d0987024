"""Ends of strands, each from one nucleotide."""

import math
from dataclasses import replace

import gapped
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from loopelastica.errors import StructureError
from loopelastica.molecule.entry import read_entry
from loopelastica.molecule.gaps import find_gaps
from loopelastica.molecule.polymer import Monomer
from loopelastica.molecule.strand_ends import flank_end, line_length, strand_ends
from loopelastica.molecule.strands import ideal_strand, strand_atoms

BACKBONE = ("P", "O5'", "C5'", "C4'", "C3'", "O3'")


def ideal(k, is_dna=False, without=()):
    """Nucleotide k of an ideal strand."""
    positions = strand_atoms(ideal_strand(is_dna), k)
    atoms = {
        name: position
        for name, position in zip(BACKBONE, positions, strict=True)
        if name not in without
    }
    name = "DA" if is_dna else "A"
    return Monomer("A", k, "", name, "A", is_dna, atoms_A=atoms)


@pytest.fixture(scope="module")
def gap(tmp_path_factory):
    path = gapped.gapped(tmp_path_factory.mktemp("flanks") / "a.pdb", {6, 7})
    (found,) = find_gaps(read_entry(path)).gaps
    return found


@pytest.mark.parametrize("after", [False, True])
def test_an_ideal_nucleotide_of_rna_ends_half_a_step_beyond_on_the_line(after):
    origin, frame, rms = flank_end(ideal(3), after)
    assert rms == pytest.approx(0.0, abs=1e-9)
    # its neighbour, from the other side, ends at the same place
    other, other_frame, _ = flank_end(ideal(2 if after else 4), not after)
    np.testing.assert_allclose(origin, other, atol=1e-9)
    np.testing.assert_allclose(frame, other_frame, atol=1e-9)


@pytest.mark.parametrize("is_dna", [False, True])
@pytest.mark.parametrize("after", [False, True])
def test_a_frame_is_right_handed_and_orthonormal(is_dna, after):
    _, frame, _ = flank_end(ideal(1, is_dna), after)
    np.testing.assert_allclose(frame.T @ frame, np.eye(3), atol=1e-12)
    assert np.linalg.det(frame) == pytest.approx(1.0)


@pytest.mark.parametrize("is_dna", [False, True])
def test_the_tangent_points_from_5_to_3(is_dna):
    before, here = ideal(1, is_dna), ideal(2, is_dna)
    step = here.backbone_A.mean(axis=0) - before.backbone_A.mean(axis=0)
    _, frame, _ = flank_end(before, after=False)
    assert frame[:, 2] @ step > 0


def test_where_the_nucleotide_stands_does_not_matter(gap, rng):
    rotation, shift = Rotation.random(rng=rng), rng.uniform(-50, 50, 3)
    moved = replace(
        gap.before,
        atoms_A={k: rotation.apply(v.copy()) + shift for k, v in gap.before.atoms_A.items()},
    )
    origin, frame, rms = flank_end(gap.before, after=False)
    origin_2, frame_2, rms_2 = flank_end(moved, after=False)
    np.testing.assert_allclose(origin_2, rotation.apply(origin) + shift, atol=1e-9)
    np.testing.assert_allclose(frame_2, rotation.as_matrix() @ frame, atol=1e-9)
    assert rms_2 == pytest.approx(rms)


@pytest.mark.parametrize("without", [("P",), ("P", "O5'"), ("O3'",)])
def test_four_or_five_atoms_are_enough_and_hardly_worse(without):
    origin, frame, _ = flank_end(ideal(1, without=without), after=True)
    whole, whole_frame, _ = flank_end(ideal(1), after=True)
    np.testing.assert_allclose(origin, whole, atol=1e-9)
    np.testing.assert_allclose(frame, whole_frame, atol=1e-9)


@pytest.mark.parametrize("without", [("C4'",), ("P", "O5'", "C5'")])
def test_fewer_or_none_in_the_middle_are_refused_by_name(without):
    with pytest.raises(StructureError, match=r"A\.A1: it lacks C4' or has fewer than four"):
        flank_end(ideal(1, without=without), after=False)


def test_the_length_grows_with_nucleotides_and_with_the_distance():
    for is_dna in (False, True):
        lengths = [line_length(n, 0.0, is_dna) for n in range(1, 13)]
        assert lengths == sorted(lengths)
        for n in range(1, 13):
            for distance in (1.0, 5.0 * n, 7.0 * n):
                assert line_length(n, distance, is_dna) > distance


@pytest.mark.parametrize(
    ("n", "distance", "length"),
    [(1, 3.0, 6.0), (2, 11.9, 12.138), (3, 10.0, 16.5), (4, 22.0, 23.1), (5, 10.0, 25.0)],
)
def test_lengths_of_rna_are_those_of_the_recipe(n, distance, length):
    assert line_length(n, distance) == pytest.approx(length)


def test_both_ends_are_those_of_the_flanks(gap):
    ends = strand_ends(gap)
    start, frame, rms_5 = flank_end(gap.before, after=False)
    end, end_frame, rms_3 = flank_end(gap.after, after=True)
    np.testing.assert_array_equal(ends.start_origin_A, start)
    np.testing.assert_array_equal(ends.end_frame, end_frame)
    assert ends.fit_rms_A.tolist() == [rms_5, rms_3]
    assert ends.n == 2
    assert ends.distance_A == pytest.approx(math.dist(start, end))
    assert ends.length_A == line_length(2, ends.distance_A)
    assert f"{ends.distance_A:.1f} Å apart" in repr(ends)
    points = np.array([[0.0, 0.0, 0.0], [0.1, 0.2, 0.3]])
    np.testing.assert_allclose(
        ends.from_file(ends.to_file(points)) / ends.length_A, points, atol=1e-9
    )
    np.testing.assert_allclose(ends.start_frame, frame)


def test_ends_that_are_too_far_apart_are_refused_with_both_distances(gap):
    apart = {name: position + 40.0 for name, position in gap.after.atoms_A.items()}
    with pytest.raises(
        StructureError, match=r"A\.6-7: 2 nt cannot span \d+\.\d Å: they reach 18 Å"
    ):
        strand_ends(replace(gap, after=replace(gap.after, atoms_A=apart)))


def test_a_strand_of_both_kinds_is_as_short_as_one_of_rna(gap):
    first, second = gap.monomers
    near = strand_ends(gap)
    mixed = replace(gap, monomers=(replace(first, is_dna=True), second))
    dna = replace(gap, monomers=tuple(replace(m, is_dna=True) for m in gap.monomers))
    assert strand_ends(mixed).length_A == near.length_A
    assert strand_ends(dna).length_A == line_length(2, near.distance_A, is_dna=True)
