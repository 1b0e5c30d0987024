import numpy as np
import pytest

from loopelastica.atoms.geometry import chiral_quads
from loopelastica.atoms.minimum import right_phosphates
from loopelastica.atoms.site import site_of


@pytest.fixture(scope="module")
def site(koc, fold):
    return site_of(koc, fold, koc.positions(0))


def volume(positions, quad):
    p, o3, op1, op2 = positions[quad]
    return (o3 - p) @ np.cross(op1 - p, op2 - p)


def test_the_oxygens_of_a_phosphate_that_has_turned_over_are_put_anew(models, site):
    molecule = models[0].molecule
    own = [q for q in chiral_quads(molecule)[0] if molecule.names[q[0]] == "P"]
    quads = [q for q in own if site.moving[q[0]]]
    good = models[0].relaxed.positions_A
    positions = good.copy()
    for quad in quads[1:3]:
        positions[quad[2:]] = positions[quad[[3, 2]]]
        assert volume(positions, quad) < 0.0
    positions[quads[3][2]] = positions[quads[3][3]]
    right_phosphates(site, positions)
    for quad in quads:
        assert volume(positions, quad) > 2.0
    # and they are near to where the minimization had them
    np.testing.assert_allclose(positions, good, atol=0.35)


def test_the_last_oxygen_is_put_on_the_right_side_of_the_stems_phosphorus(models, site):
    molecule, right = models[0].molecule, models[0].positions_A
    n = len(molecule.residues)
    o3, p = molecule.index(n - 1, "O3'"), molecule.index(n, "P")
    kept, turned_over = right.copy(), right.copy()
    right_phosphates(site, kept)
    np.testing.assert_array_equal(kept[o3], right[o3])
    turned_over[o3] = 2.0 * right[p] - right[o3]
    right_phosphates(site, turned_over)
    # three oxygens do not stand evenly: half an Å, where it was three Å away
    assert np.linalg.norm(turned_over[o3] - right[o3]) < 0.6
