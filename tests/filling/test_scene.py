"""What the page shows of filled strands."""

import gapped
import numpy as np
import pytest
from scipy.spatial import KDTree

import loopelastica as le
from loopelastica.filling.folder import is_there, write_folder
from loopelastica.report.page.scene import read_scene

pytest.importorskip("rdkit")


def points(flat):
    return np.array(flat).reshape(-1, 3)


@pytest.fixture(scope="module")
def filled(tmp_path_factory):
    """A strand that is filled, and one that is refused."""
    folder = tmp_path_factory.mktemp("scene")
    atoms = [*gapped.chain({6, 7}), "TER", *gapped.chain({9}, name="B", moved=40.0)]
    filling = le.fill(gapped.pdb(folder / "ab.pdb", atoms, head=gapped.seqres()))
    key = write_folder(folder / "out", filling, scene=True)
    return filling, folder / "out", key


def test_every_strand_is_there_filled_or_refused(filled):
    filling, folder, _ = filled
    scene = read_scene(folder / "scene.js")
    first, second = scene["items"]
    assert (first["row"]["loop"], first["row"]["status"]) == ("A.6-7", "filled")
    assert (second["row"]["loop"], second["row"]["status"]) == ("B.9", "refused")
    assert second["row"]["reason"] == filling.strands[1].reason
    assert second["candidates"] == []
    assert scene["sha256"] == filling.sha256


def test_a_strand_is_drawn_between_its_neighbours_with_its_atoms(filled):
    filling, folder, _ = filled
    item = read_scene(folder / "scene.js")["items"][0]
    (candidate,) = filling.strands[0].candidates
    (drawn,) = item["candidates"]
    assert item["labels"] == ["A.U6", "A.U7"]
    assert [strand["labels"] for strand in item["strands"]] == [["A.A4", "A.C5"], ["A.C8", "A.G9"]]
    np.testing.assert_allclose(points(drawn["trace"]), candidate.trace, atol=0.006)
    distance, _ = KDTree(points(drawn["line"])).query(candidate.trace)
    assert distance.max() < 0.4
    np.testing.assert_allclose(
        points(drawn["atoms"]["points"]), candidate.atoms.positions_A, atol=0.006
    )
    assert drawn["sound"] == candidate.sound
    near = {label for chain in item["neighbours"] for label in chain["labels"]}
    assert "A.G10" in near
    assert not near & {"A.U6", "A.U7", "A.C5", "A.C8"}


def test_a_strand_that_was_there_is_shown_beside_the_one_built_anew(tmp_path):
    filling = le.fill(gapped.pdb(tmp_path / "a.pdb", gapped.chain()), strands="A.6-8")
    write_folder(tmp_path / "out", filling, scene=True)
    (item,) = read_scene(tmp_path / "out" / "scene.js")["items"]
    own = points(item["own"]["trace"])
    atoms = np.array(
        [[float(line[k : k + 8]) for k in (30, 38, 46)] for line in gapped.chain()]
    )  # fmt: skip
    assert len(own) == 3
    distance, _ = KDTree(atoms).query(own)
    assert distance.max() < 2.0


def test_a_folder_without_a_scene_is_another_result(filled):
    filling, folder, key = filled
    assert is_there(folder, key)
    other = write_folder(folder, filling)
    assert not is_there(folder, key)
    assert is_there(folder, other)
    assert not (folder / "scene.js").exists()
