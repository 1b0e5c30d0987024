"""Scripts that show the candidates in PyMOL and ChimeraX."""

import dataclasses
import os
import re

import pytest

from loopelastica._files import data_path
from loopelastica.report.viewers import path_from, write_chimerax, write_pymol

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


ODD_FILES = (
    *("semi;system touch X;.pdb", "two\nsystem touch X.pdb", 'quote".pdb', "quote'.pdb"),
    *("a,b.pdb", "a b.pdb", "$HOME.pdb", "#1.pdb", "[red].pdb", "back\\.pdb", "é.pdb", "a*.pdb"),
    os.fsdecode(b"\xff.pdb"),
)


@pytest.mark.parametrize("name", ODD_FILES)
def test_scripts_find_a_file_of_any_name_by_one_that_says_nothing(
    tmp_path, written, koc_lines, name
):
    path = tmp_path / name
    path.write_text("\n".join([*koc_lines, "END", ""]))
    folder, _ = written(path, tmp_path)
    for script, load in (
        ("view.pml", "load native.pdb, native"),
        ("view.cxc", 'open "native.pdb"'),
    ):
        lines = (folder / script).read_text(encoding="utf-8").splitlines()
        assert load in lines
        assert not any(sign in line for line in lines for sign in (";", "touch", "$", "[", "é"))
    assert (folder / "native.pdb").resolve() == path.resolve()
    assert (folder / "native.pdb").read_bytes() == path.read_bytes()


def test_so_does_a_folder_of_any_name_and_a_link_that_cannot_be_made_is_a_copy(
    tmp_path, written, koc_lines, monkeypatch
):
    def no_links(*_):
        raise OSError("no links here")

    monkeypatch.setattr("pathlib.Path.symlink_to", no_links)
    path = tmp_path / "my structures" / "2koc.pdb"
    path.parent.mkdir()
    path.write_text("\n".join([*koc_lines, "END", ""]))
    folder, _ = written(path, tmp_path)
    assert not (folder / "native.pdb").is_symlink()
    assert (folder / "native.pdb").read_bytes() == path.read_bytes()


@pytest.mark.parametrize(
    ("chain", "pymol", "chimerax"),
    [
        ("AA", "chain AA and resi 6+7+8+9", "#2/AA:6,7,8,9"),
        ("a b", 'chain "a b" and resi 6+7+8+9', '#2//chain_id="a b":6,7,8,9'),
        ("A-2", 'chain "A-2" and resi 6+7+8+9', '#2//chain_id="A-2":6,7,8,9'),
        *(
            (chain, "resi 6+7+8+9", "#2:6,7,8,9")
            for chain in ("a\nb", "a;system b", 'a"b', "a*", " ")
        ),
    ],
)
def test_a_chain_is_named_where_it_can_be_and_its_residues_by_their_numbers_alone_elsewhere(
    tmp_path, fold, chain, pymol, chimerax
):
    pair = tuple(label.replace("A.", f"{chain}.") for label in fold.hairpin.closing_pair)
    hairpin = dataclasses.replace(fold.hairpin, chain=chain, closing_pair=pair)
    loop = dataclasses.replace(fold, hairpin=hairpin)
    write_pymol(tmp_path / "view.pml", loop, "native.cif", chain)
    write_chimerax(tmp_path / "view.cxc", loop, "native.cif", chain, 1)
    lines = (tmp_path / "view.pml").read_text().splitlines()
    assert f"select loop, native and {pymol}" in lines
    assert f"show {chimerax} atoms" in (tmp_path / "view.cxc").read_text().splitlines()
    # nothing of the label in the headline ends it or begins a command
    assert [line.startswith("#") for line in lines[:4]] == [True, True, False, False]
    assert lines[2] == "set connect_mode, 1"
    assert ";" not in "".join(lines)


def test_an_insertion_code_that_is_no_letter_says_nothing(tmp_path, fold):
    icode = fold.hairpin.icode.astype("<U20")
    icode[0], icode[1] = "; quit", "B"
    loop = dataclasses.replace(fold, hairpin=dataclasses.replace(fold.hairpin, icode=icode))
    write_pymol(tmp_path / "view.pml", loop, "native.pdb", "A")
    assert "resi 6+7B+8+9" in (tmp_path / "view.pml").read_text()
