import dataclasses

import numpy as np
import pytest

import loopelastica as le
from loopelastica.atoms.carry import Line, curve_on, helix_twist, own_phase
from loopelastica.atoms.fibre import fibre_nucleotide
from loopelastica.atoms.states import place
from loopelastica.folding.lines import chain_lines
from loopelastica.molecule.clamp_rule import StemClamp
from loopelastica.molecule.ends import ClosingPoses, StemEnds
from loopelastica.molecule.shapes import LoopShape
from loopelastica.molecule.strands import ideal_strand, line_frame, line_length_A


def continuation(strand, n):
    """The line that goes on as the helix of the stem for n nucleotides, and where it starts."""
    start, end = line_frame(strand, 0.5), line_frame(strand, n + 0.5)
    length_A = n * line_length_A(strand)
    clamp, none = StemClamp(0, 0, 0.0, line_length_A(strand)), np.zeros((0, 3))
    ends = StemEnds(*start, *end, length_A, clamp, none, none, np.zeros(2), None)
    rod = le.solve(le.Clamping.from_frames(*start, *end, length_A, free_spin=True))
    return Line.between(rod, ends, strand), start


def screw(strand, position, k):
    angle = np.deg2rad(k * strand.turn_deg)
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return turn @ position + [0.0, 0.0, k * strand.rise_A]


@pytest.mark.parametrize("is_dna", [False, True])
@pytest.mark.parametrize("n", [2, 4])
def test_a_straight_continuation_of_the_stem_reproduces_the_fibre_coordinates(is_dna, n):
    strand = ideal_strand(is_dna)
    line, (origin, frame) = continuation(strand, n)
    for k in range(1, n + 1):
        carried = place("G", is_dna, line, k, 0.0, 0.0)
        for name, position in carried.items():
            expected = screw(strand, fibre_nucleotide("G", is_dna)[name], k)
            np.testing.assert_allclose(origin + frame @ position, expected, atol=1e-9)


@pytest.mark.parametrize("is_dna", [False, True])
def test_atoms_carried_at_their_own_phase_are_fibre_coordinates_too(is_dna):
    strand = ideal_strand(is_dna)
    line, (origin, frame) = continuation(strand, 3)
    for name in ("P", "OP1", "OP2", "O3'"):
        fibre = fibre_nucleotide("A", is_dna)[name]
        phase, (x, y) = own_phase(strand, fibre)
        # phases before ½ and after n + ½ lie on the stem's helix beyond the rod
        for k in (1, 2, 3):
            point, axes = line.at([k + phase])
            position = point[0] + axes[0][:, 0] * x + axes[0][:, 1] * y
            np.testing.assert_allclose(
                origin + frame @ position, screw(strand, fibre, k), atol=1e-9
            )


def test_the_directors_meet_the_stem_at_both_ends(fold):
    candidate, ends = fold.candidates[0], fold.ends
    line = Line.between(candidate.rod, ends, ideal_strand(False))
    points, frames = line.at([0.5, 4.5])
    np.testing.assert_allclose(frames[0], np.eye(3), atol=1e-9)
    np.testing.assert_allclose(frames[1], ends.start_frame.T @ ends.end_frame, atol=1e-8)
    np.testing.assert_allclose(
        ends.start_origin_A + ends.start_frame @ points[1], ends.end_origin_A, atol=1e-8
    )
    # no more than half a turn from the twist of the helix
    expected = 4 * np.deg2rad(15.7)
    assert abs(line.spin - expected) <= np.pi + 1e-3


@pytest.mark.parametrize("turn_deg", [-170, -60, 60, 170])
def test_of_all_spins_that_meet_the_stem_the_one_nearest_to_the_helix_is_taken(fold, turn_deg):
    candidate, c, s = fold.candidates[0], *np.array([np.cos, np.sin])
    c, s = c(np.deg2rad(turn_deg)), s(np.deg2rad(turn_deg))
    about_its_tangent = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    plain = Line.between(candidate.rod, fold.ends, ideal_strand(False))
    ends = dataclasses.replace(fold.ends, end_frame=fold.ends.end_frame @ about_its_tangent)
    line = Line.between(candidate.rod, ends, ideal_strand(False))
    np.testing.assert_allclose(line.at([4.5])[1][0], ends.start_frame.T @ ends.end_frame, atol=1e-8)
    turned = np.rad2deg(line.spin - plain.spin) - turn_deg
    assert turned / 360 == pytest.approx(round(turned / 360), abs=1e-6)
    # four nucleotides of 15.7° each; the rod itself is free to turn and has no twist
    assert abs(np.rad2deg(line.spin) - 4 * 15.7) <= 180.5


@pytest.fixture(scope="module")
def chain(chains):
    return chains.candidates[0].line


def test_the_directors_of_a_chain_meet_the_closing_nucleotides(chain):
    curve = curve_on(chain, ideal_strand(False))
    points, frames = curve.at([0.0, 5.0])
    np.testing.assert_allclose(points, [np.zeros(3), chain.poses.position_A], atol=1e-8)
    np.testing.assert_allclose(frames, [np.eye(3), chain.poses.rotation], atol=1e-8)
    assert abs(curve.spin - 5 * helix_twist(ideal_strand(False))) <= np.pi + 1e-3


def test_frames_along_a_chain_are_frames_and_change_steadily(chain):
    phases = np.linspace(-1.0, 6.0, 1401)
    points, frames = curve_on(chain, ideal_strand(False)).at(phases)
    np.testing.assert_allclose(frames.swapaxes(1, 2) @ frames, np.tile(np.eye(3), (1401, 1, 1)),
                               atol=1e-9)  # fmt: skip
    np.testing.assert_allclose(np.linalg.det(frames), 1.0)
    steps = np.diff(points, axis=0)
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    np.testing.assert_allclose(steps, 0.5 * (frames[1:] + frames[:-1])[:, :, 2], atol=0.02)
    assert np.abs(np.diff(frames, axis=0)).max() < 0.05


def test_beyond_a_chain_the_strands_of_the_stem_go_on(chain):
    strand = ideal_strand(False)
    points, frames = curve_on(chain, strand).at([-1.0, 6.0])
    at_0, of_0 = line_frame(strand, 0.0)
    for k, step, origin, frame in (
        (0, -1.0, np.zeros(3), np.eye(3)),
        (1, 1.0, chain.poses.position_A, chain.poses.rotation),
    ):
        at, of = line_frame(strand, step)
        np.testing.assert_allclose(points[k], origin + frame @ of_0.T @ (at - at_0), atol=1e-8)
        np.testing.assert_allclose(frames[k], frame @ of_0.T @ of, atol=1e-8)


@pytest.mark.parametrize("is_dna", [False, True])
def test_a_chain_that_is_the_helix_carries_the_fibre_coordinates(is_dna):
    strand, n = ideal_strand(is_dna), 4
    poses = [line_frame(strand, phase) for phase in range(n + 2)]
    origin, frame = poses[0]
    nodes = (np.array([point for point, _ in poses]) - origin) @ frame
    shape = LoopShape("", is_dna, np.diff(nodes, axis=0), frame.T @ poses[-1][1], "helix")
    ends = ClosingPoses(*poses[0], *poses[-1])
    (line,) = chain_lines([shape], ends, is_dna)
    curve = curve_on(line, strand)
    for k in range(1, n + 1):
        for name, position in place("G", is_dna, curve, k, 0.0, 0.0).items():
            expected = screw(strand, fibre_nucleotide("G", is_dna)[name], k)
            # a cubic spline is not quite a helix
            np.testing.assert_allclose(origin + frame @ position, expected, atol=0.05)


def test_a_rod_is_carried_on_as_before(fold):
    line = fold.candidates[0].line
    by_line = curve_on(line, ideal_strand(False)).at([1.0, 2.5])
    by_rod = Line.between(line.rod, fold.ends, ideal_strand(False)).at([1.0, 2.5])
    for one, other in zip(by_line, by_rod, strict=True):
        np.testing.assert_array_equal(one, other)
