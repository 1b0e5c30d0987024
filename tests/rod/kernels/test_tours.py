import numpy as np
import pytest
from scipy.integrate import solve_ivp

import loopelastica as le
from loopelastica.rod._search import AXES, Search, _in_the_middle
from loopelastica.rod._starts import Deadline
from loopelastica.rod.kernels.middle import Catch, enter
from loopelastica.rod.kernels.tours import Tour, visit

FIGURE_6 = [-0.4, -0.1, 0.5, 4.8, 1.4, 2.2]


def catch_of(symmetry=0, room=500):
    return Catch(
        np.empty((room, 6)), np.empty((room, 6)), np.empty(room), np.zeros(room, np.int64),
        np.zeros(1, np.int64), symmetry,
    )  # fmt: skip


def end_of(g, torsion_ratio):
    """End position and frame in the start frame, from loads in the middle, by SciPy."""

    def slope(_, y):
        r, frame = y[:3], y[3:].reshape(3, 3)
        moment = g[3:] + np.cross(g[:3], r)
        t = frame[:, 2]
        omega = moment + (1 / torsion_ratio - 1) * (moment @ t) * t
        return np.concatenate([t, np.cross(omega, frame.T).T.ravel()])

    y0 = np.concatenate([np.zeros(3), np.eye(3).ravel()])
    start, end = (
        solve_ivp(slope, (0, s), y0, "DOP853", rtol=1e-11, atol=1e-12).y[:, -1] for s in (-0.5, 0.5)
    )
    first = start[3:].reshape(3, 3)
    return first.T @ (end[:3] - start[:3]), first.T @ end[3:].reshape(3, 3)


@pytest.mark.parametrize("axis", ["d1", "d2", "d3"])
@pytest.mark.parametrize(
    ("torsion_ratio", "free_spin"), [(1.0, False), (0.4, False), (3.0, False), (1.0, True)]
)
def test_what_a_tour_meets_has_the_clamping_of_its_start(problem, axis, torsion_ratio, free_spin):
    clamping = le.Clamping.from_parameters(FIGURE_6, free_spin)
    rod, catch = le.solve(clamping, torsion_ratio), catch_of()
    enter(_in_the_middle(rod), rod.energy, catch)
    tour = Tour(np.array(AXES[axis]), axis == "d3", np.zeros(3), 150.0, 600, 0.5, 0.9)
    walked, ended = np.zeros(500, np.bool_), np.zeros(4, np.int64)
    made = visit(problem(clamping, torsion_ratio, 1e-9), tour, 120.0, catch, walked, 30, ended)
    count = int(catch.count[0])
    assert 1 <= made <= count
    # one way round is enough where a curve closes; else both are followed
    assert made <= ended.sum() <= 2 * made
    assert count > 1 or axis != "d3"
    for g in catch.loads[:count]:
        place, frame = end_of(g, torsion_ratio)
        # a coarse mesh
        np.testing.assert_allclose(place, clamping.position, atol=2e-2)
        compared = [2] if free_spin else [0, 1, 2]
        np.testing.assert_allclose(frame[:, compared], clamping.rotation[:, compared], atol=0.1)
        assert not free_spin or abs(g[5]) < 1e-9


def test_no_tour_leaves_from_where_another_came_through(problem):
    clamping = le.Clamping.from_parameters(FIGURE_6)
    rod, catch = le.solve(clamping), catch_of()
    enter(_in_the_middle(rod), rod.energy, catch)
    tour = Tour(np.array(AXES["d3"]), True, np.zeros(3), 150.0, 600, 0.5, 0.9)
    walked, ended = np.zeros(500, np.bool_), np.zeros(4, np.int64)
    target = problem(clamping, 1.0, 1e-9)
    assert visit(target, tour, 120.0, catch, walked, 500, ended) >= 1
    low = catch.energies[: catch.count[0]] <= 120
    assert walked[: catch.count[0]][low].all()
    assert visit(target, tour, 120.0, catch, walked, 500, ended) == 0


def test_rods_of_a_slacker_clamping_are_pulled_to_this_one():
    clamping = le.Clamping.from_parameters(FIGURE_6)
    known = le.equilibria(clamping)
    search = Search(clamping, 1.0, 1e-9, Deadline(None))
    search.pulled(40, 1.3, 90.0)
    assert len(search) > 0
    for rod, _ in search.solutions(80.0):
        assert any(abs(rod.energy - other.energy) < 1e-6 for other in known)
