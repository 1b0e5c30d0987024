"""From the rod's own frame to the file, and the native line beside it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from loopelastica.molecule.ends import stem_ends
from loopelastica.molecule.hairpins import find_hairpins
from loopelastica.molecule.nucleotides import centroids
from loopelastica.molecule.strands import A_RNA, line_frame
from loopelastica.molecule.trace import (
    loop_arc_positions,
    native_backbone,
    rmsd_A,
    smoothed_curvature,
    smoothed_line,
    to_file_coordinates,
)


def test_a_straight_rod_follows_the_start_tangent(koc):
    ends = stem_ends(koc.nucleotides, find_hairpins(koc)[0], koc.positions(0))
    straight = np.array([[0, 0, s] for s in (0.0, 0.5, 1.0)])
    line = to_file_coordinates(straight, ends.start_origin_A, ends.start_frame, ends.length_A)
    np.testing.assert_allclose(line[0], ends.start_origin_A)
    np.testing.assert_allclose(line[2] - line[0], 24.0 * ends.start_frame[:, 2], atol=1e-12)


def test_components_are_taken_along_the_columns_of_the_frame():
    rng = np.random.default_rng(0)
    frame, origin = Rotation.from_quat(rng.normal(size=4)).as_matrix(), rng.normal(size=3)
    line = rng.normal(size=(5, 3))
    expected = [
        origin + 7.0 * (x * frame[:, 0] + y * frame[:, 1] + z * frame[:, 2]) for x, y, z in line
    ]
    np.testing.assert_allclose(to_file_coordinates(line, origin, frame, 7.0), expected, atol=1e-12)


def test_arc_positions_are_the_middles_of_n_equal_parts():
    np.testing.assert_allclose(loop_arc_positions(3), [1 / 6, 1 / 2, 5 / 6])
    with pytest.raises(ValueError, match="`n`"):
        loop_arc_positions(0)


def test_smoothed_line_of_an_ideal_helix_is_that_helix():
    points = np.array([line_frame(A_RNA, k)[0] for k in range(12)])
    line = smoothed_line(points, 101)
    exact = np.array([line_frame(A_RNA, x)[0] for x in np.linspace(0.5, 10.5, 101)])
    assert rmsd_A(line[20:-20], exact[20:-20]) < 0.01
    assert rmsd_A(line, exact) < 0.1


def test_smoothed_curvature_is_the_turning_of_the_smoothed_line(rng):
    points = np.cumsum(rng.normal(size=(7, 3)) + [4.0, 0.0, 0.0], axis=0)
    line = smoothed_line(points, 4001)
    steps = np.diff(line, axis=0)
    apart = np.linalg.norm(steps, axis=1)
    turning = np.linalg.norm(np.diff(steps / apart[:, None], axis=0), axis=1) / apart[1:]
    np.testing.assert_allclose(
        turning, smoothed_curvature(points, 4001)[1:-1], rtol=2e-3, atol=1e-4
    )


def test_the_native_line_passes_the_loop_at_its_arc_positions(koc):
    (hairpin,) = find_hairpins(koc)
    n_points = 8 * 50 + 1
    backbone = native_backbone(koc.nucleotides, hairpin, koc.positions(0))
    line = smoothed_line(backbone, n_points)
    index = np.round(loop_arc_positions(len(hairpin)) * (n_points - 1)).astype(int)
    native = centroids(koc.nucleotides, koc.positions(0))[hairpin.loop]
    np.testing.assert_allclose(line[index], native, atol=1e-9)


def test_a_loop_that_is_not_whole_has_no_native_backbone(koc):
    (hairpin,) = find_hairpins(koc)
    positions = koc.positions(0).copy()
    positions[koc.nucleotides.columns(("C4'",))[6]] = np.nan
    assert native_backbone(koc.nucleotides, hairpin, positions) is None


@pytest.mark.parametrize(
    ("points", "n_points", "name"),
    [
        (np.zeros((2, 3)), 10, "centroids_A"),
        (np.zeros((4, 2)), 10, "centroids_A"),
        (np.full((4, 3), np.nan), 10, "centroids_A"),
        (np.zeros((4, 3)), 1, "n_points"),
    ],
)
def test_smoothed_line_refuses_what_is_no_line(points, n_points, name):
    with pytest.raises(ValueError, match=f"`{name}`"):
        smoothed_line(points, n_points)


def test_rmsd_does_not_superpose():
    a = np.random.default_rng(3).normal(size=(6, 3))
    assert rmsd_A(a, a + np.array([3.0, 0.0, 4.0])) == pytest.approx(5.0)
    with pytest.raises(ValueError, match="shapes"):
        rmsd_A(a, a[:5])
