import numpy as np
import pytest

from loopelastica.atoms.fibre import fibre_nucleotide
from loopelastica.atoms.measures import angles_deg, pseudorotation, pucker_name

RING = ("C1'", "C2'", "C3'", "C4'", "O4'")


@pytest.mark.parametrize(("is_dna", "name"), [(False, "C3'-endo"), (True, "C3'-exo")])
def test_the_fibre_sugars_have_their_known_puckers(is_dna, name):
    # A-RNA is C3'-endo; the B-DNA of 1972 lies at 192°, just beyond C2'-endo
    atoms = fibre_nucleotide("A", is_dna)
    phase, amplitude = pseudorotation(*(atoms[a] for a in RING))
    assert pucker_name(phase) == name
    assert 34.0 < amplitude < 40.0


def test_pseudorotation_of_a_mirror_image_is_half_a_turn_away():
    ring = [fibre_nucleotide("A", False)[a] for a in RING]
    phase, amplitude = pseudorotation(*ring)
    mirrored, same = pseudorotation(*(point * [1, 1, -1] for point in ring))
    assert (mirrored - phase) % 360.0 == pytest.approx(180.0)
    assert same == pytest.approx(amplitude)


def test_a_right_angle_and_a_straight_one():
    points = np.array([[1.0, 0, 0], [0, 0, 0], [0, 2.0, 0], [-3.0, 0, 0]])
    found = angles_deg(points, np.array([[0, 1, 2], [0, 1, 3]]))
    np.testing.assert_allclose(found, [90.0, 180.0])
