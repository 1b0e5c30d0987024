"""The structures of a folder."""

import json

import pytest

from loopelastica.molecule.folders import structure_files, with_folders


@pytest.fixture
def folder(tmp_path):
    for name in (
        *("b.pdb", "a.cif.gz", "note.txt", "c.ENT", "in/d.mmcif", "in/deep/e.pdb.bz2"),
        *(".hidden/f.pdb", "out/2koc_A6-9/whole.pdb", "out/2koc/filled.pdb", "loops.lib.run/x.csv"),
    ):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("")
    for name in ("out/2koc_A6-9/ranking.json", "out/2koc/fill.json"):
        (tmp_path / name).write_text(json.dumps({"program": "loopelastica", "files": ["x"]}))
    return tmp_path


def names(folder, files):
    return [file.relative_to(folder).as_posix() for file in files]


def test_a_folder_is_looked_into_alone(folder):
    assert names(folder, structure_files(folder)) == ["a.cif.gz", "b.pdb", "c.ENT"]


def test_deeper_its_folders_count_but_hidden_ones_and_predictions(folder):
    assert names(folder, structure_files(folder, deep=True)) == [
        *("a.cif.gz", "b.pdb", "c.ENT", "in/d.mmcif", "in/deep/e.pdb.bz2"),
    ]


def test_a_manifest_of_others_hides_nothing(folder):
    (folder / "in" / "ranking.json").write_text('{"program": "another"}')
    assert "in/d.mmcif" in names(folder, structure_files(folder, deep=True))


@pytest.mark.parametrize(("name", "why"), [("", ""), ("x", ": it is not there")])
def test_a_folder_without_structures_is_named_as_the_user_called_it(tmp_path, name, why):
    with pytest.raises(ValueError, match=rf"^`sources` .*holds no PDB or mmCIF file{why}$"):
        structure_files(tmp_path / name, deep=True, argument="sources")


def test_a_folder_among_files_gives_way_to_its_structures(folder):
    given = ["x.pdb", str(folder), str(folder / "in"), str(folder / "loops.lib.run")]
    assert with_folders(given) == [
        "x.pdb",
        *(str(folder / name) for name in ("a.cif.gz", "b.pdb", "c.ENT")),
        str(folder / "in" / "d.mmcif"),
        # whoever reads it says what it is
        str(folder / "loops.lib.run"),
    ]
