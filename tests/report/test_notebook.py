"""A loop in a notebook."""

import sys

import pytest

from loopelastica.errors import MissingDependencyError
from loopelastica.molecule.setting import Settings
from loopelastica.report.notebook import view_fold


def messages(view, name):
    return [m for m in view._ngl_msg_archive if m["methodName"] == name]


def test_every_candidate_is_a_component_that_can_be_hidden(koc, fold):
    pytest.importorskip("nglview")
    view = view_fold(fold, koc)
    shapes = {m["args"][0]: m["args"][1] for m in messages(view, "addShape")}
    shown = [name for name in shapes if name[0].isdigit()]
    assert [int(name.split()[0]) for name in shown] == [c.rank for c in fold.candidates]
    assert {"file's loop", "stem", "names"} < set(shapes)
    assert [shape[-1] for shape in shapes["names"]] == ["C5", "U6", "U7", "C8", "G9", "G10"]
    hidden = sum(c.contacts.touching and c.rank > 1 for c in fold.candidates)
    assert hidden
    assert len(messages(view, "setVisibility")) == hidden


def test_the_structure_is_there_only_near_the_loop(koc, fold):
    pytest.importorskip("nglview")
    (loaded,) = messages(view_fold(fold, koc), "loadFile")
    text = loaded["args"][0]["data"]
    assert 300 < text.count("\nATOM") <= len(koc.universe.atoms)


def test_without_a_structure_there_are_lines_and_with_its_setting_the_stem(koc, fold):
    pytest.importorskip("nglview")
    names = [m["args"][0] for m in messages(view_fold(fold), "addShape")]
    assert "stem" not in names
    view = view_fold(fold, setting=Settings(koc).of(fold.hairpin))
    assert "stem" in [m["args"][0] for m in messages(view, "addShape")]
    assert not messages(view, "loadFile")


def test_nglview_that_is_missing_is_named_with_its_extra(fold, monkeypatch):
    monkeypatch.setitem(sys.modules, "nglview", None)
    with pytest.raises(MissingDependencyError, match=r"loopelastica\[notebook\]"):
        view_fold(fold)


def test_a_loop_that_was_not_folded_says_why_it_cannot_be_shown(refused):
    with pytest.raises(ValueError, match=r"`fold` has no candidates to show: .*line"):
        view_fold(refused)
