import json
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.studies.bench.judge import independent
from loopelastica.studies.completeness import search as of
from loopelastica.studies.completeness.compare import as_equilibrium

SPAN = 8.0 * math.pi**2
FIG_6 = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])


def energies(rods):
    return [rod.energy for rod in rods]


@pytest.fixture(scope="module")
def ring():
    closed = le.Clamping(np.zeros(3), np.eye(3))
    return of.search(closed, 1.0, 400, np.random.default_rng(1), 60.0)


def test_the_closed_ring_has_circles_and_the_figure_eight_once_each(ring):
    # once around, once around with a turn of torsion either way, figure eight, twice around
    once = 2.0 * math.pi**2
    np.testing.assert_allclose(
        energies(ring), [once, 2 * once, 2 * once, 56.219805, 4 * once], rtol=1e-7
    )
    assert sum(rod.hits for rod in ring) > 50


def test_rods_are_those_of_the_paper():
    rods = of.search(FIG_6, 1.0, 300, np.random.default_rng(6), 20.0)
    # the doctest of `equilibria` has the same
    np.testing.assert_allclose(energies(rods), [7.0579, 19.1464, 23.2724], atol=5e-5)
    assert all(rod.residual < 1e-9 for rod in rods)


@pytest.mark.parametrize(("torsion_ratio", "free"), [(1.0, False), (1.0, True), (0.2, False)])
def test_rods_hold_by_another_integrator(torsion_ratio, free):
    clamping = le.Clamping([0.2, -0.3, 0.1], ROTATION, free)
    rods = of.search(clamping, torsion_ratio, 200, np.random.default_rng(2), 20.0)
    assert rods
    for rod in rods:
        its = as_equilibrium(rod, clamping, torsion_ratio)
        end, frame = its.centerline(2)[1], its.frames(2)[1]
        np.testing.assert_allclose(end, clamping.position, atol=1e-6)
        if free:
            assert abs(rod.loads[5]) < 1e-9
            np.testing.assert_allclose(frame[:, 2], clamping.rotation[:, 2], atol=1e-6)
        else:
            np.testing.assert_allclose(frame, clamping.rotation, atol=1e-6)
            assert independent(its)[1] < 1e-6


ROTATION = Rotation.from_rotvec([1.2, 0.3, -0.8]).as_matrix()


def test_tense_rods_are_pulled_from_loose_ones():
    clamping = le.Clamping(0.94 * np.array([0.6, 0.0, 0.8]), ROTATION)
    rods = of.search(clamping, 1.0, 150, np.random.default_rng(3), SPAN)
    assert rods[0].energy == pytest.approx(le.solve(clamping).energy, rel=1e-7)
    # hits of the loose rods are kept
    assert sum(energies(rods) == rod.energy for rod in rods) <= len(rods)
    assert rods[0].hits > 1


def test_no_hit_is_counted_twice():
    clamping = le.Clamping([0.1, 0.2, 0.1], ROTATION)
    rods = of.search(clamping, 1.0, 120, np.random.default_rng(4), SPAN)
    assert 0 < sum(rod.hits for rod in rods) <= 120
    for i, a in enumerate(rods):
        assert not any(of.same(a.energy, a.mark, b.energy, b.mark) for b in rods[:i])


def test_rods_of_a_circle_of_solutions_are_one():
    clamping = le.Clamping([0.0, 0.0, 0.6], np.eye(3))
    rods = of.search(clamping, 1.0, 200, np.random.default_rng(5), 30.0)
    arch = le.solve(clamping)
    same = [rod for rod in rods if abs(rod.energy - arch.energy) < 1e-6]
    assert len(same) == 1
    assert same[0].hits > 1


def test_where_nothing_arrives_there_are_no_rods():
    clamping = le.Clamping([0.0, 0.0, 0.5], ROTATION)
    assert of.search(clamping, 1.0, 0, np.random.default_rng(0), SPAN) == []


@pytest.mark.slow
def test_stored_poses_have_the_energies_listed_for_them(rod_folder):
    cases = json.loads((rod_folder / "equilibria.json").read_text(encoding="utf-8"))
    total = there = 0
    for number, case in enumerate(cases):
        clamping = le.Clamping(case["position"], case["rotation"])
        rng = np.random.default_rng([7, number])
        found = energies(of.search(clamping, case["torsion_ratio"], 400, rng, SPAN))
        assert found, case["position"]
        listed = [e for e in case["energies"] if e < case["energies"][0] + SPAN]
        hit = [any(abs(e - f) < 1e-6 * (1.0 + e) for f in found) for e in listed]
        assert hit[0], f"not the lowest rod at {case['position']}"
        total, there = total + len(hit), there + sum(hit)
    assert there >= 0.95 * total
