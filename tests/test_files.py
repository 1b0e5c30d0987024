"""Whole or not at all."""

import contextlib
import errno
import json
import os
import pickle
import stat
from pathlib import Path

import pytest

import loopelastica
from loopelastica._files import (
    OutputError,
    cells,
    make_folder,
    sha256,
    whole_file,
    whole_folder,
    write_csv,
    write_json,
    write_text,
)


def fail_half_way(whole, path):
    with whole(path) as part:
        (part if part.is_file() else part / "d").write_text("half")
        raise RuntimeError


def whole_result(path):
    return whole_folder(path, "all.json")


def write_result(path, **files):
    with whole_result(path) as part:
        for name, text in files.items():
            (part / name).write_text(text)
        manifest = {"program": "loopelastica", "files": [*files, "all.json"]}
        (part / "all.json").write_text(json.dumps(manifest))


def names(folder):
    return sorted(p.name for p in folder.iterdir())


def test_what_fails_leaves_the_former_content_and_nothing_else(tmp_path):
    file, folder = tmp_path / "a.txt", tmp_path / "b"
    file.write_text("former")
    write_result(folder, c="former")
    for whole, path in ((whole_file, file), (whole_result, folder)):
        with pytest.raises(RuntimeError):
            fail_half_way(whole, path)
    with pytest.raises(ValueError, match="JSON"):
        write_json(file, {"value": float("nan")})
    assert names(tmp_path) == ["a.txt", "b"]
    assert file.read_text() == "former"
    assert names(folder) == ["all.json", "c"]


def test_what_is_written_is_there_for_the_group_as_any_other_file(tmp_path):
    mask = os.umask(0o027)
    try:
        write_json(tmp_path / "new" / "a.json", {"Å": 1})
        write_result(tmp_path / "folder")
    finally:
        os.umask(mask)
    assert json.loads((tmp_path / "new" / "a.json").read_text()) == {"Å": 1}
    assert stat.S_IMODE((tmp_path / "new" / "a.json").stat().st_mode) == 0o640
    assert stat.S_IMODE((tmp_path / "folder").stat().st_mode) == 0o750


def test_names_of_any_length_can_be_written(tmp_path):
    write_text(tmp_path / f"{'a' * 251}.txt", "text")
    write_result(tmp_path / ("b" * 249), a="text")
    assert len(names(tmp_path)) == 2


def test_tables_have_the_columns_of_their_first_row_or_those_given(tmp_path):
    rows = [{"a": 1, "b": None}, {"a": 2, "b": "x,y"}]
    assert write_csv(tmp_path / "t.csv", rows) == 2
    assert (tmp_path / "t.csv").read_bytes() == b'a,b\n1,\n2,"x,y"\n'
    assert write_csv(tmp_path / "t.csv", iter(rows), ("b",)) == 2
    assert (tmp_path / "t.csv").read_bytes() == b'b\n""\n"x,y"\n'
    assert write_csv(tmp_path / "t.csv", [], ("a", "b")) == 0
    assert (tmp_path / "t.csv").read_bytes() == b"a,b\n"
    with pytest.raises(ValueError, match="c"):
        write_csv(tmp_path / "t.csv", [*rows, {"a": 1, "b": 2, "c": 3}])


@pytest.mark.parametrize("text", ["=1+1", "+1+1", "-2+3", "@SUM(A1)", " =1", "＝1", "-5A", "-"])
def test_a_cell_that_a_spreadsheet_would_compute_begins_with_an_apostrophe(text):
    assert cells({"a": text}) == {"a": f"'{text}"}


@pytest.mark.parametrize("value", ["-1.5", "+2e-3", -1.5, None, "A6-9", "a=b", True, ""])
def test_numbers_and_usual_names_are_written_as_they_are(value):
    assert cells({"a": value}) == {"a": value}


def test_a_name_breaks_no_line_of_a_table_and_no_file(tmp_path):
    write_csv(tmp_path / "t.csv", [{"file": "a\nb\r\tc\udcff.pdb", "rank": 1}])
    assert (tmp_path / "t.csv").read_bytes() == b"file,rank\na\\nb\\r\\tc\\udcff.pdb,1\n"
    write_json(tmp_path / "t.json", {"file": "a\nb\udcff"})
    assert json.loads((tmp_path / "t.json").read_text()) == {"file": "a\nb\udcff"}


def test_the_citation_names_this_version():
    root = Path(__file__).resolve().parents[1]
    cited = [line for line in (root / "CITATION.cff").read_text().splitlines() if "version" in line]
    assert f"version: {loopelastica.__version__}" in cited


def test_a_folder_that_is_written_again_holds_the_new_files_only(tmp_path):
    write_result(tmp_path / "loop", former="1", both="1")
    write_result(tmp_path / "loop", new="2", both="2")
    assert names(tmp_path) == ["loop"]
    assert names(tmp_path / "loop") == ["all.json", "both", "new"]
    assert (tmp_path / "loop" / "both").read_text() == "2"


def test_what_a_user_put_into_a_folder_stays_there(tmp_path):
    write_result(tmp_path / "loop", former="1")
    (tmp_path / "loop" / "notes.txt").write_text("mine")
    (tmp_path / "loop" / "more").mkdir()
    (tmp_path / "loop" / "more" / "notes.txt").write_text("mine")
    write_result(tmp_path / "loop", new="2")
    assert names(tmp_path / "loop") == ["all.json", "more", "new", "notes.txt"]
    assert (tmp_path / "loop" / "more" / "notes.txt").read_text() == "mine"


@pytest.mark.parametrize("kind", ["file", "folder", "link"])
def test_a_name_that_is_taken_refuses_the_result_and_changes_nothing(tmp_path, kind):
    write_result(tmp_path / "loop", a="1", b="1")
    theirs, target = tmp_path / "loop" / "c", tmp_path / "target"
    target.write_text("mine")
    if kind == "file":
        theirs.write_text("mine")
    elif kind == "folder":
        theirs.mkdir()
    else:
        theirs.symlink_to(target)
    with pytest.raises(FileExistsError, match="not written by this program") as refusal:
        write_result(tmp_path / "loop", a="2", c="2")
    assert refusal.value.filename == str(theirs)
    assert names(tmp_path) == ["loop", "target"]
    assert names(tmp_path / "loop") == ["a", "all.json", "b", "c"]
    assert (tmp_path / "loop" / "a").read_text() == "1"
    assert target.read_text() == "mine"


def test_a_folder_without_a_manifest_is_not_replaced(tmp_path):
    (tmp_path / "loop").mkdir()
    (tmp_path / "loop" / "a").write_text("of an earlier version")
    with pytest.raises(FileExistsError):
        write_result(tmp_path / "loop", a="2")
    assert (tmp_path / "loop" / "a").read_text() == "of an earlier version"
    # but files beside it are no harm
    write_result(tmp_path / "loop", b="2")
    assert names(tmp_path / "loop") == ["a", "all.json", "b"]


def test_a_result_whose_manifest_is_gone_is_written_again_where_nothing_is_lost(tmp_path):
    write_result(tmp_path / "loop", a="1")
    (tmp_path / "loop" / "all.json").unlink()
    with pytest.raises(FileExistsError):
        write_result(tmp_path / "loop", a="2")
    write_result(tmp_path / "loop", a="1")
    assert names(tmp_path / "loop") == ["a", "all.json"]


@pytest.mark.parametrize(
    "manifest",
    [
        {"program": "loopelastica", "files": ["../theirs", "a", "all.json"]},
        {"program": "loopelastica", "files": ["..", "a", "all.json"]},
        {"program": "loopelastica", "files": [["a"], "all.json"]},
        {"program": "loopelastica", "files": 7},
        {"program": "other", "files": ["a", "all.json"]},
        [],
    ],
)
def test_a_forged_manifest_gives_nothing_away(tmp_path, manifest):
    (tmp_path / "theirs").write_text("mine")
    (tmp_path / "loop").mkdir()
    (tmp_path / "loop" / "all.json").write_text(json.dumps(manifest))
    (tmp_path / "loop" / "a").write_text("mine")
    with pytest.raises(FileExistsError):
        write_result(tmp_path / "loop", b="2")
    assert names(tmp_path / "loop") == ["a", "all.json"]
    assert (tmp_path / "theirs").read_text() == "mine"


@pytest.mark.parametrize("kind", ["link", "file"])
def test_a_folder_that_is_a_link_or_a_file_is_left_alone(tmp_path, kind):
    write_result(tmp_path / "elsewhere", a="1")
    if kind == "link":
        (tmp_path / "loop").symlink_to(tmp_path / "elsewhere")
    else:
        (tmp_path / "loop").write_text("mine")
    with pytest.raises(FileExistsError, match="no result is written there"):
        write_result(tmp_path / "loop", b="2")
    assert names(tmp_path / "elsewhere") == ["a", "all.json"]
    assert names(tmp_path) == ["elsewhere", "loop"]


def test_a_hidden_folder_of_somebody_else_is_left_alone(tmp_path):
    (tmp_path / ".loop.part").mkdir()
    (tmp_path / ".loop.part" / "notes").write_text("mine")
    with pytest.raises(FileExistsError, match="in the way"):
        write_result(tmp_path / "loop", a="1")
    assert names(tmp_path / ".loop.part") == ["notes"]
    # and one that only looks alike
    (tmp_path / ".l.old").mkdir()
    write_result(tmp_path / "l", a="1")
    assert names(tmp_path) == [".l.old", ".loop.part", "l"]


def test_two_runs_do_not_write_one_folder_at_once(tmp_path):
    with whole_result(tmp_path / "loop") as part:
        with pytest.raises(FileExistsError, match="another run"):
            write_result(tmp_path / "loop", a="2")
        (part / "all.json").write_text('{"program": "loopelastica", "files": ["all.json"]}')
    assert names(tmp_path / "loop") == ["all.json"]


class Killed(BaseException):
    """Ends a run without any of its cleaning up."""


@pytest.mark.parametrize("step", range(32))
def test_a_run_killed_at_any_step_leaves_one_whole_result_or_none_and_the_next_one_mends_it(
    tmp_path, monkeypatch, step
):
    loop = tmp_path / "loop"
    write_result(loop, former="1", both="1")
    (loop / "notes").write_text("mine")
    left = step

    def until_killed(function):
        def counted(*arguments, **keywords):
            nonlocal left
            left -= 1
            if left < 0:
                raise Killed
            return function(*arguments, **keywords)

        return counted

    with monkeypatch.context() as patch, contextlib.suppress(Killed):
        for name in ("mkdir", "rmdir", "unlink", "rename", "replace", "open"):
            patch.setattr(Path, name, until_killed(getattr(Path, name)))
        write_result(loop, new="2", both="2")
    if (loop / "all.json").exists():
        own = {n for n in names(loop) if not n.startswith(".")} - {"notes"}
        assert own == set(json.loads((loop / "all.json").read_text())["files"])
        assert (loop / "both").read_text() == ("2" if "new" in own else "1")
    write_result(loop, new="3", both="3")
    assert names(loop) == ["all.json", "both", "new", "notes"]
    assert (loop / "both").read_text() == "3"
    assert (loop / "notes").read_text() == "mine"
    assert names(tmp_path) == ["loop"]


def test_the_digest_is_the_published_one_of_abc(tmp_path):
    (tmp_path / "abc").write_bytes(b"abc")
    expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    assert sha256(tmp_path / "abc") == expected


def no_space(*_, **__):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_what_cannot_be_written_is_named_as_the_user_knows_it(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    folder = tmp_path / "folder.v2"
    for path in (tmp_path / "file" / "a.csv", tmp_path / "file" / "a" / "b" / "c.csv"):
        with pytest.raises(OutputError, match=rf"^{path}: cannot be written \((Not|a file)"):
            write_csv(path, [{"a": 1}])
    with pytest.raises(OutputError, match=rf"^{tmp_path / 'file'}: .*a file is there"):
        make_folder(tmp_path / "file")
    folder.mkdir()
    with pytest.raises(OutputError, match=rf"^{folder}: cannot be written \(Is a directory"):
        write_text(folder, "text")
    monkeypatch.setattr(Path, "write_text", no_space)
    sentence = rf"^{tmp_path / 'loop'}: cannot be written \(No space left on device\)$"
    with (
        pytest.raises(OutputError, match=sentence),
        whole_folder(tmp_path / "loop", "m.json") as part,
    ):
        write_text(part / "a.txt", "text")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "folder.v2"]


def test_an_error_of_reading_is_not_one_of_writing(tmp_path):
    with pytest.raises(FileNotFoundError) as caught, whole_folder(tmp_path / "loop", "m.json"):
        sha256(tmp_path / "absent.pdb")
    assert not isinstance(caught.value, OutputError)
    assert caught.value.filename == str(tmp_path / "absent.pdb")


def test_the_sentence_comes_back_from_another_process():
    error = OutputError(errno.ENOSPC, "No space left on device", "out/a.csv")
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.errno) == (str(error), errno.ENOSPC)


def test_names_that_are_no_utf8_are_written_all_the_same(tmp_path):
    name = os.fsdecode(b"a\xff.pdb")
    write_csv(tmp_path / "t.csv", [{"file": name}])
    assert (tmp_path / "t.csv").read_text() == "file\na\\udcff.pdb\n"
    write_json(tmp_path / "t.json", {"file": name})
    assert json.loads((tmp_path / "t.json").read_text()) == {"file": name}


def test_results_with_manifests_of_their_own_share_a_folder(tmp_path):
    for name in ("a", "b", "a"):
        with whole_folder(tmp_path / "out", f"{name}.json", shared=True) as part:
            (part / f"{name}.txt").write_text(name)
            listed = [f"{name}.txt", f"{name}.json"]
            write_json(part / f"{name}.json", {"program": "loopelastica", "files": listed})
    assert names(tmp_path) == ["out"]
    assert names(tmp_path / "out") == ["a.json", "a.txt", "b.json", "b.txt"]


def test_a_shared_result_that_fails_leaves_the_others(tmp_path):
    (tmp_path / "mine").write_text("mine")
    with pytest.raises(RuntimeError):
        fail_half_way(lambda path: whole_folder(path, "a.json", shared=True), tmp_path)
    assert names(tmp_path) == ["mine"]
