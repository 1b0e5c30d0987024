"""Whole or not at all."""

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


def test_what_fails_leaves_the_former_content_and_nothing_else(tmp_path):
    file, folder = tmp_path / "a.txt", tmp_path / "b"
    file.write_text("former")
    folder.mkdir()
    (folder / "c").write_text("former")
    for whole, path in ((whole_file, file), (whole_folder, folder)):
        with pytest.raises(RuntimeError):
            fail_half_way(whole, path)
    with pytest.raises(ValueError, match="JSON"):
        write_json(file, {"value": float("nan")})
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.txt", "b"]
    assert file.read_text() == "former"
    assert [p.name for p in folder.iterdir()] == ["c"]


def test_what_is_written_is_there_for_the_group_as_any_other_file(tmp_path):
    mask = os.umask(0o027)
    try:
        write_json(tmp_path / "new" / "a.json", {"Å": 1})
        with whole_folder(tmp_path / "folder"):
            pass
    finally:
        os.umask(mask)
    assert json.loads((tmp_path / "new" / "a.json").read_text()) == {"Å": 1}
    assert stat.S_IMODE((tmp_path / "new" / "a.json").stat().st_mode) == 0o640
    assert stat.S_IMODE((tmp_path / "folder").stat().st_mode) == 0o750


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


def test_the_citation_names_this_version():
    root = Path(__file__).resolve().parents[1]
    cited = [line for line in (root / "CITATION.cff").read_text().splitlines() if "version" in line]
    assert f"version: {loopelastica.__version__}" in cited


def test_a_folder_that_is_written_again_holds_the_new_files_only(tmp_path):
    for name in ("former", "new"):
        with whole_folder(tmp_path / "loop") as part:
            (part / name).write_text(name)
    assert [p.name for p in tmp_path.iterdir()] == ["loop"]
    assert [p.name for p in (tmp_path / "loop").iterdir()] == ["new"]


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
    with pytest.raises(OutputError, match=sentence), whole_folder(tmp_path / "loop") as part:
        write_text(part / "a.txt", "text")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "folder.v2"]


def test_an_error_of_reading_is_not_one_of_writing(tmp_path):
    with pytest.raises(FileNotFoundError) as caught, whole_folder(tmp_path / "loop"):
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
