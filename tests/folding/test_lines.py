"""Lines of candidates: rods and chains answer alike, in the coordinates of the file."""

import dataclasses
import json
import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from loopelastica.folding.lines import ChainLine, RodLine, chain_lines
from loopelastica.molecule.ends import ClosingPoses, fit_stem
from loopelastica.molecule.hairpins import find_hairpins
from loopelastica.molecule.strands import ideal_strand, line_length_A


@pytest.fixture(scope="module")
def poses(koc):
    (hairpin,) = find_hairpins(koc)
    return fit_stem(koc.nucleotides, hairpin, koc.positions(0)).closing()


@pytest.fixture(scope="module")
def chain(koc_shape, poses):
    (line,) = chain_lines([koc_shape], poses, False)
    return line


@pytest.fixture(scope="module")
def rod(fold):
    return fold.candidates[0].line


def own_poses(shape):
    """The ends that a shape has at rest, somewhere."""
    frame = Rotation.from_rotvec([0.3, -1.0, 2.0]).as_matrix()
    origin = np.array([10.0, -4.0, 7.0])
    return ClosingPoses(
        origin, frame, origin + frame @ shape.steps_A.sum(axis=0), frame @ shape.end_frame
    )


def test_a_shape_on_its_own_ends_is_itself(koc_shape):
    poses = own_poses(koc_shape)
    (line,) = chain_lines([koc_shape], poses, False)
    assert line.energy == pytest.approx(0.0, abs=1e-12)
    assert line.twist_turns == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(line.trace, poses.to_file(koc_shape.nodes_A[1:-1]), atol=1e-9)


def test_an_end_that_turns_about_the_line_twists_the_hinges(koc_shape):
    straight = dataclasses.replace(
        koc_shape, steps_A=np.tile([0.0, 0.0, 5.0], (5, 1)), end_frame=np.eye(3)
    )
    turn = Rotation.from_rotvec([0.0, 0.0, 1.0]).as_matrix()
    poses = ClosingPoses(np.zeros(3), np.eye(3), np.array([0.0, 0.0, 25.0]), turn)
    (line,) = chain_lines([straight], poses, False)
    assert line.twist_turns == pytest.approx(1.0 / (2 * np.pi))


def test_the_curve_of_a_chain_goes_through_its_nodes_and_on_as_the_strands(chain, poses):
    nodes = poses.to_file(chain.nodes_A)
    np.testing.assert_allclose(poses.to_file(chain.smooth(np.arange(6.0))), nodes, atol=1e-9)
    np.testing.assert_allclose(nodes[0], poses.start_origin_A, atol=1e-9)
    np.testing.assert_allclose(nodes[-1], poses.end_origin_A, atol=1e-8)
    np.testing.assert_allclose(nodes[1:-1], chain.trace, atol=1e-9)
    for phase, frame in ((0.0, poses.start_frame), (5.0, poses.end_frame)):
        pace = poses.start_frame @ chain.smooth([phase], 1)[0]
        np.testing.assert_allclose(pace, line_length_A(ideal_strand(False)) * frame[:, 2])


def test_steps_keep_their_lengths(chain, koc_shape):
    steps = np.linalg.norm(np.diff(chain.nodes_A, axis=0), axis=1)
    np.testing.assert_allclose(steps, np.linalg.norm(koc_shape.steps_A, axis=1), atol=1e-9)
    assert chain.length_A == pytest.approx(steps.sum())
    assert chain.curve_A > chain.length_A


@pytest.mark.parametrize("which", ["rod", "chain"])
def test_points_tangents_and_curvature_are_of_one_curve(which, request):
    line = request.getfixturevalue(which)
    points, tangents = line.points(2001), line.tangents(2001)
    steps = np.diff(points, axis=0)
    apart = np.linalg.norm(steps, axis=1)
    assert apart.sum() == pytest.approx(line.curve_A, rel=1e-4)
    assert np.ptp(apart) < 0.01 * apart.mean()
    np.testing.assert_allclose(np.linalg.norm(tangents, axis=1), 1.0, atol=1e-9)
    np.testing.assert_allclose(
        steps / apart[:, None], 0.5 * (tangents[1:] + tangents[:-1]), atol=2e-3
    )
    turning = np.linalg.norm(np.diff(tangents, axis=0), axis=1) / apart
    curvature = line.curvature_per_A(2001)
    np.testing.assert_allclose(
        turning, 0.5 * (curvature[1:] + curvature[:-1]), atol=0.02 * curvature.max()
    )
    np.testing.assert_allclose(line.points([0.0, 1.0]), points[[0, -1]], atol=1e-9)
    np.testing.assert_allclose(points[0], line.start_origin_A, atol=1e-9)


@pytest.mark.parametrize("which", ["rod", "chain"])
def test_phases_count_the_nucleotides_that_the_line_passes(which, request):
    line = request.getfixturevalue(which)
    s = np.linspace(0.0, 1.0, 4001)
    phases, points = line.phases(s), line.points(s)
    assert (np.diff(phases) > 0.0).all()
    for k, node in enumerate(line.trace, start=1):
        nearest = np.argmin(np.linalg.norm(points - node, axis=1))
        assert phases[nearest] == pytest.approx(k, abs=0.01)


@pytest.mark.parametrize("which", ["rod", "chain"])
def test_contacts_are_looked_for_from_half_a_nucleotide_on(which, request):
    line = request.getfixturevalue(which)
    points, phases = line.sampled()
    assert (phases[0], phases[-1]) == (0.5, 4.5)
    assert len(points) == len(phases) == 41
    np.testing.assert_allclose(points[5:40:10], line.trace, atol=1e-6)


@pytest.mark.parametrize("which", ["rod", "chain"])
def test_what_is_written_is_json_and_named_after_its_kind(which, request):
    line = request.getfixturevalue(which)
    content = json.loads(json.dumps(line.to_dict(), allow_nan=False))
    assert list(content) == [which]
    assert content[which]["energy"] == line.energy


def test_a_chain_is_one_more_time_what_its_record_says(chain):
    content = chain.to_dict()["chain"]
    again = chain_lines(
        [
            dataclasses.replace(
                chain.shape,
                steps_A=np.array(content["steps_A"]),
                end_frame=np.array(content["end_frame"]),
            )
        ],
        chain.poses,
        False,
    )[0]
    np.testing.assert_array_equal(again.nodes_A, content["nodes_A"])


def test_the_other_hairpin_moves_its_line_along(koc_shape, poses, chain):
    turn, shift = Rotation.from_rotvec([1.0, 2.0, -0.5]).as_matrix(), np.array([3.0, 50.0, -9.0])
    moved = ClosingPoses(
        turn @ poses.start_origin_A + shift,
        turn @ poses.start_frame,
        turn @ poses.end_origin_A + shift,
        turn @ poses.end_frame,
    )
    (line,) = chain_lines([koc_shape], moved, False)
    np.testing.assert_allclose(line.trace, chain.trace @ turn.T + shift, atol=1e-7)
    assert line.energy == pytest.approx(chain.energy)


def test_a_shape_that_cannot_reach_is_none_and_the_others_are_lines(koc_shape, poses):
    short = dataclasses.replace(koc_shape, steps_A=0.1 * koc_shape.steps_A)
    lost, line = chain_lines([short, koc_shape], poses, False)
    assert lost is None
    assert line.stable
    assert line.residual < 1e-9
    assert chain_lines([], poses, False) == []


def test_lines_stay_read_only_when_copied(chain, rod):
    assert (type(chain), type(rod)) == (ChainLine, RodLine)
    again = pickle.loads(pickle.dumps(chain))
    for array in (chain.nodes_A, again.rotations, again.shape.steps_A):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0
