"""Folders of results: their names, their key, and what in them is the program's own."""

import dataclasses
import json
import os

import pytest

from loopelastica._files import data_path
from loopelastica.report.folder import MANIFEST, Folders, is_there, write_fold

HAIRPIN = data_path("hairpins/2koc.pdb")


def named(fold, name):
    return dataclasses.replace(fold, hairpin=dataclasses.replace(fold.hairpin, name=name))


def files(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture(scope="module")
def loop(fold):
    """One candidate is enough here."""
    return dataclasses.replace(fold, candidates=fold.candidates[:1])


def test_folders_are_named_after_the_file_and_the_loop(tmp_path, fold):
    folders = Folders(tmp_path)
    names = [folders.claim(tmp_path / name, fold).name for name in ("2KOC.pdb.gz", "a/2KOC.cif")]
    assert names == ["2KOC_A6-9", "2KOC_A6-9_2"]


@pytest.mark.parametrize("chain", ["/../../", "..", "a b", "a\nb", "=1+1", "x" * 400, "é" * 400])
def test_no_name_of_a_chain_or_a_file_leads_out_of_the_folder(tmp_path, fold, chain):
    for stem in ("2koc", "..", "s" * 250, "-x"):
        path = Folders(tmp_path).claim(tmp_path / f"{stem}.pdb", named(fold, f"{chain}6-9"))
        assert path.parent == tmp_path
        assert os.path.normpath(path) == str(path)
        assert path.name.endswith("6-9")
        path.with_name(f".{path.name}_1000.part").mkdir()


def test_loops_with_one_safe_name_get_different_folders(tmp_path, fold):
    folders = Folders(tmp_path)
    loops = [named(fold, name) for name in ("a b6-9", "a_b6-9", "a;b6-9")]
    names = [folders.claim(tmp_path / "x.pdb", loop).name for loop in loops]
    assert names == ["x_a_b6-9", "x_a_b6-9_2", "x_a_b6-9_3"]


def test_files_of_one_name_that_are_folded_apart_never_share_a_folder(tmp_path, fold):
    names = []
    for number in (1, 2, 3):
        folders = Folders(tmp_path, number)
        names += [folders.claim(tmp_path / "x.pdb", fold).name for _ in range(3)]
    assert len(set(names)) == 9
    assert names[::3] == ["x_A6-9", "x_A6-9_2", "x_A6-9_3"]


def test_the_folder_says_what_it_came_from_and_which_files_are_its_own(tmp_path, koc, loop):
    key = write_fold(tmp_path / "a", HAIRPIN, loop, koc, plot=False)
    manifest = json.loads((tmp_path / "a" / MANIFEST).read_text())
    assert manifest["files"] == sorted(files(tmp_path / "a"))
    assert manifest["parameters"] == loop.options.to_dict()
    assert len(manifest["input"]["sha256"]) == 64
    assert is_there(tmp_path / "a", json.loads(json.dumps(key)))


@pytest.mark.parametrize("change", ["content", "path", "options", "plot", "version"])
def test_a_folder_with_another_key_is_another_result(tmp_path, koc, loop, change, monkeypatch):
    source = tmp_path / "in" / "2koc.pdb"
    source.parent.mkdir()
    source.write_bytes(HAIRPIN.read_bytes())
    folder = tmp_path / "out" / "a"
    key = write_fold(folder, source, loop, koc, plot=False)
    if change == "content":
        source.write_bytes(b"REMARK\n" + HAIRPIN.read_bytes())
    elif change == "path":
        source = source.rename(tmp_path / "2koc.pdb")
    elif change == "options":
        options = dataclasses.replace(loop.options, persistence_length_A=11.0)
        loop = dataclasses.replace(loop, options=options)
    elif change == "version":
        monkeypatch.setattr("loopelastica.report.records.__version__", "0.0.0")
    other = write_fold(folder, source, loop, koc, plot=change == "plot")
    assert is_there(folder, other)
    assert not is_there(folder, key)


@pytest.mark.parametrize("gone", ["line.csv", MANIFEST, "all"])
def test_a_folder_that_lacks_a_file_is_no_result(tmp_path, koc, loop, gone):
    key = write_fold(tmp_path / "a", HAIRPIN, loop, koc, plot=False)
    for path in (tmp_path / "a").iterdir():
        if gone in ("all", path.name):
            path.unlink()
    assert not is_there(tmp_path / "a", key)
    # and is made whole by the next run
    assert is_there(tmp_path / "a", write_fold(tmp_path / "a", HAIRPIN, loop, koc, plot=False))


def test_writing_again_keeps_the_users_files_and_drops_those_of_the_former_result(
    tmp_path, koc, loop
):
    folder = tmp_path / "a"
    write_fold(folder, HAIRPIN, loop, koc, plot=True)
    (folder / "notes.txt").write_text("mine")
    write_fold(folder, HAIRPIN, loop, koc, plot=False)
    assert "plot.png" not in files(folder)
    assert files(folder)["notes.txt"] == b"mine"


def test_a_folder_of_an_earlier_version_is_refused_and_left_as_it_is(tmp_path, koc, loop):
    folder = tmp_path / "a"
    write_fold(folder, HAIRPIN, loop, koc, plot=False)
    manifest = json.loads((folder / MANIFEST).read_text())
    del manifest["files"]
    (folder / MANIFEST).write_text(json.dumps(manifest))
    before = files(folder)
    with pytest.raises(FileExistsError, match="not written by this program"):
        write_fold(folder, HAIRPIN, loop, koc, plot=False)
    assert files(folder) == before
    assert [path.name for path in tmp_path.iterdir()] == ["a"]
