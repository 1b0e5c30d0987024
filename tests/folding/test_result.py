"""What a fold gives back: short to print, read-only for good."""

import copy
import pickle
import sys

import pytest

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.folding.expected import expected_text

HAIRPIN = data_path("hairpins/2koc.pdb")


@pytest.fixture(scope="module")
def loop():
    (loop,) = le.fold(HAIRPIN, all_models=False, shapes="rod")
    return loop


@pytest.fixture(scope="module")
def refused():
    (loop,) = le.fold(HAIRPIN, all_models=False, length_per_nucleotide_A=2.0)
    return loop


def test_results_are_one_short_line_with_the_physics(loop, refused, models):
    (scanned,) = le.scan(HAIRPIN, extend_5_max=0, extend_3_max=0)
    first = "straight rod, E/K0 0.302 1/Å, RMSD 2.12 Å"
    second = "straight rod, E/K0 1.51 1/Å, RMSD 5.99 Å, touches stem, self"
    expected = {
        f"<LoopFold A6-9 CUUCGG: 3 candidates, first {first}>": loop,
        f"<Candidate 1: {first}>": loop.candidates[0],
        f"<Candidate 2: {second}>": loop.candidates[1],
        "<Hairpin A6-9 CUUCGG: RNA, 4 nt on a stem of 5 pairs>": loop.hairpin,
        "<StemEnds 14.2 Å apart, line of 24.0 Å on 4 nucleotides, stem misfit 0.50 Å>": loop.ends,
    }
    for text, result in expected.items():
        assert repr(result) == text
    for result in (refused, scanned, scanned.candidates[0], models[0], loop.hairpin):
        assert len(repr(result)) < 160
        assert "\n" not in repr(result)
    assert "no rod fits" in repr(refused)
    assert "sound" in repr(models[0])


def test_a_notebook_shows_a_table_of_candidates(loop, refused):
    html = loop._repr_html_()
    assert html.count("<tr>") == 1 + len(loop.candidates)
    for text in ("straight rod", "2.12", expected_text(loop.candidates[0].expected_rmsd_A)):
        assert f"<td>{text}</td>" in html
    assert "no rod fits" in refused._repr_html_()


def test_copies_and_pickles_stay_read_only(loop, models):
    (scanned,) = le.scan(HAIRPIN, extend_5_max=0, extend_3_max=0)
    for again in (copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))):
        other = again(loop)
        for array in (
            other.backbone_A,
            other.ends.start_frame,
            other.hairpin.loop,
            other.candidates[0].trace,
            other.candidates[0].rmsd_models_A,
            again(loop.hairpin).stem_5,
            again(scanned).candidates[0].ends.end_frame,
        ):
            with pytest.raises(ValueError, match="read-only"):
                array[...] = 0
        assert repr(other) == repr(loop)
        assert other.options == loop.options


def test_a_loop_draws_itself_in_its_stem(loop, refused, monkeypatch):
    from matplotlib.figure import Figure

    asked = {}

    def draw(fold, **given):
        asked.update(given)
        return Figure()

    assert isinstance(loop.plot(), Figure)
    monkeypatch.setattr("loopelastica.report.plots.draw_fold", draw)
    assert isinstance(loop.plot(), Figure)
    assert asked["setting"].names == ("U6", "U7", "C8", "G9")
    assert "2koc.pdb" in asked["title"]
    with pytest.raises(le.StructureError, match=r"not folded.*no rod fits"):
        refused.plot()


def test_a_notebook_without_nglview_is_told_which_extra_is_missing(loop, refused, monkeypatch):
    monkeypatch.setitem(sys.modules, "nglview", None)
    with pytest.raises(le.MissingDependencyError, match=r"loopelastica\[notebook\]"):
        loop.view()
    with pytest.raises(le.StructureError, match="not folded"):
        refused.view()
