"""Where atoms start that a template gives, and those that it does not."""

import numpy as np
import pytest

from loopelastica.atoms.carry import curve_on
from loopelastica.atoms.site import site_of
from loopelastica.atoms.start import start_on
from loopelastica.atoms.turn import Turns
from loopelastica.molecule.strands import ideal_strand
from loopelastica.molecule.templates import monomer_of


@pytest.fixture
def scene(koc, fold):
    line = fold.candidates[0].line
    site = site_of(koc, fold, koc.positions(0), line)
    return site, curve_on(line, ideal_strand(False)), Turns((0.0,) * 4, (0.0,) * 4, 0.0)


def test_given_atoms_start_where_they_are_given_and_the_rest_is_laid_on_them(koc, scene):
    site, line, turns = scene
    names = [name for k, name in site.molecule.rows if k == 3]
    own = monomer_of(koc.nucleotides, 8, koc.positions(0)).atoms_A
    shift = np.array([5.0, 0.0, 0.0])
    backbone = {x: own[x] + shift for x in names if "'" in x or "P" in x}
    near = site.given({site.labels[3]: backbone})
    start = start_on(site, line, turns, near)
    for name in names:
        at = start[site.molecule.rows[3, name]]
        if name in backbone:
            np.testing.assert_allclose(at, near[site.molecule.rows[3, name]], atol=2e-6)
    # its base hangs on the sugar that was given, not on the line
    n9, c1 = (site.molecule.rows[3, name] for name in ("N9", "C1'"))
    assert np.linalg.norm(start[n9] - start[c1]) < 2.2
    # the others are where they are without
    plain = start_on(site, line, turns)
    assert np.linalg.norm(plain[n9] - start[c1]) > 4.0
    row = site.molecule.rows[0, "C4'"]
    np.testing.assert_array_equal(start[row], plain[row])
