import numpy as np
import pytest

import loopelastica as le
from loopelastica.rod._search import AXES, Search
from loopelastica.rod._starts import Deadline

FIGURE_6 = [-0.4, -0.1, 0.5, 4.8, 1.4, 2.2]


@pytest.mark.parametrize("free_spin", [False, True])
def test_what_each_way_found_adds_up(free_spin):
    search = Search(le.Clamping.from_parameters(FIGURE_6, free_spin), 0.7, 1e-9, Deadline(None))
    search.drawn(40, 40)
    search.random(40)
    assert search.starts == 80
    for axis in AXES:
        search.tour(axis, 80.0, 10)
    assert sum(search.found_by.values()) == len(search)
    tours = search.tours
    assert tours.closed + tours.left > 0
    assert min(tours.closed, tours.left, tours.lost, tours.unfinished) >= 0


def test_nothing_is_begun_after_the_deadline():
    search = Search(le.Clamping.from_parameters(FIGURE_6), 1.0, 1e-9, Deadline(1e-9))
    search.drawn(40, 80)
    search.random(80)
    search.tour("d3", 80.0, 10)
    search.pulled(40, 1.5, 80.0)
    assert search.starts == 0
    assert len(search) == 0
    assert search.lowest == np.inf
    assert search.solutions(80.0) == []


def test_solutions_hold_on_a_mesh_of_their_own():
    clamping = le.Clamping.from_parameters(FIGURE_6)
    search = Search(clamping, 0.4, 1e-9, Deadline(None))
    search.drawn(80, 80)
    found = search.solutions(80.0)
    assert found
    for rod, hits in found:
        assert rod.converged
        assert hits > 0
        line, frames = rod.centerline(33), rod.frames(33)
        # nodes, and poses by the loads alone
        again = le.Equilibrium(clamping, 0.4, rod.loads, rod.energy, 0.0, rod.status)
        np.testing.assert_allclose(again.centerline(33), line, atol=1e-4)
        np.testing.assert_allclose(again.frames(33), frames, atol=1e-3)
        np.testing.assert_allclose(line[-1], clamping.position, atol=1e-8)
