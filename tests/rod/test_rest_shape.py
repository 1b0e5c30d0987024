import json

import numpy as np
import pytest
from chains import clamping_near, shape_drawn
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import loopelastica as le


def test_a_chain_clamped_at_its_own_rest_end_stores_nothing(rng):
    shapes = [
        le.RestShape.from_rates(0, 0, 0),
        le.RestShape.from_rates(1.0, 2.5, 3.0),
        le.RestShape.from_rates(lambda s: np.sin(6 * s), 2.5, lambda s: 3 * s, 40),
        *(shape_drawn(rng, m) for m in (2, 5, 9)),
    ]
    for shape in shapes:
        for free_spin in (False, True):
            own = shape.clamping
            chain = shape.deform(le.Clamping(own.position, own.rotation, free_spin), 0.6)
            assert chain.converged
            assert chain.stable
            assert chain.energy < 1e-20
            np.testing.assert_allclose(chain.nodes, shape.points / shape.length, atol=1e-10)
            np.testing.assert_allclose(chain.end_frame, shape.end_frame, atol=1e-10)


def test_rates_give_the_rod_of_these_rates():
    def slope(s, state):
        frame = state[:9].reshape(3, 3)
        x, y, z = np.sin(6 * s), 2.5, 3 * s
        turned = frame @ [[0, -z, y], [z, 0, -x], [-y, x, 0]]
        return np.concatenate([turned.ravel(), frame[:, 2]])

    start = np.concatenate([np.eye(3).ravel(), np.zeros(3)])
    exact = solve_ivp(slope, (0, 1), start, rtol=1e-10, atol=1e-12).y[:, -1]
    errors = []
    for segments in (50, 100):
        shape = le.RestShape.from_rates(lambda s: np.sin(6 * s), 2.5, lambda s: 3 * s, segments)
        assert shape.length == pytest.approx(1)
        assert shape.points.shape == (segments + 1, 3)
        end = np.concatenate([shape.end_frame.ravel(), shape.points[-1]])
        errors.append(np.abs(end - exact).max())
    assert errors[1] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.05)


def test_constant_rates_turn_the_end_exactly():
    shape = le.RestShape.from_rates(1.0, -2.0, 3.0, 7)
    exact = Rotation.from_rotvec([1.0, -2.0, 3.0]).as_matrix()
    np.testing.assert_allclose(shape.end_frame, exact, atol=1e-14)


def test_poses_in_any_coordinates_give_the_same_shape(rng):
    shape = shape_drawn(rng, 5, varied=False)
    place = Rotation.random(random_state=rng).as_matrix()
    points = shape.points @ place.T + [7, -8, 9]
    same = le.RestShape.from_poses(points, place, place @ shape.end_frame)
    np.testing.assert_allclose(same.steps, shape.steps, atol=1e-14)
    np.testing.assert_allclose(same.end_frame, shape.end_frame, atol=1e-14)
    assert same.length == pytest.approx(shape.length)


def test_a_shape_survives_its_dictionary_and_cannot_be_written_to(rng):
    shape = shape_drawn(rng, 5)
    assert le.RestShape.from_dict(json.loads(json.dumps(shape.to_dict()))) == shape
    assert shape != shape_drawn(rng, 5)
    with pytest.raises(ValueError, match="read-only"):
        shape.steps[0, 0] = 1


def test_the_unit_of_length_does_not_matter(rng):
    shape = shape_drawn(rng, 6)
    clamping = clamping_near(rng, shape)
    larger = le.RestShape(7.3 * shape.steps, shape.end_frame, shape.stiffness)
    one, other = shape.deform(clamping, 0.7), larger.deform(clamping, 0.7)
    assert one.energy == pytest.approx(other.energy, rel=1e-10)
    np.testing.assert_allclose(one.nodes, other.nodes, atol=1e-10)


STEPS = [[0, 0, 1.0], [0, 1.0, 0], [1.0, 0, 0]]


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (([[0, 0, 1.0]], np.eye(3)), "steps"),
        (([], np.eye(3)), "steps"),
        ((np.ones((4, 2)), np.eye(3)), "steps"),
        (("abc", np.eye(3)), "steps"),
        (([*STEPS, [0, 0, 0]], np.eye(3)), "steps"),
        (([*STEPS, [0, 0, np.nan]], np.eye(3)), "steps"),
        (([*STEPS, [0, 0, np.inf]], np.eye(3)), "steps"),
        (([*STEPS, [0, 0, 1e-200]], np.eye(3)), "steps"),
        ((STEPS, 2 * np.eye(3)), "end_frame"),
        ((STEPS, np.diag([1, 1, -1])), "end_frame"),
        ((STEPS, np.eye(2)), "end_frame"),
        ((STEPS, None), "end_frame"),
        ((STEPS, np.eye(3), np.ones(3)), "stiffness"),
        ((STEPS, np.eye(3), [1, 1, 0, 1]), "stiffness"),
        ((STEPS, np.eye(3), [1, 1, np.nan, 1]), "stiffness"),
        ((STEPS, np.eye(3), [1, 1, -1, 1]), "stiffness"),
    ],
)
def test_what_is_no_shape_is_refused_by_name(arguments, name):
    with pytest.raises(ValueError, match=f"`{name}`"):
        le.RestShape(*arguments)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ((np.nan, 0, 0), "curvature_1"),
        ((0, "much", 0), "curvature_2"),
        ((0, 0, lambda s: np.inf), "twist"),
        ((0, 0, 0, 1), "segments"),
        ((0, 0, 0, 2.5), "segments"),
        ((0, 0, 0, 10**7), "segments"),
        ((0, 1e3, 0, 10), "segments"),
        ((1e200, 1e200, 1e200, 10), "segments"),
    ],
)
def test_rates_that_are_none_are_refused_by_name(arguments, name):
    with pytest.raises(ValueError, match=f"`{name}`"):
        le.RestShape.from_rates(*arguments)


@pytest.mark.parametrize(
    ("changed", "name"),
    [
        ({"points": STEPS[:2]}, "points"),
        ({"points": [*STEPS, STEPS[2]]}, "points"),
        ({"points": [*STEPS, [np.nan] * 3]}, "points"),
        ({"points": None}, "points"),
        ({"start_frame": np.zeros((3, 3))}, "start_frame"),
        ({"end_frame": np.ones((3, 3))}, "end_frame"),
    ],
)
def test_poses_that_are_none_are_refused_by_name(changed, name):
    good = {"points": STEPS, "start_frame": np.eye(3), "end_frame": np.eye(3)}
    with pytest.raises(ValueError, match=f"`{name}`"):
        le.RestShape.from_poses(**(good | changed))


def test_a_dictionary_that_is_no_shape_is_refused(rng):
    values = shape_drawn(rng, 3).to_dict()
    with pytest.raises(ValueError, match="`values`"):
        le.RestShape.from_dict([])
    with pytest.raises(KeyError):
        le.RestShape.from_dict({"steps": values["steps"]})
    with pytest.raises(ValueError, match="`stiffness`"):
        le.RestShape.from_dict(values | {"stiffness": [1, 2]})
