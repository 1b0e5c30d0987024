"""Runs over files with gaps: a row per strand, and no file stops the others."""

import csv
import json
import os

import gapped
import pytest

from loopelastica.batch.fills import COLUMNS, FILLS
from loopelastica.batch.run import run
from loopelastica.batch.tasks import tasks_of
from loopelastica.filling.options import FillOptions

pytest.importorskip("rdkit")


@pytest.fixture
def fill_all(tmp_path):
    def fill_all(*files, out=tmp_path / "out", jobs=1, **options):
        given = FillOptions(**options).to_dict()
        return run(FILLS, tasks_of(files, given, out), out, jobs)

    return fill_all


def table(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def manifest(folder):
    return json.loads((folder / "fill.json").read_text())


def test_the_table_has_a_row_per_strand_filled_or_refused(tmp_path, fill_all):
    atoms = [*gapped.chain({6, 7}), "TER", *gapped.chain({9}, name="B", moved=40.0)]
    file = gapped.pdb(tmp_path / "ab.pdb", atoms, head=gapped.seqres())
    done = fill_all(file)
    rows = table(tmp_path / "out" / "summary.csv")
    assert tuple(rows[0]) == COLUMNS
    assert [(r["file"], r["chain"], r["first"], r["status"]) for r in rows] == [
        (str(file), "A", "6", "filled"),
        (str(file), "B", "9", "refused"),
    ]
    filled, refused = rows
    assert filled["reason"] == ""
    assert 0.0 < float(filled["expected_10_A"]) < float(filled["expected_rmsd_A"])
    assert refused["expected_rmsd_A"] == refused["shape"] == refused["sound"] == ""
    assert {filled["folder"], refused["folder"]} == {"ab"}
    assert done.failures == (f"{file}: {refused['reason']}",)
    strand = manifest(tmp_path / "out" / "ab")["strands"][0]
    assert float(filled["distance_A"]) == strand["distance_A"]
    assert "nan" not in (tmp_path / "out" / "summary.csv").read_text().lower()


def test_a_bad_file_is_a_row_of_failures_and_the_others_are_filled(tmp_path, fill_all):
    good = [gapped.gapped(tmp_path / name, {7}) for name in ("a.pdb", "z.pdb")]
    (tmp_path / "bad.pdb").write_text("nothing\n")
    protein = tmp_path / "protein.cif"
    protein.write_text("")
    done = fill_all(good[0], tmp_path / "bad.pdb", protein, tmp_path / "absent.pdb", good[1])
    out = tmp_path / "out"
    assert [row["file"] for row in table(out / "summary.csv")] == [str(file) for file in good]
    failures = table(out / "failures.csv")
    assert [os.path.basename(row["file"]) for row in failures] == [
        "bad.pdb", "protein.cif", "absent.pdb",
    ]  # fmt: skip
    assert all(row["failure"].startswith(f"{row['file']}: ") for row in failures)
    assert done.n_done == 5
    assert {p.name for p in out.iterdir() if p.is_dir()} == {"a", "z"}


def test_a_strand_that_one_file_has_not_names_this_file(tmp_path, fill_all):
    one = gapped.pdb(tmp_path / "one.pdb", gapped.chain({6, 7}))
    other = gapped.pdb(tmp_path / "other.pdb", gapped.chain({6, 7}, name="B"))
    done = fill_all(one, other, strands="A.6-7=UU")
    (sentence,) = done.failures
    assert sentence.startswith(f"{other}: `strands` A.6-7=UU: ")
    assert [row["file"] for row in table(tmp_path / "out" / "summary.csv")] == [str(one)]


def test_the_same_run_does_nothing_again(tmp_path, fill_all):
    files = [gapped.gapped(tmp_path / f"{k}.pdb", {7}) for k in range(2)]
    files.append(gapped.pdb(tmp_path / "none.pdb", gapped.chain({7})))
    files.append(gapped.gapped(tmp_path / "whole.pdb", ()))
    first = fill_all(*files)
    before = {p: p.read_bytes() for p in (tmp_path / "out").glob("*.csv")}
    again = fill_all(*files)
    assert (first.n_resumed, again.n_resumed) == (0, 4)
    assert again.failures == first.failures
    assert {p: p.read_bytes() for p in (tmp_path / "out").glob("*.csv")} == before


def test_another_content_or_other_options_are_done_again(tmp_path, fill_all):
    file = gapped.gapped(tmp_path / "a.pdb", {7})
    fill_all(file)
    gapped.gapped(file, {8})
    assert fill_all(file).n_resumed == 0
    assert manifest(tmp_path / "out" / "a")["strands"][0]["first"] == "8"
    assert fill_all(file, candidates=2).n_resumed == 0
    assert fill_all(file, strands="A.8=G").n_resumed == 0
    assert manifest(tmp_path / "out" / "a")["strands"][0]["sequence"] == "G"
    assert fill_all(file, strands="A.8=G").n_resumed == 1


@pytest.mark.parametrize("gone", ["filled.pdb", "fill.json", ""])
def test_so_is_one_whose_folder_was_emptied(tmp_path, fill_all, gone):
    file, folder = gapped.gapped(tmp_path / "a.pdb", {7}), tmp_path / "out" / "a"
    fill_all(file)
    for path in folder.iterdir():
        if gone in ("", path.name):
            path.unlink()
    done = fill_all(file)
    assert (done.n_resumed, done.failures) == (0, ())
    assert {p.name for p in folder.iterdir()} == {"filled.pdb", "fill.json"}


def test_files_of_one_name_get_folders_of_their_own(tmp_path, fill_all):
    files = [gapped.gapped(tmp_path / name / "a.pdb", {k}) for k, name in ((7, "x"), (8, "y"))]
    files.append(gapped.gapped_cif(tmp_path / "a.cif", {9}))
    fill_all(*files)
    out = tmp_path / "out"
    assert {p.name for p in out.iterdir() if p.is_dir()} == {"a", "a_2", "a_3"}
    firsts = [manifest(out / name)["strands"][0]["first"] for name in ("a", "a_2", "a_3")]
    assert firsts == ["7", "8", "9"]
    assert (out / "a_3" / "filled.cif").is_file()
    assert fill_all(*files).n_resumed == 3


def test_a_users_file_in_the_folder_stays_and_the_run_says_so(tmp_path, fill_all):
    file, theirs = gapped.gapped(tmp_path / "a.pdb", {7}), tmp_path / "out" / "a" / "filled.pdb"
    theirs.parent.mkdir(parents=True)
    theirs.write_text("mine")
    done = fill_all(file)
    (sentence,) = done.failures
    assert str(theirs) in sentence
    assert theirs.read_text() == "mine"
    assert {p.name for p in theirs.parent.iterdir()} == {"filled.pdb"}
    assert table(tmp_path / "out" / "summary.csv") == []
    theirs.unlink()
    again = fill_all(file)
    assert (again.n_resumed, again.failures) == (0, ())


def test_notes_name_what_was_completed_and_what_is_odd(tmp_path, fill_all):
    file = gapped.gapped(tmp_path / "a.pdb", {1, 7, (8, "N3"), (11, "N3")})
    notes = fill_all(file).notes
    for fragment in ("A.C8 beside the gap lacks N3", "added to A.C8, A.U11", "at the 5' end"):
        assert any(fragment in note for note in notes)
    assert all(note.startswith(f"{file}: ") for note in notes)


def test_a_file_without_a_gap_is_done_and_has_no_row(tmp_path, fill_all):
    file = gapped.gapped(tmp_path / "a.pdb", ())
    done = fill_all(file)
    assert (done.failures, done.n_rows) == ((), 0)
    assert done.notes == (f"{file}: no internal gap; nothing to fill",)
    assert {p.name for p in (tmp_path / "out" / "a").iterdir()} == {"fill.json"}


@pytest.mark.parametrize("name", ["=1+1.pdb", "a\nb.pdb", "a b;c.pdb", os.fsdecode(b"\xff.pdb")])
def test_a_file_of_any_name_is_filled(tmp_path, fill_all, name):
    file = gapped.gapped(tmp_path / name, {7})
    assert fill_all(file).failures == ()
    (row,) = table(tmp_path / "out" / "summary.csv")
    assert (tmp_path / "out" / row["folder"] / "fill.json").is_file()
    assert fill_all(file).n_resumed == 1


@pytest.mark.slow
def test_two_processes_write_what_one_writes(tmp_path, fill_all):
    pytest.importorskip("distributed")
    files = [gapped.gapped(tmp_path / f"{k}" / "a.pdb", {6, 7, k}) for k in (7, 8)]
    files.append(gapped.pdb(tmp_path / "none.pdb", gapped.chain({7})))
    files.append(tmp_path / "absent.pdb")
    one, two = tmp_path / "one", tmp_path / "two"
    first, second = fill_all(*files, out=one), fill_all(*files, out=two, jobs=2)
    assert second.n_done == first.n_done == 4
    names = sorted(p.relative_to(one) for p in one.rglob("*") if not p.name.startswith("."))
    assert names == sorted(p.relative_to(two) for p in two.rglob("*") if not p.name.startswith("."))
    for name in names:
        if (one / name).is_file() and name.suffix != ".parquet":
            assert (one / name).read_bytes() == (two / name).read_bytes(), name
