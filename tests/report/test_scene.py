"""Which way is up, and lines joined to the stem."""

import dataclasses

import numpy as np
import pytest

import loopelastica as le
from loopelastica.molecule.setting import Settings
from loopelastica.report.scene import names_of, short_shape, smooth_strand, tube, view_of


@pytest.fixture(scope="module")
def setting(koc, chains):
    return Settings(koc).of(chains.hairpin)


def axes(view):
    return np.stack([view.across, view.up, view.towards])


@pytest.mark.parametrize("with_stem", [True, False])
def test_views_are_right_handed_with_the_loop_above_its_stem(chains, setting, with_stem):
    view = view_of(chains, setting if with_stem else None)
    np.testing.assert_allclose(axes(view) @ axes(view).T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes(view)) == pytest.approx(1.0)
    stem = np.concatenate([setting.strand_5_A, setting.strand_3_A]).mean(axis=0)
    assert (chains.candidates[0].trace.mean(axis=0) - stem) @ view.up > 5.0
    closing = setting.strand_3_A[0] - setting.strand_5_A[-1]
    assert closing @ view.across > 0.9 * np.linalg.norm(closing) * with_stem


def test_the_axis_of_an_ideal_helix_is_up():
    built = le.build("GGCACGGC(UUCG)GCCGUGCC").hairpin
    setting = Settings(built.structure, built.positions_A).of(built.fold.hairpin)
    view = view_of(built.fold, setting)
    # every step of the ideal helix rises by much the same
    rise = np.diff(setting.strand_5_A, axis=0) @ view.up
    np.testing.assert_allclose(rise, rise.mean(), atol=0.15)
    assert rise.mean() == pytest.approx(2.8, abs=0.3)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_broadside_a_line_goes_from_side_to_side(chains, setting, direction):
    view = view_of(chains, setting)
    line = np.linspace(-1.0, 1.0, 9)[:, None] * (0.3 * view.across + direction * view.towards)
    turned = view.broadside(line)
    np.testing.assert_allclose(line @ turned.towards, 0.0, atol=1e-12)
    np.testing.assert_allclose(turned.up, view.up)
    assert np.linalg.det(axes(turned)) == pytest.approx(1.0)
    assert turned.across @ view.across >= 0.0


def test_tubes_begin_and_end_at_the_closing_nucleotides_without_a_gap(chains, setting):
    for candidate in chains.candidates:
        points = tube(chains, candidate, setting, 200)
        np.testing.assert_allclose(points[0], setting.strand_5_A[-1], atol=1e-9)
        np.testing.assert_allclose(points[-1], setting.strand_3_A[0], atol=1e-9)
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        assert steps.max() < 1.05 * np.median(steps)
        # it passes the loop's nucleotides
        gaps = np.linalg.norm(candidate.trace[:, None] - points, axis=2).min(axis=1)
        assert gaps.max() < 0.3


def test_tubes_pass_the_nucleotides_that_continue_the_stem(koc):
    (loop,) = le.fold(koc, all_models=False, shapes="rod", stem_extend_5=1, stem_extend_3=1)
    points = tube(loop, loop.candidates[0], Settings(koc).of(loop.hairpin), 300)
    gaps = np.linalg.norm(loop.candidates[0].trace[:, None] - points, axis=2).min(axis=1)
    assert gaps.max() < 0.3


def test_a_stem_that_is_not_whole_has_no_joint(chains, setting):
    lost = setting.strand_5_A.copy()
    lost[-1] = np.nan
    part = dataclasses.replace(setting, strand_5_A=lost)
    points = tube(chains, chains.candidates[0], part, 50)
    assert np.isfinite(points).all()
    assert np.isfinite(axes(view_of(chains, part))).all()
    assert np.isfinite(smooth_strand(lost)).all()


@pytest.mark.parametrize(
    ("shape", "short"),
    [
        ("straight rod", "straight rod"),
        ("motif UNCG, same sequence, 49 loops", "motif UNCG, same sequence"),
        ("library 6zu5 S60.1151-S60.1156 (GGGA)", "library 6zu5 S60.1151-S60.1156"),
        ("x" * 50, "x" * 29 + "…"),
        ("a\nb", "a\\nb"),
    ],
)
def test_shapes_are_shortened_by_clauses(fold, shape, short):
    assert short_shape(dataclasses.replace(fold.candidates[0], shape=shape), 30) == short


def test_names_are_those_of_the_closing_pair_and_the_loop(fold, setting):
    assert names_of(fold, setting) == ["C5", "U6", "U7", "C8", "G9", "G10"]
    assert names_of(fold) == ["C5", "U6", "U7", "C8", "G9", "G10"]
