"""A file is done before only where its folders hold its very result."""

import csv
import json
import os

import pytest

from loopelastica._files import data_path
from loopelastica.batch.folds import FOLDS
from loopelastica.batch.run import run
from loopelastica.batch.tasks import tasks_of
from loopelastica.folding.options import FoldOptions

OPTIONS = {**FoldOptions(all_models=False, max_candidates=1).to_dict(), "plot": False}
TEXT = data_path("hairpins/2koc.pdb").read_text().split("ENDMDL")[0] + "ENDMDL\nEND\n"
OTHER = TEXT.replace("MODEL        1", "REMARK  another content\nMODEL        1")


@pytest.fixture
def fold_all(tmp_path):
    def fold_all(*files, out=tmp_path / "out", **options):
        return run(FOLDS, tasks_of(files, {**OPTIONS, **options}, out), out)

    return fold_all


def sha256_in(out, folder="a_A6-9"):
    return json.loads((out / folder / "ranking.json").read_text())["input"]["sha256"]


def test_a_result_that_another_content_has_taken_the_place_of_is_made_again(tmp_path, fold_all):
    file = tmp_path / "a.pdb"
    file.write_text(TEXT)
    assert fold_all(file).n_resumed == 0
    first = sha256_in(tmp_path / "out")
    file.write_text(OTHER)
    assert fold_all(file).n_resumed == 0
    assert sha256_in(tmp_path / "out") != first
    file.write_text(TEXT)
    assert fold_all(file).n_resumed == 0
    assert sha256_in(tmp_path / "out") == first
    assert fold_all(file).n_resumed == 1


def test_so_is_one_of_other_options(tmp_path, fold_all):
    file = tmp_path / "a.pdb"
    file.write_text(TEXT)
    taper = [OPTIONS["taper"], 0.0, OPTIONS["taper"]]
    assert [fold_all(file, taper=value).n_resumed for value in taper] == [0, 0, 0]
    manifest = json.loads((tmp_path / "out" / "a_A6-9" / "ranking.json").read_text())
    assert manifest["parameters"]["taper"] == taper[0]
    assert fold_all(file).n_resumed == 1


@pytest.mark.parametrize("gone", ["line.csv", "ranking.json", ""])
def test_so_is_one_whose_folder_was_emptied(tmp_path, fold_all, gone):
    file, folder = tmp_path / "a.pdb", tmp_path / "out" / "a_A6-9"
    file.write_text(TEXT)
    fold_all(file)
    before = {path.name for path in folder.iterdir()}
    for path in folder.iterdir():
        if gone in ("", path.name):
            path.unlink()
    done = fold_all(file)
    assert (done.n_resumed, done.failures) == (0, ())
    assert {path.name for path in folder.iterdir()} == before


def test_one_content_under_two_paths_is_two_results(tmp_path, fold_all):
    files = [tmp_path / name / "a.pdb" for name in "xy"]
    for file in files:
        file.parent.mkdir()
        file.write_text(TEXT)
    assert fold_all(files[0]).n_resumed == 0
    # of the same name, so in the same folder, whose scripts show the other file
    assert fold_all(files[1]).n_resumed == 0
    assert fold_all(files[0]).n_resumed == 0
    assert "load ../../x/a.pdb" in (tmp_path / "out" / "a_A6-9" / "view.pml").read_text()
    assert fold_all(*files).n_resumed == 1
    assert fold_all(*files).n_resumed == 2


def test_files_whose_names_become_one_get_two_folders(tmp_path, fold_all):
    files = [tmp_path / name for name in ("a;b.pdb", "a b.pdb")]
    for file in files:
        file.write_text(TEXT)
    fold_all(*files)
    folders = {path.name for path in (tmp_path / "out").iterdir() if path.is_dir()}
    assert folders == {"a_b_A6-9", "a_b_A6-9_2"}
    assert fold_all(*files).n_resumed == 2


def test_a_file_without_a_loop_is_done_once_and_for_all(tmp_path, fold_all, koc_lines):
    file = tmp_path / "a.pdb"
    strand = [line for line in koc_lines if int(line[22:26]) < 6]
    file.write_text("\n".join([*strand, "END", ""]))
    assert len(fold_all(file).failures) == 1
    again = fold_all(file)
    assert (again.n_resumed, len(again.failures)) == (1, 1)


def test_a_refused_folder_is_a_sentence_and_is_tried_again(tmp_path, fold_all):
    file, theirs = tmp_path / "a.pdb", tmp_path / "out" / "a_A6-9" / "ranking.csv"
    file.write_text(TEXT)
    theirs.parent.mkdir(parents=True)
    theirs.write_text("mine")
    (sentence,) = fold_all(file).failures
    assert str(theirs) in sentence
    assert theirs.read_text() == "mine"
    theirs.unlink()
    done = fold_all(file)
    assert (done.n_resumed, done.failures) == (0, ())


def test_hidden_folders_of_a_user_are_left_alone(tmp_path, fold_all):
    for name in (".a_A6-9.old", ".[a]_A6-9.x"):
        (tmp_path / "out" / name).mkdir(parents=True)
        (tmp_path / "out" / name / "notes").write_text("mine")
    for name in ("a.pdb", "[a].pdb", "a_.pdb"):
        (tmp_path / name).write_text(TEXT)
    fold_all(*(tmp_path / name for name in ("a.pdb", "[a].pdb", "a_.pdb")))
    kept = sorted(path.name for path in (tmp_path / "out").glob(".*") if path.is_dir())
    assert kept == [".[a]_A6-9.x", ".a_A6-9.old"]


@pytest.mark.parametrize(
    "name", ["=1+1.pdb", "a\nb.pdb", "semi;system touch X;.pdb", os.fsdecode(b"\xff.pdb")]
)
def test_a_name_breaks_no_row_of_the_table(tmp_path, fold_all, name):
    (tmp_path / name).write_text(TEXT)
    fold_all(tmp_path / name)
    with (tmp_path / "out" / "summary.csv").open() as file:
        (row,) = csv.DictReader(file)
    shown = {"a\nb.pdb": "a\\nb.pdb", "\udcff.pdb": "\\udcff.pdb"}
    assert row["file"] == f"{tmp_path}/{shown.get(name, name)}"
    assert (tmp_path / "out" / row["folder"] / "ranking.json").is_file()
    assert fold_all(tmp_path / name).n_resumed == 1
