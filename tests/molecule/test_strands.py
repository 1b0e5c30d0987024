"""Closed facts of the ideal strands."""

from __future__ import annotations

import numpy as np
import pytest

from loopelastica.molecule.strands import (
    A_RNA,
    B_DNA,
    ideal_strand,
    line_cylinder,
    line_frame,
    line_length_A,
    strand_atoms,
)

STRANDS = pytest.mark.parametrize("strand", [A_RNA, B_DNA], ids=lambda strand: strand.name)


@STRANDS
def test_all_bonds_along_the_backbone_are_bonds(strand):
    here, following = strand_atoms(strand, 3), strand_atoms(strand, 4)
    bonds = np.linalg.norm(np.diff(here, axis=0), axis=1)
    # P–O5', O5'–C5', C5'–C4', C4'–C3', C3'–O3'
    np.testing.assert_allclose(bonds, [1.60, 1.44, 1.51, 1.52, 1.42], atol=0.06)
    assert np.linalg.norm(following[0] - here[5]) == pytest.approx(1.59, abs=0.05)


@pytest.mark.parametrize(("strand", "radius", "length"), [(B_DNA, 7.97, 6.04), (A_RNA, 9.01, 5.86)])
def test_line_of_the_centroids(strand, radius, length):
    assert line_cylinder(strand)[0] == pytest.approx(radius, abs=0.005)
    assert line_length_A(strand) == pytest.approx(length, abs=0.005)


@STRANDS
def test_line_passes_through_the_centroids(strand):
    for k in (-2, 0, 5):
        point, _ = line_frame(strand, k)
        np.testing.assert_allclose(point, strand_atoms(strand, k).mean(axis=0), atol=1e-12)


@STRANDS
def test_tangent_is_the_slope_of_the_line_from_5_to_3(strand):
    h = 1e-6
    slope = (line_frame(strand, 0.5 + h)[0] - line_frame(strand, 0.5 - h)[0]) / (2 * h)
    point, frame = line_frame(strand, 0.5)
    np.testing.assert_allclose(frame[:, 2], slope / np.linalg.norm(slope), atol=1e-9)
    assert np.linalg.norm(slope) == pytest.approx(line_length_A(strand), abs=1e-8)
    radius = line_cylinder(strand)[0]
    np.testing.assert_allclose(point[:2] + radius * frame[:2, 0], 0.0, atol=1e-12)


@STRANDS
def test_frame_is_a_rotation_and_follows_the_screw(strand):
    for phase in (-0.5, 0.5, 2.25):
        frame = line_frame(strand, phase)[1]
        np.testing.assert_allclose(frame.T @ frame, np.eye(3), atol=1e-14)
        assert np.linalg.det(frame) == pytest.approx(1.0)
    turn = np.deg2rad(strand.turn_deg)
    screw = np.array(
        [[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1.0]]
    )
    np.testing.assert_allclose(
        line_frame(strand, 1.5)[1], screw @ line_frame(strand, 0.5)[1], atol=1e-14
    )


def test_the_helix_is_right_handed():
    for strand in (A_RNA, B_DNA):
        assert strand.turn_deg * strand.rise_A > 0


def test_lengths_for_loops_are_those_of_real_stems():
    assert ideal_strand(is_dna=True).length_per_nucleotide_A == 6.3
    assert ideal_strand(is_dna=False).length_per_nucleotide_A == 6.0


@pytest.mark.parametrize("strand", [A_RNA, B_DNA], ids=lambda strand: strand.name)
@pytest.mark.parametrize("taper", [0.0, 0.1, 0.2, 0.3])
def test_a_tapered_line_keeps_its_length_and_its_frames_follow_it(strand, taper):
    h = 1e-5
    # 0.5 is where the taper has set in
    for beyond, lost in ((0.01, 0.0001), (0.3, 0.09), (0.5, 0.25), (1.5, 1.25), (3.4, 3.15)):
        point, frame = line_frame(strand, -beyond, taper)
        slope = (
            line_frame(strand, -beyond + h, taper)[0] - line_frame(strand, -beyond - h, taper)[0]
        ) / (2 * h)
        assert np.linalg.norm(slope) == pytest.approx(line_length_A(strand), rel=2e-5)
        np.testing.assert_allclose(slope / np.linalg.norm(slope), frame[:, 2], atol=2e-5)
        np.testing.assert_allclose(frame.T @ frame, np.eye(3), atol=1e-12)
        radius = line_cylinder(strand)[0] * (1 - taper * lost)
        assert np.hypot(*point[:2]) == pytest.approx(radius, rel=1e-9)


def test_a_taper_changes_nothing_inside_the_stem_and_ends_at_the_axis():
    for phase in (0.0, 0.5, 3.0):
        for plain, tapered in zip(
            line_frame(A_RNA, phase), line_frame(A_RNA, phase, 0.2), strict=True
        ):
            np.testing.assert_array_equal(plain, tapered)
    with pytest.raises(ValueError, match="axis"):
        line_frame(A_RNA, -6.0, 0.2)
