import numpy as np
import pytest

from loopelastica.atoms.measures import torsion_deg
from loopelastica.atoms.suites import (
    CLUSTERS,
    HALF_WIDTHS_DEG,
    MEANS_DEG,
    TORSIONS,
    distances,
    nearest,
    suite_name,
    suite_torsions,
)


@pytest.mark.parametrize("name", CLUSTERS)
def test_the_mean_of_each_cluster_has_its_name(name):
    assert suite_name(CLUSTERS[name]) == name
    assert suite_name(np.array(CLUSTERS[name]) - 360.0) == name


def test_there_are_the_54_clusters_of_the_consensus_in_four_classes_of_puckers():
    assert len(CLUSTERS) == 54
    first, last = MEANS_DEG[:, 0] > 105, MEANS_DEG[:, 6] > 105
    counts = [int(((first == a) & (last == b)).sum()) for a in (False, True) for b in (False, True)]
    assert counts == [17, 12, 16, 9]


def test_a_suite_leaves_its_cluster_at_the_half_width():
    a = np.array(CLUSTERS["1a"])
    for place in (1, 2, 3, 4):
        for share, inside in ((0.9, True), (1.6, False)):
            moved = a.copy()
            moved[place] -= share * HALF_WIDTHS_DEG[place]
            away = distances(moved)[list(CLUSTERS).index("1a")]
            assert away == pytest.approx(share)
            assert (suite_name(moved) is not None) >= inside


@pytest.mark.parametrize(
    ("place", "degrees"), [(0, 115.0), (1, 60.0), (2, 0.0), (3, 0.0), (4, 10.0), (5, 120.0)]
)
def test_a_torsion_where_none_is_found_is_in_no_cluster(place, degrees):
    torsions = np.array(CLUSTERS["1a"])
    torsions[place] = degrees
    assert suite_name(torsions) is None


def test_the_nearest_cluster_has_the_puckers_of_the_suite():
    """C3'-endo with γ − has no cluster: one of other γ is nearest, not one of another pucker."""
    torsions = np.array([84.0, 217.0, 287.0, 297.0, 225.0, 294.0, 84.0])
    names = list(CLUSTERS)
    first = nearest(torsions)
    assert max(abs(MEANS_DEG[first][[0, 6]] - 84.0)) < 10.0
    torsions[6] = 150.7
    assert names[nearest(torsions)] == "1o"
    assert names[nearest(torsions, [names.index("1o")])] != "1o"


def test_torsions_are_those_of_the_seven_bonds(rng):
    positions = rng.normal(size=(14, 3))
    atoms = sorted({atom for quad in TORSIONS for atom in quad})
    rows = {atom: row for row, atom in enumerate(atoms)}
    quads = np.array([[[rows[atom] for atom in quad] for quad in TORSIONS]])
    found = suite_torsions(positions, quads)
    expected = [torsion_deg(*positions[quad]) % 360.0 for quad in quads[0]]
    np.testing.assert_allclose(found, [expected])
    assert suite_torsions(positions, quads[:0]).shape == (0, 7)
