import numpy as np
import pytest
from draws import load_drawn

import loopelastica as le
import loopelastica.rod.solve as solving
from loopelastica.rod.continuation import continue_clamping, twist_end
from loopelastica.rod.kernels.records import Method, Status
from loopelastica.rod.solve import detours

FIGURE_6 = [-0.4, -0.1, 0.5, 4.8, 1.4, 2.2]


def test_rotating_the_start_frame_rotates_the_loads(rng):
    c, s = np.cos(1.234), np.sin(1.234)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    for position, rotation in zip(*load_drawn(rng, 10), strict=True):
        clamping = le.Clamping(position, rotation)
        loads, turned = (
            le.solve(q, lowest=False).loads.reshape(2, 3)
            for q in (clamping, clamping.turned(1.234))
        )
        np.testing.assert_allclose(turned, loads @ turn.T, atol=1e-6)


def test_reversed_and_mirrored_loads_solve_the_reversed_and_mirrored_clamping(rng):
    from loopelastica.rod.kernels.shooting import ends

    flip, mirror = np.diag([1.0, -1, -1]), np.diag([1.0, -1, 1])
    for position, rotation in zip(*load_drawn(rng, 10, 0.7), strict=True):
        clamping = le.Clamping(position, rotation)
        rod = le.solve(clamping, 0.7, lowest=False)
        force, moment = rod.loads[:3], rod.moment(2)[-1]
        back = -flip @ rotation.T
        mirrored = np.concatenate([mirror @ rod.loads[:3], -mirror @ rod.loads[3:]])
        for loads, target in (
            (np.concatenate([back @ force, back @ moment]), clamping.reversed()),
            (mirrored, clamping.mirrored()),
        ):
            p, _ = ends(loads[None], 0.7, 4.0)
            np.testing.assert_allclose(p[0], target.position, atol=1e-8)


def test_what_cannot_be_is_refused_with_the_reason():
    with pytest.raises(ValueError, match="further"):
        le.solve(le.Clamping([0, 0, 1.1], np.eye(3)))
    with pytest.raises(ValueError, match="full length"):
        le.solve(le.Clamping([0, 1, 0], np.eye(3)))
    with pytest.raises(ValueError, match="torsion_ratio"):
        le.solve(le.Clamping([0, 0, 0.5], np.eye(3)), torsion_ratio=0)
    with pytest.raises(ValueError, match="rotations"):
        le.solve_batch(np.zeros((2, 3)), np.zeros((3, 3, 3)))


def test_the_straight_rod_carries_twist_and_no_force():
    quarter = le.Clamping.from_parameters([0, 0, 1, np.pi / 2, 0, 0])
    rod = le.solve(quarter, torsion_ratio=0.7)
    assert rod.converged
    assert rod.twist == pytest.approx(0.25)
    assert rod.energy == pytest.approx(0.5 * 0.7 * (np.pi / 2) ** 2)
    np.testing.assert_allclose(rod.loads[:3], 0)
    np.testing.assert_allclose(rod.frames(3)[-1], quarter.rotation, atol=1e-12)


def nearby(clamping, rng, size):
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_rotvec(size * rng.normal(size=3)).as_matrix()
    shift = 0.2 * size * rng.normal(size=3)
    return le.Clamping(clamping.position + shift, clamping.rotation @ turn, clamping.free_spin)


@pytest.mark.parametrize("free_spin", [False, True])
def test_a_guess_leads_to_the_rod_next_to_it(rng, free_spin):
    for position, rotation in zip(*load_drawn(rng, 6, 0.7, free_spin, 0.8), strict=True):
        rod = le.solve(le.Clamping(position, rotation, free_spin), 0.7)
        goal = nearby(rod.clamping, rng, 0.01)
        for guess in (rod, rod.loads, rod.loads.tolist()):
            warm = le.solve(goal, 0.7, guess=guess)
            assert_next(warm, rod, goal)


def test_a_guess_that_is_not_the_lowest_leads_to_one_that_is_not(rng):
    rods = le.equilibria(le.Clamping.from_parameters(FIGURE_6), rounds=1)
    for rod in rods[1:4]:
        goal = nearby(rod.clamping, rng, 0.01)
        assert_next(le.solve(goal, guess=rod), rod, goal)


def assert_next(warm, rod, goal):
    assert warm.method == Method.GUESS
    assert warm.residual < 1e-9
    assert abs(warm.energy - rod.energy) < 0.1 * (1 + rod.energy)
    assert np.abs(warm.centerline(9) - rod.centerline(9)).max() < 0.05
    assert np.abs(warm.centerline(2)[-1] - goal.position).max() < 1e-9


@pytest.mark.parametrize("shortening", [1e-2, 1e-3, 1e-4])
def test_a_tense_guess_leads_to_the_rod_next_to_it(shortening):
    direction = np.array([0.5, 0, 0.75**0.5])
    rod = le.solve(le.Clamping((1 - shortening) * direction, np.eye(3)))
    goal = le.Clamping((1 - 1.01 * shortening) * direction, np.eye(3))
    warm = le.solve(goal, guess=rod)
    assert warm.method == Method.GUESS
    assert warm.energy == pytest.approx(le.solve(goal).energy, rel=1e-9)


def test_a_guess_of_another_torsion_ratio_or_spin_serves_by_its_loads():
    clamping = le.Clamping.from_parameters(FIGURE_6)
    rod = le.solve(clamping, 1.0)
    warm = le.solve(clamping, 0.95, guess=rod)
    assert warm.method == Method.GUESS
    assert warm.torsion_ratio == 0.95
    assert warm.energy == pytest.approx(le.solve(clamping, 0.95).energy, rel=1e-9)
    free = le.solve(le.Clamping(clamping.position, clamping.rotation, True), guess=rod)
    assert free.clamping.free_spin
    assert free.loads[5] == 0
    assert free.residual < 1e-9


def test_a_bad_guess_falls_back_to_the_standard_starts():
    clamping = le.Clamping.from_parameters(FIGURE_6)
    plain = le.solve(clamping)
    stiff = [0, 0, 1e5, 0, 0, 0]
    unsolved = le.Equilibrium(clamping, 1.0, stiff, np.inf, np.inf, Status.STALLED)
    for guess in (stiff, unsolved):
        rod = le.solve(clamping, guess=guess)
        assert rod.method not in (Method.GUESS, Method.CONTINUATION)
        np.testing.assert_array_equal(rod.loads, plain.loads)
    # a rod stretched straight needs none
    assert le.solve(le.Clamping([0, 0, 1], np.eye(3)), guess=stiff).method == Method.STRAIGHT


def test_impossible_arguments_are_named():
    clamping = le.Clamping.from_parameters(FIGURE_6)
    for named, wrong in (
        ("guess", np.zeros(5)),
        ("guess", np.zeros((1, 6))),
        ("guess", [0, 0, np.nan, 0, 0, 0]),
        ("tolerance", 0.0),
        ("tolerance", 0.9e-11),
        ("tolerance", 1.1e-3),
        ("tolerance", np.nan),
        ("time_limit_s", 0),
        ("time_limit_s", -1.0),
        ("time_limit_s", "1"),
        ("torsion_ratio", -0.1),
        ("torsion_ratio", np.inf),
    ):
        with pytest.raises(ValueError, match=f"`{named}`"):
            le.solve(clamping, **{named: wrong})
        if named != "guess":
            with pytest.raises(ValueError, match=f"`{named}`"):
                le.equilibria(clamping, **{named: wrong})
    for wrong in (0, 5):
        with pytest.raises(ValueError, match="`rounds`"):
            le.equilibria(clamping, rounds=wrong)


@pytest.mark.parametrize("tolerance", [1e-11, 1e-6, 1e-3])
def test_the_residual_is_below_the_tolerance(rng, tolerance):
    for position, rotation in zip(*load_drawn(rng, 5), strict=True):
        rod = le.solve(le.Clamping(position, rotation), tolerance=tolerance)
        assert rod.converged == (rod.residual < tolerance)
        assert rod.converged
        warm = le.solve(rod.clamping, guess=rod.loads, tolerance=tolerance)
        assert warm.residual < tolerance


def unsolved(clamping):
    return le.Equilibrium(clamping, 1.0, np.zeros(6), np.inf, np.inf, Status.STALLED)


def test_where_no_start_arrives_a_clamping_nearby_leads_on(monkeypatch):
    clamping = le.Clamping.from_parameters(FIGURE_6)
    plain = le.solve(clamping)
    ways = [rod for rod in detours(clamping, 1.0) if rod is not None]
    assert len(ways) > 6
    assert all(rod.method == Method.NEARBY and rod.residual < 1e-9 for rod in ways)
    standard = solving.from_standard_starts
    monkeypatch.setattr(
        solving,
        "from_standard_starts",
        lambda q, *others: unsolved(q) if q == clamping else standard(q, *others),
    )
    rod = le.solve(clamping)
    assert rod.method == Method.NEARBY
    assert rod.energy == min(way.energy for way in ways) == pytest.approx(plain.energy)
    first = le.solve(clamping, lowest=False)
    np.testing.assert_array_equal(first.loads, ways[0].loads)


def test_a_time_limit_ends_the_detours(monkeypatch):
    clamping = le.Clamping.from_parameters(FIGURE_6)
    plain = le.solve(clamping)
    tried = []

    def ways(results):
        def each(*_):
            for result in results:
                tried.append(result)
                yield result

        return each

    monkeypatch.setattr(solving, "from_standard_starts", lambda q, *_: unsolved(q))
    monkeypatch.setattr(solving, "detours", ways([None, plain, None]))
    rod = le.solve(clamping, time_limit_s=1e-9)
    assert (rod.status, len(tried)) == (Status.OUT_OF_TIME, 1)
    assert "time limit" in rod.message
    monkeypatch.setattr(solving, "detours", ways([plain, None, None]))
    rod = le.solve(clamping, time_limit_s=1e-9)
    # what was found in time is returned
    assert rod.converged
    assert len(tried) == 2
    monkeypatch.setattr(solving, "detours", ways([None, None]))
    assert le.solve(clamping, time_limit_s=60.0).status == Status.STALLED
    assert le.solve(clamping).status == Status.STALLED


def test_the_method_says_how_a_rod_was_found():
    clamping = le.Clamping.from_parameters(FIGURE_6)
    rod = le.solve(clamping)
    assert rod.method in (Method.DISCRETE_ROD, Method.DISCRETE_ROD_SHOOTING)
    near = le.Clamping.from_parameters(np.array(FIGURE_6) + 0.01)
    far = le.Clamping.from_parameters(np.array(FIGURE_6) + 0.1)
    paths = (
        continue_clamping(rod, near, natural=True),
        continue_clamping(rod, far, natural=False),
        twist_end(rod, 0.2),
    )
    for path in paths:
        assert path.rods[0].method == rod.method
        assert {r.method for r in path.rods[1:]} == {Method.CONTINUATION}
        assert path.end.method == Method.CONTINUATION
    assert le.solve(near, guess=rod).method == Method.GUESS
    assert le.solve(le.Clamping([0, 0, 1], np.eye(3))).method == Method.STRAIGHT
    tense = le.solve(le.Clamping([0.5, 0, 0.865], np.eye(3)))
    assert tense.method == Method.BOUNDARY_LAYERS
    assert str(tense.method) == "boundary layers"
