"""What the page shows of a loop: its candidates where the fold has them, joined to its stem."""

import json

import numpy as np
import pytest
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.molecule.nucleotides import read_structure
from loopelastica.molecule.setting import Settings
from loopelastica.report.page.scene import fold_scene, read_scene, script_json, write_scene


def points(flat):
    return np.array(flat).reshape(-1, 3)


@pytest.fixture(scope="module")
def setting(koc, fold):
    return Settings(koc).of(fold.hairpin)


@pytest.fixture(scope="module")
def scene(fold, setting):
    return fold_scene(fold, setting, "2koc.pdb")


def test_every_candidate_is_there_with_its_nucleotides_on_its_line(fold, scene):
    assert [c["rank"] for c in scene["candidates"]] == [c.rank for c in fold.candidates]
    assert scene["labels"] == ["A.U6", "A.U7", "A.C8", "A.G9"]
    for drawn, candidate in zip(scene["candidates"], fold.candidates, strict=True):
        np.testing.assert_allclose(points(drawn["trace"]), candidate.trace, atol=0.006)
        distance, _ = KDTree(points(drawn["line"])).query(candidate.trace)
        assert distance.max() < 0.4
        assert drawn["expected_rmsd_A"] == candidate.expected_rmsd_A[1]
        assert len(drawn["phases"]) == len(drawn["curvature"])


def test_nucleotides_that_continue_the_stem_are_on_the_line_too(koc):
    (loop,) = le.fold(koc, all_models=False, shapes="rod", stem_extend_5=1, stem_extend_3=1)
    scene = fold_scene(loop, Settings(koc).of(loop.hairpin), "2koc.pdb")
    distance, _ = KDTree(points(scene["candidates"][0]["line"])).query(loop.candidates[0].trace)
    assert distance.max() < 0.4


def test_lines_begin_and_end_beside_the_closing_pair(scene):
    five, three = (points(strand["points"]) for strand in scene["strands"])
    for candidate in scene["candidates"]:
        line = points(candidate["line"])
        assert np.linalg.norm(line[0] - five[-1]) < 7.0
        assert np.linalg.norm(line[-1] - three[0]) < 7.0


def test_curvature_of_the_files_own_loop_stands_at_its_nucleotides(scene, fold):
    own = scene["own"]
    assert own["phases"][0] == 0.5
    assert own["phases"][-1] == 4.5
    np.testing.assert_allclose(points(own["trace"]), fold.backbone_A[1:-1], atol=0.006)


def test_a_loop_that_is_turned_and_shifted_has_the_same_scene_turned_and_shifted(
    tmp_path, koc_lines, rng
):
    turn, shift = Rotation.random(random_state=rng).as_matrix(), rng.uniform(-20, 20, 3)
    lines = []
    for line in koc_lines:
        place = np.array([float(line[k : k + 8]) for k in (30, 38, 46)]) @ turn.T + shift
        lines.append(line[:30] + "".join(f"{x:8.3f}" for x in place) + line[54:])
    scenes = []
    for name, text in (("here", koc_lines), ("there", lines)):
        file = tmp_path / f"{name}.pdb"
        file.write_text("\n".join([*text, "END", ""]))
        structure = read_structure(file)
        (loop,) = le.fold(structure, shapes="rod")
        scenes.append(fold_scene(loop, Settings(structure).of(loop.hairpin), "x.pdb"))
    here, there = scenes
    assert len(here["candidates"]) == len(there["candidates"])
    for key in ("line", "trace"):
        moved = points(here["candidates"][0][key]) @ turn.T + shift
        np.testing.assert_allclose(points(there["candidates"][0][key]), moved, atol=0.03)
    a, b = (s["candidates"][0]["curvature"] for s in scenes)
    np.testing.assert_allclose(a, b, atol=1e-3)


def test_atoms_are_those_of_the_model_and_their_bonds_have_the_lengths_of_bonds(
    fold, setting, atoms
):
    scene = fold_scene(fold, setting, "2koc.pdb", atoms)
    first, model = scene["candidates"][0], atoms.models[0]
    assert first["sound"] == model.checks.sound
    drawn = first["atoms"]
    np.testing.assert_allclose(points(drawn["points"]), model.positions_A, atol=0.006)
    ends = points(drawn["points"])[np.array(drawn["bonds"]).reshape(-1, 2)]
    lengths = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)
    assert lengths.min() > 1.1
    assert lengths.max() < 1.75
    assert len(drawn["names"]) == len(drawn["elements"]) == len(model.positions_A)
    # two of three or more candidates were built
    assert scene["candidates"][2]["atoms"] is None


def test_what_is_written_is_read_again(tmp_path, scene):
    path = tmp_path / "scene.js"
    write_scene(path, [scene], {"version": "1.2.3"})
    back = read_scene(path)
    assert back == json.loads(json.dumps({"version": "1.2.3", "items": [scene]}))


@pytest.mark.parametrize("text", ["", "window.loopelasticaScene = [", "[1]", "\udcff", "{}"])
def test_what_is_no_scene_is_none(tmp_path, text):
    path = tmp_path / "scene.js"
    assert read_scene(path) is None
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    assert read_scene(path) is None


@pytest.mark.parametrize("text", ["</script>", "<!--", "\u2028", "a\udcffb", "</SCRIPT\n>"])
def test_no_text_ends_a_script_or_a_line_of_it(text):
    written = script_json({"name": text})
    assert written.isascii()
    assert "<" not in written
    assert json.loads(written) == {"name": text}
