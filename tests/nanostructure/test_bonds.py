"""Bonds between backbone sites; numbers by hand."""

import dataclasses

import helix_designs as designs
import numpy as np
import pytest

from loopelastica.nanostructure.bonds import backbone_sites, bond_lengths
from loopelastica.nanostructure.scadnano import read_design


@pytest.fixture
def helix(tmp_path):
    return read_design(designs.write(designs.duplex(5), tmp_path)).system


def moved(system, nucleotide, by):
    centre = system.centre.copy()
    centre[nucleotide] += by
    return dataclasses.replace(system, centre=centre)


def test_the_backbone_site_is_behind_the_centre_and_to_its_side():
    x, y, z = np.eye(3)[:, None]
    # a1 along x and a3 along z: a2 = a3 × a1 is along y
    np.testing.assert_allclose(backbone_sites(z, x, z), -0.34 * x + 0.3408 * y + z)


def test_strands_have_a_bond_less_than_nucleotides(helix):
    bonds = bond_lengths(helix)
    assert bonds.first.tolist() == [0, 1, 2, 3, 5, 6, 7, 8]
    assert bonds.second.tolist() == [1, 2, 3, 4, 6, 7, 8, 9]


def test_a_shift_of_one_end_is_a_shift_of_its_site(helix):
    bonds = bond_lengths(helix)
    sites = backbone_sites(helix.centre, helix.a1, helix.a3)
    step = sites[4] - sites[3]
    longer = bond_lengths(moved(helix, 4, 0.5 * step))
    assert longer.length[3] == pytest.approx(1.5 * bonds.length[3])
    assert longer.outside.tolist() == [False, False, False, True, False, False, False, False]


def test_the_worst_bond_is_named(helix):
    assert bond_lengths(helix).sentence(helix) == ""
    broken = moved(moved(helix, 0, [0, 0, -9.0]), 9, [0, 0, 2.0])
    sentence = bond_lengths(broken).sentence(broken)
    assert sentence.startswith("2 of 8 bonds are outside oxDNA's window of 0.5064 to 1.0064")
    assert "from helix 0, offset 0 to helix 0, offset 1 of ST0[0]0[4]" in sentence


def test_bonds_of_what_has_no_place_are_left_out(helix):
    placed = helix.placed.copy()
    placed[2] = False
    assert bond_lengths(dataclasses.replace(helix, placed=placed)).first.tolist() == [
        0, 3, 5, 6, 7, 8,
    ]  # fmt: skip


def test_a_bond_of_unknown_length_is_outside(helix):
    assert bond_lengths(moved(helix, 0, np.nan)).outside[0]
