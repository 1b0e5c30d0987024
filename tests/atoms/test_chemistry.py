import numpy as np
import pytest
from rdkit import Chem

from loopelastica.atoms.chemistry import METHYLATED, Residue, loop_molecule
from loopelastica.atoms.fibre import fibre_nucleotide
from loopelastica.atoms.geometry import (
    CHIRALITY,
    chiral_quads,
    ideal_geometry,
    outer_distances,
    planar_quads,
    ring_quads,
)
from loopelastica.atoms.ideal import ideal_value


def test_phosphates_are_charged_and_the_junctions_are_bonds():
    molecule = loop_molecule([Residue("U", False, "U"), Residue("C", False, "C")])
    assert Chem.GetFormalCharge(molecule.mol) == -3
    junctions = [(-1, "O3'", 0, "P"), (0, "O3'", 1, "P"), (1, "O3'", 2, "P")]
    bonds = {frozenset(bond) for bond in molecule.bonds}
    for residue, name, other, other_name in junctions:
        pair = {molecule.index(residue, name), molecule.index(other, other_name)}
        assert frozenset(pair) in bonds
    with pytest.raises(ValueError, match="no atom N9"):
        molecule.index(0, "N9")


def test_the_sequence_of_the_molecule_is_that_of_rdkit():
    own = loop_molecule([Residue(letter, True, f"D{letter}") for letter in "GATC"]).mol
    reader = Chem.MolFromSequence("GATC", flavor=6)
    assert len(own.GetSubstructMatches(Chem.MolFromSmiles("O=P"))) == 5
    # the same nucleosides, joined by neutral phosphates there and charged ones here
    neutral = Chem.RWMol(own)
    for atom in neutral.GetAtoms():
        atom.SetFormalCharge(0)
    Chem.SanitizeMol(neutral)
    assert neutral.HasSubstructMatch(reader, useChirality=True)


@pytest.mark.parametrize("name", sorted(METHYLATED))
def test_methylated_nucleotides_have_names_of_their_own_and_ideal_values(name):
    parent = {"5MU": "U", "5MC": "C", "OMC": "C", "OMU": "U", "6MZ": "A", "A2M": "A"}
    residue = Residue(parent.get(name, "G"), False, name)
    molecule = loop_molecule([residue])
    assert set(dict(METHYLATED[name])) < set(molecule.names)
    assert residue.standard == name
    assert not residue.renamed
    geometry = ideal_geometry(molecule)
    assert ((geometry.length_A > 1.2) & (geometry.length_A < 1.65)).all()
    assert ((geometry.angle_deg > 99) & (geometry.angle_deg < 133)).all()


@pytest.mark.parametrize(
    ("letter", "is_dna", "resname", "standard", "renamed"),
    [
        ("U", False, "PSU", "U", True),
        ("A", True, "DA3", "DA", False),
        ("G", False, "rG", "G", False),
        ("C", False, "CYT", "C", False),
        ("T", True, "THY", "DT", False),
        ("G", False, "I", "G", True),
    ],
)
def test_names_of_the_parents_are_kept_and_others_change(
    letter, is_dna, resname, standard, renamed
):
    residue = Residue(letter, is_dna, resname)
    assert (residue.standard, residue.renamed) == (standard, renamed)


def test_an_empty_loop_and_an_unknown_base_are_refused():
    with pytest.raises(ValueError, match="`residues` is empty"):
        loop_molecule([])
    with pytest.raises(ValueError, match="'N' cannot be built"):
        loop_molecule([Residue("N", False, "N")])


@pytest.mark.parametrize("letter", "ACGUT")
@pytest.mark.parametrize("is_dna", [False, True])
def test_every_bond_and_angle_of_the_usual_nucleotides_is_tabulated(letter, is_dna):
    molecule = loop_molecule([Residue(letter, is_dna, letter)])
    loop = set(molecule.loop_atoms)
    geometry = ideal_geometry(molecule)
    for rows in [*geometry.bonds.tolist(), *geometry.angles.tolist()]:
        if set(rows) <= loop:
            names = [molecule.names[row] for row in rows]
            assert ideal_value(letter, is_dna, *names) is not None, names


def test_the_fibre_has_the_hands_that_are_asked_for_and_those_of_rdkit():
    for letter, is_dna in [("A", False), ("C", False), ("G", True), ("T", True)]:
        molecule = loop_molecule([Residue(letter, is_dna, letter)])
        fibre = fibre_nucleotide(letter, is_dna)
        positions = np.array([fibre.get(name, np.zeros(3)) for name in molecule.names])
        for row, residue in enumerate(molecule.residue):
            if residue != 0:
                positions[row] = 50.0 + 3.0 * row
        quads, volumes = chiral_quads(molecule)
        inside = [q for q in range(len(quads)) if all(molecule.residue[i] == 0 for i in quads[q])]
        assert len(inside) == (3 if is_dna else 4)
        for q in inside:
            a, b, c, d = positions[quads[q]]
            assert np.dot(b - a, np.cross(c - a, d - a)) == pytest.approx(volumes[q], rel=0.15)
        three = Chem.Mol(molecule.mol)
        conformer = Chem.Conformer(len(positions))
        for row, at in enumerate(positions.tolist()):
            conformer.SetAtomPosition(row, at)
        three.AddConformer(conformer)
        Chem.AssignStereochemistryFrom3D(three)
        flat = Chem.Mol(molecule.mol)
        for mol in (three, flat):
            Chem.AssignStereochemistry(mol, cleanIt=True, force=True)
        for name in ("C1'", "C3'", "C4'"):
            row = molecule.index(0, name)
            hands = [mol.GetAtomWithIdx(row).GetProp("_CIPCode") for mol in (three, flat)]
            assert hands[0] == hands[1]
    assert {centre for centre, _, _ in CHIRALITY} == {"C1'", "C2'", "C3'", "C4'", "P"}


def test_bases_are_planar_and_sugars_are_not():
    molecule = loop_molecule([Residue("G", False, "G")])
    flat = {molecule.names[row] for row in planar_quads(molecule).ravel()}
    assert {"N9", "C8", "N7", "C5", "C6", "O6", "N1", "C2", "N2", "N3", "C4"} <= flat
    assert not flat & {"C2'", "C3'", "C4'", "O4'"}


def test_the_outer_distance_of_an_angle_is_the_cosine_rule():
    molecule = loop_molecule([Residue("U", False, "U")])
    geometry = ideal_geometry(molecule)
    pairs, length, deviation = outer_distances(geometry)
    names = [{molecule.names[i] for i in pair} for pair in pairs]
    row = names.index({"C5'", "P"})
    expected = np.sqrt(1.593**2 + 1.44**2 - 2 * 1.593 * 1.44 * np.cos(np.deg2rad(120.9)))
    assert length[row] == pytest.approx(expected)
    assert (deviation > 0).all()


def test_ring_volumes_change_sign_between_the_puckers():
    molecule = loop_molecule([Residue("U", False, "U")])
    rings = ideal_geometry(molecule).rings
    north = ring_quads(rings, np.array([18.0]))[1]
    south = ring_quads(rings, np.array([162.0]))[1]
    assert north[0] > 1.5
    assert south[0] < -1.5
