"""The file of a library: round trip, bytes, and what is no such file."""

import io
import json
import os
import pickle
import zipfile

import numpy as np
import pytest
from loop_shapes import found

import loopelastica as le
from loopelastica._files import OutputError, TakenError
from loopelastica._version import __version__
from loopelastica.folding.library import Library
from loopelastica.folding.library_file import FORMAT, load_library, save_library


@pytest.fixture(scope="module")
def library():
    sequences = ("CUUUG", "GAAAC", "CUUCGG", "GGAAAC", "CUUCGG", "GUUUUUUUC")
    return Library.of(
        found(sequence, f"{k + 1}abc", is_dna=k == 1, seed=k)
        for k, sequence in enumerate(sequences)
    )


@pytest.fixture
def path(library, tmp_path):
    save_library(library, tmp_path / "loops.lib")
    return tmp_path / "loops.lib"


def changed(path, change):
    """The file with its arrays changed."""
    with np.load(path) as archive:
        arrays = dict(archive)
    change(arrays)
    with path.open("wb") as file:
        np.savez_compressed(file, **arrays)
    return path


def about(**changes):
    def change(arrays):
        content = json.loads(arrays["about"].tobytes()) | changes
        arrays["about"] = np.frombuffer(json.dumps(content).encode(), dtype=np.uint8)

    return change


def read_whole(path):
    return [table.steps_A.tolist() for _, table in load_library(path).tables()]


def refusal(path):
    with pytest.raises(le.LoopelasticaError) as error:
        read_whole(path)
    sentence = str(error.value)
    assert sentence.startswith(f"{path}: ")
    assert "\n" not in sentence
    return sentence


def test_what_is_written_is_read(library, path):
    loaded = load_library(path)
    assert loaded.counts == library.counts
    for (_, written), (_, read) in zip(library.tables(), loaded.tables(), strict=True):
        for name in ("is_dna", "letters", "entries", "sources", "copies"):
            assert getattr(read, name).tolist() == getattr(written, name).tolist()
        np.testing.assert_allclose(read.steps_A, written.steps_A, atol=1e-6)
        np.testing.assert_allclose(read.end_frames, written.end_frames, atol=1e-6)
        np.testing.assert_allclose(read.stem_rms_A, written.stem_rms_A, atol=1e-6)
        # turns are turns, to all digits
        product = read.end_frames @ read.end_frames.swapaxes(1, 2)
        np.testing.assert_allclose(product, np.tile(np.eye(3), (len(read), 1, 1)), atol=1e-14)
        assert (np.linalg.det(read.end_frames) > 0).all()
    assert len(loaded.of_length(4, is_dna=False)) == 3
    assert len(loaded.of_length(5)) == 0


def test_written_again_or_from_what_was_read_it_is_the_same_to_the_byte(library, path, tmp_path):
    for name, source in (("a.lib", library), ("b.lib", load_library(path))):
        save_library(source, tmp_path / name)
        assert (tmp_path / name).read_bytes() == path.read_bytes()
    assert {p.name for p in tmp_path.iterdir()} == {"loops.lib", "a.lib", "b.lib"}


def test_an_empty_library_is_written_and_read(tmp_path):
    save_library(Library.of([]), tmp_path / "none.lib")
    loaded = load_library(tmp_path / "none.lib")
    assert len(loaded) == len(loaded.of_length(4)) == 0


def test_only_the_table_that_is_asked_for_is_read(path):
    """A table that is damaged disturbs nobody who needs another one."""

    def change(arrays):
        arrays["RNA4/steps"] = arrays["RNA4/steps"][:, :2]

    loaded = load_library(changed(path, change))
    assert len(loaded.of_length(3)) == 2
    with pytest.raises(le.LoopelasticaError, match=r"the library is damaged .*; build it again$"):
        loaded.of_length(4)


def test_a_file_is_read_once_and_again_when_it_changes(library, path):
    first = load_library(path)
    assert load_library(str(path)) is load_library(path) is first
    assert first.of_length(4) is first.of_length(4)
    save_library(Library.of([found("CUUUG")]), path)
    assert len(load_library(path)) == 1
    # what is in use stays as it was
    assert len(first.of_length(7)) == 1


def test_an_open_library_goes_to_another_process(path):
    sent = pickle.loads(pickle.dumps(load_library(path)))
    np.testing.assert_array_equal(
        sent.of_length(4).steps_A, load_library(path).of_length(4).steps_A
    )


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"no archive\n",
        b"PK\x03\x04 no more",
        bytes(range(256)) * 10,
        b"ATOM      1  P     G A   1\n",
    ],
)
def test_another_file_is_no_library(tmp_path, content):
    path = tmp_path / "x.lib"
    path.write_bytes(content)
    assert "this is no library of loop shapes, or not a whole one" in refusal(path)


def test_other_archives_are_no_libraries(tmp_path):
    path = tmp_path / "x.lib"
    with path.open("wb") as file:
        np.savez(file, steps=np.zeros(3))
    assert "this is no library" in refusal(path)
    with path.open("wb") as file:
        np.save(file, np.zeros(3))
    assert "this is no library" in refusal(path)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("about.npy", "{}")
    assert "build it again" in refusal(path)
    with path.open("wb") as file:
        np.savez(file, about=np.array([{"a": 1}], dtype=object))
    assert "build it again" in refusal(path)


def test_a_file_that_is_cut_short_anywhere_is_refused(path):
    content = path.read_bytes()
    for end in range(0, len(content), 97):
        path.write_bytes(content[:end])
        assert "this is no library of loop shapes, or not a whole one" in refusal(path)


def test_a_damaged_byte_is_refused_or_changes_nothing(path):
    content, whole, refused = path.read_bytes(), read_whole(path), 0
    for place in range(0, len(content), 41):
        path.write_bytes(content[:place] + bytes([content[place] ^ 0x55]) + content[place + 1 :])
        try:
            same = read_whole(path) == whole
        except le.LoopelasticaError:
            refused += 1
        else:
            assert same
    assert refused > 10


@pytest.mark.parametrize(
    "change",
    [
        about(program="another"),
        about(format=0),
        about(format="1"),
        about(tables={"RNA4": -1}),
        about(tables={"RNA4": 10**15}),
        about(tables={"XNA4": 1}),
        about(tables={"RNA0": 1}),
        about(tables=3),
        about(tables={"RNA9": 1}),
        lambda arrays: arrays.pop("RNA3/turns"),
        lambda arrays: arrays.update({"about": np.zeros(3)}),
        lambda arrays: arrays["RNA3/steps"].fill(np.nan),
        lambda arrays: arrays["RNA3/steps"].fill(0.0),
        lambda arrays: arrays["RNA3/turns"].fill(0.0),
        lambda arrays: arrays["RNA3/letters"].fill(7),
        lambda arrays: arrays.update({"RNA3/entries": np.array([1])}),
    ],
)
def test_an_archive_that_contradicts_itself_is_damaged(path, change):
    assert refusal(changed(path, change)).endswith("; build it again")


def test_a_library_of_a_later_version_says_so(path):
    sentence = refusal(changed(path, about(format=FORMAT + 1, version="9.9")))
    assert sentence == (
        f"{path}: a library of loopelastica 9.9, which this version ({__version__}) cannot read;"
        " update the program, or build the library again"
    )


def test_what_is_no_file_is_named(tmp_path):
    assert refusal(tmp_path / "x.lib").endswith("there is no such file; a library was expected")
    assert refusal(tmp_path).endswith("this is no file; a library was expected")
    os.mkfifo(tmp_path / "pipe")
    assert refusal(tmp_path / "pipe").endswith("this is no file; a library was expected")


@pytest.mark.parametrize("path", [None, 3, b"x.lib", io.BytesIO()])
def test_a_path_is_a_path(path):
    with pytest.raises(ValueError, match=r"^`path` is .*; it must be the path of a library$"):
        load_library(path)


def test_a_library_is_replaced_and_nothing_else(library, path, tmp_path):
    save_library(Library.of([found("CUUUG")]), path)
    save_library(library, path)
    changed(path, about(format=FORMAT + 1))
    save_library(library, path)
    assert len(load_library(path)) == 6
    (tmp_path / "empty.lib").touch()
    save_library(library, tmp_path / "empty.lib")
    (tmp_path / "notes.txt").write_text("mine")
    for taken in (tmp_path / "notes.txt", tmp_path):
        with pytest.raises(TakenError, match="this is no library of loop shapes"):
            save_library(library, taken)
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_what_cannot_be_written_leaves_nothing(library, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot be written"):
        save_library(library, tmp_path / "file" / "loops.lib")
    assert [p.name for p in tmp_path.iterdir()] == ["file"]
