"""Files of one stem in a folder: all of them or none, and nothing of others is touched."""

import json

import helix_designs as designs
import pytest

from loopelastica._files import TakenError
from loopelastica.report.nanostructure import is_there, write_folder


@pytest.fixture
def found(tmp_path):
    from loopelastica.nanostructures.nanostructure import nanostructure

    return nanostructure(designs.write(designs.hairpin(6), tmp_path))


@pytest.fixture
def refused(tmp_path):
    from loopelastica.nanostructures.nanostructure import nanostructure

    return nanostructure(designs.write(designs.linker(2, apart=3), tmp_path / "far.sc"))


def names(folder):
    return {path.name for path in folder.iterdir()}


def test_several_designs_share_a_folder(found, tmp_path):
    out = tmp_path / "out"
    keys = [write_folder(out, stem, found) for stem in ("a", "b")]
    assert {name.split(".")[0] for name in names(out)} == {"a", "b"}
    assert all(is_there(out, stem, key) for stem, key in zip("ab", keys, strict=True))
    (out / "a.dat").unlink()
    assert not is_there(out, "a", keys[0])
    assert is_there(out, "b", keys[1])


def test_a_refused_design_has_its_record_alone(refused, tmp_path):
    out = tmp_path / "out"
    write_folder(out, "far", refused)
    assert names(out) == {"far.json"}
    record = json.loads((out / "far.json").read_text())
    assert record["status"] == "refused"
    (reason,) = record["refused"]
    assert "would suffice" in reason
    assert record["strands"][0]["reason"] == reason


def test_files_of_a_former_result_go_with_it(found, refused, tmp_path):
    out = tmp_path / "out"
    write_folder(out, "a", found)
    (out / "notes.txt").write_text("mine")
    write_folder(out, "a", refused)
    assert names(out) == {"a.json", "notes.txt"}


@pytest.mark.parametrize("name", ["a.dat", "a.json", "a.cif"])
def test_what_others_wrote_stays_and_nothing_is_written(found, tmp_path, name):
    out = tmp_path / "out"
    out.mkdir()
    (out / name).write_text("mine")
    with pytest.raises(TakenError, match="not written by this program"):
        write_folder(out, "a", found)
    assert names(out) == {name}
    assert (out / name).read_text() == "mine"


def test_an_input_of_the_run_is_not_written_over_even_where_it_is_a_former_result(found, tmp_path):
    out = tmp_path / "out"
    write_folder(out, "a", found)
    before = (out / "a.dat").read_bytes()
    with pytest.raises(TakenError, match="this is the input"):
        write_folder(out, "a", found, inputs=[out / "a.dat"])
    assert (out / "a.dat").read_bytes() == before
