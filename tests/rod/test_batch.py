import inspect

import numpy as np
import pytest
from draws import load_drawn, pose_drawn

import loopelastica as le
import loopelastica.rod.batch as batches
from loopelastica.rod.kernels.records import Method, Status


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
    batch = le.solve_batch(positions, rotations, torsion_ratio, free_spin, lowest=False)
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


@pytest.mark.parametrize("lowest", [False, True])
def test_rows_do_not_depend_on_their_batch_or_on_threads(rng, monkeypatch, lowest):
    positions, rotations = load_drawn(rng, 40)
    whole = le.solve_batch(positions, rotations, lowest=lowest)
    parts = [le.solve_batch(positions[i::3], rotations[i::3], lowest=lowest) for i in range(3)]
    monkeypatch.setattr(batches, "_CHUNK", 7)
    threaded = le.solve_batch(positions, rotations, lowest=lowest, threads=2)
    for i, part in enumerate(parts):
        np.testing.assert_array_equal(part.loads, whole.loads[i::3])
        np.testing.assert_array_equal(part.by_loads, whole.by_loads[i::3])
    for name in ("loads", "energy", "residual", "method", "by_loads"):
        np.testing.assert_array_equal(getattr(threaded, name), getattr(whole, name))
    for i in range(0, 40, 9):
        np.testing.assert_array_equal(threaded[i].poses(5), whole[i].poses(5))


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


SHELLS = [(0, 0.5), (0.5, 0.95), (0.95, 0.99), (0.99, 0.999), (0.999, 0.9999)]


def poses_of_every_kind(rng, n):
    """``n`` poses of each shell, to |η| = 0.9999."""
    drawn = [pose_drawn(rng, n, low, high) for low, high in SHELLS]
    return tuple(np.concatenate(parts) for parts in zip(*drawn, strict=True))


def assert_rows_give_back_what_they_say(batch):
    assert batch.converged.all()
    for i, rod in enumerate(batch):
        miss = np.abs(rod.centerline(2)[-1] - batch.positions[i]).max()
        assert miss <= batch.residual[i] + 1e-11, (i, rod.method)
        assert end_misfit(rod, rod.clamping) < 2e-9


def test_a_row_ends_at_its_clamping_within_its_residual(rng):
    batch = le.solve_batch(*poses_of_every_kind(rng, 4))
    assert_rows_give_back_what_they_say(batch)
    # every way of keeping a rod is among them
    assert batch.by_loads.any()
    assert any(len(rod.layers) for rod in batch)
    assert any(len(rod.node_s) > 1 for rod in batch)


@pytest.mark.parametrize("lowest", [False, True])
@pytest.mark.parametrize(("torsion_ratio", "free_spin"), [(1.0, False), (0.6, False), (1.0, True)])
def test_hundreds_of_rows_end_at_their_clampings_within_their_residuals(
    rng, torsion_ratio, free_spin, lowest
):
    poses = poses_of_every_kind(rng, 60)
    assert_rows_give_back_what_they_say(le.solve_batch(*poses, torsion_ratio, free_spin, lowest))


def test_rows_by_loads_need_nothing_but_their_loads(rng):
    batch = le.solve_batch(*poses_of_every_kind(rng, 6))
    for i in np.flatnonzero(batch.by_loads):
        rod = le.Equilibrium(
            batch[int(i)].clamping, 1.0, batch.loads[i], batch.energy[i], 0.0, Status.CONVERGED
        )
        assert end_misfit(rod, rod.clamping) < 2e-9
    tense = np.linalg.norm(batch.loads[:, :3], axis=1) > 80**2
    assert tense.any()
    assert not batch.by_loads[tense].any()


def test_solve_and_its_batch_have_the_same_defaults(rng):
    one, many = (inspect.signature(f).parameters for f in (le.solve, le.solve_batch))
    for name in ("torsion_ratio", "lowest", "tolerance", "time_limit_s"):
        assert one[name].default == many[name].default
    positions, rotations = pose_drawn(rng, 12, high=0.6)
    plain = le.solve_batch(positions, rotations)
    np.testing.assert_array_equal(
        plain.energy, le.solve_batch(positions, rotations, lowest=True).energy
    )
    for i, rod in enumerate(plain):
        assert rod.energy == pytest.approx(
            le.solve(le.Clamping(positions[i], rotations[i])).energy, rel=1e-8
        )


@pytest.mark.parametrize("lowest", [False, True])
def test_a_torsion_ratio_for_each_row_is_a_batch_for_each_ratio(rng, lowest):
    positions, rotations = poses_of_every_kind(rng, 4)
    ratios = np.array([0.6, 1.0, 1.7])[rng.integers(0, 3, len(positions))]
    mixed = le.solve_batch(positions, rotations, ratios, lowest=lowest)
    np.testing.assert_array_equal(mixed.torsion_ratio, ratios)
    for ratio in np.unique(ratios):
        rows = np.flatnonzero(ratios == ratio)
        alone = le.solve_batch(positions[rows], rotations[rows], ratio, lowest=lowest)
        for name in ("loads", "energy", "residual", "status", "method", "by_loads"):
            np.testing.assert_array_equal(getattr(mixed, name)[rows], getattr(alone, name))
        for k, i in enumerate(rows):
            assert mixed[int(i)].torsion_ratio == ratio
            np.testing.assert_array_equal(mixed[int(i)].poses(3), alone[k].poses(3))


def test_a_batch_is_a_sequence_of_equilibria(rng):
    batch = le.solve_batch(*pose_drawn(rng, 5))
    assert len(batch) == len(list(batch)) == 5
    assert all(isinstance(rod, le.Equilibrium) for rod in batch)
    np.testing.assert_array_equal(batch[-1].loads, batch.loads[4])
    np.testing.assert_array_equal(batch[np.int64(2)].loads, batch.loads[2])
    np.testing.assert_array_equal([rod.energy for rod in batch[3:0:-2]], batch.energy[3:0:-2])
    assert batch[5:] == []
    for beyond in (5, -6):
        with pytest.raises(IndexError):
            batch[beyond]
    assert repr(batch) == "<Batch: 5 of 5 clampings solved>"
    for name in ("positions", "rotations", "torsion_ratio", "loads", "energy", "status", "method"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(batch, name)[0] = 0
    positions, rotations = np.zeros((0, 3)), np.zeros((0, 3, 3))
    assert list(le.solve_batch(positions, rotations)) == []


def test_failed_rows_are_equilibria_that_did_not_converge_unless_they_are_no_clamping():
    positions = np.array([[0, 0, 0.9], [0, 0, 1.1], [0, 0, np.nan], [0, 0, 1.0]])
    batch = le.solve_batch(positions, np.array([np.eye(3)] * 4))
    assert repr(batch) == "<Batch: 2 of 4 clampings solved>"
    unreachable = batch[1]
    assert not unreachable.converged
    assert unreachable.status == Status.UNREACHABLE
    assert unreachable.energy == unreachable.residual == np.inf
    assert "further apart" in unreachable.message
    with pytest.raises(ValueError, match="row 2"):
        batch[2]
    with pytest.raises(ValueError, match="row 2"):
        batch[-2]
    assert batch[3].method == Method.STRAIGHT
    for name in ("loads", "energy", "residual"):
        assert not np.isnan(getattr(batch, name)).any()


def test_a_time_limit_marks_the_rows_that_are_left(rng, monkeypatch):
    class Late:
        """Passed when it has been asked twice."""

        def __init__(self, limit_s):
            self.looks = 0

        @property
        def passed(self):
            self.looks += 1
            return self.looks > 2

    positions, rotations = pose_drawn(rng, 12, high=0.8)
    whole = le.solve_batch(positions, rotations)
    monkeypatch.setattr(batches, "Deadline", Late)
    monkeypatch.setattr(batches, "_CHUNK", 4)
    batch = le.solve_batch(positions, rotations, time_limit_s=1.0)
    # the first row alone, then four at a time
    assert batch.status.tolist() == [Status.CONVERGED] * 5 + [Status.OUT_OF_TIME] * 7
    np.testing.assert_array_equal(batch.loads[:5], whole.loads[:5])
    assert np.isinf(batch.energy[5:]).all()
    assert "time limit" in batch[7].message


def test_impossible_arguments_of_a_batch_are_named():
    poses = np.zeros((2, 3)), np.array([np.eye(3)] * 2)
    for named, wrong in (
        ("tolerance", 1e-12),
        ("tolerance", 0.1),
        ("time_limit_s", 0.0),
        ("time_limit_s", "soon"),
        ("threads", 0),
        ("threads", 1.5),
        ("torsion_ratio", [1.0, 2.0, 3.0]),
        ("torsion_ratio", [1.0, -1.0]),
        ("torsion_ratio", np.nan),
    ):
        with pytest.raises(ValueError, match=f"`{named}`"):
            le.solve_batch(*poses, **{named: wrong})
    with pytest.raises(ValueError, match="`positions`"):
        le.solve_batch(np.zeros(3), np.eye(3))


def test_free_spin_may_be_a_number_and_compiles_nothing_new(rng):
    def signatures():
        from loopelastica.rod import kernels

        modules = [m for m in vars(kernels).values() if inspect.ismodule(m)]
        found = [value for m in modules for value in vars(m).values()]
        return sum(len(v.signatures) for v in found if hasattr(v, "signatures"))

    positions, rotations = pose_drawn(rng, 3)
    for flag in (False, True):
        plain = le.solve_batch(positions, rotations, free_spin=flag)
        rod = le.solve(le.Clamping(positions[0], rotations[0], flag))
        before = signatures()
        assert before > 0
        for number in (int(flag), np.bool_(flag), np.int64(flag)):
            batch = le.solve_batch(positions, rotations, free_spin=number, lowest=np.bool_(True))
            assert batch.free_spin is flag
            np.testing.assert_array_equal(batch.loads, plain.loads)
            again = le.solve(le.Clamping(positions[0], rotations[0], number))
            np.testing.assert_array_equal(again.loads, rod.loads)
        assert signatures() == before


def test_a_looser_tolerance_is_met_and_a_tighter_one_too(rng):
    poses = pose_drawn(rng, 12, 0.9, 0.999)
    for tolerance in (1e-10, 1e-5):
        batch = le.solve_batch(*poses, tolerance=tolerance)
        assert (batch.residual[batch.converged] < tolerance).all()
        assert batch.converged.mean() > 0.9


def test_frames_that_are_rotations_nearly_are_those_of_a_clamping(rng):
    positions, rotations = pose_drawn(rng, 8)
    rounded = rotations.round(5)
    batch = le.solve_batch(positions, rounded)
    assert batch.converged.all()
    for i, rod in enumerate(batch):
        assert end_misfit(rod, le.Clamping(positions[i], rounded[i])) < 2e-9
    # what a clamping refuses is no row either
    for wrong in (1 + 2e-4, -1):
        bad = le.solve_batch(positions, wrong * rotations)
        assert (bad.status == Status.BAD_INPUT).all()
        with pytest.raises(ValueError, match="`rotation`"):
            le.Clamping(positions[0], wrong * rotations[0])
