"""Pictures."""

import dataclasses

import pytest

from loopelastica.report.plots import plot_fold


@pytest.mark.parametrize("title", ["$x", "a$b_c$", "$\\frac{$", "環", "[red]"])
def test_a_title_is_a_name_and_no_formula(tmp_path, fold, title):
    plot_fold(fold, tmp_path / "plot.png", title=title)
    assert (tmp_path / "plot.png").stat().st_size > 10_000


def drawn(loop, path, monkeypatch):
    """All texts of a picture."""
    from matplotlib.figure import Figure

    figures = []

    def keep(self, *arguments, **options):
        figures.append(self)
        saved(self, *arguments, **options)

    saved = Figure.savefig
    monkeypatch.setattr(Figure, "savefig", keep)
    plot_fold(loop, path)
    front, side, _ = figures[0].axes
    return [t.get_text() for t in front.get_legend().get_texts()], [
        t.get_text() for t in side.texts
    ]


def test_lines_are_named_by_their_shapes_the_first_one_first(tmp_path, chains, monkeypatch):
    legend, texts = drawn(chains, tmp_path / "plot.png", monkeypatch)
    n = len(chains.candidates)
    assert legend[0].startswith("1: like 2koc A.5-A.10, ")
    assert [int(text.split(":")[0]) for text in legend[:n]] == list(range(1, n + 1))
    assert legend[n:] == ["file (smoothed)"]
    assert texts == ["expected error of 1 (80 %): 1.2 (0.5–2.0) Å"]


@pytest.mark.parametrize("shape", ["like $x$ a", "like $\\frac{$", "like a\nb", "like 環"])
def test_a_shape_is_a_name_and_no_formula(tmp_path, chains, shape):
    odd = dataclasses.replace(chains.candidates[0], shape=shape)
    plot_fold(dataclasses.replace(chains, candidates=(odd,)), tmp_path / "plot.png")
    assert (tmp_path / "plot.png").stat().st_size > 10_000
