"""Pictures."""

import pytest

from loopelastica.report.plots import plot_fold


@pytest.mark.parametrize("title", ["$x", "a$b_c$", "$\\frac{$", "環", "[red]"])
def test_a_title_is_a_name_and_no_formula(tmp_path, fold, title):
    plot_fold(fold, tmp_path / "plot.png", title=title)
    assert (tmp_path / "plot.png").stat().st_size > 10_000
