from dataclasses import replace

import numpy as np
import pytest
import strands

from loopelastica.nanostructures.oxdna.checks import check_start, closest_centres


@pytest.mark.parametrize(
    "system", [strands.helix("GCATTGCAGC"), strands.hairpin("GCGTAC", "TTTTTT")]
)
def test_a_start_without_faults_is_sound(system):
    found = check_start(system)
    assert found.sound
    assert found.sentences() == []


def test_a_bond_out_of_the_window_is_named():
    system = strands.helix("GCATTGCAGC")
    centre = system.centre.copy()
    # a gap between the strand's first three nucleotides and the others
    centre[:3] -= [0, 0, 1.0]
    found = check_start(replace(system, centre=centre))
    assert found.broken.tolist() == [[2, 3]]
    assert not found.sound
    (sentence,) = found.sentences()
    assert sentence.startswith("nucleotide 2 and nucleotide 3: their bond is")
    assert "0.5064 to 1.0064" in sentence


def test_centres_that_are_too_near_are_named():
    system = strands.helix("GCATTGCAGC")
    centre = system.centre.copy()
    centre[14] = centre[2] + [0.3, 0, 0]
    found = check_start(replace(system, centre=centre))
    assert [2, 14] in np.sort(found.close, axis=1).tolist()
    assert found.distance.max() < 0.4
    assert any("0.300 apart" in sentence for sentence in found.sentences())


def test_centres_of_neighbours_may_be_near():
    system = strands.helix("AC")
    centre = system.centre.copy()
    centre[1] = centre[0] + [0, 0, 0.1]
    assert len(check_start(replace(system, centre=centre)).close) == 0


def test_centres_are_compared_across_the_box():
    system = strands.helix("GCATTGCAGC", box=(30.0, 30.0, 30.0))
    centre = system.centre.copy()
    centre[14] = centre[2] + [0.3, 30.0, -60.0]
    found = check_start(replace(system, centre=centre))
    assert [2, 14] in np.sort(found.close, axis=1).tolist()


@pytest.mark.parametrize("wrong", [[0.9, 0, 0], [0, 0, 1.0], [np.nan, 0, 0]])
def test_axes_that_are_no_frame_are_named(wrong):
    system = strands.helix("ACGT")
    a1 = system.a1.copy()
    a1[7] = wrong
    found = check_start(replace(system, a1=a1))
    assert found.skewed.tolist() == [7]
    assert "nucleotide 7: its axes" in found.sentences()[-1]


def test_nucleotides_without_a_place_are_left_out():
    system = strands.helix("ACGT")
    centre = np.full((8, 3), np.nan)
    lost = replace(system, placed=np.zeros(8, dtype=bool), centre=centre, a1=centre, a3=centre)
    assert check_start(lost).sound


def test_faults_of_one_kind_are_one_note_with_their_number():
    system = strands.helix("GCATTGCAGC")
    assert list(check_start(system).notes()) == []
    assert repr(check_start(system)) == "<StartCheck: sound>"
    centre, a1 = system.centre.copy(), system.a1.copy()
    centre[:, 2] *= 3
    a1[7:9] *= 0.9
    bonds, axes = check_start(replace(system, centre=centre, a1=a1)).notes()
    assert bonds.startswith("18 bonds are outside of oxDNA's window, first from nucleotide 0 to")
    assert axes.startswith("axes of 2 nucleotides")
    assert axes.endswith("first of nucleotide 7")


def test_the_closest_centres_are_those_of_no_neighbours():
    system = strands.helix("GCATTGCAGC")
    i, j = np.triu_indices(20, 1)
    apart = np.linalg.norm(system.centre[i] - system.centre[j], axis=1)
    expected = apart[system.n3[i] != j].min()
    assert closest_centres(system) == pytest.approx(expected)
    assert closest_centres(system, most=0.5) is None
