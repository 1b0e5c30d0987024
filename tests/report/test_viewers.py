"""Scripts that show the candidates in PyMOL and ChimeraX."""

import re

import pytest

from loopelastica._files import data_path
from loopelastica.report.viewers import path_from, write_chimerax

HAIRPIN = data_path("hairpins/2koc.pdb")


@pytest.mark.parametrize(
    ("script", "load"),
    [("view.pml", r"^load (.*), native$"), ("view.cxc", r'^open "(.*)"$')],
)
def test_scripts_show_every_candidate_over_the_file(shipped, script, load):
    folder, fold = shipped
    text = (folder / script).read_text()
    (source,) = re.findall(load, text, re.M)
    assert (folder / source).resolve() == HAIRPIN.resolve()
    assert "traces.pdb" in text
    names = {"view.pml": "color 0x{}, rank_{:04d}", "view.cxc": "color #1.{1} #{0}"}
    for candidate, colour in zip(fold.candidates, ("1f77b4", "ff7f0e", "2ca02c"), strict=False):
        assert names[script].format(colour, candidate.rank) in text
    assert re.search(r"chain A and resi 6\+7\+8\+9|#2\.1/A:6,7,8,9", text)


def test_scripts_escape_negative_numbers(tmp_path, written, koc_lines):
    lines = [s[:22] + f"{int(s[22:26]) - 8:4d}" + s[26:] for s in koc_lines]
    path = tmp_path / "negative.pdb"
    path.write_text("\n".join([*lines, "END", ""]))
    folder, _ = written(path, tmp_path)
    assert r"resi \-2+\-1+0+1" in (folder / "view.pml").read_text()
    assert "/A:-2,-1,0,1 atoms" in (folder / "view.cxc").read_text()


def test_paths_hold_when_both_ends_are_moved(tmp_path):
    (tmp_path / "a").mkdir()
    assert path_from(tmp_path / "out" / "x", tmp_path / "a" / "b.pdb") == "../../a/b.pdb"


@pytest.mark.parametrize(("n_models", "native"), [(1, "#2/A:6,7,8,9"), (2, "#2.1/A:6,7,8,9")])
def test_chimerax_numbers_the_models_of_a_file_that_has_several(tmp_path, fold, n_models, native):
    write_chimerax(tmp_path / "view.cxc", fold, "native.pdb", "A", n_models)
    assert f"show {native} atoms" in (tmp_path / "view.cxc").read_text()
