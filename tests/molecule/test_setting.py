import MDAnalysis as mda
import numpy as np
import pytest

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.molecule.nucleotides import read_structure
from loopelastica.molecule.setting import MAX_PAIRS, NEAR_A, Settings


@pytest.fixture(scope="module")
def structure():
    return read_structure(data_path("hairpins/2koc.pdb"))


@pytest.fixture(scope="module")
def setting(structure):
    (hairpin,) = le.find_hairpins(structure)
    return Settings(structure).of(hairpin)


def test_strands_run_along_the_chain_and_pair_outwards_from_the_closing_pair(setting):
    assert setting.names_5 == ("G1", "G2", "C3", "A4", "C5")
    assert setting.names_3 == ("G10", "U11", "G12", "C13", "C14")
    assert setting.names == ("U6", "U7", "C8", "G9")
    assert setting.strand_5_A.shape == setting.strand_3_A.shape == (5, 3)


def test_bonds_have_the_lengths_of_bonds_and_reach_every_heavy_atom(structure, setting):
    bonds = np.concatenate([setting.stem_bonds_A, setting.loop_bonds_A])
    lengths = np.linalg.norm(bonds[:, 0] - bonds[:, 1], axis=1)
    assert lengths.min() > 1.15
    assert lengths.max() < 1.75
    # the table of nucleotides has no third oxygen of a terminal phosphate
    heavy = structure.universe.select_atoms("not name H* and not name OP3")
    drawn = {tuple(np.round(point, 3)) for point in bonds.reshape(-1, 3)}
    assert drawn == {tuple(np.round(p, 3)) for p in structure.positions(0)[heavy.indices]}


def test_the_loops_bonds_include_both_its_junctions(structure, setting):
    atoms = structure.universe.atoms
    ends = {tuple(np.round(point, 3)) for point in setting.loop_bonds_A.reshape(-1, 3)}
    for selection in ("resid 5 and name O3'", "resid 10 and name P"):
        (index,) = atoms.select_atoms(selection).indices
        assert tuple(np.round(structure.positions(0)[index], 3)) in ends


def test_a_setting_moves_with_the_structure(structure, setting, rng):
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    rotation *= np.linalg.det(rotation)
    moved = structure.positions(0) @ rotation.T + 7.0
    (hairpin,) = le.find_hairpins(structure)
    there = Settings(structure, moved).of(hairpin)
    np.testing.assert_allclose(there.strand_5_A, setting.strand_5_A @ rotation.T + 7.0, atol=1e-4)
    assert len(there.stem_bonds_A) == len(setting.stem_bonds_A)


def test_neighbours_are_near_in_order_and_not_the_hairpin_itself(tmp_path):
    one = mda.Universe(str(data_path("hairpins/2koc.pdb")))
    other = one.copy()
    other.atoms.translate([0.0, 0.0, 15.0])
    both = mda.Merge(one.atoms, other.atoms)
    both.add_TopologyAttr("chainIDs", ["A"] * len(one.atoms) + ["B"] * len(one.atoms))
    structure = read_structure(both)
    hairpin = le.find_hairpins(structure)[0]
    setting = Settings(structure).of(hairpin)
    assert setting.neighbours
    own = np.concatenate([setting.strand_5_A, setting.strand_3_A])
    loop = setting.loop_bonds_A.reshape(-1, 3)
    for chain in setting.neighbours:
        assert len(chain.labels) == len(chain.points_A)
        assert all(label.startswith("B.") for label in chain.labels)
        gaps = np.linalg.norm(chain.points_A[:, None] - np.concatenate([own, loop])[None], axis=2)
        assert gaps.min(axis=1).max() < NEAR_A + 5.0


def test_no_more_pairs_are_shown_than_a_picture_can_hold():
    built = le.build("GGCACGGCAC(UUCG)GUGCCGUGCC")
    assert len(built.hairpin.fold.hairpin.stem_5) > MAX_PAIRS
    setting = Settings(built.hairpin.structure, built.hairpin.positions_A).of(
        built.hairpin.fold.hairpin
    )
    assert len(setting.names_5) == len(setting.names_3) == MAX_PAIRS
