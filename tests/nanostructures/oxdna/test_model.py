import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from loopelastica.nanostructures.oxdna.model import (
    BOND_LONGEST,
    BOND_SHORTEST,
    HELIX_RISE,
    HELIX_TWIST,
    UNIT_NM,
    backbone_sites,
    base_sites,
    centre_of,
    duplex,
    stack_sites,
)


@pytest.fixture
def frames(rng):
    """Centres and two axes of seven nucleotides anywhere."""
    turn = Rotation.random(7, rng=rng).as_matrix()
    return rng.normal(size=(7, 3)), turn[:, :, 0], turn[:, :, 2]


def test_bonds_may_be_as_long_as_the_program_lets_them():
    np.testing.assert_allclose([BOND_SHORTEST, BOND_LONGEST], [0.5064, 1.0064])


def test_a_centre_follows_from_its_backbone_site(frames):
    centre, a1, a3 = frames
    np.testing.assert_allclose(centre_of(backbone_sites(centre, a1, a3), a1, a3), centre)


def test_the_backbone_site_is_off_the_line_of_the_bases(frames):
    centre, a1, a3 = frames
    site = backbone_sites(centre, a1, a3) - centre
    for axis, distance in ((a1, -0.34), (np.cross(a3, a1), 0.3408), (a3, 0.0)):
        np.testing.assert_allclose(np.einsum("ij,ij->i", site, axis), distance, atol=1e-12)


def test_base_and_stacking_sites_are_on_the_first_axis(frames):
    centre, a1, _ = frames
    np.testing.assert_allclose(base_sites(centre, a1), centre + 0.4 * a1)
    np.testing.assert_allclose(stack_sites(centre, a1), centre + 0.34 * a1)


def test_all_bonds_of_a_duplex_are_in_the_window():
    centre, a1, a3 = duplex(30)
    bonds = np.linalg.norm(np.diff(backbone_sites(centre, a1, a3), axis=1), axis=-1)
    assert bonds.min() > BOND_SHORTEST
    assert bonds.max() < BOND_LONGEST
    assert np.ptp(bonds) < 1e-12


def test_bases_of_a_pair_face_each_other():
    centre, a1, _ = duplex(12)
    across = base_sites(centre, a1)[1] - base_sites(centre, a1)[0]
    np.testing.assert_allclose(across, 0.4 * a1[0], atol=1e-12)
    np.testing.assert_allclose(a1[0], -a1[1])


def test_a_duplex_is_right_handed():
    centre, _, _ = duplex(2)
    a, b = centre[0]
    assert np.cross(a, b)[2] * (b - a)[2] > 0


def test_third_axes_point_from_3_to_5():
    centre, _, a3 = duplex(5)
    upwards, downwards = np.diff(centre, axis=1)[:, :, 2]
    # the first strand runs up from 5' to 3', the second one down
    assert (upwards > 0).all()
    assert (downwards > 0).all()
    np.testing.assert_allclose(a3[0], np.tile([0, 0, -1], (5, 1)))
    np.testing.assert_allclose(a3[1], np.tile([0, 0, 1], (5, 1)))


def test_one_groove_is_wider_than_the_other():
    centre, a1, a3 = duplex(40)
    here, there = backbone_sites(centre, a1, a3)
    # from a backbone in the middle to the other strand, above and below
    apart = np.linalg.norm(there - here[20], axis=1)
    above, below = apart[22:].min(), apart[:19].min()
    assert abs(above - below) > 0.3


def test_a_turn_of_the_duplex_is_that_of_dna():
    assert 2 * np.pi / HELIX_TWIST == pytest.approx(10.03, abs=0.01)
    assert pytest.approx(0.332, abs=1e-3) == HELIX_RISE * UNIT_NM
