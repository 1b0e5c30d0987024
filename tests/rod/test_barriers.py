import numpy as np
import pytest
from draws import load_drawn

import loopelastica as le
from loopelastica.rod.barriers import NONE_FOUND, OTHER_CLASS
from loopelastica.rod.morse import homotopy_class

FIGURE_6 = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])


@pytest.fixture(scope="module")
def rods():
    return le.equilibria(FIGURE_6)


def test_a_pair_has_the_pass_that_its_saddles_join(rods):
    barriers = le.barriers(rods, search=False)
    minima = [i for i, rod in enumerate(rods) if rod.index == 0]
    assert [b.minima for b in barriers] == [(i, j) for i in minima for j in minima if i < j]
    barrier = barriers.between(2, 1)
    assert barrier.minima == (1, 2)
    assert barrier.energy == barrier.saddle.energy == pytest.approx(40.21129, abs=1e-4)
    assert barrier.saddle.index == 1
    heights = [barrier.energy - rods[i].energy for i in (1, 2)]
    assert barrier.height_from == pytest.approx(heights)
    assert barrier.via == (barrier.saddle,)
    assert barrier.message == ""
    with pytest.raises(ValueError, match="no barrier between 1 and 3"):
        barriers.between(1, 3)


def test_no_pass_leads_to_the_other_class(rods):
    for barrier in le.barriers(rods, search=False):
        a, b = (rods[i] for i in barrier.minima)
        other = homotopy_class(a) != homotopy_class(b)
        assert (barrier.message == OTHER_CLASS) == other
        assert barrier.message in ("", OTHER_CLASS, NONE_FOUND)
        if other:
            assert barrier.saddle is None
            assert barrier.energy == np.inf
            assert barrier.height_from == (np.inf, np.inf)


def test_a_pass_is_found_that_the_list_lacks(rods):
    # 0.026 above the minimum of 67.084, to which both ways of the list's next saddle lead
    minima = [rod for rod in rods if rod.index == 0 and homotopy_class(rod) == 0]
    shallow = next(rod for rod in minima if abs(rod.energy - 67.0844) < 1e-3)
    (barrier,) = le.barriers([minima[0], shallow])
    assert barrier.energy == pytest.approx(67.11058, abs=1e-4)
    assert barrier.saddle.index == 1
    assert barrier.height_from[1] == pytest.approx(0.02619, abs=1e-4)


def test_what_was_found_on_the_way_is_handed_back(rods):
    found = le.barriers([rod for rod in rods if rod.index == 0]).found
    assert found
    assert all(rod.converged and rod.index in (0, 1) for rod in found)
    assert [rod.energy for rod in found] == sorted(rod.energy for rod in found)


def test_the_way_is_the_lowest_of_all_ways(rods):
    barriers = le.barriers(rods)
    height = {b.minima: b.energy for b in barriers}
    for i, j in height:
        for k in {m for pair in height for m in pair} - {i, j}:
            by_k = max(height[tuple(sorted((i, k)))], height[tuple(sorted((j, k)))])
            assert height[i, j] <= by_k
    for barrier in barriers:
        if barrier.saddle is not None:
            assert barrier.energy == max(rod.energy for rod in barrier.via)
            assert min(barrier.height_from) > 0


def test_minima_of_a_free_spin_are_joined():
    rng = np.random.default_rng(4)
    joined = 0
    for position, rotation in zip(*load_drawn(rng, 6, 1.0, True), strict=True):
        clamping = le.Clamping(position, rotation, free_spin=True)
        for barrier in le.barriers(le.equilibria(clamping)):
            assert barrier.message != OTHER_CLASS
            if barrier.saddle is None:
                continue
            low = le.ways_down(barrier.saddle)
            assert all(rod.energy < barrier.energy for rod in low)
            joined += 1
    assert joined


def test_mirror_images_have_the_same_barrier(rods):
    mirrored = le.barriers(le.equilibria(FIGURE_6.mirrored(), energy_max=50))
    for barrier, other in zip(le.barriers(rods[:6]), mirrored, strict=True):
        assert other.energy == pytest.approx(barrier.energy, abs=1e-5)


def test_fewer_than_two_minima_have_no_barrier(rods):
    assert le.barriers([]) == []
    assert le.barriers(rods[:1]) == []
    assert le.barriers([rod for rod in rods if rod.index == 2]) == []


def test_a_time_limit_is_said(rods):
    minima = [rod for rod in rods if rod.index == 0]
    barriers = le.barriers(minima, time_limit_s=1e-9)
    assert barriers.out_of_time
    assert any("time limit" in barrier.message for barrier in barriers)
    assert not le.barriers(rods[:3], search=False).out_of_time


def test_a_table_has_a_row_for_each_pair(rods):
    pytest.importorskip("pandas")
    barriers = le.barriers(rods, search=False)
    table = le.to_dataframe(barriers)
    assert len(table) == len(barriers)
    assert list(table.columns[:3]) == ["minimum", "other_minimum", "barrier_energy"]
    assert table["message"].str.contains("full turn").any()


def test_what_is_no_list_of_one_clamping_is_refused(rods):
    other = le.solve(FIGURE_6.mirrored())
    with pytest.raises(ValueError, match="different clampings"):
        le.barriers([rods[0], other])
    with pytest.raises(ValueError, match="`equilibria` holds 3"):
        le.barriers([rods[0], 3])
    with pytest.raises(ValueError, match="`equilibria` is 3"):
        le.barriers(3)
