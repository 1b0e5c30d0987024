"""Which files are a design, alone and in a folder."""

import json
from pathlib import Path

import helix_designs as designs
import pytest

from loopelastica.errors import StructureError
from loopelastica.nanostructures.inputs import designs_of, input_paths, read_input
from loopelastica.nanostructures.options import NanostructureOptions


def touched(folder, *names):
    for name in names:
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_text("")
    return [str(folder / name) for name in names]


def test_a_topology_and_its_configuration_of_one_stem_are_one_design(tmp_path):
    a, b, c, d = touched(tmp_path, "a.top", "b.top", "a.dat", "b.oxdna")
    assert designs_of([a, b, c, d])[0] == [(a, c), (b, d)]


def test_two_of_other_names_belong_together_where_they_follow_each_other(tmp_path):
    a, last, b, end = touched(tmp_path, "a.top", "last.dat", "b.top", "end.conf")
    assert designs_of([a, last, b, end])[0] == [(a, last), (b, end)]
    assert designs_of([last, a])[0] == [(a, last)]


def test_a_file_that_is_alone_stays_alone(tmp_path):
    a, x, y, z = touched(tmp_path, "a.top", "x.dat", "y.dat", "z.sc")
    assert designs_of([a, x, y, z])[0] == [(a, x), (y, None), (z, None)]


def test_a_design_that_is_given_twice_counts_once(tmp_path):
    (z,) = touched(tmp_path, "z.sc")
    around = str(tmp_path / ".." / tmp_path.name / "z.sc")
    found, notes = designs_of([z, around, z])
    assert found == [(z, None)]
    assert len(notes) == 2
    assert all("it counts once" in note for note in notes)


def test_a_folder_stands_for_its_designs_and_topologies(tmp_path):
    folder = tmp_path / "in"
    touched(tmp_path, "in/b.sc", "in/a.top", "in/a.dat", "in/notes.txt", "in/c.sc.gz")
    names = [(Path(one).name, other) for one, other in designs_of([str(folder)])[0]]
    assert names == [("a.top", None), ("b.sc", None), ("c.sc.gz", None)]


def test_what_this_program_wrote_into_a_folder_is_no_design(tmp_path):
    touched(tmp_path, "b.sc", "b.top", "b.dat", "own.top", "own.dat")
    manifest = {"program": "loopelastica", "files": ["b.top", "b.dat", "b.json"]}
    (tmp_path / "b.json").write_text(json.dumps(manifest))
    names = [Path(one).name for one, _ in designs_of([str(tmp_path)])[0]]
    assert names == ["b.sc", "own.top"]


def test_a_folder_without_designs_is_left_to_whoever_reads_it(tmp_path):
    assert designs_of([str(tmp_path)])[0] == [(str(tmp_path), None)]
    with pytest.raises(StructureError, match=r"this folder has no design of scadnano \(\.sc\)"):
        read_input(tmp_path, NanostructureOptions())


def test_files_of_a_design_include_the_one_beside_it(tmp_path):
    top, dat = touched(tmp_path, "a.top", "a.dat")
    assert input_paths(top, None) == [top, dat]
    assert input_paths(dat, None) == [top, dat]
    (alone,) = touched(tmp_path, "b.top")
    assert input_paths(alone, None) == [alone]


@pytest.mark.parametrize("name", ["a.pdb", "a.cif.gz", "a", "a.sc.txt"])
def test_a_name_that_is_neither_is_refused_with_what_is_needed(tmp_path, name):
    (file,) = touched(tmp_path, name)
    with pytest.raises(StructureError, match=r"is needed$"):
        read_input(file, NanostructureOptions())


def test_a_design_of_scadnano_has_no_other_file(tmp_path):
    file = designs.write(designs.hairpin(), tmp_path)
    with pytest.raises(ValueError, match=r"`other` is 'x\.dat', but .* which is one file"):
        read_input(file, NanostructureOptions(other="x.dat"))


@pytest.mark.parametrize("name", ["absent.sc", "absent", "absent.txt", "absent.sc.gz"])
def test_what_is_not_there_is_named_whatever_its_name_ends_in(tmp_path, name):
    with pytest.raises(StructureError, match=rf"{name}: there is no such file$"):
        read_input(tmp_path / name, NanostructureOptions())


@pytest.mark.parametrize("path", [None, 3, "", ["a.sc"]])
def test_a_path_that_is_none_is_named(path):
    with pytest.raises(ValueError, match="`path` is"):
        read_input(path, NanostructureOptions())


def test_of_a_folder_with_designs_one_is_needed(tmp_path):
    touched(tmp_path, "z.sc")
    with pytest.raises(StructureError, match="this is a folder; one of the designs in it"):
        read_input(tmp_path, NanostructureOptions())


def test_helices_of_oxdna_are_not_fitted(tmp_path):
    top, _ = touched(tmp_path, "a.top", "a.dat")
    with pytest.raises(ValueError, match=r"`helices` .*a\.top is of oxDNA"):
        read_input(top, NanostructureOptions(helices="fitted"))
