import numpy as np
import pytest
from draws import load_drawn
from scipy.spatial.transform import Rotation

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


# rods that are held nearly straight, and wound: they pass each other over a loop
HELD = le.Clamping(
    [-0.8188014257997491, -0.04689623429758041, -0.34606887245488954],
    [
        [0.8363968610926622, 0.2613308224707238, 0.48181582786487726],
        [0.282818084077299, 0.5472218996777773, -0.787757655459837],
        [-0.4695255286703672, 0.7951442596431849, 0.3837855967637447],
    ],
)


def test_passes_above_the_bound_of_the_list_join_what_it_leaves_apart():
    rods = le.equilibria(HELD)
    apart = [b for b in le.barriers(rods, search=False) if b.message == NONE_FOUND]
    assert apart
    barriers = le.barriers(rods)
    for pair in apart:
        barrier = barriers.between(*pair.minima)
        assert barrier.energy > rods.energy_max
        assert barrier.saddle.index == 1
        assert barrier.message == ""
        assert any(barrier.saddle is rod for rod in barriers.found)


def test_a_pass_with_the_same_loop_and_other_twist_is_found():
    turn = Rotation.from_rotvec([-0.9428, 0.7056, 2.19]).as_matrix()
    rods = le.equilibria(le.Clamping([0.1367, 0.5849, 0.65], turn), 0.5)
    wound = next(i for i, rod in enumerate(rods) if abs(rod.energy - 53.1244) < 1e-3)
    barrier = le.barriers(rods).between(0, wound)
    # under a tension of 1177
    assert barrier.energy == pytest.approx(154.840, abs=1e-2)
    assert [rod.index for rod in barrier.via] == [1] * len(barrier.via)


def test_a_plain_list_of_minima_has_the_barriers_of_the_whole_list(rods):
    minima = [rod for rod in rods if rod.energy < 50 and rod.index == 0]
    whole = {b.energy for b in le.barriers(rods) if max(b.minima) < 4 and b.saddle is not None}
    plain = {b.energy for b in le.barriers(minima) if b.saddle is not None}
    assert sorted(plain) == pytest.approx(sorted(whole)[: len(plain)], abs=1e-6)
    assert plain
    # and a higher pass in the list does not stand for a lower one that is not
    saddles = [rod for rod in rods if rod.index == 1 and rod.energy > 41]
    again = {b.energy for b in le.barriers(minima + saddles) if b.saddle is not None}
    assert sorted(again) == pytest.approx(sorted(plain), abs=1e-6)


@pytest.mark.parametrize("free_spin", [False, True])
def test_circles_of_rods_are_joined_by_circles(free_spin):
    rods = le.equilibria(le.Clamping([0, 0, 0.5], np.eye(3), free_spin), rounds=1)
    barriers = [b for b in le.barriers(rods) if b.message != OTHER_CLASS]
    assert barriers
    for barrier in barriers:
        one, other = (rods[i] for i in barrier.minima)
        # mirror images of one another, over a planar rod
        assert one.energy == pytest.approx(other.energy, abs=1e-6)
        assert barrier.saddle.family_dimension == 1
        assert barrier.saddle.twist == pytest.approx(round(barrier.saddle.twist), abs=1e-6)


def test_the_closed_ring_wound_once_passes_over_the_figure_eight():
    rods = le.equilibria(le.Clamping([0, 0, 0], np.eye(3)), rounds=1)
    joined = [b for b in le.barriers(rods) if b.saddle is not None]
    assert [b.energy for b in joined] == pytest.approx([56.220], abs=1e-3)
    heights = [height for b in joined for height in b.height_from]
    assert heights == pytest.approx([56.220 - 4 * np.pi**2] * 2, abs=1e-3)


def own_descent(saddle, sign, n=48):
    """Energy at the end of an explicit gradient flow of a chain of rotations, K30 = 1.

    Turns of the n frames between both ends; E = ½ n Σ ω², ω the turn from each to the next.
    """
    frames = Rotation.from_quat(
        saddle.poses(np.r_[0.0, (np.arange(n) + 0.5) / n, 1.0])[:, 3:], scalar_first=True
    )
    weights = np.r_[2.0, np.ones(n - 1), 2.0] * n
    position = saddle.clamping.position
    rng = np.random.default_rng(5)
    step, kick, energy = 0.1 / n**2, rng.normal(size=(n, 3)), np.inf
    for k in range(60_000):
        omega = (frames[:-1].inv() * frames[1:]).as_rotvec() * weights[:, None] ** 0.5
        before, energy = energy, 0.5 * np.sum(omega**2)
        if k > 2000 and k % 500 == 0 and abs(before - energy) < 1e-7:
            break
        force = omega * weights[:, None] ** 0.5
        slope = n * (force[1:] - force[:-1])
        if k < 1500:
            # along a random direction until the unstable one has taken over
            slope = slope + sign * 20.0 * np.exp(-k / 200) * kick
        inner = frames[1:-1].as_matrix()
        # the turn b moves the end by −(t × …) / n: columns d1, d2
        sides = np.stack([-inner[:, :, 1], inner[:, :, 0], 0 * inner[:, :, 2]], axis=2) / n
        sides = sides.transpose(1, 0, 2).reshape(3, -1)
        off = inner[:, :, 2].sum(axis=0) / n - position
        turns = step * slope.ravel()
        turns -= sides.T @ np.linalg.solve(sides @ sides.T, sides @ turns + off)
        moved = frames[1:-1] * Rotation.from_rotvec(turns.reshape(-1, 3))
        frames = Rotation.concatenate([frames[0], moved, frames[-1]])
    return energy


@pytest.mark.slow
def test_an_own_chain_flows_from_the_pass_to_both_minima(rods):
    barrier = le.barriers(rods, search=False).between(1, 2)
    ends = sorted(own_descent(barrier.saddle, sign) for sign in (1.0, -1.0))
    assert ends == pytest.approx([rods[1].energy, rods[2].energy], rel=0.02)
