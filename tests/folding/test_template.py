"""Templates deformed onto the ends at hand, in order."""

from dataclasses import replace

import numpy as np
import pytest

from loopelastica.folding.template import deformed
from loopelastica.molecule.ends import fit_stem
from loopelastica.molecule.hairpins import find_hairpins
from loopelastica.molecule.templates import hairpin_template, monomer_of


@pytest.fixture(scope="module")
def scene(koc):
    (hairpin,) = find_hairpins(koc)
    templates = [
        hairpin_template(koc.nucleotides, hairpin, koc.positions(model), f"model{model}")
        for model in range(4)
    ]
    return templates, fit_stem(koc.nucleotides, hairpin, koc.positions(0)).closing()


def renamed(template, sequence):
    return replace(template, shape=replace(template.shape, sequence=sequence))


def test_a_loop_on_its_own_stem_is_not_deformed(scene, koc):
    (own,) = deformed(scene[0][:1], scene[1], "CUUCGG", False)
    assert own.line.energy == pytest.approx(0.0, abs=1e-9)
    assert own.shape == "like model0 A.5-A.10"
    at = monomer_of(koc.nucleotides, 8, koc.positions(0)).atoms_A
    for name, place in own.carried[3].atoms_A.items():
        np.testing.assert_allclose(place, at[name], atol=1e-4)


def test_of_one_sequence_the_least_deformed_comes_first(scene):
    found = deformed(scene[0][::-1], scene[1], "CUUCGG", False)
    energies = [one.line.energy for one in found]
    assert energies == sorted(energies)
    assert found[0].shape == "like model0 A.5-A.10"


def test_the_more_similar_sequence_comes_before_the_less_deformed(scene):
    templates = [renamed(scene[0][0], "CAAAAG"), renamed(scene[0][1], "CUUUGG"), scene[0][2]]
    found = deformed(templates, scene[1], "CTTCGG", False)
    assert [one.template.shape.sequence for one in found] == ["CUUCGG", "CUUUGG", "CAAAAG"]


def test_a_motif_errs_as_the_same_letters_do(scene):
    templates = [renamed(scene[0][0], x) for x in ("CGAAAG", "AGCAAU", "CGAAUG")]
    found = deformed(templates, scene[1], "CGAAAG", False)
    alike = {one.template.shape.sequence: one.alike for one in found}
    assert alike == {"CGAAAG": True, "AGCAAU": True, "CGAAUG": False}
    errors = {one.alike: one.errors.at(2.0, 1.0, 4) for one in found}
    assert errors[True][1] < errors[False][1]


def test_a_respaced_template_is_deformed_and_has_no_atoms(scene):
    (found,) = deformed([scene[0][0].respaced(5)], scene[1], "CUUACGG", False)
    assert len(found.line) == 5
    assert (found.carried, found.alike) == ((), False)


def test_nothing_to_deform(scene):
    assert deformed([], scene[1], "CUUCGG", False) == []
