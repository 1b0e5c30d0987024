import numpy as np

from loopelastica.atoms.geometry import chiral_quads
from loopelastica.atoms.minimum import _right_phosphates


def volume(positions, quad):
    p, o3, op1, op2 = positions[quad]
    return (o3 - p) @ np.cross(op1 - p, op2 - p)


def test_the_oxygens_of_a_phosphate_that_has_turned_over_are_put_anew(models):
    molecule = models[0].molecule
    quads = [q for q in chiral_quads(molecule)[0] if molecule.names[q[0]] == "P"]
    good = models[0].relaxed.positions_A
    positions = good.copy()
    for quad in quads[1:3]:
        positions[quad[2:]] = positions[quad[[3, 2]]]
        assert volume(positions, quad) < 0.0
    positions[quads[3][2]] = positions[quads[3][3]]
    _right_phosphates(molecule, positions)
    for quad in quads:
        assert volume(positions, quad) > 2.0
    # and they are near to where the minimization had them
    np.testing.assert_allclose(positions, good, atol=0.35)


def test_the_last_oxygen_is_put_on_the_right_side_of_the_stems_phosphorus(models):
    molecule, right = models[0].molecule, models[0].positions_A
    n = len(molecule.residues)
    o3, p = molecule.index(n - 1, "O3'"), molecule.index(n, "P")
    kept, turned_over = right.copy(), right.copy()
    _right_phosphates(molecule, kept)
    np.testing.assert_array_equal(kept[o3], right[o3])
    turned_over[o3] = 2.0 * right[p] - right[o3]
    _right_phosphates(molecule, turned_over)
    # three oxygens do not stand evenly: half an Å, where it was three Å away
    assert np.linalg.norm(turned_over[o3] - right[o3]) < 0.6
