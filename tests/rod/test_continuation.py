import inspect
import math

import numpy as np
import pytest
from draws import pose_drawn
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod.continuation import continue_clamping, twist_end
from loopelastica.rod.kernels.records import Status

FIGURE_6 = [-0.4, -0.1, 0.5, 4.8, 1.4, 2.2]


def pairs(rng, n, low=0.0, high=0.95, free_spin=False):
    positions, rotations = pose_drawn(rng, 2 * n, low, high)
    clampings = [le.Clamping(p, r, free_spin) for p, r in zip(positions, rotations, strict=True)]
    return list(zip(clampings[:n], clampings[n:], strict=True))


def turning_points(values):
    steps = np.diff(values)
    return int(np.count_nonzero(steps[1:] * steps[:-1] < 0))


@pytest.mark.parametrize(
    ("torsion_ratio", "free_spin"), [(1.0, False), (0.7, False), (1.0, True), (0.7, True)]
)
def test_the_end_of_a_path_is_an_equilibrium_there_and_the_way_back_leads_home(
    rng, torsion_ratio, free_spin
):
    for a, b in pairs(rng, 4, high=0.8, free_spin=free_spin):
        rod = le.solve(a, torsion_ratio)
        path = continue_clamping(rod, b, stability=False)
        assert all(r.converged and r.residual < 1e-9 for r in path.rods)
        assert len(path.parameter) == len(path.rods)
        assert turning_points(path.parameter) == len(path.folds)
        if not path.converged:
            assert path.end is None
            continue
        assert np.abs(path.end.clamping.position - b.position).max() < 1e-12
        assert np.abs(path.end.clamping.rotation - b.rotation).max() < 1e-12
        end = path.end.poses(np.ones(1))[0]
        assert np.abs(end[:3] - b.position).max() < 1e-9
        back = continue_clamping(path.end, a, stability=False)
        if len(path.folds) == 0:
            assert back.converged
            assert np.abs(back.end.loads - rod.loads).max() < 1e-6


def test_the_end_of_a_path_is_in_the_list_of_equilibria(rng):
    for a, b in pairs(rng, 2, 0.4, 0.9):
        path = continue_clamping(le.solve(a), b)
        assert path.converged
        loads = [rod.loads for rod in le.equilibria(b)]
        assert np.abs(np.array(loads) - path.end.loads).max(axis=1).min() < 1e-6
        assert path.end.index is not None


def test_one_turn_of_the_end_leads_to_the_second_solution_of_figure_6():
    rod = le.solve(le.Clamping.from_parameters(FIGURE_6))
    p = rod.physical
    assert np.allclose(
        [p.lam, p.t_p, p.a, p.length], [-0.3112, -0.2178, -0.7406, 4.7988], atol=6e-5
    )
    path = twist_end(rod, 1.0)
    assert path.converged
    p = path.end.physical
    assert np.allclose([p.lam, p.t_p, p.a, p.length], [1.0462, 1.5606, 3.2264, 3.1601], atol=6e-5)
    # the sixth clamping parameter φ grows by one turn: so does the net winding
    assert path.end.net_winding - rod.net_winding == pytest.approx(1.0, abs=1e-6)
    assert np.abs(path.end.clamping.parameters - FIGURE_6).max() < 1e-9


@pytest.mark.parametrize("torsion_ratio", [1.0, 0.7])
def test_three_turns_of_the_end_either_way(rng, torsion_ratio):
    for position, rotation in zip(*pose_drawn(rng, 4), strict=True):
        rod = le.solve(le.Clamping(position, rotation), torsion_ratio)
        for turns in (3.0, -3.0):
            path = twist_end(rod, turns)
            assert path.converged
            assert path.parameter[-1] == pytest.approx(turns, abs=1e-9)
            assert turning_points(path.parameter) == len(path.folds)
            assert max(r.residual for r in path.rods) < 1e-9


def test_stability_is_lost_at_the_first_fold_of_a_generic_rod():
    rod = le.solve(le.Clamping.from_parameters(FIGURE_6))
    path = twist_end(rod, 2.5, stability=True)
    assert path.converged
    assert len(path.folds) >= 2
    assert path.rods[0].index == 0
    assert path.snaps_at == path.stability_lost[0] == path.folds[0]
    # beyond the fold there is no rod nearby: the branch never goes further before it turns back
    turned = int(np.argmax(np.diff(path.parameter) < 0))
    assert path.parameter[: turned + 1].max() <= path.folds[0] + 1e-12
    assert path.rods[turned + 1].index == 1


@pytest.mark.parametrize("torsion_ratio", [0.7, 1.0, 1.5])
def test_a_ring_loses_stability_at_michells_twist(torsion_ratio):
    # 2π√3 K0/K3: A. G. M. Michell, Messenger of Math. 11 (1889) 181
    ring = le.solve(le.Clamping([0, 0, 0], np.eye(3)), torsion_ratio)
    assert ring.energy == pytest.approx(2 * math.pi**2, rel=1e-9)
    path = twist_end(ring, 3.0, stability=True)
    assert path.converged
    assert len(path.folds) == 0
    assert path.stability_lost[0] == pytest.approx(math.sqrt(3) / torsion_ratio, rel=2e-3)
    assert path.end.twist == pytest.approx(3.0, abs=1e-9)


def test_an_arch_stretched_nearly_straight_bears_eulers_load():
    arch = le.solve(le.Clamping([0, 0, 0.9], np.eye(3)))
    path = continue_clamping(arch, le.Clamping([0, 0, 0.9999], np.eye(3)))
    assert path.converged
    assert len(path.folds) == len(path.stability_lost) == 0
    assert -path.end.loads[2] == pytest.approx(4 * math.pi**2, rel=1e-4)


@pytest.mark.parametrize("free_spin", [False, True])
def test_an_arch_that_may_turn_about_its_chord_follows_its_ends_downhill(free_spin):
    arch = le.solve(le.Clamping([0, 0, 0.9], np.eye(3), free_spin))
    for axis in ([0.6, 0, 0], [0, 0.6, 0]):
        tilted = le.Clamping([0, 0, 0.9], Rotation.from_rotvec(axis).as_matrix(), free_spin)
        path = continue_clamping(arch, tilted)
        assert path.converged
        assert path.end.energy == pytest.approx(le.solve(tilted).energy, abs=1e-9)
        assert path.end.stable


def test_a_planar_arch_gives_way_out_of_its_plane_before_the_branch_folds():
    # held by a small tilt the arch cannot turn about its chord; tilted back it winds into ever
    # more planar waves, and never arrives
    held = le.Clamping([0, 0, 0.9], Rotation.from_rotvec([0.3, 0, 0]).as_matrix())
    other = le.Clamping([0, 0, 0.9], Rotation.from_rotvec([-2.5, 0, 0]).as_matrix())
    path = continue_clamping(le.solve(held), other, steps=150)
    assert path.status == Status.TOO_MANY_ITERATIONS
    assert "turned back at 0.3" in path.message
    assert 0 < path.snaps_at < path.folds[0]
    assert max(np.abs(rod.centerline(9)[:, 0]).max() for rod in path.rods) < 1e-8
    lost = int(np.argmax([rod.index > 0 for rod in path.rods]))
    assert path.parameter[lost - 1] <= path.snaps_at <= path.parameter[lost]
    # past the snap the rod of least energy is another one
    beyond = path.rods[lost].clamping
    assert le.solve(beyond).energy < path.rods[lost].energy - 1e-6


def test_a_small_motion_takes_one_step(rng):
    rod = le.solve(le.Clamping.from_parameters(FIGURE_6))
    near = le.Clamping.from_parameters(np.array(FIGURE_6) + 0.01)
    path = continue_clamping(rod, near)
    assert path.converged
    assert len(path.rods) == 2
    small_steps = continue_clamping(rod, near, natural=False)
    assert len(small_steps.rods) > 2
    assert np.abs(path.end.loads - small_steps.end.loads).max() < 1e-7
    still = continue_clamping(rod, rod.clamping)
    assert still.converged
    assert np.array_equal(still.end.loads, rod.loads)


def test_between_slack_and_tense_rods(rng):
    for (a, _), (b, _) in zip(pairs(rng, 2, 0.3, 0.9), pairs(rng, 2, 0.995, 0.999), strict=True):
        path = continue_clamping(le.solve(a), b, stability=False)
        assert path.converged
        assert path.end.residual < 1e-9
        onward = continue_clamping(path.end, le.Clamping(b.position * 0.999, b.rotation))
        assert onward.converged


def test_what_cannot_be_reached_is_a_status():
    rod = le.solve(le.Clamping.from_parameters(FIGURE_6))
    out = continue_clamping(rod, le.Clamping([0, 0, 1.2], np.eye(3)))
    assert out.status == Status.UNREACHABLE
    assert out.end is None
    assert "further apart" in out.message
    few = twist_end(rod, 5.0, steps=3)
    assert few.status == Status.TOO_MANY_ITERATIONS
    assert np.isfinite(few.parameter).all()
    straight = le.solve(le.Clamping([0, 0, 1], np.eye(3)))
    assert continue_clamping(straight, rod.clamping).status == Status.STALLED
    stalled = le.Equilibrium(rod.clamping, 1.0, np.zeros(6), math.inf, math.inf, Status.STALLED)
    assert twist_end(stalled, 1.0).status == Status.STALLED
    assert twist_end(stalled, 1.0).rods == ()


def test_arguments_that_make_no_sense_are_refused():
    rod = le.solve(le.Clamping([0, 0, 0.5], np.eye(3)))
    free = le.solve(le.Clamping([0, 0, 0.5], np.eye(3), free_spin=True))
    with pytest.raises(ValueError, match="`clamping`"):
        continue_clamping(rod, free.clamping)
    with pytest.raises(ValueError, match="`turns`"):
        twist_end(rod, math.nan)
    with pytest.raises(ValueError, match="`rod`"):
        twist_end(free, 1.0)


def test_both_ways_to_move_a_rod_have_the_same_defaults():
    clamp, twist = (inspect.signature(f).parameters for f in (continue_clamping, twist_end))
    for name in ("max_step", "stability"):
        assert clamp[name].default == twist[name].default
        assert clamp[name].kind == twist[name].kind == inspect.Parameter.KEYWORD_ONLY
    rod = le.solve(le.Clamping.from_parameters(FIGURE_6))
    near = le.Clamping.from_parameters(np.array(FIGURE_6) + 0.01)
    for path in (continue_clamping(rod, near), twist_end(rod, 0.02)):
        assert all(r.index == 0 for r in path.rods)


def test_without_stability_the_first_fold_is_where_a_rod_snaps():
    rod = le.solve(le.Clamping.from_parameters(FIGURE_6))
    path = twist_end(rod, 2.5, stability=False)
    assert len(path.stability_lost) == 0
    assert all(r.index is None for r in path.rods)
    assert path.snaps_at == path.folds[0]
    assert twist_end(rod, 0.02).snaps_at is None


def test_a_closed_branch_ends_where_it_began():
    rods = le.equilibria(le.Clamping([0.1, 0, 0.3], np.eye(3)), rounds=2)
    rod = min(rods, key=lambda r: abs(r.energy - 33.3202))
    path = twist_end(rod, 6.0, steps=300, stability=False)
    assert path.status == Status.STALLED
    assert "closed" in path.message
    assert path.end is None
    assert len(path.folds) >= 2
    assert path.parameter[-1] == pytest.approx(0, abs=1e-9)
    np.testing.assert_allclose(path.rods[-1].loads, rod.loads, atol=1e-4)
