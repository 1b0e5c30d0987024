import numpy as np
import pytest
from draws import pose_drawn
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod.kernels.boundary_layers import planar_start, solve_layers
from loopelastica.rod.kernels.layer_poses import check_layers, layers_apart, sample_layers
from loopelastica.rod.kernels.rotations import end_turn

# kernels that Python does not call otherwise are compiled one by one
pytestmark = pytest.mark.slow


@pytest.fixture
def layered(problem, start, room):
    """Random poses that two boundary layers solve: (clamping, problem, record)."""

    def drawn(rng, n, low, high, torsion_ratio, free_spin=False, **named):
        for position, rotation in zip(*pose_drawn(rng, n, low, high), strict=True):
            clamping = le.Clamping(position, rotation, free_spin)
            here, layers = problem(clamping, torsion_ratio), room().layers[0]
            if solve_layers(here, start(**named), layers) and layers_apart(layers):
                yield clamping, here, layers

    return drawn


@pytest.mark.parametrize("free_spin", [False, True])
@pytest.mark.parametrize("torsion_ratio", [0.5, 1.0, 3.0])
def test_nearly_straight_rods_are_two_boundary_layers(rng, layered, torsion_ratio, free_spin):
    count = 0
    for clamping, here, layers in layered(rng, 40, 0.995, 0.9999, torsion_ratio, free_spin):
        count += 1
        assert check_layers(here, layers) < 1e-10
        poses = sample_layers(layers, torsion_ratio, np.array([0.0, 1.0]))
        np.testing.assert_allclose(poses[0], [0, 0, 0, 1, 0, 0, 0], atol=1e-12)
        np.testing.assert_allclose(poses[1, :3], clamping.position, atol=1e-12)
        last, rotation = (
            Rotation.from_quat(poses[1, 3:], scalar_first=True).as_matrix(),
            clamping.rotation,
        )
        if free_spin:
            last, rotation = last[:, 2], rotation[:, 2]
        np.testing.assert_allclose(last, rotation, atol=1e-10)
    assert count >= 38


def test_turns_wind_the_tense_rod(layered):
    twists = []
    for turns in (0, 3, -3):
        rng = np.random.default_rng(4)
        ((_, _, layers),) = list(layered(rng, 1, 0.999, 0.9999, 1.0, turns=turns))
        twists.append(2 * layers.root * np.sin(layers.beta) / (2 * np.pi))
    np.testing.assert_allclose(np.diff(twists[:2]), 3, atol=0.1)
    np.testing.assert_allclose(twists[2] - twists[0], -3, atol=0.1)


def test_a_layer_over_the_other_side_costs_more(layered):
    roots = {}
    for over in (False, True):
        rng = np.random.default_rng(4)
        ((_, here, layers),) = list(layered(rng, 1, 0.999, 0.9999, 1.0, over_0=over))
        assert check_layers(here, layers) < 1e-9
        roots[over] = layers.root
        # δ near 0 goes straight to the axis, near π over the other side first
        assert (np.cos(layers.delta_0) < 0) == over
    assert roots[True] > roots[False]


def test_slack_rods_have_no_boundary_layers(problem, start, room):
    here = problem(le.Clamping([0, 0, 0.1], np.eye(3)), 1.0)
    assert not solve_layers(here, start(), room().layers[0])


@pytest.mark.parametrize("angle", [0.05, 0.3])
def test_the_planar_start_of_two_equal_angles_is_their_closed_form(problem, angle):
    # both tangents at the angle α to the chord, on one side: √F (1 − |r|) = 4 (1 − cos α/2), and
    # the axis is the chord
    turned = Rotation.from_euler("y", -2 * angle).as_matrix()
    shortening = 0.01 * angle**2
    chord = Rotation.from_euler("y", -angle).apply([0, 0, 1 - shortening])
    root, *axis = planar_start(problem(le.Clamping(chord, turned), 1.0), False, False)
    assert root == pytest.approx(4 * (1 - np.cos(angle / 2)) / shortening, rel=1e-9)
    np.testing.assert_allclose(axis, chord / np.linalg.norm(chord), atol=1e-12)


def test_the_end_turn_about_an_axis_along_the_tangents_is_their_spin():
    for spin in (0.4, -2.0, 3.0):
        end = Rotation.from_euler("z", spin).as_quat(scalar_first=True)
        assert end_turn(end, np.array([1.0, 0, 0, 0])) == pytest.approx(spin, abs=1e-12)
