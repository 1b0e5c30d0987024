import json

import numpy as np
import pytest
from draws import load_drawn, pose_drawn

import loopelastica as le
import loopelastica.rod.solve as solving
from loopelastica.rod.equilibrium import Status


def end_misfit(rod, clamping):
    """Largest end error of what the user is given, by its own center line and frames."""
    r, frame = rod.centerline(5)[-1], rod.frames(5)[-1]
    if clamping.free_spin:
        frame, target = frame[:, 2], clamping.rotation[:, 2]
    else:
        target = clamping.rotation
    return max(np.abs(r - clamping.position).max(), np.abs(frame - target).max())


@pytest.mark.parametrize("free_spin", [False, True])
@pytest.mark.parametrize("torsion_ratio", [0.7, 1.0, 1.5])
def test_every_load_drawn_pose_is_solved_below_1e_9(rng, torsion_ratio, free_spin):
    positions, rotations = load_drawn(rng, 170, torsion_ratio, free_spin)
    batch = le.solve_batch(positions, rotations, torsion_ratio, free_spin)
    assert batch.converged.all()
    assert batch.residual.max() < 1e-9
    for i in range(0, 170, 10):
        clamping = le.Clamping(positions[i], rotations[i], free_spin)
        rod = le.solve(clamping, torsion_ratio, lowest=False)
        assert end_misfit(rod, clamping) < 2e-9
        # the batch may have gone another way to another rod; its loads must fit as well
        shot = le.Equilibrium(
            clamping, torsion_ratio, batch.loads[i], batch.energy[i], 0.0, Status.CONVERGED
        )
        if np.linalg.norm(batch.loads[i, :3]) < 100:
            assert end_misfit(shot, clamping) < 2e-9


def test_rows_do_not_depend_on_their_batch_or_on_threads(rng, monkeypatch):
    positions, rotations = load_drawn(rng, 40)
    whole = le.solve_batch(positions, rotations)
    parts = [le.solve_batch(positions[i::3], rotations[i::3]) for i in range(3)]
    monkeypatch.setattr(solving, "_CHUNK", 7)
    threaded = le.solve_batch(positions, rotations, threads=2)
    for i, part in enumerate(parts):
        np.testing.assert_array_equal(part.loads, whole.loads[i::3])
    np.testing.assert_array_equal(threaded.loads, whole.loads)
    np.testing.assert_array_equal(threaded.energy, whole.energy)


def test_the_lowest_of_a_batch_is_that_of_solve(rng):
    positions, rotations = pose_drawn(rng, 12, high=0.9)
    batch = le.solve_batch(positions, rotations, lowest=True)
    for i in range(12):
        rod = le.solve(le.Clamping(positions[i], rotations[i]))
        np.testing.assert_allclose(rod.loads, batch.loads[i], rtol=1e-6, atol=1e-6)


def test_the_first_solution_is_not_lower_than_the_lowest(rng):
    poses = pose_drawn(rng, 30, high=0.6)
    first, lowest = (le.solve_batch(*poses, lowest=flag) for flag in (False, True))
    assert first.converged.any()
    assert (lowest.energy <= first.energy + 1e-9).all()
    assert (lowest.energy < first.energy - 1e-3).any()


def test_free_spin_has_no_end_moment_about_the_tangent_and_costs_less(rng):
    positions, rotations = load_drawn(rng, 20)
    free = le.solve_batch(positions, rotations, free_spin=True, lowest=True)
    assert free.converged.all()
    assert (free.loads[:, 5] == 0).all()


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


def test_chain_reversal_gives_the_reversed_rod(rng):
    for position, rotation in zip(*load_drawn(rng, 10), strict=True):
        clamping = le.Clamping(position, rotation)
        forward = le.equilibria(clamping)
        backward = le.equilibria(clamping.reversed())
        # the search starts differ, so the lists may; the lowest is found from both sides
        assert forward[0].energy == pytest.approx(backward[0].energy, rel=1e-8)
        line = forward[0].centerline(9)
        # the reversed start frame is ours at the end, with d2 and d3 turned round
        ours = rotation @ np.diag([1.0, -1, -1])
        again = backward[0].centerline(9)[::-1] @ ours.T + position
        np.testing.assert_allclose(again, line, atol=1e-6)


def test_known_planar_energies_at_aligned_ends():
    # planar elasticae over a chord of 0.9: two inflections, one loop (see the docstring's bound)
    rods = le.equilibria(le.Clamping([0, 0, 0.9], np.eye(3)))
    energies = np.array([rod.energy for rod in rods])
    for known in (4.1, 16.2, 36.5):
        assert np.abs(energies - known).min() < 0.06
    # a circle of solutions is listed once: energies repeat for mirror images only
    assert np.sum(np.abs(energies - energies[0]) < 1e-6) == 1


def test_equilibria_are_sorted_distinct_and_below_the_bound(rng):
    for position, rotation in zip(*load_drawn(rng, 10), strict=True):
        rods = le.equilibria(le.Clamping(position, rotation), energy_max=60.0)
        energies = [rod.energy for rod in rods]
        assert energies == sorted(energies)
        assert all(e <= 60 for e in energies)
        assert 0 <= rods.unseen <= 1
        for i, a in enumerate(rods):
            for b in rods[:i]:
                assert np.abs(a.frames(9) - b.frames(9)).max() > 1e-5


def test_what_cannot_be_is_refused_with_the_reason():
    with pytest.raises(ValueError, match="further"):
        le.solve(le.Clamping([0, 0, 1.1], np.eye(3)))
    with pytest.raises(ValueError, match="full length"):
        le.solve(le.Clamping([0, 1, 0], np.eye(3)))
    with pytest.raises(ValueError, match="torsion_ratio"):
        le.solve(le.Clamping([0, 0, 0.5], np.eye(3)), torsion_ratio=0)
    with pytest.raises(ValueError, match="rotations"):
        le.solve_batch(np.zeros((2, 3)), np.zeros((3, 3, 3)))


def test_a_batch_reports_impossible_rows_and_solves_the_others():
    positions = np.array([[0, 0, 0.9], [0, 0, 1.1], [0, 0, np.nan], [0, 0, 1.0], [0, 0, 0.5]])
    rotations = np.array([np.eye(3)] * 5)
    rotations[4] *= 2
    batch = le.solve_batch(positions, rotations)
    assert batch.status.tolist() == [
        Status.CONVERGED,
        Status.UNREACHABLE,
        Status.BAD_INPUT,
        Status.CONVERGED,
        Status.BAD_INPUT,
    ]
    assert np.isinf(batch.energy[~batch.converged]).all()
    assert not np.isnan(batch.loads).any()


def test_the_straight_rod_carries_twist_and_no_force():
    quarter = le.Clamping.from_parameters([0, 0, 1, np.pi / 2, 0, 0])
    rod = le.solve(quarter, torsion_ratio=0.7)
    assert rod.converged
    assert rod.twist == pytest.approx(0.25)
    assert rod.energy == pytest.approx(0.5 * 0.7 * (np.pi / 2) ** 2)
    np.testing.assert_allclose(rod.loads[:3], 0)
    np.testing.assert_allclose(rod.frames(3)[-1], quarter.rotation, atol=1e-12)


def test_an_equilibrium_survives_json_and_takes_points_or_arc_lengths(rng):
    position, rotation = (a[0] for a in load_drawn(rng, 1))
    rod = le.solve(le.Clamping(position, rotation), 0.7)
    again = le.Equilibrium.from_dict(json.loads(json.dumps(rod.to_dict())))
    np.testing.assert_array_equal(again.centerline(11), rod.centerline(11))
    s = np.array([0.7, 0.1, 1.0])
    np.testing.assert_allclose(rod.centerline(s)[[1, 0, 2]], rod.centerline(np.sort(s)))
    assert rod.curvature(11).shape == (11,)
    for wrong in (0, [[0.5]], [1.5], [np.nan]):
        with pytest.raises(ValueError, match="`n`"):
            rod.centerline(wrong)


def test_physical_parameters_and_net_winding_of_a_solution(rng):
    for position, rotation in zip(*load_drawn(rng, 5, 0.7), strict=True):
        rod = le.solve(le.Clamping(position, rotation), 0.7)
        closed_form = rod.physical.clamping(0.7)
        np.testing.assert_allclose(closed_form.position, position, atol=1e-8)
        np.testing.assert_allclose(closed_form.rotation, rotation, atol=1e-8)
        # all equilibria of one clamping have net windings an integer apart
        others = le.equilibria(rod.clamping, 0.7)
        apart = np.array([r.net_winding - rod.net_winding for r in others])
        np.testing.assert_allclose(apart, np.round(apart), atol=1e-8)
        assert rod.writhe + rod.twist == pytest.approx(rod.net_winding)
    circle = le.solve(le.Clamping.from_parameters([0, 0, 1, 0.5, 0, 0]))
    assert circle.physical is None


def test_turns_select_wound_rods_and_circles_are_labelled():
    tense = le.Clamping.from_parameters([0.0, 0.0, 0.97, 0.3, 0.1, 0.2])
    for turns in (0, 2, -3):
        rods = le.equilibria(tense, turns=turns, rounds=1, energy_max=1e4)
        assert rods
        assert {rod.turns for rod in rods} == {turns}
        # under tension one of them carries the turns as twist, others as loops
        assert any(abs(rod.twist - turns) < 0.6 for rod in rods)
    assert not rods[0].family
    assert all(rod.family for rod in le.equilibria(le.Clamping([0, 0, 0.9], np.eye(3)), rounds=1))
