"""Folders of fillings: complete or absent, and nothing of a user is touched."""

import hashlib
import json
import math
from pathlib import Path

import gapped
import pytest

import loopelastica as le
from loopelastica.filling.folder import (
    STRAND_COLUMNS,
    folder_of,
    is_there,
    strand_row,
    write_folder,
)

pytest.importorskip("rdkit")


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return gapped.gapped(tmp_path_factory.mktemp("folder") / "a.pdb", {6, 7})


@pytest.fixture(scope="module")
def filling(file):
    return le.fill(file)


def manifest(folder):
    return json.loads((folder / "fill.json").read_text())


@pytest.mark.parametrize(
    ("name", "number", "folder"),
    [
        ("a.pdb", 1, "a"),
        ("a.pdb", 2, "a_2"),
        ("a.cif.gz", 1, "a"),
        ("a.mmcif", 1, "a"),
        ("a.ent.bz2", 1, "a"),
        ("pdb1abc.ent.gz", 1, "pdb1abc"),
        ("a.b.cif", 1, "a.b"),
    ],
)
def test_a_folder_is_called_as_its_file_without_suffixes(name, number, folder):
    assert folder_of(Path("out"), Path("in") / name, number) == Path("out") / folder


@pytest.mark.parametrize("name", ["../a.pdb", "..pdb", ".pdb", "a/../b.cif", "a b;c.cif", "\n.pdb"])
def test_a_folder_lies_in_that_of_the_results(name):
    folder = folder_of(Path("out"), Path(name))
    assert folder.parent == Path("out")
    assert folder.name not in ("", ".", "..")
    assert folder.name.isprintable()


def test_fill_json_has_the_fields_of_the_contract(filling, file, tmp_path):
    content = manifest(filling.write(tmp_path / "out"))
    assert content["version"] == le.__version__
    assert content["sha256"] == hashlib.sha256(file.read_bytes()).hexdigest()
    (strand,) = content["strands"]
    assert {key: strand[key] for key in ("chain", "first", "last", "sequence", "status")} == {
        "chain": "A", "first": "6", "last": "7", "sequence": "UU", "status": "filled",
    }  # fmt: skip
    assert strand["reason"] is None
    assert strand["sound"] is True
    assert len(strand["expected_rmsd_A"]) == 3
    (candidate,) = strand["candidates"]
    assert candidate["rank"] == 1
    assert candidate["closest_contact_A"] >= 2.2
    assert len(candidate["trace_A"]) == 2
    assert content["parameters"]["candidates"] == 1


def test_no_number_in_it_is_none_that_json_knows(filling, tmp_path):
    def numbers(value):
        if isinstance(value, dict):
            value = list(value.values())
        if isinstance(value, list):
            for one in value:
                yield from numbers(one)
        elif isinstance(value, float):
            yield value

    folder = filling.write(tmp_path / "out")
    assert all(map(math.isfinite, numbers(manifest(folder))))
    json.loads((folder / "fill.json").read_text(), parse_constant=pytest.fail)


def test_a_refused_strand_is_in_it_with_its_reason_and_no_structure_is_written(tmp_path):
    filling = le.fill(gapped.pdb(tmp_path / "a.pdb", gapped.chain({6, 7})))
    folder = filling.write(tmp_path / "out")
    assert {p.name for p in folder.iterdir()} == {"fill.json"}
    (strand,) = manifest(folder)["strands"]
    assert (strand["status"], strand["candidates"]) == ("refused", [])
    assert strand["sound"] is None
    assert strand["expected_rmsd_A"] is None
    assert "A.6-7=NN" in strand["reason"]


def test_a_row_has_every_column_and_is_of_the_first_candidate(filling):
    (strand,) = filling.strands
    row = strand_row(strand)
    assert tuple(row) == STRAND_COLUMNS
    assert row["shape"] == strand.candidates[0].line.shape
    assert row["expected_10_A"] < row["expected_rmsd_A"] < row["expected_90_A"]
    assert row["sound"] is True


def test_a_folder_is_there_where_all_its_files_are(filling, tmp_path):
    folder = tmp_path / "out"
    assert not is_there(folder, {})
    key = write_folder(folder, filling)
    assert is_there(folder, key)
    assert not is_there(folder, {**key, "sha256": "another"})
    (folder / "filled.pdb").unlink()
    assert not is_there(folder, key)


def test_what_a_former_result_had_more_goes_and_a_users_files_stay(file, filling, tmp_path):
    folder = tmp_path / "out"
    gap = gapped.gapped(tmp_path / "c.pdb", {4, 5, 6, 7, 8, 9, 10})
    le.fill(gap, candidates=3).write(folder)
    assert (folder / "filled_2.pdb").is_file()
    (folder / "notes.txt").write_text("mine")
    filling.write(folder)
    assert {p.name for p in folder.iterdir()} == {"filled.pdb", "fill.json", "notes.txt"}
    assert (folder / "notes.txt").read_text() == "mine"
    # a filling without any model leaves no structure of the one before
    le.fill(gapped.gapped(tmp_path / "whole.pdb", ())).write(folder)
    assert {p.name for p in folder.iterdir()} == {"fill.json", "notes.txt"}


@pytest.mark.parametrize("name", ["filled.pdb", "fill.json"])
def test_a_name_that_a_user_has_taken_is_refused(filling, tmp_path, name):
    (tmp_path / name).write_text("mine")
    with pytest.raises(FileExistsError, match=name):
        filling.write(tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text() == "mine"
