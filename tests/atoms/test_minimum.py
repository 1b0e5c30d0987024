import numpy as np
import pytest

from loopelastica.atoms.geometry import chiral_quads
from loopelastica.atoms.minimum import minimum, right_phosphates
from loopelastica.atoms.restraints import Problem
from loopelastica.atoms.site import site_of
from loopelastica.molecule.nucleotides import BACKBONE


@pytest.fixture(scope="module")
def site(koc, fold):
    return site_of(koc, fold, koc.positions(0), fold.candidates[0].line)


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


def test_the_last_oxygen_is_held_where_the_stems_phosphate_wants_it(models, site):
    molecule = models[0].molecule
    problem = Problem.at(site)
    ((row, place),) = problem.pinned.items()
    o3 = molecule.index(molecule.n - 1, "O3'")
    assert problem.order[row] == o3
    # three oxygens do not stand evenly: some tenths of an Å
    assert np.linalg.norm(place - models[0].relaxed.positions_A[o3]) < 0.4


def test_the_last_oxygen_comes_to_the_right_side_of_the_stems_phosphorus(models, site):
    """From a start on the wrong one, where the stem's oxygens stand between the two."""
    molecule = models[0].molecule
    o3, p = molecule.index(molecule.n - 1, "O3'"), molecule.index(molecule.n, "P")
    right = np.array(models[0].relaxed.positions_A)
    start = right.copy()
    start[o3] = 2.0 * right[p] - right[o3]
    backbone = [[molecule.index(k, name) for name in BACKBONE] for k in range(molecule.n)]
    centers = right[np.array(backbone)].mean(axis=1)
    found = minimum(Problem.at(site), centers, 0.3, start, (), 5000, 30.0)
    assert np.linalg.norm(found.positions_A[o3] - right[o3]) < 0.6
