"""Pictures."""

import dataclasses
import itertools

import numpy as np
import pytest
from matplotlib.colors import to_hex

import loopelastica as le
from loopelastica.molecule.setting import Settings
from loopelastica.molecule.trace import smoothed_curvature
from loopelastica.report.palette import NATIVE, colour
from loopelastica.report.plots import draw_fold, plot_fold


@pytest.fixture(scope="module")
def setting(koc, chains):
    return Settings(koc).of(chains.hairpin)


@pytest.fixture(scope="module")
def figure(chains, setting):
    return draw_fold(chains, setting, "2koc.pdb")


def texts(axes):
    return [text.get_text() for text in axes.texts]


def boxes(axes, renderer):
    return {t.get_text(): t.get_window_extent(renderer) for t in axes.texts if t.get_text()}


def many(fold, n, shape):
    """The first candidate n times, each a little elsewhere and of another rank."""
    first = fold.candidates[0]
    ranked = (dataclasses.replace(first, rank=k + 1, shape=shape) for k in range(n))
    return dataclasses.replace(fold, candidates=tuple(ranked))


@pytest.mark.parametrize("title", ["$x", "a$b_c$", "$\\frac{$", "環", "[red]", "two\nlines"])
def test_a_title_is_a_name_and_no_formula(tmp_path, fold, title):
    plot_fold(fold, tmp_path / "plot.png", title=title)
    assert (tmp_path / "plot.png").stat().st_size > 10_000


@pytest.mark.parametrize("shape", ["like $x$ a", "like $\\frac{$", "like a\nb", "like 環"])
def test_a_shape_is_a_name_and_no_formula(tmp_path, chains, shape):
    odd = dataclasses.replace(chains.candidates[0], shape=shape)
    plot_fold(dataclasses.replace(chains, candidates=(odd,)), tmp_path / "plot.png")
    assert (tmp_path / "plot.png").stat().st_size > 10_000


def test_the_heading_says_which_loop_it_is(figure):
    (heading,) = figure.texts
    for part in ("2koc.pdb", "A6-9", "CUUCGG", "A.C5–A.G10"):
        assert part in heading.get_text()


def test_both_views_name_the_loop_the_closing_pair_and_the_ends(figure):
    front, side, *_ = figure.axes
    for axes in (front, side):
        assert set(texts(axes)) >= {"C5", "U6", "U7", "C8", "G9", "G10", "5′", "3′", "10 Å"}


def test_the_key_has_a_row_for_each_candidate_the_first_one_first(figure, chains):
    *_, key = figure.axes
    found = texts(key)
    rows = [text for text in found if text[0].isdigit() and "  " in text]
    assert [int(row.split()[0]) for row in rows] == [c.rank for c in chains.candidates]
    assert rows[0] == "1  like 2koc A.5-A.10"
    assert "1.2 (0.5–2.0)" in found
    assert f"{chains.candidates[0].rmsd_A:.2f}" in found
    assert "expected error of 1: 1.2 Å (50 %)" in found


def test_a_candidate_has_one_colour_everywhere(figure, chains):
    front, side, curvature, key = figure.axes
    for candidate in chains.candidates:
        for axes in (front, side, curvature, key):
            colours = [to_hex(line.get_color()) for line in axes.lines]
            assert colour(candidate.rank) in colours


def test_the_band_is_as_wide_as_the_expected_error_twice(figure, chains):
    front = figure.axes[0]
    (band,) = (line for line in front.lines if line.get_alpha() == 0.14)
    points_per_A = front.get_window_extent().width / figure.dpi * 72 / np.ptp(front.get_xlim())
    expected = 2.0 * chains.candidates[0].expected_rmsd_A[1] * points_per_A
    assert band.get_linewidth() == pytest.approx(expected, rel=1e-6)


def test_both_views_have_one_scale_in_both_directions(figure):
    scales = []
    for axes in figure.axes[:2]:
        box = axes.get_window_extent()
        scales += [box.width / np.ptp(axes.get_xlim()), box.height / np.ptp(axes.get_ylim())]
    assert np.ptp(scales) < 1e-6 * scales[0]


def test_the_curvature_of_the_files_loop_is_drawn(figure, chains):
    curvature = figure.axes[2]
    (own,) = (line for line in curvature.lines if line.get_color() == NATIVE)
    np.testing.assert_allclose(own.get_ydata(), smoothed_curvature(chains.backbone_A, 101))


def test_lines_meet_the_stem(figure, setting, chains):
    front = figure.axes[0]
    (first,) = (
        line for line in front.lines
        if to_hex(line.get_color()) == colour(1) and line.get_linewidth() == 2.6
    )  # fmt: skip
    closing = [line.get_xydata() for line in front.lines if line.get_linewidth() == 2.2]
    np.testing.assert_allclose(first.get_xydata()[[0, -1]], closing[0], atol=1e-6)


LONG = "library 6zu5 L50.2120-L50.2125 with a name beyond all measure (GUACGUACGUACGUACGUA)"


@pytest.mark.parametrize("case", ["ten", "short", "long", "DNA"])
def test_no_text_is_on_another_or_outside(case, chains, setting):
    if case == "ten":
        fold, place = many(chains, 10, LONG), setting
    else:
        sequence = {
            "short": "GGCAC(GCA)GUGCC",
            "long": f"GGCAC({'ACGUU' * 6})GUGCC",
            "DNA": "GCGAC(TTTTT)GTCGC",
        }[case]
        built = le.build(sequence).hairpin
        fold = built.fold
        place = Settings(built.structure, built.positions_A).of(fold.hairpin)
    figure = draw_fold(fold, place, "a" * 300)
    renderer = figure.canvas.get_renderer()
    figure.draw(renderer)
    outline = figure.bbox
    for axes in figure.axes:
        found = boxes(axes, renderer)
        for box in found.values():
            assert outline.x0 <= box.x0
            assert box.x1 <= outline.x1
            assert outline.y0 <= box.y0
            assert box.y1 <= outline.y1
        for (one, a), (other, b) in itertools.combinations(found.items(), 2):
            # a letter's box is larger than the letter
            a, b = a.padded(-1.5), b.padded(-1.5)
            assert not a.overlaps(b), (one, other)


def test_more_candidates_than_rows_are_counted(chains, setting):
    key = draw_fold(many(chains, 14, "straight rod"), setting).axes[-1]
    assert "and 4 more" in texts(key)


def test_a_loop_without_a_setting_is_drawn_without_its_stem(chains):
    figure = draw_fold(chains)
    assert "5′" not in texts(figure.axes[0])
    assert "C5" in texts(figure.axes[0])


def test_a_picture_shows_itself_in_a_notebook(figure):
    assert figure._repr_png_().startswith(b"\x89PNG")


def test_a_loop_that_was_not_folded_says_why_there_is_no_picture(refused):
    with pytest.raises(ValueError, match=r"`fold` has no candidates to draw: .*line"):
        draw_fold(refused)
