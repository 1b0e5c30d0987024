"""The paper's grid of guesses, and its tested rods."""

import math

import numpy as np
import pytest

from loopelastica.rod.clamping import Clamping
from loopelastica.rod.paper import grid as module
from loopelastica.rod.paper.grid import build, grid, spacing, trial_points
from loopelastica.rod.parameters import PhysicalParameters, a_min

# the printed method is compiled for its tests alone
pytestmark = pytest.mark.slow


@pytest.mark.parametrize("symmetry", [True, False])
def test_points_fill_the_region_of_equation_40(symmetry):
    size, step = 1.5, 0.5
    found = build(size, step, symmetry)
    p = found.points
    lam, t_p = (p[:, 0], p[:, 1])
    if symmetry:
        # a mirrored guess has λ and t_P of the opposite sign
        flipped = t_p < 0
        lam, t_p = np.where(flipped, -lam, lam), np.abs(t_p)
        assert set(np.unique(t_p).round(9)) == {1e-3, 0.5, 1.0, 1.5}
    else:
        assert set(np.unique(t_p).round(9)) == {-1.5, -1.0, -0.5, 1e-3, 0.5, 1.0, 1.5}
    assert set(np.unique(lam).round(9)) == set(np.arange(-1.5, 1.6, 0.5))
    assert not (p[:, 1] == 0).any()
    assert p[:, 2].max() <= size**2
    assert p[:, 3].min() == 0
    assert p[:, 4].min() == pytest.approx(0.1)
    for row in p[:: len(p) // 50]:
        rod = PhysicalParameters(row[0], row[1], row[2], 0.0, row[3], row[4])
        # t_P = 1e-3 has the bounds of t_P = 0
        slack = 0.1 if abs(row[1]) == 1e-3 else 1e-9
        assert row[3] <= 0.95 * rod.period + slack
        assert row[4] <= rod.period + slack
        low = a_min(row[0], 0.0 if abs(row[1]) == 1e-3 else row[1])
        rung = (row[2] - low) / step
        assert abs(rung - round(rung)) * step < 3e-3


def test_images_are_those_of_the_closed_form():
    found = build(1.5, 0.75, True, torsion_ratio=0.7)
    seen = 0
    for p, (eta1, eta3, psi, theta, phi) in zip(found.points, found.images, strict=True):
        # by the public classes: another way than the kernels
        rod = PhysicalParameters(p[0], p[1], p[2], 0.0, p[3], p[4])
        expected = rod.clamping(0.7).reduced()[0]
        assert [eta1, 0, eta3] == pytest.approx(expected.position, abs=1e-9)
        if eta1 < 1e-6:  # a straight rod: nothing tells where η1 ≥ 0 is
            continue
        seen += 1
        image = Clamping.from_parameters([eta1, 0, eta3, psi, theta, phi])
        assert image.rotation == pytest.approx(expected.rotation, abs=1e-7)
    assert seen > 0.9 * len(found)


def test_symmetry_keeps_phi_below_pi_and_half_of_the_rods():
    half, whole = build(1.5, 0.5, True), build(1.5, 0.5, False)
    assert (half.images[:, 4] <= math.pi).all()
    assert (whole.images[:, 4] > math.pi).any()
    # whole = both signs of t_P, but t_P = 0 once
    middle = int((np.abs(half.points[:, 1]) == 1e-3).sum())
    assert len(whole) == 2 * len(half) - middle


def test_nearest_is_the_least_plain_difference(rng):
    found = build(1.5, 0.5)
    for _ in range(20):
        q = rng.uniform([0, -1, 0, 0, 0], [1, 1, math.tau, math.pi, math.pi])
        distance = np.linalg.norm(found.images - q, axis=1)
        ranks = found.nearest(q, 7)
        assert distance[ranks] == pytest.approx(np.sort(distance)[:7], abs=0)
        assert found.nearest(q)[0] == np.argmin(distance)
        from loopelastica.rod.paper.path import nearest

        assert nearest(found.images, q) == np.argmin(distance)
    with pytest.raises(ValueError, match="`q`"):
        found.nearest([0.0, 1.0])
    with pytest.raises(ValueError, match="`count`"):
        found.nearest(np.zeros(5), 0)


def test_tested_rods_count_as_in_the_reading_of_the_text():
    assert spacing(2, 0.5) == pytest.approx(1.4)
    counts = {
        (step, half): len(trial_points(2, step, spacing(2, step) * half))
        for step, half in ((2, 1), (1, 1), (0.5, 0.5), (0.25, 0.5))
    }
    assert counts == {(2, 1): 4188, (1, 1): 2712, (0.5, 0.5): 57740, (0.25, 0.5): 53864}


def test_tested_rods_lie_inside_and_off_the_guesses():
    rods = trial_points(2, 1, spacing(2, 1))
    assert np.abs(rods[:, :2]).max() == pytest.approx(1.5)
    assert not (np.abs(rods[:, :2]).max(axis=1) < 1e-9).any()
    assert len(np.unique(rods[:, 0].round(9))) == 2 * 2 + 2  # 2 l + 1 intervals
    for row in rods[::150]:
        rod = PhysicalParameters(row[0], row[1], row[2], 0.0, row[3], row[4])
        assert np.linalg.norm(rod.centerline(2)[1]) < 0.95
        assert row[2] >= a_min(row[0], row[1]) + 0.5 - 1e-9
        assert 0.5 <= row[3] <= 0.95 * rod.period - 0.5 + 1e-9
        assert 0.6 <= row[4] <= rod.period - 0.5 + 1e-9
    assert module.singular_share(rods) == pytest.approx(0.5022, abs=1e-4)


@pytest.mark.parametrize("name", ["size", "step", "torsion_ratio"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.inf, math.nan])
def test_a_bad_number_is_named(name, value):
    numbers = {"size": 1.0, "step": 1.0, "torsion_ratio": 1.0, name: value}
    with pytest.raises(ValueError, match=f"`{name}`"):
        build(**numbers)


def test_workers_change_nothing():
    one, many = build(1.0, 0.5, workers=1), build(1.0, 0.5, workers=3)
    assert np.array_equal(one.points, many.points)
    assert np.array_equal(one.images, many.images)


def test_a_grid_is_computed_once():
    assert grid(1.0, 0.5) is grid(1.0, 0.5)
    assert np.array_equal(grid(1.0, 0.5).images, build(1.0, 0.5).images)
    assert not grid(1.0, 0.5).points.flags.writeable
