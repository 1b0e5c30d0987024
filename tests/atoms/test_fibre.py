import numpy as np
import pytest

from loopelastica.atoms.chemistry import Residue, loop_molecule
from loopelastica.atoms.fibre import fibre_nucleotide, in_line_frame
from loopelastica.molecule.nucleotides import BACKBONE
from loopelastica.molecule.strands import ideal_strand, line_frame, strand_atoms

EVERY = [(letter, is_dna) for letter in "ACGUT" for is_dna in (False, True)]


@pytest.mark.parametrize(("letter", "is_dna"), EVERY)
def test_a_nucleotide_has_the_atoms_and_bonds_of_its_molecule_and_no_others(letter, is_dna):
    atoms = fibre_nucleotide(letter, is_dna)
    molecule = loop_molecule([Residue(letter, is_dna, letter)])
    own = molecule.loop_atoms
    assert {molecule.names[row] for row in own} == set(atoms)
    expected = {
        frozenset((molecule.names[i], molecule.names[j]))
        for i, j in molecule.bonds
        if i in own and j in own
    }
    names, at = list(atoms), np.array(list(atoms.values()))
    near = np.argwhere(np.triu(np.linalg.norm(at[:, None] - at[None], axis=2) < 1.9, k=1))
    assert {frozenset((names[i], names[j])) for i, j in near} == expected


@pytest.mark.parametrize("is_dna", [False, True])
def test_the_backbone_is_that_of_the_ideal_strand(is_dna):
    atoms = fibre_nucleotide("A", is_dna)
    expected = strand_atoms(ideal_strand(is_dna), 0)
    np.testing.assert_allclose([atoms[name] for name in BACKBONE], expected, atol=1e-12)


@pytest.mark.parametrize("is_dna", [False, True])
def test_watson_crick_partners_meet_at_hydrogen_bond_distance(is_dna):
    # the second strand is the first one turned about the dyad (φ, z) → (−φ, −z)
    one = fibre_nucleotide("G", is_dna)
    other = {name: at * [1, -1, -1] for name, at in fibre_nucleotide("C", is_dna).items()}
    for donor, acceptor in (("N1", "N3"), ("N2", "O2"), ("O6", "N4")):
        # O6–N4 of the B-DNA table is 2.67 Å
        assert 2.6 < np.linalg.norm(one[donor] - other[acceptor]) < 3.1


def test_the_line_frame_and_back(rng):
    strand = ideal_strand(True)
    position = rng.normal(size=(4, 3))
    point, frame = line_frame(strand, 0.0)
    np.testing.assert_allclose(point + in_line_frame(strand, position) @ frame.T, position)


def test_an_unknown_base_is_refused():
    with pytest.raises(ValueError, match="`letter` is 'N'"):
        fibre_nucleotide("N", False)
