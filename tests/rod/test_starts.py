import math

import numpy as np
import pytest
from draws import pose_drawn

import loopelastica as le
from loopelastica.rod._arguments import check_torsion_ratio
from loopelastica.rod._starts import (
    Deadline,
    check_tolerance,
    from_loads,
    from_standard_starts,
    from_start,
    standard_starts,
    straight,
)
from loopelastica.rod.kernels.records import START, Method, Start, Status, starts_array


def test_a_deadline_passes_when_its_time_is_over(monkeypatch):
    from loopelastica.rod import _starts

    now = [100.0]
    monkeypatch.setattr(_starts.time, "monotonic", lambda: now[0])
    deadline, never = Deadline(2), Deadline(None)
    for time, passed in ((101.9, False), (102.0, True), (1e9, True)):
        now[0] = time
        assert deadline.passed is passed
        assert 0.0 < deadline.left_s <= 0.11
        assert not never.passed
        assert never.left_s is None


def test_tables_of_starts_begin_with_the_plain_one():
    plain, soft, free = (standard_starts(*a) for a in ((1.0, False), (0.09, False), (1.0, True)))
    for table in (plain, soft, free):
        assert table.dtype == START
        assert table[0].tolist() == Start()
        assert len(np.unique(table)) == len(table)
    # twist costs next to nothing: more turns
    assert set(soft["turns"]) > set(plain["turns"]) == {0.0, 1.0, -1.0}
    assert set(free["turns"]) == {0.0}
    np.testing.assert_array_equal(standard_starts(0.1, False), standard_starts(10.0, False))
    # near K30 = 1 some of the others are left out
    assert set(plain.tolist()) < set(standard_starts(0.1, False).tolist())


@pytest.mark.slow
@pytest.mark.parametrize(("torsion_ratio", "free_spin"), [(1.0, False), (1.5, False), (1.0, True)])
def test_starts_that_are_left_out_lead_to_no_lower_rod(rng, torsion_ratio, free_spin):
    from loopelastica.rod import batch

    poses = pose_drawn(rng, 300, 0.0, 0.98)
    energy = le.solve_batch(*poses, torsion_ratio, free_spin).energy
    every = np.concatenate(
        [
            standard_starts(0.05, False),
            starts_array((Start(over_0=True, over_1=True), Start(bow=1.5))),
        ]
    )
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(batch, "standard_starts", lambda *_: every)
        of_all = le.solve_batch(*poses, torsion_ratio, free_spin).energy
    np.testing.assert_allclose(energy, of_all, rtol=1e-6)


@pytest.mark.parametrize("limits", [(1e-11, 1e-3)])
def test_tolerances_and_torsion_ratios_are_checked_at_their_limits(limits):
    for value in limits:
        assert check_tolerance(value) == value
    for value in (0.99 * limits[0], 1.01 * limits[1], math.nan, math.inf):
        with pytest.raises(ValueError, match="`tolerance`"):
            check_tolerance(value)
    assert check_torsion_ratio(np.float32(0.5)) == 0.5
    for value in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(ValueError, match="`torsion_ratio`"):
            check_torsion_ratio(value)


def test_within_rounding_of_its_length_a_rod_is_straight():
    for shortening, is_straight in ((2e-9, False), (0.9e-9, True), (0.0, True), (-0.9e-9, True)):
        rod = straight(le.Clamping([0, 0, 1 - shortening], np.eye(3)), 1.0)
        assert (rod is not None) == is_straight
    for position, tilt in (([0, 0, 1 + 2e-9], 0.0), ([2e-8, 0, 1], 0.0), ([0, 0, 1], 2e-8)):
        clamping = le.Clamping.from_parameters([*position, 0.3, tilt, 0])
        with pytest.raises(ValueError, match="`clamping`"):
            straight(clamping, 1.0)


def test_a_straight_rod_takes_the_shorter_way_round():
    for spin in (3.0, -3.0):
        rod = straight(le.Clamping.from_parameters([0, 0, 1, spin, 0, 0]), 0.5)
        assert rod.loads[5] == pytest.approx(0.5 * spin)
        assert rod.energy == pytest.approx(0.25 * spin**2)
    free = straight(le.Clamping.from_parameters([0, 0, 1, 3.0, 0, 0], free_spin=True), 0.5)
    assert free.energy == free.loads[5] == 0


@pytest.mark.parametrize(("torsion_ratio", "free_spin"), [(1.0, False), (0.09, False), (1.0, True)])
def test_the_lowest_is_the_lowest_of_what_each_start_leads_to(rng, torsion_ratio, free_spin):
    for position, rotation in zip(*pose_drawn(rng, 8), strict=True):
        clamping = le.Clamping(position, rotation, free_spin)
        lowest = from_standard_starts(clamping, torsion_ratio, lowest=True)
        first = from_standard_starts(clamping, torsion_ratio)
        found = [
            from_start(clamping, torsion_ratio, Start(*row.tolist()))
            for row in standard_starts(torsion_ratio, free_spin)
        ]
        energies = [rod.energy for rod in found if rod.converged]
        assert lowest.energy == pytest.approx(min(energies), rel=1e-6)
        assert first.energy >= lowest.energy - 1e-9 * (1 + lowest.energy)
        assert max(rod.residual for rod in found if rod.converged) < 1e-9


def test_loads_lead_to_a_rod_of_loads_alone_or_to_a_status():
    clamping = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
    known = le.solve(clamping)
    rod = from_loads(clamping, 1.0, known.loads + 0.1, 20)
    assert rod.method == Method.SHOOTING
    assert rod.energy == pytest.approx(known.energy)
    for loads, patience in ((np.array([0, 0, 1e5, 0, 0, 0.0]), 20), (np.zeros(6), 1)):
        failed = from_loads(clamping, 1.0, loads, patience)
        assert (failed.status, failed.method) == (Status.STALLED, Method.NONE)
        assert failed.energy == failed.residual == np.inf


def test_layered_methods_keep_their_layers(rng):
    for position, rotation in zip(*pose_drawn(rng, 10, 0.99, 0.9999), strict=True):
        rod = le.solve(le.Clamping(position, rotation))
        layered = rod.method in (Method.BOUNDARY_LAYERS, Method.DISCRETE_ROD_LAYERS)
        assert len(rod.layers) == (layered and len(rod.node_s) == 1)
