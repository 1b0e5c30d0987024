import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import loopelastica as le
from loopelastica.rod.stability import assess
from loopelastica.studies.completeness.compare import matches
from loopelastica.studies.completeness.morse import index
from loopelastica.studies.completeness.search import search


@pytest.mark.parametrize("free", [False, True])
@pytest.mark.parametrize(
    ("load", "modes"),
    [(0.0, 0), (39.0, 0), (40.0, 1), (80.0, 1), (81.0, 2), (157.0, 2), (159.0, 3)],
)
def test_euler_column_clamped_at_both_ends(load, modes, free):
    # buckles at 4π², 8.18π², 16π² in each of two planes
    column = np.array([0.0, 0.0, -load, 0.0, 0.0, 0.0])
    assert index(column, 1.0, free) == 2 * modes


@pytest.mark.parametrize("torsion_ratio", [0.3, 1.0, 2.0])
@pytest.mark.parametrize(("share", "holds"), [(0.98, True), (1.02, False)])
def test_twisted_ring_snaps_at_root_three_over_k(torsion_ratio, share, holds):
    # Michell 1889: the ring is left at √3/K30 turns of torsion, M3 = K30 · 2π · turns
    curvature = math.tau
    torsion = share * math.sqrt(3.0) * math.tau
    ring = np.array([0.0, torsion * curvature, 0.0, 0.0, curvature, torsion])
    assert (index(ring, torsion_ratio, False) == 0) == holds


def test_level_ways_of_a_family_lead_nowhere():
    # a ring turns about its tangent and along itself; a figure eight too, over saddles of its own
    circle = np.array([0.0, 0.0, 0.0, 0.0, math.tau, 0.0])
    assert index(circle, 1.0, False) == 0
    assert index(2.0 * circle, 1.0, False) > 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("torsion_ratio", "free"), [(1.0, False), (1.0, True), (0.1, False), (10.0, False)]
)
def test_it_is_the_index_counted_from_conjugate_points(torsion_ratio, free):
    rng, compared = np.random.default_rng(8), 0
    for rotation in Rotation.random(4, random_state=rng):
        clamping = le.Clamping(rng.uniform(-0.4, 0.4, 3), rotation.as_matrix(), free)
        rods = search(clamping, torsion_ratio, 150, rng, 80.0)
        found = [assess(rod) for rod in le.equilibria(clamping, torsion_ratio)]
        for i, j in np.argwhere(matches(rods, found, clamping)):
            assert index(rods[i].middle, torsion_ratio, free) == found[j].index
            compared += 1
    assert compared >= 10
